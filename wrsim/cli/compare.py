"""``wrsim compare`` and ``wrsim resolve``: one scenario, or the snapshots of a result, by several contact models."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_error, print_found, progress_bar
from wrsim.cli.errors import exit_code, reporting_errors
from wrsim.cli.options import At, Force, Json, Models, OneWheelset, Pictures, Quiet, ResultFile, ScenarioFile, into


def compare_command(
    file: ScenarioFile,
    contact: Annotated[
        str,
        typer.Option(
            metavar="A,B,...",
            help="Contact models: half-space, kik-piotrowski+polach, kik-piotrowski+strips=80; file: as in FILE.",
        ),
    ],
    reference: Annotated[
        str | None, typer.Option(metavar="A", help="Whom the others are measured against; default: the first.")
    ] = None,
    output: Annotated[Path | None, into(metavar="DIR", help="Default: results/<name of FILE>_compared.")] = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation."""
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force, file):
        from wrsim.analysis import exact_run_warning
        from wrsim.analysis.compare import compare, comparison_report, comparison_tables
        from wrsim.report.outputs import write_comparison
        from wrsim.scenario.build import build
        from wrsim.scenario.contact_choice import split_names, with_contact_model
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        names = split_names(contact)
        for words in [w for name in names for w in exact_run_warning(build(with_contact_model(scenario, name)))]:
            if not quiet:
                print_error(words)
        with progress_bar(not (quiet or as_json)) as progress:
            found = compare(scenario, names, reference, progress)
        directory = output or Path("results") / f"{file.stem}_compared"
        report = comparison_report(found, str(file))
        files = write_comparison(found, report, directory, pictures, scenario.title)
        if as_json or not quiet:
            print_found(as_json, report, comparison_tables(found, report), files, directory)
        if code := max(exit_code(m.result) for m in found.models):
            raise typer.Exit(code)


def resolve_command(
    result: ResultFile,
    contact: Annotated[
        str, typer.Option(metavar="NAME", help="Contact model, such as half-space+fastsim.")
    ] = "half-space",
    at: At = None,
    wheelset: OneWheelset = None,
    same: Annotated[
        str, typer.Option(metavar="load|pose", help="What every wheel keeps: its vertical force or its height.")
    ] = "load",
    output: Annotated[Path | None, into(metavar="DIR", help="Default: <folder of RESULT>/<NAME>.")] = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Solve the contacts at the snapshots of a result again, by the exact solver or any other contact model."""
    with reporting_errors(as_json):
        from wrsim.analysis.resolve import resolve
        from wrsim.report.output_folder import claimed, folder_of_result, naming, read, write_resolved
        from wrsim.report.outputs import file_name
        from wrsim.results.moments import moments_at, resolved_table
        from wrsim.results.summary_tables import first_lines, remarks
        from wrsim.scenario.loading import load_text

        before = read(result)
        folder = folder_of_result(result)
        with naming(result), progress_bar(not (quiet or as_json)) as progress:
            moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
            scenario = load_text(before.dataset.attrs["scenario_text"], folder, models or (), closed=True)
            after = resolve(before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress)
        directory = output or folder / file_name(contact)
        with claimed(directory, force, (result,)) as keeper:
            files = write_resolved(after, directory, pictures)
            keeper.clear(files)
        if as_json or not quiet:
            notes = first_lines(remarks(after.summary()), "remarks")
            tables = [resolved_table(before.wheelset(wheelset), after.wheelset(), notes)]
            numbers = {"directory": str(directory), "summary": after.summary()}
            print_found(as_json, numbers, tables, files, directory)
