"""``wrsim report``, ``view`` and ``export``: pages about results for a browser, and files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_files
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import AnyResult, BesideResult, Force, Json, Models, check_ending


def report(
    results: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT...", help="Results: files, folders, runs that were cut off; one study or service."
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="HTML", help="Default: report.html beside the first result."),
    ] = None,
    with_view: Annotated[bool, typer.Option("--view", help="With the viewer of each result inside.")] = False,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a page about a result, several results beside each other, a study, or wheels in service.

    It holds identity, verdict, assessment, histories, contacts and wear; of a study outputs, pictures and cases.
    """
    from wrsim.report.output_folder import beside, writing

    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        from wrsim.results import write_atomically
        from wrsim.study.pages import page_of

        check_ending("-o", output, ".html")
        page = page_of(results, with_view, models or ())
        print_files([write_atomically(output or beside(results[0]) / "report.html", page.encode())], as_json)


def view(
    result: AnyResult,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="HTML", help="Default: view.html beside the result.")
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a page to look at a run: wheels on their rails, the vehicle on its track, modes of a stability analysis."""
    from wrsim.report.output_folder import beside, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.report.view import view_page
        from wrsim.results import write_atomically

        check_ending("-o", output, ".html")
        page = view_page(read(result), beside(result), models or ())
        print_files([write_atomically(output or beside(result) / "view.html", page.encode())], as_json)


def export(
    result: AnyResult,
    to: Annotated[
        str, typer.Option("--to", metavar="FORMAT,...", help="mat, csv, parquet, mdf; several with commas between.")
    ],
    output: BesideResult = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a result for other programs: MATLAB, CSV, Parquet or MDF (result.mat, .csv, .parquet, .mf4)."""
    from wrsim.report.output_folder import beside, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.results.exports import ENDINGS, formats
        from wrsim.results.exports import export as exported

        asked = formats(to)
        loaded, directory = read(result), output or beside(result)
        files = [exported(loaded, name, directory / f"result.{ENDINGS.get(name, name)}") for name in asked]
        print_files(files, as_json)
