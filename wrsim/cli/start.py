"""``wrsim new``, ``check``, ``keys``, ``warm``: a scenario to start from, checked; kernels compiled ahead."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_error, print_json, print_lines, print_numbers
from wrsim.cli.errors import reporting_errors, writing_files
from wrsim.cli.options import Force, Json, Models, Quiet, ScenarioFile, Set, into
from wrsim.register import ANALYSES, FILES


def new(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND",
            help=f"{', '.join(ANALYSES)} (scenarios), vehicle, train, track, profile, study or wear.",
        ),
    ] = "curving",
    template: Annotated[
        str | None,
        typer.Argument(
            metavar="[TEMPLATE]",
            help="vehicle: coach, metro, freight, tram, locomotive, wheelset; track: curve, line; profile: wheel, "
            "rail, worn-wheel.",
            show_default=False,
        ),
    ] = None,
    output: Annotated[Path | None, into(metavar="FILE", help="Default: <KIND>.toml here.")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a file to start from, which can be used as it is: a scenario that names all keys, or another kind."""
    with writing_files(as_json, force):
        from wrsim.results import write_atomically
        from wrsim.scenario.templates import template_files

        texts = template_files(kind, template, output or Path(f"{template or kind}.toml"))
        files = [write_atomically(path, text.encode()) for path, text in texts.items()]
        if as_json:
            print_json({"files": [str(path) for path in files]})
        else:
            command = "run" if kind in ANALYSES else "vehicle" if kind == "train" else kind
            print_lines(*map(str, files), f"use it with: wrsim {command} {files[0]}")
            print_lines(
                f"wrsim keys{'' if kind in ANALYSES else f' --file {FILE_KINDS.get(kind, kind)}'} explains its keys"
            )


FILE_KINDS = {"wear": "service"}
"""Names of kinds of files in the register, where they differ."""


def check_command(file: ScenarioFile, values: Set = None, models: Models = None, as_json: Json = False) -> None:
    """Check a scenario and all the files it names, without running it."""
    with reporting_errors(as_json):
        from wrsim.api import check

        found = check(file, values or (), models or ())
        print_numbers(as_json, found.numbers, found.tables)
        for words in [] if as_json else found["warnings"]:
            print_error(f"{file}: warning: {words}")


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


def warm_command(quiet: Quiet = False) -> None:
    """Compile ahead what runs and poses need, so that the first of them starts at once."""
    with reporting_errors(False):
        from wrsim.analysis.warming import warm_up

        words = warm_up()
        if not quiet:
            print_lines(words)
