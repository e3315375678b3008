"""The ``wrsim`` command: its entry point and all of its commands.

Commands import what they need when they run, so that ``wrsim --help`` answers at once.
"""

import gc
import sys
from typing import Annotated

import typer

from wrsim import __version__
from wrsim.cli.assess import assess_command, conicity_command, ride_command, spectra_command, vehicle
from wrsim.cli.console import print_lines, show_progress
from wrsim.cli.data import export_command, fmu, profile, recording, track
from wrsim.cli.errors import INTERRUPTED, any_output, usage_as_json
from wrsim.cli.inspect import diff_command, plot, report, show_command, view
from wrsim.cli.run import compare_command, resolve_command, run_command, study, type_test, wear
from wrsim.cli.start import check_command, keys_command, new, warm_command

app = typer.Typer(
    help="Railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["--help", "-h"]},
    pretty_exceptions_enable=False,
)

PANELS = {
    "Start": (new, check_command, keys_command, warm_command),
    "Run": (run_command, study, type_test, wear, compare_command, resolve_command),
    "Inspect": (show_command, plot, report, view, diff_command),
    "Assess": (assess_command, ride_command, spectra_command, conicity_command, vehicle),
    "Data": (profile, track, recording, export_command, fmu),
}
for panel, commands in PANELS.items():
    for command in commands:
        name = command.__name__.removesuffix("_command").replace("_", "-")
        app.command(name, rich_help_panel=panel)(command)


def main() -> None:
    """Entry point of the ``wrsim`` command."""
    any_output()
    # a hundred thousand lasting objects of libraries are looked through again and again otherwise: a second of a run
    gc.set_threshold(50_000, 20, 100)
    show_progress()
    try:
        with usage_as_json("--json" in sys.argv[1:]) as standalone:
            sys.exit(app(prog_name="wrsim", standalone_mode=standalone))
    except KeyboardInterrupt:  # outside of a command
        sys.exit(INTERRUPTED)


def _version(wanted: bool) -> None:
    if wanted:
        print_lines(f"wrsim {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", "-v", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
