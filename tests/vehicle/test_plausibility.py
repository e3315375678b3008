"""Implausible vehicles are named, with their physical reason; shipped ones are plausible."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from wrsim.analysis.stationary.statics import static_state
from wrsim.inputs.lookup import shipped_models
from wrsim.inputs.toml_files import write_toml
from wrsim.scenario.plausibility import vehicle_warnings
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle

MODELS = [path for folder in ("vehicles", "trains") for path in sorted((shipped_models() / folder).glob("*.toml"))]
COACH = tomllib.loads((shipped_models() / "vehicles/manchester_1.toml").read_text())


MODELS += [shipped_models() / "templates/metro.toml", shipped_models() / "templates/locomotive.toml"]
PUBLISHED = {"gz18": "in pitch at 315"}
"""Placeholders of 1 kg m2 for the arms, in published data that others have computed with."""


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_shipped_models_are_plausible(path: Path) -> None:
    found = vehicle_warnings(load_vehicle(path))
    assert [words for words in found if PUBLISHED.get(path.stem, "-") not in words] == []
    assert len(found) == (path.stem in PUBLISHED)


def test_the_metro_to_start_from_weighs_what_the_published_one_weighs() -> None:
    own, published = (load_vehicle(shipped_models() / name) for name in ("templates/metro.toml", "vehicles/gz18.toml"))
    assert own.mass == pytest.approx(published.mass, rel=1e-12)
    for one, other in zip(own.parts, published.parts, strict=True):
        assert one.inertia == pytest.approx(other.inertia, rel=1e-9)


def changed(tmp_path: Path, change: Callable[[dict[str, Any]], object]) -> Vehicle:
    data = tomllib.loads(write_toml(COACH))
    change(data)
    path = tmp_path / "coach.toml"
    path.write_text(write_toml(data))
    return load_vehicle(path)


def stiffness(name: str, factor: float) -> Callable[[dict[str, Any]], object]:
    def change(data: dict[str, Any]) -> None:
        for element in data["parts"]["bogie"]["elements"]:
            if element["name"] == name:
                found = element["stiffness_kN_per_m"]
                element["stiffness_kN_per_m"] = (
                    [factor * k for k in found] if isinstance(found, list) else factor * found
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


IMPLAUSIBLE = {
    "stiff springs": (
        stiffness("primary", 300.0),
        r"^wheelset 'rear.outer' oscillates in yaw at \d+\.\d Hz on 'rear.primary",
    ),
    "stiff secondary springs": (
        stiffness("secondary", 1e3),
        r"frame' oscillates in roll at 11\d\.\d Hz on 'rear.secondary",
    ),
    "stiff rod": (stiffness("traction rod", 1e3), r"frame' oscillates along x at \d+\.\d Hz on 'rear.traction rod'"),
    "soft primary springs": (stiffness("primary", 1e-3), r"'front.primary .*' carries .* deflects by 37\.\d+ m"),
    "soft secondary springs": (
        stiffness("secondary", 1e-3),
        r"'.*secondary .*' carries 78\.45 kN, deflects by 182\.4 m",
    ),
    "pivots of millimetres": (every("at_mm", 1e-3), "'front.outer' and 'rear.inner' are 0.019 m apart.*overlap"),
    "pivots of a bridge": (every("at_mm", 10.0), "'front.inner' and 'rear.inner' are .* m apart.*up to 25 m"),
    "centre below the rail": (every("centre_mm", -1.0), "'carbody' is at a height of -1.8 m above the rails"),
    "light body": (
        lambda d: d["bodies"]["carbody"].update(mass_kg=24),
        "gyration of body 'carbody' of 24 kg is 48.65 m in roll",
    ),
    "little body": (
        lambda d: d["bodies"]["carbody"].update(mass_kg=32, inertia_kg_m2=[56.8, 1970, 1970]),
        "the wheelsets are 58% of the mass",
    ),
    "dense bodies": (every("inertia_kg_m2", 1e-3), "body 'carbody' are those of a sphere of 0.323 m"),
    "a wheelbase of ten": (
        lambda d: [w.update(x_mm=10 * w["x_mm"]) for w in d["parts"]["bogie"]["wheelsets"].values()],
        "'front.frame' and 'rear.frame' are among each other: 25.6 m",
    ),
    "a wheelset of kilograms": (lambda d: d["wheelset"].update(mass_kg=1.8), "'front.outer' = 1.8 kg"),
    "a free axle": (
        one_axle_without_springs,
        r"nothing holds wheelset 'front.inner' \(and 1 more part\) along x, along y and in yaw",
    ),
    "a free body": (nothing_along, "nothing holds body 'carbody' along x:"),
}


PARTS = {"centre below the rail": 2, "dense bodies": 2}
"""How many parts are wrong, if not one: car body and frame."""


@pytest.mark.parametrize("name", IMPLAUSIBLE)
def test_an_implausible_value_is_named_once(name: str, tmp_path: Path) -> None:
    change, words = IMPLAUSIBLE[name]
    found = vehicle_warnings(changed(tmp_path, change))
    assert len(found) == PARTS.get(name, 1) and sum(bool(re.search(words, each)) for each in found) == 1, found


def test_uneven_wheel_loads_are_those_of_the_vehicle_at_rest(tmp_path: Path) -> None:
    vehicle = changed(tmp_path, lambda data: data["bodies"]["carbody"].update(centre_mm=[4000, 600, 1800]))
    (words,) = vehicle_warnings(vehicle)
    name, *loads = re.search(r"of '(.*)' are (\S+) kN left and (\S+) kN right", words).groups()
    at_rest = static_state(vehicle).wheel_loads[vehicle.index(name)] / 1e3
    # the body settles on its springs: some 1 mm of 600 aside
    assert [float(load) for load in loads] == pytest.approx(at_rest.tolist(), rel=0.01)
