"""The report of one result or several: one page that needs nothing else."""

import base64
import hashlib
import io
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib.resources import files
from typing import Any, TypeVar

import jinja2
import numpy as np
import xarray as xr
from markupsafe import Markup
from matplotlib.figure import Figure
from PIL import Image

from wrsim import __version__
from wrsim.assessment.outcome import TO_CONFIRM, Assessment
from wrsim.errors import InputError
from wrsim.plots.assessment import history_figure, track_diagram
from wrsim.plots.compare import overlay_figure
from wrsim.plots.cross_section import has_outlines, section_gallery
from wrsim.plots.drawing import Makers, drawing
from wrsim.plots.moments import choose_moments
from wrsim.plots.patches import patch_gallery
from wrsim.plots.pictures import standard_figures
from wrsim.plots.ride import ride_figure
from wrsim.plots.spectra import spectra_figure
from wrsim.plots.subsurface import subsurface_figure
from wrsim.plots.theme import rendered
from wrsim.plots.wear import fatigue_figure, wear_figure
from wrsim.report import tables
from wrsim.report.charts import charts_of
from wrsim.report.document import NO_COVER, Cover, css_text, paragraph, together
from wrsim.results import Result
from wrsim.results.moments import has_patches, has_subsurface, moment_dim, subsurface_tables
from wrsim.results.ride import Ride
from wrsim.results.spectra import spectra_table
from wrsim.results.summary import has_wear
from wrsim.results.table import as_html, formatted, quantity
from wrsim.results.wheelsets import matched, numbered, of_wheelset, wheelsets, worst_wheelset
from wrsim.system import quoted

T = TypeVar("T")

MOST_RESULTS = 8  # results in one report: more have no colours of their own
MOST_MOMENTS = 6  # moments of a wheelset whose contacts are drawn
DOTS = 140  # an inch of pictures that would be too large as drawings


def report_page(
    results: Sequence[Result], sources: Sequence[str], *, viewers: Sequence[str] = (), cover: Cover = NO_COVER
) -> str:
    """The report as HTML. sources: where the results were read from; viewers: pages of their viewers, to be had inside.
    Raises InputError for more results than a page can distinguish."""
    if len(results) > MOST_RESULTS:
        raise InputError(
            f"a report takes at most {MOST_RESULTS} results, not {len(results)}: wrsim study compares more"
        )
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.assessment.assess import assess_runs

    runs = _Runs(results, [last_part(source) for source in sources], _evaluate(assess_runs, results))
    charts = charts_of([r.dataset for r in runs.alike], runs.names, tables.chart_limits(runs.assessments))
    histories = _histories(runs) if charts else {}
    contacts = {name: _contacts(r.dataset, name) for name, r in zip(runs.names, results, strict=True)}
    makers = [histories, *(wheelset["makers"] for sets in contacts.values() for wheelset in sets)]
    moving = [r if {"point", "time"} <= set(r.dataset.dims) else None for r in results]
    with drawing({name: make for each in makers for name, make in each.items()}, partial(rendered, dpi=DOTS)) as finish:
        page: dict[str, Any] = _document_part(runs) | _assessment_part(runs) | _table_part(runs)
        page |= _ride_part(runs.names, _evaluate(evaluate_ride, moving)) | {
            "cover": cover.of(" / ".join(dict.fromkeys(r.title for r in results))),
            "data": charts,
            "histories": list(histories),
            "pictures": [as_picture(n, make()) for n, make in ({} if charts else _standard(runs)).items()],
            "contacts": contacts,
            "wear": [_wear(r, name) for r, name in zip(results, runs.names, strict=True) if has_wear(r.dataset)],
            "vibrations": [_vibrations(r, name) for r, name in zip(results, runs.names, strict=True)],
            "viewers": list(zip(runs.names, viewers, strict=False)),
        }
        page["drawn"] = {name: _as_webp(content) for name, content in finish().items()}
    return page_template("report.html").render(page)


class _Runs:
    """Results of a report, with what is worked out of each of them once.

    names: of several results a letter and where each was read from, of one nothing; alike: the results with wheelsets
    by order, from the front; judged: assessments, or why there are none.
    """

    def __init__(
        self, results: Sequence[Result], sources: Sequence[str], judged: Sequence[tuple[Assessment | None, str]]
    ) -> None:
        self.results, self.sources, self.judged = results, sources, judged
        named = [f"{chr(ord('A') + i)} {source}" for i, source in enumerate(sources)]
        self.names = named if len(named) > 1 else [""]
        self.alike = [Result(matched(r.dataset, results[0].dataset)) for r in results]
        self.summaries = [r.summary() for r in self.alike]
        self.assessments = [assessment for assessment, _ in judged]


def _evaluate(evaluate: Callable[[Result], T], results: Sequence[Result | None]) -> list[tuple[T | None, str]]:
    """What is evaluated of every result, or why there is none; no word about results that are None."""
    return [tables.evaluated(evaluate, r) if r is not None else (None, "") for r in results]


def _document_part(runs: _Runs) -> dict[str, Any]:
    """Summary in sentences, verdicts, who is who, how to run it again."""
    results, sources, summaries = runs.results, runs.sources, runs.summaries
    return {
        "several": len(results) > 1,
        "names": runs.names,
        "version": __version__,
        "paragraphs": [paragraph(*each) for each in zip(results, summaries, runs.assessments, strict=True)],
        "verdicts": [tables.verdict(r, *judged) for r, judged in zip(results, runs.judged, strict=True)],
        "identity": tables.identity(results, sources),
        "versions": tables.version_rows(results, summaries),
        "inputs": [tables.inputs(r) for r in results],
        "texts": [str(r.dataset.attrs.get("scenario_text", "")) for r in results],
        "commands": [f"wrsim run scenario.toml -o {quoted(source or 'run')}" for source in sources],
    }


def _assessment_part(runs: _Runs) -> dict[str, Any]:
    """Limits and margins with their sources, and the track with its sections."""
    rows, sources_of_limits = tables.assessment_rows(runs.assessments)
    cells = [cell for row in rows for cell in row["cells"] if cell]
    assessments = [assessment for assessment in runs.assessments if assessment]
    named = zip(runs.names, runs.assessments, strict=True)
    return {
        "lone": all(assessment.lone for assessment in assessments),
        "assessment": rows,
        "rules": " / ".join(dict.fromkeys(assessment.rules.title for assessment in assessments)),
        "limits_from": sources_of_limits,
        "estimated": any(cell["estimate"] for cell in cells),
        "to_confirm": any(cell["star"] for cell in cells) and TO_CONFIRM,
        "notes": [(name, assessment.notes) for name, assessment in named if assessment and assessment.notes],
        "tracks": [_track(r.dataset, each) for r, each in zip(runs.results, runs.assessments, strict=True)],
    }


def _table_part(runs: _Runs) -> dict[str, Any]:
    """Peaks, curves, differences, numbers and events."""
    return {
        "cards": tables.cards(runs.summaries, runs.names),
        "apart": tables.apart(runs.results, runs.names),
        "curves": tables.curves(runs.summaries, runs.names),
        "numbers": tables.numbers(runs.results, runs.summaries, runs.names),
        "events": tables.event_table(runs.results, runs.summaries, runs.names),
    }


def _ride_part(names: Sequence[str], rides: Sequence[tuple[Ride | None, str]]) -> dict[str, Any]:
    """Comfort and third octaves of what was evaluated, and why the rest was not."""
    ridden = {name: ride for name, (ride, _) in zip(names, rides, strict=True) if ride}
    bands = [("third octaves of the accelerations", ride_figure(ridden, "ride_bands"))] if ridden else []
    return {
        "ride": [ride.table(name) for name, ride in ridden.items()],
        "ride_notes": [why for _, why in rides if why],
        "bands": [as_picture(*band) for band in bands],
    }


@cache
def _environment() -> jinja2.Environment:
    loader = jinja2.PackageLoader("wrsim.report", "templates")
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["table"] = as_html
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False, "separators": (",", ":"), "allow_nan": False}
    environment.filters["css"] = css_text
    environment.globals |= {"text_of": text_of, "hashes": hashes, "together": together}
    return environment


def page_template(name: str) -> jinja2.Template:
    """A template of this package; everything that it is given is escaped."""
    return _environment().get_template(name)


def text_of(name: str) -> Markup:
    """A script or a style sheet of this package, for a page as it is."""
    return Markup(files("wrsim.report").joinpath(name).read_text(encoding="utf-8"))


def hashes(*names: str) -> Markup:
    """Those files for a content security policy: a page may use an element of exactly this text and no other."""
    digests = (hashlib.sha256(text_of(name).encode()).digest() for name in names)
    return Markup(" ").join(Markup(f"'sha256-{base64.b64encode(d).decode()}'") for d in digests)


def last_part(source: str) -> str:
    """The last part of the path of a result or its folder."""
    return source.rstrip("/").removesuffix("/result.nc").rsplit("/", 1)[-1]


def _track(dataset: xr.Dataset, assessment: Assessment | None) -> tuple[str, str] | None:
    """The track of a run as a picture with the labels of its sections; None where the run knows no curvature."""
    if "curvature" not in dataset or dataset.sizes.get("time", 0) < 2 or np.ptp(dataset["distance"].values) < 1e-9:
        return None
    sections = assessment.sections if assessment else ()
    ends = (f"{formatted(s.start, '.0f')} to {quantity(s.end, 'm', '.0f')}" for s in sections)
    labels = [f"section {s.number}: {s.label}, {places}" for s, places in zip(sections, ends, strict=True)]
    return as_picture("; ".join(labels) or "curvature and cant", track_diagram(dataset, sections))


def _histories(runs: _Runs) -> Makers:
    """Pictures of histories for print and for readers without scripts; several results over each other: the wheelset
    that has the largest Y/Q in the first of them."""
    if len(runs.results) == 1:
        (assessment,) = runs.assessments
        return ({"as assessed": partial(history_figure, assessment)} if assessment else {}) | _standard(runs)
    worst = worst_wheelset(runs.alike[0].dataset)
    having = {name: r.dataset for name, r in zip(runs.names, runs.alike, strict=True) if worst in wheelsets(r.dataset)}
    datasets = [of_wheelset(dataset, worst) for dataset in having.values()]
    return {f"wheelset {worst}": partial(overlay_figure, datasets, list(having))}


def _standard(runs: _Runs) -> dict[str, Callable[[], Figure]]:
    """The standard pictures of results, but those of contacts and wear, which have sections of their own."""
    return {
        f"{name}: {picture}" if name else picture: make
        for r, name in zip(runs.results, runs.names, strict=True)
        for picture, make in standard_figures(r.dataset).items()
        if not picture.endswith(("patches", "sections", "subsurface", "wear", "fatigue", "bent", "fast"))
    }


def _contacts(dataset: xr.Dataset, result: str) -> list[dict[str, Any]]:
    """Contacts of all wheelsets at some of their snapshots: pictures, numbers, and how many of the moments."""
    if not has_patches(dataset) or not has_outlines(dataset):
        return []
    wheelset_rows = []
    for name, label in numbered(wheelsets(dataset)).items():
        wheelset = of_wheelset(dataset, name)
        moments, total = choose_moments(wheelset, MOST_MOMENTS), wheelset.sizes[moment_dim(wheelset)]
        makers = {
            "wheel on rail": partial(section_gallery, wheelset, moments),
            "patches from above": partial(patch_gallery, wheelset, moments),
        }
        if has_subsurface(wheelset):
            makers["stresses below the surface"] = partial(subsurface_figure, wheelset)
        numbers = [tables.contacts(wheelset, moments), *subsurface_tables(wheelset)]
        row: dict[str, Any] = {"numbers": numbers, "open": name == worst_wheelset(dataset)}
        row["name"] = label + (f": {len(moments)} of {total} moments" if len(moments) < total else "")
        row["makers"] = {f"{result} {label} {heading}".strip(): make for heading, make in makers.items()}
        wheelset_rows.append(row)
    return wheelset_rows


def _vibrations(result: Result, name: str) -> dict[str, Any]:
    """What bends, and spectra of the fast channels: of the displacements of rails those of their acceleration."""
    from wrsim.analysis.spectra import evaluate_spectra

    names = {"bent": "rails and axles, magnified", "fast": "fast channels"}
    drawn = {name.rpartition("/")[2]: make for name, make in standard_figures(result.dataset).items()}
    pictures = [as_picture(part, drawn[name]()) for name, part in names.items() if name in drawn]
    fast = [str(n).removeprefix("fast_") for n in result.dataset.data_vars if str(n).startswith("fast_")]
    evaluated = [
        tables.evaluated(partial(evaluate_spectra, channel=c, derivative=2 * c.startswith("rail_")), result)
        for c in fast
    ]
    data = [part for part, _ in evaluated if part is not None]
    pictures += [as_picture(f"spectra of {part.attrs['channel']}", spectra_figure(part)) for part in data]
    notes = dict.fromkeys(why for _, why in evaluated if why)
    return {"tables": [spectra_table(part, name) for part in data], "pictures": pictures, "notes": list(notes)}


def _wear(result: Result, name: str) -> dict[str, Any]:
    figures = {"depths over the profiles": wear_figure, "rolling contact fatigue": fatigue_figure}
    pictures = [as_picture(title, make(result.dataset)) for title, make in figures.items()]
    return {"name": name, "tables": tables.wear_tables(result.dataset), "pictures": pictures}


def as_picture(name: str, figure: Figure) -> tuple[str, str]:
    """A figure for a page: its name, and its SVG as a data address."""
    return name.replace("_", " "), _address("svg+xml", rendered(figure, "svg"))


def _as_webp(png: bytes) -> str:
    """The same picture without loss, in a fraction of the bytes: a page is mailed."""
    stream = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").save(stream, "webp", lossless=True, quality=20)
    return _address("webp", stream.getvalue())


def _address(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
