"""How a time integration goes and how it ends: samples, progress, stops, faults; convergence, derivatives of forces."""

import gc
import shutil
import signal
import sys
import threading
import weakref
from pathlib import Path

import numpy as np
import pytest
from support.allocations import allocations
from support.knife_edge import KnifeEdge, KnifeEdgeForces, bare_wheelset, example_wheelset
from support.runs import FAST, arc, straight, transition
from support.vehicles import ROOT

from wrsim import InputError, SimulationError, load, stepper
from wrsim.simulation import step_size
from wrsim.simulation.bodies import Solid
from wrsim.simulation.implicit_step import ImplicitStep
from wrsim.simulation.integrate import Integration
from wrsim.simulation.recorder import BLOCK, Checkpoint, Ending, Recorder
from wrsim.simulation.step_size import RK44_LIMIT, SAFETY, creep_rate, eigenvalues, round_step, stable_step
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.dynamics import stepper as kernel
from wrsim.vehicle.dynamics.implicit_step import AHEAD

BODY = Solid(1500.0, (900.0, 100.0, 900.0))
Q0 = np.array([0.46, 0.0, 0.0, 0.0, 0.0, 0.0])
V0 = np.array([0.0, 10.0, 0.0, 0.0, 0.0, 21.0])


def free(t, q, q_t, out):
    """No forces."""
    out.fill(0.0)


def run(forces=free, *, duration=0.1, step=1e-3, bodies=(BODY,), **keys):
    """Integrate from rolling along x."""
    n = len(bodies)
    return Integration(BodySystem(bodies, forces), duration=duration, step=step, **keys).run(
        np.tile(Q0, n), np.tile(V0, n)
    )


def test_samples_stand_at_each_interval_and_the_monitor_ends_at_the_one_it_saw():
    motion = run(duration=0.0253, step=1e-3, sample_interval=4e-3)
    assert motion.times == pytest.approx([0.0, 0.004, 0.008, 0.012, 0.016, 0.02, 0.024, 0.026], abs=1e-15)
    assert motion.q[:, 1] == pytest.approx(10.0 * motion.times)
    assert motion.q[:, 5] == pytest.approx(21.0 * motion.times)
    assert (motion.status, motion.cause, motion.reason) == ("completed", "", "")
    assert motion.end == motion.times[-1]
    motion = run(monitor=lambda t, q, q_t: "too far" if q[1] > 0.505 else None)
    assert (motion.status, motion.cause, motion.reason) == ("stopped", "monitor", "too far")
    assert motion.times[-1] == pytest.approx(0.051)
    assert motion.q[-1, 1] > 0.505
    assert len(motion.times) == 52


def test_a_law_knows_the_time_of_its_stage():
    def push(t, q, q_t, out):
        out.fill(0.0)
        out[2] = 1500.0 * t * t  # y = t^4 / 12: exact for RK44

    motion = run(push, duration=1.0, step=0.1, integrator="rk44")
    assert motion.q[:, 2] == pytest.approx(motion.times**4 / 12.0, abs=1e-14)
    # generalised alpha knows it at the end of a step, and converges with the square of the step
    errors = [abs(run(push, duration=1.0, step=h).q[-1, 2] - 1.0 / 12.0) for h in (0.02, 0.01)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_progress_runs_from_nothing_to_the_end(monkeypatch):
    monkeypatch.setattr("wrsim.simulation.integrate.PROGRESS_INTERVAL", 0.0)
    seen = []
    run(progress=lambda fraction, left: seen.append((fraction, left)))
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[0] == pytest.approx(0.01)
    assert seen[-1] == (1.0, 0.0)
    assert all(left >= 0.0 for _, left in seen)


@pytest.mark.parametrize(("integrator", "broken"), [("rk44", 0.0505), ("generalised-alpha", 0.0500039)])
def test_a_force_that_is_not_finite_ends_the_run_and_is_named(integrator, broken):
    def breaks(t, q, q_t, out):
        out.fill(0.0)
        if t > 0.05:
            out[4] = np.nan

    motion = run(breaks, sample_interval=0.02, integrator=integrator)
    assert (motion.status, motion.cause) == ("stopped", "not-finite")
    # in the middle of a step of RK44; the implicit step is tried in ever more parts
    assert motion.reason == f"the force along roll is not a number at t = {broken:g} s"
    # the samples, and the last good state between two of them
    assert motion.times == pytest.approx([0.0, 0.02, 0.04, 0.05])
    assert np.all(np.isfinite(motion.q)) and np.all(np.isfinite(motion.q_t))


def test_a_start_that_is_not_finite_is_refused():
    with pytest.raises(SimulationError, match="the rate of spin"):
        Integration(BodySystem([BODY], free), duration=1.0, step=0.1).run(
            Q0, V0 * np.nan ** np.array([0, 0, 0, 0, 0, 1])
        )


@pytest.mark.parametrize("keys", [{"step": 0.0}, {"duration": -1.0}, {"duration": np.inf}])
def test_a_run_without_steps_is_refused(keys):
    with pytest.raises(ValueError, match="step and duration"):
        run(**keys)


@pytest.mark.parametrize(("integrator", "lost_at"), [("rk44", "0.0505"), ("generalised-alpha", "0.0500")])
def test_a_law_that_cannot_go_on_ends_the_run_in_good_order(integrator, lost_at):
    def lost(t, q, q_t, out):
        out.fill(0.0)
        if t > 0.05:
            raise SimulationError(f"no contact at t = {t:.4f} s")

    motion = run(lost, integrator=integrator)
    assert (motion.status, motion.cause) == ("stopped", "forces")
    assert motion.reason == f"no contact at t = {lost_at} s"
    assert motion.times[-1] == pytest.approx(0.05)


class Broken(Exception):
    pass


def broken(*args):
    raise Broken("on purpose")


@pytest.mark.parametrize("keys", [{"forces": broken}, {"monitor": broken}, {"progress": broken}])
def test_other_exceptions_come_through(keys, monkeypatch):
    monkeypatch.setattr("wrsim.simulation.integrate.PROGRESS_INTERVAL", 0.0)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(Broken, match="on purpose"):
        run(**keys)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_system_is_as_good_as_new_after_a_run_that_broke():
    faulty = [True]

    def law(t, q, q_t, out):
        out.fill(0.0)
        if faulty[0] and t > 0.05:
            raise Broken

    system = BodySystem([BODY], law)
    with pytest.raises(Broken):
        Integration(system, duration=0.1, step=1e-3).run(Q0, V0)
    faulty[0] = False
    assert Integration(system, duration=0.1, step=1e-3).run(Q0, V0).q[-1, 1] == pytest.approx(1.0)


def test_ctrl_c_ends_the_run_after_the_step_and_keeps_what_was_computed():
    def press(t, q, q_t):
        if abs(t - 0.05) < 1e-9:
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    motion = run(monitor=press)
    assert (motion.status, motion.cause) == ("stopped", "interrupt")
    assert motion.reason.startswith("interrupted by the user at t = 0.05")
    assert 0.05 <= motion.end <= 0.052
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_ctrl_c_ends_at_once():
    def stuck(t, q, q_t, out):
        out.fill(0.0)
        if t > 0.05:
            for _ in range(2):
                signal.raise_signal(signal.SIGINT)
            raise AssertionError("not reached")

    motion = run(stuck)
    assert motion.cause == "interrupt"
    assert motion.end == pytest.approx(0.05)


def test_runs_work_outside_the_main_thread():
    motions = []
    thread = threading.Thread(target=lambda: motions.append(run()))
    thread.start()
    thread.join()
    assert motions[0].status == "completed"


def test_exudyn_writes_neither_to_the_console_nor_to_files(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run()
    with pytest.raises(Broken):
        run(broken)
    captured = capfd.readouterr()
    assert captured.out == captured.err == ""
    assert list(tmp_path.iterdir()) == []


def test_a_system_and_its_law_are_freed():
    class Law:
        def __call__(self, t, q, q_t, out):
            out.fill(0.0)

    law = Law()
    reference = weakref.ref(law)
    system = BodySystem([BODY], law)
    Integration(system, duration=0.01, step=1e-3).run(Q0, V0)
    del law, system
    gc.collect()
    assert reference() is None


@pytest.fixture(scope="module")
def rolling() -> BodySystem:
    """The example wheelset on knife edges at 30 m/s."""
    return KnifeEdgeForces(example_wheelset(), 30.0).system


def test_rk44_converges_with_fourth_order_on_the_force_law(rolling):
    # 3 mm to the side, 5 mrad yawed, 2 um too low: the contact springs vibrate, friction partly saturates
    q = np.array([0.46 - KnifeEdge().approach(50e3) - 2e-6, 0.0, 3e-3, 5e-3, 2.1e-4, 0.0])
    q_t = np.array([0.0, 30.0, 0.0, 0.0, 0.0, 30.0 / 0.46])

    def end(step):
        return Integration(rolling, duration=0.1, step=step, integrator="rk44").run(q, q_t).q[-1]

    exact = end(1e-5)
    errors = [np.abs(end(step) - exact)[[0, 2, 3, 4]] for step in (4e-4, 2e-4, 1e-4)]
    ratios = np.array([errors[0] / errors[1], errors[1] / errors[2]])
    assert np.all((ratios[:, 0] > 14.0) & (ratios[:, 0] < 22.0)), ratios  # height: 16, from above
    assert np.all(ratios > 14.0), ratios  # the others gain from terms that cancel
    assert np.all(errors[0] < 1e-8)


def test_generalised_alpha_converges_with_the_square_of_the_step(rolling):
    # the same wheelset at its own height: what moves is slower than the contact springs
    q = np.array([0.46 - KnifeEdge().approach(50e3), 0.0, 3e-3, 5e-3, 2.1e-4, 0.0])
    q_t = np.array([0.0, 30.0, 0.0, 0.0, 0.0, 30.0 / 0.46])
    exact = Integration(rolling, duration=0.2, step=1e-4, integrator="rk44").run(q, q_t).q[-1]
    errors = [
        np.abs(Integration(rolling, duration=0.2, step=step, weight=1.0).run(q, q_t).q[-1] - exact)[[2, 3]]
        for step in (1e-3, 5e-4, 2.5e-4)
    ]
    ratios = np.array([errors[0] / errors[1], errors[1] / errors[2]])
    assert np.all((ratios > 3.0) & (ratios < 5.0)), ratios


def test_a_jump_of_the_force_that_holds_the_balance_does_not_stop_the_run():
    # dry friction of 100 N, beside a weight of 15 kN: the body comes to rest where no velocity balances the forces
    def rubs(t, q, q_t, out):
        out.fill(0.0)
        out[2] = -100.0 * np.sign(q_t[2])

    q_t = V0 + np.array([0.0, 0.0, 1e-2, 0.0, 0.0, 0.0])
    motion = Integration(BodySystem([BODY], rubs), duration=0.3, step=2e-3).run(Q0, q_t)
    assert motion.status == "completed"
    rest = 1e-2 / (100.0 / 1500.0)  # s
    still = motion.times > rest + 2e-3
    assert np.abs(motion.q_t[still, 2]).max() < 2e-3 * 100.0 / 1500.0  # what the friction takes in one step
    assert motion.q[-1, 2] == pytest.approx(0.5 * 1e-2 * rest, abs=1e-2 * 2e-3)


def test_a_step_that_newton_does_not_solve_is_taken_by_rk44_and_counted():
    # friction of 67 times the weight: no velocity balances it, and no step is short enough
    def rubs(t, q, q_t, out):
        out.fill(0.0)
        if t > 0.0505:
            out[2] = -1e6 * np.sign(q_t[2] + 1e-3)

    motion = run(rubs, duration=0.06)
    assert motion.status == "completed"
    assert motion.work.explicit_steps >= 9
    assert abs(motion.q_t[-1, 2] + 1e-3) < 1e-3 * 1e6 / 1500.0 / 128  # what the friction takes in one part of a step


# The stable time step: what the creep forces and the contact springs allow, and what happens beyond.


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
    assert step_size.step_for_speed(speed) <= min(SAFETY * limit, 5e-4)
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
    values = eigenvalues(system.forces, system.bodies, q, q)
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
        assert np.abs(eigenvalues(system.forces, system.bodies, q, np.zeros(6))).max() == pytest.approx(
            expected, rel=1e-6
        )


def test_the_step_is_a_part_of_a_millisecond_grows_with_speed_and_falls_with_load():
    steps = [step_size.step_for_speed(v) for v in (1.0, 2.0, 5.0, 10.0, 20.0, 100.0)]
    assert steps == sorted(steps)
    assert steps[-1] == 1e-3
    for step in steps:
        assert 1e-3 / step == pytest.approx(round(1e-3 / step), abs=1e-9)
    assert round_step(4e-4) == pytest.approx(1e-3 / 3)
    assert round_step(1.0) == 1e-3
    vehicle = example_wheelset(axle_load=200e3)
    assert step_size.step_for_speed(5.0, vehicle) < step_size.step_for_speed(5.0, example_wheelset(axle_load=50e3))


# Samples of a run are safe whatever happens to the file that keeps them.
@pytest.mark.skipif(sys.platform == "win32", reason="Windows removes no file that is open")
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


# A vehicle that others move on step by step, beside the usual run; its inputs, its limits.
COACH = load(ROOT / "scenarios/manchester_r300.toml").with_values(
    FAST
    | {
        "track.segments": [straight(26.0), transition(15.0), arc(80.0, 300.0, 100.0)],
        "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 60]}],
        "run.start_distance_m": 12.0,
        "run.distance_m": 70.0,
        "vehicle.loads": [
            {"name": "push", "on": "carbody", "at_mm": [0.0, 0.0, 1500.0], "axes": "track", "force_kN": [0.0, 0.0, 0.0]}
        ],
        "vehicle.efforts": [{"moment_kNm": 0.0}],
    }
)


def test_steps_with_a_fixed_number_of_iterations_follow_the_usual_run() -> None:
    """Into a curve on an uneven track: bodies within 0.05 mm rms, and no memory is allocated in a step."""
    bench = stepper(COACH)
    law, q, q_t = bench.law, bench.q.copy(), bench.q_t.copy()
    states = [q]
    for _ in range(300):
        bench.step(10)
        states.append(bench.q.copy())
    assert bench.time == pytest.approx(3.0)
    assert bench.residual[1] < 0.02
    count = allocations(lambda _, *arguments: kernel.advance(*arguments), 0, bench.memory.buffer, bench.memory.index)
    assert count == 0
    law.set_search_start(12.0)
    usual = Integration(BodySystem(law.bodies, law), duration=3.0, step=2e-3, sample_interval=10e-3).run(q, q_t)
    bodies = 6 * len(law.bodies)
    off = (np.array(states) - usual.q)[:, :bodies].reshape(len(states), -1, 6)
    heading = usual.q[:, 3:bodies:6]
    assert np.ptp(heading) > 0.08
    across = np.cos(heading) * off[:, :, 2] - np.sin(heading) * off[:, :, 1]
    assert np.sqrt((across**2).mean()) < 5e-5
    assert np.sqrt((off[:, :, 0] ** 2).mean()) < 5e-5


DIPPED = load(ROOT / "scenarios/curve_r300.toml").with_values(
    {
        "contact.cells": 4,
        "track.rail_sections": [
            {"at_m": 20.0 + offset, "rail": "rails/60E1.toml", "side": "right", "down_mm": down}
            for offset, down in ((-1.0, 0.0), (-0.3, 0.0), (0.0, 3.0), (0.3, 0.0), (1.0, 0.0))
        ],
        "run.start_distance_m": 15.0,
    }
)
"""A wheelset with strips over a crossing's dip, where grids come and go."""


def test_a_budget_of_residuals_bounds_every_step_and_coarse_contacts_come_back() -> None:
    """Never more than it; no bit changes as long as no step needs more; one that is spent leaves .005 mm rms at most,
    is told in the outputs, and no contact is coarse any more behind the dip."""
    benches = {budget: stepper(DIPPED, budget=budget) for budget in (np.inf, 1e5, 8.0)}
    heights, told = {budget: [] for budget in benches}, []
    for _ in range(600):
        for budget, bench in benches.items():
            bench.step()
            heights[budget].append(bench.q.copy())
        told.append([float(benches[8.0].outputs[f"contacts.{name}"][0]) for name in ("coarse", "unsolved")])
    assert np.array_equal(heights[np.inf], heights[1e5])
    free, bounded, shares = benches[np.inf].coarse, benches[8.0].coarse, np.array(told)
    assert free.most > 4 * 8.0 and free[:3] == (0, 0, 0)  # two wheels, two evaluations
    assert 2 * 8.0 < bounded.most <= 4 * 8.0
    assert bounded[:3] == ((shares[:, 0] > 0.0).sum(), *shares.sum(axis=0))
    assert 0 < bounded.steps < 30 and 0 < bounded.unsolved < bounded.contacts
    first, last = np.flatnonzero(shares[:, 0])[[0, -1]]
    assert first > 300 and last < 400
    off = np.array(heights[8.0])[:, :3] - np.array(heights[np.inf])[:, :3]
    assert not off[:first].any() and off[first].any()
    assert np.sqrt((off**2).mean()) < 5e-6
    with pytest.raises(InputError, match=r"^budget = 2: must be 3 residuals"):
        stepper(DIPPED, budget=2.0)


@pytest.mark.skipif(sys.platform != "linux", reason="counts of a thread are Linux's")
def test_steps_with_a_deadline_take_no_page_fault() -> None:
    resource = pytest.importorskip("resource")
    bench = stepper(COACH)
    with bench.deadline() as problem:
        assert problem == "" or "memory" in problem.lower() or "permitted" in problem
        assert not gc.isenabled()
        bench.step(100)
        before = resource.getrusage(resource.RUSAGE_THREAD)
        for _ in range(500):
            bench.step()
        after = resource.getrusage(resource.RUSAGE_THREAD)
    assert gc.isenabled()
    assert (after.ru_majflt, after.ru_minflt) == (before.ru_majflt, before.ru_minflt)


def test_inputs_act_from_one_step_to_the_next() -> None:
    """A braking moment on every axle changes the momentum of the train by its impulse; a side force moves the car."""
    free = COACH.with_values({"vehicle.drive": "free", "track.irregularities": []})
    pushed, plain = stepper(free), stepper(free)
    moment, torques = -2e3, [f"{m.name}.torque_Nm" for m in pushed.law.vehicle.wheelsets]
    struts = {name for name in pushed.inputs if name.endswith(".control_N")}
    assert set(pushed.inputs) == {*torques, *struts, *(f"push.force_{axis}_N" for axis in "xyz")}
    assert {name.removesuffix(".control_N") + ".force_N" for name in struts} <= set(pushed.outputs)
    for name in torques:
        pushed.inputs[name][:] = moment
    for each in (pushed, plain):
        each.step(500)
    vehicle = pushed.law.vehicle
    # per axle M / r brakes the whole, and with it what turns
    mass = sum(body.mass for body in pushed.law.bodies)
    turning = sum(m.wheelset.inertia[1] / m.wheelset.mean_radius**2 for m in vehicle.wheelsets)
    expected = sum(moment / m.wheelset.mean_radius for m in vehicle.wheelsets) / (mass + turning) * pushed.time
    car = 6 * vehicle.index("carbody")
    slower = float(pushed.outputs["carbody.speed_m_s"][0] - plain.outputs["carbody.speed_m_s"][0])
    assert slower == pytest.approx(expected, rel=0.05)
    before = pushed.q[car + 2] - plain.q[car + 2]
    pushed.inputs["push.force_y_N"][:] = 5e3
    for each in (pushed, plain):
        each.step(200)
    assert pushed.q[car + 2] - plain.q[car + 2] > before + 1e-3


def test_outputs_are_those_of_the_place_however_far_the_vehicle_has_gone_between_two_looks() -> None:
    """All through a curve in one call, and look by look."""
    curve = load(ROOT / "scenarios/curve_r300.toml").with_values({"contact.normal": "kik-piotrowski"})
    far, near = stepper(curve), stepper(curve)
    far.step(12_200)
    for _ in range(122):
        near.step(100)
    for name, value in near.outputs.items():
        assert far.outputs[name] == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_outputs_know_the_place_after_many_turns_of_a_circle() -> None:
    """32 of them: the outer rail is 150 m longer than the centre line by then."""
    circle = load(ROOT / "scenarios/curve_r300.toml").with_values(
        {
            "contact.normal": "kik-piotrowski",
            "vehicle.speed_kmh": 36.0,
            "track.segments": [straight(20.0), arc(20_300.0, 100.0, 0.0)],
        }
    )
    seen = {}
    for start in (50.0, 20_250.0):
        bench = stepper(circle.with_values({"run.start_distance_m": start, "run.distance_m": 20.0}))
        bench.step(1000)
        seen[start] = {name: value.copy() for name, value in bench.outputs.items()}
        distance = next(name for name in seen[start] if name.endswith(".distance_m"))
        assert seen[start].pop(distance) == pytest.approx(start + 10.0, abs=0.1)
    for name, value in seen[50.0].items():
        assert seen[20_250.0][name] == pytest.approx(value, rel=1e-4, abs=1e-5), name


def test_what_cannot_be_taken_step_by_step_is_refused() -> None:
    with pytest.raises(InputError, match=r"must be above 0 and at most 0\.005 s"):
        stepper(COACH, step=0.1)
    with pytest.raises(InputError, match="only with the fast models"):
        stepper(COACH.with_values({"contact.normal": "half-space"}))
    with pytest.raises(InputError, match="only runs along the track"):
        stepper(load(ROOT / "scenarios/static_s1002.toml"))
    for amount, message in ((1e4, "no longer near its track"), (np.nan, "is not a number")):
        bench = stepper(COACH)
        bench.q[1] += amount
        with pytest.raises(SimulationError, match=message):
            bench.step()


@pytest.mark.parametrize(("angle", "wrong"), [(0.5, 0.027), (2.5, 0.06)])
def test_accelerations_of_a_vibration_that_drifts_are_foretold_soon_after_it_has_changed(angle, wrong):
    """Two accelerations foretell a vibration, two more a drift, the steps of another one fade; angle of a step."""
    q, q_t, q_tt = np.zeros((3, 6))
    newton = ImplicitStep(q, q_t, q_tt, 1, 0, 1e-3, 1e3, 1e4)
    for k in range(400):
        q_tt[:] = np.sin((angle if k > 200 else 0.7 * angle) * k + np.arange(6)) + 3e-3 * k
        newton.end_step()
    assert newton.rows[AHEAD] == pytest.approx(np.sin(angle * 400 + np.arange(6)) + 1.2, abs=wrong)
