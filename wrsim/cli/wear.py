"""``wrsim wear``: wheels that wear in service, step by step, until a mileage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Output, Pictures, Quiet, Scheduler, Slurm, Tls, Workers
from wrsim.cli.showing import print_json, print_tables, say
from wrsim.cli.study import check_crew, crew

if TYPE_CHECKING:
    from wrsim.study.service.steps import Step


def wear(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Service file (TOML).")],
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
    """Wear wheels in service: cases by their shares, a new profile, again; started again, it goes on (docs/wear.md)."""
    with reporting_errors(as_json):
        from wrsim.results.ledger import Keeper, Ledger, keeping
        from wrsim.study.service.history import OUTPUTS, write_history
        from wrsim.study.service.record import report_of, table_of
        from wrsim.study.service.service import read_service
        from wrsim.study.service.steps import steps_of

        check_crew(workers, scheduler, slurm, tls)
        directory = output if output is not None else Path("results") / file.stem
        service, reads = read_service(file, models or ())
        silent = quiet or as_json

        steps: list[Step] = []
        keeper = Keeper(reads, force)
        most = len(service.shares)
        with (
            Ledger(directory).locked(),
            keeping(keeper),
            crew(workers, scheduler, slurm, tls, silent, most) as work,
        ):
            keeper.check_folder(directory, OUTPUTS)
            try:
                for step in steps_of(service, directory, work):
                    steps.append(step)
                    if not silent:
                        say(step.words(service.mileage))
            except KeyboardInterrupt:
                raise KeyboardInterrupt(
                    f"interrupted; what is done is safe in {directory}: start the same command again to go on"
                ) from None
            dataset, files = write_history(service, steps, directory, pictures)
        if as_json:
            print_json(report_of(dataset) | {"directory": str(directory), "files": [str(f) for f in files]})
        elif not quiet:
            print_tables([table_of(dataset)])
            say(f"{len(files)} files in {directory}")
