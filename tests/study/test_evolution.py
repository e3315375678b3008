"""Wheels that wear in service: steps, mass, what a killed service does, wrong input."""

import datetime
import json
import shutil
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from support.commands import ok, refusal
from support.rows import rows_of
from support.runs import SCENARIOS
from support.scenario_texts import DATA

from wrsim.errors import InputError, SimulationError
from wrsim.results import write_atomically
from wrsim.results.files import EVOLUTION, as_json, digest_of, holds
from wrsim.results.netcdf import write_netcdf
from wrsim.study.evolution.history import read_history, wear_history, write_history
from wrsim.study.evolution.reading import Evolution, read_evolution
from wrsim.study.evolution.stages import STAGES, tableau
from wrsim.study.evolution.steps import STEP, Step, folder_of, read_step, wear_steps
from wrsim.study.plan import PLAN, Plan
from wrsim.study.task import run_case

table = rows_of(__file__)

BASE, CASES, SERVICE = (
    (DATA / name).read_text() for name in ("service_base.toml.in", "service_cases.csv", "service.toml")
)


def service_in(folder: Path, more: str = "", cases: str = CASES, text: str = SERVICE) -> Evolution:
    """A service of a curve and nearly straight track."""
    (folder / "base.toml").write_text(BASE.format(scenario=SCENARIOS / "curve_r300.toml"))
    (folder / "cases.csv").write_text(cases)
    (folder / "service.toml").write_text(text + more)
    return read_evolution(folder / "service.toml")[0]


def work(plan: Plan, todo: Sequence[int]) -> None:
    """Run the cases here, one after the other, as a worker does."""
    write_atomically(Path(plan.folder) / PLAN, plan.dumped())
    for index in todo:
        run_case(plan.folder, digest_of(plan.dumped()), index)


@pytest.fixture(scope="module", autouse=True)
def two_stages() -> Iterator[None]:
    """Heun's in the place of four: mass, files and going on do not hang on how many there are."""
    with pytest.MonkeyPatch.context() as patch:
        heun = np.array([[0.0, 0.0], [1.0, 0.0]]), np.full(2, 0.5)
        patch.setattr("wrsim.study.evolution.steps.tableau", lambda: heun)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("service")


@pytest.fixture(scope="module")
def evolution(folder: Path) -> Evolution:
    return service_in(folder)


@pytest.fixture(scope="module")
def steps(evolution: Evolution, folder: Path) -> list[Step]:
    return list(wear_steps(evolution, folder / "out", work))


def test_mass_off_the_wheels_is_mass_lost(evolution: Evolution, steps: list[Step]) -> None:
    """What is off the section, times the ring and the density, against what tread and flange lost on the way.

    The ring's radius at each place is that of the profile that ran there."""
    lost = sum(step.way * (step.tread + step.flange) for step in steps)
    areas = np.array(steps[-1].areas)
    middles = 0.5 * (evolution.places[1:] + evolution.places[:-1])
    radius = 0.46 - evolution.unworn.at(middles)[1]
    off = 7850.0 * (2.0 * np.pi * radius * areas * evolution.places[1]).sum()
    assert off == pytest.approx(lost, rel=1e-4)


def test_a_service_that_was_killed_gives_the_same_to_the_bit(evolution, steps, folder, tmp_path, monkeypatch):
    """Killed in its second step, one case done; then all that it had is read, on the next day as well."""
    whole = folder / "out"
    shutil.copytree(folder_of(whole, 0), folder_of(tmp_path, 0))

    class Killed(Exception):
        pass

    def killed(plan: Plan, todo: Sequence[int]) -> None:
        work(plan, todo[:1])
        raise Killed

    with pytest.raises(Killed):
        list(wear_steps(evolution, tmp_path, killed))
    assert not (folder_of(tmp_path, 1) / STEP).exists()
    ran: list[int] = []

    def rest(plan: Plan, todo: Sequence[int]) -> None:
        ran.append(len(todo))
        work(plan, todo)

    class Tomorrow(datetime.date):
        @classmethod
        def today(cls) -> "Tomorrow":
            day = datetime.date.today() + datetime.timedelta(days=1)
            return cls(day.year, day.month, day.day)

    monkeypatch.setattr("wrsim.study.evolution.steps.date", Tomorrow)
    again = list(wear_steps(evolution, tmp_path, rest))
    assert again == steps
    assert ran == [1] + [2] * (2 * (len(steps) - 1) - 1)
    for i in range(len(steps)):
        assert (folder_of(tmp_path, i) / STEP).read_bytes() == (folder_of(whole, i) / STEP).read_bytes()

    def nothing(plan: Plan, todo: Sequence[int]) -> None:
        raise AssertionError("all was done")

    assert list(wear_steps(evolution, tmp_path, nothing)) == steps


def test_stages_are_of_second_order_and_stay_stable() -> None:
    """Chebyshev's method: exact for a rate that grows evenly, damped for any that decays, up to 9.8 of its time."""
    before, whole = tableau()
    places = before.sum(axis=1)
    assert whole.sum() == pytest.approx(1.0, abs=1e-13) and whole @ places == pytest.approx(0.5, abs=1e-13)
    assert places[0] == 0.0 and (np.diff(places) > 0.0).all() and places[-1] < 1.0

    def growth(z: float) -> float:
        return float(1.0 + z * whole @ np.linalg.solve(np.eye(STAGES) - z * before, np.ones(STAGES)))

    assert max(abs(growth(z)) for z in np.linspace(-9.8, -0.01, 300)) < 1.0
    assert abs(growth(-12.0)) > 1.0
    off = [abs(growth(-z) - np.exp(-z)) for z in (0.1, 0.05)]
    assert off[0] / off[1] == pytest.approx(8.0, rel=0.1)


@pytest.mark.usefixtures("unpainted")
def test_the_page_of_a_service_holds_numbers_pictures_and_files_and_takes_it_alone(evolution, steps, tmp_path):
    write_history(evolution, steps, tmp_path, pictures=False)
    assert holds(tmp_path, EVOLUTION) and not holds(tmp_path.parent, EVOLUTION)
    ok("report", tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert str(evolution.wheel) not in page  # no place of this machine
    assert all(text in page for text in (evolution.source.title, "Sd [mm]", "left,0.5,500,60"))
    summary = page[page.index('id="h-summary"') : page.index('id="identity"')]
    assert all(text in summary for text in ("wear by the law", "Flange thickness Sd: from", "Equivalent conicity"))
    assert page.count("<img ") == 2 and page.count('<tr><th scope="row">') > len(steps)
    for more, message in ((tmp_path, "a report takes one profile evolution"), ("--view", "it is for results of runs")):
        assert message in refusal("report", tmp_path, more)
    write_netcdf(tmp_path / "wear.nc", read_history(tmp_path).drop_vars("depth"))
    assert "but has no depth; run it again" in refusal("report", tmp_path)


@pytest.mark.usefixtures("sketched")
def test_history_tells_the_flange_and_can_be_loaded(evolution: Evolution, steps: list[Step], tmp_path: Path) -> None:
    dataset, files = write_history(evolution, steps, tmp_path, pictures=True)
    assert {"wear.nc", "wear.csv", "wear.json", "worn_wheel.toml", "wear_profiles.png", "wear_mileage.png"} == {
        file.name for file in files
    }
    assert tomllib.loads((tmp_path / "worn_wheel.toml").read_text())["date"] == datetime.date.today()
    assert dataset.sizes["point"] == len(steps) + 1
    assert dataset["flange_thickness"].values[0] == pytest.approx(32.5e-3, abs=1e-6)
    assert dataset["flange_height"].values[-1] > dataset["flange_height"].values[0] - 1e-9
    assert (np.diff(dataset["deepest"].values) > 0.0).all()
    assert np.isfinite(dataset["conicity"].values).all()
    again = wear_history(evolution, steps)
    assert again.identical(dataset)


def test_a_finished_service_is_told_again_and_another_does_not_go_on_with_its_steps(steps, folder, tmp_path):
    """Nothing is left to run: no worker comes."""
    told = json.loads(ok("wear", folder / "service.toml", "-o", folder / "out", "--no-pictures", "--json").stdout)
    assert told["steps"] == len(steps) and told["worn"]["mileage_km"] == pytest.approx(40.0)
    assert told["worn"]["depth_mm"] > told["new"]["depth_mm"] == 0.0
    another_service = service_in(tmp_path, cases=CASES.replace("20000,80", "20000,85"))
    with pytest.raises(InputError, match="was computed from another profile evolution"):
        next(wear_steps(another_service, folder / "out", work))


@pytest.mark.parametrize("odd", [
    b"", b"[]", b"\xff", b"[" * 100_000, b"{}", {"areas": 3}, {"areas": ["x"]}, {"areas": []}, {"way": "x"},
    {"way": None}, {"way": -1.0}, {"way": float("nan")}, {"start": 10**400}, {"mileage": 1.0},
], ids=lambda odd: str(odd)[:20])  # fmt: skip
def test_a_step_file_with_odd_content_counts_as_none(odd: object, evolution: Evolution, tmp_path: Path) -> None:
    areas = (0.0,) * (evolution.places.size - 1)
    whole = asdict(Step(0, 0.0, 1e3, 1e-9, 1e-7, 0.0, areas, evolution.digest))
    (tmp_path / STEP).write_bytes(json.dumps(whole).encode())
    assert read_step(evolution, tmp_path) == Step(**whole)
    older = {"service" if key == "evolution" else key: value for key, value in whole.items()}
    (tmp_path / STEP).write_bytes(json.dumps(older).encode())
    assert read_step(evolution, tmp_path) == Step(**whole), "under its older name"
    (tmp_path / STEP).write_bytes(odd if isinstance(odd, bytes) else json.dumps(whole | dict(odd)).encode())  # type: ignore[call-overload]
    assert read_step(evolution, tmp_path) is None


def test_a_case_without_a_result_or_with_an_unknown_key_stops_the_service(tmp_path: Path) -> None:
    """No step is written, and the error names the case."""
    evolution = service_in(tmp_path)

    def idle(plan: Plan, todo: Sequence[int]) -> None:
        pass

    with pytest.raises(SimulationError, match="case case left: no result"):
        list(wear_steps(evolution, tmp_path / "out", idle))
    assert not (folder_of(tmp_path / "out", 0) / STEP).exists()
    evolution = service_in(tmp_path, cases=CASES.replace("vehicle.speed_kmh", "vehicle.sped_kmh"))
    with pytest.raises(InputError, match="sped_kmh"):
        list(wear_steps(evolution, tmp_path / "out", work))


def test_a_service_ends_where_its_wheel_would_overlap_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Normals of a flange's tip meet 12 mm under it. No contact takes so much off there: losses are given here, those
    of a first step that was done before and of the next one."""
    evolution = service_in(tmp_path, more="largest_depth_mm = 1\n")
    middles = 0.5 * (evolution.places[1:] + evolution.places[:-1])
    tip = np.exp(-(((evolution.unworn.at(middles)[0] + 57e-3) / 2.5e-3) ** 2))
    done = Step(0, 0.0, 20e3, 3e-7, 0.0, 0.0, tuple((6.6e-3 * tip).tolist()), evolution.digest)
    write_atomically(folder_of(tmp_path, 0) / STEP, as_json(asdict(done)))
    monkeypatch.setattr("wrsim.study.evolution.steps._lost", lambda evolution, plan: (1e-6 * tip, 0.0, 0.0))
    monkeypatch.setattr("wrsim.study.evolution.steps.missing", lambda plan: [])
    with pytest.raises(InputError) as caught:
        list(wear_steps(evolution, tmp_path, work))
    assert "service.toml: step 1, from 20 to 2" in str(caught.value)
    assert "the removed material makes the profile overlap itself at u = -5" in str(caught.value)
    assert not (folder_of(tmp_path, 1) / STEP).exists()


FAULTS = table("faults")


@pytest.mark.parametrize(("changes", "message"), FAULTS)
def test_wrong_input_is_one_clear_error(changes: dict[str, str], message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        service_in(tmp_path, **changes)
    assert message in str(caught.value)
    assert "Traceback" not in str(caught.value)
