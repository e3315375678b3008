"""``wrsim run``, ``study``, ``wear``, ``compare``, ``resolve``: what computes results."""

import logging
from pathlib import Path
from typing import Annotated, Any

import typer

import wrsim
from wrsim.api.outcome import Outcome
from wrsim.cli import console, options
from wrsim.cli.errors import reporting_errors


@options.drawing
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
    verbose: options.Verbose = False,
) -> None:
    """Run a scenario; writes dataset, tables, summary and pictures to DIR.

    While it lasts, a run is stored in DIR/result.nc.part, so that one that was cut off goes on with --resume.
    """
    with reporting_errors(as_json):
        if quiet:
            logging.getLogger("wrsim").setLevel(logging.ERROR)
        found = wrsim.run_scenario(
            file, output, values or (), models=models or (), resume=resume, threads=threads, pictures=pictures,
            force=force, bar=console.progress_of(quiet or as_json)["bar"],
            warn=console.silent if quiet else console.print_error,
        )  # fmt: skip
        if as_json:
            console.print_json(found.numbers)
        elif not found.files:
            console.print_error(*found.lines)
        else:
            if not quiet:
                console.print_numbers(False, {}, found.tables)
                console.print_lines(*found.shown_lines)
                console.print_files(len(found.files), found.folder, len(found["removed"]))
            if found.code:
                console.print_error(f"{file}: stopped: {found.found.result.stop_reason}")
            if found.code and not quiet:
                console.print_error(f"what was computed is in {found.folder}; draw it with: wrsim plot {found.folder}")
                if found.found.can_go_on:
                    console.print_error("go on with the same command and --resume")
        if found.code:
            raise typer.Exit(found.code)


@options.drawing
def study(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Study file (TOML).")],
    output: options.Output = None,
    dry_run: options.DryRun = False,
    retry: options.Retry = False,
    models: options.Models = None,
    pictures: options.Pictures = True,
    workers: options.Workers = None,
    scheduler: options.Scheduler = None,
    slurm: options.Slurm = False,
    tls: options.Tls = None,
    force: options.Force = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Run a scenario many times with some keys varied; start it again and only what is missing runs."""
    with reporting_errors(as_json):
        found = wrsim.run_study(
            file, output, workers=workers, scheduler=scheduler, slurm=slurm, tls=tls, retry=retry, dry_run=dry_run,
            models=models or (), pictures=pictures, force=force, warn=console.print_error,
            **console.progress_of(quiet or as_json),
        )  # fmt: skip
        if dry_run:
            console.print_numbers(as_json, found.numbers, found.tables)
        elif as_json:
            console.print_json(found.numbers | {"files": [str(f) for f in found.files]})
        elif not quiet:
            console.print_numbers(False, found.numbers, found.tables)
            console.print_files(len(found.files), found.folder)
        for words in [] if as_json or dry_run else found.found(quiet):
            console.print_error(words)
        if found.code:
            raise typer.Exit(found.code)


@options.writing(takes="force bar notify warn", workers=True)
def type_test(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of a type test (TOML).")],
    output: options.Output = None,
    dry_run: options.DryRun = False,
    retry: options.Retry = False,
    models: options.Models = None,
    **computed: Any,
) -> Outcome:
    """Type test: states of a vehicle through runs and stationary tests, judged clause by clause.

    Start it again and only what is missing runs. The exit code is 4 where a limit is exceeded.
    """
    return wrsim.run_type_test(file, output, dry_run=dry_run, retry=retry, models=models or (), **computed)


@options.drawing
@options.writing(takes="force bar notify warn", workers=True)
def wear(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of a profile evolution (TOML).")],
    output: options.Output = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    **computed: Any,
) -> Outcome:
    """Profile evolution: cases by their shares, a worn profile, again; started again, it goes on."""
    return wrsim.run_wear(file, output, models=models or (), pictures=pictures, **computed)


@options.drawing
@options.writing(reads="file", takes="bar warn")
def compare_command(
    file: options.ScenarioFile,
    contact: Annotated[
        str,
        typer.Option(
            metavar="A,B,...",
            help="Contact models: half-space, kik-piotrowski+polach, kik-piotrowski+strips=80; file: as in FILE.",
        ),
    ],
    output: Annotated[Path | None, options.into(metavar="DIR", help="Default: results/<FILE>_compared.")] = None,
    reference: Annotated[
        str | None, typer.Option(metavar="A", help="Whom the others are measured against; default: the first.")
    ] = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    **computed: Any,
) -> Outcome:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation."""
    output = output or Path("results") / f"{file.stem}_compared"
    return wrsim.compare(file, contact, reference, output, models=models or (), pictures=pictures, **computed)


@options.drawing
@options.writing(takes="force bar")
def resolve_command(
    result: options.ResultFile,
    contact: Annotated[
        str, typer.Option(metavar="NAME", help="Contact model, such as half-space+fastsim.")
    ] = "half-space",
    output: Annotated[Path | None, options.into(metavar="DIR", help="Default: <folder of RESULT>/<NAME>.")] = None,
    at: options.At = None,
    wheelset: options.OneWheelset = None,
    same: Annotated[
        str, typer.Option(metavar="load|pose", help="What every wheel keeps: its vertical force or its height.")
    ] = "load",
    models: options.Models = None,
    pictures: options.Pictures = True,
    **computed: Any,
) -> Outcome:
    """Solve the contacts at the snapshots of a result again, by the exact solver or any other contact model."""
    return wrsim.resolve(
        result, contact, output, at=at or (), wheelset=wheelset, same=same, models=models or (), pictures=pictures,
        **computed,
    )  # fmt: skip
