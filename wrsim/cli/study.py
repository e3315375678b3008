"""``wrsim study``: one scenario run many times with some keys varied, on as many workers as there are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import STOPPED, reporting_errors
from wrsim.cli.options import Force, Json, Models, Output, Pictures, Quiet, Scheduler, Slurm, Tls, Workers
from wrsim.cli.showing import complain, print_json, print_tables, progress_bar, say, say_files
from wrsim.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

    from wrsim.study.plan import Plan
    from wrsim.study.task import Marker

LISTED = 40
"""Cases that are listed on the screen."""
OUTPUTS = ("study.nc", "study.csv", "times.csv", "study.json", "plan.json")


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
        check_crew(workers, scheduler, slurm, tls)
        from wrsim.results.ledger import Keeper, Ledger, keeping
        from wrsim.study.collect import markers_of, report_of, tables_of, write_study
        from wrsim.study.engine import missing
        from wrsim.study.plan import planned

        directory = output if output is not None else Path("results") / file.stem
        plan, reads = planned(file, directory, models or ())
        if dry_run:
            _foretell(plan, workers, as_json)
            return
        keeper = Keeper(reads, force)
        with Ledger(directory).locked(), keeping(keeper):
            keeper.check_folder(directory, OUTPUTS)
            todo = missing(plan, retry)
            if not quiet and not as_json:
                kept = len(plan.cases) - len(todo)
                say(f"{len(plan.cases)} cases" + (f", {kept} of them known already" if kept else ""))
            try:
                if todo:
                    with crew(workers, scheduler, slurm, tls, quiet or as_json, len(todo)) as work:
                        work(plan, todo)
            except KeyboardInterrupt:
                write_study(plan, markers_of(plan), pictures=False)
                raise KeyboardInterrupt(
                    f"interrupted; what is done is safe in {directory}: start the study again to go on"
                ) from None
            markers = markers_of(plan)
            files = write_study(plan, markers, pictures)
        report = report_of(plan, markers)
        failed = len(report["unfinished"])
        if as_json:
            print_json(
                report | {"exit_code": STOPPED if failed else 0, "ran": len(todo), "files": [str(f) for f in files]}
            )
        else:
            if not quiet:
                print_tables(tables_of(report))
                _say_other_code(markers)
                say_files(len(files), directory)
            lacking = [m for m in markers if m is not None and m.faults]
            if lacking:
                complain(f"{len(lacking)} cases lack outputs, study.csv says which: {lacking[0].faults[0]}")
            if failed:
                complain(f"{failed} of {len(plan.cases)} cases have no result; --retry runs them again")
        if failed:
            raise typer.Exit(STOPPED)


def check_crew(workers: int | None, scheduler: str | None, slurm: bool, tls: Path | None) -> None:
    """Raises ``InputError`` for options that do not go together; warns of a scheduler that listens to everybody."""
    from wrsim.study.cluster import address_of

    if scheduler is not None and (slurm or workers is not None):
        raise InputError("--scheduler: its workers are there already: leave out --workers and --slurm")
    open_to_all = scheduler is not None and address_of(scheduler).startswith("tcp://")
    if tls is not None and (open_to_all or not (scheduler or slurm)):
        raise InputError(f"--tls {tls}: is for --slurm and --scheduler tls://...")
    if open_to_all:
        complain(
            f"warning: --scheduler {scheduler} is neither encrypted nor authenticated: whoever reaches it can execute "
            "programs as you; start it with certificates and take tls:// (docs/security.md)"
        )


@contextmanager
def crew(
    count: int | None, scheduler: str | None, slurm: bool, tls: Path | None, quiet: bool, most: int
) -> Iterator[Callable[[Plan, Sequence[int]], None]]:
    """A function that lets workers do cases of a plan; they come when it is called first, and stay until the end.

    count: of processes or jobs, None: the usual; most: cases that there may be at once.
    """
    from wrsim.results import write_atomically
    from wrsim.results.ledger import digest_of
    from wrsim.study import cluster
    from wrsim.study.engine import execute, kinds, warm_remotely
    from wrsim.study.plan import PLAN
    from wrsim.study.task import compile_for

    hands = count or (1 if slurm else cluster.processors())
    local = scheduler is None and not slurm
    client: Client | None = None

    def opened(plan: Plan, first: Sequence[int]) -> Client:
        if scheduler is not None:
            return stack.enter_context(cluster.workers_at(cluster.address_of(scheduler), tls))
        if slurm:
            return stack.enter_context(cluster.slurm_workers(hands, tls, Path(plan.folder)))
        for i in first:  # compile once
            compile_for(plan.scenario(plan.cases[i]))
        return stack.enter_context(cluster.local_workers(min(hands, most)))

    def work(plan: Plan, todo: Sequence[int]) -> None:
        nonlocal client
        content = plan.dumped()
        write_atomically(Path(plan.folder) / PLAN, content)
        here = client
        if here is None:
            first = kinds(plan, todo)
            client = here = opened(plan, first)
            if not local:
                if slurm and not quiet:
                    say("waiting for the first job of SLURM")
                here.wait_for_workers(1)
                warm_remotely(here, plan, digest_of(content), first)
        with progress_bar(not quiet) as progress:
            execute(here, plan, todo, progress, 1 if scheduler is not None else hands)

    with ExitStack() as stack:
        yield work


def _foretell(plan: Plan, count: int | None, as_json: bool) -> None:
    """The cases, which are known already, and how long the rest will take."""
    from wrsim.results.table import Column, Table, duration
    from wrsim.study.cluster import processors
    from wrsim.study.collect import MISSING, markers_of
    from wrsim.study.engine import missing
    from wrsim.study.foretell import time_of_cases

    markers, todo = markers_of(plan), missing(plan)
    each, how = time_of_cases(plan, todo, markers)
    count = count or processors()
    total = each * len(todo) / min(count, max(len(todo), 1))
    states = [MISSING if m is None else m.status for m in markers]
    if as_json:
        cases = [
            {"case": c.name, "label": c.label, "values": c.values, "status": s}
            for c, s in zip(plan.cases, states, strict=True)
        ]
        expected = {"of_one_case_s": each, "on_workers": count, "of_all_s": total}
        print_json({"cases": cases, "missing": len(todo), "time": expected})
        return
    rows = [(c.name, c.label, s) for c, s in zip(plan.cases[:LISTED], states, strict=False)]
    more = [f"... and {len(plan.cases) - LISTED} more; --json lists all"] if len(plan.cases) > LISTED else []
    notes = [*more, f"{len(plan.cases)} cases, {len(todo)} to run"]
    if todo:
        notes.append(f"one case takes {duration(each)} ({how}); on {count} workers the study takes {duration(total)}")
    print_tables([Table(plan.title, (Column("case"), Column("values"), Column("state")), rows, tuple(notes))])


def _say_other_code(markers: Sequence[Marker | None]) -> None:
    """Say so when results come from different states of wrsim."""
    from wrsim.analysis.motion.record import code_digest

    others = sum(m is not None and m.code not in ("", code_digest()) for m in markers)
    if others:
        complain(
            f"{others} cases were computed by another state of wrsim's code; delete their folders to run them again"
        )
