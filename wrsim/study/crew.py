"""The crew of a study: workers here, at an address, or under SLURM, which come when the first case is to be done."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

from distributed import Client

from wrsim.errors import InputError
from wrsim.results import write_atomically
from wrsim.results.manifest import Keeper, Manifest, digest_of, keeping
from wrsim.study import cluster
from wrsim.study.cluster import address_of
from wrsim.study.engine import execute, kinds, warm_remotely
from wrsim.study.plan import PLAN, Plan
from wrsim.study.task import compile_for

LOGGER = logging.getLogger("wrsim.study")
Bar = Callable[[], AbstractContextManager[Callable[[float, float], None] | None]]
"""Makes a progress bar, or none."""


def check_crew(workers: int | None, scheduler: str | None, slurm: bool, tls: Path | None) -> list[str]:
    """A warning of a scheduler that listens to everybody. Raises ``InputError`` for options that do not go together."""
    if scheduler is not None and (slurm or workers is not None):
        raise InputError("--scheduler: its workers are there already: leave out --workers and --slurm")
    open_to_all = scheduler is not None and address_of(scheduler).startswith("tcp://")
    if tls is not None and (open_to_all or not (scheduler or slurm)):
        raise InputError(f"--tls {tls}: is for --slurm and --scheduler tls://...")
    warning = (
        f"warning: --scheduler {scheduler} is neither encrypted nor authenticated: whoever reaches it can execute "
        "programs as you; start it with certificates and take tls:// (docs/security.md)"
    )
    return [warning] if open_to_all else []


@contextmanager
def kept_folder(directory: Path, reads: Sequence[Path], force: bool, outputs: Sequence[str]) -> Iterator[None]:
    """The folder of a study or service, for one process alone; nothing of the user's in it is written over."""
    keeper = Keeper(tuple(reads), force)
    with Manifest(directory).locked(), keeping(keeper):
        keeper.check_folder(directory, outputs)
        yield


@contextmanager
def crew(
    count: int | None, scheduler: str | None, slurm: bool, tls: Path | None, most: int, progress: Bar
) -> Iterator[Callable[[Plan, Sequence[int]], None]]:
    """A function that lets workers do cases of a plan; they come when it is called first, and stay until the end.

    count: of processes or jobs, None: the usual; most: cases that there may be at once; progress: a bar.
    """
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
                if slurm:
                    LOGGER.warning("waiting for the first job of SLURM")
                here.wait_for_workers(1)
                warm_remotely(here, plan, digest_of(content), first)
        with progress() as advance:
            execute(here, plan, todo, advance, 1 if scheduler is not None else hands)

    with ExitStack() as stack:
        yield work
