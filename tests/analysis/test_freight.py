"""The shipped freight wagon, empty and laden: loads by hand, friction at rest and in a curve, events."""

import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.runs import FAST, SCENARIOS, arc, straight

from wrsim import Scenario, Straight, Track, Vehicle, load, run
from wrsim.analysis.motion.messages import event_words
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.stationary.statics import static_state
from wrsim.plots.histories import vehicle_figures
from wrsim.scenario.build import build
from wrsim.simulation import integrate
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.vehicle.loads import Load
from wrsim.vehicle.preload import preloads

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
        f"{bogie}.{slider} {to} {side}"
        for bogie in ("front", "rear")
        for slider in ("guide", "pusher")
        for to in ("outer", "inner")
        for side in ("left", "right")
    }
    assert "nothing presses friction" in event_words(monitor.events()[0], vehicle)


# Loads at rest, in runs, in steady motion and in stability: balances of forces and moments, a gust, resuming.
BODIES = {"carbody": 32000.0, "front.frame": 2615.0, "rear.frame": 2615.0}
AXLE, HEIGHT, GRAVITY = 1813.0, 2.2, 9.80665


def wind(**force: Any) -> list[dict[str, Any]]:
    """Wind on the coach."""
    return [{"name": "wind", "on": "carbody", "at_mm": [0, 0, 1e3 * HEIGHT], "axes": "track"} | force]


ROWS = [[22, 0, 0, 0], [24, 0, 30, 0], [32, 0, 30, 0], [35, 0, 0, 0]]

START = FAST | {"run.start_distance_m": 20.0, "output.patches_at_m": []}


def gusty() -> Scenario:
    """The coach through a gust on straight track."""
    keys = {"vehicle.speed_kmh": 120.0, "vehicle.loads": wind(distance_m_force_kN=ROWS)}
    keys |= {"track.segments": [straight(90.0)], "run.distance_m": 20.0, "run.output_interval_ms": 4.0}
    return load(SCENARIOS / "manchester_r300.toml").with_values(START | keys)


@pytest.fixture(scope="module")
def gust(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, Path]]:
    """The run, and the file of one that was stopped on the way by Ctrl-C."""
    file = tmp_path_factory.mktemp("gust") / "run.part"
    asked = []

    def progress(fraction: float, left: float) -> None:
        if fraction > 0.3 and not asked:
            asked.append(fraction)
            signal.raise_signal(signal.SIGINT)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(integrate, "PROGRESS_INTERVAL", 0.0)  # a fast machine is through before the first report else
        stopped = run(gusty(), progress, record=file)
    assert (stopped.status, stopped.dataset.attrs["stop_cause"]) == ("stopped", "interrupt")
    yield run(gusty()).dataset, file


def test_a_gust_acts_where_its_table_says_by_its_impulse(gust: tuple[Any, Path]) -> None:
    d = gust[0]
    assert d.attrs["status"] == "completed"
    expected = 1e3 * np.interp(d.distance.values, *np.transpose(ROWS)[[0, 2]])
    # the point lies over the reference body, whose tilt and pitch move it by some 10 um along the track
    assert d.external_fy.values[:, 0] == pytest.approx(expected, abs=1.0)
    assert float(d.external_fy.max()) == pytest.approx(30e3, rel=1e-12)
    d = gust[0]
    times = d.time.values
    momentum = sum(m * np.gradient(d.body_lateral.sel(body=name).values, times) for name, m in BODIES.items())
    momentum = momentum + AXLE * np.gradient(d.lateral_shift.sum(dim="wheelset").values, times)
    y = d.Y.transpose("time", "wheelset", "wheel").values
    force = d.external_fy.values[:, 0] - (y[:, :, 0] - y[:, :, 1]).sum(axis=1)
    steps = np.diff(times)
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * steps)])
    assert np.abs(momentum).max() > 3e3
    assert momentum[2:-2] == pytest.approx(impulse[2:-2], abs=0.01 * np.abs(momentum).max())


def test_a_run_through_a_gust_goes_on_with_the_same_numbers(gust: tuple[Any, Path]) -> None:
    d, file = gust
    again = run(gusty(), record=file, resume=True).dataset
    assert again.identical(d)
    assert vehicle_figures(again)["vehicle_external_loads"]().axes


def test_a_run_starts_from_the_motion_that_belongs_to_the_load() -> None:
    speed, segment = 70.0, arc(80.0, 600.0, 60.0)
    keys = {"vehicle.speed_kmh": speed, "vehicle.loads": wind(force_kN=[0, -20, 0]), "run.distance_m": 2.0}
    scenario = load(SCENARIOS / "manchester_r300.toml")
    d = run(scenario.with_values(START | keys | {"track.segments": [segment]})).dataset
    y = d.Y.transpose("time", "wheelset", "wheel").values
    net = (y[:, :, 0] - y[:, :, 1]).sum(axis=1)
    curvature, tilt = d.curvature.values[0, 0], np.arcsin(d.cant.values[0, 0] / 1.5)
    mass = sum(BODIES.values()) + 4 * AXLE
    outward = mass * ((speed / 3.6) ** 2 * curvature * np.cos(tilt) - GRAVITY * np.sin(tilt))
    assert net == pytest.approx(-20e3 - outward, rel=0.01)
    assert d.body_lateral.values == pytest.approx(d.body_lateral.values[:1].repeat(len(net), axis=0), abs=2e-4)
    assert d.Q.values == pytest.approx(d.Q.values[:1].repeat(len(net), axis=0), rel=0.02)
