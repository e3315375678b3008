"""The viewer of one result: wheels on their rails and the vehicle on its track, one page that needs nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wrsim import __version__
from wrsim.errors import InputError, in_one_line
from wrsim.report.page import template
from wrsim.report.view_data import view_data
from wrsim.results import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wrsim.scenario.build import Setup


def view_page(result: Result, folder: Path, models: Sequence[Path] = ()) -> str:
    """The viewer as HTML.

    folder, models: where the model files of the scenario are looked up; where they are missing, the page shows what the
    result alone holds and says so. Raises InputError for a result with nothing to look at.
    """
    setup, why = setup_of(result, folder, models)
    data = view_data(result, setup, why)
    page: dict[str, Any] = {
        "title": result.title,
        "version": __version__,
        "numbers": "run" in data,
        "data": data,
    }
    return template("view.html").render(page)


def setup_of(result: Result, folder: Path, models: Sequence[Path] = ()) -> tuple[Setup[Any] | None, str]:
    """The set-up of a result's scenario, or None and why it cannot be had."""
    from wrsim.scenario.build import build
    from wrsim.scenario.loading import load_text

    try:
        text = str(result.dataset.attrs.get("scenario_text", ""))
        return build(load_text(text, folder, models, closed=True)), ""
    except InputError as problem:
        why = in_one_line(problem)
        return None, f"The scenario of the result cannot be set up here, so there is no vehicle to show: {why}"
