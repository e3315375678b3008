"""Two processes draw what one draws, whatever happens to the second."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from support.waiting import wait_until

from wrsim import system
from wrsim.plots import drawing
from wrsim.plots.theme import new_figure, rendered


def maker(height: float) -> Callable[[], Figure]:
    """A figure that differs from others by its height [mm]."""

    def make() -> Figure:
        figure = new_figure(40.0, height)
        figure.add_subplot().plot([0.0, height], [0.0, 1.0])
        return figure

    return make


FIGURES = {f"picture {n}": maker(20.0 + n) for n in range(5)}


@pytest.fixture(autouse=True)
def two_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "processors", lambda: 2)


def test_pictures_of_two_processes_are_those_of_one_in_their_order() -> None:
    with drawing(FIGURES) as finish:
        drawn = finish()
    assert list(drawn.items()) == [(name, rendered(make())) for name, make in FIGURES.items()]


def test_all_pictures_are_there_when_the_second_process_is_killed() -> None:
    parent = os.getpid()

    def deadly() -> Figure:
        if os.getpid() != parent:
            os.kill(os.getpid(), signal.SIGKILL)
        return FIGURES["picture 0"]()

    with drawing(dict.fromkeys("abc", deadly)) as finish:
        drawn = finish()
    assert list(drawn.values()) == [rendered(FIGURES["picture 0"]())] * 3


def test_an_error_of_a_picture_is_met_here() -> None:
    def faulty() -> Figure:
        raise ValueError("no such picture")

    with pytest.raises(ValueError, match="no such picture"), drawing({"a": faulty, "b": faulty}) as finish:
        finish()


@pytest.mark.skipif(not system.FORKS, reason="one process draws")
def test_the_second_process_dies_with_the_first(tmp_path: Path) -> None:
    """It has inherited the lock of the folder: alive, it would keep the run that goes on out of it."""
    code = f"""
import os, time
from pathlib import Path
from wrsim import system
from wrsim.plots import drawing
system.processors = lambda: 2
def slow():
    Path({str(tmp_path / "second")!r}).write_text(str(os.getpid()))
    time.sleep(1e4)
with drawing({{"one": slow, "other": slow}}) as finish:
    time.sleep(1e4)
"""
    first = subprocess.Popen([sys.executable, "-c", code])
    try:
        told = tmp_path / "second"
        wait_until(lambda: told.exists() and told.read_text(), first)
        second = int(told.read_text())
        assert second != first.pid
        first.kill()
        first.wait()
        wait_until(lambda: not _runs(second), seconds=60.0)
    finally:
        first.kill()


def _runs(process: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
