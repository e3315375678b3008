"""``wrsim diff``: two results side by side; for regression tests, its exit code says whether they are alike."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import DIFFERENT, reporting_errors
from wrsim.cli.options import AnyResult, Force, Json
from wrsim.cli.showing import print_json, print_tables, say
from wrsim.cli.storing import read, told_of, writing
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.results.differences import Difference

LISTED = 20


def diff(
    first: AnyResult,
    second: AnyResult,
    tolerance: Annotated[
        float,
        typer.Option(metavar="PART", help="Largest difference allowed, as a part of the quantity's largest value."),
    ] = 0.01,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="QUANTITY", help="Such as Y_over_Q_max; may be given again.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Leave a table and an overlay picture there.")
    ] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Compare two results: peaks, medians in full curves, other numbers; exit code 4 when they differ."""
    with reporting_errors(as_json), writing(force, first, second):
        from wrsim.results.differences import differences, table_of
        from wrsim.results.render import as_records

        if not 0.0 <= tolerance < math.inf:
            raise InputError(f"--tolerance {tolerance:g}: must be a number not below 0, such as 0.01 for 1 %")
        one, other = read(first), read(second)
        with told_of(first, second):
            found = differences(one, other, only or ())
        beyond = [d for d in found if d.relative > tolerance]
        words = _ends(one, other)
        files = [] if output is None else _write(found, one, other, (str(first), str(second)), output)
        alike = not beyond and not words
        if as_json:
            print_json(
                {
                    "alike": alike,
                    "tolerance": tolerance,
                    "ends": words,
                    "differences": as_records(table_of(found)),
                    "files": [str(f) for f in files],
                }
            )
        else:
            _print(found, beyond, words, tolerance, (first, second))
            if files:
                say(f"{len(files)} files in {output}")
        if not alike:
            raise typer.Exit(DIFFERENT)


def _ends(one: Result, other: Result) -> list[str]:
    """How the two ended, where they did not end alike."""
    if one.status == other.status:
        return []
    return [
        f"{name}: {r.status}" + (f": {r.stop_reason}" if r.stop_reason else "")
        for name, r in (("A", one), ("B", other))
    ]


def _print(
    found: list[Difference], beyond: list[Difference], words: list[str], tolerance: float, names: tuple[Path, Path]
) -> None:
    """What is beyond the tolerance, or the largest differences where nothing is."""
    from wrsim.results.differences import table_of
    from wrsim.results.table import Table

    shown = (beyond or [d for d in found if d.relative > 0.0])[:LISTED]
    more = [f"... and {len(beyond) - LISTED} more; --json lists all"] if len(beyond) > LISTED else []
    if beyond:
        verdict = f"{len(beyond)} of {len(found)} numbers differ by more than {100.0 * tolerance:g} %"
    elif words:
        verdict = "the numbers are alike, the ends are not"
    else:
        verdict = f"alike: {len(found)} numbers, none differs by more than {100.0 * tolerance:g} %"
    head = Table("", notes=tuple(f"{letter}: {name}" for letter, name in zip("AB", names, strict=True)))
    print_tables([head, *([table_of(shown)] if shown else []), Table("", notes=(*more, *words, verdict))])


def _write(found: list[Difference], one: Result, other: Result, names: tuple[str, str], folder: Path) -> list[Path]:
    """``diff.csv`` and, of runs and poses, ``diff.png``."""
    from wrsim.plots.diff import has_curves, overlay_figure
    from wrsim.plots.style import save
    from wrsim.results import write_atomically
    from wrsim.results.differences import table_of
    from wrsim.results.files import as_csv
    from wrsim.results.render import as_rows
    from wrsim.results.wheelsets import of_wheelset, wheelsets, worst_wheelset

    files = [write_atomically(folder / "diff.csv", as_csv(as_rows(table_of(found))))]
    datasets = (one.dataset, other.dataset)
    if all(has_curves(d) for d in datasets):
        worst = worst_wheelset(one.dataset)
        if worst in wheelsets(other.dataset):
            pair = [of_wheelset(d, worst) for d in datasets]
            files.append(save(overlay_figure(pair[0], pair[1], names), folder / "diff.png"))
    return files
