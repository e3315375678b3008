"""Options and arguments that several commands take."""

import inspect
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial, wraps
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

import typer

import wrsim
from wrsim.api.outcome import Outcome, in_units
from wrsim.cli.console import print_error, print_outcome, progress_of, show_times, silent
from wrsim.cli.errors import reporting_errors, writing_files
from wrsim.errors import InputError

T = TypeVar("T")
Models = Annotated[
    list[Path] | None,
    typer.Option("--models", metavar="DIR", help="Folder with model files of your own; may be given again."),
]
Json = Annotated[bool, typer.Option("--json", help="Write one JSON object to stdout and nothing else.")]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        help="Change a key: vehicle.speed_kmh=60, vehicle.bogie.primary.stiffness_kN_per_m.2=1500.",
    ),
]
Force = Annotated[
    bool, typer.Option("--force", help="Write also over files that wrsim did not write, or that were changed since.")
]
Pictures = Annotated[bool, typer.Option(help="Draw the pictures.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar, no table.")]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", callback=show_times, help="Print each part of the work with its time.")
]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers", "-w", metavar="N", min=1, help="Worker processes here, or jobs of SLURM; default: one a processor."
    ),
]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Use the workers of this dask scheduler.")]
Tls = Annotated[
    Path | None,
    typer.Option(
        "--tls", metavar="DIR", help="Certificates for --scheduler or --slurm: a folder with ca.pem, cert.pem, key.pem."
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="List the cases and the time they will take; run nothing.")]
Retry = Annotated[bool, typer.Option("--retry", help="Run again what failed, stopped or ran out of time.")]
Slurm = Annotated[bool, typer.Option("--slurm", help="Run the workers as SLURM jobs (extra wrsim\\[cluster]).")]
SectionsOf = Annotated[
    Path | None, typer.Option("--scenario", metavar="FILE", help="Take the settings from this scenario instead.")
]
ScenarioFile = Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML).")]
ResultFile = Annotated[
    Path,
    typer.Argument(metavar="RESULT", help="A result file, the folder of a run, or a run that was cut off (.part)."),
]
Gauge = Annotated[float, typer.Option(min=400.0, max=2000.0, help="14 mm below the rail tops.")]
Inclination = Annotated[str, typer.Option(help='Of the rails: 1:40, 1:20 ... or "none".')]
Radius = Annotated[float, typer.Option(min=100.0, max=1500.0, help="Of both wheels at the tape circle.")]
At = Annotated[
    list[str] | None,
    typer.Option("--at", metavar="PLACE", help="Contacts at this distance of the vehicle, in m, or of this pose only."),
]
OneWheelset = Annotated[
    str | None, typer.Option("--wheelset", metavar="NAME", help="This wheelset, or that number, alone.")
]
into = partial(typer.Option, "--output", "-o")
"""Where to write."""
Output = Annotated[Path | None, into(metavar="DIR", help="Default: results/<name of FILE>.")]
BesideResult = Annotated[Path | None, into(metavar="DIR", help="Default: beside the result.")]


PICTURES = (".png", ".svg", ".pdf")
"""Endings of the names of pictures."""


Formats = Annotated[
    str | None, typer.Option("--format", metavar="png,svg,pdf", help="Kinds of pictures, one or more; default png.")
]
LOOK = {
    "width_mm": Annotated[
        float | None, typer.Option("--width-mm", metavar="MM", help="Width of pictures, 60 to 500; default 170.")
    ],
    "font": Annotated[str | None, typer.Option(metavar="NAME", help="Family of the letters, such as 'DejaVu Serif'.")],
    "style": Annotated[str | None, typer.Option(metavar="FILE", help="Style file, or a style of matplotlib.")],
}
"""How pictures look."""


Units = Annotated[
    str | None,
    typer.Option(
        "--units", metavar="metric|us", help="Of tables, pictures, reports; default: those of the scenario, or metric."
    ),
]


def drawing(command: Callable[..., None], kinds: bool = True) -> Callable[..., None]:
    """The command with the options of the pictures that it draws; kinds: also that of their kinds, unless a picture is
    named as a whole, with its ending."""
    added: dict[str, Any] = ({"formats": Formats} if kinds else {}) | LOOK
    chooses = "units" not in inspect.signature(command).parameters  # else the command does, which is itself decorated

    def looked(**given: Any) -> None:
        chosen = {name: value for name in added if (value := given.pop(name)) is not None}
        with reporting_errors(given["as_json"]), ExitStack() as stack:
            if chooses:
                stack.enter_context(in_units(given.pop("units")))
            if chosen:
                stack.enter_context(wrsim.look(**chosen))
            command(**given)

    return _with_options(looked, command, added | {"units": Units})


drawing_to = partial(drawing, kinds=False)


READING = {
    "unit": Annotated[str | None, typer.Option(metavar="mm|m|cm|in|thou", help="Of files of points.")],
    "heights": Annotated[str | None, typer.Option(metavar="up|down", help="Which way heights of points grow.")],
    "field_side": Annotated[
        str | None,
        typer.Option(metavar="positive|negative", help="Sign of the field side, points of rails."),
    ],
    "origin": Annotated[
        str | None, typer.Option(metavar="'tape circle'|'flange back'", help="Where x is zero in points of wheels.")
    ],
    "back_to_tape_circle_mm": Annotated[
        float | None, typer.Option(min=20.0, max=120.0, help="From the flange back; default: of the file, or 70.")
    ],
    "measured": Annotated[
        bool | None,
        typer.Option("--measured/--exact", help="Smooth points, or interpolate; default: by file."),
    ],
}
"""How files of points are read; what a profile file says itself wins."""


def reading_profiles(command: Callable[..., Outcome]) -> Callable[..., Outcome]:
    """The command with options for the files of points that it reads, which it takes by name."""
    return _with_options(lambda **given: command(**given), command, READING)


WORKERS = {"workers": Workers, "scheduler": Scheduler, "slurm": Slurm, "tls": Tls}
"""Where cases run."""


def writing(
    of: str = "", reads: str = "", takes: str = "", workers: bool = False
) -> Callable[[Callable[..., Outcome]], Callable[..., None]]:
    """A command that writes files, from the function that gives what it found: with the options ``--force`` and
    ``--json``. It prints what was found and ends with its exit code.

    of, reads: parameters with the result that it reports on and with files that it reads; of several results the first
    one counts. takes: what the function takes by name of "force", "bar", "notify" and "warn", where it takes long: with
    ``--quiet`` and ``--verbose``. workers: whether it also takes where its cases run.
    """
    added = (WORKERS if workers else {}) | {"force": Force, "as_json": Json}
    added |= ({"quiet": Quiet, "verbose": Verbose} if takes else {}) | {"units": Units}

    def decorated(function: Callable[..., Outcome]) -> Callable[..., None]:
        def command(
            force: bool, as_json: bool, units: str | None, quiet: bool = False, verbose: bool = False, **given: Any
        ) -> None:
            result, *others = _paths(given.get(of)) or [None]
            read = [path for name in reads.split() for path in _paths(given[name])]
            own = {"force": force, "warn": silent if quiet and not workers else print_error}
            own |= progress_of(quiet or as_json)
            with writing_files(as_json, force, *others, *read, of=result), in_units(units):
                found = function(**given, **{name: own[name] for name in takes.split()})
                for words in [] if as_json else found.numbers.get("warnings", ()):
                    print_error(f"{given['file']}: warning: {words}")
                if as_json or not quiet:
                    print_outcome(as_json, found)
                if found.code:
                    raise typer.Exit(found.code)

        return _with_options(command, function, added)

    return decorated


def _paths(given: Any) -> list[Any]:
    return [] if given is None else list(map(Path, given)) if isinstance(given, list) else [Path(given)]


def _with_options(wrapper: Callable[..., T], function: Callable[..., Any], added: dict[str, Any]) -> Callable[..., T]:
    """The wrapper as a command with the parameters of a function and further options, which are off or not given."""
    signature = inspect.signature(function, eval_str=True)
    here = partial(inspect.Parameter, kind=inspect.Parameter.KEYWORD_ONLY)
    own = [here(name, annotation=of, default=False if get_args(of)[0] is bool else None) for name, of in added.items()]
    given = [each for name, each in signature.parameters.items() if name not in added]
    given = [each for each in given if each.kind is not inspect.Parameter.VAR_KEYWORD]
    command = wraps(function)(wrapper)
    command.__signature__ = signature.replace(parameters=[*given, *own])  # type: ignore[attr-defined]
    command.__annotations__ = function.__annotations__ | added
    return command


def check_ending(option: str, path: Path | None, *endings: str) -> None:
    """Raises InputError for a file to be written whose name does not end as it must."""
    if path is not None and path.suffix.lower() not in endings:
        raise InputError(f"{option} {path}: must end in {' or '.join(endings)}")
