"""The ``wrsim`` command: its entry point and all of its commands.

Functions of the API import what they need when they run, so that ``wrsim --help`` answers at once; what is called by
its name imports no other command.
"""

import atexit
import gc
import inspect
import logging
import sys
from collections.abc import Callable
from pkgutil import resolve_name
from typing import Annotated, Any

import typer

import wrsim
from wrsim.api.options import Option
from wrsim.api.outcome import Outcome
from wrsim.cli import console
from wrsim.cli.errors import INTERRUPTED, any_output, reporting_errors, usage_as_json
from wrsim.cli.options import QUIET, Values, command
from wrsim.errors import InputError

DRAWS_ONE = ("width_mm", "font", "style", "no_title")
DRAWS = ("formats", *DRAWS_ONE)
"""Options of pictures that are named as a whole, with their ending."""
STEP_MS = inspect.Parameter(
    "step_ms",
    inspect.Parameter.KEYWORD_ONLY,
    default=None,
    annotation=Annotated[float | None, Option("Step; default: one that holds.", least=1e-3, most=5.0)],
)


def _one_folder(values: Values) -> Values:
    if len(values["results"]) > 1 and "output" not in values:
        raise InputError("-o DIR is missing: an assessment of several runs belongs to none of their folders")
    return {}


def _columns(values: Values) -> Values:
    from wrsim.api.data import columns_of

    return {"columns": columns_of(values["file"], values.get("columns"))}


def _step(values: Values) -> Values:
    return {"step": 1e-3 * values["step_ms"]} if "step_ms" in values else {}


def _mute_log(values: Values) -> Values:
    if values["quiet"]:
        logging.getLogger("wrsim").setLevel(logging.ERROR)
    return {}


def _show_folder(outcome: Outcome, values: Values, removed: int = 0) -> None:
    """Tables, and where the files are."""
    if not values["quiet"]:
        console.print_numbers(False, {}, outcome.tables)
        console.print_lines(*outcome.shown_lines)
        console.print_files(len(outcome.files), outcome.folder, removed)


def _show_run(outcome: Outcome, values: Values) -> None:
    """The result, why a run stopped and how it goes on."""
    folder = outcome.folder
    if values["as_json"]:
        console.print_json(outcome.numbers)
    elif not outcome.files:
        console.print_error(*outcome.lines)
    else:
        _show_folder(outcome, values, len(outcome["removed"]))
        if outcome.code:
            console.print_error(f"{values['file']}: stopped: {outcome.value.result.stop_reason}")
        if outcome.code and not values["quiet"]:
            console.print_error(f"what was computed is in {folder}; draw it with: wrsim plot {folder}")
            if outcome.value.can_go_on:
                console.print_error("go on with the same command and --resume")


def _show_study(outcome: Outcome, values: Values) -> None:
    """The cases of a dry run with their time; or the outputs, and what went wrong."""
    if values["dry_run"]:
        console.print_numbers(values["as_json"], outcome.numbers, outcome.tables)
    elif values["as_json"]:
        console.print_json(outcome.numbers | {"files": [str(f) for f in outcome.files]})
    else:
        _show_folder(outcome, values)
        for message in outcome.value(values["quiet"]):
            console.print_error(message)


def warm(quiet: Annotated[bool, typer.Option("--quiet", "-q", help=QUIET)] = False) -> None:
    """Precompile the kernels of runs and poses."""
    with reporting_errors(False), console.progress_bar(not (quiet or sys.stderr.isatty())):
        message = wrsim.warm()
        if not quiet:
            console.print_lines(message)


def _command(function: str, *arguments: Any, **options: Any) -> Callable[[], Callable[..., None]]:
    """What makes the command of a function of the API, which it imports."""
    return lambda: command(resolve_name(f"wrsim.api.{function}"), *arguments, **options)


PANELS: dict[str, dict[str, Callable[[], Callable[..., None]]]] = {
    "Start": {
        "new": _command("data:new_file"),
        "check": _command("runs:check", adds=("as_json",)),
        "keys": _command("data:keys", adds=("as_json",)),
        "warm": lambda: warm,
    },
    "Run": {
        "run": _command("runs:run_scenario", _mute_log, _show_run, draws=DRAWS),
        "study": _command("studies:run_study", show=_show_study, draws=DRAWS),
        "type-test": _command("studies:run_type_test"),
        "wear": _command("studies:run_wear", draws=DRAWS),
        "optimise": _command("decisions:optimise", draws=DRAWS),
        "calibrate": _command("measurements:calibrate", draws=DRAWS),
        "compare": _command("runs:compare", draws=DRAWS, reads="scenario"),
        "resolve": _command("runs:resolve", draws=DRAWS),
    },
    "Inspect": {
        "show": _command("runs:show", adds=("as_json", "units")),
        "plot": _command("pages:write_pictures", draws=DRAWS, source="result"),
        "report": _command("pages:write_report", source="results"),
        "view": _command("pages:write_view", source="result"),
        "live": _command("pages:write_live", _step, reads="files", further=[STEP_MS]),
        "diff": _command("analyses:diff", draws=DRAWS, reads="first second"),
    },
    "Assess": {
        "assess": _command("analyses:assess", _one_folder, draws=DRAWS, source="results"),
        "validate": _command("measurements:validate", draws=DRAWS),
        "ride": _command("analyses:ride", draws=DRAWS, source="result"),
        "spectra": _command("analyses:spectra", draws=DRAWS, source="result"),
        "conicity": _command("profiles:conicity", draws=DRAWS),
        "vehicle": _command("vehicles:stationary", draws=DRAWS_ONE),
    },
    "Data": {
        "profile": _command("profiles:profiles", draws=DRAWS_ONE, reads="files"),
        "track": _command("pages:draw_track", draws=DRAWS_ONE, reads="file"),
        "recording": _command("data:read_recording", _columns, draws=DRAWS, reads="file columns"),
        "export": _command("data:export", source="result"),
        "dataset": _command("data:dataset", source="study"),
        "fmu": _command("data:write_unit", _step, reads="scenario", further=[STEP_MS]),
    },
}
"""What makes the commands, by their names, in the panels of the help."""


def application(wanted: str = "") -> typer.Typer:
    """All commands, or the wanted one alone if there is one of this name: those of others take time to make."""
    app = typer.Typer(
        help="Railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.",
        no_args_is_help=True,
        context_settings={"help_option_names": ["--help", "-h"]},
        pretty_exceptions_enable=False,
    )
    app.callback()(_common)
    is_there = any(wanted in members for members in PANELS.values())
    for panel, members in PANELS.items():
        for name, made in members.items():
            if name == wanted or not is_there:
                app.command(name, rich_help_panel=panel)(made())
    return app


def main() -> None:
    """Entry point of the ``wrsim`` command."""
    any_output()
    # three hundred thousand lasting objects of libraries are looked through otherwise: a second of a run
    gc.set_threshold(400_000, 20, 100)
    atexit.register(gc.freeze)  # nor at the end, where it takes half a second
    if sys.argv[1:2] == ["run"]:  # xarray and pandas ask of all numbers whether they are theirs
        for library in ("dask", "pyarrow"):
            sys.modules.setdefault(library, None)  # type: ignore[arg-type]
    console.show_progress()
    try:
        with usage_as_json("--json" in sys.argv[1:]) as standalone:
            sys.exit(application(*sys.argv[1:2])(prog_name="wrsim", standalone_mode=standalone))
    except KeyboardInterrupt:  # outside of a command
        sys.exit(INTERRUPTED)


def _version(wanted: bool) -> None:
    if wanted:
        console.print_lines(f"wrsim {wrsim.__version__}")
        raise typer.Exit


def _common(
    version: Annotated[
        bool, typer.Option("--version", "-v", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
