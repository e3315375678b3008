"""The command line: check, run, plot, profile.

Commands import what they need when they run, so that ``wrsim --help`` answers at once. Every error that a user can
meet becomes one message on stderr (with ``--json``: one JSON object on stdout) and an exit code:

==== ==================================================================
0    done
1    the result could not be written: full disk, no permission
2    bad input: a file, a key, a value, an argument
3    the run stopped early; what was computed is on disk
70   a mistake in wrsim itself; WRSIM_DEBUG=1 shows where
130  interrupted with Ctrl-C; what was computed is on disk
==== ==================================================================
"""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim import __version__
from wrsim.errors import InputError, WrsimError

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.scenario.loading import Scenario

STOPPED, INTERNAL, INTERRUPTED = 3, 70, 130
FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
DEBUG = "WRSIM_DEBUG"

Progress = Callable[[float, float], None]

app = typer.Typer(
    help="Railway wheelsets on curved track with conformal wheel-rail contact.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

ScenarioFile = Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML).")]
Models = Annotated[
    list[Path] | None,
    typer.Option("--models", metavar="DIR", help="Folder with model files of your own; may be given again."),
]
Json = Annotated[bool, typer.Option("--json", help="Write one JSON object to stdout and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar, no summary.")]


def main() -> None:
    """Entry point of the ``wrsim`` command."""
    try:
        app(prog_name="wrsim")
    except KeyboardInterrupt:  # outside of a command
        sys.exit(INTERRUPTED)


def _version(asked: bool) -> None:
    if asked:
        print(f"wrsim {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def check(file: ScenarioFile, models: Models = None, as_json: Json = False) -> None:
    """Check a scenario and all the files it names, without running it."""
    with _told(as_json):
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        facts = _facts(build(scenario))
        if as_json:
            _print_json({"status": "valid", "scenario": str(file), **facts})
        else:
            print(f"{file}: valid")
            _print_facts(facts)


@app.command()
def run(
    file: ScenarioFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: results/<name of FILE>.")
    ] = None,
    models: Models = None,
    pictures: Annotated[bool, typer.Option(help="Draw the standard pictures.")] = True,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scenario; leaves dataset, tables, summary and pictures in DIR."""
    with _told(as_json):
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        directory = output if output is not None else Path("results") / file.stem
        _claim(directory, scenario)
        from wrsim.analysis import run as analyse

        with _progress_bar(not (quiet or as_json)) as progress:
            result = analyse(scenario, progress=progress, output=directory)
        files = _write(result, directory, pictures)
        code = _exit_code(result)
        if as_json:
            _print_json(
                {
                    "status": result.status,
                    "exit_code": code,
                    "directory": str(directory),
                    "files": [str(f) for f in files],
                    "summary": result.summary(),
                }
            )
        else:
            if not quiet:
                _print_summary(result, directory, files)
            if code:
                _complain(f"{file}: stopped: {result.stop_reason}")
                if not quiet:
                    _complain(f"what was computed is in {directory}; draw it with: wrsim plot {directory}")
        if code:
            raise typer.Exit(code)


@app.command()
def plot(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="A result file, or the folder of a run.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: beside the result.")
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at", metavar="PLACE", help="Patches at this distance in m, or of this pose; may be given again."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw the pictures of a result."""
    with _told(as_json):
        from wrsim.plots import standard_pictures
        from wrsim.results import Result

        loaded = Result.load(result)
        directory = output or (result if result.is_dir() else result.parent)
        files = standard_pictures(loaded.dataset, directory, **({"at": at} if at else {}))
        _print_files(files, as_json)


@app.command()
def profile(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Wheel or rail profile: TOML or points.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PNG", help="Default: <name of FILE>.png here.")
    ] = None,
    kind: Annotated[
        str | None, typer.Option(metavar="wheel|rail", help="Needed for a file of two columns only.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw a profile with its slope and curvature."""
    with _told(as_json):
        if kind not in (None, "wheel", "rail"):
            raise InputError(f"--kind {kind}: must be wheel or rail")
        from wrsim.geometry.profile_models import load_profile
        from wrsim.plots import profile_picture

        loaded = load_profile(file, kind)  # type: ignore[arg-type]
        picture = output or Path(file.stem + ".png")
        if picture.suffix.lower() != ".png":
            raise InputError(f"-o {picture}: must end in .png")
        _print_files([profile_picture(loaded, picture)], as_json)


# --- what a run does around the analysis ---------------------------------------------------------------


def _claim(directory: Path, scenario: Scenario) -> None:
    """Put the scenario's text into the folder: the record of the run, and proof that it may be written to."""
    from wrsim.results import write_atomically

    record = directory / "scenario.toml"
    if scenario.path is None or not record.exists() or not record.samefile(scenario.path):
        write_atomically(record, scenario.text.encode())


def _write(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """Numbers first, pictures last: what fails late costs least."""
    from wrsim.results import write_run

    files = [directory / "scenario.toml", *write_run(result, directory)]
    if pictures:
        from wrsim.plots import standard_pictures

        files += standard_pictures(result.dataset, directory)
    return files


def _exit_code(result: Result) -> int:
    if result.status == "completed":
        return 0
    interrupted = result.dataset.attrs.get("stop_cause") == "interrupt"
    return INTERRUPTED if interrupted or result.stop_reason.startswith("interrupted") else STOPPED


@contextmanager
def _progress_bar(wanted: bool) -> Iterator[Progress | None]:
    """A bar with the time left on stderr if that is a terminal; the callback takes (fraction, seconds left)."""
    if not (wanted and sys.stderr.isatty()):
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (TextColumn("running"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[left]}"))
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("run", total=1.0, left="")

        def advance(fraction: float, seconds_left: float) -> None:
            bar.update(task, completed=fraction, left=_duration(seconds_left))

        yield advance


def _duration(seconds: float) -> str:
    """Time left in words that do not flicker."""
    if not 0.0 <= seconds < 1e7:
        return ""
    if seconds < 90.0:
        return f"{seconds:.0f} s left"
    return f"{seconds / 60.0:.0f} min left" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h left"


# --- what the user reads -------------------------------------------------------------------------------


def _facts(setup: Setup) -> dict[str, Any]:
    """What a scenario comes to, for people to see that it is what they meant."""
    facts: dict[str, Any] = {
        "title": setup.title,
        "analysis": setup.analysis,
        "vehicle": setup.wheelset.name,
        "axle_load_kN": setup.wheelset.static_axle_load / 1e3,
        "gauge_mm": 1e3 * setup.track.nominal_gauge,
        "rails": [rail.name for rail in setup.rails],
        "files": [str(f) for f in setup.files],
    }
    if setup.static is not None:
        facts["poses"] = len(setup.static.poses)
    elif setup.analysis == "curving":
        facts["segments"] = [f.label if f.label == f.kind else f"{f.kind} {f.label}" for f in setup.track.features()]
        facts["from_m"], facts["to_m"] = setup.run.start, setup.run.end
        facts["speed_kmh"] = 3.6 * setup.run.speed
        facts["duration_s"] = setup.run.duration
        facts["patches_at_m"] = list(setup.run.patches_at)
    return facts


def _print_facts(facts: dict[str, Any]) -> None:
    for name, value in facts.items():
        if isinstance(value, list):
            value = ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
        elif isinstance(value, float):
            value = f"{value:.6g}"
        print(f"  {name:<14} {value}")


def _print_summary(result: Result, directory: Path, files: list[Path]) -> None:
    """The peaks of each wheel as a small table, and where everything is."""
    from rich.console import Console
    from rich.table import Table

    summary = result.summary()
    table = Table(title=result.title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    table.add_column("peak")
    for wheel in summary["wheels"]:
        table.add_column(wheel, justify="right")
        table.add_column("at", justify="left", style="dim")
    names = list(next(iter(summary["wheels"].values()), {}))
    for name in names:
        peaks = [peaks.get(name) for peaks in summary["wheels"].values()]
        if any(p is not None and p["value"] is not None for p in peaks):
            table.add_row(name, *(cell for p in peaks for cell in _peak(p)))
    console = Console(highlight=False)
    console.print(table)
    console.print(f"{len(files)} files in {directory}", soft_wrap=True)


def _peak(peak: dict[str, Any] | None) -> tuple[str, str]:
    if peak is None or peak["value"] is None:
        return "-", ""
    place = peak.get("pose")
    if place is None:
        place = f"{peak['distance_m']:.1f} m" if "distance_m" in peak else f"{peak['time_s']:.3f} s"
    return f"{peak['value']:.4g}", str(place)


def _print_files(files: list[Path], as_json: bool) -> None:
    if as_json:
        _print_json({"files": [str(f) for f in files]})
    else:
        for file in files:
            print(file)


def _print_json(content: dict[str, Any]) -> None:
    print(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))


def _complain(message: str) -> None:
    print(message, file=sys.stderr)


# --- errors --------------------------------------------------------------------------------------------


@contextmanager
def _told(as_json: bool) -> Iterator[None]:
    """Turn every error of a command into a message and an exit code."""
    try:
        yield
        sys.stdout.flush()
    except WrsimError as error:
        _fail(str(error), type(error).__name__, error.exit_code, as_json)
    except KeyboardInterrupt:
        _fail("interrupted", "KeyboardInterrupt", INTERRUPTED, as_json)
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit from None
    except OSError as error:
        full = error.errno in FULL_DISK
        reason = "the disk is full; free some space or choose another directory" if full else error.strerror
        where = f"{error.filename}: " if error.filename else ""
        _fail(f"{where}{reason or error}", "WrsimError", WrsimError.exit_code, as_json)
    except MemoryError:
        message = "out of memory: fewer poses, a larger output interval or fewer patches_at_m need less"
        _fail(message, "MemoryError", WrsimError.exit_code, as_json)
    except Exception as error:
        if isinstance(error, typer.Exit) or os.environ.get(DEBUG):
            raise
        message = (
            f"internal error: {type(error).__name__}: {error}\n"
            f"This is a mistake in wrsim {__version__}, not in your input. Please report it with the scenario; "
            f"{DEBUG}=1 shows where it happened."
        )
        _fail(message, "InternalError", INTERNAL, as_json)


def _fail(message: str, kind: str, code: int, as_json: bool) -> None:
    if as_json:
        _print_json({"error": {"kind": kind, "exit_code": code, "messages": message.split("\n")}})
    else:
        _complain(message)
    raise typer.Exit(code) from None


if __name__ == "__main__":
    main()
