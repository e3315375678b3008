"""Tables that the contact kernel computes with, of profiles, rails and bounds of the traction; kept once made."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.settings import ContactSettings
from wrsim.geometry.profile.distance_field import DistanceField, distance_field
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.rolled_rail import RolledRail, station_fields

Array = NDArray[np.float64]

TABLE_STEP = 0.1e-3  # of the profile tables [m]


@dataclass(frozen=True)
class RailTables:
    """What the kernel takes of a rail, see `core.contact.arrays.Arrays`: rows of one section and their distance; its
    field (of several stations one behind the other) with so many rows each, how far it may be off; largest concave
    curvature [1/m]."""

    table: Array
    rates: Array
    stations: Array
    step: float
    rows: int
    field: DistanceField
    field_rows: int
    slack: float
    hollow: float


@lru_cache(maxsize=16)
def plain_rail(rail: Profile) -> RailTables:
    """The tables of a rail of one profile."""
    table, step = profile_table(rail)
    field_ = distance_field(rail)
    hollow = max(float(table[:, 4].max()), 0.0)
    rows, field_rows = len(table), len(field_.values)
    return RailTables(table, np.zeros((0, 0)), np.zeros((2, 1)), step, rows, field_, field_rows, 0.0, hollow)


@lru_cache(maxsize=8)
def changing_rail(rail: RolledRail) -> RailTables:
    """The tables of a rail that changes along the track."""
    flat = (-1, rail.tables.shape[2])
    own = station_fields(rail)
    stations = np.stack((rail.stations, own.numbers))
    return RailTables(
        rail.tables.reshape(flat), rail.rates.reshape(flat), stations, rail.step, rail.tables.shape[1], own.field,
        own.rows, own.slack, rail.hollow,
    )  # fmt: skip


@lru_cache(maxsize=32)
def profile_table(profile: Profile) -> tuple[Array, float]:
    """The table of a profile and its step [m]."""
    table, step = profile.table(TABLE_STEP)
    return np.ascontiguousarray(table), step


def combined_modulus(settings: ContactSettings) -> float:
    """E* = 1 / ((1 - nu_w^2)/E_w + (1 - nu_r^2)/E_r) [Pa]."""
    compliance = sum((1.0 - m.poisson_ratio**2) / m.youngs_modulus for m in (settings.wheel, settings.rail))
    return 1.0 / compliance


def bound_over_cells(cells: int, parabolic: bool) -> Array:
    """Mean of sqrt(1 - X^2) (or 1 - X^2) over each of the cells of -1 < X < 1, from the leading edge on."""
    x = np.linspace(1.0, -1.0, cells + 1)
    if parabolic:
        primitive = x - x**3 / 3.0
    else:
        primitive = 0.5 * (x * np.sqrt(np.maximum(1.0 - x**2, 0.0)) + np.arcsin(x))
    return np.ascontiguousarray((primitive[:-1] - primitive[1:]) / (x[:-1] - x[1:]))
