"""Where the cases run: workers of dask.distributed on this machine, at an address, or under SLURM.

Whoever can talk to a scheduler or a worker can let it execute anything, and they to whoever connects: all of them talk
TLS, and each shows a certificate (docs/user/security.md).
"""

import asyncio
import logging
import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

from wrsim.errors import InputError, WrsimError
from wrsim.study.pool import ATTEMPTS, ONE_THREAD, Pool

try:
    import cryptography as cryptography
    import dask
    from distributed import Client, Nanny, Scheduler, SpecCluster, Worker
    from distributed import Future as Future
    from distributed import KilledWorker as KilledWorker
    from distributed import as_completed as as_completed
    from distributed.comm import connect
    from distributed.security import Security
    from distributed.system import MEMORY_LIMIT
except ModuleNotFoundError as error:
    fault = f"studies and other analyses of many runs need {error.name}: install it with pip install 'wrsim[study]'"
    raise InputError(fault) from None

PLAIN_PROCESSES = sys.platform == "win32"
"""Whether workers of this machine are processes of a `Pool`: dask has not been shown to work there."""
QUIET = {"DASK_LOGGING__DISTRIBUTED": "critical"}
"""Silent workers: the study reports what happens to them."""

TRIM = "MALLOC_TRIM_THRESHOLD_"
"""With dask's number a worker returns memory at once and asks for it again: 4 000 page faults a case of 2 s."""
MEMORY = "2GB"
"""Requested of SLURM for a worker where the user's dask-jobqueue configuration sets nothing."""
LOOPBACK = "127.0.0.1"
WAIT = 20
"""Time that a scheduler has to answer [s]."""
CA, CERT, KEY = "ca.pem", "cert.pem", "key.pem"
"""A folder of certificates: of the authority, one's own, its key."""


class _WithoutPages:
    """No web pages, which show a study to everybody; needs ``dashboard=False``."""

    def start_http_server(self, *arguments: Any, **options: Any) -> None:
        """Nothing listens."""


class QuietScheduler(_WithoutPages, Scheduler):
    """A scheduler without web pages."""


class QuietWorker(_WithoutPages, Worker):
    """A worker without web pages, which does not look every 10 ms at what it computes."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        with dask.config.set({"distributed.worker.profile.enabled": False}):
            super().__init__(*arguments, **options)


def security_of(folder: Path | None, *roles: str) -> Security | None:
    """The certificates in a folder, for some of the roles client, scheduler, worker.

    Without a folder those of the user's configuration of dask (``distributed.comm.tls``), None where it has none.
    Raises ``InputError`` for files that cannot be used.
    """
    settings: dict[str, Any] = {}
    if folder is not None:
        settings["tls_ca_file"] = str(folder.resolve() / CA)
        for role in roles:
            settings[f"tls_{role}_cert"], settings[f"tls_{role}_key"] = (str(folder.resolve() / n) for n in (CERT, KEY))
    security = Security(require_encryption=True, **settings)
    for role in roles:
        files = security.get_tls_config_for_role(role)
        if not files["ca_file"] or not files["cert"]:
            return None
        try:
            security.get_connection_args(role)
        except (OSError, ValueError) as error:  # SSLError is an OSError
            where = folder or ", ".join(files[part] for part in ("ca_file", "cert", "key") if files[part])
            why = getattr(error, "strerror", None) or error
            raise InputError(f"{where}: {CA}, {CERT} and {KEY} must be PEM files that go together ({why})") from None
    return security


@contextmanager
def _without_script() -> Iterator[None]:
    """Workers do not execute the script that asks for them: multiprocessing would import it in each of them."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """A terminal sends Ctrl-C to all processes: those that are started here, and later by threads that begin here, do
    not take it; they end with their cluster. This process takes it when the block ends."""
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # its start would undo the mask
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def local_workers(count: int) -> Iterator[Client | Pool]:
    """Worker processes on this machine; one that dies is started again.

    They listen on the loopback interface and accept the certificate that is made here, which is in no file; those of a
    pool listen to nothing.
    """
    if PLAIN_PROCESSES:
        with _without_script(), Pool(count) as pool:
            yield pool
        return
    security = Security.temporary()
    common: dict[str, Any] = {"host": LOOPBACK, "protocol": "tls://", "security": security, "dashboard": False}
    options = {"worker_class": QuietWorker, "nthreads": 1, "memory_limit": MEMORY_LIMIT // count}
    options |= {"env": ONE_THREAD | QUIET, "silence_logs": logging.CRITICAL}
    worker = {"cls": Nanny, "options": common | options}
    with _settings(), _without_script(), ExitStack() as stack:
        with _deaf_to_ctrl_c():
            cluster = stack.enter_context(
                SpecCluster(
                    scheduler={"cls": QuietScheduler, "options": common},
                    worker=worker,
                    workers=dict.fromkeys(range(count), worker),
                    security=security,
                    silence_logs=logging.CRITICAL,
                )
            )
        yield stack.enter_context(closing(Client(cluster, set_as_default=False)))


def address_of(scheduler: str) -> str:
    """An address with its protocol, TLS unless it has one. Raises ``InputError`` if that is neither TLS nor TCP."""
    protocol, _, rest = scheduler.rpartition("://")
    if protocol not in ("", "tls", "tcp"):
        raise InputError(f"--scheduler {scheduler}: must begin with tls:// or tcp://")
    return f"{protocol or 'tls'}://{rest}"


def security_at(address: str, certificates: Path | None) -> Security | None:
    """What a scheduler at this address asks for; nothing without TLS. Raises ``InputError`` without certificates."""
    encrypted = address.startswith("tls://")
    security = security_of(certificates, "client") if encrypted else None
    if encrypted and security is None:
        raise InputError(
            f"--scheduler {address}: needs certificates: give --tls DIR, a folder with {CA}, {CERT} and {KEY}, "
            "or set them in the configuration of dask (distributed.comm.tls)"
        )
    return security


@contextmanager
def workers_at(address: str, certificates: Path | None) -> Iterator[Client]:
    """The workers of a scheduler that runs already; address: see `address_of`.

    Raises ``InputError`` when no scheduler answers, or certificates are missing.
    """
    with _settings():
        security = security_at(address, certificates)
        try:
            asyncio.run(_greeted(address, security))
            client = Client(address, timeout=WAIT, set_as_default=False, security=security)
        except (OSError, RuntimeError, TimeoutError, ValueError, MemoryError) as error:
            answer = "what answers is no scheduler" if isinstance(error, MemoryError) else str(error)
            why = answer.split("\n")[0] or type(error).__name__
            raise InputError(
                f"--scheduler {address}: no dask scheduler answers there ({why}); must be an address such as "
                "tls://10.0.0.1:8786, as 'dask scheduler' prints it"
            ) from None
        with closing(client):
            yield client


async def _greeted(address: str, security: Security | None) -> None:
    """Connect once: a client that something else than a scheduler answers does not end for a minute, and what that
    sends is taken as a length in bytes, which may be too large for any memory."""
    arguments = security.get_connection_args("client") if security else {}
    (await connect(address, timeout=WAIT, **arguments)).abort()


@contextmanager
def slurm_workers(count: int, certificates: Path | None, folder: Path) -> Iterator[Client]:
    """SLURM jobs of one worker each; folder: one that all nodes see.

    Raises ``InputError`` where dask-jobqueue or SLURM are missing.
    """
    with _settings(), slurm_security(certificates, folder) as security, slurm_cluster(security) as cluster:
        try:
            cluster.scale(count)
        except (OSError, RuntimeError) as error:
            raise WrsimError(f"--slurm: the jobs could not be submitted: {error}") from None
        with closing(Client(cluster, set_as_default=False)) as client:
            yield client


@contextmanager
def slurm_security(certificates: Path | None, folder: Path) -> Iterator[Security]:
    """Certificates of scheduler, jobs and client.

    Without given ones they are made: in a folder that the jobs see, readable by this user only, gone with the cluster.
    """
    roles = ("client", "scheduler", "worker")
    if named := security_of(certificates, *roles):
        yield named
        return
    made = Security.temporary()
    with TemporaryDirectory(prefix=".tls-", dir=folder) as private:
        for name, text in ((CA, made.tls_ca_file), (CERT, made.tls_client_cert), (KEY, made.tls_client_key)):
            (Path(private) / name).write_text(text, encoding="utf-8")
        yield security_of(Path(private), *roles) or made


def slurm_cluster(security: Security) -> Any:
    """A cluster of SLURM jobs, none submitted yet.

    Queue, account, memory and time come from the user's dask-jobqueue configuration (``~/.config/dask/jobqueue.yaml``).
    """
    before = signal.getsignal(signal.SIGINT)
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError:
        raise InputError("--slurm needs dask-jobqueue: install it with pip install 'wrsim[cluster]'") from None
    finally:  # its import makes Ctrl-C end the process with code 0 and no message
        if signal.getsignal(signal.SIGINT) is not before:
            signal.signal(signal.SIGINT, before)

    def configured(key: str, otherwise: Any) -> Any:
        return dask.config.get(f"jobqueue.slurm.{key}", None) or otherwise

    quiet = ["--no-dashboard", "--worker-class", f"{QuietWorker.__module__}.{QuietWorker.__name__}"]
    return SLURMCluster(
        cores=1,
        processes=1,
        memory=configured("memory", MEMORY),
        security=security,
        worker_extra_args=[*configured("worker-extra-args", []), *quiet],
        job_script_prologue=[
            *configured("job-script-prologue", []),
            *(f"export {name}={value}" for name, value in (ONE_THREAD | QUIET).items()),
            f"export DASK_DISTRIBUTED__NANNY__PRE_SPAWN_ENVIRON=\"{{'{TRIM}': None}}\"",
            "export DASK_TEMPORARY_DIRECTORY=$(mktemp -d)",  # see _settings
            "trap 'rm -rf \"$DASK_TEMPORARY_DIRECTORY\"' EXIT",
        ],
        silence_logs=logging.CRITICAL,
        scheduler_cls=QuietScheduler,
        scheduler_options=configured("scheduler-options", {}) | {"dashboard": False},
    )


@contextmanager
def _settings() -> Iterator[None]:
    """Settings of dask for a study: silent, no limit to how often a healthy worker may be lost, a folder of its own.

    dask looks up modules in its folder of temporary files first; the usual one may belong to another user.
    """
    logger = logging.getLogger("distributed")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with (
            TemporaryDirectory(prefix="wrsim-") as folder,
            dask.config.set({"distributed.scheduler.allowed-failures": ATTEMPTS - 1, "temporary-directory": folder}),
            dask.config.set({"logging.distributed": "critical", f"distributed.nanny.pre-spawn-environ.{TRIM}": None}),
        ):
            yield
    finally:
        logger.setLevel(level)


def check_threads(client: Client | Pool) -> None:
    """Raises ``InputError`` for workers with more than one thread: a case has a processor to itself."""
    if isinstance(client, Pool):
        return
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        if worker["nthreads"] != 1:
            raise InputError(
                f"worker {address} has {worker['nthreads']} threads: start it with 'dask worker --nthreads 1' and as "
                "many workers as processors (--nworkers)"
            )
