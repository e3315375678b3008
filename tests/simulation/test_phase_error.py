"""The error that steps of generalised alpha leave in a vibration: estimated while it lasts, and kept small."""

from contextlib import closing

import numpy as np
import pytest

from wrsim.analysis.motion.monitor import PEAK_ERROR
from wrsim.analysis.motion.phase_error import DAMPING, PhaseError
from wrsim.simulation import recorder as recorders
from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration
from wrsim.simulation.recorder import Recorder
from wrsim.simulation.system import BodySystem

BODY = Solid(1500.0, (900.0, 100.0, 900.0))
STEP, LOAD = 2e-3, 60e3
TOLERANCE = 0.5 * PEAK_ERROR * LOAD
V0 = np.array([0.0, 10.0, 0.0, 0.0, 0.0, 21.0])


class Vibration:
    """A body on a lateral spring with a damper, its force watched."""

    def __init__(self, frequency: float, amplitude: float, damping: float = DAMPING, step: float = STEP) -> None:
        """amplitude [N] of the force at the start; step [s]: see PhaseError."""
        self.omega, self.damping, self.amplitude = 2.0 * np.pi * frequency, damping, amplitude
        self.phase_error, self.largest, self.y = PhaseError(1, step, TOLERANCE), 0.0, 0.0
        self.system = BodySystem([BODY], self.forces)

    def forces(self, t, q, q_t, out):
        out.fill(0.0)
        self.y = q[2]
        out[2] = -BODY.mass * (self.omega**2 * q[2] + 2.0 * self.damping * self.omega * q_t[2])

    def step(self, t, sampled):
        self.phase_error.add(t, np.array([-BODY.mass * self.omega**2 * self.system.q[2]]))
        self.largest = max(self.largest, self.phase_error.arrays[-1][3])

    def __call__(self, t, q, q_t):
        return None

    @property
    def longest_step(self):
        return self.phase_error.longest_step

    def get_state(self):
        return np.concatenate([array.ravel() for array in self.phase_error.arrays])

    def set_state(self, memory):
        place = 0
        for array in self.phase_error.arrays:
            array[...] = memory[place : place + array.size].reshape(array.shape)
            place += array.size

    def run(self, seconds=1.0, recorder=None):
        start = self.amplitude / (BODY.mass * self.omega**2)
        q0 = np.array([0.46, 0.0, start, 0.0, 0.0, 0.0])
        return Integration(
            self.system, duration=seconds, step=STEP, monitor=self, monitor_interval=2 * STEP, recorder=recorder
        ).run(q0, V0)

    def error(self, motion):
        """Largest error of the force [N]."""
        decay, damped = self.damping * self.omega, self.omega * (1.0 - self.damping**2) ** 0.5
        t = motion.times
        exact = np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))
        return np.abs(BODY.mass * self.omega**2 * motion.q[:, 2] - self.amplitude * exact).max()


@pytest.mark.parametrize("frequency", [22.0, 26.0, 30.0])
def test_the_estimated_error_is_that_of_the_integration(frequency):
    vibration = Vibration(frequency, 1e3)
    error = vibration.error(vibration.run())
    # at one ring-down (omega h)^2 / (12 zeta e) of the amplitude, while the phase is off by little
    assert error == pytest.approx(1e3 * (vibration.omega * STEP) ** 2 / (12.0 * DAMPING * np.e), rel=0.02)
    assert vibration.largest == pytest.approx(error, rel=0.05)
    assert vibration.system.work.refined_steps == 0


def test_steps_are_refined_where_the_error_passes_half_a_per_cent_of_the_load_and_whole_again_behind_it():
    amplitude = TOLERANCE / ((2.0 * np.pi * 26.0 * STEP) ** 2 / (12.0 * DAMPING * np.e))
    below, above = Vibration(26.0, 0.95 * amplitude), Vibration(26.0, 1.1 * amplitude)
    fixed_step = Vibration(26.0, 1.1 * amplitude, step=0.0)
    errors = [vibration.error(vibration.run(2.0)) for vibration in (below, above, fixed_step)]
    assert [vibration.system.work.refined_steps > 0 for vibration in (below, above, fixed_step)] == [False, True, False]
    assert errors[0] < TOLERANCE < errors[2]
    assert above.longest_step == np.inf
    assert above.system.work.refined_steps < 500


@pytest.mark.parametrize("damping", [0.02, 0.005])
def test_an_error_stays_within_one_per_cent_of_the_load(damping):
    coarse, refined = (Vibration(36.0, 4e3, damping, step) for step in (0.0, STEP))
    assert coarse.error(coarse.run()) > 1.9 * PEAK_ERROR * LOAD
    assert refined.error(refined.run()) < PEAK_ERROR * LOAD


def test_noise_and_a_single_impact_do_not_add_up():
    rng = np.random.default_rng(1)
    noise, impact, swing = (PhaseError(1, STEP, TOLERANCE) for _ in range(3))
    forces = 1e3 * rng.standard_normal(500)
    turn = 2.0 * np.pi * 36.0 * STEP
    amplitude = np.abs(np.diff(forces, 2)).mean() / (2.0 / np.pi * turn**2)  # of the same sum of second differences
    wave = amplitude * np.sin(turn * np.arange(500))
    for i in range(500):
        noise.add(i * STEP, forces[i : i + 1])
        swing.add(i * STEP, wave[i : i + 1])
        impact.add(i * STEP, np.array([1e4 * (i == 250)]))
    assert 5.0 * noise.arrays[-1][3] < swing.arrays[-1][3]
    assert impact.arrays[-1][3] < TOLERANCE


def test_a_run_in_refined_steps_goes_on_to_the_bit(tmp_path, monkeypatch):
    monkeypatch.setattr(recorders, "FLUSH_INTERVAL", 0.0)

    def run(recorder=None):
        return Vibration(36.0, 4e3).run(1.2, recorder)

    whole, path = run(), tmp_path / "x.part"
    assert whole.work.refined_steps > 0
    header = {"integrator": "generalised-alpha", "step_s": STEP, "start_s": 0.0}
    with closing(Recorder.create(path, header, 6)) as recorder:
        run(recorder)
    data = path.read_bytes()
    for part in (0.3, 0.6, 0.9):
        path.write_bytes(data[: int(part * len(data))])
        with closing(Recorder.continued(path)) as recorder:
            again = run(recorder)
        assert np.array_equal(again.q, whole.q)
        assert again.work == whole.work
