"""Train files: names, places, what the vehicles share, and one clear message for each that cannot be used."""

from pathlib import Path

import numpy as np
import pytest
from support.commands import refusal
from support.vehicle_texts import GOOD
from support.vehicles import ROOT, manchester, read_vehicle

from wrsim.analysis.stationary.statics import static_state
from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.vehicle.bogies import level_of
from wrsim.vehicle.preload import preloads
from wrsim.vehicle.vehicle import Vehicle

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
    own = [f"coach{k}.{mounted.name}" for k in (1, 2, 3) for mounted in coach.wheelsets]
    assert [mounted.name for mounted in train.wheelsets] == own
    for k, unit in enumerate(train.units):
        x = [train.parts[i].centre[0] + 26.4 * k for i in unit.parts]
        np.testing.assert_allclose(x, [part.centre[0] for part in coach.parts], atol=1e-12)
        assert (unit.pulled_mass, unit.pulled_inertia) == (coach.mass, coach.moved_mass)
        assert train.names[unit.reference] == f"coach{k + 1}.carbody"
        assert level_of(train, f"coach{k + 1}.carbody") == "car body"
        assert level_of(train, f"coach{k + 1}.front.frame") == "bogie frame"
    each = [p.force for p in preloads(coach)]
    for k in range(3):
        found = [p.force for p in preloads(train)[k * len(each) : (k + 1) * len(each)]]
        for a, b in zip(found, each, strict=True):
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


COACH = 'model = "vehicles/manchester_1.toml"'
FOURTH = '[[vehicles]]\nname = "coach2"\nmodel = "vehicles/manchester_1.toml"\nlength_mm = 26400\n[[couplings]]'
TABLE = "stroke_mm_force_kN = [[5, 1], [50, 300]]"
COUPLINGS = TRAIN.partition("[[couplings]]")[2]
FAULTS: dict[str, tuple[tuple[tuple[str, str], ...], str]] = {
    "fewer couplings than gaps": ((("count = 3", "count = 4"), (COUPLINGS, COUPLINGS + "[[couplings]]" + COUPLINGS)),
     r"couplings: there are 2 for 3 gaps between vehicles: give one for all, or one for each"),
    "a single wheelset": (((COACH, COACH.replace("manchester_1", "wheelset_s1002")),),
     "is no vehicle of parts; a train takes vehicles with bodies"),
    "elements to the track": (((COACH, COACH.replace("manchester_1", "cooperrider_bogie")),),
     "has elements to the frame of the track"),
    "one vehicle": ((("count = 3", "count = 1"),), "is one vehicle: a train has at least two"),
    "vehicles that overlap": ((("length_mm = 26400", "length_mm = 20000"),),
     r"length_mm = 20000.0: is too short: 'coach1.front.outer' lies 10.78 m from the middle"),
    "two of one name": ((("[[couplings]]", FOURTH),), r"vehicles\[1\].name: 'coach2' is the name of another vehicle"),
    "a point in a name": ((('name = "coach"', 'name = "coach."'),), "cannot be the name of a vehicle"),
    "no such body": ((("count = 3", 'count = 3\nbody = "carbdy"'),),
     "body = \"carbdy\": is no body of that vehicle; there is carbody.*did you mean 'carbody'"),
    "slack and pretension": ((("pretension_kN = 20 ", "pretension_kN = 20\nslack_mm = 5 "),),
     "slack_mm = 5: must be 0 next to pretension_kN"),
    "stiffness twice": ((("preload_kN = 15 ", "#"), ("stroke_mm = 55 ", TABLE.replace("5, 1", "0, 1") + "#")),
     "stroke_mm_force_kN.*: cannot be given with stiffness_kN_per_m"),
    "a stroke that begins late": ((("stiffness_kN_per_m = 6000", TABLE), ("preload_kN = 15", "#"), ("stroke_mm = 55 ",
     "#")), "must begin with stroke 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_train_that_cannot_be_used_is_told_in_one_line(name: str, tmp_path: Path) -> None:
    changes, message = FAULTS[name]
    with pytest.raises(InputError, match=message) as caught:
        loaded(changed(*changes), tmp_path)
    assert "\n" not in str(caught.value)
    assert "train.toml" in str(caught.value)


def test_a_train_has_no_single_poses() -> None:
    static = load(ROOT / "scenarios/static_s1002.toml")
    with pytest.raises(InputError, match=r'model.*: is a train; analysis = "static" knows one vehicle'):
        build(static.with_values({"vehicle.model": "trains/manchester_3.toml"}))


def test_a_train_has_no_tests_at_rest() -> None:
    outcome = refusal("vehicle", "trains/manchester_3.toml", "--twist", "3")
    assert "is a train; tests at rest are for one vehicle" in outcome
