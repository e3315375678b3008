"""What a command leaves on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wrsim.errors import InputError, suggest
from wrsim.register import ANALYSES, resolved

if TYPE_CHECKING:
    from xarray import Dataset

    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario

RESULT = "result.nc"
PART = RESULT + ".part"
"""The run in a folder while it lasts, and after that if it did not come to its end."""

NEAR = 1.0
"""Distance to the place asked for at which kept patches still count as being there [m]."""


def claim(directory: Path, scenario: Scenario) -> None:
    """Put the scenario's text into the folder: the record of the run, and proof that it may be written to."""
    from wrsim.results import write_atomically

    record = directory / "scenario.toml"
    if scenario.path is None or not record.exists() or not record.samefile(scenario.path):
        write_atomically(record, scenario.text.encode())


def write(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """Numbers first, pictures last: what fails late costs least.

    Once the numbers are safe, the run's own file has done its work, unless the user may want to go on with it.
    """
    from wrsim.results import write_run

    files = [directory / "scenario.toml", *write_run(result, directory)]
    if not can_go_on(result):
        (directory / PART).unlink(missing_ok=True)
    if further := ANALYSES[result.analysis].further:
        files += resolved(further)(result, directory, pictures)
    if pictures:
        from wrsim.plots import standard_pictures

        files += standard_pictures(result.dataset, directory)
    return files


def can_go_on(result: Result) -> bool:
    """True for a run that Ctrl-C has ended, or the death of its process."""
    return result.dataset.attrs.get("stop_cause") in ("interrupt", "cut-off")


def read(path: Path) -> Result:
    """A result, or what there is of a run that did not come to its end: a file, or the newer of both in a folder."""
    from wrsim.results import Result

    if path.is_dir():
        part, whole = path / PART, path / RESULT
        path = whole
        if part.exists() and (not whole.exists() or part.stat().st_mtime_ns > whole.stat().st_mtime_ns):
            path = part
    if path.suffix == ".part":
        from wrsim.analysis import recorded

        return recorded(path)
    return Result.load(path)


def is_complete(directory: Path, scenario: Scenario) -> bool:
    """True when the folder holds the whole result of this scenario and no run that was cut off."""
    from wrsim.results import Result

    if (directory / PART).exists() or not (directory / RESULT).exists():
        return False
    result = Result.load(directory / RESULT)
    return not can_go_on(result) and result.dataset.attrs["scenario_text"] == scenario.text


def patch_pictures(dataset: Dataset, at: list[str], directory: Path) -> list[Path]:
    """Patches and sections of one wheelset at the given distances [m] or poses."""
    from wrsim.plots import patch_gallery, save, section_gallery
    from wrsim.plots.cross_section import has_outlines

    moments = moments_at(dataset, at)
    name = "_".join("".join(c if c.isalnum() or c in "+-." else "-" for c in place) for place in at)
    files = [save(patch_gallery(dataset, moments), directory / f"patches_at_{name}.png")]
    if has_outlines(dataset):
        files.append(save(section_gallery(dataset, moments), directory / f"sections_at_{name}.png"))
    return files


def moments_at(dataset: Dataset, at: list[str]) -> list[int]:
    """Places of the asked distances or poses among those whose patches the result holds. Raises InputError."""
    from wrsim.plots.moments import has_patches

    if not has_patches(dataset):
        raise InputError("--at: this result holds no contact patches; choose places with [output] patches_at_m")
    if "pose" in dataset.dims:
        names = [str(name) for name in dataset["pose"].values]
        for place in at:
            if place not in names:
                raise InputError(f"--at {place}: there is no such pose{suggest(place, names)}; {_some(names)}")
        return [names.index(place) for place in at]
    distances = [float(d) for d in dataset["snapshot_distance"].values]
    moments = []
    for place in at:
        try:
            offsets = [abs(d - float(place)) for d in distances]
        except ValueError:
            raise InputError(f"--at {place}: must be a distance in m") from None
        if not min(offsets) <= NEAR:
            kept = _some([f"{d:.1f}" for d in distances])
            raise InputError(f"--at {place}: no patches are kept within {NEAR:g} m of there; {kept}")
        moments.append(offsets.index(min(offsets)))
    return moments


def _some(names: list[str], most: int = 12) -> str:
    """What there is, cut short."""
    return "there are " + ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
