"""Workers for a study, and the cases that they are given; all that lasts is in the folders of the cases."""

import logging
import secrets
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from itertools import islice
from pathlib import Path

from wrsim.analysis.progress import Progress, Report
from wrsim.errors import InputError, WrsimError
from wrsim.inputs.toml_files import texts_in
from wrsim.results import write_atomically
from wrsim.results.files import Keeper, Manifest, digest_of, keeping
from wrsim.study import cluster, task
from wrsim.study.cluster import Client, Future, KilledWorker, address_of, as_completed, check_threads
from wrsim.study.plan import PLAN, Plan
from wrsim.study.pool import ATTEMPTS, Call, Completed, Pool, WorkerDied
from wrsim.study.task import Work
from wrsim.system import processors

LOGGER = logging.getLogger("wrsim.study")
Bar = Callable[[], AbstractContextManager[Progress | None]]
"""Makes a progress bar, or none."""
PAUSE = 1.0
"""Between two questions to the scheduler how many workers there are [s]."""
AT_HAND = 2
"""Cases that a worker has: the one it runs, and the next."""


def kinds(plan: Plan, cases: Sequence[int]) -> list[int]:
    """One case of each set of kernels: analysis, contact models and integrator decide which are needed."""
    chosen: dict[str, int] = {}
    seen: set[str] = set()
    for i in cases:
        texts = str(sorted((k, v) for k, v in plan.cases[i].values.items() if isinstance(v, str | dict | list)))
        if texts in seen:
            continue
        seen.add(texts)
        tables = plan.scenario(plan.cases[i]).merged.data
        parts = {"analysis": tables["analysis"], "contact": tables.get("contact"), "run": tables.get("run", {})}
        signature = str([(name, sorted(texts_in(part))) for name, part in parts.items()])
        chosen.setdefault(signature, i)
    return list(chosen.values())


def warm_remotely(client: Client, plan: Plan, digest: str, cases: Sequence[int]) -> None:
    """Compile on one worker of every host, one after the other: hosts may share their cache."""
    by_host: dict[str, str] = {}
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        by_host.setdefault(worker["host"], address)
    for address in by_host.values():
        future = client.submit(task.warm_cases, plan.folder, digest, list(cases), workers=[address], pure=False)
        try:
            future.result()
        except Exception as error:
            raise WrsimError(f"worker {address} cannot run wrsim: {type(error).__name__}: {error}") from None


def execute(
    client: Client | Pool,
    plan: Plan,
    cases: Sequence[int],
    progress: Progress | None = None,
    expected: int = 1,
) -> None:
    """Run these cases to their markers.

    expected: workers that will come. A case at which several workers died becomes an entry. Raises ``InputError`` when
    the first completed case shows that an output cannot be had, ``WrsimError`` when a worker cannot work at all.
    """
    check_threads(client)
    report = Report(progress)
    suspects: list[int] = []
    checked, count = False, 0
    for index, died in _handed_out(client, plan, cases, expected):
        if died:  # or another case on the same worker: looked at again when nothing else runs
            suspects.append(index)
            continue
        marker = None if checked else task.read_marker(plan.folder_of(plan.cases[index]))
        if marker is not None and marker.status == task.COMPLETED:  # it shows whether all outputs can be had
            checked = True
            if marker.faults:
                raise InputError("\n".join(marker.faults))
        count += 1
        report(count / len(cases))
    for suspect in suspects:
        for index, died in _handed_out(client, plan, [suspect], 1):
            if died:
                _note_killed(plan, index)


def _handed_out(client: Client | Pool, plan: Plan, cases: Sequence[int], expected: int) -> Iterator[tuple[int, bool]]:
    """Cases in the order in which they come to an end, and whether their workers died.

    A worker has one case and the next one at hand: the scheduler's memory does not grow with the study.
    """
    digest, session = digest_of(plan.dumped()), secrets.token_hex(4)
    waiting = iter(cases)
    running: dict[str, int] = {}
    asked, workers = float("-inf"), 0

    def submitted(index: int) -> Future | Call:
        key = f"{plan.cases[index].name}-{session}"
        running[key] = index
        return client.submit(task.run_case, plan.folder, digest, index, key=key)

    def room() -> int:
        nonlocal asked, workers
        if (now := time.monotonic()) - asked > PAUSE:  # the scheduler has more to do than to count
            asked, workers = now, sum(client.nthreads().values())
        return AT_HAND * max(expected, workers) - len(running)

    begun = [submitted(i) for i in islice(waiting, room())]
    done = Completed(client, len(begun)) if isinstance(client, Pool) else as_completed(begun, loop=client.loop)
    for future in done:
        index = running.pop(future.key)
        error = future.exception() if future.status == "error" else None
        if error is not None and not isinstance(error, KilledWorker | WorkerDied):
            reason = f"{'' if isinstance(error, WrsimError) else f'{type(error).__name__}: '}{error}"
            kept = "cases that are done are kept: start the same command again to go on"
            raise WrsimError(f"case {plan.cases[index].label}: {reason}; {kept}")
        future.release()
        for following in islice(waiting, max(room(), 0)):
            done.add(submitted(following))
        yield index, error is not None


def _note_killed(plan: Plan, index: int) -> None:
    """The entry of a case that no worker survives."""
    case = plan.cases[index]
    folder = plan.folder_of(case)
    marker = task.read_marker(folder)
    if marker is None or marker.outputs != plan.outputs_digest:
        hook = f", or {plan.hook} ends the process" if plan.hook else ""
        deaths = f"{2 * ATTEMPTS} workers died at it one after the other"
        message = f"{deaths}: too little memory, a crash below Python{hook}"
        marker = task.Marker(
            case.name, case.label, task.FAILED, message, outputs=plan.outputs_digest, ended=time.time()
        )
        task.write_marker(folder, marker)


def check_workers(workers: int | None, scheduler: str | None, slurm: bool, tls: Path | None) -> list[str]:
    """A warning of a scheduler that listens to everybody. Raises ``InputError`` for options that do not go together and
    where certificates are missing."""
    if scheduler is not None and (slurm or workers is not None):
        raise InputError("--scheduler: its workers are there already: leave out --workers and --slurm")
    open_to_all = scheduler is not None and address_of(scheduler).startswith("tcp://")
    if tls is not None and (open_to_all or not (scheduler or slurm)):
        raise InputError(f"--tls {tls}: is for --slurm and --scheduler tls://...")
    if scheduler is not None:
        cluster.security_at(address_of(scheduler), tls)
    warning = (
        f"warning: --scheduler {scheduler} is neither encrypted nor authenticated: whoever reaches it can execute "
        "programs as you; start it with certificates and take tls:// (docs/user/security.md)"
    )
    return [warning] if open_to_all else []


@contextmanager
def kept_folder(directory: Path, reads: Sequence[Path], force: bool, outputs: Sequence[str]) -> Iterator[None]:
    """The folder of a study or a profile evolution, for one process alone; no file of the user is overwritten."""
    keeper = Keeper(tuple(reads), force)
    with Manifest(directory).locked(), keeping(keeper):
        keeper.check_folder(directory, outputs)
        yield


@contextmanager
def worker_pool(
    count: int | None, scheduler: str | None, slurm: bool, tls: Path | None, most: int, progress: Bar
) -> Iterator[Work]:
    """A function that lets workers run cases of a plan; they start with its first call and stay until the end.

    count: of processes or jobs, None: the usual; most: cases that there may be at once; progress: a bar.
    """
    expected = count or (1 if slurm else processors())
    client: Client | Pool | None = None

    def started(plan: Plan, first: Sequence[int]) -> Client | Pool:
        if scheduler is None and not slurm:
            for i in first:  # compile once
                task.compile_for(plan.scenario(plan.cases[i]))
            return stack.enter_context(cluster.local_workers(min(expected, most)))
        if scheduler is not None:
            pool = stack.enter_context(cluster.workers_at(address_of(scheduler), tls))
        else:
            pool = stack.enter_context(cluster.slurm_workers(expected, tls, Path(plan.folder)))
            LOGGER.warning("waiting for the first job of SLURM")
        pool.wait_for_workers(1)
        warm_remotely(pool, plan, digest_of(plan.dumped()), first)
        return pool

    def work(plan: Plan, todo: Sequence[int]) -> None:
        nonlocal client
        write_atomically(Path(plan.folder) / PLAN, plan.dumped())
        client = client or started(plan, kinds(plan, todo))
        with progress() as advance:
            execute(client, plan, todo, advance, 1 if scheduler is not None else expected)

    with ExitStack() as stack:
        yield work
