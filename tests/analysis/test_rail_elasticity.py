"""Elastic rails: a mass on spring and damper under each wheel of a vehicle."""

from functools import cache

import numpy as np
import pytest
from support.vehicles import Train, manchester, on_track

from wrsim.geometry.track.segments import Arc
from wrsim.geometry.track.track import RailElasticity
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails, steady_state
from wrsim.simulation.step_size import eigenvalues

TRACK = RailElasticity(stiffness=(25e6, 50e6), damping=(40e3, 60e3), mass=(120.0, 160.0))
SPEED = 15.0
CURVED = (Arc(400.0, 800.0, cant=0.04),)


@cache
def train(elastic: bool, curved: bool = False) -> Train:
    segments = {"segments": CURVED} if curved else {}
    return on_track(manchester(), SPEED, structure=TRACK if elastic else None, **segments)


@cache
def steady(elastic: bool, curved: bool = False):
    law = train(elastic, curved).law
    if not curved:
        return steady_state(law)
    q, q_t = design_state(law, lateral=-3e-3)  # a curve is searched for from outward
    law.look_near(50.0)
    q, q_t = lower_on_rails(law, q, q_t)
    return steady_state(law, (q, q_t))


def wheel_forces(law, q, q_t) -> np.ndarray:
    """Forces of the wheels on the rails along n and b (wheelset, left and right, 2) [N]."""
    law(0.0, q, q_t, np.zeros(law.size))
    return np.array(
        [[(-w.side * w.model.arrays.total["Fo"], -w.model.arrays.total["Fb"]) for w in pair] for pair in law.wheels]
    )


@pytest.mark.parametrize("curved", [False, True], ids=["straight", "curve"])
def test_in_steady_motion_the_springs_of_the_rails_carry_the_wheels(curved: bool) -> None:
    law, state = train(True, curved).law, steady(True, curved)
    moved = state.q[-16:].reshape(4, 2, 2)
    forces = wheel_forces(law, state.q, state.q_t)
    assert moved * np.array(TRACK.stiffness) == pytest.approx(
        forces, abs=0.02
    )  # N; the displacements are settled to 0.1 nm
    assert forces[:, :, 1].sum() == pytest.approx(-manchester().mass * 9.80665, rel=1e-2 if curved else 1e-6)
    if curved:  # the flanges push the rails apart
        assert np.abs(moved[:, :, 0]).max() > 1e-5


def test_a_vehicle_sinks_with_its_rails_and_nothing_else_changes() -> None:
    rigid, elastic = steady(False), steady(True)
    n = 6 * len(train(True).law.bodies)
    sunk = manchester().mass * 9.80665 / 8.0 / TRACK.stiffness[1]
    change = (elastic.q[:n] - rigid.q[:n]).reshape(-1, 6)
    assert change[:, 0] == pytest.approx(-sunk, rel=1e-3)  # wheels of both ends are not loaded quite alike
    assert np.abs(change[:, 2:5]).max() < 2e-6  # lateral shift, heading, roll


def test_a_rail_moved_like_its_vehicle_changes_no_force() -> None:
    law, rigid = train(True).law, train(False).law
    q, q_t = steady(False).q, steady(False).q_t
    n, size = 6 * len(law.bodies), rigid.size
    plain = np.zeros(size)
    rigid(0.0, q, q_t, plain)
    both, both_t = np.concatenate([q, np.zeros(16)]), np.concatenate([q_t, np.zeros(16)])
    rails = both[-16:].reshape(4, 2, 2)
    rates = both_t[-16:].reshape(4, 2, 2)
    rails[:], rates[:] = (2e-3, -1e-3), (0.01, -0.02)
    for column, by in ((2, 2e-3), (0, -1e-3)):
        both[column:n:6] += by
    for column, by in ((2, 0.01), (0, -0.02)):
        both_t[column:n:6] += by
    out = np.zeros(law.size)
    law(0.0, both, both_t, out)
    # the pull along the track and round-off of the places are all that may differ
    assert out[:n] == pytest.approx(plain[:n], abs=5.0)
    # and each piece is accelerated by its wheel's force, spring and damper
    forces = wheel_forces(law, both, both_t)
    law(0.0, both, both_t, out)
    expected = (forces - rails * np.array(TRACK.stiffness) - rates * np.array(TRACK.damping)) / np.array(TRACK.mass)
    assert out[-16:].reshape(4, 2, 2) == pytest.approx(expected, rel=1e-12)


def test_a_rail_without_its_wheel_swings_at_its_own_frequency() -> None:
    law = train(True).law
    q, q_t = design_state(law)
    q[: 6 * len(law.bodies) : 6] += 0.05  # lifted off
    found = eigenvalues(train(True).system, q, q_t)
    for stiffness, damping, mass in zip(TRACK.stiffness, TRACK.damping, TRACK.mass, strict=True):
        half = 0.5 * damping / mass
        expected = -half + 1j * np.sqrt(stiffness / mass - half**2)
        assert (np.abs(found - expected) < 1e-3 * abs(expected)).sum() == 8
