"""``wrsim new``, ``check``, ``keys``, ``warm``: a scenario to start from, checked; kernels compiled ahead."""

import sys
from pathlib import Path
from typing import Annotated

import typer

import wrsim
from wrsim.api.outcome import Outcome
from wrsim.cli import options
from wrsim.cli.console import print_error, print_json, print_lines, print_numbers, progress_bar
from wrsim.cli.errors import reporting_errors
from wrsim.inputs.file_kinds import FILES
from wrsim.register import ANALYSES


@options.writing()
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
    output: Annotated[Path | None, options.into(metavar="FILE", help="Default: <KIND>.toml here.")] = None,
) -> Outcome:
    """Write a file to start from, which can be used as it is: a scenario that names all keys, or another kind."""
    return wrsim.new_file(kind, template, output)


def check_command(
    file: options.ScenarioFile, values: options.Set = None, models: options.Models = None, as_json: options.Json = False
) -> None:
    """Check a scenario and all the files it names, without running it."""
    with reporting_errors(as_json):
        found = wrsim.check(file, values or (), models or ())
        print_numbers(as_json, found.numbers, found.tables)
        for words in [] if as_json else found["warnings"]:
            print_error(f"{file}: warning: {words}")


def keys_command(
    section: Annotated[
        str | None,
        typer.Argument(metavar="SECTION", help="A table or a key, such as track.segments or contact.normal."),
    ] = None,
    file: Annotated[str, typer.Option("--file", metavar="KIND", help=f"{', '.join(FILES)}.")] = "scenario",
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of that kind of file, for editors.")
    ] = False,
    as_json: options.Json = False,
) -> None:
    """List the keys of a table: unit, what is allowed, default, other names, an example."""
    with reporting_errors(as_json):
        found = wrsim.keys(section, file, schema)
        if as_json and not schema:
            print_json(found.numbers)
        else:
            print_lines(*found.lines)


def warm_command(quiet: options.Quiet = False) -> None:
    """Compile ahead what runs and poses need, so that the first of them starts at once."""
    with reporting_errors(False), progress_bar(not (quiet or sys.stderr.isatty())):
        words = wrsim.warm()
        if not quiet:
            print_lines(words)
