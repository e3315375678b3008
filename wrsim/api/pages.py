"""Pages and pictures: reports, the viewer, figures of results and tracks."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Unpack

from wrsim.api import options
from wrsim.api.options import AnyPath, Argument, Option, Reading, ResultLike, documented, into
from wrsim.api.outcome import Outcome, as_list, as_result, as_scenario, folder_beside, name_of, paths_in
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.report.document import Cover


@documented
def write_report(
    results: Annotated[
        options.ResultsLike,
        Argument("Results: files, folders, cut-off runs; one study or evolution.", "RESULT...", kind=list[Path]),
    ],
    file: Annotated[
        AnyPath, into("The page, printed for .pdf; report.html beside the first result unless given.", "HTML|PDF")
    ] = None,
    *,
    title: Annotated[str, Option("Default: the titles of the results.", "TEXT")] = "",
    author: Annotated[str, Option("Named beneath the title.", "TEXT")] = "",
    company: Annotated[str, Option("Named beneath the title and on every page.", "TEXT")] = "",
    logo: Annotated[AnyPath, Option("A picture beside the title.", "PNG|SVG|JPG")] = None,
    date: Annotated[str, Option("Default: today.", "TEXT")] = "",
    with_view: Annotated[bool, Option("Embed the viewer of each result.", flags="--view")] = False,
    models: options.Models = (),
) -> Outcome:
    """Write a report about a result, several results beside each other, a study, or a profile evolution.

    It holds a summary, verdict, assessment, histories, contacts and wear; of a study outputs, pictures and cases.
    Versions and digests are in its appendix. A PDF needs Chromium, Chrome or Edge.

    Raises
    ------
    InputError
        For files that are no results, or not of one kind.
    """
    from wrsim.report.document import Cover, find_browser, logo_address, printed
    from wrsim.results import write_atomically

    several, picture = as_list(results), logo_address(Path(logo)) if logo else ""
    target = Path(file) if file is not None else folder_beside(several[0]) / "report.html"
    browser = find_browser(target) if target.suffix.lower() == ".pdf" else ""
    if browser and with_view:
        raise InputError(f"--view: {target} is printed, and a viewer needs a browser; write a page (.html) with it")
    page = _page_of(several, with_view, list(map(Path, models)), Cover(title, author, company, date, picture))
    return Outcome([], {}, [write_atomically(target, printed(page, browser, target) if browser else page.encode())])


def _page_of(results: Sequence[ResultLike], with_view: bool, models: Sequence[Path], cover: Cover) -> str:
    """The page about results of runs, a study or a profile evolution; with_view: with viewers of the results inside."""
    from wrsim.results.files import EVOLUTION, STUDY, holds
    from wrsim.results.units import in_page

    for path in paths_in(*results):
        kind = "study" if holds(path, STUDY) else "profile evolution" if holds(path, EVOLUTION) else ""
        if not kind:
            continue
        if len(results) > 1:
            raise InputError(f"{path}: is a {kind}: a report takes one {kind}, or results of runs")
        if with_view:
            raise InputError(f"--view: {path} is a {kind}; it is for results of runs, as each case of a {kind} is")
        from wrsim.report.study import evolution_page, study_page
        from wrsim.study import collect
        from wrsim.study.evolution import history

        if kind == "study":
            return in_page(study_page(collect.read_study(path), str(path), cover))
        dataset = history.read_history(path)
        return in_page(evolution_page(dataset, str(path), history.mileage_table(dataset), cover))
    from wrsim.report.page import report_page
    from wrsim.report.view_data import view_page

    loaded = [as_result(each) for each in results]
    pairs = zip(loaded, results, strict=True)
    viewers = [view_page(result, folder_beside(each), models) for result, each in pairs] if with_view else []
    return in_page(report_page(loaded, [name_of(each) for each in results], viewers=viewers, cover=cover))


@documented
def write_view(
    result: options.ResultFile,
    file: Annotated[AnyPath, into("The page; view.html beside the result unless given.", "HTML")] = None,
    models: options.Models = (),
) -> Outcome:
    """Write an interactive viewer: wheels on their rails, the vehicle on its track, modes of a stability analysis."""
    from wrsim.report.view_data import view_page
    from wrsim.results import write_atomically

    folder = folder_beside(result, None if file is None else Path(file).parent)
    beside = folder_beside(result) if paths_in(result) else folder
    page = view_page(as_result(result), beside, list(map(Path, models)))
    return Outcome([], {}, [write_atomically(folder / "view.html" if file is None else Path(file), page.encode())])


@documented
def write_live(
    files: Annotated[
        str | Sequence[str],
        Argument(
            'A scenario; or "contact" and profiles of wheels and rails, such as wheels/S1002.toml rails/60E1.toml.',
            "SCENARIO|contact FILE...",
            kind=list[str],
        ),
    ],
    file: Annotated[AnyPath, into("The page.", "HTML", default="<FILE>.html")] = None,
    *,
    gauge_mm: Annotated[float, Option("Gauge, 14 mm below the rail tops.", least=400.0, most=2000.0)] = 1435.0,
    flange_back_mm: Annotated[float, Option("Distance of the flange backs.", least=300.0, most=1900.0)] = 1360.0,
    inclination: Annotated[str, Option('Inclination of the rails: 1:40, 1:20 ... or "none".')] = "1:40",
    radius_mm: Annotated[float, Option("Radius of the wheels at the tape circle.", least=100.0, most=1500.0)] = 460.0,
    friction: Annotated[float, Option("Coefficient of friction to begin with.", least=0.0, most=0.8)] = 0.35,
    load_kN: Annotated[float, Option("Wheel load to begin with.", least=0.5, most=250.0)] = 60.0,
    values: options.Values = (),
    step: Annotated[
        float | None, "Step of the integration of a scenario [s]; None: one that holds over its run."
    ] = None,
    budget: options.Budget = None,
    models: options.Models = (),
    **reading: Unpack[Reading],
) -> Outcome:
    """Write a live page: a vehicle that runs, or a wheel to be dragged, turned and loaded on its rail.

    It contains a program and runs without network. A vehicle needs zig to be compiled (pip install ziglang).
    With "contact" every wheel is paired with every rail, by the strip model and Kik and Piotrowski's. --set,
    --step-ms and --budget are for scenarios, the options of profiles for contacts. Without --step-ms the step is 1 ms,
    halved until it holds: in 95 % of the steps of the run at most 1 % of the weight is left without balance.

    Returns
    -------
    Outcome
        ``files``; ``value`` has the pairs; of a scenario ``["step_s"]``.

    Raises
    ------
    InputError
        For other files, and for wheels without rails.
    """
    kind, *names = [files] if isinstance(files, str) else list(files)
    if kind != "contact":
        if names:
            raise InputError(f'{kind}: one scenario alone, or "contact" with profiles of wheels and rails behind it')
        of_contact = {
            "gauge_mm": gauge_mm, "flange_back_mm": flange_back_mm, "inclination": inclination, "radius_mm": radius_mm,
            "friction": friction, "load_kN": load_kN, **reading,
        }  # fmt: skip
        _refuse(of_contact, 'is for "contact"; a scenario has its own')
        return _live_vehicle(Path(kind), file, values, step, budget, models)
    _refuse({"values": values, "step": step, "budget": budget}, "is for a scenario, which contact has not")
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.contact.profiles.files import reading_options
    from wrsim.contact.profiles.models import readings_of
    from wrsim.report.live_contact import MOST_PAIRS, LivePair, contact_page
    from wrsim.results import write_atomically

    pairing = Pairing(flange_back_mm / 1e3, inclination, "none", models, reading)
    with reading_options(**reading):
        readings, faults = readings_of(names, None, models)
    if faults:
        raise InputError("\n".join(faults))
    profiles = {name: each.profile for name, each in readings.items()}
    wheels = {name: p for name, p in profiles.items() if p.kind == "wheel"}
    rails = {name: p.inclined(pairing.slope) for name, p in profiles.items() if p.kind == "rail"}
    if not wheels or not rails:
        raise InputError(f"{' '.join(names) or 'contact'}: at least one wheel and one rail are needed")
    if len(wheels) * len(rails) > MOST_PAIRS:
        raise InputError(f"{len(wheels)} wheels on {len(rails)} rails: a page takes at most {MOST_PAIRS} pairs")
    radius, gauge = radius_mm / 1e3, gauge_mm / 1e3
    pairs = [
        LivePair.usual(f"{w} on {r}{pairing.inclined}", wheel, rail, radius, gauge, pairing.spacing(wheel, wheel))
        for w, wheel in wheels.items()
        for r, rail in rails.items()
    ]
    title = pairs[0].name if len(pairs) == 1 else f"{', '.join(wheels)} on {', '.join(rails)}{pairing.inclined}"
    page = contact_page(pairs, title, friction, 1e3 * load_kN)
    target = Path(file) if file is not None else Path(f"{kind}.html")
    return Outcome([], {}, [write_atomically(target, page.encode())], value=pairs)


def _refuse(values: Mapping[str, Any], why: str) -> None:
    """Raise InputError for an option of a live page that is not as it is without being given."""
    for name, value in values.items():
        known = inspect.signature(write_live).parameters.get(name)
        if value != (known.default if known else None):
            flag = {"values": "set", "step": "step-ms"}.get(name, name.replace("_", "-"))
            raise InputError(f"--{flag}: {why}")


def _live_vehicle(
    scenario: Path,
    file: AnyPath,
    values: Sequence[str] | Mapping[str, Any],
    step: float | None,
    budget: float | None,
    models: Sequence[str | Path],
) -> Outcome:
    """The live page of a scenario."""
    from wrsim.report.live_vehicle import live_vehicle_page
    from wrsim.results import write_atomically

    loaded = as_scenario(scenario, models).with_set(values)
    page, bench = live_vehicle_page(loaded, step, budget)
    target = Path(file) if file is not None else Path(f"{scenario.stem}.html")
    lines = [f"{len(page) / 1e6:.1f} MB; steps of {1e3 * bench.step_size:g} ms", *filter(None, [bench.budget_line])]
    return Outcome([], {"step_s": bench.step_size}, [write_atomically(target, page.encode())], loaded, lines=lines)


@documented
def write_pictures(
    result: options.ResultFile,
    output: options.BesideResult = None,
    at: options.Places = (),
    wheelset: options.OneWheelset = None,
) -> Outcome:
    """Plot a result; --at: contact patches at given positions.

    Returns
    -------
    Outcome
        ``files``. `wrsim.look` chooses their kinds, width and style.
    """
    from wrsim.report.outputs import draw_pictures
    from wrsim.results.wheelsets import wheelset_folder, wheelsets, worst_wheelset

    loaded, directory = as_result(result), folder_beside(result, output)
    dataset = loaded.dataset
    if wheelset is not None or at:
        dataset = loaded.wheelset(wheelset or worst_wheelset(dataset))
        if output is None:
            directory /= wheelset_folder(wheelsets(loaded.dataset), str(dataset["wheelset"].item()))
    return Outcome([], {}, draw_pictures(dataset, at, directory))


@documented
@contextmanager
def look(
    formats: Annotated[str, Option("Kinds of pictures; default: png.", "png,svg,pdf", flags="--format")] = "png",
    width_mm: Annotated[float | None, Option("Width of pictures, 60 to 500; default: 170.", "MM")] = None,
    font: Annotated[str, Option("Font family, such as 'DejaVu Serif'.", "NAME")] = "",
    style: Annotated[str, Option("Style file, or a style of matplotlib.", "FILE")] = "",
    no_title: Annotated[bool, Option("Pictures without title and captions.", flags="--no-title")] = False,
    units: Annotated[
        str | None, Option("Units of tables, pictures, reports; default: of the scenario, or metric.", "metric|us")
    ] = None,
) -> Iterator[None]:
    """How all pictures that are drawn in the block look, and the units of tables, pictures and pages in it.

    Returns
    -------
    AbstractContextManager
        Pictures outside of its block look as before; those that are named as a whole are of the kind of its ending.
    """
    from wrsim.plots.theme import LOOK, NARROW, WIDE, look_of
    from wrsim.results.units import shown_in

    if width_mm is not None and not NARROW <= width_mm <= WIDE:
        raise InputError(f"--width-mm {width_mm:g}: must be from {NARROW:g} to {WIDE:g}")
    token = LOOK.set(look_of(formats, width_mm, font, style, not no_title))
    try:
        with shown_in(units) if units is not None else nullcontext():
            yield
    finally:
        LOOK.reset(token)


@documented
def draw_track(
    file: Annotated[str | Path, Argument("Scenario, track file (TOML), IFC, LandXML or railML file.", "FILE")],
    picture: Annotated[
        str | Path,
        into("The picture, or a civil file by its ending.", "PNG|SVG|PDF|IFC|XML", default="<FILE>_track.png"),
    ],
    models: options.Models = (),
    *,
    alignment: Annotated[str | None, Option("Which alignment of a civil file that has several.", "NAME")] = None,
) -> Outcome:
    """Draw the track of a scenario, a track file or a civil file, or export it to IFC or LandXML.

    The picture shows plan, curvature, cant, gauge, height and irregularities.

    Returns
    -------
    Outcome
        ``value`` is the Track.
    """
    from datetime import date

    from wrsim.report.outputs import draw_model
    from wrsim.results import write_atomically
    from wrsim.results.table import Table
    from wrsim.scenario.track_build import exported, track_model
    from wrsim.track.civil import ENDINGS

    track, target = track_model(Path(file), models, alignment), Path(picture)
    notes = [] if track.alignment is None else [f"alignment: {track.alignment.described}"]
    notes += [f"cant: {track.assumptions}"] if track.assumptions else []
    if target.suffix.lower() in ENDINGS:
        text, left_out = exported(track, target, date.today().isoformat())
        written, notes = write_atomically(target, text.encode()), [*notes, *left_out]
    else:
        written = draw_model("track", target, track)
    return Outcome([Table("", notes=tuple(notes))] if notes else [], {}, [written], track)
