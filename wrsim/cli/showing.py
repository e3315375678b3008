"""What the user reads: tables, facts of a scenario, progress, peaks of a result."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from textwrap import fill
from typing import TYPE_CHECKING, Any

from wrsim.register import ANALYSES, resolved

if TYPE_CHECKING:
    from wrsim.geometry.profile.smoothing_report import SmoothingReport
    from wrsim.results import Result
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
    from wrsim.simulation.step import evaluations_for

    plan = setup.plan
    evaluations = evaluations_for(
        plan.integrator, plan.duration, plan.speeds[0], plan.output_interval, plan.step, setup.vehicle
    )
    complain(
        f'contact.normal = "half-space" solves the exact problem at every stage of the integration: about '
        f"{evaluations:.0f} times for each wheel, some {_duration(EXACT_TIME * evaluations).removesuffix(' left')}. "
        "wrsim resolve does it for the kept moments of a fast run"
    )


EXACT_TIME = 0.06  # of both wheels together, with creep forces [s]


def print_facts(facts: dict[str, Any]) -> None:
    for name, value in facts.items():
        if isinstance(value, list):
            value = ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
        elif isinstance(value, float):
            value = f"{value:.6g}"
        say(f"  {name:<14} {value}")


def print_table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], *, title: str = "", left: Sequence[str] = (), width: int = 0
) -> None:
    """A table on the screen. Columns are flush right but for those in ``left``; a row of one cell is a heading in bold.

    width: letters that the table needs, where the terminal may be narrower. No cell is ever cut, heads are wrapped.
    """
    from rich.cells import cell_len
    from rich.console import Console
    from rich.table import Table

    rows = [[*map(plain, row)] for row in rows]
    columns = [[*head.split(), *(row[i] for row in rows if len(row) > 1)] for i, head in enumerate(heads)]
    least = [max(map(cell_len, column), default=0) for column in columns]
    whole = [max(letters, cell_len(head)) for letters, head in zip(least, heads, strict=True)]
    console = Console(highlight=False, markup=False)
    console.width = max(console.width, width)
    if sum(whole) + 2 * len(heads) > console.width:
        whole = least
        console.width = max(console.width, sum(least) + 2 * len(heads))
    table = Table(title=plain(title) or None, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for head, letters in zip(heads, whole, strict=True):
        look: Any = {"justify": "left" if head in left else "right", "style": "dim" if head == "at" else None}
        table.add_column(fill(head, max(letters, 1)), no_wrap=True, **look)
    for row in rows:
        table.add_row(*row, style="bold" if len(row) == 1 else None)
    console.print(table)


def print_result(result: Result) -> None:
    """The numbers of a result as its analysis shows them, and what its contacts have to say."""
    resolved(ANALYSES[result.analysis].printed)(result)
    print_some([f"{place}: {words}" for place, words in result.summary().get("remarks", {}).items()], "remarks")


def print_numbers(result: Result) -> None:
    """The plain numbers of a result's summary, a line each."""
    print_title(result.title)
    print_facts({name: value for name, value in result.summary().items() if isinstance(value, int | float)})


def print_some(lines: Sequence[str], what: str) -> None:
    """The first lines, and how many more there are."""
    for line in lines[:MOST_LINES]:
        say(line)
    if len(lines) > MOST_LINES:
        say(f"and {len(lines) - MOST_LINES} more {what}: see summary.json")


MOST_LINES = 10
"""Events and remarks that are printed."""


def print_title(title: str) -> None:
    """A title in bold."""
    from typer import secho

    secho(plain(title), bold=True)


def print_smoothing(reports: Sequence[SmoothingReport]) -> None:
    """Curvature before and after, and how far smoothing moved the points, one line a cut-off."""
    first = reports[0]
    say(f"{len(first.points)} points, which scatter by {1e6 * first.scatter:.3g} um across the curve")
    heads = ("cut-off", "largest curvature [1/m]", "at u [mm]", "RMS change [um]", "largest [um]", "at u [mm]", "line")
    rows = [["none", f"{first.curvature_before:.4g}", *[""] * 5]]
    for r in reports:
        most, where, line = r.largest_change
        found = [f"{r.curvature_after:.4g}", f"{1e3 * r.sharpest:.2f}", f"{1e6 * r.rms_change:.3g}"]
        rows.append([f"{1e3 * r.cutoff:g} mm", *found, f"{1e6 * most:.3g}", f"{1e3 * where:.2f}", str(line)])
    print_table(heads, rows)


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


_CONTROLS = {*range(0x20), *range(0x7F, 0xA0), *range(0x202A, 0x202F), *range(0x2066, 0x206A)} - {0x09, 0x0A}
_PLAIN = dict.fromkeys(_CONTROLS, "\N{REPLACEMENT CHARACTER}")


def plain(text: str) -> str:
    """A text without characters that command a terminal: titles, names and paths come from anybody."""
    return text.translate(_PLAIN)


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
            bar.update(task, completed=fraction, left=_duration(seconds_left))

        try:
            yield advance
        finally:
            _Telling.bar = None


def _duration(seconds: float) -> str:
    """Time left in words that do not flicker."""
    if not 0.0 <= seconds < 1e7:
        return ""
    if seconds < 90.0:
        return f"{seconds:.0f} s left"
    return f"{seconds / 60.0:.0f} min left" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h left"
