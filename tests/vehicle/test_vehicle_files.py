"""Vehicle files: published numbers arrive in SI units, faults are told with file, line, key and what is allowed."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.commands import refusal
from support.rows import rows_of
from support.vehicle_texts import GOOD, fault
from support.vehicles import ROOT, manchester, read_vehicle

from wrsim import InputError, Vehicle, load, load_vehicle
from wrsim.analysis.stationary.statics import static_state
from wrsim.inputs.lookup import Finder, shipped_models
from wrsim.inputs.toml_files import write_toml
from wrsim.scenario.build import build
from wrsim.scenario.plausibility import vehicle_warnings
from wrsim.vehicle.bogies import level_of
from wrsim.vehicle.elements import GUIDE, Spring
from wrsim.vehicle.loads import CarriedMass
from wrsim.vehicle.preload import preloads
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


@pytest.mark.parametrize(("old", "new", "message"), table("one_fault"))
def test_one_fault_in_a_vehicle_file_is_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    said = fault(tmp_path, (old, new), text=VEHICLE)
    assert "\n" not in said and message in said


# Files of whole vehicles that cannot be used: one clear message each, with file, line, key and what was meant.
def test_the_good_file_loads_and_friction_takes_the_spring_on_its_own_side(tmp_path: Path) -> None:
    assert fault(tmp_path) == ""
    assert fault(tmp_path, inserted("guide")) == ""
    elements = read_vehicle(tmp_path / "car.toml").elements
    pressed = {e.name: e.slider.normal.element for e in elements if e.slider and e.slider.normal}
    assert pressed == {
        f"guide {to} {side}": f"primary {to} {side}" for to in ("front", "rear") for side in ("left", "right")
    }


TEXTS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["texts"]
BAD = table("a_bad_file_is_refused_with_a_clear_message")


def inserted(*names: str) -> tuple[str, str]:
    """The change that puts texts in front of the elements, for friction between them, or of the body."""
    before = "[[elements]]" if "guide" in names else "[bodies.body]"
    return before, "".join(TEXTS[name] for name in names) + before


@pytest.mark.parametrize(("name", "more", "changes", "expected"), BAD, ids=[row[0] for row in BAD])
def test_a_bad_file_is_refused_with_a_clear_message(name, more, changes, expected, tmp_path):
    message = fault(tmp_path, inserted(*more), *changes)
    assert expected in message
    assert message.startswith("car.toml")


WIND = {"name": "wind", "on": "carbody", "at_mm": [0, 0, 2200], "axes": "track", "force_kN": [0, 40, 0]}


@pytest.mark.parametrize(("scenario", "values", "message"), [
    ("static_s1002", {"vehicle.loads": [WIND]}, "loads: cannot be combined with analysis = .static.: remove it"),
    ("steady_manchester", {"vehicle.loads": [{k: v for k,
     v in WIND.items() if k != "force_kN"} | {"time_s_force_kN": [[0, 0, 0, 0], [1, 0, 1, 0]]}]},
     "vehicle.loads[0]: analysis = .steady. looks for motion that lasts: load 'wind' must be constant"),
])  # fmt: skip
def test_loads_that_do_not_suit_an_analysis_are_refused(scenario: str, values: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message.replace("[", r"\[").replace("]", r"\]")):
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


@pytest.mark.parametrize(("values", "message"), table("a_scenario_that_does_not_suit_its_vehicle_is_refused"))
def test_a_scenario_that_does_not_suit_its_vehicle_is_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message.replace("?", r"\?").replace("[", r"\[").replace("]", r"\]")):
        build(load(ROOT / "scenarios/manchester_r300.toml").with_values(values))


# Train files: names, places, what the vehicles share, and one clear message for each that cannot be used.
TRAIN = (ROOT / "models/trains/manchester_3.toml").read_text(encoding="utf-8")
SECOND = """
[[vehicles]]
name = "car"
model = "car.toml"
length_mm = 9000
middle_mm = 500
reversed = true
driven = false
"""


def loaded(text: str, folder: Path, car: str = GOOD) -> Vehicle:
    """The train of this text, with a car file beside it."""
    (folder / "train.toml").write_text(text, encoding="utf-8")
    (folder / "car.toml").write_text(car, encoding="utf-8")
    return read_vehicle(folder / "train.toml")


def changed(*changes: tuple[str, str]) -> str:
    """The shipped file with other words."""
    text = TRAIN
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def test_a_train_is_its_vehicles_one_behind_the_other(tmp_path: Path) -> None:
    train = loaded(TRAIN, tmp_path)
    coach = manchester()
    assert [m.name for m in train.members] == ["coach1", "coach2", "coach3"]
    names = [f"coach{k}.{mounted.name}" for k in (1, 2, 3) for mounted in coach.wheelsets]
    assert [mounted.name for mounted in train.wheelsets] == names
    for k, unit in enumerate(train.units):
        x = [train.parts[i].centre[0] + 26.4 * k for i in unit.parts]
        np.testing.assert_allclose(x, [part.centre[0] for part in coach.parts], atol=1e-12)
        assert (unit.pulled_mass, unit.pulled_inertia) == (coach.mass, coach.moved_mass)
        assert train.names[unit.reference] == f"coach{k + 1}.carbody"
        assert level_of(train, f"coach{k + 1}.carbody") == "car body"
        assert level_of(train, f"coach{k + 1}.front.frame") == "bogie frame"
    each = [p.force for p in preloads(coach)]
    for k in range(3):
        forces = [p.force for p in preloads(train)[k * len(each) : (k + 1) * len(each)]]
        for a, b in zip(forces, each, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(
        static_state(train).wheel_loads, np.tile(static_state(coach).wheel_loads, (3, 1)), rtol=1e-7
    )


def test_vehicles_of_all_kinds_run_either_way_round(tmp_path: Path) -> None:
    """Behind three coaches a short car turned round: its front axle is the rear one, 500 mm nearer to its end."""
    train = loaded(changed(("[[couplings]]", SECOND + "[[couplings]]")), tmp_path)
    origin = -2.0 * 26.4 - 13.2 - 4.5 + 0.5  # the middle lies 500 mm ahead of the origin, turned round behind it
    places = {m.name: m.x - origin for m in train.wheelsets[-2:]}
    assert places == pytest.approx({"car.rear": 2.0, "car.front": -2.0})
    assert train.couplings[-1].name == "coach3-car"
    assert (train.couplings[-1].ahead, train.couplings[-1].behind) == ("coach3.carbody", "car.body")
    driven = sum(unit.pulled_mass for unit in train.units if unit.driven)
    assert driven == pytest.approx(train.mass)  # those that are driven take the car along
    left = [e.points[1] for e in train.elements if e.name == "car.primary front left"]
    assert left[0] == pytest.approx((origin - 2.0, 0.9, 0.45))  # left stays left


COUPLINGS = TRAIN.partition("[[couplings]]")[2]


@pytest.mark.parametrize(("name", "changes", "message"), table("a_train_that_cannot_be_used_is_told_in_one_line"))
def test_a_train_that_cannot_be_used_is_told_in_one_line(name, changes, message, tmp_path):
    pairs = [tuple(text.replace("{couplings}", COUPLINGS) for text in pair) for pair in changes]
    with pytest.raises(InputError, match=message) as caught:
        loaded(changed(*pairs), tmp_path)
    assert "\n" not in str(caught.value)
    assert "train.toml" in str(caught.value)


def test_a_train_has_neither_single_poses_nor_tests_at_rest() -> None:
    static = load(ROOT / "scenarios/static_s1002.toml")
    with pytest.raises(InputError, match=r'model.*: is a train; analysis = "static" knows one vehicle'):
        build(static.with_values({"vehicle.model": "trains/manchester_3.toml"}))
    outcome = refusal("vehicle", "trains/manchester_3.toml", "--twist", "3")
    assert "is a train; tests at rest are for one vehicle" in outcome


# Implausible vehicles are named, with their physical reason; shipped ones are plausible.
ALL_MODELS = [path for folder in ("vehicles", "trains") for path in sorted((shipped_models() / folder).glob("*.toml"))]
COACH_FILE = tomllib.loads((shipped_models() / "vehicles/manchester_1.toml").read_text())

ALL_MODELS += [shipped_models() / "templates/metro.toml", shipped_models() / "templates/locomotive.toml"]


@pytest.mark.parametrize("path", ALL_MODELS, ids=lambda path: path.stem)
def test_shipped_models_are_plausible(path: Path) -> None:
    assert vehicle_warnings(load_vehicle(path)) == []


def test_the_metro_to_start_from_weighs_what_the_published_one_weighs() -> None:
    template, published = (
        load_vehicle(shipped_models() / name) for name in ("templates/metro.toml", "vehicles/gz18.toml")
    )
    assert template.mass == pytest.approx(published.mass, rel=1e-12)
    for template_part, published_part in zip(template.parts, published.parts, strict=True):
        assert template_part.inertia == pytest.approx(published_part.inertia, rel=1e-9)


def changed_coach(tmp_path: Path, change: Callable[[dict[str, Any]], object]) -> Vehicle:
    data = tomllib.loads(write_toml(COACH_FILE))
    change(data)
    path = tmp_path / "coach.toml"
    path.write_text(write_toml(data))
    return load_vehicle(path)


def stiffness(name: str, factor: float) -> Callable[[dict[str, Any]], object]:
    def change(data: dict[str, Any]) -> None:
        for element in data["parts"]["bogie"]["elements"]:
            if element["name"] == name:
                value = element["stiffness_kN_per_m"]
                element["stiffness_kN_per_m"] = (
                    [factor * k for k in value] if isinstance(value, list) else factor * value
                )

    return change


def every(key: str, factor: float) -> Callable[[Any], object]:
    def change(tree: Any) -> None:
        for value in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
            if isinstance(value, dict) and key in value:
                value[key] = [factor * v for v in value[key]]
            change(value)

    return change


def one_axle_without_springs(data: dict[str, Any]) -> None:
    for element in data["parts"]["bogie"]["elements"]:
        if isinstance(element["to"], list):
            element["to"] = ["outer"]


def nothing_along(data: dict[str, Any]) -> None:
    for element in data["parts"]["bogie"]["elements"]:
        if element["name"] == "secondary":
            element["stiffness_kN_per_m"][0] = 0.0
    data["parts"]["bogie"]["elements"].pop()  # the traction rod


def update(place: list[str], values: dict[str, Any]) -> Callable[[dict[str, Any]], object]:
    return lambda data: reduce(getitem, place, data).update(values)


def wheelbase(factor: float) -> Callable[[dict[str, Any]], object]:
    return lambda data: [w.update(x_mm=factor * w["x_mm"]) for w in data["parts"]["bogie"]["wheelsets"].values()]


def wheels(left: float, right: float) -> Callable[[dict[str, Any]], object]:
    def change(data: dict[str, Any]) -> None:
        del data["wheelset"]["radius_mm"]
        data["wheelset"] |= {"radius_left_mm": left, "radius_right_mm": right}

    return change


def dampers(name: str, factor: float) -> Callable[[dict[str, Any]], object]:
    def change(data: dict[str, Any]) -> None:
        for element in data["parts"]["bogie"]["elements"]:
            if element["name"] == name:
                element["damping_kNs_per_m"] *= factor

    return change


def carries(mass: float) -> Callable[[dict[str, Any]], object]:
    load = {"name": "people", "on": "carbody", "at_mm": [0, 0, 1800], "mass_kg": mass, "inertia_kg_m2": [5e4, 2e6, 2e6]}
    return lambda data: data.update(payloads=[load])


def stops(twice: bool) -> Callable[[dict[str, Any]], object]:
    def change(data: dict[str, Any]) -> None:
        elements = data["parts"]["bogie"]["elements"]
        (stop,) = (element for element in elements if element["kind"] == "bump-stop")
        stop |= {"both_ways": False}
        if twice:  # of the other side, from the other body
            elements.append(stop | {"name": "other stop", "body": stop["to"], "to": stop["body"]})

    return change


ONES = (stiffness, every, update, wheelbase, wheels, dampers, carries, stops)
CHANGES: dict[str, Callable[..., Any]] = {function.__name__: function for function in ONES}
CHANGES |= {
    function.__name__: lambda function=function: function for function in (one_axle_without_springs, nothing_along)
}


@pytest.mark.parametrize(("name", "how", "by", "pattern", "count"), table("an_implausible_value_is_named_once"))
def test_an_implausible_value_is_named_once(
    name: str, how: str, by: list[Any], pattern: str, count: int, tmp_path: Path
):
    warned = vehicle_warnings(changed_coach(tmp_path, CHANGES[how](*by)))
    assert len(warned) == count and sum(bool(re.search(pattern, each)) for each in warned) == min(count, 1), warned


def test_a_mass_high_above_its_wheelset_is_told() -> None:
    wheelset = load_vehicle(shipped_models() / "vehicles/wheelset_s1002.toml")
    for height, told in ((4.6, 1), (3.0, 0)):
        carried = tuple(replace(each, height=height) for each in wheelset.carried)
        warned = vehicle_warnings(replace(wheelset, carried=carried))
        assert len(warned) == told and all("height of the centre of the sprung mass" in each for each in warned)


def test_uneven_wheel_loads_are_those_of_the_vehicle_at_rest(tmp_path: Path) -> None:
    vehicle = changed_coach(tmp_path, lambda data: data["bodies"]["carbody"].update(centre_mm=[4000, 600, 1800]))
    (warning,) = vehicle_warnings(vehicle)
    name, *loads = re.search(r"of '(.*)' are (\S+) kN left and (\S+) kN right", warning).groups()
    at_rest = static_state(vehicle).wheel_loads[vehicle.index(name)] / 1e3
    # the body settles on its springs: some 1 mm of 600 aside
    assert [float(load) for load in loads] == pytest.approx(at_rest.tolist(), rel=0.01)
