"""A result in a few lines: for the interpreter, and as a card for notebooks."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Any

import xarray as xr

from wrsim.results.moments import has_patches, with_patches
from wrsim.results.summary import peak
from wrsim.results.wheelsets import of_wheelset, wheelsets

PEAKS = {"Y": "Y kN", "Q": "Q kN", "Y_over_Q": "Y/Q", "p0": "p0 MPa"}
"""Channels whose largest values are shown, and their headings."""
MOST = 8
"""Wheelsets and kept moments that are listed."""

Line = tuple[str, str]
"""What it is, in words."""


def as_text(dataset: xr.Dataset) -> str:
    """A result in a few lines."""
    head = f"<Result: {dataset.attrs['title']}>"
    rows = [[f"  {name}", words] for name, words in _facts(dataset)]
    table = _peaks(dataset)
    lines = [head, *(f"{name:<12}{words}" for name, words in rows)]
    if len(table) > 1:
        widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]
        for row in table:
            cells = (f"{c:<{w}}" if i < 2 else f"{c:>{w}}" for i, (c, w) in enumerate(zip(row, widths, strict=True)))
            lines.append("  " + "  ".join(cells).rstrip())
    return "\n".join(lines)


def as_html(dataset: xr.Dataset) -> str:
    """The same as a card; every text of the user's is escaped."""

    def row(cells: list[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag} style='text-align:left'>{escape(c)}</{tag}>" for c in cells) + "</tr>"

    facts = "".join(row([name, words], "td") for name, words in _facts(dataset))
    table = _peaks(dataset)
    peaks = row(table[0], "th") + "".join(row(cells, "td") for cells in table[1:]) if len(table) > 1 else ""
    title = escape(str(dataset.attrs["title"]))
    return (
        f"<div><strong>{title}</strong><table>{facts}</table>" + (f"<table>{peaks}</table>" if peaks else "") + "</div>"
    )


def _facts(dataset: xr.Dataset) -> Iterator[Line]:
    """What was computed, how far it came, what there is."""
    attributes, sizes = dataset.attrs, dataset.sizes
    ending = f"stopped: {attributes['stop_reason']}" if attributes["status"] == "stopped" else "completed"
    yield "analysis", f"{attributes['analysis']}, {ending}"
    if "time" in dataset.dims:
        words = f"{sizes['time']} instants"
        if sizes["time"] and "distance" in dataset.coords:
            first, last = dataset["distance"].values[[0, -1]]
            words += f", {dataset['time'].values[-1] - dataset['time'].values[0]:.4g} s, {first:z.1f} to {last:z.1f} m"
        yield "samples", words
    else:
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        words = f"{sizes['pose']} pose{'s' * (sizes['pose'] != 1)}"
        yield "samples", words + (f", {unsolved} of them without a solution" if unsolved else "")
    yield "wheelsets", _listed(list(wheelsets(dataset)))
    if has_patches(dataset):
        if "snapshot_distance" in dataset:
            yield "patches", _listed([f"{d:.1f}" for d in dataset["snapshot_distance"].values]) + " m"
        else:
            yield "patches", _listed([str(name) for name in dataset["pose"].values[with_patches(dataset)]])


def _listed(names: list[str]) -> str:
    return ", ".join(names[:MOST]) + (f" and {len(names) - MOST} more" if len(names) > MOST else "")


def _peaks(dataset: xr.Dataset) -> list[list[str]]:
    """A heading, and for every wheel its largest values."""
    names = [name for name in PEAKS if name in dataset]
    if not names:
        return []
    rows = [["wheelset", "wheel", *(f"largest {PEAKS[name]}" for name in names)]]
    for wheelset in wheelsets(dataset)[:MOST]:
        one = of_wheelset(dataset, wheelset)
        for wheel in map(str, dataset["wheel"].values):
            rows.append([wheelset, wheel, *(_shown(peak(one, name, wheel, largest_magnitude=True)) for name in names)])
    return rows


def _shown(found: dict[str, Any] | None) -> str:
    return "-" if found is None else f"{found['value']:.4g}"
