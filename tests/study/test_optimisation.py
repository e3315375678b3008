"""The best candidate is where theory says, whatever stops the search; what fails and what limits is told."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.commands import ok
from support.functions import POSE, search_file, work_of
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim.contact.profiles.models import load_profile
from wrsim.errors import InputError
from wrsim.inputs.toml_files import read_bytes
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario, load
from wrsim.scenario.vehicle_build import given_value, vehicle_of
from wrsim.study.changed_files import changed_in, write_scenario, write_vehicle, write_wheel
from wrsim.study.collect import read_study
from wrsim.study.optimisation.outcome import (
    history,
    limits,
    multipliers,
    neighbours,
    optimisation_report,
    optimisation_tables,
    status_of,
)
from wrsim.study.optimisation.reading import read_optimisation
from wrsim.study.optimisation.search import Search
from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, DERAILED, Work
from wrsim.vehicle.vehicle_files import load_vehicle

ROOT = SCENARIOS.parent
MODELS = ROOT / "models"

TWO_KEYS = """
[[vary]]
key = "static.lateral_mm"
low = -1.5
high = 1.5
[[vary]]
key = "static.yaw_mrad"
low = -1.5
high = 1.5
"""
ONE_KEY = TWO_KEYS[: TWO_KEYS.rindex("[[vary]]")]
HOOK = 'hook = "hook.py:numbers"\noutput = '
OBJECTIVE = f'[[objective]]\n{HOOK}"f"\naim = "minimise"\n'
CONSTRAINT = f'[[constraint]]\n{HOOK}"g"\nat_most = 1\n'


def rosenbrock(lateral_mm: float, yaw_mrad: float) -> dict[str, float]:
    x, y = lateral_mm, yaw_mrad
    return {"f": (1.0 - x) ** 2 + 100.0 * (y - x * x) ** 2, "g": x * x + y * y}


@pytest.fixture(autouse=True)
def poses_without_a_run(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Scenarios are built once, functions stand for them, and nothing waits for the disk."""
    built = []

    def build_once(scenario: Scenario) -> Setup:
        built.append(built[0] if built else build(scenario))
        for file in built[0].files:
            read_bytes(file, "model file")
        return built[0]

    monkeypatch.setattr("wrsim.study.plan.build", build_once)
    monkeypatch.setattr("wrsim.results.files.os.fsync", lambda handle: None)
    monkeypatch.setattr("wrsim.study.optimisation.reading._probe", lambda candidates, scenario, sought: None)
    yield


def searched(folder: Path, text: str, work: Work) -> Search:
    file = search_file(folder, text)
    search = Search(read_optimisation(file, folder / "out"), work)
    search.run()
    return search


def test_rosenbrock_without_constraints_is_solved(tmp_path):
    text = TWO_KEYS + OBJECTIVE + "[search]\nevaluations = 500\n"
    search = searched(tmp_path, text, work_of(rosenbrock))
    assert search.ends == ["converged"]
    assert search.best().candidate.values == pytest.approx((1.0, 1.0), abs=5e-3)


def test_a_constrained_optimum_is_found_with_its_multiplier(tmp_path):
    """Least x^2 + y^2 / 2 with x + y >= 1: x = 1/3, y = 2/3, multiplier 2/3."""

    def function(lateral_mm: float, yaw_mrad: float) -> dict[str, float]:
        return {"f": lateral_mm**2 + 0.5 * yaw_mrad**2, "g": lateral_mm + yaw_mrad}

    text = TWO_KEYS + OBJECTIVE + CONSTRAINT.replace("at_most", "at_least") + "[search]\nevaluations = 400\n"
    search = searched(tmp_path, text + "tolerance = 1e-4\n", work_of(function))
    best = search.best()
    assert best.feasible
    assert best.candidate.values == pytest.approx((1.0 / 3.0, 2.0 / 3.0), abs=2e-3)
    ((name, multiplier),) = multipliers(search, neighbours(search))
    assert name == "g at least 1"
    assert multiplier == pytest.approx(2.0 / 3.0, rel=0.02)


def test_one_key_is_solved_by_a_few_candidates_and_its_bound_limits(tmp_path):
    """Least x + 2 / (x + 2); then a function whose least value is at a bound."""
    search = searched(
        tmp_path / "a", ONE_KEY + OBJECTIVE, work_of(lambda lateral_mm: {"f": 2.0 / (lateral_mm + 2.0) + lateral_mm})
    )
    assert search.best().candidate.values[0] == pytest.approx(2.0**0.5 - 2.0, abs=3e-3)
    assert len(search.known) < 20
    search = searched(tmp_path / "b", ONE_KEY + OBJECTIVE, work_of(lambda lateral_mm: {"f": -lateral_mm}))
    assert search.best().candidate.values == (1.5,)
    assert [line for line in limits(search, neighbours(search)) if "lateral_mm high = 1.5 (multiplier 3)" in line]


def test_one_key_comes_to_its_constraint_and_past_candidates_that_fail(tmp_path):
    """Least (x - 1.2)^2 with x^2 <= 1; what lies below -1 derails."""
    text = ONE_KEY + OBJECTIVE + CONSTRAINT
    function = work_of(
        lambda lateral_mm: {"f": (lateral_mm - 1.2) ** 2, "g": lateral_mm**2},
        lambda lateral_mm: DERAILED if lateral_mm < -1.0 else COMPLETED,
    )
    search = searched(tmp_path, text, function)
    assert search.best().feasible
    assert search.best().candidate.values[0] == pytest.approx(1.0, abs=4e-3)
    assert {status_of(evaluated) for evaluated in search.known.values()} == {
        COMPLETED,
        DERAILED,
        "exceeds a constraint",
    }


def test_a_search_that_was_killed_goes_on_to_the_same_bits(tmp_path):
    """Whole numbers and choices among the keys, some candidates derail."""
    text = (
        TWO_KEYS
        + (
            '[[vary]]\nkey = "contact.strips"\nlow = 5\nhigh = 40\nwhole = true\nstart = 20\n'
            '[[vary]]\nkey = "static.load_kN"\nchoices = [40, 60, 80]\n'
        )
        + OBJECTIVE
        + "[search]\nevaluations = 60\nseed = 5\n"
    )

    def function(lateral_mm: float, yaw_mrad: float, strips: int, load_kN: int) -> dict[str, float]:
        assert isinstance(strips, int) and load_kN in (40, 60, 80)
        return {"f": rosenbrock(lateral_mm, yaw_mrad)["f"] + (strips - 11) ** 2 + abs(load_kN - 80)}

    work = work_of(function, lambda lateral_mm, **rest: DERAILED if lateral_mm > 1.2 else COMPLETED)
    whole = searched(tmp_path / "whole", text, work)
    assert whole.best().candidate.values[3] == 80 and abs(whole.best().candidate.values[2] - 11) <= 2
    left = [30]

    class Killed(Exception):
        pass

    def killed(plan: Plan, todo: list[int]) -> None:
        for i in todo:
            left[0] -= 1
            if left[0] < 0:
                raise Killed
            work(plan, [i])

    with pytest.raises(Killed):
        searched(tmp_path / "again", text, killed)
    again = searched(tmp_path / "again", text, work)
    assert list(again.known) == list(whole.known)
    assert np.array_equal(history(again)["cost"].values, history(whole)["cost"].values, equal_nan=True)


def test_the_front_of_two_objectives_is_the_curve_between_their_optima(tmp_path):
    """Squares of the distances from two points: sqrt(f) + sqrt(g) is their distance all along the front."""

    def function(lateral_mm: float, yaw_mrad: float) -> dict[str, float]:
        x, y = lateral_mm, yaw_mrad
        return {"f": (x - 1.0) ** 2 + y**2, "g": x**2 + (y - 1.0) ** 2}

    objectives = OBJECTIVE + OBJECTIVE.replace('"f"', '"g"')
    text = TWO_KEYS + objectives + "[search]\nfront = 5\nevaluations = 500\n"
    search = searched(tmp_path, text, work_of(function))
    front = search.front()
    costs = np.array([point.costs for point in front])
    assert len(front) >= 5 and (np.diff(costs[:, 0]) > 0.0).all() and (np.diff(costs[:, 1]) < 0.0).all()
    detour = np.sqrt(costs).sum(axis=1) / 2.0**0.5 - 1.0
    assert detour.min() > -1e-12 and np.median(detour) < 0.01 and detour.max() < 0.1  # between two ceilings
    assert costs[:, 0].min() < 1e-3 and costs[:, 1].min() < 1e-3
    report = optimisation_report(search, [])
    assert report["limits"] == [] and "What limits it" not in optimisation_tables(report)


@pytest.mark.parametrize(("text", "message"), rows_of(__file__)("faults_of_the_file"))
def test_a_fault_of_the_file_is_one_error(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as error:
        read_optimisation(search_file(tmp_path, text), tmp_path / "out")
    assert "\n" not in str(error.value)


THERE = "wheelsets.wheelset.wheels.left.Q_max_kN", "wheelsets.wheelset.wheels.left.Q_max_20Hz_kN", "events.0.time_s"


def test_an_output_that_a_run_cannot_have_is_refused_by_its_first_steps(tmp_path, monkeypatch):
    """A place in a list that is empty at the start may be there at the end."""
    monkeypatch.undo()  # of what stands for runs in the other tests
    file = tmp_path / "optimisation.toml"
    vary = '[[vary]]\nkey = "contact.friction"\nlow = 0.2\nhigh = 0.4\nstart = 0.3\n'
    place = "wheelsets.wheelset.full_curves.0.left.Y_kN"
    text = f'base = "{SCENARIOS / "curve_r300.toml"}"\n{vary}[[objective]]\nsummary = "{place}"\naim = "minimise"\n'
    file.write_text(
        text + "".join(f'[[constraint]]\nsummary = "{place_in_list}"\nat_most = 1\n' for place_in_list in THERE)
    )
    read_optimisation(file, tmp_path / "out")
    wrong = place.replace("full_curves", "full_curve")
    file.write_text(text + f'[[constraint]]\nsummary = "{wrong}"\nat_most = 1\n')
    with pytest.raises(InputError) as error:
        read_optimisation(file, tmp_path / "out")
    message = 'constraint[0].summary: "wheelsets.wheelset.full_curve.0.left.Y_kN": "full_curve.0.left.Y_kN" is not in'
    assert f"{file.name}:11: {message}" in str(error.value) and "did you mean 'full_curves'" in str(error.value)


def test_a_command_writes_history_page_and_files_of_the_best_candidate(tmp_path, monkeypatch, unpainted):
    @contextmanager
    def pool(*arguments: object, **options: object) -> Iterator[Work]:
        yield work_of(rosenbrock)

    monkeypatch.setattr("wrsim.study.engine.worker_pool", pool)
    file = search_file(tmp_path, TWO_KEYS + OBJECTIVE + CONSTRAINT + "[search]\nevaluations = 30\n")
    text = ok("optimise", file, "-o", tmp_path / "out", "--no-pictures").output
    assert "candidates (" in text and "evaluations used up" in text
    report = json.loads((tmp_path / "out" / "optimisation.json").read_text())
    best = load(tmp_path / "out" / "best.toml")
    assert best.merged.data["static"]["yaw_mrad"] == report["best"]["values"]["static.yaw_mrad"]
    assert best.merged.data["static"]["load_kN"] == 60
    rows = (tmp_path / "out" / "history.csv").read_text().splitlines()
    assert len(rows) == 1 + report["evaluations"] and rows[0].startswith("evaluation,cost,f,g")
    assert "<h2" in (tmp_path / "out" / "optimisation.html").read_text()
    assert read_study(tmp_path / "out")["cost"].sizes == {"evaluation": report["evaluations"]}
    assert "at most 34 candidates, 34 cases" in ok("optimise", file, "-o", tmp_path / "out", "--dry-run").output


def test_files_of_changed_values_read_back_as_the_scenario_that_was_changed(tmp_path):
    """Keys of the vehicle by name, an entry of a list of the scenario, and names of files beside the vehicle's file."""
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "own.toml").write_text((MODELS / "wheels" / "S1002.toml").read_text())
    vehicle = (MODELS / "vehicles" / "manchester_1.toml").read_text().replace("wheels/S1002.toml", "own.toml")
    (tmp_path / "models" / "coach.toml").write_text(vehicle)
    (tmp_path / "run.toml").write_text(
        f'base = "{SCENARIOS / "manchester_r300.toml"}"\n[vehicle]\nmodel = "models/coach.toml"\n'
    )
    base = load(tmp_path / "run.toml")
    changes = {"vehicle.bogie.primary.stiffness_kN_per_m.2": 1500.5, "track.segments[2].radius_m": 310.0}
    wanted = base.with_values(changes)
    file = write_scenario(tmp_path / "out" / "best.toml", base, changes, "Best", ["found by hand"])
    read = load(file)
    assert file.read_text().startswith("# found by hand\n")
    assert read.merged.data | {"title": ""} == wanted.merged.data | {"title": ""}
    assert changed_in(changes, "changes") and not changed_in(changes, "wheel_changes")
    written = write_vehicle(tmp_path / "out" / "vehicle.toml", wanted)
    assert load_vehicle(written).elements == vehicle_of(wanted).elements
    assert '"../models/own.toml"' in written.read_text()


def test_keys_of_a_wheel_profile_are_varied_and_written(tmp_path):
    """A flanged wheel by its angle; of a worn one the depth of a bell: both are of the file, and reach the wheel."""
    (tmp_path / "own.toml").write_text(
        'name = "own"\nbody = "wheel"\nkind = "flanged"\ndate = 2026-01-31\nsource = "made up"\n'
        "flange_angle_deg = 68\nflange_length_mm = 20\n"
    )
    (tmp_path / "pose.toml").write_text(POSE.replace("[track]", 'wheel = "own.toml"\n[track]'))
    base, key = load(tmp_path / "pose.toml"), "vehicle.wheel_changes.flange_angle_deg"
    assert given_value(base, key) == 68
    changed = base.with_values({key: 74.0})
    wheel = vehicle_of(changed).wheelsets[0].wheelset.left.profile
    slopes = np.abs(wheel.slope_angle(np.linspace(0.0, wheel.length, 2000)))
    assert np.degrees(slopes.max()) == pytest.approx(74.0, abs=1e-6)
    written = write_wheel(tmp_path / "out" / "wheel.toml", changed)
    assert load_profile(written, "wheel").length == pytest.approx(wheel.length, rel=1e-12)
    worn = base.with_values({"vehicle.wheel": "wheels/S1002_worn.toml"})
    bell = "vehicle.wheel_changes.removals[0].depth_mm"
    assert isinstance(given_value(worn, bell), int | float)
    deeper = vehicle_of(worn.with_values({bell: given_value(worn, bell) + 0.5}))
    assert deeper.wheelsets[0].wheelset.left.profile != vehicle_of(worn).wheelsets[0].wheelset.left.profile
    with pytest.raises(InputError, match=r"flange_angle = 70.*did you mean"):
        vehicle_of(base.with_values({"vehicle.wheel_changes.flange_angle": 70}))


@pytest.mark.campaign
def test_the_damping_of_a_body_over_waves_is_that_of_the_closed_form(tmp_path: Path) -> None:
    """A mass m on springs k and a damper c over waves of amplitude z at frequencies w: the mean square acceleration is
    (z w^2)^2 / 2 (k^2 + c^2 w^2) / ((k - m w^2)^2 + c^2 w^2); the derivative of the sum over two w vanishes."""
    mass, stiffness, speeds, length = 8000.0, 4e5, np.array([37.7952, 85.0392]) / 3.6, 31 * 0.3048
    w = 2.0 * np.pi * speeds / length
    dynamic, squares = (stiffness - mass * w * w) ** 2, w**4
    slope = np.sqrt(squares * w * w * np.abs(dynamic - stiffness**2))
    damping = np.sqrt((slope[0] * dynamic[1] - slope[1] * dynamic[0]) / (slope[1] * w[0] ** 2 - slope[0] * w[1] ** 2))
    ok("optimise", ROOT / "tests/data/two_mass/damping.toml", "-o", tmp_path / "found", "--no-pictures", "-q")
    report = json.loads((tmp_path / "found/optimisation.json").read_text())
    (optimum,) = report["best"]["values"].values()
    assert 4.0 * 1e3 * optimum == pytest.approx(damping, rel=1e-3)
    assert report["evaluations"] <= 200
