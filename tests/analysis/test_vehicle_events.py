"""What a whole vehicle's run tells of on the way: lifted wheels, stops at their end, derailment; its pictures."""

import numpy as np
import pytest
from support.vehicles import ROOT, SHORT

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.messages import event_words
from wrsim.analysis.motion.monitor import STRIKE, Monitor
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails
from wrsim.simulation.system import BodySystem

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
    words = event_words(monitor.events()[0], monitor.law.vehicle)
    assert words.startswith("the left wheel of wheelset front.outer is lifted for ")
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
    assert off is not None and off.kind == "derailed" and off.words in reason


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
