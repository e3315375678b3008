"""Vehicle files: published numbers arrive in SI units, faults are told with file, line, key and what is allowed."""

from pathlib import Path

import pytest
from support.vehicle_texts import GOOD, fault

from wrsim.errors import InputError
from wrsim.inputs.lookup import Finder, shipped_models
from wrsim.vehicle.elements import GUIDE, Spring
from wrsim.vehicle.loads import CarriedMass
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

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


def test_the_guide_frame_holds_its_wheelset_at_the_height_of_other_wheels(tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    vehicle = load_vehicle(tmp_path / "vehicle.toml", FIND)
    turned = vehicle.with_wheelsets(lambda w: w.with_wheel("left", None, 0.44).with_wheel("right", None, 0.44))
    assert turned.wheelsets[0].height == 0.44
    assert [spring.at[2] for spring in springs(turned)] == [0.44, 0.44]


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


def test_the_vertical_spring_is_left_out_because_the_load_is_prescribed() -> None:
    """A spring to a frame at fixed height would carry a part of the load that nobody knows."""
    for file in sorted((MODELS / "vehicles").glob("*.toml")):
        text = file.read_text()
        if "wheels/lrv_standin.toml" in text and not (MODELS / "wheels/lrv_standin.toml").exists():
            continue
        vehicle = load_vehicle(file, FIND)
        assert all(spring.stiffness[2] == 0.0 for spring in springs(vehicle))


def test_the_light_rail_wheelset_has_the_numbers_of_the_paper_and_its_wheel_load(tmp_path: Path) -> None:
    """Marques et al., table 1: R 375 mm, H 1055 mm; 24 kN a wheel."""
    text = (MODELS / "vehicles/wheelset_lrv.toml").read_text()
    assert "wheels/lrv_standin.toml" in text
    assert "stand-in" in text and "[assumed]" in text
    (tmp_path / "vehicle.toml").write_text(text.replace("wheels/lrv_standin.toml", "wheels/S1002.toml"))
    vehicle = load_vehicle(tmp_path / "vehicle.toml", FIND)
    w = vehicle.wheelsets[0].wheelset
    assert (w.profile_spacing, w.mean_radius) == (pytest.approx(1.055), 0.375)
    assert 0.5 * vehicle.weight == pytest.approx(24e3, rel=1e-3)


ONE_FAULT = [
    ("mass_kg = 1000", "mass = 1000", "car.toml:5: wheelset.mass = 1000: unknown key; did you mean 'mass_kg' (in kg)?"),
    ("mass_kg = 1000", "mass_kg = 0", "wheelset.mass_kg = 0: must be a number above 0"),
    ("roll_inertia_kg_m2 = 600", "ixx_kg_m2 = 600", "did you mean 'roll_inertia_kg_m2'?"),
    ("roll_inertia_kg_m2 = 600", "roll_inertia_kg_m2 = 610",
     "wheelset.roll_inertia_kg_m2 = 610: must equal yaw_inertia_kg_m2 = 600"),
    ("spin_inertia_kg_m2 = 100", "spin_inertia_kg_m2 = 1201", "must be at most twice yaw_inertia_kg_m2 = 600"),
    ("roll_inertia_kg_m2 = 600", "", "wheelset.roll_inertia_kg_m2 is missing: must be a number above 0"),
    ("flange_back_mm = 1360", "", "wheelset.profile_spacing_mm is missing: must be a number from 400"),
    ("flange_back_mm = 1360", "flange_back_mm = 1360\nprofile_spacing_mm = 1500",
     "cannot stand next to profile_spacing_mm"),
    ("flange_back_mm = 1360", "profile_spacing_mm = 1500\nback_to_tape_circle_mm = 70", "goes with flange_back_mm"),
    ("radius_mm = 450", "radius_mm = 0.45", "wheelset.radius_mm = 0.45: must be a number from 100 to 1500"),
    ("radius_mm = 450", "radius_left_mm = 450", "wheelset.radius_right_mm is missing: goes with radius_left_mm"),
    ('wheel = "wheels/S1002.toml"', "", "wheelset.wheel is missing: must be a wheel profile file"),
    ('"wheels/S1002.toml"', '"wheels/S1003.toml"', 'car.toml:11: wheelset.wheel = "wheels/S1003.toml": not found in'),
    ('"wheels/S1002.toml"', '"rails/60E1.toml"', "a wheel profile is needed here"),
    ("[1, 2, 3]", "[1, 2]", "suspension.stiffness_kN_per_m = [1, 2]: must be three numbers not below 0"),
    ("date = 2026-01-31", 'date = "2026-01-31"', "must be a date without quotes"),
    ("[sprung]", "[spring]", "spring: unknown key; did you mean 'sprung'?"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), ONE_FAULT)
def test_one_fault_in_a_vehicle_file_is_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    said = fault(tmp_path, (old, new), text=VEHICLE)
    assert "\n" not in said and message in said


def test_a_profile_in_the_place_of_a_vehicle_is_told_as_such() -> None:
    with pytest.raises(InputError, match="is a profile file; a vehicle file"):
        load_vehicle(MODELS / "wheels/S1002.toml", FIND)


def test_a_missing_vehicle_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such vehicle file"):
        load_vehicle(tmp_path / "none.toml", FIND)
