"""Any number of a scenario, a vehicle or a track file is changed by names of parts and elements."""

from pathlib import Path

import pytest
from support.rows import rows_of

from wrsim import InputError, load, load_text, load_vehicle
from wrsim.scenario.build import build
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.vehicle.elements import Spring
from wrsim.vehicle.vehicle import Vehicle

table = rows_of(__file__)

SCENARIOS = Path(__file__).parents[2] / "scenarios"
COACH, LINE, TRAIN = (SCENARIOS / f"{name}.toml" for name in ("manchester_r300", "mixed_line", "train_s_curve"))


def springs(vehicle: Vehicle, name: str) -> list[Spring]:
    return [e for e in vehicle.elements if isinstance(e, Spring) and f".{name} " in f".{e.name}"]


def test_a_number_of_an_element_is_changed_wherever_its_part_is_placed() -> None:
    whole = load(COACH).with_set(["vehicle.bogie.primary.stiffness_kN_per_m.2=1500"])
    found = springs(vehicle_of(whole), "primary")
    assert len(found) == 8
    assert {e.stiffness for e in found} == {(31391e3, 3884e3, 1500e3)}


@pytest.mark.parametrize("key", ["primary.stiffness_kN_per_m[2]", "parts.bogie.elements[0].stiffness_kN_per_m.2"])
def test_short_and_full_names_mean_the_same(key: str) -> None:
    short, full = (
        vehicle_of(load(COACH).with_values({f"vehicle.{k}": 1500})) for k in (key, "bogie.primary.stiffness_kN_per_m.2")
    )
    assert short == full


def test_the_text_of_a_changed_scenario_is_whole() -> None:
    changed = load(COACH).with_values({"vehicle.carbody.mass_kg": 40_000, "vehicle.gravity_m_per_s2": 9.8})
    again = vehicle_of(load_text(changed.text))
    assert again == vehicle_of(changed)
    assert again.weight == pytest.approx(9.8 * (load_vehicle("vehicles/manchester_1.toml").mass + 8000))


def test_vehicles_of_a_train_are_changed_by_their_names() -> None:
    changed = vehicle_of(
        load(TRAIN).with_values({"vehicle.coach.carbody.mass_kg": 40_000, "vehicle.coach.driven": False})
    )
    assert [b.mass for b in changed.bodies if b.name.endswith("carbody")] == [40_000.0] * 3
    assert not any(member.driven for member in changed.members)


REFUSED = {
    "vehicle.bogie.primry.at_mm.1": r"there is no 'primry' in parts.bogie \(did you mean 'primary'\?\)",
    "vehicle.bogie.primary.stiffnes_kN_per_m": "unknown key; did you mean 'stiffness_kN_per_m', which is given already",
    "vehicle.bogie.primary.stiffness_kN_per_m.3": r"there is no such entry; there are 3, \[0\] to \[2\]",
    "vehicle.wheelset.axle.modes": r"a new table is given as a whole, such as wheelset.axle=\{modes = ...\}",
    "vehicle.carbody.mass_kg.x": "'bodies.carbody.mass_kg' = 32000 is no table",
    "vehicle.sped_kmh": "did you mean 'speed_kmh'",
    "trak.gauge_mm": "did you mean 'track'",
    "track.segments[9].radius_m": r"there are 5, \[0\] to \[4\]",
    "track.segments.2.radius_m": "must be a number of size 10",
    "vehicle.bogie.primary.stifness_kN_per_m.2": "did you mean 'stiffness_kN_per_m'",
}


@pytest.mark.parametrize("key", REFUSED)
def test_a_mistake_in_set_is_named_as_such(key: str) -> None:
    with pytest.raises(InputError, match=rf"^--set {key.replace('[', '.').replace(']', '.')}=-1: .*{REFUSED[key]}"):
        vehicle_of(load(COACH).with_set([f"{key}=-1"]))


@pytest.mark.parametrize(("option", "words"), table("words_of_other_programs_lead_to_ours"))
def test_words_of_other_programs_lead_to_ours(option: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        build(load(COACH).with_set([option]))


def test_a_file_that_set_names_is_looked_up_in_the_working_directory_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_bytes((SCENARIOS.parent / "models/vehicles/wheelset_s1002.toml").read_bytes())
    changed = load(COACH).with_set(["vehicle.model=mine.toml"])
    assert [w.name for w in build(changed).vehicle.wheelsets] == ["wheelset"]
    with pytest.raises(InputError, match="not found"):
        build(load(COACH).with_values({"vehicle.model": "mine.toml"}))
