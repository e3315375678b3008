"""``wrsim report``, ``view`` and ``export``: pages about results for a browser, and files of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import BesideResult, Force, Json, Models, ResultFile, check_ending, into
from wrsim.errors import InputError


def report(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Results: files, folders, cut-off runs; or one study or service."),
    ],
    output: Annotated[Path | None, into(metavar="HTML", help="Default: report.html beside the first result.")] = None,
    with_view: Annotated[bool, typer.Option("--view", help="With the viewer of each result inside.")] = False,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a page about a result, several results beside each other, a study, or wheels in service.

    It holds identity, verdict, assessment, histories, contacts and wear; of a study outputs, pictures and cases.
    """
    from wrsim.report.output_folder import folder_of_result, writing

    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        from wrsim.results import write_atomically

        check_ending("-o", output, ".html")
        page = _page_of(results, with_view, models or ())
        file = write_atomically(output or folder_of_result(results[0]) / "report.html", page.encode())
        print_found(as_json, {}, [], [file])


def _page_of(paths: Sequence[Path], with_view: bool, models: Sequence[Path]) -> str:
    """The page about results of runs, one study, or one service; with_view: with the viewer of each result inside."""
    from wrsim.report.output_folder import folder_of_result, read
    from wrsim.report.page import report_page
    from wrsim.report.study import service_page, study_page
    from wrsim.report.view_data import view_page
    from wrsim.study import collect
    from wrsim.study.evolution import history

    for path in paths:
        kind = "study" if collect.holds(path, collect.NUMBERS) else ""
        kind = "service" if collect.holds(path, history.NUMBERS) else kind
        if not kind:
            continue
        if len(paths) > 1:
            raise InputError(f"{path}: is a {kind}: a report takes one {kind}, or results of runs")
        if with_view:
            raise InputError(f"--view: {path} is a {kind}; it is for results of runs, as each case of a {kind} is")
        if kind == "study":
            return study_page(collect.read_study(path), str(path))
        dataset = history.read_history(path)
        return service_page(dataset, str(path), history.mileage_table(dataset))
    results = [read(path) for path in paths]
    pairs = zip(results, paths, strict=True)
    viewers = [view_page(result, folder_of_result(path), models) for result, path in pairs] if with_view else []
    return report_page(results, list(map(str, paths)), viewers=viewers)


def view(
    result: ResultFile,
    output: Annotated[Path | None, into(metavar="HTML", help="Default: view.html beside the result.")] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a page to look at a run: wheels on their rails, the vehicle on its track, modes of a stability analysis."""
    from wrsim.report.output_folder import folder_of_result, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.report.view_data import view_page
        from wrsim.results import write_atomically

        check_ending("-o", output, ".html")
        page = view_page(read(result), folder_of_result(result), models or ())
        file = write_atomically(output or folder_of_result(result) / "view.html", page.encode())
        print_found(as_json, {}, [], [file])


def export(
    result: ResultFile,
    to: Annotated[
        str, typer.Option("--to", metavar="FORMAT,...", help="mat, csv, parquet, mdf; several with commas between.")
    ],
    output: BesideResult = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a result for other programs: MATLAB, CSV, Parquet or MDF (result.mat, .csv, .parquet, .mf4)."""
    from wrsim.report.output_folder import folder_of_result, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.results.exports import ENDINGS, export_result, formats

        asked = formats(to)
        loaded, directory = read(result), output or folder_of_result(result)
        files = [export_result(loaded, name, directory / f"result.{ENDINGS.get(name, name)}") for name in asked]
        print_found(as_json, {}, [], files)
