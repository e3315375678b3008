"""``wrsim keys``: what a file may hold; ``wrsim new``: a scenario to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_json, print_lines
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import Force, Json, into
from wrsim.register import ANALYSES, FILES


def keys(
    section: Annotated[
        str | None, typer.Argument(metavar="SECTION", help="A table such as contact or track.segments; default: all.")
    ] = None,
    file: Annotated[str, typer.Option("--file", metavar="KIND", help=f"{', '.join(FILES)}.")] = "scenario",
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of that kind of file, for editors.")
    ] = False,
    as_json: Json = False,
) -> None:
    """List the keys of a table: unit, what is allowed, default, other names, an example."""
    with reporting_errors(as_json):
        from wrsim.scenario.reference import check_kind, keys_numbers, keys_text, schema_text

        check_kind(file)
        if as_json and not schema:
            print_json(keys_numbers(file, section))
        else:
            print_lines(schema_text(file) if schema else keys_text(file, section))


def new(
    kind: Annotated[str, typer.Argument(metavar="ANALYSIS", help=f"One of {', '.join(ANALYSES)}.")] = "curving",
    output: Annotated[Path | None, into(metavar="FILE", help="Default: <ANALYSIS>.toml here.")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a scenario to start from: it runs as it is, and names every other key in a comment."""
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force):
        from wrsim.results import write_atomically
        from wrsim.scenario.reference import check_analysis
        from wrsim.scenario.templates import scenario_template

        check_analysis(kind)
        path = write_atomically(output or Path(f"{kind}.toml"), scenario_template(kind).encode())
        if as_json:
            print_json({"files": [str(path)]})
        else:
            print_lines(f"{path}: run it with: wrsim run {path}; wrsim keys SECTION explains its keys")
