"""``wrsim study`` and ``wrsim wear``: a scenario run many times, profile evolution, on many workers."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli import console
from wrsim.cli.console import print_error, progress_bar  # fmt: skip
from wrsim.cli.errors import STOPPED, reporting_errors
from wrsim.cli.options import Force, Json, Models, Output, Pictures, Quiet, Scheduler, Slurm, Tls, Workers


def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Study file (TOML).")],
    output: Output = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    slurm: Slurm = False,
    tls: Tls = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="List the cases and the time they will take; run nothing.")
    ] = False,
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed, stopped or ran out of time.")] = False,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a scenario many times with some keys varied; start it again and only what is missing runs."""
    with reporting_errors(as_json):
        from wrsim.study.collect import OUTPUTS, faults_of, markers_of, study_report, study_tables, write_study
        from wrsim.study.engine import check_workers, kept_folder, missing, worker_pool
        from wrsim.study.estimate import estimate
        from wrsim.study.plan import planned

        for warning in check_workers(workers, scheduler, slurm, tls):
            print_error(warning)
        bar = partial(progress_bar, not (quiet or as_json))
        directory = output or Path("results") / file.stem
        plan, reads = planned(file, directory, models or ())
        if dry_run:
            expected = estimate(plan, workers)
            console.print_numbers(as_json, expected.numbers(), [expected.table()])
            return
        with kept_folder(directory, reads, force, OUTPUTS):
            todo = missing(plan, retry)
            if not (quiet or as_json):
                known = len(plan.cases) - len(todo)
                console.print_lines(f"{len(plan.cases)} cases" + (f", {known} of them known already" if known else ""))
            try:
                if todo:
                    with worker_pool(workers, scheduler, slurm, tls, len(todo), bar) as work:
                        work(plan, todo)
            except KeyboardInterrupt:
                write_study(plan, markers_of(plan), pictures=False)
                raise interrupted(directory) from None
            markers = markers_of(plan)
            files = write_study(plan, markers, pictures)
        report = study_report(plan, markers)
        code = STOPPED if report["unfinished"] else 0
        if as_json:
            console.print_json(report | {"exit_code": code, "ran": len(todo), "files": [str(f) for f in files]})
        elif not quiet:
            console.print_numbers(False, report, study_tables(report))
            console.print_files(len(files), directory)
        for words in [] if as_json else faults_of(report, markers, quiet):
            print_error(words)
        if code:
            raise typer.Exit(code)


def interrupted(directory: Path) -> KeyboardInterrupt:
    """With where the finished part is."""
    return KeyboardInterrupt(f"interrupted; what is done is safe in {directory}: start the same command again to go on")


def wear(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of a profile evolution (TOML).")],
    output: Output = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    slurm: Slurm = False,
    tls: Tls = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Profile evolution: cases by their shares, a worn profile, again; started again, it goes on (docs/wear.md)."""
    with reporting_errors(as_json):
        from wrsim.study.engine import check_workers, kept_folder, worker_pool
        from wrsim.study.evolution.history import OUTPUTS, evolution_report, mileage_table, write_history
        from wrsim.study.evolution.reading import read_evolution
        from wrsim.study.evolution.steps import Step, wear_steps

        for warning in check_workers(workers, scheduler, slurm, tls):
            print_error(warning)
        directory = output or Path("results") / file.stem
        evolution, reads = read_evolution(file, models or ())
        steps: list[Step] = []
        bar = partial(progress_bar, not (quiet or as_json))
        with (
            kept_folder(directory, reads, force, OUTPUTS),
            worker_pool(workers, scheduler, slurm, tls, len(evolution.shares), bar) as work,
        ):
            try:
                for step in wear_steps(evolution, directory, work):
                    steps.append(step)
                    if not (quiet or as_json):
                        console.print_lines(step.words(evolution.mileage))
            except KeyboardInterrupt:
                raise interrupted(directory) from None
            dataset, files = write_history(evolution, steps, directory, pictures)
        if as_json or not quiet:
            numbers = evolution_report(dataset) | {"directory": str(directory)}
            console.print_found(as_json, numbers, [mileage_table(dataset)], files, directory)
