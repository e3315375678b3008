"""``wrsim assess`` and ``wrsim ride``: a run by EN 14363 and what else is known; its accelerations."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import BesideResult, Force, Json, Pictures, ResultFile, SectionsOf


def assess_command(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Runs: files, folders, cut off or not. Several count as one test."),
    ],
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Assess a run: EN 14363 quantities section by section, limits and margins; writes tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).
    """
    from wrsim.report.output_folder import folder_of_result, read, writing

    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        from wrsim.analysis.assessment import assess as assessed
        from wrsim.report.output_folder import names_apart, naming
        from wrsim.report.outputs import write_assessment
        from wrsim.results.assessment import assessment_dict, assessment_numbers
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.assessment import AssessmentSection

        names = names_apart(results, output)
        settings = None if scenario is None else load(scenario).table(AssessmentSection).settings()
        loaded = [read(path) for path in results]
        with naming(*results):
            found = assessed(loaded, settings, names)
        directory = output or folder_of_result(results[0])
        files = write_assessment(found, directory, pictures)
        print_found(as_json, assessment_dict(found), assessment_numbers(found), files, directory)


def ride(
    result: ResultFile,
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Ride: accelerations at the points of a vehicle, their spectra, third-octaves and comfort."""
    from wrsim.report.output_folder import folder_of_result, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.analysis.ride import evaluate_ride
        from wrsim.report.output_folder import naming
        from wrsim.report.outputs import write_ride
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.run import RideSection

        loaded, section = read(result), None if scenario is None else load(scenario).table(RideSection)
        with naming(result):
            found = evaluate_ride(loaded, section)
        directory = output or folder_of_result(result)
        files = write_ride(found, directory, pictures)
        print_found(as_json, found.as_dict(), [found.table()], files, directory)
