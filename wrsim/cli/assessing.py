"""``wrsim assess``: a run assessed by EN 14363 and what else is known."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import BesideResult, Force, Json, Pictures, SectionsOf, beside
from wrsim.cli.showing import print_json, print_table, say
from wrsim.cli.storing import RESULT, read, writing
from wrsim.errors import InputError

WIDTH = 112
"""Letters that the tables need."""

if TYPE_CHECKING:
    from wrsim.results.assessment import Assessment, Section, ZoneValue


def assess(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Runs: files, folders, cut off or not. Several count as one test."),
    ],
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Assess a run: EN 14363 quantities section by section, limits and margins; leaves tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).
    """
    with reporting_errors(as_json), writing(force, *results[1:], of=results[0]):
        from wrsim.analysis.assessment import assess as assessed
        from wrsim.results import write_atomically
        from wrsim.results.assessment_tables import assessment_csv, assessment_json, assessment_rows
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.assessment import AssessmentSection

        if len(results) > 1 and output is None:
            raise InputError("-o DIR is missing: an assessment of several runs belongs to none of their folders")
        loaded = [read(path) for path in results]
        settings = None if scenario is None else load(scenario).table(AssessmentSection).settings()
        found = assessed(loaded, settings, _names(results))
        directory = output or beside(results[0])
        files = [
            write_atomically(directory / "assessment.json", assessment_json(found)),
            write_atomically(directory / "assessment.csv", assessment_csv(found)),
        ]
        if pictures:
            from wrsim.plots.assessment import assessment_pictures

            files += assessment_pictures(found, directory)
        if as_json:
            print_json(assessment_rows(found) | {"files": [str(f) for f in files]})
            return
        print_assessment(found)
        say(f"{len(files)} files in {directory}")


def _names(results: list[Path]) -> list[str]:
    """Names of runs: the ends of their paths, as long as it takes to tell them apart.

    Raises InputError for a run that is given twice.
    """
    paths = [path.resolve() for path in results]
    paths = [path.parent if path.name.startswith(RESULT) else path for path in paths]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError(f"{results[i]}: given twice")
    parts = 1
    while len({path.parts[-parts:] for path in paths}) < len(paths):
        parts += 1
    return ["/".join(path.parts[-parts:]) for path in paths]


def _remark(section: Section) -> str:
    """What there is to say of a section, behind its class."""
    words = [word for word, said in (("short", section.short), ("does not count", not section.counts)) if said]
    return f" ({', '.join(words)})" if words else ""


def print_assessment(found: Assessment) -> None:
    """Sections, then the worst value of every quantity in every class of track, then what could not be said."""
    rows = []
    for s in found.sections:
        numbers = (f"{s.start:z.1f}", f"{s.end:.1f}", f"{3.6 * s.speed:.0f}", f"{1e3 * s.cant_deficiency:z.0f}")
        rows.append([*([s.run] if s.run else []), str(s.number), s.label + _remark(s), *numbers])
    heads = ["section", "class", "from m", "to m", "km/h", "cant deficiency mm"]
    if found.sections[0].run:
        heads.insert(0, "run")
    print_table(heads, rows, title=found.title, left=("run", "class"), width=WIDTH)
    say()
    sources: dict[str, str] = {}
    rows, last = [], ""
    for row in found.zones():
        limit, quantity = row.worst.limit, row.worst.quantity
        letter = ""
        if limit is not None:
            letter = sources.setdefault(f"{limit.source} [{limit.mark}]", chr(ord("a") + len(sources) % 26))
        rows.append(_cells(row, quantity.key != last, letter))
        last = quantity.key
    heads = ["", "unit", "class (sections)", "worst", "estimate", "limit", "margin", "", "by", "worst in"]
    print_table(heads, rows, left=("", "unit", "class (sections)", "by", "worst in"), width=WIDTH)
    say()
    print_regressions(found)
    print_track(found)
    for source, letter in sources.items():
        say(f"{letter}  {source}")
    for note in found.notes:
        say(f"note: {note}")
    verdict = "every quantity is within its limit" if found.passed else "A LIMIT IS EXCEEDED"
    say(f"{verdict}; [mem]: from memory of the standard, [pub]: from a published source")


def print_regressions(found: Assessment) -> None:
    """How quantities with a limit depend on what the sections differ in, and why some of them are not told."""
    from wrsim.results.regression import SHOWN

    rows, short = [], set()
    for row in found.zones():
        r, quantity = row.regression, row.worst.quantity
        if r is None:
            short |= {row.worst.section.zone} if found.estimate_over else set()
            continue
        factor = quantity.shown.factor
        slopes = []
        for name in found.estimate_over:
            if name not in r.over:
                slopes.append("")
                continue
            unit, own = SHOWN[name]
            i = r.over.index(name)
            slopes.append(f"{r.slope[i] * factor / own:z.3g} at {r.at[i] * own:.4g} {unit}")
        numbers = [f"{value * factor:z.4g}" for value in (r.fit, r.deviation, r.estimate)]
        if row.worst.limit is not None:
            rows.append([quantity.symbol, f"{row.worst.section.zone} ({row.number})", *slopes, *numbers])
    if rows:
        heads = [
            "",
            "class (sections)",
            *(f"per {SHOWN[n][0]} of {n}" for n in found.estimate_over),
            "fit",
            "s",
            "estimate",
        ]
        print_table(
            heads, rows, title="estimated values by regression [mem]", left=("", "class (sections)"), width=WIDTH
        )
        say()
    if short:
        say(f"no regression, too few sections or influences that go together: {', '.join(sorted(short))}")


def print_track(found: Assessment) -> None:
    """How uneven the sections are."""
    if not found.track:
        return
    rows = [
        [str(t.section.number), t.direction, *(f"{1e3 * v:.2f}" for v in (t.deviation, t.largest)), t.by_deviation,
         t.by_largest, t.tl90]
        for t in found.track
    ]  # fmt: skip
    heads = ["section", "", "deviation mm", "largest mm", "UIC 518 by deviation", "by largest", "TL90 of EN 14363"]
    print_table(heads, rows, title="Track, worse rail, waves of 3 to 25 m [mem]", left=("",), width=WIDTH)
    say()


def _cells(row: ZoneValue, first: bool, letter: str) -> list[str]:
    worst, cells = row.worst, row.cells()
    shown = worst.quantity.shown
    return [
        worst.quantity.symbol if first else "",
        shown.symbol if first and shown.symbol != "1" else "",
        f"{worst.section.zone} ({row.number})",
        *(cells[key] for key in ("worst", "estimate", "limit", "margin", "verdict")),
        letter,
        cells["worst in"],
    ]
