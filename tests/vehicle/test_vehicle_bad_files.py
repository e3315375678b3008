"""Files of whole vehicles that cannot be used: one clear message each, with file, line, key and what was meant."""

from pathlib import Path

import pytest
from support.commands import call, ok
from support.vehicle_texts import GOOD, fault
from support.vehicles import ROOT, read_vehicle

from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load


def test_the_good_file_loads(tmp_path: Path) -> None:
    assert fault(tmp_path) == ""


def test_friction_takes_the_spring_on_its_own_side_that_leads_to_the_same_body(tmp_path: Path) -> None:
    assert fault(tmp_path, *guide()) == ""
    elements = read_vehicle(tmp_path / "car.toml").elements
    pressed = {e.name: e.slider.normal.of for e in elements if e.slider and e.slider.normal}
    assert pressed == {
        f"guide {to} {side}": f"primary {to} {side}" for to in ("front", "rear") for side in ("left", "right")
    }


LOOSE = "[bodies.box]\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\ncentre_mm = [0, 0, 0]\n"

PUSH = """\
[[loads]]
name = "push"
on = "body"
at_mm = [0, 0, 2000]
axes = "track"
force_kN = [0, 9, 0]
"""
BALLAST = """\
[[payloads]]
name = "coal"
on = "body"
at_mm = [0, 0, 900]
mass_kg = 4000
"""
ROWS = "time_s_force_kN = [[0, 0, 0, 0], [2, 0, 9, 0], [2, 0, 0, 0]]"

GUIDE = """\
[[elements]]
kind = "friction"
name = "guide"
body = "body"
to = ["front", "rear"]
origin = "to"
at_mm = [0, 900, 0]
both_sides = true
plane = "yz"
friction = 0.3
normal_spring = "primary"
stick_stiffness_kN_per_m = 5000
"""


def guide(*changes: tuple[str, str]) -> tuple[tuple[str, str], ...]:
    """Friction at the axles, changed."""
    text = GUIDE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return (("[[elements]]", text + "[[elements]]"),)


def before(text: str) -> tuple[tuple[str, str], ...]:
    """More text, in front of the body."""
    return (("[bodies.body]", text + "[bodies.body]"),)


BAD = {
    "friction along and across": (guide(('plane = "yz"', 'plane = "yz"\ndirection = "z"')),
     'elements[0].plane = "yz": cannot stand next to direction: give one of them'),
    "friction without normal force": (guide(('normal_spring = "primary"\n', "")),
     "elements[0].normal_force_kN is missing: must be a number above 0"),
    "no such normal spring": (guide(('"primary"', '"primry"')),
     'elements[0].normal_spring = "primry": is no element; there is guide, '),
    "friction that presses itself": (guide(('"primary"', '"guide"')),
     'elements[0].normal_spring = "guide": depends on the load of a spring itself: must be that spring'),
    "normal spring without load": (guide(('"primary"', '"damper"')),
     "friction 'guide front left' has no normal force: 'damper front left' carries nothing along its direction"),
    "missing mass": ((("mass_kg = 8000\n", ""),),
     "car.toml:15: bodies.body.mass_kg is missing: must be a number above 0"),
    "negative mass": ((("8000", "-8000"),), "car.toml:16: bodies.body.mass_kg = -8000: must be a number above 0"),
    "impossible inertia": ((("4000, 9000", "400, 900"),),
     "inertia_kg_m2 = [400, 900, 9500]: the one about z is larger"),
    "misspelt key": ((("stiffness_kN", "stifness_kN"),), "did you mean 'stiffness_kN_per_m'?"),
    "misspelt body": ((('body = "body"', 'body = "bdy"'),),
     'elements[0].body = "bdy": is no body; there is body, front'),
    "attached to itself": ((('to = ["front", "rear"]', 'to = "body"'),), "is the body that the element comes from"),
    "beside the axle": ((("at_mm = [0, 900, 0]", "at_mm = [300, 900, 0]"),), "beside its axle, which lies at x = 2000"),
    "wheelset first": ((('body = "body"\nto = ["front", "rear"]', 'body = "front"\nto = "body"'),),
     "is a wheelset: the axes of an element cannot turn with it; exchange body and to"),
    "loose body": (before(LOOSE), "body box hang on nothing: no element joins them to a wheelset"),
    "no preload": ((("3000, 800]", "3000, 0]"),), "the preload cannot be found: nothing holds body 'body' vertically"),
    "names twice": ((('name = "damper"', 'name = "primary"'),),
     "duplicate names of elements; must be different for each: primary front left"),
    "no wheelset": ((("[wheelsets]\nfront.x_mm = 2000\nrear.x_mm = -2000\n", ""), ('to = ["front", "rear"]',
     'to = "track"')), "is no body"),
    "unknown part": ((("[bodies.body]", '[[places]]\npart = "bogie"\nname = "a"\nat_mm = [0, 0, 0]\n[bodies.body]'),),
     'places[0].part = "bogie": is no part; there is none'),
    "unknown type": ((("front.x_mm = 2000", 'front = {x_mm = 2000, type = "motor"}'),), "is no type of wheelset"),
    "falling table": ((("damping_kNs_per_m = 8", "velocity_m_per_s_force_kN = [[0, 0], [1, 5], [0.5, 6]]"),),
     "row [2] must not lie below the row before it"),
    "load of old": (before(PUSH.replace('axes = "track"\n', "")),
     'car.toml:15: loads[0].axes is missing: must be "track" or "body", the axes that the force keeps to. A load '
     "acts beside the preload: the vehicle tilts under it on its springs. A force that the vehicle is trimmed with, "
     "as [[loads]] once meant, stands in [[payloads]]"),
    "load on nobody": (before(PUSH.replace('"body"', '"bdoy"')),
     "loads[0].on = \"bdoy\": is no body; there is body, front, rear (did you mean 'body'?)"),
    "load of two ways": ((("[bodies.body]", PUSH + "time_s_force_kN = [[0, 0, 0, 0]]\n[bodies.body]"),),
     "loads[0].time_s_force_kN = [[0, 0, 0, 0]]: cannot stand next to force_kN"),
    "load of no way": (before(PUSH.replace("force_kN = [0, 9, 0]\n", "")),
     "loads[0].force_kN is missing: must be three numbers"),
    "load without a number": (before(PUSH.replace("[0, 9, 0]", "[0, nan, 0]")), "loads[0].force_kN = [0, nan, 0]: "),
    "times that do not rise": (before(PUSH.replace("force_kN = [0, 9, 0]", ROWS)), "loads[0].time_s_force_kN"),
    "rows of three": (before(PUSH.replace("force_kN = [0, 9, 0]", "distance_m_force_kN = [[0, 1, 2]]")),
     "four numbers [distance m, x kN, y kN, z kN]"),
    "loads of one name": (before(PUSH + PUSH), "duplicate names of loads; must be different for each: push"),
    "payload of nothing": ((("[bodies.body]", PUSH.replace("loads", "payloads").replace('axes = "track"\n',
     "") + "mass_kg = 3\n[bodies.body]"),),
     "payloads[0].force_kN = [0, 9, 0]: cannot stand next to mass_kg: give one of them"),
    "payload with axes": (before(PUSH.replace("loads", "payloads")), "payloads[0].axes"),
    "mass on a wheelset": (before(BALLAST.replace('"body"', '"front"')),
     'payloads[0].on = "front": is a wheelset, which spins'),
    "mass far out": (before(BALLAST.replace("[0, 0, 900]", "[3000, 0, 3000]")),
     "the payload turns the principal axes of body 'body' about y"),
    "missing wheel": ((("wheels/S1002", "wheels/S1003"),), 'did you mean "wheels/S1002.toml"?'),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_refused_with_a_clear_message(name: str, tmp_path: Path) -> None:
    changes, words = BAD[name]
    message = fault(tmp_path, *changes)
    assert words in message
    assert message.startswith("car.toml")


def test_wheels_that_do_not_fit_the_gauge_are_refused(tmp_path: Path) -> None:
    (tmp_path / "car.toml").write_text(GOOD.replace("1360", "1260"))
    scenario = load(ROOT / "scenarios/manchester_r300.toml").with_values({"vehicle.model": str(tmp_path / "car.toml")})
    with pytest.raises(InputError, match="the wheelset is placed off the rails: at a gauge of 1435 mm"):
        build(scenario)


WIND = {"name": "wind", "on": "carbody", "at_mm": [0, 0, 2200], "axes": "track", "force_kN": [0, 40, 0]}
COAL = {"name": "coal", "on": "carbody", "at_mm": [0, 0, 900], "mass_kg": 20e3}


@pytest.mark.parametrize(("scenario", "values", "words"), [
    ("static_s1002", {"vehicle.loads": [WIND]}, "vehicle.loads: has no place in analysis = .static.: remove it"),
    ("steady_manchester", {"vehicle.loads": [{k: v for k,
     v in WIND.items() if k != "force_kN"} | {"time_s_force_kN": [[0, 0, 0, 0], [1, 0, 1, 0]]}]},
     "vehicle.loads[0]: analysis = .steady. looks for motion that lasts: load 'wind' must be constant"),
])  # fmt: skip
def test_loads_that_do_not_suit_an_analysis_are_refused(scenario: str, values: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words.replace("[", r"\[").replace("]", r"\]")):
        build(load(ROOT / f"scenarios/{scenario}.toml").with_values(values))


def test_a_payload_is_part_of_its_body(tmp_path: Path) -> None:
    (tmp_path / "car.toml").write_text(
        GOOD.replace("[bodies.body]", BALLAST + "inertia_kg_m2 = [10, 20, 30]\n[bodies.body]")
    )
    vehicle = read_vehicle(tmp_path / "car.toml")
    (body,) = vehicle.bodies
    assert (body.mass, body.centre) == (12e3, pytest.approx((0.0, 0.0, 1.1)))
    steiner = 8e3 * 0.1**2 + 4e3 * 0.2**2
    assert body.inertia == pytest.approx((4010.0 + steiner, 9020.0 + steiner, 9530.0))
    assert vehicle.weight == pytest.approx((12e3 + 2e3) * vehicle.gravity)


@pytest.mark.parametrize(("values", "words"), [
    ({"vehicle.sprung_mass_kg": 1000.0}, "is what a single wheelset carries"),
    ({"vehicle.loads": [WIND | {"on": "carbdoy"}]}, "vehicle.loads[0].on = .*did you mean 'carbody'?"),
    ({"vehicle.loads": [WIND, WIND]}, "vehicle.loads[1].name = .wind.: is the name of another load"),
    ({"vehicle.payloads": [COAL | {"on": "front.outer"}]}, "vehicle.payloads[0].on = .*is a wheelset, which spins"),
    ({"vehicle.payloads": [COAL | {"at_mm": [8000, 0, 6800]}]}, "turns the principal axes of body 'carbody' about y"),
    ({"vehicle.drive": "wheel"}, 'did you mean "wheels"?'),
    ({"run.distance_m": 285.0}, "the first wheelset is 10.78 m ahead of the vehicle's origin"),
])  # fmt: skip
def test_a_scenario_that_does_not_suit_its_vehicle_is_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words.replace("?", r"\?").replace("[", r"\[").replace("]", r"\]")):
        build(load(ROOT / "scenarios/manchester_r300.toml").with_values(values))


def test_the_command_draws_a_vehicle(tmp_path: Path) -> None:
    ok("vehicle", "vehicles/manchester_1.toml", "-o", tmp_path / "m.svg")
    assert (tmp_path / "m.svg").read_text().startswith("<?xml")
    again = call("vehicle", "vehicles/manchester_1.toml", "-o", tmp_path / "m.jpg")
    assert again.exit_code == 2
