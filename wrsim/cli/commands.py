"""The commands: check, run, plot, profile.

They import what they need when they run, so that ``wrsim --help`` answers at once.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from wrsim import __version__
from wrsim.cli.ending import INTERRUPTED, exit_code, told
from wrsim.cli.showing import complain, facts, print_facts, print_files, print_json, print_summary, progress_bar
from wrsim.cli.storing import claim, patch_pictures, write
from wrsim.errors import InputError

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
    with told(as_json):
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        found = facts(build(scenario))
        if as_json:
            print_json({"status": "valid", "scenario": str(file), **found})
        else:
            print(f"{file}: valid")
            print_facts(found)


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
    with told(as_json):
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        build(scenario)  # what cannot run leaves nothing behind
        directory = output if output is not None else Path("results") / file.stem
        claim(directory, scenario)
        from wrsim.analysis import run as analyse

        with progress_bar(not (quiet or as_json)) as progress:
            result = analyse(scenario, progress=progress)
        files = write(result, directory, pictures)
        code = exit_code(result)
        if as_json:
            print_json(
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
                print_summary(result, directory, files)
            if code:
                complain(f"{file}: stopped: {result.stop_reason}")
                if not quiet:
                    complain(f"what was computed is in {directory}; draw it with: wrsim plot {directory}")
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
    """Draw the pictures of a result; with --at the contact patches at chosen places only."""
    with told(as_json):
        from wrsim.results import Result

        loaded = Result.load(result)
        directory = output or (result if result.is_dir() else result.parent)
        if at:
            files = patch_pictures(loaded, at, directory)
        else:
            from wrsim.plots import standard_pictures

            files = standard_pictures(loaded.dataset, directory)
        print_files(files, as_json)


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
    with told(as_json):
        if kind not in (None, "wheel", "rail"):
            raise InputError(f"--kind {kind}: must be wheel or rail")
        from wrsim.geometry.profile_models import load_profile
        from wrsim.plots.profile import profile_picture

        loaded = load_profile(file, kind)  # type: ignore[arg-type]
        picture = output or Path(file.stem + ".png")
        if picture.suffix.lower() != ".png":
            raise InputError(f"-o {picture}: must end in .png")
        print_files([profile_picture(loaded, picture)], as_json)
