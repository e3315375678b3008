"""``wrsim report``: one page about one result, several beside each other, a study, or wheels in service."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, beside, check_ending
from wrsim.cli.showing import print_files
from wrsim.cli.storing import read, writing
from wrsim.errors import InputError


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
    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        check_ending("-o", output, ".html")
        target = output or beside(results[0]) / "report.html"
        from wrsim.study.collect import is_study
        from wrsim.study.service.record import is_service

        for path in results:
            kind = "study" if is_study(path) else "service" if is_service(path) else ""
            if kind:
                _report_alone(path, kind, len(results), with_view, target, as_json)
                return
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
        print_files([write_atomically(target, page.encode())], as_json)


def _report_alone(path: Path, kind: str, count: int, with_view: bool, target: Path, as_json: bool) -> None:
    """Write the page about a study or a service."""
    from wrsim.results import write_atomically

    if count > 1:
        raise InputError(f"{path}: is a {kind}: a report takes one {kind}, or results of runs")
    if with_view:
        raise InputError(f"--view: {path} is a {kind}; it is for results of runs, as each case of a {kind} is")
    if kind == "study":
        from wrsim.report.study import study_page
        from wrsim.study.collect import read_study

        page = study_page(read_study(path), str(path))
    else:
        from wrsim.report.service import service_page
        from wrsim.study.service.record import read_record, table_of

        dataset = read_record(path)
        page = service_page(dataset, str(path), table_of(dataset))
    print_files([write_atomically(target, page.encode())], as_json)
