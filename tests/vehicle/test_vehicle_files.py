"""Vehicle files: published numbers arrive in SI units, faults are told with file, line, key and what is allowed."""

from pathlib import Path

import pytest
from support.commands import call, ok
from support.rows import rows_of
from support.vehicle_texts import GOOD, fault
from support.vehicles import ROOT, read_vehicle

from wrsim.errors import InputError
from wrsim.inputs.lookup import Finder, shipped_models
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.vehicle.elements import GUIDE, Spring
from wrsim.vehicle.loads import CarriedMass
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

table = rows_of(__file__)

MODELS = shipped_models()
FIND = Finder((MODELS,))

SPRUNG = """\
[suspension]
stiffness_kN_per_m = [1, 2, 3]
damping_kNs_per_m = [4, 5, 6]
half_spacing_mm = 900
[sprung]
mass_kg = 5000
height_above_axle_mm = 1200
"""
VEHICLE = GOOD.partition("[wheelsets]")[0] + SPRUNG
"""The wheelset of the good car, alone."""


def test_a_vehicle_arrives_in_si_units(tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    vehicle = load_vehicle(tmp_path / "vehicle.toml", FIND)
    w = vehicle.wheelsets[0].wheelset
    assert (w.name, w.source, w.mass, w.inertia) == ("a car", "made up", 1000.0, (600.0, 100.0, 600.0))
    assert w.profile_spacing == pytest.approx(1.5), "flange backs plus twice 70 mm"
    assert w.left.radius == w.right.radius == w.mean_radius == pytest.approx(0.45)
    assert w.left.profile.kind == "wheel"
    left, right = springs(vehicle)
    assert left.stiffness == right.stiffness == (1e3, 2e3, 3e3)
    assert left.damping == right.damping == (4e3, 5e3, 6e3)
    assert (left.at, right.at) == (pytest.approx((0.0, 0.9, 0.45)), pytest.approx((0.0, -0.9, 0.45)))
    assert vehicle.carried == (CarriedMass("wheelset", 5000.0, pytest.approx(1.2)),)
    assert vehicle.weight == pytest.approx(6000 * STANDARD_GRAVITY)
    assert vehicle.drive == "free"  # the guide frame runs at constant speed


def springs(vehicle: Vehicle) -> list[Spring]:
    """The springs to the guide frame."""
    return [e for e in vehicle.elements if isinstance(e, Spring) and e.first == GUIDE]


def test_each_wheel_may_have_its_own_profile_and_radius(tmp_path: Path) -> None:
    text = VEHICLE.replace("radius_mm = 450", "radius_left_mm = 450\nradius_right_mm = 449")
    text = text.replace('wheel = "wheels/S1002.toml"', 'wheel_left = "wheels/S1002.toml"\nwheel_right = "mine.toml"')
    (tmp_path / "mine.toml").write_text((MODELS / "wheels/cone_1in20.toml").read_text())
    (tmp_path / "vehicle.toml").write_text(text)
    w = load_vehicle(tmp_path / "vehicle.toml", FIND).wheelsets[0].wheelset
    assert (w.left.radius, w.right.radius) == (0.45, 0.449)
    assert w.left.profile.name == "S1002"
    assert w.right.profile.name != "S1002", "a profile beside the vehicle file is found there"
    changed = w.with_wheel("right", w.left.profile, None)
    assert (changed.right.profile.name, changed.right.radius, w.right.radius) == ("S1002", 0.449, 0.449)


def test_the_shipped_s1002_wheelset_is_that_of_manchester_vehicle_1() -> None:
    """Iwnicki 1998: wheelset 1813 kg, 1120 / 112 / 1120 kg m2, flange backs 1360 mm, R 460 mm; bodies per axle."""
    vehicle = load_vehicle(MODELS / "vehicles/wheelset_s1002.toml", FIND)
    w = vehicle.wheelsets[0].wheelset
    assert (w.mass, w.inertia) == (1813.0, (1120.0, 112.0, 1120.0))
    assert (w.profile_spacing, w.mean_radius) == (pytest.approx(1.5), 0.46)
    left = springs(vehicle)[0]
    assert left.stiffness[:2] == (31.391e6, 3.884e6)
    assert left.damping == (15e3, 2e3, 4e3)
    assert left.at[1] == 1.0
    assert vehicle.carried[0].mass == 32000 / 4 + 2615 / 2
    height = (8000 * 1.8 + 1307.5 * 0.6) / 9307.5 - 0.46
    assert vehicle.carried[0].height == pytest.approx(height, abs=1e-3)


ONE_FAULT = table("one_fault")  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), ONE_FAULT)
def test_one_fault_in_a_vehicle_file_is_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    said = fault(tmp_path, (old, new), text=VEHICLE)
    assert "\n" not in said and message in said


# Files of whole vehicles that cannot be used: one clear message each, with file, line, key and what was meant.
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

FRICTION_GUIDE = """\
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
    text = FRICTION_GUIDE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return (("[[elements]]", text + "[[elements]]"),)


def before(text: str) -> tuple[tuple[str, str], ...]:
    """More text, in front of the body."""
    return (("[bodies.body]", text + "[bodies.body]"),)


BAD = {
    "friction along and across": (guide(('plane = "yz"', 'plane = "yz"\ndirection = "z"')),
     'elements[0].plane = "yz": cannot be given with direction: give one of them'),
    "friction without normal force": (guide(('normal_spring = "primary"\n', "")),
     "elements[0].normal_force_kN is missing: must be a number above 0"),
    "no such normal spring": (guide(('"primary"', '"primry"')),
     'elements[0].normal_spring = "primry": is no element; there is guide, '),
    "friction that presses itself": (guide(('"primary"', '"guide"')),
     'elements[0].normal_spring = "guide": depends on the load of a spring itself: must be that spring'),
    "normal spring without load": (guide(('"primary"', '"damper"')),
     "friction 'guide front left' has no normal force: 'damper front left' carries nothing along its direction"),
    "impossible inertia": ((("4000, 9000", "400, 900"),),
     "inertia_kg_m2 = [400, 900, 9500]: the one about z is larger"),
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
     "as [[loads]] of older files, belongs in [[payloads]]"),
    "load on nobody": (before(PUSH.replace('"body"', '"bdoy"')),
     "loads[0].on = \"bdoy\": is no body; there is body, front, rear (did you mean 'body'?)"),
    "load of two ways": ((("[bodies.body]", PUSH + "time_s_force_kN = [[0, 0, 0, 0]]\n[bodies.body]"),),
     "loads[0].time_s_force_kN = [[0, 0, 0, 0]]: cannot be given with force_kN"),
    "times that do not rise": (before(PUSH.replace("force_kN = [0, 9, 0]", ROWS)), "loads[0].time_s_force_kN"),
    "rows of three": (before(PUSH.replace("force_kN = [0, 9, 0]", "distance_m_force_kN = [[0, 1, 2]]")),
     "four numbers [distance m, x kN, y kN, z kN]"),
    "loads of one name": (before(PUSH + PUSH), "duplicate names of loads; must be different for each: push"),
    "payload of nothing": ((("[bodies.body]", PUSH.replace("loads", "payloads").replace('axes = "track"\n',
     "") + "mass_kg = 3\n[bodies.body]"),),
     "payloads[0].force_kN = [0, 9, 0]: cannot be given with mass_kg: give one of them"),
    "payload with axes": (before(PUSH.replace("loads", "payloads")), "payloads[0].axes"),
    "mass on a wheelset": (before(BALLAST.replace('"body"', '"front"')),
     'payloads[0].on = "front": is a wheelset, which spins'),
    "mass far out": (before(BALLAST.replace("[0, 0, 900]", "[3000, 0, 3000]")),
     "the payload turns the principal axes of body 'body' about y"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_refused_with_a_clear_message(name: str, tmp_path: Path) -> None:
    changes, words = BAD[name]
    message = fault(tmp_path, *changes)
    assert words in message
    assert message.startswith("car.toml")


WIND = {"name": "wind", "on": "carbody", "at_mm": [0, 0, 2200], "axes": "track", "force_kN": [0, 40, 0]}


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


@pytest.mark.parametrize(("values", "words"), table("a_scenario_that_does_not_suit_its_vehicle_is_refused"))
def test_a_scenario_that_does_not_suit_its_vehicle_is_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words.replace("?", r"\?").replace("[", r"\[").replace("]", r"\]")):
        build(load(ROOT / "scenarios/manchester_r300.toml").with_values(values))


def test_the_command_draws_a_vehicle(tmp_path: Path) -> None:
    ok("vehicle", "vehicles/manchester_1.toml", "-o", tmp_path / "m.svg")
    assert (tmp_path / "m.svg").read_text().startswith("<?xml")
    again = call("vehicle", "vehicles/manchester_1.toml", "-o", tmp_path / "m.jpg")
    assert again.exit_code == 2
