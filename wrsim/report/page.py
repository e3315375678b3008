"""The report of one result or several: one page that needs nothing else."""

import base64
import hashlib
import io
import shlex
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib.resources import files
from typing import Any

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
from wrsim.plots.theme import rendered
from wrsim.plots.wear import fatigue_figure, wear_figure
from wrsim.report import tables
from wrsim.report.charts import charts_of
from wrsim.report.document import NO_COVER, Cover, css_text, paragraph, together
from wrsim.results import Result
from wrsim.results.moments import has_patches, moment_dim
from wrsim.results.spectra import spectra_table
from wrsim.results.summary import has_wear
from wrsim.results.table import as_html, formatted, quantity
from wrsim.results.wheelsets import matched, numbered, of_wheelset, wheelsets, worst_wheelset

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
    sources = [last_part(source) for source in sources]
    names = [f"{chr(ord('A') + i)} {source}" for i, source in enumerate(sources)]
    names = names if len(names) > 1 else [""]
    alike = [Result(matched(r.dataset, results[0].dataset)) for r in results]  # wheelsets by order, from the front
    summaries = [r.summary() for r in alike]
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.assessment.assess import assess_runs

    both = [tables.evaluated(assess_runs, r) for r in results]
    found = [assessment for assessment, _ in both]
    charts = charts_of([r.dataset for r in alike], names, tables.chart_limits(found))
    moves = [{"point", "time"} <= set(r.dataset.dims) for r in results]
    rides = [tables.evaluated(evaluate_ride, r) if so else (None, "") for r, so in zip(results, moves, strict=True)]
    ridden = {name: ride for name, (ride, _) in zip(names, rides, strict=True) if ride}
    bands = [partial(ride_figure, ridden, "ride_bands")] if ridden else []
    histories = _histories(alike, names, found) if charts else {}
    contacts = {name: _contacts(r.dataset, name) for name, r in zip(names, results, strict=True)}
    rows, sources_of_limits = tables.assessment_rows(found)
    makers = [histories, *(own["makers"] for sets in contacts.values() for own in sets)]
    with drawing({name: make for own in makers for name, make in own.items()}, partial(rendered, dpi=DOTS)) as finish:
        page: dict[str, Any] = {
            "cover": cover.of(" / ".join(dict.fromkeys(r.title for r in results))),
            "paragraphs": [paragraph(r, s, own) for r, s, own in zip(results, summaries, found, strict=True)],
            "several": len(results) > 1,
            "names": names,
            "version": __version__,
            "verdicts": [tables.verdict(r, *own) for r, own in zip(results, both, strict=True)],
            "identity": tables.identity(results, sources),
            "versions": tables.version_rows(results, summaries),
            "lone": all(own.lone for own in found if own),
            "inputs": [tables.inputs(r) for r in results],
            "texts": [str(r.dataset.attrs.get("scenario_text", "")) for r in results],
            "commands": [f"wrsim run scenario.toml -o {shlex.quote(source or 'run')}" for source in sources],
            "assessment": rows,
            "rules": " / ".join(dict.fromkeys(own.rules.title for own in found if own)),
            "limits_from": sources_of_limits,
            "estimated": any(cell and cell["estimate"] for row in rows for cell in row["cells"]),
            "to_confirm": any(cell and cell["star"] for row in rows for cell in row["cells"]) and TO_CONFIRM,
            "notes": [(name, own.notes) for name, own in zip(names, found, strict=True) if own and own.notes],
            "tracks": [_track(r.dataset, own) for r, own in zip(results, found, strict=True)],
            "data": charts,
            "pictures": [as_picture(n, make()) for n, make in ({} if charts else _standard(results, names)).items()],
            "cards": tables.cards(summaries, names),
            "apart": tables.apart(results, names),
            "curves": tables.curves(summaries, names),
            "numbers": tables.numbers(results, summaries, names),
            "contacts": contacts,
            "wear": [_wear(r, name) for r, name in zip(results, names, strict=True) if has_wear(r.dataset)],
            "vibrations": [_vibrations(r, name) for r, name in zip(results, names, strict=True)],
            "ride": [ride.table(name) for name, ride in ridden.items()],
            "ride_notes": [why for _, why in rides if why],
            "bands": [as_picture("third octaves of the accelerations", make()) for make in bands],
            "events": tables.event_table(results, summaries, names),
            "viewers": list(zip(names, viewers, strict=False)),
            "histories": list(histories),
        }
        page["drawn"] = {name: _as_webp(content) for name, content in finish().items()}
    return page_template("report.html").render(page)


@cache
def _environment() -> jinja2.Environment:
    loader = jinja2.PackageLoader("wrsim.report", "templates")
    own = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    own.filters["table"] = as_html
    own.policies["json.dumps_kwargs"] = {"sort_keys": False, "separators": (",", ":"), "allow_nan": False}
    own.filters["css"] = css_text
    own.globals |= {"text_of": text_of, "hashes": hashes, "together": together}
    return own


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


def _track(dataset: xr.Dataset, found: Assessment | None) -> tuple[str, str] | None:
    """The track of a run as a picture, with words for its sections; None where the run knows no curvature."""
    if "curvature" not in dataset or dataset.sizes.get("time", 0) < 2 or np.ptp(dataset["distance"].values) < 1e-9:
        return None
    sections = found.sections if found else ()
    ends = (f"{formatted(s.start, '.0f')} to {quantity(s.end, 'm', '.0f')}" for s in sections)
    words = [f"section {s.number}: {s.label}, {places}" for s, places in zip(sections, ends, strict=True)]
    return as_picture("; ".join(words) or "curvature and cant", track_diagram(dataset, sections))


def _histories(results: Sequence[Result], names: Sequence[str], found: Sequence[Assessment | None]) -> Makers:
    """Pictures of histories for print and for readers without scripts; several results over each other: the wheelset
    that has the largest Y/Q in the first of them."""
    if len(results) == 1:
        return ({"as assessed": partial(history_figure, found[0])} if found[0] else {}) | _standard(results, names)
    worst = worst_wheelset(results[0].dataset)
    having = [(r.dataset, name) for r, name in zip(results, names, strict=True) if worst in wheelsets(r.dataset)]
    datasets = [of_wheelset(dataset, worst) for dataset, _ in having]
    return {f"wheelset {worst}": partial(overlay_figure, datasets, [name for _, name in having])}


def _standard(results: Sequence[Result], names: Sequence[str]) -> dict[str, Callable[[], Figure]]:
    """The standard pictures of results, but those of contacts and wear, which have sections of their own."""
    return {
        f"{name}: {picture}" if name else picture: make
        for r, name in zip(results, names, strict=True)
        for picture, make in standard_figures(r.dataset).items()
        if not picture.endswith(("patches", "sections", "wear", "fatigue", "bent", "fast"))
    }


def _contacts(dataset: xr.Dataset, result: str) -> list[dict[str, Any]]:
    """Contacts of all wheelsets at some of their snapshots: pictures, numbers, and how many of the moments."""
    if not has_patches(dataset) or not has_outlines(dataset):
        return []
    found = []
    for name, label in numbered(wheelsets(dataset)).items():
        one = of_wheelset(dataset, name)
        moments, total = choose_moments(one, MOST_MOMENTS), one.sizes[moment_dim(one)]
        galleries = {"wheel on rail": section_gallery, "patches from above": patch_gallery}
        own: dict[str, Any] = {"numbers": tables.contacts(one, moments), "open": name == worst_wheelset(dataset)}
        own["name"] = label + (f": {len(moments)} of {total} moments" if len(moments) < total else "")
        makers = ((f"{result} {label} {what}".strip(), make) for what, make in galleries.items())
        found.append(own | {"makers": {words: partial(make, one, moments) for words, make in makers}})
    return found


def _vibrations(result: Result, name: str) -> dict[str, Any]:
    """What bends, and spectra of the fast channels: of the displacements of rails those of their acceleration."""
    from wrsim.analysis.spectra import evaluate_spectra

    words = {"bent": "rails and axles, magnified", "fast": "fast channels"}
    drawn = {name.rpartition("/")[2]: make for name, make in standard_figures(result.dataset).items()}
    pictures = [as_picture(own, drawn[name]()) for name, own in words.items() if name in drawn]
    fast = [str(n).removeprefix("fast_") for n in result.dataset.data_vars if str(n).startswith("fast_")]
    found = [
        tables.evaluated(partial(evaluate_spectra, channel=c, derivative=2 * c.startswith("rail_")), result)
        for c in fast
    ]
    data = [own for own, _ in found if own is not None]
    pictures += [as_picture(f"spectra of {own.attrs['channel']}", spectra_figure(own)) for own in data]
    notes = dict.fromkeys(why for _, why in found if why)
    return {"tables": [spectra_table(own, name) for own in data], "pictures": pictures, "notes": list(notes)}


def _wear(result: Result, name: str) -> dict[str, Any]:
    figures = {"depths over the profiles": wear_figure, "rolling contact fatigue": fatigue_figure}
    pictures = [as_picture(words, make(result.dataset)) for words, make in figures.items()]
    return {"name": name, "tables": tables.wear_tables(result.dataset), "pictures": pictures}


def as_picture(name: str, figure: Figure) -> tuple[str, str]:
    """A figure for a page: its name in words, and its SVG as a data address."""
    return name.replace("_", " "), _address("svg+xml", rendered(figure, "svg"))


def _as_webp(png: bytes) -> str:
    """The same picture without loss, in a fraction of the bytes: a page is mailed."""
    stream = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").save(stream, "webp", lossless=True, quality=20)
    return _address("webp", stream.getvalue())


def _address(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
