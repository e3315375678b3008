"""Where the cases run: workers of dask.distributed on this machine, at an address, or under SLURM."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING, Any

from wrsim.errors import InputError, WrsimError

if TYPE_CHECKING:
    from distributed import Client

ONE_THREAD = {name: "1" for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of a worker: it computes one case at a time, on one processor."""
QUIET = {"DASK_LOGGING__DISTRIBUTED": "critical"}
"""What becomes of a worker is told by the study."""

MEMORY = "2GB"
"""Asked of SLURM for a worker where the user's dask-jobqueue configuration says nothing."""


@contextmanager
def local_workers(count: int) -> Iterator[Client]:
    """So many worker processes on this machine; one that dies is started again."""
    from distributed import Client, LocalCluster

    with (
        _settings(),
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",  # any free port: several studies may run
            silence_logs=logging.CRITICAL,
            env=ONE_THREAD | QUIET,
        ) as cluster,
        closing(Client(cluster, set_as_default=False)) as client,
    ):
        yield client


@contextmanager
def workers_at(address: str) -> Iterator[Client]:
    """The workers of a scheduler that runs already. Raises ``InputError`` when nobody answers there."""
    from distributed import Client

    with _settings():
        try:
            client = Client(address, timeout=WAIT, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            why = str(error).split("\n")[0] or type(error).__name__
            raise InputError(
                f"--scheduler {address}: no dask scheduler answers there ({why}); must be an address such as "
                "tcp://10.0.0.1:8786, as 'dask scheduler' prints it"
            ) from None
        with closing(client):
            yield client


@contextmanager
def slurm_workers(count: int) -> Iterator[Client]:
    """So many jobs of one worker each. Raises ``InputError`` where dask-jobqueue or SLURM are missing."""
    from distributed import Client

    with _settings(), slurm_cluster() as cluster:
        try:
            cluster.scale(count)
        except (OSError, RuntimeError) as error:
            raise WrsimError(f"--slurm: the jobs could not be submitted: {error}") from None
        with closing(Client(cluster, set_as_default=False)) as client:
            yield client


def slurm_cluster() -> Any:
    """A cluster of SLURM jobs, none submitted yet.

    Queue, account, memory and time come from the user's dask-jobqueue configuration (``~/.config/dask/jobqueue.yaml``).
    """
    before = signal.getsignal(signal.SIGINT)
    try:
        import dask
        from dask_jobqueue import SLURMCluster
    except ImportError:
        raise InputError("--slurm needs dask-jobqueue: install it with pip install 'wrsim[cluster]'") from None
    finally:  # importing it makes Ctrl-C end the process with 0 and without a word
        if signal.getsignal(signal.SIGINT) is not before:
            signal.signal(signal.SIGINT, before)

    prologue = dask.config.get("jobqueue.slurm.job-script-prologue", None) or []
    return SLURMCluster(
        cores=1,
        processes=1,
        memory=dask.config.get("jobqueue.slurm.memory", None) or MEMORY,
        job_script_prologue=[*prologue, *(f"export {name}={value}" for name, value in (ONE_THREAD | QUIET).items())],
        silence_logs=logging.CRITICAL,
        scheduler_options={"dashboard_address": ":0"},
    )


WAIT = 20
"""Time that a scheduler has to answer [s]."""


@contextmanager
def _settings() -> Iterator[None]:
    """Settings of dask for a study: silent, and no limit to how often a healthy worker may be lost."""
    try:
        import dask
    except ImportError:
        raise InputError("wrsim study needs dask.distributed: install it with pip install distributed") from None
    logger = logging.getLogger("distributed")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with dask.config.set(
            {"distributed.scheduler.allowed-failures": ATTEMPTS - 1, "logging.distributed": "critical"}
        ):
            yield
    finally:
        logger.setLevel(level)


ATTEMPTS = 2
"""How many workers may die at the same case before it is tried alone, and again before it counts as failed."""


def check_threads(client: Client) -> None:
    """Raises ``InputError`` for workers with more than one thread: a case has a processor to itself."""
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        if worker["nthreads"] != 1:
            raise InputError(
                f"worker {address} has {worker['nthreads']} threads: start it with 'dask worker --nthreads 1' and as "
                "many workers as processors (--nworkers)"
            )


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
