"""Rails that change along the track, in scenarios and runs."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.rows import rows_of
from support.runs import FAST, SCENARIOS
from support.vehicles import Train, manchester, on_track

from wrsim import Arc, Flat, Harmonic, InputError, Result, load, load_profile, load_text, load_vehicle, run
from wrsim.analysis.resolve import resolve_contacts
from wrsim.inputs.lookup import shipped_models
from wrsim.inputs.toml_files import write_toml
from wrsim.results.moments import sample_of
from wrsim.scenario.build import build
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails, steady_state
from wrsim.simulation.step_size import eigenvalues
from wrsim.track.track import RailElasticity

table = rows_of(__file__)


NEW, WORN = "rails/60E1.toml", "rails/60E1_worn.toml"


def section(place: float, rail: str = NEW, **more: Any) -> dict[str, Any]:
    return {"at_m": place, "rail": rail, **more}


@pytest.fixture(scope="module")
def lowered() -> Result:
    """A wheelset that runs from new rails to worn ones 2 mm lower."""
    values = {"track.rail_sections": [section(3.0), section(4.5, down_mm=1.0), section(6.0, WORN, down_mm=2.0)]}
    more = {"run.distance_m": 7.0, "vehicle.speed_kmh": 30, "output.patches_at_m": [1, 7], "run.output_interval_ms": 5}
    return run(load(SCENARIOS / "rail_states.toml").with_values(values | more | FAST))


def test_a_wheelset_follows_its_rails_and_they_are_drawn_as_they_are_at_each_moment(lowered: Result) -> None:
    dataset = lowered.wheelset()
    height = dataset["vertical_shift"].values
    assert height[-1] - height[0] == pytest.approx(
        -2e-3, abs=5e-5
    )  # the worn rail's running surface is as high as the new one's
    assert dataset["Q"].values[-1] == pytest.approx(dataset["Q"].values[0], rel=2e-3)
    heights = lowered.wheelset()["rail_profile_z"].max("rail_point").values
    assert heights[0] == pytest.approx(heights[0].mean(), abs=1e-5)
    assert heights[-1] - heights[0] == pytest.approx(-2e-3, abs=1e-5)


def test_a_check_rail_takes_a_wheelset_by_the_back_of_its_flange() -> None:
    """Its face is 6:1, its rail inclined 1:40. Before it all is as on the plain rail."""
    short = {"run.start_distance_m": 9.3, "run.distance_m": 1.5, "output.patches_at_m": []}
    scenario = load(SCENARIOS / "check_rail.toml").with_values(short | FAST)
    checked = run(scenario).wheelset()
    plain = run(scenario.with_values({"track.rail_sections": [], "run.distance_m": 0.2})).wheelset()
    before = plain["lateral_shift"].values[0]
    assert before < -6e-3 and checked["lateral_shift"].values[0] == pytest.approx(before, abs=1e-8)
    assert checked["Q"].values[0] == pytest.approx(plain["Q"].values[0], rel=1e-5)
    last = checked.isel(time=-1)
    assert -4.4e-3 < last["lateral_shift"].item() < -4.0e-3
    patches = last.sel(wheel="left")
    back = int(np.nanargmin(patches["contact_angle"].values))
    steep = np.arctan(6.0) - np.arctan(1.0 / 40.0)
    assert patches["contact_angle"].values[back] == pytest.approx(-steep, abs=2e-3)
    assert patches["N"].values[back] > 2e4
    # the flange of the other wheel is free: its contact lies on the tread
    assert abs(np.nanmax(last.sel(wheel="right")["contact_angle"].values)) < 0.35
    assert last["Y"].sel(wheel="left").item() < 0.0


@pytest.mark.parametrize("keep", ["pose", "load"])
def test_contacts_are_solved_again_on_the_rail_of_their_place(lowered: Result, keep: Any) -> None:
    before = lowered.wheelset()
    scenario = load_text(str(lowered.dataset.attrs["scenario_text"]), SCENARIOS)
    after = resolve_contacts(lowered, scenario, "file", keep=keep).wheelset()
    rows = [sample_of(before, m) for m in range(before.sizes["snapshot"])]
    for name in ("N", "p0", "Q", "contact_angle", "u_rail"):
        assert after[name].values == pytest.approx(before[name].values[rows], rel=1e-4, nan_ok=True)
    assert after["rail_profile_z"].values == pytest.approx(before["rail_profile_z"].values, nan_ok=True)


def test_a_wheel_that_drops_into_a_gap_says_where() -> None:
    """No rail any more: a floor 25 mm lower."""
    gap = [section(s, down_mm=25.0 * (s > 5.0)) for s in (4.7, 5.0, 5.01, 5.95)]
    values = {
        "track.rail_sections": gap,
        "run.start_distance_m": 4.95,
        "run.distance_m": 0.9,
        "output.patches_at_m": [],
    }
    result = run(load(SCENARIOS / "rail_states.toml").with_values(values | {"vehicle.speed_kmh": 60} | FAST))
    assert result.status == "stopped"
    match = re.search(
        r"wheel has dropped into a gap of its rail, or beside it, at .* ([\d.]+) m along the track", result.stop_reason
    )
    assert match and 5.0 < float(match[1]) < 5.6
    lifted = result.dataset["event_label"].values.tolist()
    assert any("loses contact" in label for label in lifted)


def write_sections(path: Path, heights: dict[float, float], features: str = "1 2") -> Path:
    """Points of a new rail, a quarter of a millimetre apart, at places [m] moved up [mm]; features on its top."""
    rail = load_profile(shipped_models() / NEW)
    arc = np.linspace(0.0, rail.length, round(rail.length / 0.25e-3))
    u, w = (1e3 * a for a in rail.at(arc))
    marks = [""] * arc.size
    marks[int(w.argmax())] = features
    rows = [
        f"{place:g},{y:.9f},{z:.9f},{mark}"
        for place, up in heights.items()
        for y, z, mark in zip(u, w + up, marks, strict=True)
    ]
    path.write_text("\n".join(["at_m,outward_mm,up_mm,feature", *rows]), encoding="utf-8")
    return path


def test_a_table_of_sections_is_the_rail_of_its_files(tmp_path: Path) -> None:
    """Sections of one table lie where those of single files do, corner on corner."""
    file = str(write_sections(tmp_path / "rail.csv", {-1.0: 0.0, 0.5: -1.0, 2.0: -2.0}))
    single = [section(4.0), section(5.5, down_mm=1.0), section(7.0, down_mm=2.0)]
    scenario = load(SCENARIOS / "rail_states.toml")
    whole, from_table = (
        build(scenario.with_values({"track.rail_sections": sections, "track.inclination": "none"})).surfaces[1]
        for sections in (single, [{"at_m": 5.0, "table": file}])
    )
    assert whole is not None and from_table is not None
    assert [table_section.distance for table_section in from_table.sections] == pytest.approx([4.0, 5.5, 7.0])
    for ours, theirs in zip(from_table.sections, whole.sections, strict=True):
        assert ours.features[0] == ours.features[1] == pytest.approx(ours.profile.top_arclength, abs=0.25e-3)
        arc = np.linspace(0.0, theirs.profile.length, 500)
        away = np.array(ours.profile.at(arc)) - np.array(theirs.profile.at(arc))
        assert np.abs(away).max() < 2e-6  # a spline over arcs and lines that meet with a jump of curvature


TABLE_FAULTS = [
    ("1 x", 'feature = "1 x": must be numbers of features'),
    ("at_m,outward_mm,up_mm\n0,1,2\n0,2,2", "2 different points; a profile needs at least 10"),
    ({0.0: 0.0, 50.0: 0.0}, "its section at 50 m lies at 55 m: it must be on the track, which is 40 m long"),
    ({0.0: 0.0, -1.0: 0.0}, "at_m = -1: must be more than 0 of the section before"),
    ({0.0: 0.0}, "has 1 sections; at least 2 are needed"),
    ("1 1", "duplicate feature 1 in this section"),
    ("1 3", "feature 2 is missing in the section that begins here"),
]


@pytest.mark.parametrize(("content", "message"), TABLE_FAULTS, ids=[message[:30] for _, message in TABLE_FAULTS])
def test_a_fault_in_a_table_names_its_line(content: str | dict[float, float], message: str, tmp_path: Path) -> None:
    file = tmp_path / "rail.csv"
    if isinstance(content, dict):
        write_sections(file, content)
    elif "," in content:
        file.write_text(content)
    else:
        write_sections(file, {0.0: 0.0, 1.0: 0.0}, content)
    values = {"track.rail_sections": [{"at_m": 5.0, "table": str(file)}]}
    with pytest.raises(InputError) as caught:
        build(load(SCENARIOS / "rail_states.toml").with_values(values))
    assert message in str(caught.value)


FAULTS: list[tuple[dict[str, Any], str]] = table("faults")  # fmt: skip


@pytest.mark.parametrize(("values", "message"), FAULTS, ids=[message[:30] for _, message in FAULTS])
def test_one_fault_is_one_clear_error(values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build(load(SCENARIOS / "rail_states.toml").with_values(values))
    assert message in str(caught.value) and len(str(caught.value).splitlines()) == 1


# Elastic rails: a mass on spring and damper under each wheel of a vehicle.
TRACK = RailElasticity(stiffness=(25e6, 50e6), damping=(40e3, 60e3), mass=(120.0, 160.0))
SPEED = 15.0
CURVED = (Arc(400.0, 800.0, cant=0.04),)


@cache
def train(elastic: bool, curved: bool = False) -> Train:
    segments = {"segments": CURVED} if curved else {}
    return on_track(manchester(), SPEED, structure=TRACK if elastic else None, **segments)


@cache
def steady(elastic: bool, curved: bool = False):
    law = train(elastic, curved).law
    if not curved:
        return steady_state(law)
    q, q_t = design_state(law, lateral=-3e-3)  # a curve is searched for from outward
    law.set_search_start(50.0)
    q, q_t = lower_on_rails(law, q, q_t)
    return steady_state(law, (q, q_t))


def wheel_forces(law, q, q_t) -> np.ndarray:
    """Forces of the wheels on the rails along n and b (wheelset, left and right, 2) [N]."""
    law(0.0, q, q_t, np.zeros(law.size))
    return np.array(
        [[(-w.side * w.model.arrays.total["Fo"], -w.model.arrays.total["Fb"]) for w in pair] for pair in law.wheels]
    )


@pytest.mark.parametrize("curved", [False, True], ids=["straight", "curve"])
def test_in_steady_motion_the_springs_of_the_rails_carry_the_wheels(curved: bool) -> None:
    law, state = train(True, curved).law, steady(True, curved)
    moved = state.q[-16:].reshape(4, 2, 2)
    forces = wheel_forces(law, state.q, state.q_t)
    assert moved * np.array(TRACK.stiffness) == pytest.approx(
        forces, abs=0.02
    )  # N; the displacements are settled to 0.1 nm
    assert forces[:, :, 1].sum() == pytest.approx(-manchester().mass * 9.80665, rel=1e-2 if curved else 1e-6)
    if curved:  # the flanges push the rails apart
        assert np.abs(moved[:, :, 0]).max() > 1e-5


def test_a_vehicle_sinks_with_its_rails_and_nothing_else_changes() -> None:
    rigid, elastic = steady(False), steady(True)
    n = 6 * len(train(True).law.bodies)
    sunk = manchester().mass * 9.80665 / 8.0 / TRACK.stiffness[1]
    change = (elastic.q[:n] - rigid.q[:n]).reshape(-1, 6)
    assert change[:, 0] == pytest.approx(-sunk, rel=1e-3)  # wheels of both ends are not loaded quite alike
    assert np.abs(change[:, 2:5]).max() < 2e-6  # lateral shift, heading, roll


def test_a_rail_moved_like_its_vehicle_changes_no_force() -> None:
    law, rigid = train(True).law, train(False).law
    q, q_t = steady(False).q, steady(False).q_t
    n, size = 6 * len(law.bodies), rigid.size
    plain = np.zeros(size)
    rigid(0.0, q, q_t, plain)
    q_all, q_t_all = np.concatenate([q, np.zeros(16)]), np.concatenate([q_t, np.zeros(16)])
    rails = q_all[-16:].reshape(4, 2, 2)
    rates = q_t_all[-16:].reshape(4, 2, 2)
    rails[:], rates[:] = (2e-3, -1e-3), (0.01, -0.02)
    for column, by in ((2, 2e-3), (0, -1e-3)):
        q_all[column:n:6] += by
    for column, by in ((2, 0.01), (0, -0.02)):
        q_t_all[column:n:6] += by
    out = np.zeros(law.size)
    law(0.0, q_all, q_t_all, out)
    # the pull along the track and round-off of the places are all that may differ
    assert out[:n] == pytest.approx(plain[:n], abs=5.0)
    # and each piece is accelerated by its wheel's force, spring and damper
    forces = wheel_forces(law, q_all, q_t_all)
    law(0.0, q_all, q_t_all, out)
    expected = (forces - rails * np.array(TRACK.stiffness) - rates * np.array(TRACK.damping)) / np.array(TRACK.mass)
    assert out[-16:].reshape(4, 2, 2) == pytest.approx(expected, rel=1e-12)


def test_a_rail_without_its_wheel_swings_at_its_own_frequency() -> None:
    law = train(True).law
    q, q_t = design_state(law)
    q[: 6 * len(law.bodies) : 6] += 0.05  # lifted off
    values = eigenvalues((system := train(True).system).forces, system.bodies, q, q_t)
    for stiffness, damping, mass in zip(TRACK.stiffness, TRACK.damping, TRACK.mass, strict=True):
        half = 0.5 * damping / mass
        expected = -half + 1j * np.sqrt(stiffness / mass - half**2)
        assert (np.abs(values - expected) < 1e-3 * abs(expected)).sum() == 8


# Wheels out of round in vehicle files, scenarios, poses and runs.
ROOT = Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios/flat.toml"
WHEELSET = ROOT / "models/vehicles/wheelset_s1002.toml"
R, MM = 0.46, 1e-3


def with_table(**table):
    return load(SCENARIO).with_values({"vehicle.out_of_round": [table], "contact.normal": "kik-piotrowski"})


def test_a_vehicle_file_gives_its_wheels_their_shape(tmp_path):
    vehicle_file = tmp_path / "wheelset.toml"
    vehicle_file.write_text(
        WHEELSET.read_text().replace("wheels/", f"{ROOT}/models/wheels/")
        + '\n[[wheelset.out_of_round]]\nkind = "flat"\nwheel = "right"\nlength_mm = 40\nat_deg = 90\n'
        + '[[wheelset.out_of_round]]\nkind = "harmonic"\norder = 3\namplitude_mm = 0.1\nphase_deg = 90\n'
    )
    wheelset = load_vehicle(vehicle_file).wheelsets[0].wheelset
    wave = Harmonic(3, 0.1 * MM, np.pi / 2)
    assert wheelset.left.out_of_round == (wave,)
    flat, wave_of_right = wheelset.right.out_of_round
    assert wave_of_right == wave and isinstance(flat, Flat)
    assert_allclose([flat.length, flat.angle, flat.deepest], [0.04, np.pi / 2, 0.04**2 / (8 * R)], rtol=1e-3)
    assert wheelset.with_wheel("right", None, 0.45).right.out_of_round == (flat, wave)


@pytest.mark.parametrize("table, message", table("what_cannot_be_is_refused_with_its_key"))
def test_what_cannot_be_is_refused_with_its_key(table, message):
    with pytest.raises(InputError) as error:
        build(with_table(**table))
    assert message in str(error.value) and "vehicle.out_of_round[0]" in str(error.value)


@pytest.mark.parametrize("rows, message", table("a_file_of_radii_that_is_no_wheel_is_refused_with_its_line"))
def test_a_file_of_radii_that_is_no_wheel_is_refused_with_its_line(tmp_path, rows, message):
    file = tmp_path / "radii.csv"
    file.write_text(rows)
    with pytest.raises(InputError) as error:
        build(with_table(kind="radius", file=str(file)))
    assert f"{file}" in str(error.value) and message in str(error.value)


def test_measured_radii_and_sections_are_the_wave_that_they_were_made_of(tmp_path):
    angle = np.arange(0, 360, 2)
    file = tmp_path / "radii.csv"
    rows = [f"{a},{100.0 * np.cos(np.radians(3 * a)):.9f}" for a in angle]
    file.write_text("\n".join(["angle_deg,deviation_um", *rows]))
    (part,) = build(with_table(kind="radius", file=str(file))).wheelset.left.out_of_round
    angles = np.arange(720) * np.pi / 360
    depth_of_table = part.depth(angles, np.zeros(0), R)[:, 0]
    # a wave of 3 around is 0.5^((3 / 289)^2) of itself behind a limit of 10 mm
    assert_allclose(depth_of_table, -1e-4 * np.cos(3 * angles), atol=2e-8)
    for name, conicity in (("a", 0.025), ("b", 0.035)):
        (tmp_path / f"{name}.toml").write_text(
            f'name = "{name}"\nbody = "wheel"\nkind = "cone"\nconicity = {conicity}\nfrom_mm = -50\nto_mm = 60\n'
            'date = 2026-11-26\nsource = "a line"\n'
        )
    sections = tmp_path / "sections.csv"
    sections.write_text("angle_deg,profile\n0,a.toml\n120,b.toml\n240,a.toml\n")
    scenario = with_table(kind="sections", file=str(sections), cutoff_mm=0)
    scenario = scenario.with_values({"vehicle.wheel": str(tmp_path / "a.toml")})
    (part,) = build(scenario).wheelset.left.out_of_round
    depth = part.depth(np.radians([0.0, 120.0, 240.0]), np.array([-0.01, 0.02]), R)
    assert_allclose(depth, [[0.0, 0.0], [-1e-4, 2e-4], [0.0, 0.0]], atol=1e-9)


@pytest.mark.parametrize("speed", [60, 120])
def test_the_default_step_holds_the_blow_of_a_flat_within_a_percent(speed):
    """At 120 km/h the wheel leaves the rail; half of the steps give 1.4 % at 60 km/h."""
    keys = {"vehicle.speed_kmh": speed, "vehicle.out_of_round[0].at_deg": 15.0, "run.output_interval_ms": 0.1}
    tables = load(SCENARIO).with_values(keys | {"run.time_s": 0.16 * 3.6 / speed}).merged.data
    tables["run"].pop("step_us")
    peaks = [
        float(run(load_text(write_toml(tables | {"run": tables["run"] | more}), ROOT)).dataset["Q"].max())
        for more in ({}, {"step_us": 10})
    ]
    assert peaks[1] > 1e5 and peaks[0] == pytest.approx(peaks[1], rel=0.009)


def test_poses_turn_the_wheel():
    """A rounded flat lowers the wheel by its depth, less what the flatter wheel is pressed in less."""
    values = {
        "vehicle.out_of_round": [{"kind": "flat", "shape": "rounded", "length_mm": 120, "depth_mm": 0.4, "at_deg": 5}],
        "static.load_kN": 50,
        "static.lateral_mm": 0,
        "static.yaw_mrad": 0,
        "static.wheel_angle_deg": [-90, 5],
    }
    data = run(load(ROOT / "scenarios/static_s1002.toml").with_values(values)).dataset
    high, low = data["vertical_shift"].values
    assert_allclose(high - low, 0.4e-3, atol=2e-5)
    assert [str(name) for name in data["pose"].values] == ["y+0_angle-90", "y+0_angle+5"]
