"""Pages and pictures: reports, the viewer, figures of results and tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from wrsim.api import options
from wrsim.api.options import AnyPath, Argument, Option, ResultLike, documented, into
from wrsim.api.outcome import Outcome, as_list, as_result, folder_beside, name_of, paths_in
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.report.document import Cover


@documented
def write_report(
    results: Annotated[
        options.ResultsLike,
        Argument("Results: files, folders, cut-off runs; one study or evolution.", "RESULT...", kind=list[Path]),
    ],
    file: Annotated[AnyPath, into("The page; report.html beside the first result unless given.", "HTML")] = None,
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
    Versions and digests are in its appendix.

    Raises
    ------
    InputError
        For files that are no results, or not of one kind.
    """
    from wrsim.report.document import Cover, logo_address
    from wrsim.results import write_atomically

    several, picture = as_list(results), logo_address(Path(logo)) if logo else ""
    page = _page_of(several, with_view, list(map(Path, models)), Cover(title, author, company, date, picture))
    target = Path(file) if file is not None else folder_beside(several[0]) / "report.html"
    return Outcome([], {}, [write_atomically(target, page.encode())])


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
    token = LOOK.set(look_of(formats, width_mm, font, style))
    try:
        with shown_in(units) if units is not None else nullcontext():
            yield
    finally:
        LOOK.reset(token)


@documented
def draw_track(
    file: Annotated[str | Path, Argument("Scenario or track file (TOML).", "FILE")],
    picture: Annotated[str | Path, into("The picture.", "PNG|SVG|PDF", default="<FILE>_track.png")],
    models: options.Models = (),
) -> Outcome:
    """Draw the track of a scenario or of a track file: plan, curvature, cant, gauge, height, irregularities.

    Returns
    -------
    Outcome
        ``value`` is the Track.
    """
    from wrsim.report.outputs import draw_model
    from wrsim.scenario.track_build import track_model

    track = track_model(Path(file), models)
    return Outcome([], {}, [draw_model("track", Path(picture), track)], track)
