"""``wrsim assess``: a run assessed by EN 14363 and what else is known."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import BesideResult, Force, Json, Pictures, SectionsOf, beside
from wrsim.cli.showing import print_json, print_tables, say
from wrsim.cli.storing import RESULT, read, told_of, writing
from wrsim.errors import InputError


def assess(
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
    """Assess a run: EN 14363 quantities section by section, limits and margins; leaves tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).
    """
    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        from wrsim.analysis.assessment import assess as assessed
        from wrsim.results import write_atomically
        from wrsim.results.assessment_tables import assessment_csv, assessment_json, assessment_numbers, assessment_rows
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.assessment import AssessmentSection

        if len(results) > 1 and output is None:
            raise InputError("-o DIR is missing: an assessment of several runs belongs to none of their folders")
        loaded = [read(path) for path in results]
        settings = None if scenario is None else load(scenario).table(AssessmentSection).settings()
        names = _names(results)
        with told_of(*results):
            found = assessed(loaded, settings, names)
        directory = output or beside(results[0])
        files = [
            write_atomically(directory / "assessment.json", assessment_json(found)),
            write_atomically(directory / "assessment.csv", assessment_csv(found)),
        ]
        if pictures:
            from wrsim.plots.assessment import assessment_pictures

            files += assessment_pictures(found, directory)
        if as_json:
            print_json(assessment_rows(found) | {"files": [str(f) for f in files]})
            return
        print_tables(assessment_numbers(found))
        say(f"{len(files)} files in {directory}")


def _names(results: list[Path]) -> list[str]:
    """Names of runs: the ends of their paths, as long as it takes to tell them apart.

    Raises InputError for a run that is given twice.
    """
    paths = [path.resolve() for path in results]
    paths = [path.parent if path.name.startswith(RESULT) else path for path in paths]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError(f"{results[i]}: given twice")
    parts = 1
    while len({path.parts[-parts:] for path in paths}) < len(paths):
        parts += 1
    return ["/".join(path.parts[-parts:]) for path in paths]
