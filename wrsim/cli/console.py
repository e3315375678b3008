"""What commands print: tables, files, warnings, progress."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from wrsim.errors import plain

if TYPE_CHECKING:
    from wrsim.results.table import Table
    from wrsim.scenario.build import Setup

Progress = Callable[[float, float], None]


def warn(file: Path, setup: Setup) -> None:
    """Say what of a scenario is allowed, but looks like a slip."""
    from wrsim.scenario.plausibility import warnings

    for warning in warnings(setup):
        print_error(f"{file}: warning: {warning}")


def warn_slow(setup: Setup) -> None:
    """Warn of a run whose forces all come from the exact contact solver."""
    from wrsim.analysis import exact_run_warning

    for words in exact_run_warning(setup):
        print_error(words)


def print_tables(tables: Iterable[Table]) -> None:
    """Tables on the terminal."""
    from wrsim.results.render import on_terminal

    on_terminal(tables)


def print_found(
    as_json: bool, numbers: dict[str, Any], tables: Iterable[Table], files: Sequence[Path], folder: Path | None = None
) -> None:
    """Numbers with the names of files as JSON; or tables, and the files: how many in a folder, or each."""
    if as_json:
        print_json(numbers | {"files": [str(f) for f in files]})
        return
    print_tables(tables)
    say(*(map(str, files) if folder is None else [f"{len(files)} files in {folder}"]))


def print_json(content: dict[str, Any]) -> None:
    print(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))


def print_error(message: str) -> None:
    print(plain(message), file=sys.stderr)


def say_files(count: int, directory: Path, removed: int = 0) -> None:
    """State where the files of a command are, how many of an earlier one are gone, and how to look at them."""
    say(f"{count} files in {directory}")
    if removed:
        say(f"{removed} files of the result before are gone from there")
    say(f"a page about it for the browser: wrsim report {quote(str(directory))}")


def say(*lines: str) -> None:
    """Print lines of text."""
    for line in lines:
        print(plain(line))


class _Telling(logging.Handler):
    """A line on a terminal that shows what is at work before a run; its bar has room for it. An empty one clears it."""

    bar: Callable[[str], None] | None = None

    def emit(self, record: logging.LogRecord) -> None:
        words = record.getMessage()
        if _Telling.bar is not None:
            _Telling.bar(words or "running")
        else:
            sys.stderr.write(f"\r{words}\x1b[K")
            sys.stderr.flush()


def show_progress() -> None:
    """From now on a terminal shows how far kernels are compiled (the logger ``wrsim.kernels``) and how the search for
    the motion at the start of a run goes (``wrsim.start``)."""
    if sys.stderr.isatty():
        for name in ("wrsim.kernels", "wrsim.start"):
            logger = logging.getLogger(name)
            logger.addHandler(_Telling())
            logger.setLevel(logging.INFO)
            logger.propagate = False


@contextmanager
def progress_bar(wanted: bool) -> Iterator[Progress | None]:
    """A bar with the time left on stderr if that is a terminal; the callback takes (fraction, seconds left)."""
    if not (wanted and sys.stderr.isatty()):
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[left]}"))
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("running", total=1.0, left="")
        _Telling.bar = lambda words: bar.update(task, description=words, refresh=True)

        def advance(fraction: float, seconds_left: float) -> None:
            bar.update(task, completed=fraction, left=time_left(seconds_left))

        try:
            yield advance
        finally:
            _Telling.bar = None


def time_left(seconds: float) -> str:
    """Time left in words that do not flicker."""
    from wrsim.results.table import duration

    return f"{duration(float(round(seconds)))} left" if 0.0 <= seconds < 1e7 else ""
