"""What the user reads: tables, facts of a scenario, progress, peaks of a result."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from wrsim.errors import plain
from wrsim.register import ANALYSES

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.results.table import Table
    from wrsim.scenario.build import Setup

Progress = Callable[[float, float], None]


def facts(setup: Setup) -> dict[str, Any]:
    """What a scenario comes to, for people to see that it is what they meant."""
    vehicle = setup.vehicle
    facts: dict[str, Any] = {
        "title": setup.title,
        "analysis": setup.analysis,
        "vehicle": vehicle.name,
        "wheelsets": [mounted.name for mounted in vehicle.wheelsets],
        "axle_load_kN": vehicle.weight / len(vehicle.wheelsets) / 1e3,
        "drive": setup.drive,
        "gauge_mm": 1e3 * setup.track.nominal_gauge,
        "rails": [rail.name for rail in setup.rails],
        "files": [str(f) for f in setup.files],
    }
    if setup.conical is None:
        chosen = setup.contact
        facts |= {"normal": chosen.normal, "tangential": chosen.creep_forces, "max_patches": chosen.patch_count}
        facts |= {"strip_width_mm": 1e3 * chosen.strip_width} if chosen.strip_width else {"strips": chosen.strip_count}
    else:
        facts["contact"] = f"conical wheels, {setup.conical.conicity:g}, with a prescribed creep law"
    if ANALYSES[setup.analysis].moves:
        facts["segments"] = [f.label if f.label == f.kind else f"{f.kind} {f.label}" for f in setup.track.features()]
    return facts | setup.plan.facts()


def warn(file: Path, setup: Setup) -> None:
    """Say what of a scenario is allowed, but looks like a slip."""
    from wrsim.scenario.plausibility import warnings

    for warning in warnings(setup):
        complain(f"{file}: warning: {warning}")


def tell_slow(setup: Setup) -> None:
    """Warn of a run whose forces all come from the exact contact solver."""
    if setup.contact.normal != "half-space" or not ANALYSES[setup.analysis].moves:
        return
    from wrsim.results.table import duration
    from wrsim.simulation.step import evaluations_for

    plan = setup.plan
    evaluations = evaluations_for(
        plan.integrator, plan.duration, plan.speeds[0], plan.output_interval, plan.step, setup.vehicle
    )
    complain(
        f'contact.normal = "half-space" solves the exact problem at every stage of the integration: about '
        f"{evaluations:.0f} times for each wheel, some {duration(EXACT_TIME * evaluations)}. "
        "wrsim resolve does it for the kept moments of a fast run"
    )


EXACT_TIME = 0.06  # of both wheels together, with creep forces [s]


def facts_table(title: str, facts: dict[str, Any]) -> Table:
    """Facts, one a line."""
    from wrsim.results.table import Column, Table, formatted

    def text(value: object) -> str:
        return ", ".join(map(text, value)) if isinstance(value, list) else formatted(value, ".6g")

    return Table(title, (Column(), Column()), [(name, text(value)) for name, value in facts.items()])


def print_tables(tables: Iterable[Table]) -> None:
    """Tables on the terminal."""
    from wrsim.results.render import on_terminal

    on_terminal(tables)


def print_result(result: Result) -> None:
    """The numbers of a result that people read first."""
    print_tables(result.numbers())


def print_files(files: list[Path], as_json: bool) -> None:
    if as_json:
        print_json({"files": [str(f) for f in files]})
    else:
        say("\n".join(map(str, files)))


def print_json(content: dict[str, Any]) -> None:
    print(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))


def complain(message: str) -> None:
    print(plain(message), file=sys.stderr)


def say_files(count: int, directory: Path, removed: int = 0) -> None:
    """Say where the files of a command stand, how many of an earlier one are gone, and how to look at them."""
    say(f"{count} files in {directory}")
    if removed:
        say(f"{removed} files of the result before are gone from there")
    say(f"a page about it for the browser: wrsim report {quote(str(directory))}")


def say(text: str = "") -> None:
    print(plain(text))


class _Telling(logging.Handler):
    """A line on a terminal that says what is at work before a run; its bar has room for it. An empty one clears it."""

    bar: Callable[[str], None] | None = None

    def emit(self, record: logging.LogRecord) -> None:
        words = record.getMessage()
        if _Telling.bar is not None:
            _Telling.bar(words or "running")
        else:
            sys.stderr.write(f"\r{words}\x1b[K")
            sys.stderr.flush()


def tell_progress() -> None:
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
