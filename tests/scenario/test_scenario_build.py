"""A scenario becomes a wheelset on a track: SI units, poses, a place for every wheel on its rail."""

import math
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.rows import rows_of
from support.scenario_texts import CURVE, STATIC, edited, faults

from wrsim import InputError, Vehicle, load, load_profile, load_text, load_vehicle
from wrsim.contact.settings import USUAL
from wrsim.inputs.checking import check_value
from wrsim.inputs.file_kinds import resolved
from wrsim.inputs.values import Series
from wrsim.register import ANALYSES, TABLES
from wrsim.scenario.build import Setup, build
from wrsim.scenario.plausibility import facts, warnings
from wrsim.scenario.schema import ScenarioFile
from wrsim.scenario.sections.static import read_cases
from wrsim.scenario.track_build import SAMPLES, flange_clearance, misplaced
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.track.track import RailElasticity
from wrsim.vehicle.elements import Spring
from wrsim.vehicle.loads import SlipControl

table = rows_of(__file__)

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_everything_is_si_behind_build() -> None:
    setup = build(load_text(CURVE + "step_us = 500\n"))
    assert setup.plan.speed == pytest.approx(15.0)
    assert (setup.plan.start, setup.plan.end) == (0.0, pytest.approx(190.0))
    assert setup.plan.duration == pytest.approx(190.0 / 15.0)
    assert (setup.plan.step, setup.plan.output_interval) == (pytest.approx(5e-4), pytest.approx(5e-3))
    assert setup.plan.patches_at == (pytest.approx(130.0),), "the middle of the arc unless told otherwise"
    assert setup.track.nominal_gauge == pytest.approx(1.435)
    assert float(setup.track.curvature(130.0)) == pytest.approx(1 / 300)
    assert float(setup.track.cant(130.0)) == pytest.approx(0.060)
    assert setup.wheelset.profile_spacing == pytest.approx(1.5)
    assert setup.contact.friction == (0.35, 0.35)
    assert setup.contact.rail.shear_modulus == pytest.approx(82.03e9, rel=1e-4)


ON_ROLLERS = {"track.rollers": {"radius_mm": 800.0}}
REFUSED_ON_ROLLERS = table("keys_that_rollers_refuse")


@pytest.mark.parametrize(("scenario", "keys", "message"), REFUSED_ON_ROLLERS)
def test_keys_that_rollers_refuse(scenario, keys, message):
    with pytest.raises(InputError, match=message):
        build(load(SCENARIOS / f"{scenario}.toml").with_values(ON_ROLLERS | keys))


def test_rollers_are_si_behind_build_and_told_in_the_result() -> None:
    setup = build(load(SCENARIOS / "equilibrium_s1002.toml").with_values(ON_ROLLERS))
    assert setup.roller == pytest.approx(0.8)
    assert setup.attributes()["structure"] == "rollers of radius 800 mm, every wheelset over their tops"


def test_elasticity_of_rails_and_a_limit_of_slip_are_si_behind_build() -> None:
    keys = {"vehicle.drive": "wheels", "vehicle.slip_control": {"slip_kmh": 3.6, "creepage": 0.1}}
    setup = build(load(SCENARIOS / "manchester_mixed_line.toml").with_values(keys))
    assert setup.track.structure == RailElasticity((25e6, 50e6), (40e3, 60e3), (120.0, 160.0))
    assert setup.vehicle.slip_control == SlipControl(1.0, 0.1)


def test_overrides_of_the_vehicle_hold_for_their_side() -> None:
    text = edited(
        CURVE,
        "speed_kmh = 54",
        'speed_kmh = 54\nradius_left_mm = 459\nwheel_right = "wheels/cone_1in20.toml"\nsprung_mass_kg = 100',
    )
    setup = build(load_text(text))
    wheelset = setup.wheelset
    assert (wheelset.left.radius, wheelset.right.radius) == (0.459, 0.46)
    assert wheelset.left.profile.name == "S1002"
    assert wheelset.right.profile.name != "S1002"
    assert setup.vehicle.carried[0].mass == 100.0


def test_each_rail_has_its_own_profile_and_friction_and_each_body_its_own_material() -> None:
    text = edited(CURVE, 'rail = "rails/60E1.toml"', 'rail_left = "rails/60E1.toml"\nrail_right = "rails/54E1.toml"')
    text = edited(
        text,
        "friction = 0.35",
        "friction_left = 0.1\nfriction_right = 0.5\n[contact.material]\npoisson = 0.3\n"
        "[contact.material.wheel]\nyoungs_modulus_GPa = 200",
    )
    setup = build(load_text(text))
    assert setup.rails[0].name != setup.rails[1].name
    assert setup.contact.friction == (0.1, 0.5)
    assert setup.contact.wheel.youngs_modulus == pytest.approx(200e9)
    assert setup.contact.rail.youngs_modulus == pytest.approx(210e9)
    assert setup.contact.wheel.poisson_ratio == setup.contact.rail.poisson_ratio == 0.3


def test_an_arc_by_its_angle_is_as_long_as_radius_times_angle() -> None:
    track = build(load_text(edited(CURVE, "length_m = 120", "angle_deg = 90"))).track
    assert track.length == pytest.approx(70 + 300 * math.pi / 2)


def test_values_can_be_changed_from_python_and_are_checked_again() -> None:
    scenario = load_text(CURVE)
    changed = scenario.with_values({"vehicle.speed_kmh": 36, "track.segments[2].radius_m": -500, "run.distance_m": 5})
    assert changed.spec.vehicle.speed_kmh == 36.0
    assert changed.spec.track.segments[2].radius_m == -500.0
    assert load_text(changed.text).spec == changed.spec
    assert scenario.spec.vehicle.speed_kmh == 54.0, "a scenario does not change"
    with pytest.raises(InputError, match=r"new value: contact\.friction = 7: must be a number from 0 to 2"):
        scenario.with_values({"contact.friction": 7})
    with pytest.raises(InputError, match=r"track\.segments\[7\]: there is no such entry"):
        scenario.with_values({"track.segments[7].radius_m": 7})


def test_a_grid_gives_every_combination_with_names_that_differ() -> None:
    text = edited(STATIC, "lateral_mm = 0", "lateral_mm = {from = -1, to = 1, step = 0.1}\nyaw_mrad = [0, 12]")
    poses = build(load_text(text)).plan.poses
    assert len(poses) == len({p.name for p in poses}) == 42
    assert poses[0].lateral == pytest.approx(-1e-3)
    assert poses[-1].lateral == 1e-3
    assert {p.yaw for p in poses} == {0.0, 0.012}
    assert {p.load for p in poses} == {60e3}


@given(first=st.floats(-50, 50), count=st.integers(0, 400), step=st.floats(1e-3, 1.0))
def test_a_range_holds_its_ends_and_equal_steps(first: float, count: int, step: float) -> None:
    last = first + count * step
    values = np.array(check_value(Series[float], {"from": first, "to": last, "step": step}, "range"))
    assert len(values) == count + 1
    assert values[0] == first
    assert values[-1] == pytest.approx(last, abs=1e-9)
    assert values[-1] <= last
    assert np.diff(values) == pytest.approx(step, abs=1e-9)


def test_a_table_gives_its_rows_with_their_names(tmp_path: Path) -> None:
    table = "# poses of the test bench\nid, load_kN, lateral_mm, yaw_mrad\n\nstraight, 24, 0, 0\nflange, 24, 9.5, 12\n"
    (tmp_path / "poses.csv").write_text(table)
    text = edited(STATIC, "lateral_mm = 0\nload_kN = 60", 'cases = "poses.csv"')
    (tmp_path / "case.toml").write_text(text)
    setup = build(load(tmp_path / "case.toml"))
    assert [p.name for p in setup.plan.poses] == ["straight", "flange"]
    assert setup.plan.poses[1].lateral == pytest.approx(9.5e-3)
    assert setup.plan.poses[1].yaw == pytest.approx(12e-3)
    assert tmp_path / "poses.csv" in setup.files


TABLE_FAULTS = table("table_faults")


@pytest.mark.parametrize(("table", "message"), TABLE_FAULTS)
def test_one_fault_in_a_table_is_one_line_with_its_line_number(tmp_path: Path, table: str, message: str) -> None:
    (tmp_path / "poses.csv").write_text(table)
    with pytest.raises(InputError) as told:
        read_cases(tmp_path / "poses.csv")
    lines = str(told.value).split("\n")
    assert len(lines) == 1
    assert lines[0].startswith(str(tmp_path / "poses.csv"))
    assert message in lines[0]


@pytest.mark.parametrize(("gauge_mm", "reason"), table("a_wheelset_off_the_rails_is_refused_with_the_reason"))
def test_a_wheelset_off_the_rails_is_refused_with_the_reason(tmp_path: Path, gauge_mm: int, reason: str) -> None:
    (line,) = faults(edited(CURVE, "gauge_mm = 1435", f"gauge_mm = {gauge_mm}"), tmp_path)
    case = tmp_path / "case.toml"
    assert line.startswith('case.toml:8: track.rail = "')
    assert line.endswith(f"; see track.gauge_mm in {case}:7 and vehicle.model in {case}:4")
    assert "the wheelset is placed off the rails" in line
    assert reason in line


def test_a_narrowing_without_room_and_a_default_that_does_not_fit_are_refused(tmp_path: Path) -> None:
    text = edited(CURVE, "length_m = 120", "length_m = 120\ngauge_widening_mm = -12")
    (line,) = faults(text, tmp_path)
    assert "at a gauge of 1423 mm" in line
    assert "flange" in line
    scenario = load(
        Path(__file__).parents[2] / "scenarios" / "manchester_r300.toml"
    )  # starts where runs start by default
    short_track = scenario.with_values({"track.segments": [{"kind": "straight", "length_m": 9.0}]})
    with pytest.raises(InputError, match=r"run.start_distance_m: must lie on the track, which is 9 m long"):
        build(short_track)


def test_s1002_on_standard_gauge_has_the_flange_clearance_of_its_drawing() -> None:
    """Flange thickness 32.5 mm, flange backs 1360 mm: (1435 - 1360)/2 - 32.5 = 5 mm a side."""
    setup = build(load_text(CURVE))
    wheel, spacing = setup.wheelset.left.profile, setup.wheelset.profile_spacing
    assert flange_clearance(wheel.table(SAMPLES)[0], spacing, 1.435) == pytest.approx(5e-3, abs=1e-4)
    assert not misplaced(wheel, setup.rails[0], spacing, 1.435)


@pytest.mark.parametrize(("changes", "beginnings"), table("slips_that_are_allowed_are_warned_of"))
def test_slips_that_are_allowed_are_warned_of(changes, beginnings):
    messages = warnings(build(load(SCENARIOS / "curve_r300.toml").with_values(changes)))
    assert len(messages) == len(beginnings)
    assert all(warning.startswith(word) for warning, word in zip(messages, beginnings, strict=True))
    assert all("is outside of the usual" in w for w in messages)


@pytest.mark.parametrize(("changes", "patterns"), table("implausible_runs_are_warned_of_once"))
def test_implausible_runs_are_warned_of_once(changes, patterns):
    """Each just beyond its limit; just within there is none."""
    messages = warnings(build(load(SCENARIOS / "curve_r300.toml").with_values(changes)))
    assert len(messages) == len(patterns), messages
    assert all(re.search(word, warning) for warning, word in zip(messages, patterns, strict=True)), messages


def test_a_scan_of_the_other_body_is_told(tmp_path: Path) -> None:
    """Scans that do not say what they are of, the wheel upright or the wrong way up."""
    for name, profile in (("wheel", load_profile("wheels/S1002.toml")), ("rail", load_profile("rails/60E1.toml"))):
        u, w = profile.at(np.linspace(0.0, profile.length, 400))
        np.savetxt(tmp_path / f"{name}.csv", 1e3 * np.column_stack([u, w]), delimiter=",")
    scenario = load(SCENARIOS / "curve_r300.toml")
    (told,) = warnings(build(scenario.with_values({"track.rail": (tmp_path / "wheel.csv").as_posix()})))
    assert "profile 'wheel' of a rail is shaped like a wheel" in told
    with pytest.raises(InputError, match=r"rail.csv: .* unless it is a rail: no flange is seen"):
        build(scenario.with_values({"vehicle.wheel": (tmp_path / "rail.csv").as_posix()}))
    right = {"vehicle.wheel": (tmp_path / "wheel.csv").as_posix(), "track.rail": (tmp_path / "rail.csv").as_posix()}
    assert warnings(build(scenario.with_values(right))) == []


@pytest.mark.parametrize(
    ("normal", "creep"), [("kik-piotrowski", "fastsim"), ("strips", "fastrip"), ("half-space", "half-space")]
)
def test_each_normal_model_has_its_usual_creep_forces_and_strips(normal, creep):
    scenario = load(SCENARIOS / "static_s1002.toml").with_values({"contact.normal": normal})
    usual = build(scenario).contact
    assert (usual.creep_forces, usual.strip_count, usual.flexibility) == (creep, USUAL[normal].strips, "blended")
    assert facts(build(scenario))["tangential"] == creep
    named = build(scenario.with_values({"contact.tangential": "polach", "contact.strips": 30})).contact
    assert (named.creep_forces, named.strip_count) == ("polach", 30)
    if normal == "strips":
        with pytest.raises(
            InputError, match=r"contact\.strip_width_mm = 0\.2: goes with normal = .*strips = 12 to 200"
        ):
            build(scenario.with_values({"contact.strip_width_mm": 0.2}))
    else:
        by_width = build(scenario.with_values({"contact.strip_width_mm": 0.2})).contact
        assert (by_width.strip_count, by_width.strip_width) == (None, pytest.approx(2e-4))
    assert usual.fast().creep_forces == ("fastsim" if normal == "kik-piotrowski" else "fastrip")


# The register of analyses: what it names is there, and a scenario takes the tables that it says.
@pytest.mark.parametrize("name", ANALYSES)
def test_every_function_that_the_register_names_is_there(name: str) -> None:
    analysis = ANALYSES[name]
    named = [getattr(analysis, field.name) for field in fields(analysis)]
    dotted = [value for value in named if isinstance(value, str) and ":" in value]
    assert len(dotted) >= 2
    assert all(callable(resolved(value)) for value in dotted)


def test_a_scenario_takes_the_tables_of_all_analyses() -> None:
    assert set(TABLES) < set(ScenarioFile.model_fields)
    for name, place in TABLES.items():
        assert resolved(place).header == f"[{name}]"


# Any number of a scenario, a vehicle or a track file is changed by names of parts and elements.
COACH, LINE, TRAIN = (SCENARIOS / f"{name}.toml" for name in ("manchester_r300", "mixed_line", "train_s_curve"))


def springs(vehicle: Vehicle, name: str) -> list[Spring]:
    return [e for e in vehicle.elements if isinstance(e, Spring) and f".{name} " in f".{e.name}"]


def test_a_number_of_an_element_is_changed_wherever_its_part_is_placed() -> None:
    whole = load(COACH).with_set(["vehicle.bogie.primary.stiffness_kN_per_m.2=1500"])
    assert whole.text == load(COACH).with_set({"vehicle.bogie.primary.stiffness_kN_per_m.2": 1500}).text
    primary = springs(vehicle_of(whole), "primary")
    assert len(primary) == 8
    assert {e.stiffness for e in primary} == {(31391e3, 3884e3, 1500e3)}


@pytest.mark.parametrize("key", ["primary.stiffness_kN_per_m[2]", "parts.bogie.elements[0].stiffness_kN_per_m.2"])
def test_short_and_full_names_mean_the_same(key: str) -> None:
    short, full = (
        vehicle_of(load(COACH).with_values({f"vehicle.{k}": 1500})) for k in (key, "bogie.primary.stiffness_kN_per_m.2")
    )
    assert short == full


def test_what_is_set_in_text_or_by_name_is_in_the_whole_vehicle_or_train() -> None:
    changed = load(COACH).with_values({"vehicle.carbody.mass_kg": 40_000, "vehicle.gravity_m_per_s2": 9.8})
    again = vehicle_of(load_text(changed.text))
    assert again == vehicle_of(changed)
    assert again.weight == pytest.approx(9.8 * (load_vehicle("vehicles/manchester_1.toml").mass + 8000))
    changed = vehicle_of(
        load(TRAIN).with_values({"vehicle.coach.carbody.mass_kg": 40_000, "vehicle.coach.driven": False})
    )
    assert [b.mass for b in changed.bodies if b.name.endswith("carbody")] == [40_000.0] * 3
    assert not any(member.driven for member in changed.members)
    tram = load(SCENARIOS / "tram_car_r25.toml").with_values({'vehicle.frame."frame".mass_kg': 2000})
    assert [b.mass for b in vehicle_of(tram).bodies[1:]] == [2000.0] * 2  # a body of the name of its part


@pytest.mark.parametrize(("key", "message"), table("a_mistake_in_set_is_named_as_such"))
def test_a_mistake_in_set_is_named_as_such(key: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"^--set {key.replace('[', '.').replace(']', '.')}=-1: .*{message}"):
        vehicle_of(load(COACH).with_set([f"{key}=-1"]))


@pytest.mark.parametrize(("option", "message"), table("words_of_other_programs_lead_to_ours"))
def test_words_of_other_programs_lead_to_ours(option: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build(load(COACH).with_set([option]))


def test_a_file_that_set_names_is_looked_up_in_the_working_directory_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_bytes((SCENARIOS.parent / "models/vehicles/wheelset_s1002.toml").read_bytes())
    changed = load(COACH).with_set(["vehicle.model=mine.toml"])
    assert [w.name for w in build(changed).vehicle.wheelsets] == ["wheelset"]
    with pytest.raises(InputError, match="not found"):
        build(load(COACH).with_values({"vehicle.model": "mine.toml"}))


def test_cases_of_a_study_share_what_is_the_same_for_them(tmp_path: Path) -> None:
    """Parts of equal tables and files are one object, and a set-up is that of a build of its own. Others are not
    shared: of a changed key, of a changed file, and outside of a study."""
    rail = tmp_path / "rail.toml"
    rail.write_text((SCENARIOS.parent / "models/rails/60E1.toml").read_text())
    base = load(SCENARIOS / "curve_r300.toml").with_values({"track.rail": str(rail)})
    digests = {str(rail): "before"}

    def built(changes: dict[str, object]) -> Setup:
        return build(base.with_values(changes), digests)

    slow, fast = built({"vehicle.speed_kmh": 40.0}), built({"vehicle.speed_kmh": 60.0, "contact.friction": 0.2})
    alone = build(base.with_values({"vehicle.speed_kmh": 60.0, "contact.friction": 0.2}))
    assert fast.vehicle is slow.vehicle is not alone.vehicle and fast.rails is slow.rails is not alone.rails
    assert fast.track is slow.track is not alone.track, "with its tables"
    assert built({"run.distance_m": 50.0}).track.reach < slow.track.reach
    near, far = (built({"run.time_s": 2.0, "vehicle.speed_kmh": speed}) for speed in (40.0, 60.0))
    assert near.track is far.track and near.plan.end + 10.0 < far.plan.end, "as far as ends some metres apart"
    assert fast.attributes() == alone.attributes() and fast.files == alone.files
    assert fast.vehicle == alone.vehicle and fast.plan == alone.plan and fast.contact == alone.contact
    heavy = built({"vehicle.sprung_mass_kg": 1.1 * slow.vehicle.carried[0].mass})
    assert heavy.vehicle != slow.vehicle and heavy.rails is slow.rails
    rail.write_text(rail.read_text().replace('name = "60E1"', 'name = "another"'))
    digests[str(rail)] = "after"
    assert built({}).rails[0].name != slow.rails[0].name
