"""Vehicle files: published numbers arrive in SI units, faults are told with file, line, key and what is allowed."""

import tomllib
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


@pytest.mark.parametrize(("old", "new", "message"), table("one_fault"))
def test_one_fault_in_a_vehicle_file_is_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    said = fault(tmp_path, (old, new), text=VEHICLE)
    assert "\n" not in said and message in said


# Files of whole vehicles that cannot be used: one clear message each, with file, line, key and what was meant.
def test_the_good_file_loads(tmp_path: Path) -> None:
    assert fault(tmp_path) == ""


TEXTS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["texts"]
BAD = table("a_bad_file_is_refused_with_a_clear_message")


def inserted(*names: str) -> tuple[str, str]:
    """The change that puts texts in front of the elements, for friction between them, or of the body."""
    before = "[[elements]]" if "guide" in names else "[bodies.body]"
    return before, "".join(TEXTS[name] for name in names) + before


@pytest.mark.parametrize(("name", "more", "changes", "words"), BAD, ids=[row[0] for row in BAD])
def test_a_bad_file_is_refused_with_a_clear_message(
    name: str, more: list[str], changes: list[tuple[str, str]], words: str, tmp_path: Path
) -> None:
    message = fault(tmp_path, inserted(*more), *changes)
    assert words in message
    assert message.startswith("car.toml")


def test_friction_takes_the_spring_on_its_own_side_that_leads_to_the_same_body(tmp_path: Path) -> None:
    assert fault(tmp_path, inserted("guide")) == ""
    elements = read_vehicle(tmp_path / "car.toml").elements
    pressed = {e.name: e.slider.normal.of for e in elements if e.slider and e.slider.normal}
    assert pressed == {
        f"guide {to} {side}": f"primary {to} {side}" for to in ("front", "rear") for side in ("left", "right")
    }


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
        GOOD.replace("[bodies.body]", TEXTS["ballast"] + "inertia_kg_m2 = [10, 20, 30]\n[bodies.body]")
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
