"""A result in a few lines: for the interpreter, and as a card for notebooks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from markupsafe import Markup

from wrsim.results import render
from wrsim.results.moments import has_patches, with_patches
from wrsim.results.summary import wheel_peaks
from wrsim.results.summary_tables import vehicle_table
from wrsim.results.table import Column, Table, formatted, quantity
from wrsim.results.wheelsets import of_wheelset, wheelsets

MOST = 8
"""Wheelsets and kept moments that are listed."""


def result_text(dataset: xr.Dataset) -> str:
    """A result in a few lines."""
    return "\n".join([f"<Result: {dataset.attrs['title']}>", render.as_text(_tables(dataset))])


def result_html(dataset: xr.Dataset) -> str:
    """The same as a card; every text of the user's is escaped."""
    title = Markup("<strong>{}</strong>").format(str(dataset.attrs["title"]))
    return Markup("<div>{}{}</div>").format(title, Markup("").join(map(render.as_html, _tables(dataset))))


def _tables(dataset: xr.Dataset) -> list[Table]:
    """What was computed, and the peaks of every wheel."""
    about = Table("", (Column(), Column()), list(_about(dataset)))
    names = wheelsets(dataset)[:MOST]
    summaries = [wheel_peaks(of_wheelset(dataset, name)) for name in names]
    known = any(name in dataset for name in ("Y", "Q", "p0"))
    return [about, vehicle_table("", names, summaries)] if known else [about]


def _about(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """What was computed, how far it came, what there is."""
    attributes, sizes = dataset.attrs, dataset.sizes
    ending = f"stopped: {attributes['stop_reason']}" if attributes["status"] == "stopped" else "completed"
    yield "analysis", f"{attributes['analysis']}, {ending}"
    if "time" in dataset.dims:
        words = f"{sizes['time']} instants"
        if sizes["time"] and "distance" in dataset.coords:
            first, last = dataset["distance"].values[[0, -1]]
            words += f", {quantity(float(np.ptp(dataset['time'].values)), 's')}"
            words += f", {formatted(float(first), '.1f')} to {quantity(float(last), 'm', '.1f')}"
        yield "samples", words
    else:
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        words = f"{sizes['pose']} pose{'s' * (sizes['pose'] != 1)}"
        yield "samples", words + (f", {unsolved} of them without a solution" if unsolved else "")
    yield "wheelsets", _listed(list(wheelsets(dataset)))
    if has_patches(dataset):
        if "snapshot_distance" in dataset:
            yield "patches", _listed([formatted(float(d), ".1f") for d in dataset["snapshot_distance"].values]) + " m"
        else:
            yield "patches", _listed([str(name) for name in dataset["pose"].values[with_patches(dataset)]])


def _listed(names: list[str]) -> str:
    return ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")
