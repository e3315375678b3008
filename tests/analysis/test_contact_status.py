"""Whatever the kernels have to say of a contact, every analysis that can meet it says."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from support.runs import SCENARIOS, STEERING

from wrsim.analysis import run
from wrsim.analysis.compare import compare_models, comparison_report
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion import monitor as monitors
from wrsim.analysis.motion.messages import event_words
from wrsim.analysis.motion.monitor import MANY, Monitor
from wrsim.analysis.resolve import resolve_contacts
from wrsim.contact.status import NOT_CONVERGED, WORDS
from wrsim.contact.workspace import KernelArrays
from wrsim.core.contact import records
from wrsim.core.contact.records import STATUS_NOT_CONVERGED, STATUS_PROFILE_END, STATUS_TOO_DEEP
from wrsim.errors import SimulationError
from wrsim.results import Result
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails
from wrsim.simulation.system import Work

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
    monkeypatch.setattr(monitors.kernel, "all_on_rails", lambda *arrays: False)


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
    report(monkeypatch, status)
    said = ANALYSES[name]()
    assert [words for bit, words in WORDS.items() if bit & status and words not in said] == [], said


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
    words = [event_words(event, monitor.law.vehicle) for event in monitor.events()]
    assert f"the left wheel: {WORDS[STATUS_PROFILE_END]}, for 0.10 m, 5 ms" in words
    assert f"the right wheel: {WORDS[STATUS_NOT_CONVERGED]}, for 0.10 m, 5 ms" in words
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
    words = event_words(event, monitor.law.vehicle)
    assert words == f"time steps that Newton's method did not solve were cut into parts for 0.21 m, {5 * (MANY + 1)} ms"
    other, *_ = watch()
    other.set_state(monitor.get_state())
    assert (other.events(), other.cut_steps) == (monitor.events(), MANY + 2)
