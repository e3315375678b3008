"""What a whole vehicle's run tells of on the way: lifted wheels, stops at their end, derailment; its pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.vehicles import ROOT, SHORT, into_the_curve

from wrsim.analysis.motion.vehicle_start import vehicle_law
from wrsim.analysis.motion.vehicle_watch import VehicleWatch
from wrsim.plots import standard_figures
from wrsim.plots.style import save
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.vehicle_state import design_state, lower_on_rails

CARBODY, FRONT_FRAME = 4, 5


def watched() -> tuple[VehicleWatch, np.ndarray, np.ndarray]:
    """A watch, and the state of the coach standing on straight track."""
    setup = build(load(ROOT / "scenarios/manchester_r300.toml").with_values(SHORT))
    law = vehicle_law(setup)
    q, q_t = design_state(law, 12.0)
    lower_on_rails(law, q, q_t)
    watch = VehicleWatch(setup, law)
    assert watch(0.0, q, q_t) is None
    assert watch.events() == []
    return watch, q, q_t


def test_a_bump_stop_beyond_its_table_is_an_event_with_time_and_place() -> None:
    watch, q, q_t = watched()
    q[6 * CARBODY + 2] += 0.07
    for i in range(3):
        assert watch(0.1 + 0.005 * i, q, q_t) is None
    events = watch.events()
    assert len(events) == 2  # both bogies have one
    time, distance, words = events[0]
    assert time == 0.1
    assert abs(distance - 12.0) < 1e-6
    assert words == "bump stop front.lateral stop is beyond the end of its table for 0.00 m, 10 ms"


def test_a_lifted_wheel_is_an_event_and_a_longer_flight_a_derailment() -> None:
    watch, q, q_t = watched()
    q[0] += 3e-3
    assert watch(0.1, q, q_t) is None
    assert [words[:45] for _, _, words in watch.events()] == [
        "the left wheel of wheelset front.outer is lif",
        "the right wheel of wheelset front.outer is li",
    ]
    moved = q.copy()
    moved[: 6 * 7].reshape(-1, 6)[:, 1] += 3.5
    reason = watch(0.3, moved, q_t)
    assert reason is not None
    assert reason.startswith(
        "derailed: the left wheel of wheelset front.outer has had no contact with its rail for 3.50 m"
    )


def test_a_flange_over_its_rail_is_a_derailment() -> None:
    watch, q, q_t = watched()
    q[0] += 0.03
    q[2] += 0.06
    reason = watch(0.1, q, q_t)
    assert reason is not None
    assert "of wheelset front.outer has climbed over its rail" in reason


def test_a_watch_that_recalls_its_memory_goes_on_where_it_was() -> None:
    watch, q, q_t = watched()
    q[6 * CARBODY + 2] += 0.07
    watch(0.1, q, q_t)
    other, _, _ = watched()
    other.recall(watch.memory())
    assert other.events() == watch.events()
    for each in (watch, other):
        each(0.105, q, q_t)
    assert other.events() == watch.events()
    assert np.array_equal(other.memory(), watch.memory())


def test_a_vehicle_gets_pictures_of_its_own_and_those_of_its_worst_wheelset(tmp_path: Path) -> None:
    figures = standard_figures(into_the_curve().dataset)
    assert {"vehicle_guiding", "vehicle_steering", "vehicle_bodies", "vehicle_accelerations"} < set(figures)
    assert {"front.outer_overview", "front.outer_patches"} < set(figures)
    picture = save(figures["vehicle_steering"](), tmp_path / "steering.png")
    assert picture.stat().st_size > 10_000
