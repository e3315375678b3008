"""The derivative that an implicit step uses, of every contact law, beside central differences of cold contacts.

Laws are taken from ``Normal`` and ``Tangential``. An implicit step solves with the derivative of the fast model where
the contact is exact, so half-space contacts have none of their own.
"""

from itertools import product
from typing import get_args

import numpy as np
import pytest
from support.runs import setup_of, straight

from wrsim.analysis.contacts import force_law
from wrsim.contact.settings import Normal, Tangential
from wrsim.contact.workspace import WARM_TOLERANCE
from wrsim.simulation.force_law import COORDINATES, SMALL, SMALL_RATE, force_derivative
from wrsim.simulation.integrate import OF_CONTACTS
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails

FAST = [name for name in get_args(Normal) if name != "half-space"]
CREEP = [name for name in get_args(Tangential) if name != "half-space"]
POSES = {"tread": (1e-3, 2e-3, 40e-6), "root": (5.5e-3, 4e-3, 40e-6), "flange": (6.8e-3, 8e-3, 50e-6)}
"""Lateral shift [m], yaw [rad] and approach [m] of a wheelset."""

IMPLICIT = 1e3  # rate over displacement in an implicit step of 2 ms [1/s]
DIRECTIONS = [(1.0, 0.0), (0.0, 1.0), (1.0, IMPLICIT)]
SCALE = np.array([1.0, 1.0, 1.0, 0.46, 0.75, 0.46])  # a moment over its arm is a force [m]
SPANS = np.array([0.5, 1.0, 2.0])  # of second differences, over the step: creep forces have kinks
ALLOWED = 0.02  # part of the matrix: an iteration of Newton's method then leaves about so much of the residual


def pressed(law: VehicleOnTrack, lateral: float, yaw: float, approach: float) -> tuple[np.ndarray, np.ndarray]:
    """A wheelset that rolls with some creep in all directions, deeper in its rails than where they touch."""
    law.look_near(law.start)
    q, q_t = design_state(law, lateral=np.full(1, lateral))
    q[3] += yaw
    q, q_t = lower_on_rails(law, q, q_t)
    q[0] -= approach
    q_t[2] += 0.01
    q_t[5] *= 1.001
    return q, q_t


# every law, and every pose with the laws of a run
CASES = [(normal, creep, "root") for normal in FAST for creep in CREEP]
CASES += [("strips", "fastsim", "tread"), ("strips", "fastsim", "flange"), ("kik-piotrowski", "fastsim", "flange")]
LONG = [case for case in product(FAST, CREEP, POSES) if case not in CASES]


@pytest.mark.parametrize(
    ("normal", "creep", "pose"), [*CASES, *(pytest.param(*case, marks=pytest.mark.campaign) for case in LONG)]
)
def test_the_derivative_is_that_of_the_forces(normal: str, creep: str, pose: str) -> None:
    """Off by no more than theory allows, twice h/2 f'' of a forward difference and 2 e/h of forces known to e; and that
    is little."""
    setup = setup_of(
        [straight(100.0)], 20.0, start=50.0, values={"contact.normal": normal, "contact.tangential": creep}
    )
    law = force_law(setup)
    q, q_t = pressed(law, *POSES[pose])

    def cold(by_q: np.ndarray, by_q_t: np.ndarray) -> np.ndarray:
        out = np.zeros(law.size)
        law(0.0, q + by_q, q_t + by_q_t, out)
        return out[:6] / SCALE

    middle = cold(np.zeros(law.size), np.zeros(law.size))
    carried = sum(abs(wheel.model.arrays.total.Fb) for wheel in law.wheels[0])
    assert carried > 3e4
    known = (0.0, 0.0) if normal == "kik-piotrowski" else (WARM_TOLERANCE, OF_CONTACTS)
    cold_error, warm_error = (carried * (tolerance + 1e-12) for tolerance in known)
    for by_q, by_q_t in DIRECTIONS:
        with law.following(OF_CONTACTS):
            law(0.0, q, q_t, np.zeros(law.size))
            found = force_derivative(law, q, q_t, 1, 0.0, by_q, by_q_t, central=False)[:6, :6] / SCALE[:, None]
        whole = np.linalg.norm(found / SCALE)
        for c, name in enumerate(COORDINATES):
            h = min(SMALL[name] / max(by_q, 1e-300), SMALL_RATE / max(by_q_t, 1e-300))
            unit = np.eye(law.size)[c] * h
            up, down = (np.array([cold(m * by_q * unit, m * by_q_t * unit) for m in way * SPANS]) for way in (1, -1))
            central = (up[1] - down[1]) / (2.0 * h)
            bent = np.linalg.norm((up + down - 2.0 * middle) / (SPANS[:, None] * h) ** 2, axis=1).max()
            noise = 2.0 * warm_error / h + cold_error / h
            error = np.linalg.norm(found[:, c] - central)
            assert error <= h * bent + noise, (name, by_q, by_q_t)
            assert h * bent + noise <= ALLOWED * SCALE[c] * whole, (name, by_q, by_q_t)
