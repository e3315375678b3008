"""Stationary tests of EN 14363: loops on twisted track and on a turntable against moments by hand."""

import json
from dataclasses import replace
from math import asin, radians

import numpy as np
import pytest
from support.commands import call
from support.rows import rows_of
from support.vehicles import manchester, on_track, shipped

from wrsim import InputError, Vehicle
from wrsim.analysis.stationary import loops
from wrsim.analysis.stationary.at_rest import tables_at_rest
from wrsim.vehicle.bogies import bogies_of
from wrsim.vehicle.elements import Slider, Strut

table = rows_of(__file__)

SLOW, FAST = loops.RATES


@pytest.fixture(autouse=True)
def few_steps(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """What holds at the ends and in the middle of a way does not depend on how many steps lie between."""
    if request.node.get_closest_marker("campaign") is None:
        monkeypatch.setattr(loops, "TWIST_STEPS", 4)
        monkeypatch.setattr(loops, "ROTATION_STEPS", 4)


def with_struts(kind: str, places: list[tuple[str, str, tuple[float, float, float]]], **keys: object) -> Vehicle:
    """The coach with one more strut at each place (first body, second body, point)."""
    struts = (
        Strut(f"more {i}", kind, first, second, (point, point), **keys)
        for i, (first, second, point) in enumerate(places)
    )
    return replace(manchester(), elements=(*manchester().elements, *struts))


def test_the_twists_of_the_standard_join_where_their_formulas_meet():
    for length in (4.0, 20.0, 30.0):
        assert loops.lone_twist(length) == pytest.approx(loops.lone_twist(length * (1 + 1e-9)), rel=1e-6)
    assert loops.body_twist(3.0) == pytest.approx(7e-3) and loops.body_twist(1.0) == pytest.approx(7e-3)
    # together under the whole length: 2 per mille and 20 mm less what the bogie has of its own
    assert 19.0 * loops.body_twist(19.0) == pytest.approx(15e-3 + 2e-3 * 19.0)
    assert 2.56 * loops.bogie_twist(2.56) == pytest.approx(7e-3 * 2.56 - 5e-3)


def test_twisted_bogies_unload_wheels_by_the_roll_stiffness_of_their_axles():
    # primary springs of 1220 kN/m, 1 m to either side; each axle rolls against a level frame, wheels 1.5 m apart
    twisted = loops.twist_test(manchester(), 0.0, 5e-3)
    force = 2.0 * 1220e3 * 1.0**2 * (5e-3 * 1.28 / 1.5) / 1.5
    assert twisted.unloading == pytest.approx(force / twisted.static, rel=2e-3)
    assert twisted.friction == pytest.approx(0.0, abs=1e-9)


def test_a_twisted_body_unloads_wheels_by_both_stages_in_series():
    # of a bogie: 4 primary springs; 2 secondary springs that also bend, and an anti-roll bar. The body yaws until
    # nothing pushes sideways: its load leans by half of the roll of the columns, and half of load over shear stiffness
    twisted = loops.twist_test(manchester(), 4e-3, 0.0)
    load = 16e3 * 9.80665
    aside = 0.525 - 0.46 + 0.5 * 0.605 + 0.5 * load / (2.0 * 160e3)
    primary, secondary = 4.0 * 1220e3, 2.0 * 430e3 + 2.0 * 10.5e3 + 940e3 - load * aside
    moment = 4e-3 * 9.5 / 1.5 / (1.0 / primary + 1.0 / secondary)
    # the frames yaw a little, too, which shifts load from one of their axles to the other
    by_bogie = (twisted.unloading * twisted.static).reshape(2, 2, 2).mean(axis=1)
    assert by_bogie == pytest.approx(moment / 2.0 / 1.5, rel=0.01)


def test_friction_in_a_box_opens_the_loop_by_its_force():
    force = 2e3
    places = [
        (f"{end}.frame", m.name, (m.x, y, m.height))
        for m in manchester().wheelsets
        for end in (m.name.split(".")[0],)
        for y in (1.0, -1.0)
    ]
    vehicle = with_struts("friction", places, axis=2, slider=Slider("coulomb", 8e6, force))
    rubbing, free = (loops.twist_test(v, 0.0, 5e-3) for v in (vehicle, manchester()))
    assert rubbing.static == pytest.approx(free.static, rel=1e-6)
    # two faces 1 m from the middle against wheels 0.75 m from it; what slides at the end of the twist, too
    assert rubbing.friction == pytest.approx(2.0 * force / 1.5 / free.static, rel=1e-3)
    assert rubbing.unloading - free.unloading == pytest.approx(rubbing.friction, rel=1e-3)
    # the loop is closed, and its first way lies within it
    closed = rubbing.wheel_loads[loops.TWIST_STEPS :]
    assert closed[0] == pytest.approx(closed[-1], abs=1.0)
    assert (rubbing.wheel_loads[: loops.TWIST_STEPS] >= closed.min(axis=0) - 1.0).all()


OWN = 2.0 * 160e3 * 1.0**2
"""Yaw stiffness of the coach's secondary springs [N m/rad]: of 160 kN/m, 1 m to either side."""
GIVING = OWN / (4.0 * 160e3 * 9.5**2 + OWN) + OWN / (4.0 * (31391e3 * 1.0**2 + 3884e3 * 1.28**2))
"""What gives way beside them: the body, on the other bogie and lateral springs; the frame, in its primary springs."""


def test_springs_resist_by_the_sine_of_the_angle_in_series_with_what_holds_body_and_frame():
    radius = 20.0
    # springs alike along and across pull back to where they were: the couple of two of them is k b^2 sin(angle)
    turned = loops.rotation_test(manchester(), bogies_of(manchester())[0], 0.01 * SLOW, radius)
    moment = OWN * turned.angle
    for _ in range(20):
        moment = OWN * np.sin(turned.angle - moment / OWN * GIVING)
    assert turned.moment == pytest.approx(moment, abs=5e-4 * turned.largest)
    assert turned.angle.max() == pytest.approx(asin(9.5 / radius), rel=1e-9)
    assert turned.axle_load == pytest.approx(manchester().weight / 4.0, rel=1e-6)
    assert turned.factor == pytest.approx(moment.max() / (2.56 * manchester().weight / 4.0), rel=5e-4)


def test_yaw_dampers_resist_with_the_rate_of_the_turntable():
    c, b = 100e3, 1.2
    places = [("front.frame", "carbody", (9.5, y, 0.8)) for y in (b, -b)]
    vehicle = with_struts("damper", places, axis=0, damping=c, series_stiffness=5e6)
    slow, fast, free = (
        loops.rotation_test(v, bogies_of(v)[0], rate, 1500.0)
        for v, rate in ((vehicle, SLOW), (vehicle, FAST), (manchester(), 0.01 * SLOW))
    )
    damping = 2.0 * c * b**2 / (1.0 + GIVING) ** 2  # what gives way takes of the rate, and of the springs' angle
    assert fast.largest - slow.largest == pytest.approx(damping * radians(0.8), rel=2e-3)
    assert slow.largest - free.largest == pytest.approx(damping * radians(0.2), rel=5e-3)


def test_sliding_bearers_and_a_bowl_resist_by_friction_times_load_times_arm():
    turned = loops.rotation_test(shipped("freight_y25"), bogies_of(shipped("freight_y25"))[0], SLOW)
    bowl = 0.25 * 0.5 * (12600 * 9.80665 / 2.0 - 2 * 14e3) * 0.12
    bearers = 0.3 * 14e3 * 0.85
    assert turned.largest == pytest.approx(2.0 * (bowl + bearers), rel=1e-3)
    # Coulomb: it turns back with the same moment
    middle = turned.moment[np.abs(turned.angle) < 1e-9]
    assert np.abs(middle[1:]) == pytest.approx(turned.largest, rel=1e-3)


def test_an_axle_is_held_by_a_frame_and_not_by_its_own_bridge():
    vehicle = shipped("irw")
    assert [(b.frame, b.wheelsets) for b in bogies_of(vehicle)] == [("front.frame", (0, 1)), ("rear.frame", (2, 3))]
    law = on_track(vehicle).law
    assert list(law.axles["holder"]) == [vehicle.index(f"{end}.frame") for end in ("front", "front", "rear", "rear")]
    assert bogies_of(shipped("cooperrider_bogie")) == ()
    # the case of a gear sits on one axle only
    motors = bogies_of(shipped("manchester_motor"))
    assert [(b.frame, b.wheelsets) for b in motors] == [("front.bogie.frame", (0, 1)), ("rear.frame", (2, 3))]


def test_the_command_turns_both_bogies_and_draws_their_loops(tmp_path):
    picture = tmp_path / "loops.png"
    asked = "vehicle", "vehicles/manchester_1.toml", "--rotation-test", "--loops", str(picture)
    answer = json.loads(call(*asked, "--json").stdout)
    assert [t["bogie"] for t in answer["rotation_test"]] == ["front.frame"] * 2 + ["rear.frame"] * 2
    assert picture.stat().st_size > 10_000
    (table,) = (t for t in tables_at_rest(answer) if t.title.startswith("rotation test"))
    assert [row[-1] for row in table.rows] == [t["X"] for t in answer["rotation_test"]]


@pytest.mark.parametrize(("asked", "said"), table("options_without_their_test_are_refused"))
def test_options_without_their_test_are_refused(asked, said):
    told = call("vehicle", "vehicles/manchester_1.toml", *asked)
    assert told.exit_code != 0 and said in " ".join(told.output.split())


def test_a_vehicle_without_bogies_cannot_turn_them():
    with pytest.raises(InputError, match="has no bogies to turn"):
        loops.turning_bogies(shipped("cooperrider_bogie"))
    with pytest.raises(InputError, match="no wider than half of its pivots"):
        loops.rotation_test(manchester(), bogies_of(manchester())[0], SLOW, 9.0)
