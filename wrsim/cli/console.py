"""What commands print: tables, files, warnings, progress."""

from __future__ import annotations

import json
import logging
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from math import inf
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from wrsim import system
from wrsim.errors import plain

if TYPE_CHECKING:
    from wrsim.api.outcome import Outcome
    from wrsim.results.table import Table

Progress = Callable[[float, float], None]

LINES_APART = 20.0
"""Seconds between two lines of progress where stderr is no terminal."""


def print_numbers(as_json: bool, numbers: dict[str, Any], tables: Iterable[Table]) -> None:
    """Numbers as JSON, or tables on the terminal."""
    if as_json:
        print_json(numbers)
        return
    from wrsim.results.table import on_terminal

    on_terminal(tables)


def print_outcome(outcome: Outcome, values: Mapping[str, Any]) -> None:
    """Numbers with the names of files as JSON; or tables, the files (how many in a folder, or each) and lines.

    given: options of the command; without --force it writes no files.
    """
    as_json, numbers = values["as_json"], outcome.numbers
    if values.get("quiet") and not as_json:
        return
    if "force" in values:
        numbers = numbers | {"files": [str(f) for f in outcome.files]}
    print_numbers(as_json, numbers, outcome.tables)
    if not as_json:
        one_folder = [f"{len(outcome.files)} files in {outcome.folder}"]
        files = map(str, outcome.files) if outcome.folder is None else one_folder
        print_lines(*files, *outcome.shown_lines)


def print_json(content: dict[str, Any]) -> None:
    print(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))


def print_error(message: str) -> None:
    """A message on stderr; warnings are bold on a terminal."""
    line = plain(message)
    if ": warning: " in line and sys.stderr.isatty():
        line = f"{system.BOLD}{line}{system.USUAL}"
    print(line, file=sys.stderr)


def print_files(count: int, directory: Path | None, removed: int = 0) -> None:
    """Where the files of a command are, how many of an earlier result are removed, and how to look at them."""
    print_lines(f"{count} files in {directory}")
    if removed:
        print_lines(f"{removed} files of the earlier result are removed from there")
    print_lines(f"HTML report: wrsim report {system.quoted(str(directory))}")


def print_lines(*lines: str) -> None:
    for line in lines:
        print(plain(line))


def silent(message: str) -> None:
    """In place of what prints."""


def progress_of(mute: bool) -> dict[str, Callable[..., Any]]:
    """``bar``, which gives a context with the callback of a progress bar, and ``notify``, which takes lines on the
    progress of a study; neither shows anything if mute."""
    return {"bar": partial(progress_bar, not mute), "notify": silent if mute else print_lines}


class _StatusLine(logging.Handler):
    """A line on a terminal, or the text of the progress shown, for what precedes a run. An empty message clears it."""

    bar: Callable[[str], None] | None = None

    def emit(self, record: logging.LogRecord) -> None:
        message = record.getMessage()
        if _StatusLine.bar is not None:
            _StatusLine.bar(message or "running")
        elif sys.stderr.isatty():
            sys.stderr.write(f"\r{message}{system.ERASE}")
            sys.stderr.flush()


def show_progress() -> None:
    """Show the progress of compiling and of the search for the motion at the start of a run."""
    for name in ("wrsim.kernels", "wrsim.start"):
        logger = logging.getLogger(name)
        logger.addHandler(_StatusLine())
        logger.setLevel(logging.INFO)
        logger.propagate = False


class _Times(logging.Handler):
    """A line on stderr with the time of a part of the work."""

    def emit(self, record: logging.LogRecord) -> None:
        from wrsim.results.table import quantity

        print_error(f"{quantity(getattr(record, 'seconds', 0.0), 's', '.2f'):>10}  {record.getMessage()}")


def show_times(wanted: bool) -> bool:
    """Print what a command does and the time of each part (``--verbose``)."""
    logger = logging.getLogger("wrsim.timing")
    if wanted:
        logger.handlers, logger.propagate = [_Times()], False
        logger.setLevel(logging.INFO)
    return wanted


@contextmanager
def progress_bar(wanted: bool) -> Iterator[Progress | None]:
    """A bar with the time left on stderr, or a line now and then if that is no terminal; the callback takes (fraction,
    seconds left)."""
    if not wanted:
        yield None
        return
    with _bar() if sys.stderr.isatty() else _lines() as (show, advance):
        _StatusLine.bar = show
        try:
            yield advance
        finally:
            _StatusLine.bar = None


@contextmanager
def _bar() -> Iterator[tuple[Callable[[str], None], Progress]]:
    """What sets the text of a bar, and what moves it on."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskProgressColumn, TextColumn
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(time_left(task.fields["left"], time.monotonic() - task.fields["told"]))

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeLeft())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("running", total=1.0, left=inf, told=time.monotonic())

        def advance(fraction: float, seconds_left: float) -> None:
            bar.update(task, completed=fraction, left=seconds_left, told=time.monotonic())

        yield lambda text: bar.update(task, description=text, refresh=True), advance


@contextmanager
def _lines() -> Iterator[tuple[Callable[[str], None], Progress]]:
    """The same in lines, one every ``LINES_APART``, the last one again where nothing new is told for so long."""
    last, latest, left, told, done = time.monotonic(), "running", inf, time.monotonic(), Event()

    def show(text: str, seconds_left: float = inf) -> None:
        nonlocal last, latest, left, told
        if text:
            latest, left, told = text, seconds_left, time.monotonic()
        if time.monotonic() - last >= LINES_APART:
            print_error(f"{latest}, {time_left(left, time.monotonic() - told)}".removesuffix(", "))
            last = time.monotonic()

    def repeat() -> None:
        while not done.wait(1.0):
            show("")

    Thread(target=repeat, daemon=True).start()
    try:
        yield show, lambda fraction, seconds_left: show(f"{fraction:.0%}", seconds_left)
    finally:
        done.set()


def time_left(seconds: float, waited: float = 0.0) -> str:
    """Time left in words that do not flicker; waited: since it was told [s]. Where that is over: how long ago."""
    from wrsim.results.table import duration

    if waited > max(seconds, 1.0) + 1.0:
        return f"{duration(float(round(waited)))} since the last step, longer than expected"
    return f"{duration(float(round(max(seconds - waited, 0.0))))} left" if 0.0 <= seconds < 1e7 else ""
