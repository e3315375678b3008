"""Which functions of the package each test calls, and how long it takes: a plugin of pytest for campaigns/mutants.py.

    CALLS=FILE PATIENCE=SECONDS pytest -p campaigns.calls TEST ...

writes {test: [passed, processor time in s, functions as "module.py:qualified name"]} to FILE. A test that takes longer
than PATIENCE [s] has not passed; the functions that it called until then are kept. Calls of fixtures count for
all tests of a file that follow. Without the compiler kernels are functions like others, with it they are not seen.
"""

import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

FILE, PATIENCE = Path(os.environ["CALLS"]), float(os.environ["PATIENCE"])
PACKAGE = str(Path("wrsim").resolve())
AGAIN = 1.0  # between signals to a test that goes on [s]
records: dict[str, tuple[bool, float, list[str]]] = {}
calls: set[CodeType] = set()
of_fixtures: dict[Path, set[CodeType]] = {}


def note(frame: FrameType, event: str, argument: object) -> None:
    """Called at each call of a Python function."""
    calls.add(frame.f_code)


def stop(*_: object) -> None:
    """A skip: hypothesis does not look for a smaller example of it."""
    pytest.skip("takes too long")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    calls.clear()
    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE, AGAIN)
    sys.settrace(note)
    try:
        yield
    finally:
        of_fixtures.setdefault(item.path, set()).update(calls)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[Any]:
    before = os.times()
    done = yield
    spent = sum(os.times()[:4]) - sum(before[:4])
    names = {
        f"{Path(code.co_filename).relative_to(Path.cwd())}:{code.co_qualname}"
        for code in calls | of_fixtures.get(item.path, set())
        if code.co_filename.startswith(PACKAGE)
    }
    records[item.nodeid] = (item.nodeid in passed, spent, sorted(names))
    return done


passed: set[str] = set()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "call" and report.passed:
        passed.add(report.nodeid)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    sys.settrace(None)
    yield


def pytest_sessionfinish() -> None:
    FILE.write_text(json.dumps(records), encoding="utf-8")
