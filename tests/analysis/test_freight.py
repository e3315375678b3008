"""The shipped freight wagon, empty and laden: loads by hand, friction at rest and in a curve, events."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.runs import SCENARIOS

from wrsim.analysis import run
from wrsim.analysis.motion.messages import event_words
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.stationary.statics import static_state
from wrsim.geometry.track.segments import Straight
from wrsim.geometry.track.track import Track
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.vehicle.loads import Load
from wrsim.vehicle.preload import preloads
from wrsim.vehicle.vehicle import Vehicle

G = 9.80665
TARE, COAL, WHEELSET, FRAME = 22e3, 68e3, 1300.0, 2100.0
FRICTION = 0.3 * 0.364  # of a box's guide over the force of its spring
QUICK = {"contact.normal": "kik-piotrowski", "contact.strips": 15, "contact.cells": 8}


def wagon(name: str = "freight_r300") -> Vehicle:
    return build(load(SCENARIOS / f"{name}.toml")).vehicle


def spring_line(force: float) -> float:
    """How far a box's springs are compressed by a force [N]."""
    return min(force, 33e3) / 1e6 + max(0.0, force - 33e3) / 2.6e6


@pytest.mark.parametrize("name,mass", [("freight_r300", TARE), ("freight_r300_laden", TARE + COAL)])
def test_wheel_loads_and_springs_carry_the_weight(name: str, mass: float) -> None:
    vehicle = wagon(name)
    np.testing.assert_allclose(static_state(vehicle).wheel_loads, mass * G / 8.0, rtol=1e-9)
    at_rest = dict(zip((e.name for e in vehicle.elements), preloads(vehicle), strict=True))
    box = (mass - 4.0 * WHEELSET) * G / 8.0
    assert at_rest["front.primary outer left"].force[0] == pytest.approx(-box, rel=1e-9)
    bearer, pivot = at_rest["front.side bearer left"].force[2], at_rest["front.pivot"].force[2]
    assert bearer == pytest.approx(14e3)
    assert pivot == pytest.approx((mass - 4.0 * WHEELSET - 2.0 * FRAME) * G / 2.0 - 28e3, rel=1e-9)


def test_under_its_load_the_empty_wagon_sinks_onto_its_inner_springs_and_its_guides_carry_a_share() -> None:
    """On the way down friction pushes up with mu tan(20 deg) times the spring's force."""
    vehicle = wagon()
    coal = Load.constant("coal", "carbody", (0.0, 0.0, -COAL * G), (0.0, 0.0, 1.95))
    down = static_state(replace(vehicle, loads=(coal,))).moved[vehicle.names.index("front.frame") - 4, 1]
    empty, laden = ((mass - 4.0 * WHEELSET) * G / 8.0 for mass in (TARE, TARE + COAL))
    expected = spring_line(laden / (1.0 + FRICTION)) - spring_line(empty)
    assert -down == pytest.approx(expected, abs=2e-5)  # and the supports give way by micrometres


@pytest.fixture(scope="module")
def curve() -> Any:
    """The laden wagon into the curve."""
    return run(load(SCENARIOS / "freight_r300_laden.toml").with_values(QUICK | {"run.distance_m": 60})).dataset


def channel(dataset: Any, axis: str, name: str, place: str = "f") -> Any:
    values = dataset[f"suspension_{place}{axis}"]
    return values.values[:, list(dataset[values.dims[1]].values).index(name)]


def test_in_a_curve_friction_stays_within_its_bounds_and_takes_work(curve: Any) -> None:
    assert curve.attrs["cut_steps"] == 0
    for to in ("outer", "inner"):
        for side in ("left", "right"):
            spring = -channel(curve, "z", f"front.primary {to} {side}")
            guide = [channel(curve, axis, f"front.guide {to} {side}") for axis in "yz"]
            travel = [channel(curve, axis, f"front.guide {to} {side}", "d") for axis in "yz"]
            assert (np.hypot(*guide) <= FRICTION * spring * (1.0 + 1e-9)).all()
            work = -sum(
                np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(d)) for f, d in zip(guide, travel, strict=True)
            )  # what the spring of the slider holds at the end is a part of it
            assert work > 0.0
            pusher = channel(curve, "x", f"front.pusher {to} {side}")
            assert (np.abs(pusher) <= 0.182 * spring * (1.0 + 1e-9)).all()
    assert np.abs(channel(curve, "x", "front.pusher outer left")).max() > 10e3


def test_the_bogie_turns_against_its_friction(curve: Any) -> None:
    """The bearers slide 0.85 m times the bogie's angle, half of the pivots' distance over the radius."""
    for side, sign in (("left", 1.0), ("right", -1.0)):
        slid = channel(curve, "x", f"front.bearer friction {side}", "d")[-1]
        assert sign * slid == pytest.approx(0.85 * 4.5 / 300.0, rel=0.15)  # the wheelsets stand askew in their gauge
        pull = np.hypot(*(channel(curve, axis, f"front.bearer friction {side}") for axis in "xy"))
        part = pull / (0.3 * channel(curve, "z", f"front.side bearer {side}"))
        assert 0.99 < part.max() <= 1.0 + 1e-9


def test_a_wagon_that_lifts_off_its_springs_says_that_nothing_presses_its_guides() -> None:
    """A pull of the weight of all that stands on the springs."""
    vehicle = wagon()
    law = VehicleOnTrack(vehicle, Track.build([Straight(200.0)], 1.5), (), speed=10.0, start=100.0)
    monitor = Monitor(law, 10.0)
    q, q_t = design_state(law)
    assert monitor.look(0.0, q, q_t) is None and monitor.events() == []
    q[6 * 4 : 6 * len(law.bodies) : 6] += 0.03  # springs are compressed by 20.6 mm
    monitor.look(0.1, q, q_t)
    loose = {event.part for event in monitor.events() if event.kind == "loose"}
    assert loose == {
        f"{bogie}.{what} {to} {side}"
        for bogie in ("front", "rear")
        for what in ("guide", "pusher")
        for to in ("outer", "inner")
        for side in ("left", "right")
    }
    assert "nothing presses friction" in event_words(monitor.events()[0], vehicle)
