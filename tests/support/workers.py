"""`--workers N`: tests are collected once, then N forked processes take file after file.

Imports and collected tests are shared; each worker has its own capture, temporary folder and fixtures of a session."""

import os
import signal
import subprocess
import sys
import traceback
from array import array
from itertools import groupby
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import SimpleNamespace

import pytest

TESTS = Path(__file__).parents[1]
EARLY = pytest.StashKey[subprocess.Popen[bytes]]()


def add_workers(parser: pytest.Parser) -> None:
    """The option --workers."""
    parser.addoption("--workers", type=int, default=0, help="processes that share the files of tests")


def uncompiled(form: str) -> subprocess.Popen[bytes]:
    """A process whose output is what "few" cases of the kernels, or the "full" ones, give without the compiler."""
    command = [sys.executable, "-m", "support.kernels", form]
    return subprocess.Popen(command, cwd=TESTS, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, stdout=subprocess.PIPE)


def begin_early(config: pytest.Config) -> None:
    """One processor collects the whole suite; another one begins with what takes longest."""
    if config.option.workers and config.args == config.getini("testpaths"):
        config.stash[EARLY] = uncompiled("few")


def _work(
    session: pytest.Session, name: str, files: list[list[pytest.Item]], queue: int, connection: Connection
) -> None:
    """Runs the tests of the files whose numbers are taken from the queue; never returns."""
    config = session.config
    config.get_terminal_writer()._file = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    capture = config.pluginmanager.getplugin("capturemanager")
    capture.stop_global_capturing()  # writes into a file that all would share
    capture.start_global_capturing()
    factory = config._tmp_path_factory  # type: ignore[attr-defined]
    factory._basetemp = factory.mktemp(name, numbered=False)
    written = config.hook.pytest_report_to_serializable
    sender = SimpleNamespace(
        pytest_runtest_logreport=lambda report: connection.send(written(config=config, report=report))
    )
    config.pluginmanager.register(sender)
    try:
        while number := os.read(queue, 2):
            items = files[array("H", number)[0]]
            for item, following in zip(items, [*items[1:], session], strict=True):  # a session's fixtures stay
                config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        session._setupstate.teardown_exact(None)
        os._exit(0)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        session._setupstate.teardown_exact(None)
    except BaseException:
        capture.suspend_global_capture()
        traceback.print_exc()
    finally:
        os._exit(1)


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Forks the workers and takes their reports. A test of which none came to its end has failed."""
    config = session.config
    if not config.option.workers or config.option.collectonly or session.testsfailed:
        return None
    files = [list(items) for _, items in groupby(session.items, lambda item: item.path)]
    queue, entrance = os.pipe()
    os.write(entrance, array("H", range(len(files))).tobytes())
    os.close(entrance)
    names, workers = {}, {}
    for name in (f"worker{i}" for i in range(config.option.workers)):
        receiver, sender = Pipe(duplex=False)
        names[receiver] = SimpleNamespace(gateway=SimpleNamespace(id=name), _workerinfocache=name)
        if (pid := os.fork()) == 0:
            for connection in names:
                connection.close()  # a worker's pipe is to break with this process
            _work(session, name, files, queue, sender)
        sender.close()
        workers[receiver] = pid
    open_, unfinished = set(workers), {item.nodeid: item for item in session.items}
    try:
        while open_:
            for receiver in wait(open_):
                try:
                    data = receiver.recv()
                except EOFError:
                    open_.remove(receiver)
                    continue
                report = config.hook.pytest_report_from_serializable(config=config, data=data)
                report.node = names[receiver]
                if report.when == "teardown":
                    del unfinished[report.nodeid]
                config.hook.pytest_runtest_logreport(report=report)
                if session.shouldfail:
                    raise session.Failed(session.shouldfail)
    finally:
        for receiver in open_:
            os.kill(workers[receiver], signal.SIGINT)
        ends = [os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) for pid in workers.values()]
    if any(ends) and not unfinished:
        raise session.Failed(f"the workers ended with {ends}")
    for item in unfinished.values():
        why = f"not run to its end; the workers ended with {ends}"
        report = pytest.TestReport(item.nodeid, item.location, {}, "failed", why, "call")
        config.hook.pytest_runtest_logreport(report=report)
    return True
