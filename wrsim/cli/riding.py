"""``wrsim ride``: spectra, third-octaves and comfort at the points of a vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import AnyResult, BesideResult, Force, Json, Pictures, SectionsOf, beside
from wrsim.cli.showing import complain, print_json, print_tables, say
from wrsim.cli.storing import read, told_of, writing
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.results.ride import Ride


def ride(
    result: AnyResult,
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Ride: accelerations at the points of a vehicle, their spectra, third-octaves and comfort."""
    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.analysis.ride import evaluate_ride
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.run import RideSection

        loaded, section = read(result), None if scenario is None else load(scenario).table(RideSection)
        with told_of(result):
            found = evaluate_ride(loaded, section)
        directory = output or beside(result)
        files = write_ride(found, directory, pictures)
        if as_json:
            print_json(found.as_dict() | {"files": [str(f) for f in files]})
            return
        print_tables([found.table()])
        say(f"{len(files)} files in {directory}")


def write_ride_of(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """The ride of a run; one that was too short for it says so."""
    from wrsim.analysis.ride import evaluate_ride

    try:
        return write_ride(evaluate_ride(result), directory, pictures)
    except InputError as error:
        complain(f"no spectra: {error}")
        return []


def write_ride(found: Ride, directory: Path, pictures: bool) -> list[Path]:
    """Tables first, pictures last."""
    from wrsim.results import write_atomically

    files = [
        write_atomically(directory / "ride.json", found.json()),
        write_atomically(directory / "third_octaves.csv", found.bands_csv()),
        write_atomically(directory / "spectra.csv", found.spectra_csv()),
    ]
    if pictures:
        from wrsim.plots.ride import ride_pictures

        files += ride_pictures(found, directory)
    return files
