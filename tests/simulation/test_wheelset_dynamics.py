"""Dynamics of the wheelset in the integrator against what can be known: free bodies, Klingel, published growth rates.

The contact is a law on knife edges (support.knife_edge), so that only wheelset, carrier and integrator are tested.
"""

import numpy as np
import pytest
from scipy.optimize import curve_fit
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset

from wrsim.core.body.kinematics import kinematics
from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration
from wrsim.simulation.system import BodySystem

BODY = Solid(1500.0, (900.0, 100.0, 900.0))


def free(t, q, q_t, out):
    """No forces."""
    out.fill(0.0)


def momentum_and_energy(motion, body):
    """Angular momentum about the centre of mass (n, 3) and kinetic energy (n,)."""
    momentum, energy = [], []
    for q, q_t in zip(motion.q, motion.q_t, strict=True):
        state = kinematics(q, q_t)
        axle, omega, velocity = np.array(state.left), np.array(state.omega), np.array(state.velocity)
        along = omega @ axle
        momentum.append(body.inertia[0] * omega + (body.inertia[1] - body.inertia[0]) * along * axle)
        energy.append(0.5 * body.mass * velocity @ velocity + 0.5 * omega @ momentum[-1])
    return np.array(momentum), np.array(energy)


def test_a_free_spinning_wheelset_keeps_energy_and_angular_momentum():
    q = np.array([1.0, 2.0, 3.0, 0.5, 0.1, 0.0])
    q_t = np.array([0.3, 20.0, -1.0, 0.7, -0.4, 100.0])
    motion = Integration(
        BodySystem([BODY], free), duration=5.0, step=5e-4, integrator="rk44", sample_interval=0.05
    ).run(q, q_t)
    momentum, energy = momentum_and_energy(motion, BODY)
    # drift of RK44 at 100 rad/s and h = 5e-4
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-7
    assert np.abs(momentum - momentum[0]).max() < 1e-6 * np.linalg.norm(momentum[0])
    assert motion.q[:, :3] == pytest.approx(q[:3] + motion.times[:, None] * q_t[:3], abs=1e-9)


def test_a_free_axle_precesses_about_its_angular_momentum():
    q = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0])
    q_t = np.array([0.0, 0.0, 0.0, 0.5, 0.2, 60.0])
    motion = Integration(
        BodySystem([BODY], free), duration=2.0, step=5e-4, integrator="rk44", sample_interval=0.05
    ).run(q, q_t)
    momentum, _ = momentum_and_energy(motion, BODY)
    size = np.linalg.norm(momentum[0])
    axis = momentum[0] / size
    axle = np.array([kinematics(a, b).left for a, b in zip(motion.q, motion.q_t, strict=True)])
    # symmetric top: the axle turns about L at |L| / I_cross
    turn = size / BODY.inertia[0] * motion.times
    parallel = (axle[0] @ axis) * axis
    expected = (
        parallel
        + np.cos(turn)[:, None] * (axle[0] - parallel)
        + np.sin(turn)[:, None] * np.cross(axis, axle[0] - parallel)
    )
    assert axle == pytest.approx(expected, abs=1e-7)


def rolling(speed, lateral=0.0):
    """System of the example on knife edges, and its state where it rolls along x."""
    law = KnifeEdge()
    q = np.array([law.radius - law.approach(50e3), 0.0, lateral, 0.0, 0.0, 0.0])
    q_t = np.array([0.0, speed, 0.0, 0.0, 0.0, speed / law.radius])
    return KnifeEdgeForces(example_wheelset(), speed).system, q, q_t


def swing(speed, duration):
    """Growth rate and angular frequency of a wheelset that was put a micrometre aside."""
    system, q, q_t = rolling(speed, 1e-6)
    motion = Integration(system, duration=duration, step=5e-4, integrator="rk44", sample_interval=2e-3).run(q, q_t)
    late = motion.times > 1.0  # the other modes have died
    return growth_and_frequency(motion.times[late], motion.q[late, 2])


def growth_and_frequency(times, values):
    """Growth rate and angular frequency of a single growing or decaying oscillation."""
    values = values / np.abs(values).max()
    spectrum = np.abs(np.fft.rfft(values * np.hanning(len(values))))
    guess = 2 * np.pi * np.fft.rfftfreq(len(values), times[1] - times[0])[np.argmax(spectrum)]

    def model(t, growth, frequency, a, b, offset):
        t = t - t.mean()
        return np.exp(growth * t) * (a * np.cos(frequency * t) + b * np.sin(frequency * t)) + offset

    found, _ = curve_fit(model, times, values, [0.0, guess, 0.5, 0.5, 0.0])
    assert np.std(model(times, *found) - values) < 1e-3
    return found[0], found[1]


@pytest.mark.parametrize(
    ("speed", "growth", "frequency"),
    [(29.9, -0.927, 11.268), (44.8, -0.555, 16.874), (54.7, 0.177, 20.433), (64.7, 1.302, 23.743)],
)
def test_growth_rates_of_the_three_dimensional_example(speed, growth, frequency):
    found = swing(speed, 4.5)
    # the reference has three digits; 2 % is what the project asks
    assert found[0] == pytest.approx(growth, rel=0.007)
    assert found[1] == pytest.approx(frequency, rel=1e-3)
