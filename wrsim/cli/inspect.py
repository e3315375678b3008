"""``wrsim show``, ``plot``, ``report``, ``view``, ``diff``: results in numbers, pictures and pages."""

from pathlib import Path
from typing import Annotated

import typer

import wrsim
from wrsim.api.outcome import Outcome, in_units
from wrsim.cli import options
from wrsim.cli.console import print_lines, print_numbers
from wrsim.cli.errors import reporting_errors


def show_command(result: options.ResultFile, as_json: options.Json = False, units: options.Units = None) -> None:
    """Print the summary of a result, or of what there is of a run."""
    with reporting_errors(as_json), in_units(units):
        found = wrsim.show(result)
        print_numbers(as_json, found.numbers, found.tables)
        if not as_json:
            print_lines(*found.shown_lines)


@options.drawing
@options.writing(of="result")
def plot(
    result: options.ResultFile,
    output: options.BesideResult = None,
    at: options.At = None,
    wheelset: options.OneWheelset = None,
) -> Outcome:
    """Draw the pictures of a result; with --at the contact patches at chosen places only."""
    return wrsim.write_pictures(result, output, at or (), wheelset)


@options.writing(of="results")
def report(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Results: files, folders, cut-off runs; one study or evolution."),
    ],
    output: Annotated[
        Path | None, options.into(metavar="HTML", help="Default: report.html beside the first result.")
    ] = None,
    title: Annotated[str, typer.Option(metavar="TEXT", help="Default: the titles of the results.")] = "",
    author: Annotated[str, typer.Option(metavar="TEXT", help="Named beneath the title.")] = "",
    company: Annotated[str, typer.Option(metavar="TEXT", help="Named beneath the title and on every page.")] = "",
    logo: Annotated[Path | None, typer.Option(metavar="PNG|SVG|JPG", help="A picture beside the title.")] = None,
    date: Annotated[str, typer.Option(metavar="TEXT", help="Default: today.")] = "",
    with_view: Annotated[bool, typer.Option("--view", help="With the viewer of each result inside.")] = False,
    models: options.Models = None,
) -> Outcome:
    """Write a page about a result, several results beside each other, a study, or a profile evolution.

    It holds a summary, verdict, assessment, histories, contacts and wear; of a study outputs, pictures and cases.
    Versions and digests are in its appendix.
    """
    options.check_ending("-o", output, ".html")
    return wrsim.write_report(
        results, output, title=title, author=author, company=company, logo=logo, date=date, with_view=with_view,
        models=models or (),
    )  # fmt: skip


@options.writing(of="result")
def view(
    result: options.ResultFile,
    output: Annotated[Path | None, options.into(metavar="HTML", help="Default: view.html beside the result.")] = None,
    models: options.Models = None,
) -> Outcome:
    """Write a page to look at a run: wheels on their rails, the vehicle on its track, modes of a stability analysis."""
    options.check_ending("-o", output, ".html")
    return wrsim.write_view(result, output, models or ())


@options.drawing
@options.writing(reads="first second")
def diff_command(
    first: options.ResultFile,
    second: options.ResultFile,
    tolerance: Annotated[
        float,
        typer.Option(metavar="PART", help="Largest difference allowed, as a part of the quantity's largest value."),
    ] = 0.01,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="QUANTITY", help="Such as Y_over_Q_max; may be given again.")
    ] = None,
    output: Annotated[
        Path | None, options.into(metavar="DIR", help="Write a table and an overlay picture there.")
    ] = None,
) -> Outcome:
    """Compare two results: peaks, medians in full curves, other numbers; exit code 4 when they differ."""
    return wrsim.diff(first, second, tolerance, only or (), output)
