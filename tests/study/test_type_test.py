"""Type tests: the runs of a programme, and verdicts on forces that are known."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from support import synthetic_run
from support.rows import rows_of
from support.runs import ROOT, SCENARIOS
from support.scenario_texts import DATA
from support.synthetic_run import Q0

from wrsim import InputError, run_type_test
from wrsim.analysis.stationary.at_rest import numbers_at_rest
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.study import type_test as tests_of_type
from wrsim.study.programme import Programme, ProgrammeRun, read_programme
from wrsim.study.task import COMPLETED, DERAILED, RESULT, Marker, write_marker

table = rows_of(__file__)

TEXT = (DATA / "type_test.toml.in").read_text()


def programme_file(folder: Path, more: str = "", old: str = "", new: str = "") -> Path:
    file = folder / "test.toml"
    file.write_text(TEXT.format(base=SCENARIOS / "type_test" / "coach_base.toml", more=more).replace(old, new, 1))
    return file


@pytest.fixture(scope="module")
def programme(tmp_path_factory) -> Programme:
    folder = tmp_path_factory.mktemp("programme")
    return read_programme(programme_file(folder), folder / "out")


def test_every_state_makes_every_run_with_speed_and_length_by_the_rules(programme):
    assert programme.names == ("straight", "R 300 left", "R 300 right")
    assert len(programme.plan.cases) == 2 * 3
    frictions = [programme.plan.scenario(case).spec.contact.friction for case in programme.plan.cases]
    assert frictions == [0.4] * 3 + [0.2] * 3
    straight, left, right = (programme.plan.scenario(case).spec for case in programme.plan.cases[:3])
    speed = left.vehicle.speed_kmh / 3.6
    assert 1500.0 * speed**2 / (9.80665 * 300.0) == pytest.approx(100.0 + 80.0)
    arcs = [next(s for s in spec.track.segments if s.kind == "arc") for spec in (left, right)]
    assert [arc.radius_m for arc in arcs] == [300.0, -300.0]
    assert arcs[0].length_m == 3 * 70.0  # EN 14363, very small radii
    assert straight.track.segments[0].length_m == 2 * 250.0 + 2 * 60.0
    seeds = [spec.track.irregularities[0].seed for spec in (straight, left, right)]
    assert seeds == [7, 8, 9]


@cache
def invented(radius: float, **forces) -> bytes:
    """The file of a result with these forces, in a curve of that radius."""
    curvature = synthetic_run.curve(radius) if radius else np.zeros_like
    with TemporaryDirectory() as folder:
        return synthetic_run.run(step=4e-3, curvature=curvature, **forces).save(Path(folder) / RESULT).read_bytes()


def filled(folder: Path, statuses=(COMPLETED,) * 6, file: Path | None = None, **forces) -> Path:
    """The file of a programme whose runs are all done, with invented forces in those of the first state."""
    file = file or programme_file(folder)
    plan = read_programme(file, folder / "out").plan
    for i, (case, status) in enumerate(zip(plan.cases, statuses, strict=True)):
        case_folder = plan.folder_of(case)
        case_folder.mkdir(parents=True)
        radius = (0.0, 300.0, -300.0)[case.place[1]]
        (case_folder / RESULT).write_bytes(invented(radius, **forces if i < 3 else {}))
        ended = Marker(
            case.name, case.label, status, "" if status == COMPLETED else "it fell", outputs=plan.outputs_digest
        )
        write_marker(case_folder, replace(ended, time_limit=plan.time_limit))
    return file


def verdicts(report) -> dict[tuple[str, str], list[bool | None]]:
    rows: dict[tuple[str, str], list[bool | None]] = {}
    for verdict in report.value:
        rows.setdefault((verdict.state, verdict.clause), []).append(verdict.ok)
    return rows


def test_sound_runs_are_within_every_limit_and_a_second_run_gives_the_same_bytes(tmp_path, monkeypatch):
    file = filled(tmp_path)
    file.write_text(file.read_text().replace("[[states]]", 'stationary = ["twist"]\n[[states]]', 1))
    clause = {
        "clause": "twist",
        "symbol": "dQ/Q0",
        "unit": "1",
        "limit_source": "[read]",
        "passed": True,
        "lowest": False,
    }
    at_rest = {"twist_test": clause | {"value": 0.31, "limit": 0.6, "margin": 0.5}}
    monkeypatch.setattr(tests_of_type, "stationary_tests", lambda *arguments: (at_rest, None, ()))
    first = run_type_test(file, tmp_path / "out")
    assert verdicts(first)["wet", "twist"] == [True]
    assert first["passed"] is True and first.code == 0
    assert all(ok is not False for outcomes in verdicts(first).values() for ok in outcomes)
    contents = {path.name: path.read_bytes() for path in first.files}
    assert set(contents) == {"type_test.json", "type_test.csv", "type_test.html"}
    monkeypatch.setattr(tests_of_type, "stationary_tests", None)  # stored, too
    second = run_type_test(file, tmp_path / "out")
    assert second["ran"] == 0
    assert {path.name: path.read_bytes() for path in second.files} == contents


def test_a_force_beyond_its_limit_turns_its_clause_red_in_its_state_alone(tmp_path):
    # 40 kN to one side: beyond k1 (10 + 2Q0/3) = 43.3 kN together with 10 kN to the other
    red = run_type_test(filled(tmp_path, y=lambda s: (40e3 + 0.0 * s, -10e3 + 0.0 * s)), tmp_path / "out")
    assert red.code == 4 and red["passed"] is False
    rows = verdicts(red)
    assert set(rows["new", "track shift"]) == {False}
    assert set(rows["wet", "track shift"]) == {True}
    assert set(rows["new", "vertical force"]) == {True}
    record = json.loads((tmp_path / "out" / "type_test.json").read_text())
    assert {v["clause"] for v in record["verdicts"] if v["ok"] is False} >= {"track shift"}
    mean = next(v for v in record["verdicts"] if v["clause"] == "vertical force")
    low, high = map(float, mean["interval"].split(" to "))
    assert low == high == pytest.approx(1e-3 * Q0, rel=1e-3)  # without scatter


def test_a_run_takes_waves_besides_the_spectrum_and_the_vehicle_rests_on_its_cant_deficiency(tmp_path):
    waves = '\n[[runs.irregularities]]\nkind="mcat"\ndeviation="alinement"\nchord_ft=62\nfrom_m=170\namplitude_mm=19\n'
    file = programme_file(
        tmp_path, 'stationary = ["cant"]\nrules = "49cfr213"', "[irregularities]", waves + "[irregularities]"
    )
    text = file.read_text()
    for friction, height in ((0.4, 1800), (0.2, 12000)):
        with_height = f'{friction}, "vehicle.carbody.centre_mm" = [0, 0, {height}] }}'
        text = text.replace(f"{friction} }}", with_height)
    file.write_text(text)
    programme = read_programme(file, tmp_path / "out")
    scenarios = [programme.plan.scenario(case) for case in programme.plan.cases]
    kinds = [[irregularity.kind for irregularity in scenario.spec.track.irregularities] for scenario in scenarios[:3]]
    assert kinds == [["spectrum"], ["spectrum", "mcat"], ["spectrum", "mcat"]]
    report = run_type_test(filled(tmp_path, file=file), tmp_path / "out")
    at_rest = {v.clause: v for v in report.value if v.zone == "at rest" and v.state == "new"}
    assert verdicts(report)["wet", "cant"] == [False]  # it overturns
    assert set(at_rest) == {"213.57(d)(1)(i)", "213.57(d)(1)(ii)", "sway"}
    lean = numbers_at_rest(vehicle_of(scenarios[0]), 80.0)["leaning"]
    least = min(1.0 - lost for wheel_losses in lean["unloading"].values() for lost in wheel_losses.values())
    share = at_rest["213.57(d)(1)(i)"]
    assert float(share.worst) == pytest.approx(least, rel=1e-3) and share.ok is (least >= 0.6)
    assert share.share == pytest.approx((least - 0.6) / 0.4, rel=1e-3)
    assert float(at_rest["sway"].worst) == pytest.approx(lean["flexibility_coefficient"]["carbody"], rel=1e-3)


def test_a_load_aside_springs_too_soft_and_worn_wheels_are_red_at_rest_as_by_hand(tmp_path):
    file = programme_file(tmp_path, 'stationary = ["weighing", "settling", "conicity"]\npayload_kg = 8000')
    text, wheels, springs = file.read_text(), ("S1002", "S1002_worn"), (430, 160)
    for friction, aside, stiffness, wheel in zip((0.4, 0.2), (50, 250), springs, wheels, strict=True):
        changes = f'"vehicle.carbody.centre_mm" = [0, {aside}, 1800], "vehicle.wheelset.wheel" = "wheels/{wheel}.toml"'
        changes += f', "vehicle.bogie.secondary.stiffness_kN_per_m.2" = {stiffness}'
        text = text.replace(f"{friction} }}", f"{friction}, {changes} }}")
    file.write_text(text)
    report = run_type_test(filled(tmp_path, file=file), tmp_path / "out")
    rest = {(v.state, v.clause): v for v in report.value if v.zone == "at rest"}
    sound, faulty = ({clause: v for (state, clause), v in rest.items() if state == name} for name in ("new", "wet"))
    assert all(v.ok for v in sound.values()) and not any(v.ok for v in faulty.values())
    plan = read_programme(file, tmp_path / "out").plan
    vehicle = vehicle_of(plan.scenario(plan.cases[0]))
    half = 0.5 * vehicle.wheelsets[0].wheelset.profile_spacing
    for state, aside, stiffness in zip((sound, faulty), (0.05, 0.25), springs, strict=True):
        share = 32000.0 * aside / (vehicle.mass * half)
        assert float(state["wheel loads"].worst) == pytest.approx((1.0 + share) / (1.0 - share), rel=2e-3)
        sinking = 8.0 * 9.80665 * (1.0 / (4 * stiffness) + 1.0 / (8 * 1220.0)) * 1e3  # springs in series [mm]
        assert float(state["buffer height"].worst) == pytest.approx(sinking, rel=0.03)  # they lean, too


def test_a_run_that_derails_is_red(tmp_path):
    report = run_type_test(filled(tmp_path, (DERAILED, *[COMPLETED] * 5)), tmp_path / "out")
    assert verdicts(report)["new", "every run comes to its end"] == [False]
    assert verdicts(report)["wet", "every run comes to its end"] == [True]
    assert any("new, straight: it fell" in note for note in report["notes"])


@pytest.mark.parametrize(("more", "old", "new", "message"), table("a_programme_that_cannot_be_run_is_refused"))
def test_a_programme_that_cannot_be_run_is_refused(tmp_path, more, old, new, message):
    with pytest.raises(InputError, match=message):
        run_type_test(programme_file(tmp_path, more, old, new), tmp_path / "out", dry_run=True)


def test_runs_take_the_former_key_of_their_directions():
    run = {"name": "R 300", "radius_m": 300.0, "speed_kmh": 60.0, "sections": 3}
    assert ProgrammeRun.model_validate(run | {"hands": "left"}).directions == "left"
    with pytest.raises(ValueError, match="unknown key"):
        ProgrammeRun.model_validate(run | {"hands": "left", "directions": "right"})


def test_a_rule_set_beside_the_programme_judges_its_runs(tmp_path, monkeypatch):
    shipped = (ROOT / "wrsim" / "assessment" / "data" / "en14363.toml").read_text()
    (tmp_path / "mine.toml").write_text(shipped.replace('id = "track shift"', 'id = "shift by my rules"'))
    file = filled(tmp_path)
    file.write_text(file.read_text().replace("[[states]]", 'rules = "mine.toml"\n[[states]]', 1))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    report = run_type_test(file, tmp_path / "out")
    assert report["ran"] == 0
    assert verdicts(report)["new", "shift by my rules"]
