"""``wrsim run``, ``study``, ``wear``, ``compare``, ``resolve``: what computes results."""

from __future__ import annotations

import logging
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from wrsim.cli import console, options
from wrsim.cli.errors import exit_code, reporting_errors, writing_files


def run_command(
    file: options.ScenarioFile,
    output: options.Output = None,
    values: options.Set = None,
    models: options.Models = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the run in DIR that was cut off or interrupted.")
    ] = False,
    threads: Annotated[
        int | None,
        typer.Option(
            "--threads",
            min=1,
            help="Cores that compute the wheels' contacts side by side; all for trains of three vehicles and more.",
            show_default="1",
        ),
    ] = None,
    pictures: Annotated[bool, typer.Option(help="Draw the standard pictures.")] = True,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
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
                console.print_error(words)
        directory = output or Path("results") / file.stem
        written = run_into(
            directory, scenario, setup, file, resume=resume, threads=threads, pictures=pictures, force=force,
            progress=console.progress_bar(not (quiet or as_json)),
        )  # fmt: skip
        result, code = written.result, exit_code(written.result)
        if as_json:
            own = {"status": result.status, "exit_code": code, "directory": str(directory)}
            lists = {"files": [str(f) for f in written.files], "removed": [str(f) for f in written.removed]}
            console.print_json(own | lists | {"summary": {**result.summary(), **written.took}})
        elif not written.files:
            console.print_error(written.words)
        else:
            if not quiet:
                console.print_numbers(False, {}, result.numbers())
                console.print_lines(*filter(None, [written.words]))
                console.print_files(len(written.files), directory, len(written.removed))
            if code:
                console.print_error(f"{file}: stopped: {result.stop_reason}")
            if code and not quiet:
                console.print_error(f"what was computed is in {directory}; draw it with: wrsim plot {directory}")
                if can_go_on(result):
                    console.print_error("go on with the same command and --resume")
        if code:
            raise typer.Exit(code)


def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Study file (TOML).")],
    output: options.Output = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    slurm: options.Slurm = False,
    tls: options.Tls = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="List the cases and the time they will take; run nothing.")
    ] = False,
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed, stopped or ran out of time.")] = False,
    models: options.Models = None,
    pictures: options.Pictures = True,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Run a scenario many times with some keys varied; start it again and only what is missing runs."""
    with reporting_errors(as_json):
        from wrsim.api import run_study

        directory = output or Path("results") / file.stem
        found = run_study(
            file, directory, workers=workers, scheduler=scheduler, slurm=slurm, tls=tls, retry=retry, dry_run=dry_run,
            models=models or (), pictures=pictures, force=force, **_progress(quiet or as_json),
        )  # fmt: skip
        if dry_run:
            console.print_numbers(as_json, found.numbers, found.tables)
        elif as_json:
            console.print_json(found.numbers | {"files": [str(f) for f in found.files]})
        elif not quiet:
            console.print_numbers(False, found.numbers, found.tables)
            console.print_files(len(found.files), directory)
        for words in [] if as_json or dry_run else found.found(quiet):
            console.print_error(words)
        if found.code:
            raise typer.Exit(found.code)


def _progress(mute: bool) -> dict[str, Any]:
    """A bar and words on the progress of a study, unless mute; warnings."""
    say = (lambda words: None) if mute else console.print_lines
    return {"bar": partial(console.progress_bar, not mute), "say": say, "warn": console.print_error}


def wear(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of a profile evolution (TOML).")],
    output: options.Output = None,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    slurm: options.Slurm = False,
    tls: options.Tls = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Profile evolution: cases by their shares, a worn profile, again; started again, it goes on."""
    with reporting_errors(as_json):
        from wrsim.api import run_wear

        directory = output or Path("results") / file.stem
        found = run_wear(
            file, directory, workers=workers, scheduler=scheduler, slurm=slurm, tls=tls, models=models or (),
            pictures=pictures, force=force, **_progress(quiet or as_json),
        )  # fmt: skip
        if as_json or not quiet:
            console.print_found(as_json, found.numbers, found.tables, found.files, directory)


def compare_command(
    file: options.ScenarioFile,
    contact: Annotated[
        str,
        typer.Option(
            metavar="A,B,...",
            help="Contact models: half-space, kik-piotrowski+polach, kik-piotrowski+strips=80; file: as in FILE.",
        ),
    ],
    reference: Annotated[
        str | None, typer.Option(metavar="A", help="Whom the others are measured against; default: the first.")
    ] = None,
    output: Annotated[Path | None, options.into(metavar="DIR", help="Default: results/<FILE>_compared.")] = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation."""
    with writing_files(as_json, force, file):
        from wrsim.analysis import exact_run_warning
        from wrsim.analysis.compare import compare, comparison_report, comparison_tables
        from wrsim.report.outputs import write_comparison
        from wrsim.scenario.build import build
        from wrsim.scenario.contact_choice import split_names, with_contact_model
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        names = split_names(contact)
        for words in [w for name in names for w in exact_run_warning(build(with_contact_model(scenario, name)))]:
            if not quiet:
                console.print_error(words)
        with console.progress_bar(not (quiet or as_json)) as progress:
            found = compare(scenario, names, reference, progress)
        directory = output or Path("results") / f"{file.stem}_compared"
        report = comparison_report(found, str(file))
        files = write_comparison(found, report, directory, pictures, scenario.title)
        if as_json or not quiet:
            console.print_found(as_json, report, comparison_tables(found, report), files, directory)
        if code := max(exit_code(m.result) for m in found.models):
            raise typer.Exit(code)


def resolve_command(
    result: options.ResultFile,
    contact: Annotated[
        str, typer.Option(metavar="NAME", help="Contact model, such as half-space+fastsim.")
    ] = "half-space",
    at: options.At = None,
    wheelset: options.OneWheelset = None,
    same: Annotated[
        str, typer.Option(metavar="load|pose", help="What every wheel keeps: its vertical force or its height.")
    ] = "load",
    output: Annotated[Path | None, options.into(metavar="DIR", help="Default: <folder of RESULT>/<NAME>.")] = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve the contacts at the snapshots of a result again, by the exact solver or any other contact model."""
    with reporting_errors(as_json):
        from wrsim.analysis.resolve import resolve
        from wrsim.report.output_folder import RECORD, claimed, folder_of_result, naming, read, write
        from wrsim.report.outputs import file_name
        from wrsim.results import write_atomically
        from wrsim.results.moments import moments_at, resolved_table
        from wrsim.results.summary_tables import first_lines, remarks
        from wrsim.scenario.loading import load_text

        before = read(result)
        folder = folder_of_result(result)
        with naming(result), console.progress_bar(not (quiet or as_json)) as progress:
            moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
            scenario = load_text(before.dataset.attrs["scenario_text"], folder, models or (), closed=True)
            after = resolve(before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress)
        directory = output or folder / file_name(contact)
        with claimed(directory, force, (result,)) as keeper:
            write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
            files = write(after, directory, pictures)
            keeper.clear(files)
        if as_json or not quiet:
            notes = first_lines(remarks(after.summary()), "remarks")
            tables = [resolved_table(before.wheelset(wheelset), after.wheelset(), notes)]
            numbers = {"directory": str(directory), "summary": after.summary()}
            console.print_found(as_json, numbers, tables, files, directory)
