"""Pages and pictures: reports, the viewer, figures of results and tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from wrsim.api.outcome import Given, Outcome, as_list, as_result, folder_beside, paths_among
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.report.document import Cover


def write_report(
    results: Given | Sequence[Given], file: str | Path | None = None, *, title: str = "", author: str = "",
    company: str = "", logo: str | Path | None = None, date: str = "", with_view: bool = False,
    models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Write a page about a result, several results beside each other, a study, or a profile evolution.

    Parameters
    ----------
    results : Result, path, or a sequence of these
        Results of runs; or the folder of a study or a profile evolution.
    file : str or Path, optional
        The page; report.html beside the first result unless given.
    title, author, company, date : str
        On its head; the titles of the results and today's date unless given.
    logo : str or Path, optional
        A picture, .png, .svg or .jpg.
    with_view : bool
        Whether the viewer of each result is inside.
    models : sequence of str or Path
        Folders with model files of your own, for the viewer.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For files that are no results, or not of one kind.
    """
    from wrsim.report.document import Cover, logo_address
    from wrsim.results import write_atomically

    several, picture = as_list(results), logo_address(Path(logo)) if logo else ""
    page = _page_of(several, with_view, list(map(Path, models)), Cover(title, author, company, date, picture))
    target = Path(file) if file is not None else folder_beside(several[0], None) / "report.html"
    return Outcome([], {}, [write_atomically(target, page.encode())])


def _page_of(given: Sequence[Given], with_view: bool, models: Sequence[Path], cover: Cover) -> str:
    """The page about results of runs, a study or a profile evolution; with_view: with viewers of the results inside."""
    from wrsim.results.files import EVOLUTION, STUDY, holds
    from wrsim.results.units import in_page

    for path in paths_among(*given):
        kind = "study" if holds(path, STUDY) else "profile evolution" if holds(path, EVOLUTION) else ""
        if not kind:
            continue
        if len(given) > 1:
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

    results = [as_result(each) for each in given]
    names = [str(each) if isinstance(each, str | Path) else each.title for each in given]
    pairs = zip(results, given, strict=True)
    viewers = [view_page(r, folder_beside(each, None), models) for r, each in pairs] if with_view else []
    return in_page(report_page(results, names, viewers=viewers, cover=cover))


def write_view(result: Given, file: str | Path | None = None, models: Sequence[str | Path] = ()) -> Outcome:
    """Write a page to look at a run: wheels on their rails, the vehicle on its track, modes.

    Parameters
    ----------
    result : Result, str or Path
        A result of a run or of a stability analysis.
    file : str or Path, optional
        The page; view.html beside the result unless given.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For a result that has nothing to look at.
    """
    from wrsim.report.view_data import view_page
    from wrsim.results import write_atomically

    folder = folder_beside(result, None if file is None else Path(file).parent)
    beside = folder_beside(result, None) if paths_among(result) else folder
    page = view_page(as_result(result), beside, list(map(Path, models)))
    return Outcome([], {}, [write_atomically(folder / "view.html" if file is None else Path(file), page.encode())])


def write_pictures(
    result: Given, output: str | Path | None = None, at: Sequence[str] = (), wheelset: str | None = None
) -> Outcome:
    """Draw the pictures of a result, or the contact patches at chosen places only.

    Parameters
    ----------
    result : Result, str or Path
        Any result.
    output : str or Path, optional
        Folder; beside the result unless given.
    at, wheelset
        Distances [m] or poses, and one of several wheelsets. `wrsim.look` chooses kinds of files, width and style.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For places and wheelsets that there are not.
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


@contextmanager
def look(
    formats: str = "png", width_mm: float | None = None, font: str = "", style: str = "", units: str | None = None
) -> Iterator[None]:
    """How all pictures that are drawn in the block look, and the units of tables, pictures and pages in it.

    Parameters
    ----------
    formats : str
        Kinds of files, ``"png"``, ``"svg"``, ``"pdf"``, with commas between; pictures whose file is named by its whole
        name are of the kind of its ending.
    width_mm : float, optional
        Width [mm] from 60 to 500; 170 unless given.
    font, style : str
        A family of letters; a style file of matplotlib, or one of its styles.
    units : str, optional
        ``"metric"`` or ``"us"`` (ft, in, mph, kip, degrees of curve).

    Returns
    -------
    AbstractContextManager
        Pictures outside of its block look as before.

    Raises
    ------
    InputError
        For what there is not.
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


def draw_track(file: str | Path, picture: str | Path, models: Sequence[str | Path] = ()) -> Outcome:
    """Draw the track of a scenario or of a track file: plan, curvature, cant, gauge, height, irregularities.

    Parameters
    ----------
    file, picture : str or Path
        The scenario or track file; where it is drawn, .png, .svg or .pdf.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        ``found`` is the Track.

    Raises
    ------
    InputError
        For a file that is neither.
    """
    from wrsim.report.outputs import draw_model
    from wrsim.scenario.track_build import track_model

    found = track_model(Path(file), models)
    return Outcome([], {}, [draw_model("track", Path(picture), found)], found)
