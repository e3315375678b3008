"""Steady curving against time integration, closed forms and symmetry."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.runs import FAST, SCENARIOS, STEERING

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.steady import cant_deficiency, steady_in_curve
from wrsim.errors import InputError
from wrsim.geometry.track.segments import Arc
from wrsim.results import Result
from wrsim.results.tables import tables
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.steady import SteadyPoint
from wrsim.simulation.integrate import Integration
from wrsim.simulation.placement import poses_on_track
from wrsim.simulation.steady_state import TOLERANCE
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.wheelset import STANDARD_GRAVITY


def manchester(**values) -> Scenario:
    """The shipped scenario with some keys of [steady] changed, coarse patches."""
    keys = {f"steady.{key}": value for key, value in values.items()}
    return load(SCENARIOS / "steady_manchester.toml").with_values(FAST | keys)


@cache
def curves() -> Result:
    """Two hands, and a curve that no coach runs through at that speed."""
    return run(manchester(combine="rows", radius_m=[600, -600, 150], cant_mm=[100, 100, 0], speed_kmh=[60, 60, 150]))


def wheel_state(law, q, q_t):
    """Y, Q (wheelsets, 2), shift and angle of attack (wheelsets,) at a state."""
    law(0.0, q, q_t, np.zeros(law.size))
    total = np.array([[wheel.model.arrays.force[1:] for wheel in pair] for pair in law.wheels])
    poses = [
        poses_on_track(law.track.centre, q[None, 6 * w : 6 * w + 6], q_t[None, 6 * w : 6 * w + 6], law.start + m.x)
        for w, m in enumerate(law.vehicle.wheelsets)
    ]
    return -total[..., 0], total[..., 1], *(np.array([getattr(p, n)[0] for p in poses]) for n in ("lateral", "yaw"))


@pytest.mark.parametrize(
    ("model", "duration"),
    [(STEERING, 2.0), pytest.param("vehicles/manchester_1.toml", 6.0, marks=pytest.mark.campaign)],
)
def test_steady_motion_is_where_a_long_time_integration_ends(model, duration):
    setup = build(manchester(radius_m=450, speed_kmh=70).with_values({"vehicle.model": model}))
    found = steady_in_curve(setup, setup.plan.points[0])
    assert found.left < TOLERANCE
    expected = wheel_state(found.law, found.q, found.q_t)
    # on a longer arc, disturbed, and left to itself for several swings of the car body
    start = found.law.start
    track = setup.track.relaid([Arc(260.0, 450.0, 0.1)])
    law = force_law(replace(setup, track=track, plan=RunPlan(start, start, found.law.speed)))
    q = found.q.copy()
    q[2 : 6 * len(law.bodies) : 6] += 1e-3
    motion = Integration(BodySystem(law.bodies, law), duration=duration, step=1e-3, sample_interval=0.5).run(
        q, found.q_t
    )
    assert motion.status == "completed"
    law.start += law.speed * motion.end
    law.look_near(law.start)
    at_end = wheel_state(law, motion.q[-1], motion.q_t[-1])
    for name, before, after in zip(("Y", "Q", "shift", "attack"), expected, at_end, strict=True):
        # the 1 %, of the vehicle's largest: some wheels have next to none
        assert np.abs(after - before).max() < 0.01 * np.abs(before).max(), name


def test_wheels_carry_the_weight_and_the_cant_deficiency():
    solved = curves().dataset.isel(pose=0)
    setup = build(manchester())
    vehicle, base = setup.vehicle, setup.track.cant_base
    speed, cant = 60.0 / 3.6, np.arcsin(0.1 / base)
    away = speed**2 / 600.0
    across, down = (
        away * np.cos(cant) - STANDARD_GRAVITY * np.sin(cant),
        STANDARD_GRAVITY * np.cos(cant) + away * np.sin(cant),
    )
    # bodies of a long vehicle lie along the chord, which takes some per mille of the share along the track
    assert solved["Q"].values.sum() == pytest.approx(vehicle.mass * down, rel=1e-3)
    right_less_left = solved["Y"].values[:, 1].sum() - solved["Y"].values[:, 0].sum()
    assert right_less_left == pytest.approx(vehicle.mass * across, abs=1e-3 * vehicle.mass * down)
    assert solved["cant_deficiency"].item() == pytest.approx(base * away / STANDARD_GRAVITY - 0.1)


def test_a_curve_to_the_right_is_the_mirror_image_of_one_to_the_left():
    left, right = curves().dataset.isel(pose=0), curves().dataset.isel(pose=1)
    assert left["Y"].values == pytest.approx(
        right["Y"].values[:, ::-1], abs=20.0
    )  # N of some 12 kN: patches are coarse
    assert left["lateral_shift"].values == pytest.approx(-right["lateral_shift"].values, abs=1e-5)
    assert left["Y_over_Q"].values[0, 1] > 0.15  # the leading outer wheel leans on its flange root


def test_a_curve_without_steady_motion_says_so_and_the_others_are_there():
    result = curves()
    messages = result.dataset["pose_message"].values
    assert list(messages[:2]) == ["", ""]
    assert "overturn" in messages[2] and "cant deficiency 1770 mm" in messages[2]
    assert np.isnan(result.dataset["Y"].values[2]).all()
    assert (result.dataset["unbalanced"].values[:2] < 1e-4).all()
    summary = result.summary()
    assert summary["extent"] == {"poses": 3, "solved": 2}
    assert list(summary["without_steady_motion"]) == [str(result.dataset["pose"].values[2])]


def test_its_tables_have_a_row_for_every_wheel_and_curve(tmp_path):
    result = curves()
    assert len(tables(result.dataset)["steady"]) == 1 + 2 * 8 + 1
    (steady,) = result.numbers()
    assert any(row[0] == "rear.inner left" for row in steady.rows) and "overturn" in " ".join(steady.notes)
    assert Result.load(result.save(tmp_path / "result.nc")).dataset.identical(result.dataset)


def test_an_interrupted_study_keeps_the_curves_it_has():
    def impatient(fraction: float, left: float) -> None:
        raise KeyboardInterrupt

    result = run(manchester(radius_m=[1500, 1200], speed_kmh=70), impatient)
    assert result.status == "stopped" and "after 1 of 2 curves" in result.stop_reason
    assert result.dataset.sizes["pose"] == 1


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"steady.combine": "rows", "steady.cant_mm": [0, 50]}, "must be equally many"),
        ({"contact.normal": "half-space"}, "is for poses, rest and runs"),
        ({"track.grades": [{"start_m": 0}]}, "lays its own track"),
    ],
)
def test_bad_input_is_answered_with_one_clear_line(values, message):
    with pytest.raises(InputError, match=message):
        build(load(SCENARIOS / "steady_manchester.toml").with_values(values))


def test_cant_is_missing_alike_in_curves_of_both_hands() -> None:
    points = [SteadyPoint("", radius, 0.1, 20.0) for radius in (300.0, -300.0)]
    expected = 1.5 * 20.0**2 / (STANDARD_GRAVITY * 300.0) - 0.1
    assert [cant_deficiency(point, 1.5) for point in points] == pytest.approx([expected] * 2)
