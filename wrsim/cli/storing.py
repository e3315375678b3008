"""What a command leaves on disk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from wrsim.cli.options import beside
from wrsim.errors import InputError, in_one_line
from wrsim.register import ANALYSES, resolved

if TYPE_CHECKING:
    from xarray import Dataset

    from wrsim.plots.drawing import Finish
    from wrsim.results import Result
    from wrsim.results.ledger import Keeper
    from wrsim.scenario.loading import Scenario

RESULT = "result.nc"
PART = RESULT + ".part"
"""The run in a folder while it lasts, and after that if it did not come to its end."""

RECORD = "scenario.toml"
"""The scenario of the run in a folder."""

OUTPUTS = (RESULT, RECORD, "summary.json", "vehicle.csv", "history.csv", "patches.csv", "strips.csv")
"""Names of files that an analysis writes; pictures and further tables are looked at when they are written."""


@contextmanager
def writing(force: bool, *reads: Path, of: Path | None = None) -> Iterator[None]:
    """While this lasts, no file of the user's is written over, none of ``reads`` above all (`wrsim.results.ledger`).

    of: the result that is told about.
    """
    from wrsim.results.ledger import Keeper, keeping

    with keeping(Keeper(reads if of is None else (*reads, of), force, None if of is None else beside(of))):
        yield


@contextmanager
def claimed(directory: Path, force: bool, reads: Sequence[Path], scenario: Path | None = None) -> Iterator[Keeper]:
    """Keep a folder for one analysis: nobody else writes into it, and nothing of the user's is written over.

    reads: files of its input; scenario: the file that is run. Raises ``InputError`` before anything is changed there.
    """
    from wrsim.results.files import sweep
    from wrsim.results.ledger import Keeper, Ledger, keeping

    keeper = Keeper(tuple(reads), force, directory)
    with Ledger(directory).locked(), keeping(keeper):
        kept = (RECORD,) if _is_record(directory, scenario) else ()
        sweep(directory)
        keeper.check_folder(directory, [name for name in OUTPUTS if name not in kept])
        for folder in directory.glob("wheelset_*/"):
            sweep(folder)
            keeper.check_folder(folder, OUTPUTS)
        yield keeper


def begin(directory: Path, scenario: Scenario) -> None:
    """Put the scenario's text into the folder: the record of the run, and proof that it may be written to."""
    from wrsim.results import write_atomically
    from wrsim.results.ledger import Ledger, digest_of

    Ledger(directory).note(begin=digest_of(scenario.text.encode()))
    if not _is_record(directory, scenario.path):
        write_atomically(directory / RECORD, scenario.text.encode())


def _is_record(directory: Path, scenario: Path | None) -> bool:
    """True if a scenario is run from the record of the folder itself."""
    record = directory / RECORD
    return scenario is not None and record.exists() and record.samefile(scenario)


def write(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """Numbers first, pictures last: what fails late costs least. A second process begins to draw at once.

    Only when all files stand has the run's own file done its work, unless the user may want to go on with it.
    """
    from wrsim.results import write_atomically, write_run
    from wrsim.results.ledger import Ledger

    record = directory / RECORD
    if not record.exists():  # somebody has deleted the folder of a run: it is made anew
        write_atomically(record, result.dataset.attrs["scenario_text"].encode())
    with _pictures_of(result, pictures) as finish:
        files = [record, *write_run(result, directory)]
        if further := ANALYSES[result.analysis].further:
            files += resolved(further)(result, directory, pictures)
        files += [write_atomically(directory / f"{name}.png", content) for name, content in finish().items()]
    if not can_go_on(result):
        (directory / PART).unlink(missing_ok=True)
        names = [path.relative_to(directory).as_posix() for path in files]
        Ledger(directory).note(done=result.status, pictures=pictures, files=names)
    return files


@contextmanager
def _pictures_of(result: Result, wanted: bool) -> Iterator[Finish]:
    """Draw the standard pictures of a result, if they are wanted, while its numbers are written."""
    if not wanted:
        yield dict
        return
    from wrsim.plots import drawing, standard_figures

    with drawing(standard_figures(result.dataset)) as finish:
        yield finish


def can_go_on(result: Result) -> bool:
    """True for a run that Ctrl-C has ended, or the death of its process."""
    return result.dataset.attrs.get("stop_cause") in ("interrupt", "cut-off")


@contextmanager
def told_of(*results: Path) -> Iterator[None]:
    """Name the results that cannot be used for what is done meanwhile, in one line; faults of options name these."""
    try:
        yield
    except InputError as error:
        words = in_one_line(error)
        if not words.startswith("--") and not any(str(path) in words for path in results):
            words = f"{', '.join(map(str, results))}: {words}"
        raise InputError(words) from None


def read(path: Path) -> Result:
    """A result, or what there is of a run that did not come to its end: a file, or the newer of both in a folder."""
    from wrsim.results import Result

    if path.is_dir():
        part, whole = path / PART, path / RESULT
        path = whole
        if part.exists() and (not whole.exists() or part.stat().st_mtime_ns > whole.stat().st_mtime_ns):
            path = part
    with told_of(path):
        if path.suffix == ".part":
            from wrsim.analysis import recorded

            return recorded(path)
        return Result.load(path)


def whole_result(directory: Path, scenario: Scenario) -> Result | None:
    """The whole result of this scenario in the folder, if there is one and no run that was cut off."""
    from wrsim.results import Result

    if (directory / PART).exists() or not (directory / RESULT).exists():
        return None
    result = Result.load(directory / RESULT)
    return None if can_go_on(result) or result.dataset.attrs["scenario_text"] != scenario.text else result


def has_all_files(directory: Path, scenario: Scenario, pictures: bool) -> bool:
    """True when everything that the last analysis in the folder had to write stands there."""
    from wrsim.results.ledger import Ledger

    return Ledger(directory).is_done(scenario.text, pictures)


def patch_pictures(dataset: Dataset, at: list[str], directory: Path) -> list[Path]:
    """Patches and sections of one wheelset at the given distances [m] or poses."""
    from wrsim.plots import patch_gallery, save, section_gallery
    from wrsim.plots.cross_section import has_outlines
    from wrsim.results.moments import moments_at

    moments = moments_at(dataset, at, "--at")
    name = "_".join("".join(c if c.isalnum() or c in "+-." else "-" for c in place) for place in at)
    files = [save(patch_gallery(dataset, moments), directory / f"patches_at_{name}.png")]
    if has_outlines(dataset):
        files.append(save(section_gallery(dataset, moments), directory / f"sections_at_{name}.png"))
    return files
