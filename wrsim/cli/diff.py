"""``wrsim diff``: two results side by side; for regression tests, its exit code shows whether they are alike."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found
from wrsim.cli.errors import DIFFERENT, reporting_errors
from wrsim.cli.options import Force, Json, ResultFile, into


def diff(
    first: ResultFile,
    second: ResultFile,
    tolerance: Annotated[
        float,
        typer.Option(metavar="PART", help="Largest difference allowed, as a part of the quantity's largest value."),
    ] = 0.01,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="QUANTITY", help="Such as Y_over_Q_max; may be given again.")
    ] = None,
    output: Annotated[Path | None, into(metavar="DIR", help="Write a table and an overlay picture there.")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Compare two results: peaks, medians in full curves, other numbers; exit code 4 when they differ."""
    from wrsim.report.output_folder import naming, read, writing

    with reporting_errors(as_json), writing(force, first, second):
        from wrsim.report.outputs import write_differences
        from wrsim.results.differences import beyond, compared_tables, difference_table, differences, other_ends
        from wrsim.results.render import as_records

        names, results = (str(first), str(second)), (read(first), read(second))
        with naming(first, second):
            found = differences(*results, only or (), tolerance)
        ends = other_ends(*results)
        files = [] if output is None else write_differences(found, results, names, output)
        alike = not beyond(found, tolerance) and not ends
        numbers = {
            "alike": alike,
            "tolerance": tolerance,
            "ends": ends,
            "differences": as_records(difference_table(found)),
        }
        print_found(as_json, numbers, compared_tables(found, ends, tolerance, names), files, output)
        if not alike:
            raise typer.Exit(DIFFERENT)
