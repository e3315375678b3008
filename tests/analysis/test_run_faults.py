"""What happens to a run that cannot go on: it says when, where and why, and keeps what it has computed."""

import errno
import os
import re
import signal
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.commands import call, forked, ok
from support.runs import FAST, LEADING, SCENARIOS, STEERING, arc, ride, setup_of, straight, transition
from support.vehicles import ROOT, SHORT

from wrsim import InputError, Result, Scenario, SimulationError, load, load_profile, run
from wrsim.analysis.compare import compare_models, comparison_report
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion import monitor as monitors
from wrsim.analysis.motion.derailment import flange_tip, gauge_face
from wrsim.analysis.motion.messages import event_words
from wrsim.analysis.motion.monitor import LIFT_DISTANCE, LIFT_TIME, MANY, STRIKE, Monitor
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.resolve import resolve_contacts
from wrsim.contact import records
from wrsim.contact.records import (
    STATUS_LEFT_OUT,
    STATUS_LOAD_UNSOLVED,
    STATUS_NOT_CONVERGED,
    STATUS_PROFILE_END,
    STATUS_TOO_DEEP,
)
from wrsim.contact.status import NOT_CONVERGED, SUBSTITUTED, WORDS
from wrsim.contact.workspace import KernelArrays
from wrsim.scenario.build import Setup, build
from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails
from wrsim.simulation.system import BodySystem, Work

CLIMB: dict[str, Any] = {
    # a leading axle on dry, sanded rails in a 100 m curve: the flange climbs
    "vehicle.model": LEADING,
    "vehicle.speed_kmh": 43.2,
    "contact.friction": 1.0,
    "track.segments": [straight(2.0), transition(10.0), arc(30.0, 100.0)],
}
OVERTURN: dict[str, Any] = {
    # 122 km/h where 50 would be right: the inner wheel lifts off
    "vehicle.model": STEERING,
    "vehicle.speed_kmh": 122.4,
    "track.segments": [straight(2.0), transition(20.0), arc(80.0, 150.0)],
}
FALL: dict[str, Any] = {
    # conical wheels without flange in a curve that takes more than their cones
    "vehicle.model": STEERING,
    "vehicle.speed_kmh": 36.0,
    "vehicle.wheel": "wheels/cone_1in20.toml",
    "track.segments": [straight(2.0), transition(8.0), arc(30.0, 100.0)],
}
CASES = {"climb": CLIMB, "overturn": OVERTURN, "fall": FALL}
REASONS = {
    "climb": "derailed: the flange of the right wheel has climbed over its rail (lifted by",
    "overturn": "derailed: the left wheel has had no contact with its rail for 3.",
    "fall": "wheel has dropped beside its rail",
}


def setup(keys: dict[str, Any], **more: Any) -> Setup:
    """Set-up of one of the cases."""
    values = {key: value for key, value in keys.items() if not key.startswith(("vehicle.model", "vehicle.sp", "track"))}
    speed = keys["vehicle.speed_kmh"] / 3.6
    return setup_of(keys["track.segments"], speed, keys["vehicle.model"], values=FAST | values | more)


@cache
def derailed(name: str) -> Result:
    """The run of a case."""
    return run_in_time(setup(CASES[name]))


@pytest.mark.parametrize("name", CASES)
def test_a_derailment_says_what_when_and_where(name):
    result = derailed(name)
    attributes = result.dataset.attrs
    assert (result.status, attributes["stop_cause"]) == ("stopped", "monitor")
    assert REASONS[name] in result.stop_reason
    time, distance = attributes["stop_time_s"], attributes["stop_distance_m"]
    assert result.stop_reason.endswith(f", at t = {time:.4g} s, {distance:.2f} m along the track")
    assert result.summary()["stop"]["reason"] == result.stop_reason
    # the samples go right up to it, and the strips of the end are kept
    assert result.dataset["time"].values[-1] == pytest.approx(time, abs=1e-9)
    assert result.wheelset()["snapshot_time"].values[-1] == pytest.approx(time, abs=1e-9)
    for channel in ("lateral_shift", "Y", "Q", "roll"):
        assert np.isfinite(result.wheelset()[channel].values).all()


def test_a_flange_climbs_before_it_derails_and_that_is_noticed_however_seldom_samples_are():
    last = derailed("climb").wheelset().isel(time=-1)
    lifted = float(derailed("climb").stop_reason.split("lifted by ")[1].split(" mm")[0])
    assert 15.0 < lifted < 30.0  # of a flange height of 28 mm
    assert last["u_wheel"].sel(wheel="right").values[0] < -45e-3  # the contact has gone down the flange to its tip
    assert derailed("climb").wheelset()["Y_over_Q"].sel(wheel="right").max() > 0.7
    often, seldom = derailed("climb"), run_in_time(setup(CLIMB, **{"run.output_interval_ms": 5000.0}))
    assert seldom.dataset.attrs["step_s"] == pytest.approx(often.dataset.attrs["step_s"], rel=1e-12)
    assert seldom.stop_reason == often.stop_reason
    assert seldom.dataset.sizes["time"] == 2  # start and end


@cache
def fast_ride(speed: float):
    """A wheelset on straight track, its watch, and its state at rest on the rails."""
    straight_run = setup_of([straight(100.0)], speed, STEERING)
    going = ride(straight_run)
    rest = going.steady(("z", "roll", "spin"))
    return straight_run, going, rest


def watched(speed: float, lift: float, seconds: float) -> str | None:
    """What the watch says to a wheelset held ``lift`` above its rails for some time at a speed."""
    _, going, rest = fast_ride(speed)
    watch = Monitor(going.law, speed)
    answer = None
    for t in np.arange(0.0, seconds, watch.interval):
        q = rest.q.copy()
        q[0] += lift if t > 0.0 else 0.0
        q[1] += speed * t
        answer = answer or watch(float(t), q, rest.q_t)
    return answer


def test_a_hop_is_no_derailment_however_fast_nor_a_slow_creep_in_the_air_however_long():
    # 1 mm high, a hop lasts 29 ms; 4 mm, 57 ms
    assert 3.0 * 0.029 < LIFT_DISTANCE < 100.0 * 0.045
    assert watched(100.0, 1e-3, 0.045) is None  # 4.5 m
    assert "no contact with its rail" in str(watched(100.0, 4e-3, LIFT_TIME + 0.01))
    assert watched(2.0, 4e-3, 1.2) is None  # 2.4 m
    assert "no contact with its rail" in str(watched(2.0, 4e-3, 1.7))


def test_wheels_deep_in_their_rails_are_a_lost_solution():
    _, going, rest = fast_ride(20.0)
    q = rest.q.copy()
    q[0] -= 4e-3
    answer = Monitor(going.law, 20.0)(1.0, q, rest.q_t)
    assert answer is not None
    assert answer.startswith("the contact solution is lost: the ")
    assert "overlap by 4" in answer
    assert answer.endswith(", at t = 1 s, 0.00 m along the track")


def test_flange_tips_and_gauge_faces_are_where_the_standards_have_them():
    _, going, _ = fast_ride(20.0)
    wheel = going.law.wheels[0][0].model
    tip = flange_tip(wheel.wheel)
    assert tip is not None
    assert tip == pytest.approx((-55e-3, -28e-3), abs=2e-3)  # S1002: flange 28 mm high
    assert gauge_face(wheel.rail) == pytest.approx(-43.036e-3 + wheel.rail.top[0], abs=1e-5)  # 60E1 1:40
    cone = setup(FALL).wheelset.left.profile
    assert flange_tip(cone) is None


def law_that(monkeypatch, does) -> None:
    """From 0.3 s on the force law does something else."""
    true = VehicleOnTrack.__call__

    def call(self, t, q, q_t, out):
        true(self, t, q, q_t, out)
        if t >= 0.3:
            does(out)

    monkeypatch.setattr(VehicleOnTrack, "__call__", call)


def short() -> Setup:
    """Ten metres of straight track at 20 m/s."""
    return setup_of([straight(10.0)], 20.0, STEERING, values=FAST)


def test_a_law_of_no_numbers_and_a_start_that_is_none_are_named(monkeypatch, tmp_path):
    law_that(monkeypatch, lambda out: out.__setitem__(4, np.nan))
    result = run_in_time(short())
    assert (result.status, result.dataset.attrs["stop_cause"]) == ("stopped", "not-finite")
    assert result.stop_reason == "the force along roll is not a number at t = 0.3 s"
    step = result.dataset.attrs["step_s"]
    assert result.dataset["time"].values[-1] == pytest.approx(0.3 - step, abs=1e-9)
    assert np.isfinite(result.wheelset()["Q"].values).all()
    assert Result.load(result.save(tmp_path / "x.nc")).stop_reason == result.stop_reason
    with pytest.raises(
        SimulationError, match=r"no steady motion to start from at 3 m and 79\.2 km/h in a curve of 60 m"
    ):
        run_in_time(setup_of([arc(30.0, 60.0)], 22.0, STEERING, start=3.0))


def test_the_complaint_about_a_long_step_names_file_and_line(tmp_path):
    file = tmp_path / "long_step.toml"
    base = SCENARIOS / "curve_r300.toml"
    file.write_text(f'base = "{base.as_posix()}"\n[run]\nintegrator = "rk44"\nstep_us = 4000\n')
    message = r"long_step\.toml:4: run\.step_us = 4000: must be at most \d+, where"
    with pytest.raises(InputError, match=message):
        run(load(file))
    checked = call("check", file)  # what a run refuses, a check refuses
    assert checked.exit_code == 2
    assert re.search(message, checked.stderr.replace("\n", " "))


def interrupted_on_the_way() -> None:
    """The signal of Ctrl-C comes to this process 0.1 s after the start of its run."""
    look, sent = Monitor.__call__, []

    def looking(self, t, q, q_t):
        if t > 0.1 and not sent:
            sent.append(t)
            signal.raise_signal(signal.SIGINT)
        return look(self, t, q, q_t)

    Monitor.__call__ = looking  # type: ignore[method-assign]


def test_ctrl_c_ends_a_run_with_130_and_everything_on_disk(tmp_path):
    file = tmp_path / "long.toml"
    keys = FAST | {"track.segments": [straight(4000.0)], "output.patches_at_m": [1.0]}
    file.write_text(load(SCENARIOS / "curve_r300.toml").with_values(keys).text)
    out = tmp_path / "out"
    ended = forked("run", file, "-o", out, "-q", "--no-pictures", first=interrupted_on_the_way)
    assert ended.returncode == 130, ended.stderr
    assert f"{file}: stopped: interrupted by the user at t = " in ended.stderr
    result = Result.load(out)
    assert result.status == "stopped"
    assert result.dataset.attrs["stop_cause"] == "interrupt"
    assert result.dataset["time"].values[-1] > 0.1


def test_a_full_disk_at_the_end_of_a_run_is_told_plainly(tmp_path, monkeypatch):
    file = tmp_path / "short.toml"
    keys = FAST | {"track.segments": [straight(3.0)], "output.patches_at_m": [1.0]}
    file.write_text(load(SCENARIOS / "curve_r300.toml").with_values(keys).text)
    sync = os.fsync

    def full(descriptor: int) -> None:
        if os.fstat(descriptor).st_size > 20_000:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    done = call("run", file, "-o", tmp_path / "out", "-q")
    assert done.exit_code == 1
    assert "result.nc: the disk is full (" in done.stderr
    assert "free some space or choose another directory" in done.stderr
    assert f"the run is safe in {tmp_path / 'out' / 'result.nc.part'}: go on with --resume" in done.stderr
    assert done.stderr.count("\n") == 1
    # nothing half-written, and the run itself is safe
    assert {path.name for path in (tmp_path / "out").iterdir()} == {".wrsim", "scenario.toml", "result.nc.part"}
    monkeypatch.undo()
    ok("run", file, "-o", tmp_path / "out", "-q", "--no-pictures", "--resume")
    assert Result.load(tmp_path / "out").status == "completed"


# What a whole vehicle's run tells of on the way: lifted wheels, stops at their end, derailment; its pictures.
CARBODY, FRONT_FRAME = 4, 5


def monitored() -> tuple[Monitor, np.ndarray, np.ndarray]:
    """A monitor, and the state of the coach standing on straight track."""
    setup = build(load(ROOT / "scenarios/manchester_r300.toml").with_values(SHORT))
    law = force_law(setup)
    q, q_t = design_state(law)
    q, q_t = lower_on_rails(law, q, q_t)
    monitor = Monitor(law, setup.plan.speed)
    assert monitor(0.0, q, q_t) is None
    assert monitor.events() == []
    return monitor, q, q_t


def test_a_bump_stop_beyond_its_table_is_an_event_with_time_and_place() -> None:
    monitor, q, q_t = monitored()
    q[6 * CARBODY + 2] += 0.07
    for i in range(3):
        assert monitor(0.1 + 0.005 * i, q, q_t) is None
    events = monitor.events()
    assert len(events) == 2  # both bogies have one
    event = events[0]
    assert (event.kind, event.part) == ("stop", "front.lateral stop")
    assert event.start == (0.1, pytest.approx(12.0, abs=1e-6))
    assert (
        event_words(event, monitor.law.vehicle)
        == "bump stop front.lateral stop is beyond the end of its table for 0.00 m, 10 ms"
    )


def test_a_lifted_wheel_is_an_event_and_a_longer_flight_a_derailment() -> None:
    monitor, q, q_t = monitored()
    q[0] += 3e-3
    assert monitor(0.1, q, q_t) is None
    assert [(e.kind, e.part, e.side) for e in monitor.events()] == [
        ("lift", "front.outer", "left"),
        ("lift", "front.outer", "right"),
    ]
    text = event_words(monitor.events()[0], monitor.law.vehicle)
    assert text.startswith("the left wheel of wheelset front.outer loses contact for ")
    moved = q.copy()
    moved[: 6 * 7].reshape(-1, 6)[:, 1] += 3.5
    reason = monitor(0.3, moved, q_t)
    assert reason is not None
    assert reason.startswith(
        "derailed: the left wheel of wheelset front.outer has had no contact with its rail for 3.50 m"
    )


def test_a_flange_over_its_rail_is_a_derailment() -> None:
    monitor, q, q_t = monitored()
    q[0] += 0.03
    q[2] += 0.06
    reason = monitor(0.1, q, q_t)
    assert reason is not None
    assert "of wheelset front.outer has climbed over its rail" in reason
    off = monitor.look(0.1, q, q_t)
    assert off is not None and off.kind == "derailed" and off.message in reason


def test_a_strike_that_the_step_does_not_resolve_is_an_event_with_the_step_that_does() -> None:
    monitor, _, _ = monitored()
    load_of_wheel = 0.5 * monitor.law.vehicle.weight / len(monitor.law.vehicle.wheelsets)
    force = monitor.wheels[0].model.arrays.total
    for k, times in enumerate((1.0, 1.0, 1.4, 1.0)):
        force["Fb"] = times * load_of_wheel
        monitor.step(0.002 * k, False)
    (event,) = monitor.events()
    assert (event.kind, event.part, event.side) == ("strike", "front.outer", "left")
    assert event.missed == pytest.approx((1.4 * load_of_wheel, STRIKE * 0.8 * load_of_wheel))
    assert event.step == 500e-6  # 2 ms times the root of 0.05 / 0.209 is 978 us
    assert "run.step_us = 500 resolves them" in event_words(event, monitor.law.vehicle)
    force["Fb"] = load_of_wheel
    calm, _, _ = monitored()
    for k in range(6):
        calm.wheels[0].model.arrays.total["Fb"] = (1.0 + 0.03 * k) * load_of_wheel  # rises evenly
        calm.step(0.002 * k, False)
    assert calm.events() == []


@pytest.mark.parametrize("phase", [0.3, 0.6])
def test_the_error_of_a_peak_is_that_part_of_the_second_difference(phase: float) -> None:
    """A body strikes a spring, integrated by generalised alpha with steps of a phase w h; exact: A sin(w t)."""
    w, mass = 700.0, 1500.0

    def spring(t: float, q: np.ndarray, q_t: np.ndarray, out: np.ndarray) -> None:
        out.fill(0.0)
        out[2] = -mass * w**2 * q[2]

    system = BodySystem([Solid(mass, (900.0, 100.0, 900.0))], spring)
    start, rate = np.zeros(6), np.zeros(6)
    rate[2] = 0.1
    motion = Integration(system, duration=np.pi / w, step=phase / w, weight=1.0).run(start, rate)
    force = mass * w**2 * motion.q[:, 2]
    exact = mass * w * rate[2] * np.sin(w * motion.times)
    bend = np.abs(np.diff(force, 2)).max()
    assert np.abs(force - exact).max() == pytest.approx(STRIKE * bend, rel=0.25)


# Whatever the kernels have to say of a contact, every analysis that can meet it says.
KERNEL_BITS = {name: bit for name, bit in vars(records).items() if name.startswith("STATUS_")}
COARSE = {"contact.normal": "kik-piotrowski", "contact.strips": 12, "contact.cells": 4}
OVERLAP = "overlap by"


def scenario(name: str, **values: object) -> Scenario:
    keys = {key.replace("__", "."): value for key, value in values.items()}
    return load(SCENARIOS / name).with_values(COARSE | keys)


def wheelset(name: str, **values: object) -> Scenario:
    return scenario(name, vehicle__model=STEERING, **values)


@cache
def solved() -> Result:
    return run(poses())


def poses() -> Scenario:
    return scenario("static_s1002.toml", static__lateral_mm=0.0)


def remarks(result: Result) -> str:
    return " ".join(result.summary().get("remarks", {}).values())


def messages(result: Result) -> str:
    return " ".join(map(str, result.dataset["pose_message"].values)) + remarks(result)


def events(result: Result) -> str:
    stop = result.stop_reason or ""
    return stop + " ".join(event["event"] for event in result.summary().get("events", []))


def report(monkeypatch: pytest.MonkeyPatch, status: int) -> None:
    """From now on all contacts report this status; the compiled look at all of them at once does not see it."""
    monkeypatch.setattr(KernelArrays, "status", property(lambda self: status))
    look = monitors.kernel.look
    monkeypatch.setattr(monitors.kernel, "look", lambda *arguments: look(*arguments) | monitors.kernel.WHEELS)


ANALYSES: dict[str, Callable[[], str]] = {
    "static": lambda: messages(run(poses())),
    "equilibrium": lambda: events(run(scenario("equilibrium_s1002.toml"))),
    "curving": lambda: events(run(wheelset("curve_r300.toml", run__distance_m=1.0, output__patches_at_m=[]))),
    "steady": lambda: messages(run(wheelset("steady_manchester.toml", steady__radius_m=600, steady__speed_kmh=80))),
    "stability": lambda: remarks(run(wheelset("stability_manchester.toml", stability__speed_kmh=60,
     stability__nonlinear=False))),
    "resolve": lambda: remarks(resolve_contacts(solved(), poses(), "kik-piotrowski")),
    "compare": lambda: " ".join(comparison_report(compare_models(wheelset("curve_r300.toml", run__distance_m=0.5,
     output__patches_at_m=[]), ["kik-piotrowski", "kik-piotrowski+polach"]),
     "curve")["models"]["kik-piotrowski"]["remarks"]),
}  # fmt: skip


def test_every_bit_of_the_kernels_has_words() -> None:
    assert set(KERNEL_BITS.values()) <= set(WORDS)
    assert all(bit.bit_count() == 1 for bit in WORDS)
    assert len(KERNEL_BITS) == len(set(KERNEL_BITS.values()))


@pytest.mark.parametrize("name", ANALYSES)
def test_what_a_contact_has_to_say_is_said(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    solved()
    status = sum(KERNEL_BITS.values()) - STATUS_TOO_DEEP + NOT_CONVERGED
    if name == "static":  # no solution of a pose
        status &= ~(STATUS_NOT_CONVERGED | STATUS_LOAD_UNSOLVED)
    report(monkeypatch, status)
    said = ANALYSES[name]()
    assert [text for bit, text in WORDS.items() if bit & status and text not in said] == [], said


FLAT = {"kind": "flat", "wheel": "left", "shape": "fresh", "length_mm": 40, "edge_mm": 12, "at_deg": 5.0}


def test_a_run_tells_that_a_flat_rests_on_both_edges_between_two_looks() -> None:
    """Over 5 mrad, which take 0.14 ms; the looks are 5 ms apart."""
    result = run(scenario("flat.toml", run__time_s=0.008, vehicle__out_of_round=[FLAT]))
    assert WORDS[STATUS_LEFT_OUT] in events(result)
    assert WORDS[STATUS_LEFT_OUT] not in events(run(scenario("flat.toml", run__time_s=0.004)))


def test_a_pose_on_both_edges_of_a_flat_is_left_to_the_half_space_solver() -> None:
    static = {"side": "left", "lateral_mm": 0.0, "yaw_mrad": 0.0, "wheel_angle_deg": [4.9, 5.0, 7.0]}
    keys = {f"static.{key}": value for key, value in static.items()} | {"contact.normal": "strips"}
    result = run(load(SCENARIOS / "static_s1002.toml").with_values(keys | {"vehicle.out_of_round": [FLAT]}))
    assert not any(result.dataset["pose_message"].values)
    assert [WORDS[SUBSTITUTED] in text for text in result.dataset["contact_remark"].values] == [True, True, False]
    assert np.allclose(result.dataset["Q"].values, 60e3, rtol=1e-3)


@pytest.mark.parametrize("name", ANALYSES)
def test_an_overlap_ends_a_run_and_is_no_steady_motion(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    solved()
    report(monkeypatch, STATUS_TOO_DEEP)
    try:
        said = ANALYSES[name]()
    except SimulationError as refused:
        said = str(refused)
    assert OVERLAP in said


@pytest.mark.parametrize("name", ANALYSES)
def test_where_all_is_well_nothing_is_said(name: str) -> None:
    assert ANALYSES[name]().strip() == ""


def watch() -> tuple[Monitor, Work, np.ndarray, np.ndarray]:
    """A monitor of a wheelset on straight track, the work it looks at, and the state."""
    setup = build(wheelset("curve_r300.toml"))
    law, work = force_law(setup), Work()
    return Monitor(law, setup.plan.speed, work), work, *lower_on_rails(law, *design_state(law))


def test_a_contact_s_event_says_where_and_how_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monitor, _, q, q_t = watch()
    monitor(0.0, q, q_t)
    report(monkeypatch, STATUS_PROFILE_END | STATUS_NOT_CONVERGED)
    for t in (0.1, 0.105):
        q[1] += 0.1
        monitor(t, q, q_t)
    texts = [event_words(event, monitor.law.vehicle) for event in monitor.events()]
    (at_end,) = (text for text in texts if text.startswith(f"the left wheel: {WORDS[STATUS_PROFILE_END]}"))
    assert ", for 0.10 m, 5 ms: the outer end of profile " in at_end
    assert f"the right wheel: {WORDS[STATUS_NOT_CONVERGED]}, for 0.10 m, 5 ms" in texts
    monitor.watched["steps"], monitor.watched["substitutes"] = 40, 3
    texts = [event_words(event, monitor.law.vehicle) for event in monitor.events()]
    assert any(text.endswith(", for 0.10 m, 5 ms (in all 3 evaluations in 40 steps)") for text in texts)
    assert list(monitor.statuses) == [STATUS_PROFILE_END | STATUS_NOT_CONVERGED] * 2


def test_steps_that_are_cut_are_an_event_and_told_at_once_when_there_are_many(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("WARNING", "wrsim")  # a command with --quiet before this test has set it higher
    monitor, work, q, q_t = watch()
    for i in range(MANY + 3):
        work.cut_steps += i > 0
        q[1] += 0.01
        monitor(0.005 * i, q, q_t)
        assert len(caplog.records) == (i >= MANY)
    assert "cut again and again since t = 0.005 s, 0.02 m along the track" in caplog.text
    assert monitors.log.name in caplog.text
    (event,) = monitor.events()
    text = event_words(event, monitor.law.vehicle)
    assert text == f"time steps that Newton's method did not solve were subdivided for 0.21 m, {5 * (MANY + 1)} ms"
    restored, *_ = watch()
    restored.set_state(monitor.get_state())
    assert (restored.events(), restored.cut_steps) == (monitor.events(), MANY + 2)


def test_a_wheel_that_leaves_the_end_of_a_rail_profile_names_profile_and_end(tmp_path) -> None:
    """60E1 without its field side from 4 mm inside of the middle of the head on."""
    y, z = load_profile("rails/60E1.toml").at(np.linspace(0.0, load_profile("rails/60E1.toml").length, 1000))
    rows = "\n".join(f"{1e3 * a:.9f} {1e3 * b:.9f}" for a, b in zip(y, z, strict=True) if a < -4e-3)
    (tmp_path / "short.txt").write_text(rows)
    head = 'name = "short"\nbody = "rail"\nkind = "points"\ndate = 2026-11-27\nsource = "cut"\nfile = "short.txt"\n'
    (tmp_path / "short.toml").write_text(head + 'unit = "mm"\nheights = "up"\nfield_side = "positive"\n')
    result = run(wheelset("curve_r300.toml", track__rail=str(tmp_path / "short.toml"), run__distance_m=60))
    where = "the outer end of profile 'short' (u = -4 mm)"
    assert any(
        WORDS[STATUS_PROFILE_END] in entry["event"] and where in entry["event"] for entry in result.summary()["events"]
    )
    assert result.status == "stopped" and where in result.stop_reason
