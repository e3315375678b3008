"""The ``wrsim`` command: its entry point and all of its commands.

Functions of the API import what they need when they run, so that ``wrsim --help`` answers at once.
"""

import gc
import inspect
import logging
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

import wrsim
from wrsim.api import analyses, data, pages, profiles, runs, studies, vehicles
from wrsim.api.options import Option
from wrsim.api.outcome import Outcome, folder_beside
from wrsim.cli import console
from wrsim.cli.errors import INTERRUPTED, any_output, reporting_errors, usage_as_json
from wrsim.cli.options import QUIET, Given, command
from wrsim.errors import InputError

DRAWS = ("formats", "width_mm", "font", "style")
DRAWS_ONE = ("width_mm", "font", "style")
"""Options of pictures that are named as a whole, with their ending."""
STEP_MS = inspect.Parameter(
    "step_ms",
    inspect.Parameter.KEYWORD_ONLY,
    default=1.0,
    annotation=Annotated[float, Option("Step of the integration.", least=1e-3, most=5.0)],
)


def _beside(given: Given) -> Given:
    """Tables and pictures of a result go beside it."""
    results = given.get("results", [given.get("result")])
    if len(results) > 1 and "output" not in given:
        raise InputError("-o DIR is missing: an assessment of several runs belongs to none of their folders")
    return {"output": folder_beside(results[0], given.get("output"))}


def _profiles_output(given: Given) -> Given:
    return {"output": given.get("output") or Path(Path(given["files"][0]).resolve().stem + ".png")}


def _track_picture(given: Given) -> Given:
    return {"picture": given.get("picture") or Path(f"{given['file'].stem}_track.png")}


def _recording_files(given: Given) -> Given:
    columns = data.columns_of(given["file"], given.get("columns"))
    return {"output": given.get("output") or Path(given["file"].stem), "columns": columns}


def _compared_output(given: Given) -> Given:
    return {"output": given.get("output") or Path("results") / f"{given['scenario'].stem}_compared"}


def _mute_log(given: Given) -> Given:
    if given["quiet"]:
        logging.getLogger("wrsim").setLevel(logging.ERROR)
    return {}


def _show_run(outcome: Outcome, given: Given) -> None:
    """Tables, where the files are, why a run stopped and how it goes on."""
    quiet = given["quiet"]
    if given["as_json"]:
        console.print_json(outcome.numbers)
        return
    if not outcome.files:
        console.print_error(*outcome.lines)
        return
    if not quiet:
        console.print_numbers(False, {}, outcome.tables)
        console.print_lines(*outcome.shown_lines)
        console.print_files(len(outcome.files), outcome.folder, len(outcome["removed"]))
    if outcome.code:
        console.print_error(f"{given['file']}: stopped: {outcome.value.result.stop_reason}")
    if outcome.code and not quiet:
        folder = outcome.folder
        console.print_error(f"what was computed is in {folder}; draw it with: wrsim plot {folder}")
        if outcome.value.can_go_on:
            console.print_error("go on with the same command and --resume")


def _show_study(outcome: Outcome, given: Given) -> None:
    """Cases and their time, or the outputs, where the files are, and what went wrong."""
    as_json, quiet, planned = given["as_json"], given["quiet"], given["dry_run"]
    if as_json:
        console.print_json(outcome.numbers | ({} if planned else {"files": [str(f) for f in outcome.files]}))
        return
    if planned or not quiet:
        console.print_numbers(False, {}, outcome.tables)
    if planned:
        return
    if not quiet:
        console.print_files(len(outcome.files), outcome.folder)
    for message in outcome.value(quiet):
        console.print_error(message)


def _show_keys(outcome: Outcome, given: Given) -> None:
    if given["as_json"] and not given["schema"]:
        console.print_json(outcome.numbers)
    else:
        console.print_lines(*outcome.lines)


def warm(quiet: Annotated[bool, typer.Option("--quiet", "-q", help=QUIET)] = False) -> None:
    """Compile ahead what runs and poses need, so that the first of them starts at once."""
    with reporting_errors(False), console.progress_bar(not (quiet or sys.stderr.isatty())):
        message = wrsim.warm()
        if not quiet:
            console.print_lines(message)


PANELS: dict[str, dict[str, Any]] = {
    "Start": {
        "new": command(data.new_file),
        "check": command(runs.check, adds=("as_json",)),
        "keys": command(data.keys, show=_show_keys, adds=("as_json",)),
        "warm": warm,
    },
    "Run": {
        "run": command(runs.run_scenario, _mute_log, _show_run, draws=DRAWS),
        "study": command(studies.run_study, show=_show_study, draws=DRAWS),
        "type-test": command(studies.run_type_test),
        "wear": command(studies.run_wear, draws=DRAWS),
        "compare": command(runs.compare, _compared_output, draws=DRAWS, reads="scenario"),
        "resolve": command(runs.resolve, draws=DRAWS),
    },
    "Inspect": {
        "show": command(runs.show, adds=("as_json", "units")),
        "plot": command(pages.write_pictures, draws=DRAWS, of="result"),
        "report": command(pages.write_report, of="results"),
        "view": command(pages.write_view, of="result"),
        "diff": command(analyses.diff, draws=DRAWS, reads="first second"),
    },
    "Assess": {
        "assess": command(analyses.assess, _beside, draws=DRAWS, of="results"),
        "ride": command(analyses.ride, _beside, draws=DRAWS, of="result"),
        "spectra": command(analyses.spectra, _beside, draws=DRAWS, of="result"),
        "conicity": command(profiles.conicity, draws=DRAWS),
        "vehicle": command(vehicles.stationary, draws=DRAWS_ONE),
    },
    "Data": {
        "profile": command(profiles.profiles, _profiles_output, draws=DRAWS_ONE, reads="files"),
        "track": command(pages.draw_track, _track_picture, draws=DRAWS_ONE, reads="file"),
        "recording": command(data.read_recording, _recording_files, draws=DRAWS, reads="file columns"),
        "export": command(data.export, of="result"),
        "fmu": command(
            data.write_unit, lambda given: {"step": 1e-3 * given["step_ms"]}, reads="scenario", replaced=[STEP_MS]
        ),
    },
}
"""Commands by their names, in the panels of the help."""

app = typer.Typer(
    help="Railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["--help", "-h"]},
    pretty_exceptions_enable=False,
)
for panel, members in PANELS.items():
    for name, member in members.items():
        app.command(name, rich_help_panel=panel)(member)


def main() -> None:
    """Entry point of the ``wrsim`` command."""
    any_output()
    # a hundred thousand lasting objects of libraries are looked through again and again otherwise: a second of a run
    gc.set_threshold(50_000, 20, 100)
    console.show_progress()
    try:
        with usage_as_json("--json" in sys.argv[1:]) as standalone:
            sys.exit(app(prog_name="wrsim", standalone_mode=standalone))
    except KeyboardInterrupt:  # outside of a command
        sys.exit(INTERRUPTED)


def _version(wanted: bool) -> None:
    if wanted:
        console.print_lines(f"wrsim {wrsim.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", "-v", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
