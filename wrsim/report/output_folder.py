"""The folder of a run: claimed by one analysis, written so that nothing of the user's is lost, read again."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from wrsim.errors import InputError, SimulationError, WrsimError, in_one_line
from wrsim.inputs.file_kinds import resolved
from wrsim.register import ANALYSES
from wrsim.results import Result, write_atomically, write_run
from wrsim.results.files import Keeper, Manifest, digest_of, keeping, sweep
from wrsim.results.table import quantity
from wrsim.results.units import prefer_those_of
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.plots.drawing import Finish
    from wrsim.scenario.build import Setup
    from wrsim.scenario.loading import Scenario

LOGGER = logging.getLogger("wrsim.run")

RESULT = "result.nc"
PART = RESULT + ".part"
"""The run in a folder while it lasts, and after that if it did not come to its end."""

RECORD = "scenario.toml"  # the scenario of the run in a folder

OUTPUTS = (RESULT, RECORD, "summary.json", "vehicle.csv", "history.csv", "patches.csv", "strips.csv")
"""Names of files that an analysis writes; pictures and further tables are looked at when they are written."""


@contextmanager
def claimed(directory: Path, force: bool, reads: Sequence[Path], scenario: Path | None = None) -> Iterator[Keeper]:
    """Reserve a folder for one analysis: no other process writes into it, and no file of the user's is replaced. reads:
    files of its input; scenario: the file that is run. Raises ``InputError`` before anything is changed there."""
    keeper = Keeper(tuple(reads), force, directory)
    with Manifest(directory).locked(), keeping(keeper):
        reused = (RECORD,) if _is_record(directory, scenario) else ()
        sweep(directory)
        keeper.check_folder(directory, [name for name in OUTPUTS if name not in reused])
        for folder in directory.glob("wheelset_*/"):
            sweep(folder)
            keeper.check_folder(folder, OUTPUTS)
        yield keeper


def _is_record(directory: Path, scenario: Path | None) -> bool:
    """True if a scenario is run from the record of the folder itself."""
    record = directory / RECORD
    return scenario is not None and record.exists() and record.samefile(scenario)


def write(result: Result, directory: Path, pictures: bool) -> tuple[dict[str, Any], list[Path]]:
    """Numbers first, pictures last: what fails late costs least. A second process begins to draw at once. Only when all
    files are there has the run's own file done its work, unless the user may want to go on with it. Returns the summary
    and the files."""
    record = directory / RECORD
    if not record.exists():  # somebody has deleted the folder of a run: it is made anew
        write_atomically(record, result.dataset.attrs["scenario_text"].encode())
    drawn: AbstractContextManager[Finish] = nullcontext(dict)
    if pictures:
        from wrsim.plots import standard_figures
        from wrsim.plots.drawing import drawing, in_all_kinds, written

        drawn = drawing(standard_figures(result.dataset), in_all_kinds)
    with drawn as finish:
        with timed("dataset, summary and tables written"):
            summary = result.summary()
            files = [record, *write_run(result, directory, summary)]
        if further := ANALYSES[result.analysis].further:
            files += resolved(further)(result, directory, pictures)
        with timed("pictures that are left"):
            files += written(finish, directory) if pictures else []
    if not can_go_on(result):
        (directory / PART).unlink(missing_ok=True)
        names = [path.relative_to(directory).as_posix() for path in files]
        Manifest(directory).note(done=result.status, pictures=pictures, files=names)
    return summary, files


def can_go_on(result: Result) -> bool:
    """True for a run that Ctrl-C has ended, or the death of its process."""
    return result.dataset.attrs.get("stop_cause") in ("interrupt", "cut-off")


@contextmanager
def naming(*results: Path) -> Iterator[None]:
    """Name the results that cannot be used for what is done meanwhile, in one line; faults of options name these. No
    results: the message stays as it is."""
    try:
        yield
    except InputError as error:
        message = in_one_line(error)
        if results and not message.startswith("--") and not any(str(path) in message for path in results):
            message = f"{', '.join(map(str, results))}: {message}"
        raise InputError(message) from None


def read(path: Path) -> Result:
    """A result, or what there is of a run that did not come to its end: a file, or the newer of both in a folder."""
    if path.is_dir():
        part, whole = path / PART, path / RESULT
        path = whole
        if part.exists() and (not whole.exists() or part.stat().st_mtime_ns > whole.stat().st_mtime_ns):
            path = part
    with naming(path):
        if path.suffix == ".part":
            from wrsim.analysis import recorded

            result = recorded(path)
        else:
            result = Result.load(path)
    prefer_those_of(str(result.dataset.attrs.get("scenario_text", "")))
    return result


def write_ride_of(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """The ride of a run; one that is too short for it leaves a warning."""
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.report.outputs import write_ride

    try:
        return write_ride(evaluate_ride(result), directory, pictures)
    except InputError as error:
        LOGGER.warning("no spectra: %s", error)
        return []


def unique_names(results: Sequence[Path]) -> list[str]:
    """Names of runs: the ends of their paths, as long as it takes to distinguish them. Raises InputError for a run that
    is given twice."""
    paths = [path.resolve() for path in results]
    paths = [path.parent if path.name.startswith(RESULT) else path for path in paths]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError(f"{results[i]}: given twice")
    parts = 1
    while len({path.parts[-parts:] for path in paths}) < len(paths):
        parts += 1
    return ["/".join(path.parts[-parts:]) for path in paths]


class Written(NamedTuple):
    """What a run left in a folder. took: wall times [s], and their ratio to real time, of a resumed run nothing;
    message: these, or why nothing ran; removed: files of an earlier result."""

    result: Result
    summary: dict[str, Any]
    took: dict[str, float]
    message: str
    files: Sequence[Path] = ()
    removed: Sequence[Path] = ()

    @property
    def can_go_on(self) -> bool:
        return can_go_on(self.result)


def _times(result: Result, wall: float, compiling: float) -> tuple[dict[str, float], str]:
    """Wall times [s] without and for compiling, and their ratio to real time; as a text for runs along the track."""
    times = result.dataset.coords.get("time")
    lasted = 0.0 if times is None or times.size == 0 else float(times[-1] - times[0])
    took = {"wall_time_s": round(wall, 3), "compiling_s": round(compiling, 3)}
    if not lasted:
        return took, ""
    ratio, how = (lasted / wall, "faster") if lasted >= wall else (wall / lasted, "slower")
    more = f"; compiling kernels, once, took {quantity(compiling, 's', '.3g')} besides" if compiling >= 0.1 else ""
    text = f"{quantity(lasted, 's')} on the track in {quantity(wall, 's', '.3g')} of wall time"
    text += f": {quantity(ratio, 'times', '.3g')} {how} than real time{more}"
    return took | {"times_real_time": round(wall / lasted, 4)}, text


def run_into(
    directory: Path, scenario: Scenario, setup: Setup[Any], file: Path,
    *, resume: bool, threads: int | None, pictures: bool, force: bool, progress: AbstractContextManager[Any],
) -> Written:  # fmt: skip
    """Run a scenario and write all of its files; while it lasts, the run is stored in ``result.nc.part``. file: the
    scenario's own; progress: a context that gives the callback of `wrsim.run`. Raises InputError, SimulationError;
    KeyboardInterrupt reports where an interrupted run is stored."""
    from wrsim.analysis import cost_of, run
    from wrsim.analysis.run_times import learn
    from wrsim.jit.compiling import COUNT, use_threads

    if threads is not None:
        use_threads(threads)
    record = directory / PART
    with claimed(directory, force, (*scenario.merged.files, *setup.files), file) as keeper:
        result = None
        if resume and not record.exists() and (directory / RESULT).exists():
            whole = Result.load(directory / RESULT)
            same = whole.dataset.attrs["scenario_text"] == scenario.text
            result = whole if same and not can_go_on(whole) else None
        if result is not None and Manifest(directory).is_done(scenario.text, pictures):
            return Written(result, result.summary(), {}, f"{directory} holds the whole result of this scenario already")
        if resume and result is None and not record.exists():
            LOGGER.warning("there is no run in %s to resume; it starts from the beginning", directory)
            resume = False
        Manifest(directory).note(begin=digest_of(scenario.text.encode()))
        if not _is_record(directory, scenario.path):  # the record of the run, and proof that it may be written to
            write_atomically(directory / RECORD, scenario.text.encode())
        started, before = time.perf_counter(), COUNT.seconds
        try:
            if result is None:
                with progress as advance:
                    result = run(scenario, progress=advance, record=record, resume=resume, setup=setup, threads=threads)
            compiling = COUNT.seconds - before
            wall = time.perf_counter() - started - compiling
            if not resume and result.status == "completed" and (cost := cost_of(setup)):
                learn(setup.contact.normal, cost["expected_time_s"], wall)
            summary, files = write(result, directory, pictures)
            took = ({}, "") if resume else _times(result, wall, compiling)
            return Written(result, summary, *took, files, keeper.clear(files))
        except (KeyboardInterrupt, WrsimError) as error:
            if record.exists() and not isinstance(error, InputError | SimulationError):  # Ctrl-C, or a full disk
                message = f"{str(error) or 'interrupted'}; the run is safe in {record}: go on with --resume"
                raise type(error)(message) from None
            raise
