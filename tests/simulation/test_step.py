"""The stable time step: what the creep forces and the contact springs allow, and what happens beyond."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.knife_edge import KnifeEdge, KnifeEdgeForces, bare_wheelset, example_wheelset

from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration
from wrsim.simulation.recorder import BLOCK, Checkpoint, Ending, Recorder
from wrsim.simulation.step_size import (
    RK44_LIMIT,
    SAFETY,
    creep_rate,
    eigenvalues,
    round_step,
    stable_step,
    step_for_speed,
)
from wrsim.simulation.system import BodySystem

BODY = Solid(1500.0, (900.0, 100.0, 900.0))


def rolling_on_edges(speed):
    """Manchester wheelset on knife edges, creep coefficient 1e7 N, unsprung along the track; state and system."""
    mass = 1813.0
    vehicle = example_wheelset(wheelset=bare_wheelset(mass, (1120.0, 112.0, 1120.0)))
    forces = KnifeEdgeForces(vehicle, speed, law=KnifeEdge(creep=1e7))
    q = np.array([0.46 - KnifeEdge().approach(50e3), 0.0, 0.0, 0.0, 0.0, 0.0])
    q_t = np.array([0.0, speed, 0.0, 0.0, 0.0, speed / 0.46])
    return forces.system, q, q_t


@pytest.mark.parametrize("speed", [1.0, 5.0, 20.0])
def test_the_slip_of_the_wheels_decays_within_the_creep_limit_and_stays_wrong_beyond(speed):
    system, q, q_t = rolling_on_edges(speed)
    q_t[5] *= 1.0002

    def slip(step):
        motion = Integration(system, duration=1000 * step, step=step, integrator="rk44").run(q, q_t)
        assert motion.status == "completed"
        return np.abs(motion.q_t[-50:, 1] - 0.46 * motion.q_t[-50:, 5]).max() / speed

    limit = RK44_LIMIT / creep_rate(speed, 1813.0, 112.0, 0.46, 1e7)
    assert step_for_speed(speed) <= min(SAFETY * limit, 5e-4)
    assert slip(0.98 * limit) < 1e-6
    assert slip(1.1 * limit) > 1e-4  # bounded by the saturation: it does not blow up


@pytest.mark.parametrize("speed", [1.0, 5.0, 20.0])
def test_the_stable_step_of_a_rolling_wheelset_is_that_of_its_slip(speed):
    system, q, q_t = rolling_on_edges(speed)
    limit = RK44_LIMIT / creep_rate(speed, 1813.0, 112.0, 0.46, 1e7)
    assert stable_step(system, q, q_t) == pytest.approx(limit, rel=0.02)


def test_the_stable_step_of_a_spring_is_that_of_its_frequency():
    def law(t, q, q_t, out):
        out.fill(0.0)
        out[2] = -1500.0 * 1000.0**2 * q[2]

    system = BodySystem([BODY], law)
    q = np.zeros(6)
    assert stable_step(system, q, q) == pytest.approx(2.828 / 1000.0, rel=4e-3)
    values = eigenvalues(system, q, q)
    assert np.abs(values).max() == pytest.approx(1000.0, rel=1e-6)


def test_a_rolled_body_couples_heading_and_spin_in_its_eigenvalues():
    # a torsion spring of 1 Nm/rad about the axle: spin alone at roll 0 and at any other roll
    def law(t, q, q_t, out):
        out.fill(0.0)
        out[5] = -100.0 * 50.0**2 * q[5]

    system = BodySystem([BODY], law)
    for roll in (0.0, 0.3):
        q = np.array([0.0, 0.0, 0.0, 0.0, roll, 0.0])
        # spin angle against a fixed heading: inertia reduced by the coupling, 1/(1/I + tan(roll)^2 / I_cross)
        reduced = 1.0 / (1.0 / 100.0 + np.tan(roll) ** 2 / 900.0)
        expected = 50.0 * np.sqrt(100.0 / reduced)
        assert np.abs(eigenvalues(system, q, np.zeros(6))).max() == pytest.approx(expected, rel=1e-6)


def test_the_step_is_a_whole_part_of_a_millisecond_and_grows_with_the_speed():
    steps = [step_for_speed(v) for v in (1.0, 2.0, 5.0, 10.0, 20.0, 100.0)]
    assert steps == sorted(steps)
    assert steps[-1] == 1e-3
    for step in steps:
        assert 1e-3 / step == pytest.approx(round(1e-3 / step), abs=1e-9)
    assert round_step(4e-4) == pytest.approx(1e-3 / 3)
    assert round_step(1.0) == 1e-3


def test_a_heavier_load_takes_a_smaller_step():
    vehicle = example_wheelset(axle_load=200e3)
    assert step_for_speed(5.0, vehicle) < step_for_speed(5.0, example_wheelset(axle_load=50e3))


# Samples of a run are safe whatever happens to the file that keeps them.
def test_samples_survive_the_deletion_of_their_folder(tmp_path: Path) -> None:
    """The descriptor still has what the folder has lost."""
    recorder = Recorder.create(tmp_path / "out/result.nc.part", {"step_s": 1.0, "start_s": 0.0}, 2)
    samples = 3 * BLOCK
    for k in range(samples):
        if k == BLOCK + 7:
            shutil.rmtree(tmp_path / "out")
        recorder.sample(float(k), np.array([k, -k], dtype=float), np.zeros(2))
        if recorder.due():
            recorder.flush(Checkpoint(k, np.zeros(2), np.zeros(2), np.zeros(0)))
    recorder.end(Ending("", ""))
    rows = recorder.rows()
    assert np.array_equal(rows[:, 0], np.arange(samples))
    assert np.array_equal(rows[:, 2], -np.arange(samples))
    recorder.close()
