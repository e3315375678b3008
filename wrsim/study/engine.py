"""Feeds the workers with cases; everything that lasts lies in the folders of the cases."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

from wrsim.errors import InputError, WrsimError
from wrsim.results.ledger import digest_of
from wrsim.study.cluster import ATTEMPTS, check_threads
from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, DERAILED, FAILED, MARKER, Marker, read_marker, run_case, warm, write_marker

if TYPE_CHECKING:
    from distributed import Client, Future

WINDOW = 2000
"""Cases that the scheduler knows of at once: its memory does not grow with the study."""


def missing(plan: Plan, retry: bool = False) -> list[int]:
    """Cases without a marker, or whose outputs are not those asked for; each name once.

    retry: also those that failed, stopped or ran out of time; their markers are taken away.
    """
    found: dict[str, int] = {}
    for i, case in enumerate(plan.cases):
        if case.name in found:
            continue
        marker = read_marker(plan.folder_of(case))
        if marker is not None and retry and marker.status not in (COMPLETED, DERAILED):
            (plan.folder_of(case) / MARKER).unlink()
            marker = None
        if marker is None or not marker.has_come_to(plan) or marker.outputs != plan.outputs_digest:
            found[case.name] = i
    return list(found.values())


def kinds(plan: Plan, cases: Sequence[int]) -> list[int]:
    """One case of each set of kernels: analysis, contact models and integrator decide which are needed."""
    base = plan.base()
    found: dict[str, int] = {}
    seen: set[str] = set()
    for i in cases:
        texts = str(sorted((k, v) for k, v in plan.cases[i].values.items() if isinstance(v, str | dict | list)))
        if texts in seen:
            continue
        seen.add(texts)
        tables = plan.scenario(plan.cases[i], base).tables
        own = {"analysis": tables["analysis"], "contact": tables.get("contact"), "run": tables.get("run", {})}
        words = str([(name, sorted(map(str, _words(part)))) for name, part in own.items()])
        found.setdefault(words, i)
    return list(found.values())


def _words(part: object) -> Iterator[str]:
    """All texts in a tree of tables."""
    if isinstance(part, dict):
        for value in part.values():
            yield from _words(value)
    elif isinstance(part, str):
        yield part


def warm_remotely(client: Client, plan: Plan, digest: str, cases: Sequence[int]) -> None:
    """Compile on one worker of every host, one after the other: hosts may share their cache."""
    by_host: dict[str, str] = {}
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        by_host.setdefault(worker["host"], address)
    for address in by_host.values():
        future = client.submit(warm, plan.folder, digest, list(cases), workers=[address], pure=False)
        try:
            future.result()
        except Exception as error:
            raise WrsimError(f"worker {address} cannot run wrsim: {type(error).__name__}: {error}") from None


def execute(
    client: Client,
    plan: Plan,
    cases: Sequence[int],
    progress: Callable[[float, float], None] | None = None,
) -> None:
    """Run these cases to their markers.

    progress: called with the fraction of cases done and the seconds left. A case at which several workers died becomes
    an entry. Raises ``InputError`` when the first completed case shows that an output cannot be had, ``WrsimError``
    when a worker cannot work at all.
    """
    from distributed import KilledWorker, as_completed

    check_threads(client)
    digest = digest_of(plan.dumped())
    session = secrets.token_hex(4)
    waiting = iter(cases)
    running: dict[str, int] = {}
    began = time.perf_counter()

    def submitted(index: int) -> Future:
        key = f"{plan.cases[index].name}-{session}"
        running[key] = index
        return client.submit(run_case, plan.folder, digest, index, key=key)

    done = as_completed([submitted(i) for i in islice(waiting, WINDOW)], loop=client.loop)
    checked = False
    for count, future in enumerate(done, 1):
        index = running.pop(future.key)
        error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            _note_killed(plan, index)
        elif error is not None:
            raise WrsimError(f"case {plan.cases[index].label}: {type(error).__name__}: {error}")
        future.release()
        checked = checked or _check_outputs(plan, index)
        for following in islice(waiting, 1):
            done.add(submitted(following))
        if progress is not None:
            fraction = count / len(cases)
            progress(fraction, (time.perf_counter() - began) * (1.0 - fraction) / fraction)


def _note_killed(plan: Plan, index: int) -> None:
    """The entry of a case that no worker survives."""
    case = plan.cases[index]
    folder = plan.folder_of(case)
    if read_marker(folder) is None:
        message = f"{ATTEMPTS} workers died at it one after the other: too little memory, or a crash below Python"
        write_marker(
            folder, Marker(case.name, case.label, FAILED, message, outputs=plan.outputs_digest, ended=time.time())
        )


def _check_outputs(plan: Plan, index: int) -> bool:
    """True once a completed case has shown that all outputs can be had. Raises ``InputError`` when one cannot."""
    marker = read_marker(plan.folder_of(plan.cases[index]))
    if marker is None or marker.status != COMPLETED:
        return False
    if marker.faults:
        raise InputError("\n".join(marker.faults))
    return True
