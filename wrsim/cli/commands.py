"""The commands: check, run, show, plot, profile; every other one is in a file of its own.

They import what they need when they run, so that ``wrsim --help`` answers at once.
"""

from __future__ import annotations

import gc
import logging
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim import __version__
from wrsim.cli.assessing import assess
from wrsim.cli.compare import compare
from wrsim.cli.conicity import conicity
from wrsim.cli.diff import diff
from wrsim.cli.ending import INTERRUPTED, any_output, exit_code, reporting_errors, usage_as_json
from wrsim.cli.export import export
from wrsim.cli.keys import keys, new
from wrsim.cli.options import (
    BesideResult,
    Force,
    Json,
    Models,
    Output,
    Set,
    beside,
    check_ending,
    with_set,
)
from wrsim.cli.recording import recording
from wrsim.cli.report import report
from wrsim.cli.resolve import resolve
from wrsim.cli.riding import ride
from wrsim.cli.showing import (
    complain,
    facts,
    facts_table,
    print_files,
    print_json,
    print_result,
    print_tables,
    progress_bar,
    say,
    say_files,
    tell_progress,
    tell_slow,
    warn,
)
from wrsim.cli.storing import (
    PART,
    begin,
    can_go_on,
    claimed,
    has_all_files,
    patch_pictures,
    read,
    whole_result,
    write,
    writing,
)
from wrsim.cli.study import study
from wrsim.cli.track import track
from wrsim.cli.vehicle import vehicle
from wrsim.cli.view import view
from wrsim.cli.warm import warm
from wrsim.cli.wear import wear
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.results import Result

app = typer.Typer(
    help="Railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["--help", "-h"]},
    pretty_exceptions_enable=False,
)

ScenarioFile = Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML).")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar, no summary.")]


def main() -> None:
    """Entry point of the ``wrsim`` command."""
    any_output()
    # a hundred thousand lasting objects of libraries are looked through again and again otherwise: a second of a run
    gc.set_threshold(50_000, 20, 100)
    # no array here is one of dask's; xarray imports dask.array to see that, which takes a tenth of a second
    sys.modules.setdefault("dask.array", None)  # type: ignore[arg-type]
    tell_progress()
    try:
        with usage_as_json("--json" in sys.argv[1:]) as standalone:
            sys.exit(app(prog_name="wrsim", standalone_mode=standalone))
    except KeyboardInterrupt:  # outside of a command
        sys.exit(INTERRUPTED)


def _version(asked: bool) -> None:
    if asked:
        say(f"wrsim {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", "-v", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def check(file: ScenarioFile, values: Set = None, models: Models = None, as_json: Json = False) -> None:
    """Check a scenario and all the files it names, without running it."""
    with reporting_errors(as_json):
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load
        from wrsim.scenario.plausibility import warnings

        scenario = with_set(load(file, models or ()), values or ())
        setup = build(scenario)
        if getattr(setup.plan, "limited", False):
            from wrsim.analysis import check_step

            check_step(scenario, setup)
        found = facts(setup)
        if as_json:
            print_json({"status": "valid", "scenario": str(file), "warnings": warnings(setup), **found})
        else:
            print_tables([facts_table(f"{file}: valid", found)])
            warn(file, setup)


@app.command()
def run(
    file: ScenarioFile,
    output: Output = None,
    values: Set = None,
    models: Models = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the run in DIR that was cut off or interrupted.")
    ] = False,
    threads: Annotated[
        int, typer.Option("--threads", min=1, help="Cores that compute the wheels' contacts side by side.")
    ] = 1,
    pictures: Annotated[bool, typer.Option(help="Draw the standard pictures.")] = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scenario; leaves dataset, tables, summary and pictures in DIR.

    While it lasts, a run is kept in DIR/result.nc.part, so that one that was cut off goes on with --resume.
    """
    with reporting_errors(as_json):
        from wrsim.results.summary_tables import wall_time
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load
        from wrsim.simulation.threads import use_threads

        use_threads(threads)
        scenario = with_set(load(file, models or ()), values or ())
        setup = build(scenario)  # what cannot run leaves nothing behind
        if quiet:
            logging.getLogger("wrsim").setLevel(logging.ERROR)
        else:
            warn(file, setup)
            tell_slow(setup)
        directory = output if output is not None else Path("results") / file.stem
        record = directory / PART
        with claimed(directory, force, (*scenario.files, *setup.files), file) as keeper:
            result = whole_result(directory, scenario) if resume else None
            if result is not None and has_all_files(directory, scenario, pictures):
                if as_json:
                    print_json({"status": "completed", "exit_code": 0, "directory": str(directory), "files": []})
                else:
                    complain(f"{directory} holds the whole result of this scenario already")
                return
            if resume and result is None and not record.exists():
                complain(f"there is no run in {directory} to go on with; it starts from the beginning")
                resume = False
            from wrsim.analysis import run as analyse
            from wrsim.core.compiling import COUNT

            begin(directory, scenario)
            started, before = time.perf_counter(), COUNT.seconds
            try:
                if result is None:
                    with progress_bar(not (quiet or as_json)) as progress:
                        result = analyse(
                            scenario, progress=progress, record=record, resume=resume, setup=setup, threads=threads
                        )
                compiling = COUNT.seconds - before
                lasted, wall = _lasted(result), time.perf_counter() - started - compiling
                took = {} if resume else {"wall_time_s": round(wall, 3), "compiling_s": round(compiling, 3)}
                if lasted and took:
                    took["times_real_time"] = round(wall / lasted, 4)
                files = write(result, directory, pictures)
                removed = keeper.clear(files)
            except KeyboardInterrupt:
                if record.exists():
                    raise KeyboardInterrupt(f"interrupted; the run is safe in {record}: go on with --resume") from None
                raise
        code = exit_code(result)
        if as_json:
            print_json(
                {
                    "status": result.status,
                    "exit_code": code,
                    "directory": str(directory),
                    "files": [str(f) for f in files],
                    "removed": [str(f) for f in removed],
                    "summary": {**result.summary(), **took},
                }
            )
        else:
            if not quiet:
                print_result(result)
                if "times_real_time" in took:
                    say(wall_time(wall, lasted, compiling))
                say_files(len(files), directory, len(removed))
            if code:
                complain(f"{file}: stopped: {result.stop_reason}")
                if not quiet:
                    complain(f"what was computed is in {directory}; draw it with: wrsim plot {directory}")
                    if can_go_on(result):
                        complain("go on with the same command and --resume")
        if code:
            raise typer.Exit(code)


def _lasted(result: Result) -> float:
    """How long the vehicle of a result has run [s]; 0 of what does not run along the track."""
    times = result.dataset.coords.get("time")
    return 0.0 if times is None or times.size == 0 else float(times[-1] - times[0])


ResultFile = Annotated[
    Path,
    typer.Argument(metavar="RESULT", help="A result file, the folder of a run, or a run that was cut off (.part)."),
]


@app.command()
def show(result: ResultFile, as_json: Json = False) -> None:
    """Print the summary of a result, or of what there is of a run."""
    with reporting_errors(as_json):
        loaded = read(result)
        if as_json:
            print_json(loaded.summary())
            return
        print_result(loaded)
        if loaded.stop_reason:
            say(f"stopped: {loaded.stop_reason}")


@app.command()
def plot(
    result: ResultFile,
    output: BesideResult = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="PLACE",
            help="Patches where the wheelset is there, in m, or of this pose; may be repeated.",
        ),
    ] = None,
    wheelset: Annotated[
        str | None, typer.Option(metavar="NAME", help="Pictures of this wheelset, or of that number, alone.")
    ] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw the pictures of a result; with --at the contact patches at chosen places only."""
    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.plots import standard_pictures
        from wrsim.results.wheelsets import folder_of, wheelsets, worst_wheelset

        loaded = read(result)
        dataset, directory = loaded.dataset, output or beside(result)
        if wheelset is not None or at:
            dataset = loaded.wheelset(wheelset or worst_wheelset(dataset))
            if output is None:
                directory /= folder_of(wheelsets(loaded.dataset), str(dataset["wheelset"].item()))
        if at:
            files = patch_pictures(dataset, at, directory)
        else:
            files = standard_pictures(dataset, directory)
        print_files(files, as_json)


@app.command()
def profile(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="Wheel or rail profile: TOML or points, such as wheels/S1002.toml.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PNG", help="Default: <name of FILE>.png here.")
    ] = None,
    kind: Annotated[
        str | None, typer.Option(metavar="wheel|rail", help="Needed for a file of two columns only.")
    ] = None,
    cutoff: Annotated[
        list[float] | None,
        typer.Option(
            "--cutoff",
            metavar="MM",
            help="Smooth the points as measured ones, halving waves of this length; up to four, to compare them.",
        ),
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw a profile with its slope and curvature; of measured points also what smoothing did to them."""
    with reporting_errors(as_json), writing(force, Path(file)):
        if kind not in (None, "wheel", "rail"):
            raise InputError(f"--kind {kind}: must be wheel or rail")
        picture = output or Path(Path(file).stem + ".png")
        check_ending("-o", picture, ".png")
        from wrsim.cli.profiles import loaded_and_smoothed
        from wrsim.inputs.lookup import model_file
        from wrsim.plots.profile import profile_picture

        path = model_file(file, models)
        loaded, reports = loaded_and_smoothed(path, kind, cutoff or [])  # type: ignore[arg-type]
        files = [profile_picture(loaded, picture, reports)]
        if as_json:
            smoothing = {"smoothing": [r.numbers() for r in reports]} if reports else {}
            print_json({"files": [str(f) for f in files], **smoothing})
        else:
            if reports:
                from wrsim.results.smoothing import smoothing_table

                print_tables([smoothing_table(reports)])
            print_files(files, as_json)


app.command()(assess)
app.command()(compare)
app.command()(report)
app.command()(diff)
app.command()(export)
app.command()(keys)
app.command()(new)
app.command()(recording)
app.command()(resolve)
app.command()(conicity)
app.command()(ride)
app.command()(study)
app.command()(track)
app.command()(vehicle)
app.command()(view)
app.command()(warm)
app.command()(wear)
