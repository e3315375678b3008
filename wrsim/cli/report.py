"""``wrsim report``: one page about one result, or about several beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, beside, check_ending
from wrsim.cli.showing import print_files
from wrsim.cli.storing import read, writing


def report(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Result files, folders of runs, or runs that were cut off."),
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
    """Write a page about a result: identity, verdict, assessment, histories, contacts; several are compared."""
    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        check_ending("-o", output, ".html")
        from wrsim.report import report_page
        from wrsim.report.page import rerun
        from wrsim.results import write_atomically

        loaded = [read(path) for path in results]
        sources = [str(path) for path in results]
        commands = [rerun(result, source) for result, source in zip(loaded, sources, strict=True)]
        viewers: list[str] = []
        if with_view:
            from wrsim.report.view import view_page

            viewers = [view_page(r, beside(path), models or ()) for r, path in zip(loaded, results, strict=True)]
        page = report_page(loaded, sources, commands=commands, viewers=viewers)
        target = output or beside(results[0]) / "report.html"
        print_files([write_atomically(target, page.encode())], as_json)
