"""``wrsim check``, ``run``, ``show``, ``warm``: a scenario checked, run, its result shown; kernels compiled ahead."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_error, print_files, print_json, print_lines, print_numbers, progress_bar
from wrsim.cli.errors import exit_code, reporting_errors
from wrsim.cli.options import Force, Json, Models, Output, Quiet, ResultFile, ScenarioFile, Set


def check_command(file: ScenarioFile, values: Set = None, models: Models = None, as_json: Json = False) -> None:
    """Check a scenario and all the files it names, without running it."""
    with reporting_errors(as_json):
        from wrsim.analysis import check_step
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load
        from wrsim.scenario.plausibility import facts, facts_table, warnings

        scenario = load(file, models or ()).with_set(values or ())
        setup = build(scenario)
        if getattr(setup.plan, "limited", False):
            check_step(scenario, setup)
        found, warned = facts(setup), warnings(setup)
        numbers = {"status": "valid", "scenario": str(file), "warnings": warned, **found}
        print_numbers(as_json, numbers, [facts_table(f"{file}: valid", found)])
        for words in [] if as_json else warned:
            print_error(f"{file}: warning: {words}")


def run_command(
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
    """Run a scenario; writes dataset, tables, summary and pictures to DIR.

    While it lasts, a run is kept in DIR/result.nc.part, so that one that was cut off goes on with --resume.
    """
    with reporting_errors(as_json):
        from wrsim.analysis import exact_run_warning
        from wrsim.report.output_folder import can_go_on, run_into
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load
        from wrsim.scenario.plausibility import warnings

        scenario = load(file, models or ()).with_set(values or ())
        setup = build(scenario)  # what cannot run leaves nothing behind
        if quiet:
            logging.getLogger("wrsim").setLevel(logging.ERROR)
        else:
            for words in (*(f"{file}: warning: {w}" for w in warnings(setup)), *exact_run_warning(setup)):
                print_error(words)
        directory = output or Path("results") / file.stem
        written = run_into(
            directory, scenario, setup, file, resume=resume, threads=threads, pictures=pictures, force=force,
            progress=progress_bar(not (quiet or as_json)),
        )  # fmt: skip
        result, code = written.result, exit_code(written.result)
        if as_json:
            own = {"status": result.status, "exit_code": code, "directory": str(directory)}
            lists = {"files": [str(f) for f in written.files], "removed": [str(f) for f in written.removed]}
            print_json(own | lists | {"summary": {**result.summary(), **written.took}})
        elif not written.files:
            print_error(written.note)
        else:
            if not quiet:
                print_numbers(False, {}, result.numbers())
                print_lines(*written.wall_words())
                print_files(len(written.files), directory, len(written.removed))
            if code:
                print_error(f"{file}: stopped: {result.stop_reason}")
            if code and not quiet:
                print_error(f"what was computed is in {directory}; draw it with: wrsim plot {directory}")
                if can_go_on(result):
                    print_error("go on with the same command and --resume")
        if code:
            raise typer.Exit(code)


def show(result: ResultFile, as_json: Json = False) -> None:
    """Print the summary of a result, or of what there is of a run."""
    with reporting_errors(as_json):
        from wrsim.report.output_folder import read

        loaded = read(result)
        print_numbers(as_json, loaded.summary(), loaded.numbers())
        if loaded.stop_reason and not as_json:
            print_lines(f"stopped: {loaded.stop_reason}")


def warm_command(quiet: Quiet = False) -> None:
    """Compile ahead what runs and poses need, so that the first of them starts at once."""
    with reporting_errors(False):
        from wrsim.analysis.warming import warm_up

        words = warm_up()
        if not quiet:
            print_lines(words)
