"""What the commands do, as functions: each takes scenarios, results or files and returns an `Outcome`.

The command line calls these functions; `wrsim.run` is ``wrsim run`` of any analysis (curving, steady, stability ...).
Files are written where ``output`` names a folder; messages of errors name options as the command line writes them.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from markupsafe import Markup

from wrsim.errors import DIFFERENT, INTERRUPTED, STOPPED, InputError
from wrsim.results.table import Table, as_html, as_text
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.report.document import Cover
    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario
    from wrsim.vehicle.vehicle import Vehicle

    Given: TypeAlias = Result | str | Path
    Bar: TypeAlias = Callable[[], AbstractContextManager[Any]]


log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a function found.

    tables: for people, printed and shown in notebooks; numbers: the same as plain records, as of ``--json``; files:
    that were written; found: the object behind; code: exit code of the command, 0 where all went well; folder: of the
    files, where they share one; lines: that follow the tables.
    """

    tables: Sequence[Table]
    numbers: dict[str, Any]
    files: Sequence[Path] = ()
    found: Any = None
    code: int = 0
    folder: Path | None = None
    lines: Sequence[str] = ()

    def __repr__(self) -> str:
        return "\n".join(filter(None, (as_text(self.tables), *self.lines, *map(str, self.files))))

    def _repr_html_(self) -> str:
        return Markup("<div>{}</div>").format(Markup("").join(map(as_html, self.tables)))

    def __getitem__(self, key: str) -> Any:
        return self.numbers[key]


def _read(given: Given) -> Result:
    from wrsim.report.output_folder import read
    from wrsim.results import Result

    return given if isinstance(given, Result) else read(Path(given))


def _several(given: Given | Sequence[Given]) -> list[Given]:
    from wrsim.results import Result

    return [given] if isinstance(given, Result | str | Path) else list(given)


def _paths(*given: Given) -> list[Path]:
    return [Path(each) for each in given if isinstance(each, str | Path)]


def _scenario(given: Scenario | str | Path, models: Sequence[str | Path]) -> Scenario:
    from wrsim.scenario.loading import Scenario, load

    return given if isinstance(given, Scenario) else load(given, models)


@contextmanager
def _no_bar() -> Iterator[Callable[[float, float], None]]:
    yield lambda fraction, seconds_left: None


def exit_code(result: Result) -> int:
    """Of a command: 0 for a run that came to its end, else 3, and 130 where Ctrl-C stopped it."""
    if result.status == "completed":
        return 0
    interrupted = result.dataset.attrs.get("stop_cause") == "interrupt"
    return INTERRUPTED if interrupted or result.stop_reason.startswith("interrupted") else STOPPED


def check(scenario: Scenario | str | Path, values: Sequence[str] = (), models: Sequence[str | Path] = ()) -> Outcome:
    """Check a scenario and all the files it names, without running it.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario or its file.
    values : sequence of str
        Keys to be changed, ``"vehicle.speed_kmh=60"``.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        Facts, ``["warnings"]`` of implausible values, and what the run will cost.

    Raises
    ------
    InputError
        With all faults.
    """
    from wrsim.analysis import check_step, cost_of
    from wrsim.scenario.build import build
    from wrsim.scenario.plausibility import facts, facts_table, warnings

    changed = _scenario(scenario, models).with_set(values)
    setup = build(changed)
    if getattr(setup.plan, "limited", False):
        check_step(changed, setup)
    found = facts(setup) | cost_of(setup)
    name = str(changed.path or changed.title)
    numbers = {"status": "valid", "scenario": name, "warnings": warnings(setup), **found}
    return Outcome([facts_table(f"{name}: valid", found)], numbers, found=setup)


def assess(
    results: Given | Sequence[Given],
    scenario: Scenario | str | Path | None = None,
    output: str | Path | None = None,
    pictures: bool = True,
) -> Outcome:
    """Assess a run, or several runs of one vehicle as one test, by EN 14363.

    Parameters
    ----------
    results : Result, path, or a sequence of these
        Runs along the track.
    scenario : Scenario, str or Path, optional
        With the settings, [assessment]; those of the results unless given.
    output : str or Path, optional
        Folder for tables and pictures.
    pictures : bool
        Whether pictures are drawn there.

    Returns
    -------
    Outcome
        ``found`` is the assessment.

    Raises
    ------
    InputError
        For results that are no runs, or not of one vehicle.
    """
    from wrsim.analysis.assessment import assess_runs
    from wrsim.report.output_folder import names_apart, naming
    from wrsim.report.outputs import write_assessment
    from wrsim.results.assessment import assessment_dict, assessment_numbers
    from wrsim.scenario.sections.assessment import AssessmentSection

    several = _several(results)
    paths = _paths(*several)
    names = names_apart(paths) if len(paths) == len(several) else [str(i + 1) for i in range(len(several))]
    settings = None if scenario is None else _scenario(scenario, ()).table(AssessmentSection).settings()
    loaded = [_read(each) for each in several]
    with naming(*paths):
        found = assess_runs(loaded, settings, names)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_assessment(found, folder, pictures)
    return Outcome(assessment_numbers(found), assessment_dict(found), files, found, folder=folder)


def ride(
    result: Given,
    scenario: Scenario | str | Path | None = None,
    output: str | Path | None = None,
    pictures: bool = True,
) -> Outcome:
    """Accelerations at the points of a vehicle: spectra, third-octaves, comfort.

    Parameters
    ----------
    result : Result, str or Path
        A run whose vehicle has points.
    scenario : Scenario, str or Path, optional
        With the settings, [ride]; those of the result unless given.
    output : str or Path, optional
        Folder for tables and pictures.
    pictures : bool
        Whether pictures are drawn there.

    Returns
    -------
    Outcome
        ``found`` has spectra and bands.

    Raises
    ------
    InputError
        For a result without points, or one too short.
    """
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_ride
    from wrsim.scenario.sections.run import RideSection

    loaded, section = _read(result), None if scenario is None else _scenario(scenario, ()).table(RideSection)
    with naming(*_paths(result)):
        found = evaluate_ride(loaded, section)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_ride(found, folder, pictures)
    return Outcome([found.table()], found.as_dict(), files, found, folder=folder)


def conicity(
    wheel: str, rail: str, *, gauge_mm: float = 1435.0, gauges_mm: tuple[float, float, float] | None = None,
    flange_back_mm: float = 1360.0, inclination: str = "1:40", radius_mm: float = 460.0,
    diameters_mm: tuple[float, float] | None = None, wheel_right: str | None = None, rail_right: str | None = None,
    roll: str = "none", curve_m: Sequence[float] = (), flange_from_deg: float = 40.0,
    models: Sequence[str | Path] = (), output: str | Path | None = None, pictures: bool = True,
) -> Outcome:  # fmt: skip
    """Rolling radius difference and equivalent conicity (EN 15302) of a wheelset on its rails.

    Parameters
    ----------
    wheel, rail : str
        Profile files, or folders of them, which give a map. All others as of ``wrsim conicity``.

    Returns
    -------
    Outcome
        ``found`` is a Result, or a map over profiles and gauges.

    Raises
    ------
    InputError
        For profiles that cannot be used, and for options that do not go together.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.report.outputs import write_conicity, write_conicity_map
    from wrsim.results.conicity import conicity_numbers
    from wrsim.results.table import as_records

    pairing = Pairing(flange_back_mm / 1e3, inclination, roll, list(map(Path, models)))
    if gauges_mm is not None or Path(wheel).is_dir() or Path(rail).is_dir():
        if diameters_mm or wheel_right or rail_right or curve_m:
            refused = "--diameters-mm, -right and --curve-m"
            raise InputError(f"a map is of wheelsets with like wheels on like rails, at any radius: no {refused}")
        over = pairing.map(wheel, rail, gauges_mm or (gauge_mm, gauge_mm, 1.0), radius_mm / 1e3)
        numbers = {"title": over.title, "map": as_records(over.table()), "gaps": list(over.reasons)}
        return Outcome(
            [over.table()], numbers, write_conicity_map(over, Path(output), pictures) if output else [], over
        )
    left, right = diameters_mm or (2.0 * radius_mm, 2.0 * radius_mm)
    wheels, rails, diameters = (wheel, wheel_right or wheel), (rail, rail_right or rail), (left / 1e3, right / 1e3)
    found = pairing.conicity(wheels, rails, gauge_mm / 1e3, diameters, curve_m, flange_from_deg)
    numbers = {"title": found.title, **conicity_numbers(found.wheelset())}
    return Outcome(found.numbers(), numbers, write_conicity(found, Path(output), pictures) if output else [], found)


def profiles(
    files: str | Sequence[str], output: str | Path | None = None, *, kind: str | None = None,
    cutoff: Sequence[float] = (), reference: str | None = None, on: str | None = None, gauge_mm: float = 1435.0,
    flange_back_mm: float | None = None, inclination: str = "1:40", radius_mm: float = 460.0, load_kN: float = 60.0,
    models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Profiles as workshops measure them: Sh, Sd, qR and hollow of wheels, W1, W2, W3 of rails, one row each.

    Parameters
    ----------
    files : str or sequence of str
        Profile files, and folders of them: their files that cannot be read are named in the notes of the table.
    output : str or Path, optional
        Picture; of several profiles with a table (CSV) beside it.
    reference : str, optional
        The unworn profile: head wear of rails is measured against it.
    on : str, optional
        A rail (of wheels) or a wheel (of rails) for conicity and pressure. All others as of ``wrsim profile``.

    Returns
    -------
    Outcome
        ``found`` holds the profiles by their names.

    Raises
    ------
    InputError
        For profiles that cannot be used, and for options that do not go together.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.analysis.profiles import Partner, measured_tables, wheelsets_table
    from wrsim.geometry.profile.models import gathered, load_profile
    from wrsim.inputs.lookup import model_file
    from wrsim.report.outputs import draw_model, write_profiles
    from wrsim.results.smoothing import body_of, profile_and_reports, smoothing_table
    from wrsim.results.table import as_records

    names, body = [files] if isinstance(files, str) else list(files), body_of(kind)
    unworn, other = (None if name is None else load_profile(model_file(name, models)) for name in (reference, on))
    pairing = Pairing((flange_back_mm or 1360.0) / 1e3, inclination, "none", list(map(Path, models)))
    partner = None if other is None else Partner(other, pairing, gauge_mm / 1e3, radius_mm / 1e3, 1e3 * load_kN)
    if alone := len(names) == 1 and not Path(names[0]).is_dir():
        loaded, reports = profile_and_reports(names[0], kind, cutoff, models)
        found, faults = {Path(names[0]).stem: loaded}, tuple[str, ...]()
    elif cutoff:
        raise InputError("--cutoff compares cut-offs of one file: give one, or describe each in a TOML file")
    else:
        found, faults = gathered(names, body, models)
    tables = measured_tables(found, faults, unworn, partner)
    numbers: dict[str, Any] = {f"{each}s": as_records(table) for each, table in tables.items()}
    numbers |= {"notes": [note for table in tables.values() for note in table.notes]}
    shown = [table for table in tables.values() if table.columns[1:] or not alone]
    wheels = {name: profile for name, profile in found.items() if profile.kind == "wheel"}
    if flange_back_mm is not None and (len(wheels) > 1 or partner is None):
        shown.append(wheelsets_table(wheels, flange_back_mm / 1e3))
        numbers["wheelsets"] = as_records(shown[-1])
    if alone and reports:
        shown.append(smoothing_table(reports))
        numbers["smoothing"] = [report.numbers() for report in reports]
    written: Sequence[Path] = ()
    if output is not None and alone:
        written = [draw_model("profile", Path(output), loaded, reports)]
    elif output is not None:
        written = write_profiles(found, tables, unworn, Path(output))
    return Outcome(shown, numbers, written, found)


def stationary(
    vehicle: Vehicle | str, *, cant_deficiency: float | None = None, twist: float | None = None,
    twist_test: bool = False, twists: tuple[float, float] | None = None, rotation_test: bool = False,
    rotation_radius_m: float = 150.0,
    picture: Path | None = None, loops: Path | None = None, models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Mass, centre, static wheel loads, natural modes and stationary tests of a vehicle.

    Parameters
    ----------
    vehicle : Vehicle or str
        A vehicle or its file.
    cant_deficiency : float, optional
        Roll and unloading at this cant deficiency [mm].
    twist : float, optional
        Wheel loads on track of this twist [per mille].
    twist_test, rotation_test : bool
        Tests of EN 14363; twists: of the first under body and bogie [per mille], rotation_radius_m: of the second.
    picture, loops : Path, optional
        Where the vehicle, and the loops of these tests, are drawn.

    Returns
    -------
    Outcome
        With ``["warnings"]`` of implausible values.

    Raises
    ------
    InputError
        For a vehicle file that cannot be used, and for options that do not go together.
    """
    from wrsim.analysis.stationary import at_rest
    from wrsim.scenario.plausibility import vehicle_warnings
    from wrsim.scenario.vehicle_build import vehicle_model

    if twists is not None and not twist_test:
        raise InputError("--twists belongs to --twist-test")
    if loops is not None and not (twist_test or rotation_test):
        raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
    loaded = vehicle_model(vehicle, list(models)) if isinstance(vehicle, str) else vehicle
    if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
        raise InputError(f"{vehicle}: is a train; tests at rest are for one vehicle: give the file of one of them")
    found = at_rest.numbers_at_rest(loaded, cant_deficiency, twist) | {"warnings": vehicle_warnings(loaded)}
    tested, twisted, turned = at_rest.stationary_tests(loaded, twist_test, twists, rotation_test, rotation_radius_m)
    found |= tested
    if picture is not None or loops is not None:
        from wrsim.report.outputs import draw_loops, draw_model

        found |= {"picture": str(draw_model("vehicle", picture, loaded))} if picture else {}
        found |= {"loops": str(draw_loops(loaded, twisted, turned, loops))} if loops else {}
    files = [Path(found[key]) for key in ("picture", "loops") if key in found]
    return Outcome(at_rest.tables_at_rest(found), found, files, (twisted, turned))


def diff(
    first: Given, second: Given, tolerance: float = 0.01, only: Sequence[str] = (), output: str | Path | None = None
) -> Outcome:
    """Compare two results: peaks, medians in full curves, other numbers.

    Parameters
    ----------
    first, second : Result, str or Path
        Results of one kind of analysis.
    tolerance : float
        Largest difference allowed, as a part of the quantity's largest value.
    only : sequence of str
        Quantities that count; all unless given.
    output : str or Path, optional
        Folder for a table and an overlay picture.

    Returns
    -------
    Outcome
        ``code`` 4 where they differ; ``found`` lists the deviations.

    Raises
    ------
    InputError
        For results of two kinds, and a quantity that neither has.
    """
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_differences
    from wrsim.results.differences import (
        beyond,
        compared_tables,
        difference_table,
        differences,
        inputs_apart,
        other_ends,
    )
    from wrsim.results.table import as_records

    names = tuple(str(g) if isinstance(g, str | Path) else g.title for g in (first, second))
    results, paths = (_read(first), _read(second)), _paths(first, second)
    with naming(*paths):
        found = differences(*results, only, tolerance)
    ends = other_ends(*results)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_differences(found, results, names, folder)
    alike = not beyond(found, tolerance) and not ends
    records = as_records(difference_table(found))
    apart = inputs_apart(*results)
    numbers = {"alike": alike, "tolerance": tolerance, "ends": ends, "inputs": apart, "differences": records}
    tables = compared_tables(found, ends, tolerance, names, apart)
    return Outcome(tables, numbers, files, found, 0 if alike else DIFFERENT, folder)


def export(result: Given, to: str, output: str | Path | None = None) -> Outcome:
    """Write a result for other programs.

    Parameters
    ----------
    result : Result, str or Path
        Any result.
    to : str
        ``"mat"``, ``"csv"``, ``"parquet"``, ``"mdf"``, ``"tables"``, or several with commas between.
    output : str or Path, optional
        Folder; beside the result unless given.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For an unknown format, a missing library, and a Result without ``output``.
    """
    from wrsim.results.exports import export_result, formats

    names, folder = formats(to), folder_of(result, output)
    loaded = _read(result)
    return Outcome([], {}, [file for name in names for file in export_result(loaded, name, folder)])


def folder_of(given: Given, output: str | Path | None) -> Path:
    """Where files about a result go: ``output``, else beside it. Raises InputError."""
    from wrsim.report.output_folder import folder_of_result

    if output is not None:
        return Path(output)
    if not isinstance(given, str | Path):
        raise InputError("output is missing: the result is in no folder")
    return folder_of_result(Path(given))


def write_report(
    results: Given | Sequence[Given], file: str | Path | None = None, *, title: str = "", author: str = "",
    company: str = "", logo: str | Path | None = None, date: str = "", with_view: bool = False,
    models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Write a page about a result, several results beside each other, a study, or a profile evolution.

    Parameters
    ----------
    results : Result, path, or a sequence of these
        Results of runs; or the folder of a study or a profile evolution.
    file : str or Path, optional
        The page; report.html beside the first result unless given.
    title, author, company, date : str
        On its head; the titles of the results and today's date unless given.
    logo : str or Path, optional
        A picture, .png, .svg or .jpg.
    with_view : bool
        Whether the viewer of each result is inside.
    models : sequence of str or Path
        Folders with model files of your own, for the viewer.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For files that are no results, or not of one kind.
    """
    from wrsim.report.document import Cover, logo_address
    from wrsim.results import write_atomically

    several, picture = _several(results), logo_address(Path(logo)) if logo else ""
    page = _page_of(several, with_view, list(map(Path, models)), Cover(title, author, company, date, picture))
    target = Path(file) if file is not None else folder_of(several[0], None) / "report.html"
    return Outcome([], {}, [write_atomically(target, page.encode())])


def _page_of(given: Sequence[Given], with_view: bool, models: Sequence[Path], cover: Cover) -> str:
    """The page about results of runs, a study or a profile evolution; with_view: with viewers of the results inside."""
    from wrsim.report.page import report_page
    from wrsim.report.study import evolution_page, study_page
    from wrsim.report.view_data import view_page
    from wrsim.study import collect
    from wrsim.study.evolution import history

    for path in _paths(*given):
        kind = "study" if collect.holds(path, collect.NUMBERS) else ""
        kind = "profile evolution" if collect.holds(path, history.NUMBERS) else kind
        if not kind:
            continue
        if len(given) > 1:
            raise InputError(f"{path}: is a {kind}: a report takes one {kind}, or results of runs")
        if with_view:
            raise InputError(f"--view: {path} is a {kind}; it is for results of runs, as each case of a {kind} is")
        if kind == "study":
            return study_page(collect.read_study(path), str(path), cover)
        dataset = history.read_history(path)
        return evolution_page(dataset, str(path), history.mileage_table(dataset), cover)
    results = [_read(each) for each in given]
    names = [str(each) if isinstance(each, str | Path) else each.title for each in given]
    pairs = zip(results, given, strict=True)
    viewers = [view_page(r, folder_of(each, None), models) for r, each in pairs] if with_view else []
    return report_page(results, names, viewers=viewers, cover=cover)


def write_view(result: Given, file: str | Path | None = None, models: Sequence[str | Path] = ()) -> Outcome:
    """Write a page to look at a run: wheels on their rails, the vehicle on its track, modes.

    Parameters
    ----------
    result : Result, str or Path
        A result of a run or of a stability analysis.
    file : str or Path, optional
        The page; view.html beside the result unless given.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For a result that has nothing to look at.
    """
    from wrsim.report.view_data import view_page
    from wrsim.results import write_atomically

    folder = folder_of(result, None if file is None else Path(file).parent)
    beside = folder_of(result, None) if _paths(result) else folder
    page = view_page(_read(result), beside, list(map(Path, models)))
    return Outcome([], {}, [write_atomically(folder / "view.html" if file is None else Path(file), page.encode())])


def read_recording(
    file: str | Path, output: str | Path | None = None, *, columns: str | Path | None = None,
    chord_m: tuple[float, float] | None = None, band: str | None = None,
    wavelength_m: tuple[float, float] = (3.0, 70.0), amplification: float = 8.0, transitions: str = "either",
    from_m: float | None = None, to_m: float | None = None, vehicle: str = "vehicles/manchester_1.toml",
    speed_kmh: float | None = None, models: Sequence[str | Path] = (), pictures: bool = True,
) -> Outcome:  # fmt: skip
    """Make a track, its irregularities and a scenario of a track recording car's table.

    Parameters
    ----------
    file : str or Path
        Table of the recording (CSV).
    output : str or Path, optional
        Folder for the files; without it nothing is written. All others as of ``wrsim recording``.

    Returns
    -------
    Outcome
        ``found`` is the restored track.

    Raises
    ------
    InputError
        For a table that cannot be read, with line and column.
    """
    from wrsim.report.outputs import write_recording
    from wrsim.results.recording import recording_numbers, recording_tables
    from wrsim.scenario.recorded import restored_track

    path, beside = Path(file), Path(file).with_suffix(".toml")
    chosen = Path(columns) if columns is not None else beside if beside.is_file() else None
    found = restored_track(path, chosen, chord_m, band, (from_m, to_m), wavelength_m, amplification, transitions)
    files = []
    if output is not None:
        files = write_recording(found, Path(output), vehicle, speed_kmh, list(map(Path, models)), pictures)
    folder = None if output is None else Path(output)
    return Outcome(recording_tables(found), recording_numbers(found), files, found, folder=folder)


def run_scenario(
    file: str | Path, output: str | Path | None = None, values: Sequence[str] = (), *,
    models: Sequence[str | Path] = (), resume: bool = False, threads: int | None = None, pictures: bool = True,
    force: bool = False, bar: Bar = _no_bar, warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Run a scenario into a folder: dataset, tables, summary and pictures.

    Parameters
    ----------
    file : str or Path
        Scenario file.
    output : str or Path, optional
        Folder; results/<name of the file> unless given.
    values : sequence of str
        Keys to be changed, ``"vehicle.speed_kmh=60"``. All others as of ``wrsim run``; bar, warn as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` is a `wrsim.report.output_folder.Written`, with the Result.

    Raises
    ------
    InputError, SimulationError
        As of `run`.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.report.output_folder import run_into
    from wrsim.scenario.build import build
    from wrsim.scenario.loading import load
    from wrsim.scenario.plausibility import warnings

    path = Path(file)
    directory = Path(output or f"results/{path.stem}")
    with timed("scenario read and checked"):
        scenario = load(path, models).with_set(values)
    with timed("vehicle, track and profiles built"):
        setup = build(scenario)  # what cannot run leaves nothing behind
    for words in (*(f"{file}: warning: {w}" for w in warnings(setup)), *exact_run_warning(setup)):
        warn(words)
    written = run_into(
        directory, scenario, setup, path, resume=resume, threads=threads, pictures=pictures, force=force, progress=bar()
    )
    result, code = written.result, exit_code(written.result)
    numbers = {
        "status": result.status,
        "exit_code": code,
        "directory": str(directory),
        "files": [str(f) for f in written.files],
        "removed": [str(f) for f in written.removed],
        "summary": {**result.summary(), **written.took},
    }
    lines = [written.words] if written.words else []
    return Outcome(result.numbers(), numbers, written.files, written, code, directory, lines)


def show(result: Given) -> Outcome:
    """The summary of a result, or of what there is of a run.

    Parameters
    ----------
    result : Result, str or Path
        Any result.

    Returns
    -------
    Outcome
        ``found`` is the Result.

    Raises
    ------
    InputError
        For a file that is no result.
    """
    loaded = _read(result)
    lines = [f"stopped: {loaded.stop_reason}"] if loaded.stop_reason else []
    return Outcome(loaded.numbers(), loaded.summary(), found=loaded, lines=lines)


def write_pictures(
    result: Given, output: str | Path | None = None, at: Sequence[str] = (), wheelset: str | None = None,
    formats: str = "png", width_mm: float | None = None, font: str = "", style: str = "",
) -> Outcome:  # fmt: skip
    """Draw the pictures of a result, or the contact patches at chosen places only.

    Parameters
    ----------
    result : Result, str or Path
        Any result.
    output : str or Path, optional
        Folder; beside the result unless given.
    at, wheelset
        Distances [m] or poses, and one of several wheelsets. All others as of ``wrsim plot``.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For places, wheelsets, formats and styles that there are not.
    """
    from wrsim.plots.theme import LOOK, look_of
    from wrsim.report.outputs import draw_pictures
    from wrsim.results.wheelsets import wheelset_folder, wheelsets, worst_wheelset

    look, loaded, directory = look_of(formats, width_mm, font, style), _read(result), folder_of(result, output)
    dataset = loaded.dataset
    if wheelset is not None or at:
        dataset = loaded.wheelset(wheelset or worst_wheelset(dataset))
        if output is None:
            directory /= wheelset_folder(wheelsets(loaded.dataset), str(dataset["wheelset"].item()))
    token = LOOK.set(look)
    try:
        return Outcome([], {}, draw_pictures(dataset, at, directory))
    finally:
        LOOK.reset(token)


def compare(
    scenario: Scenario | str | Path, contact: str, reference: str | None = None, output: str | Path | None = None, *,
    models: Sequence[str | Path] = (), pictures: bool = True, bar: Bar = _no_bar,
    warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Compare contact models on the poses or the run of a scenario.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario or its file.
    contact : str
        Names of models with commas between; reference: whom the others are measured against, the first unless given.
    output : str or Path, optional
        Folder; without it nothing is written. All others as of ``wrsim compare``; bar, warn as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` has the result of every model, differences and times.

    Raises
    ------
    InputError, SimulationError
        For names that are no models; when a model has no result at all.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.analysis.compare import compare_models, comparison_report, comparison_tables
    from wrsim.report.outputs import write_comparison
    from wrsim.scenario.build import build
    from wrsim.scenario.contact_choice import split_names, with_contact_model

    loaded, names = _scenario(scenario, models), split_names(contact)
    for words in [w for name in names for w in exact_run_warning(build(with_contact_model(loaded, name)))]:
        warn(words)
    with bar() as progress:
        found = compare_models(loaded, names, reference, progress)
    report = comparison_report(found, str(loaded.path or loaded.title))
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_comparison(found, report, folder, pictures, loaded.title)
    code = max(exit_code(model.result) for model in found.models)
    return Outcome(comparison_tables(found, report), report, files, found, code, folder)


def resolve(
    result: Given, contact: str = "half-space", output: str | Path | None = None, *, at: Sequence[str] = (),
    wheelset: str | None = None, same: str = "load", models: Sequence[str | Path] = (), pictures: bool = True,
    force: bool = False, bar: Bar = _no_bar,
) -> Outcome:  # fmt: skip
    """Solve the contacts at the snapshots of a result again, by the exact solver or any other contact model.

    Parameters
    ----------
    result : Result, str or Path
        A run or poses.
    contact : str
        Contact model.
    output : str or Path, optional
        Folder; one of the model's name beside the result unless given.
    at, wheelset, same
        Snapshots and wheelset; ``"load"`` or ``"pose"`` of the wheels stays. All others as of ``wrsim resolve``.

    Returns
    -------
    Outcome
        ``found`` is the new Result.

    Raises
    ------
    InputError
        For a result without poses of its wheels, and when one of several wheelsets has to be named.
    """
    from wrsim.analysis.resolve import resolve_contacts
    from wrsim.report.output_folder import RECORD, claimed, naming, write
    from wrsim.report.outputs import file_name
    from wrsim.results import write_atomically
    from wrsim.results.moments import moments_at, resolved_table
    from wrsim.results.summary_tables import first_lines, remarks
    from wrsim.scenario.loading import load_text

    before, paths = _read(result), _paths(result)
    directory = Path(output) if output else folder_of(result, None) / file_name(contact)
    with naming(*paths), bar() as progress:
        moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
        beside = folder_of(result, None) if paths else Path()
        scenario = load_text(before.dataset.attrs["scenario_text"], beside, models, closed=True)
        after = resolve_contacts(
            before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress
        )
    with claimed(directory, force, paths) as keeper:
        write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
        files = write(after, directory, pictures)
        keeper.clear(files)
    notes = first_lines(remarks(after.summary()), "remarks")
    tables = [resolved_table(before.wheelset(wheelset), after.wheelset(), notes)]
    return Outcome(tables, {"directory": str(directory), "summary": after.summary()}, files, after, folder=directory)


def draw_track(file: str | Path, picture: str | Path, models: Sequence[str | Path] = ()) -> Outcome:
    """Draw the track of a scenario or of a track file: plan, curvature, cant, gauge, height, irregularities.

    Parameters
    ----------
    file, picture : str or Path
        The scenario or track file; where it is drawn, .png, .svg or .pdf.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        ``found`` is the Track.

    Raises
    ------
    InputError
        For a file that is neither.
    """
    from wrsim.report.outputs import draw_model
    from wrsim.scenario.track_build import track_model

    found = track_model(Path(file), models)
    return Outcome([], {}, [draw_model("track", Path(picture), found)], found)


def write_unit(
    scenario: Scenario | str | Path, output: str | Path | None = None, values: Sequence[str] = (), *,
    step: float = 1e-3, models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Write the vehicle of a run as a co-simulation unit of FMI 3.0, for Linux; it needs no Python when it runs.

    Parameters
    ----------
    scenario : Scenario, str or Path
        Of a run along the track, from whose start the unit starts.
    output : str or Path, optional
        The file; <name of the scenario's file>.fmu here unless given.
    values : sequence of str
        Keys to be changed, ``"vehicle.drive=free"``.
    step : float
        Of the integration [s]. models: as of `check`.

    Returns
    -------
    Outcome
        ``["inputs"]``: their names.

    Raises
    ------
    InputError, SimulationError
        As `stepper`; WrsimError without a C compiler.
    """
    from wrsim.analysis.motion.unit import unit_of
    from wrsim.results import write_atomically
    from wrsim.results.files import KEEPER

    loaded = _scenario(scenario, models).with_set(values)
    path = Path(output or f"{loaded.path.stem if loaded.path else 'vehicle'}.fmu")
    if (keeper := KEEPER.get()) is not None:
        keeper.check(path)  # before the work
    content, inputs = unit_of(loaded, path.stem, step)
    return Outcome([], {"inputs": inputs}, [write_atomically(path, content)])


def new_file(kind: str = "curving", template: str | None = None, output: str | Path | None = None) -> Outcome:
    """Write a file to start from, which can be used as it is: a scenario that names all keys, or another kind.

    Parameters
    ----------
    kind, template : str
        As of ``wrsim new``.
    output : str or Path, optional
        The file; <template or kind>.toml here unless given.

    Returns
    -------
    Outcome
        ``files``, those that the first one names included.

    Raises
    ------
    InputError
        For a kind or a template that there is not.
    """
    from wrsim.register import ANALYSES, OTHER_NAMES
    from wrsim.results import write_atomically
    from wrsim.scenario.templates import template_files

    texts = template_files(kind, template, Path(output or f"{template or kind}.toml"))
    files = [write_atomically(path, text.encode()) for path, text in texts.items()]
    command = "run" if kind in ANALYSES else "vehicle" if kind == "train" else kind
    of_kind = "" if kind in ANALYSES else f" --file {OTHER_NAMES.get(kind, kind)}"
    use = [f"use it with: wrsim {command} {files[0]}", f"wrsim keys{of_kind} explains its keys"]
    return Outcome([], {}, files, lines=use)


def keys(section: str | None = None, file: str = "scenario", schema: bool = False) -> Outcome:
    """The keys of a table: unit, what is allowed, default, other names, an example.

    Parameters
    ----------
    section : str, optional
        A table such as ``"contact"``; all tables unless given.
    file : str
        Kind of file, as of ``wrsim keys``.
    schema : bool
        Whether ``lines`` are the JSON schema of that kind of file.

    Returns
    -------
    Outcome
        ``lines``, and the same as ``numbers``.

    Raises
    ------
    InputError
        For a kind of file or a table that there is not.
    """
    from wrsim.scenario.reference import keys_numbers, keys_text, kind_of_file, schema_text

    kind = kind_of_file(file)
    return Outcome([], keys_numbers(kind, section), lines=[schema_text(kind) if schema else keys_text(kind, section)])


def run_study(
    file: str | Path, output: str | Path | None = None, *, workers: int | None = None, scheduler: str | None = None,
    slurm: bool = False, tls: Path | None = None, retry: bool = False, dry_run: bool = False,
    models: Sequence[str | Path] = (), pictures: bool = True, force: bool = False, bar: Bar = _no_bar,
    notify: Callable[[str], None] = lambda line: None, warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Run a scenario many times with some keys varied; started again, only what is missing runs.

    Parameters
    ----------
    file : str or Path
        Study file.
    output : str or Path, optional
        Folder; results/<name of the file> unless given. All others as of ``wrsim study``; notify: takes lines on its
        progress, warn: a warning, bar: gives a context with the callback of a progress bar.

    Returns
    -------
    Outcome
        ``found`` is the plan; ``["faults"]`` lists cases without a result.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.collect import OUTPUTS, faults_of, markers_of, study_tables, write_study
    from wrsim.study.engine import check_workers, kept_folder, missing, worker_pool
    from wrsim.study.estimate import estimated_cost
    from wrsim.study.plan import planned

    directory = Path(output) if output else Path("results") / Path(file).stem
    for words in check_workers(workers, scheduler, slurm, tls):
        warn(words)
    with timed("plan of the cases"):
        plan, reads = planned(Path(file), directory, list(models))
    if dry_run:
        numbers, table = estimated_cost(plan, workers)
        return Outcome([table], numbers, found=plan)
    with kept_folder(directory, reads, force, OUTPUTS):
        todo = missing(plan, retry)
        known = len(plan.cases) - len(todo)
        notify(f"{len(plan.cases)} cases" + (f", {known} of them known already" if known else ""))
        try:
            if todo:
                with timed(f"{len(todo)} cases"), worker_pool(workers, scheduler, slurm, tls, len(todo), bar) as work:
                    work(plan, todo)
        except KeyboardInterrupt:
            write_study(plan, markers_of(plan), pictures=False)
            raise _interrupted(directory) from None
        markers = markers_of(plan)
        with timed("tables and pictures of the study"):
            report, files = write_study(plan, markers, pictures)
    code = STOPPED if report["unfinished"] else 0
    faults = partial(faults_of, report, markers)
    numbers = report | {"exit_code": code, "ran": len(todo)}
    return Outcome(study_tables(report), numbers, files, faults, code, directory)


def run_wear(
    file: str | Path, output: str | Path | None = None, *, workers: int | None = None, scheduler: str | None = None,
    slurm: bool = False, tls: Path | None = None, models: Sequence[str | Path] = (), pictures: bool = True,
    force: bool = False, bar: Bar = _no_bar, notify: Callable[[str], None] = lambda line: None,
    warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Profile evolution: cases by their shares, a worn profile, again; started again, it goes on.

    Parameters
    ----------
    file : str or Path
        File of a profile evolution.
    output : str or Path, optional
        Folder; results/<name of the file> unless given. All others as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` is the dataset over the mileage.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.engine import check_workers, kept_folder, worker_pool
    from wrsim.study.evolution.history import OUTPUTS, evolution_report, mileage_table, write_history
    from wrsim.study.evolution.reading import read_evolution
    from wrsim.study.evolution.steps import Step, wear_steps

    directory = Path(output) if output else Path("results") / Path(file).stem
    for words in check_workers(workers, scheduler, slurm, tls):
        warn(words)
    evolution, reads = read_evolution(Path(file), list(models))
    steps: list[Step] = []
    with (
        kept_folder(directory, reads, force, OUTPUTS),
        worker_pool(workers, scheduler, slurm, tls, len(evolution.shares), bar) as work,
    ):
        try:
            for step in wear_steps(evolution, directory, work):
                steps.append(step)
                notify(step.words(evolution.mileage))
        except KeyboardInterrupt:
            raise _interrupted(directory) from None
        dataset, files = write_history(evolution, steps, directory, pictures)
    numbers = evolution_report(dataset) | {"directory": str(directory)}
    return Outcome([mileage_table(dataset)], numbers, files, dataset, folder=directory)


def _interrupted(directory: Path) -> KeyboardInterrupt:
    """With where the finished part is."""
    return KeyboardInterrupt(f"interrupted; what is done is safe in {directory}: start the same command again to go on")
