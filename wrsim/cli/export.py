"""``wrsim export``: a result in the files of other programs."""

from __future__ import annotations

from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import AnyResult, BesideResult, Force, Json, beside
from wrsim.cli.showing import print_files
from wrsim.cli.storing import read, writing


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
    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.results.exports import ENDINGS, formats
        from wrsim.results.exports import export as exported

        asked = formats(to)
        loaded = read(result)
        directory = output or beside(result)
        files = [exported(loaded, name, directory / f"result.{ENDINGS.get(name, name)}") for name in asked]
        print_files(files, as_json)
