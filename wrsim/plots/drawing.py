"""Pictures drawn by two processes at once.

A second process is forked where there is a second processor for it (Linux alone). It draws while this one writes the
numbers, then both take picture after picture until all are drawn. What the second one does not bring, this one draws:
so errors are met here, as they are without it.
"""

import gc
import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser

from wrsim import system
from wrsim.plots.theme import LOOK, rendered
from wrsim.results import write_atomically

Paint = Callable[[Figure], Any]
Makers = Mapping[str, Callable[[], Figure]]
Finish = Callable[[], dict[str, Any]]
"""Draws what is left, and gives all pictures by their names."""


@contextmanager
def drawing(figures: Makers, paint: Paint = rendered) -> Iterator[Finish]:
    """Draw pictures while other work is done in the block, if there is a second processor. paint: figure to content."""
    alone = multiprocessing.current_process().daemon or system.processors() < 2
    if not system.FORKS or alone or len(figures) < 2:
        yield lambda: {name: paint(make()) for name, make in figures.items()}
        return
    context: Any = multiprocessing.get_context("fork")
    taken = context.Value("i", 0)
    receiver, sender = context.Pipe(duplex=False)
    second = context.Process(target=_second, args=(figures, paint, taken, sender, receiver, os.getpid()), daemon=True)
    with warnings.catch_warnings():
        # from 3.12 on: "may lead to deadlocks"; the only other threads are those of BLAS, which stop for a fork
        warnings.simplefilter("ignore", DeprecationWarning)
        MathTextParser("agg").parse(r"$\gamma$")  # both processes would make its grammar, 30 ms
        gc.freeze()  # to look through all that is there would copy its pages in the second process
        second.start()
    sender.close()

    def finish() -> dict[str, bytes]:
        drawn = _share(figures, paint, taken)
        with suppress(EOFError, OSError):  # it was killed, or has met an error
            drawn |= receiver.recv()
        return {name: drawn[name] if name in drawn else paint(make()) for name, make in figures.items()}

    try:
        yield finish
    finally:
        second.terminate()
        second.join()
        receiver.close()
        gc.unfreeze()


def save_all(figures: Makers, directory: str | Path) -> list[Path]:
    """Write pictures by their names, when all are drawn, as PNG or in the kinds of files of `theme.LOOK`; returns their
    paths. Raises ``WrsimError``."""
    with drawing(figures, in_all_kinds) as finish:
        return written(finish, directory)


def written(finish: Finish, directory: str | Path) -> list[Path]:
    """Write what `drawing` with `in_all_kinds` gives."""
    return [
        write_atomically(Path(directory) / f"{name}.{kind}", content)
        for name, drawn in finish().items()
        for kind, content in drawn.items()
    ]


def in_all_kinds(figure: Figure) -> dict[str, bytes]:
    """The figure in every kind of files of `theme.LOOK`."""
    return {kind: rendered(figure, kind) for kind in LOOK.get().kinds}


def _share(figures: Makers, paint: Paint, taken: Any) -> dict[str, Any]:
    """Draw one picture after the other that neither process has taken yet: the last ones, which take longest, first."""
    drawn: dict[str, Any] = {}
    for place, (name, make) in enumerate(reversed([*figures.items()])):
        with taken.get_lock():
            mine = taken.value == place
            taken.value += mine
        if mine:
            drawn[name] = paint(make())
    return drawn


def _second(figures: Makers, paint: Paint, taken: Any, sender: Any, receiver: Any, first: int) -> None:
    """What the second process does; it reports nothing, and leaves what goes wrong to the first. It must not outlive
    the first one: it has inherited the lock of the folder, and would keep others out of it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    system.die_with(first)
    receiver.close()
    try:
        sender.send(_share(figures, paint, taken))
    except Exception:
        os._exit(1)
