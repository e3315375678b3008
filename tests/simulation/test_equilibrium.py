"""Rest states: found from bad guesses, to 1e-9 of the weight, and a clear word when there is none."""

from dataclasses import replace

import numpy as np
import pytest
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset, straight

from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import find_equilibrium
from wrsim.simulation.integrate import integrate
from wrsim.simulation.system import RigidBody, System
from wrsim.vehicle.wheelset import SprungMass

ROLLING = ("z", "y", "heading", "roll", "spin_rate")
SPEED = 30.0


def rolling_guess(**places):
    """A guess: names of q to values."""
    q = np.array([0.46, 0.0, 0.0, 0.0, 0.0, 0.0])
    for name, value in places.items():
        q[("z", "x", "y", "heading", "roll", "spin").index(name)] = value
    return q, np.array([0.0, SPEED, 0.0, 0.0, 0.0, SPEED / 0.46])


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(
    "places",
    [
        {},
        {"y": 3e-3, "heading": 2e-3},
        {"z": 0.4595},
        {"z": 0.49, "roll": 5e-3},
        {"z": 0.455, "y": -4e-3, "roll": -1e-2},
    ],
    ids=["near", "aside", "too low", "in the air", "askew"],
)
def test_a_symmetric_wheelset_rolls_straight_in_the_middle(exact, places):
    law = KnifeEdge(exact=exact)
    vehicle = example_wheelset()
    forces = KnifeEdgeForces(vehicle, SPEED, straight(), 1000.0, law)
    found = find_equilibrium(forces, *rolling_guess(**places), ROLLING, weight=100e3)
    assert found.residual <= 1e-9
    assert found.q[2] == pytest.approx(0.0, abs=1e-9)
    assert found.q[3:5] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert found.q[0] == pytest.approx(0.46 - law.approach(50e3), abs=1e-6)
    assert found.q_t[5] == pytest.approx(SPEED / 0.46, rel=1e-5)
    left, right = forces.memory[1:]
    assert left == pytest.approx(right, rel=1e-6)
    assert left * np.cos(np.arctan(0.05)) == pytest.approx(50e3, rel=2e-6)


def test_a_lateral_force_is_held_by_the_springs():
    # 1 kN on two springs of 0.2 MN/m; the cones turn the wheelset, the yaw springs hold against it
    plain = example_wheelset()
    vehicle = replace(plain, constant_force=(0.0, 1e3, plain.constant_force[2]))
    forces = KnifeEdgeForces(vehicle, SPEED, straight(), 1000.0)
    found = find_equilibrium(forces, *rolling_guess(), ROLLING, weight=100e3)
    out = np.zeros(6)
    forces(0.0, found.q, found.q_t, out)
    assert np.abs(out[[0, 2]]).max() < 1e-9 * 100e3
    assert 0.0 < found.q[2] < 1e3 / 4e5


def test_a_wheelset_stands_on_both_rails_at_a_given_shift():
    forces = KnifeEdgeForces(example_wheelset(), SPEED, straight(), 1000.0)
    q, q_t = rolling_guess(y=4e-3)
    found = find_equilibrium(forces, q, q_t, ("z", "roll"), weight=100e3)
    assert found.q[2] == 4e-3
    assert found.q[4] == pytest.approx(0.05 * 4e-3 / 0.75, rel=0.05)


def test_an_equilibrium_stays_at_rest_in_time():
    vehicle = replace(example_wheelset(), sprung=SprungMass(2000.0, 1.0), constant_force=(0.0, 0.0, -5e4))
    forces = KnifeEdgeForces(vehicle, SPEED, straight(), 1000.0)
    found = find_equilibrium(forces, *rolling_guess(), ROLLING, weight=vehicle.static_axle_load)
    system = System([RigidBody.of(vehicle)], forces)
    motion = integrate(system, found.q, found.q_t, duration=1.0, step=5e-4, sample_interval=0.01)
    assert np.ptp(motion.q[:, 0]) < 1e-12
    assert np.abs(motion.q[:, 2:5]).max() < 1e-12


def test_a_standing_wheelset_keeps_what_nothing_determines():
    # creep forces of zero at rest: x is free, Newton's step leaves it
    vehicle = example_wheelset(spring=0.0)
    forces = KnifeEdgeForces(vehicle, SPEED, straight(), 1000.0)
    q, q_t = rolling_guess(x=7.0)
    found = find_equilibrium(forces, q, q_t, ("z", "x", "roll"), weight=100e3)
    assert found.q[1] == 7.0


def test_a_wheelset_off_the_rails_is_named():
    forces = KnifeEdgeForces(example_wheelset(), SPEED, straight(), 1000.0)
    with pytest.raises(SimulationError, match=r"within 50 mm of z = 1.46 m; is it above the rails"):
        find_equilibrium(forces, *rolling_guess(z=1.46), ROLLING, weight=100e3)


def test_what_did_not_converge_is_named():
    plain = example_wheelset(spring=0.0)
    vehicle = replace(plain, constant_force=(0.0, 1e6, plain.constant_force[2]))  # ten times its weight sideways
    forces = KnifeEdgeForces(vehicle, SPEED, straight(), 1000.0)
    with pytest.raises(SimulationError, match=r"not found; remaining forces over the weight: z .*, y .*; at z"):
        find_equilibrium(forces, *rolling_guess(), ROLLING, weight=100e3)


def test_forces_that_are_not_numbers_are_named():
    def law(t, q, q_t, out):
        out.fill(np.nan)

    with pytest.raises(SimulationError, match="forces are not finite"):
        find_equilibrium(law, *rolling_guess(), ROLLING, weight=100e3)


def test_as_many_equations_as_unknowns():
    with pytest.raises(ValueError, match="2 equations for 1 unknowns"):
        find_equilibrium(lambda *a: None, *rolling_guess(), ("z",), equations=("z", "y"), weight=1.0)


def test_bodies_are_told_apart():
    # two bodies on springs of their own, each in its own place
    def law(t, q, q_t, out):
        out.fill(0.0)
        out[2] = -1e6 * (q[2] - 1e-3)
        out[8] = -2e6 * (q[8] + 2e-3 - q[2])

    found = find_equilibrium(law, np.zeros(12), np.zeros(12), ("y@0", "y@1"), weight=1e4)
    assert found.q[[2, 8]] == pytest.approx([1e-3, -1e-3], abs=1e-12)
