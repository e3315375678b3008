"""The report of wheels that wear in service: one page with profiles, depths, flange and conicity."""

from __future__ import annotations

import shlex

import xarray as xr

from wrsim import __version__
from wrsim.plots.service import FIGURES
from wrsim.report.page import as_picture, template
from wrsim.results.table import Table, quantity

TEXTS = {"service_text": "Service file", "cases_text": "Table of cases", "scenario_text": "Scenario"}
"""Files that a service holds, and words for them."""


def service_page(dataset: xr.Dataset, source: str, numbers: Table) -> str:
    """The report of a service as HTML.

    dataset: ``wear.nc``; source: where it was read from; numbers: of it against the mileage.
    """
    about = dataset.attrs
    steps = dataset.sizes["point"] - 1
    mileage = quantity(1e-3 * float(dataset["mileage"].values[-1]), "km", ".6g")
    deepest = quantity(1e3 * float(dataset["deepest"].values[-1]), "mm", ".3g")
    identity = [(key, str(about[key])) for key in ("title", "law", "wheel") if key in about]
    identity += [("file", source), ("steps of wear", str(steps)), ("mileage", mileage)]
    versions = sorted(key for key in about if key.endswith("_version"))
    page = {
        "title": about["title"],
        "version": __version__,
        "verdict": f"{mileage} in {steps} steps; {deepest} worn off at the deepest place.",
        "identity": identity + [(key.removesuffix("_version"), str(about[key])) for key in versions],
        "numbers": numbers,
        "pictures": [as_picture(name, make(dataset)) for name, make in FIGURES.items()],
        "command": f"wrsim wear service.toml -o {shlex.quote(source.rstrip('/').rsplit('/', 1)[-1] or 'service')}",
        "texts": {words: str(about[key]) for key, words in TEXTS.items() if about.get(key)},
    }
    return template("service.html").render(page)
