"""``wrsim view``: a run to look at in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import AnyResult, Force, Json, Models, beside, check_ending
from wrsim.cli.showing import print_files
from wrsim.cli.storing import read, writing


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
    with reporting_errors(as_json), writing(force, of=result):
        check_ending("-o", output, ".html")
        from wrsim.report.view import view_page
        from wrsim.results import write_atomically

        page = view_page(read(result), beside(result), models or ())
        print_files([write_atomically(output or beside(result) / "view.html", page.encode())], as_json)
