"""The report of one result or several: one page that needs nothing else."""

from __future__ import annotations

import base64
import hashlib
import shlex
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure

from wrsim import __version__
from wrsim.errors import InputError
from wrsim.plots.pictures import standard_figures
from wrsim.plots.style import rendered
from wrsim.plots.wear import fatigue_figure, wear_figure
from wrsim.report import facts
from wrsim.report.bands import bands_drawing
from wrsim.report.charts import Charts, charts_of, drawing
from wrsim.report.contacts import kept_contacts, pressure_key
from wrsim.report.strip import track_strip
from wrsim.report.wear import wear_tables
from wrsim.results import Result
from wrsim.results.render import as_html
from wrsim.results.table import Table
from wrsim.results.wear import has_wear

MOST_RESULTS = 8
"""Results in one report: more have no colours of their own."""

OWN_DRAWINGS = ("patches", "sections")
"""Standard pictures in whose place the report has drawings of its own."""


def report_page(
    results: Sequence[Result], sources: Sequence[str], *, commands: Sequence[str] = (), viewers: Sequence[str] = ()
) -> str:
    """The report as HTML.

    sources: where the results were read from; commands: how each is made again; viewers: pages of their viewers, to be
    had inside. Raises InputError for more results than a page can tell apart.
    """
    if len(results) > MOST_RESULTS:
        raise InputError(
            f"a report takes at most {MOST_RESULTS} results, not {len(results)}: wrsim study compares more"
        )
    names = _names(sources)
    both = [facts.assessed(r) for r in results]
    found = [assessment for assessment, _ in both]
    charts = charts_of([r.dataset for r in results], names, facts.limits_of(found))
    rides = [facts.ridden(r) for r in results]
    several = len(results) > 1
    rows, sources_of_limits = facts.assessment_rows(found)
    page: dict[str, Any] = {
        "title": " / ".join(dict.fromkeys(r.title for r in results)),
        "several": several,
        "names": names,
        "version": __version__,
        "verdicts": [facts.verdict(r, *own) for r, own in zip(results, both, strict=True)],
        "identity": facts.identity(results, sources),
        "inputs": [facts.inputs(r) for r in results],
        "texts": [str(r.dataset.attrs.get("scenario_text", "")) for r in results],
        "commands": list(commands),
        "assessment": rows,
        "limits_from": sources_of_limits,
        "estimated": any(cell and cell["estimate"] for row in rows for cell in row["cells"]),
        "notes": [(name, own.notes) for name, own in zip(names, found, strict=True) if own is not None and own.notes],
        "strips": [track_strip(r.dataset, own.sections if own else ()) for r, own in zip(results, found, strict=True)],
        "charts": _drawn(charts, several),
        "data": charts.script_data() if charts else None,
        "first_part": charts.worst if charts and several else "",
        "cards": facts.cards(results, names),
        "curves": facts.curves(results, names),
        "numbers": _numbers(results, names),
        "contacts": [(name, *kept_contacts(r.dataset)) for name, r in zip(names, results, strict=True)],
        "keys": [pressure_key(r.dataset) if "strip_p" in r.dataset else "" for r in results],
        "wear": [_wear(r, name) for r, name in zip(results, names, strict=True) if has_wear(r.dataset)],
        "ride": [ride.table(name) for (ride, _), name in zip(rides, names, strict=True) if ride],
        "ride_notes": [why for _, why in rides if why],
        "bands": bands_drawing([ride for ride, _ in rides], names),
        "events": facts.events(results, names),
        "pictures": [] if charts else [picture for r in results for picture in _pictures(r, several)],
        "viewers": list(zip(names, viewers, strict=False)),
    }
    return template("report.html").render(page)


@cache
def _environment() -> jinja2.Environment:
    loader = jinja2.PackageLoader("wrsim.report", "templates")
    own = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    own.filters["table"] = as_html
    own.policies["json.dumps_kwargs"] = {"sort_keys": False, "separators": (",", ":"), "allow_nan": False}
    own.globals |= {"text_of": text_of, "hashes": hashes}
    return own


def template(name: str) -> jinja2.Template:
    """A template of this package; everything that it is given is escaped."""
    return _environment().get_template(name)


def text_of(name: str) -> Markup:
    """A script or a style sheet of this package, to stand in a page as it is."""
    return Markup(files("wrsim.report").joinpath(name).read_text(encoding="utf-8"))


def hashes(*names: str) -> Markup:
    """Those files for a content security policy: a page may use an element of exactly this text and no other."""
    digests = (hashlib.sha256(text_of(name).encode()).digest() for name in names)
    return Markup(" ").join(Markup(f"'sha256-{base64.b64encode(d).decode()}'") for d in digests)


def _names(sources: Sequence[str]) -> list[str]:
    """Short names that tell the results apart: A, B, ... with the last part of their paths."""
    if len(sources) == 1:
        return [""]
    short = [source.rstrip("/").removesuffix("/result.nc").rsplit("/", 1)[-1] for source in sources]
    return [f"{chr(ord('A') + i)} {name}" for i, name in enumerate(short)]


def rerun(result: Result, source: str) -> str:
    """The command that makes a result again from the scenario that stands in the report."""
    name = source.rstrip("/").removesuffix("/result.nc").rsplit("/", 1)[-1] or "run"
    return f"wrsim run scenario.toml -o {shlex.quote(name)}"


def _drawn(charts: Charts | None, several: bool) -> list[dict[str, Any]]:
    """Every chart with its drawing; of several results that of one wheelset."""
    if charts is None:
        return []
    part = charts.worst if several else ""
    return [
        {
            "key": chart.key,
            "title": chart.title,
            "unit": chart.unit,
            "note": chart.note,
            "svg": drawing(charts, chart, part),
            "lines": [line for line in chart.lines if part in ("", line.part) or not line.part],
            "peak": chart.peak(),
        }
        for chart in charts.charts
    ]


def _numbers(results: Sequence[Result], names: Sequence[str]) -> list[Table]:
    """The tables of results without wheelsets (stability, steady, conicity)."""
    if any("wheelsets" in r.summary() for r in results):
        return []
    found = []
    for result, name in zip(results, names, strict=True):
        found += [replace(t, title=f"{name}: {t.title}" if name else t.title) for t in result.numbers()]
    return found


def _wear(result: Result, name: str) -> dict[str, Any]:
    """Tables and pictures of wear and fatigue of a run."""
    figures = {"depths over the profiles": wear_figure, "rolling contact fatigue": fatigue_figure}
    return {
        "name": name,
        "tables": wear_tables(result.dataset),
        "pictures": [as_picture(words, make(result.dataset)) for words, make in figures.items()],
    }


def _pictures(result: Result, several: bool) -> list[tuple[str, str]]:
    """The standard pictures of a result without histories: words and the picture as a data address."""
    found = []
    for name, make in standard_figures(result.dataset).items():
        if name.endswith(OWN_DRAWINGS):
            continue
        words, address = as_picture(name, make())
        found.append((f"{result.title}: {words}" if several else words, address))
    return found


def as_picture(name: str, figure: Figure) -> tuple[str, str]:
    """A figure for a page: its name in words, and the drawing as a data address."""
    with mpl.rc_context({"savefig.dpi": 110}):
        drawn = rendered(figure, vector=True)
    return name.replace("_", " "), "data:image/svg+xml;base64," + base64.b64encode(drawn).decode()
