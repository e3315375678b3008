"""Tables that the contact kernel computes with, made once: profiles, rails, bounds of the traction, Kalker's creep
coefficients, a strip's influence."""

from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files

import numpy as np

from wrsim.contact.creep.flexibility import ASPECTS, SLENDEREST
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import Array, ContactSettings
from wrsim.contact.surfaces.distance_field import DistanceField, distance_field
from wrsim.contact.surfaces.rolled_rail import RolledRail, station_fields

TABLE_STEP = 0.1e-3  # of the profile tables [m]


@dataclass(frozen=True)
class RailTables:
    """What the kernel takes of a rail, see `contact.arrays.Arrays`: rows of one section and their distance; its
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
    table, step = profile_table(rail)
    field_ = distance_field(rail)
    hollow = max(float(table[:, 4].max()), 0.0)
    rows, field_rows = len(table), len(field_.values)
    return RailTables(table, np.zeros((0, 0)), np.zeros((2, 1)), step, rows, field_, field_rows, 0.0, hollow)


@lru_cache(maxsize=8)
def changing_rail(rail: RolledRail) -> RailTables:
    flat = (-1, rail.tables.shape[2])
    field_, rows, numbers, slack = station_fields(rail)
    tables, rates, stations = (
        rail.tables.reshape(flat),
        rail.rates.reshape(flat),
        np.vstack((rail.stations, numbers, rail.surface.heading(rail.stations))),
    )
    return RailTables(tables, rates, stations, rail.step, rail.tables.shape[1], field_, rows, slack, rail.hollow)


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


@cache
def _kalker_table() -> tuple[Array, Array]:
    """Aspects a/b from 0.1 to 10 (19,), and (19, 3, 3): of each at Poisson's ratio 0, 0.25, 0.5 C11 C22 C23."""
    text = files("wrsim.contact").joinpath("data/kalker_1990_table_e3.csv").read_text(encoding="utf-8")
    rows = np.array([[float(x) for x in line.split(",")] for line in text.splitlines() if line and line[0].isdigit()])
    return rows[::3, 0], rows[:, 2:].reshape(-1, 3, 3)


def creep_asymptotes(aspect: Array, poisson_ratio: float) -> tuple[Array, Array]:
    """C11, C22, C23 of slender patches (n, 3) (creep-slender), and the order of their first missing term (n,).

    J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer 1990, table E3, last rows. The strip
    theory of a patch much wider than long misses g^2 ln(1/g), the line theory of a long one the third power of
    1/ln(1/g); g: the smaller of a/b and b/a.
    """
    nu, wide = poisson_ratio, aspect < 1.0
    g = np.where(wide, aspect, 1.0 / aspect)
    log = np.log(16.0 / g**2)
    spin = np.pi * np.sqrt(g) / (3.0 * (1.0 - nu)) * (1.0 + nu * (0.5 * log + np.log(4.0) - 5.0))
    strip = np.pi**2 / 4.0 / (1.0 - nu) + 0.0 * g, np.pi**2 / 4.0 + 0.0 * g, spin
    along, across = log - 2.0 * nu, (1.0 - nu) * log + 2.0 * nu
    line = (
        2.0 * np.pi / (g * along) * (1.0 + (3.0 - np.log(4.0)) / along),
        2.0 * np.pi / (g * across) * (1.0 + (1.0 - nu) * (3.0 - np.log(4.0)) / across),
        2.0 * np.pi / (3.0 * g**1.5 * ((1.0 - nu) * log - 2.0 + 4.0 * nu)),
    )
    values = np.where(wide, strip, line).T
    return np.ascontiguousarray(values), np.where(wide, g**2 * log, log**-2)


@lru_cache(maxsize=8)
def creep_coefficients(poisson_ratio: float) -> Array:
    """C11, C22, C23 for the kernels: rows at a/b from `SLENDEREST` on in equal steps of its logarithm.

    Rows of Kalker's table are met; between them log C is a monotone cubic over log a/b, 1/C quadratic in Poisson's
    ratio through the three columns (Kalker's own rule). Beyond them Kalker's asymptotes go on from the last row; the
    ratio to them tends to 1 as the first missing term vanishes.
    """
    aspects, columns = _kalker_table()
    x = poisson_ratio
    weights = ((x - 0.25) * (x - 0.5) / 0.125, -x * (x - 0.5) / 0.0625, x * (x - 0.25) / 0.125)
    rows = 1.0 / np.einsum("i,kij->kj", weights, 1.0 / columns)
    places = np.geomspace(SLENDEREST, 1.0 / SLENDEREST, ASPECTS)
    values, order = creep_asymptotes(places, x)
    for end, beyond in ((0, places < aspects[0]), (-1, places > aspects[-1])):
        last, term = creep_asymptotes(aspects[[end]], x)
        values[beyond] *= 1.0 + (rows[end] / last - 1.0) * (order[beyond] / term)[:, None]
    within = (places >= aspects[0]) & (places <= aspects[-1])
    values[within] = np.exp(monotone_cubic(np.log(aspects), np.log(rows), np.log(places[within])))
    return values


def monotone_cubic(x: Array, y: Array, places: Array) -> Array:
    """The cubics of Fritsch and Butland through y (n, k) at rising x, at places within: scipy's pchip, whose import
    takes longer than all tables here."""
    h = np.diff(x)[:, None]
    m = np.diff(y, axis=0) / h
    first, second = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    slopes = np.empty_like(y)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = 1.0 / ((first / m[:-1] + second / m[1:]) / (first + second))
    slopes[1:-1] = np.where(m[1:] * m[:-1] > 0.0, mean, 0.0)
    for i, j in ((0, 1), (-1, -2)):
        end = ((2.0 * h[i] + h[j]) * m[i] - h[i] * m[j]) / (h[i] + h[j])
        turns = (m[i] * m[j] < 0.0) & (np.abs(end) > 3.0 * np.abs(m[i]))
        slopes[i] = np.where(end * m[i] > 0.0, np.where(turns, 3.0 * m[i], end), 0.0)
    bend = (slopes[:-1] + slopes[1:] - 2.0 * m) / h
    k = np.clip(np.searchsorted(x, places, "right") - 1, 0, x.size - 2)
    r = (places - x[k])[:, None]
    return np.asarray(y[k] + slopes[k] * r + ((m - slopes[:-1]) / h - bend)[k] * (r * r) + (bend / h)[k] * (r * r * r))


@cache
def influence_table() -> Array:
    """Coefficients of the cubic spline of PHI/t, see `contact.strips.influence`: (places of xi + 3, of t + 2), in
    the last row for xi = 0.

    PHI is the integral of sqrt(1 - x^2) asinh(t/|x - xi|) over x. ``tests/support/influence.py`` has written the table.
    """
    with files("wrsim.contact").joinpath("data/influence.npy").open("rb") as stream:
        return np.asarray(np.load(stream))
