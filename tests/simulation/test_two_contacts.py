"""A wheel that slides on tread and flange at once on rigid rails excites itself (docs/theory/multibody.md)."""

from functools import cache

import numpy as np
import pytest
from support.runs import ROOT, setup_of

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise

HOLLOW = (
    ROOT / "tests/data/wheel_hollow.whl"
)  # our own: S1002 with 3 mm of hollow tread and a worn flange, MiniProf format
BAND = 2.0 * np.pi * 60.0, 2.0 * np.pi * 250.0  # of the wheelset on its contact springs [rad/s]


@cache
def coach(friction: float, rails: str = "rigid") -> tuple[VehicleOnTrack, np.ndarray]:
    """A coach on hollow wheels in the steady curve of 250 m, and the eigenvalues of its small motions."""
    keys = {
        "vehicle.wheel": HOLLOW.as_posix(), "contact.friction": friction, "contact.strips": 12, "contact.cells": 8,
        "track.structure.kind": rails,
    }  # fmt: skip
    segments = [{"kind": "arc", "radius_m": 250, "length_m": 100, "cant_mm": 100}]
    setup = setup_of(segments, 20.0 / 3.6, "vehicles/manchester_1.toml", 50.0, keys)
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    values = np.linalg.eigvals(linearise(law, law.bodies, q, q_t).state_matrix)
    law.at(0.0, q, q_t)
    return law, values


def plane_model(law: VehicleOnTrack, wheelset: int = 0) -> np.ndarray:
    """Eigenvalues of {eq}`mb-coupling`: a wheelset that moves up, sideways and in roll on its contacts."""
    wheelset_data = law.vehicle.wheelsets[wheelset].wheelset
    K, C = np.zeros((3, 3)), np.zeros((3, 3))
    for wheel, side in zip(law.wheels[wheelset], (1, -1), strict=True):
        arrays = wheel.model.arrays
        for p in arrays.patches[: int(arrays.rows.total["lobes"].item())]:
            u, w = wheel.model.wheel.at(float(p.arc_wheel))
            y, z, ny, nz = side * (0.5 * wheelset_data.profile_spacing + u), w - wheel.model.radius, side * p.no, p.nb
            n, t = np.array([ny, nz, y * nz - z * ny]), np.array([nz, -ny, -y * ny - z * nz])
            mu, across = np.hypot(p.Fx, p.Fy) / p.N, side * p.Fy / p.N
            along_load = np.outer(n + across * t, n)
            K += 1.5 * p.N / p.approach * along_load
            C += 2.0 * p.N * along_load
            C += mu * p.N / (np.hypot(p.xi, p.eta) * law.speed) * (1.0 - (across / mu) ** 2) * np.outer(t, t)
    mass = np.diag([wheelset_data.mass, wheelset_data.mass, wheelset_data.inertia[0]])
    below = np.hstack([-np.linalg.solve(mass, K), -np.linalg.solve(mass, C)])
    return np.linalg.eigvals(np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), below]))


def growing(values: np.ndarray) -> complex:
    """The eigenvalue in the band that is farthest to the right."""
    inside = values[(values.imag > BAND[0]) & (values.imag < BAND[1])]
    return complex(inside[np.argmax(inside.real)])


@pytest.mark.parametrize("friction", [0.34, 0.37])
def test_wheelset_on_three_contacts_tells_frequency_and_limit_of_the_whole_coach(friction):
    law, values = coach(friction)
    whole, plane = growing(values), growing(plane_model(law))
    assert (whole.real > 0.0) == (plane.real > 0.0) == (friction > 0.36)
    assert plane.imag == pytest.approx(whole.imag, rel=0.02)


def test_elastic_rails_end_the_oscillation():
    assert growing(coach(0.6)[1]).real > 50.0
    values = coach(0.6, "moving mass")[1]
    assert values[np.abs(values.imag) > 20.0 * np.pi].real.max() < -5.0  # from 10 Hz on
