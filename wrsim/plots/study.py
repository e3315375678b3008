"""Pictures of a study: maps over two axes, families of curves, distributions, outputs against what was sampled.

Only completed cases count; what derailed, or has no result, is marked where it lies.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import cycle
from math import ceil
from textwrap import wrap
from typing import Any

import numpy as np
import scipy
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from wrsim.inputs.section import UNITS, unit_of
from wrsim.plots.marks import note, panels
from wrsim.plots.theme import DOTS, GROUP_MARK, INK, QUIET, SERIES_COLOURS, STOP_COLOUR, pressure_map
from wrsim.results.channels import SHOWN
from wrsim.results.sensitivity import METHODS, by_output, sensitivity_in
from wrsim.results.table import formatted, with_unit

MOST_OUTPUTS, MOST_LINES, MOST_KEYS = 12, 8, 4
"""Panels of a picture, lines of a panel, varied keys against which outputs are drawn."""
ACROSS, PANEL, LETTERS = 3, 46.0, 30
"""Panels in a row, their height [mm], letters of a line above or below one."""
ENOUGH = 8  # completed cases from which a distribution is drawn
PERCENTILES = (5, 50, 95)
COMPLETED, DERAILED = "completed", "derailed"


def study_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures that suit the axes of a study, by name: maps, curves, samples, percentiles."""
    outputs = numbers_in(dataset)
    if not outputs:
        return {}
    makers: dict[str, Callable[[], Figure]] = {}
    grids = grid_axes(dataset)
    numeric = [dim for dim in grids if dataset[dim].dtype.kind == "f"]
    if len(numeric) >= 2:
        makers["maps"] = partial(maps_figure, dataset, outputs, numeric[:2])
    if grids:
        makers["curves"] = partial(curves_figure, dataset, outputs, (numeric or grids)[0])
    coordinates = [str(n) for n, c in dataset.coords.items() if n not in dataset.dims and c.dtype.kind == "f"]
    if sampled := [name for name in coordinates if np.unique(dataset[name].values).size > 1]:
        makers["samples"] = partial(samples_figure, dataset, outputs, sampled[:MOST_KEYS])
    if (sensitivity := sensitivity_in(dataset)) and sensitivity["indices"]:
        makers["sensitivity"] = partial(sensitivity_figure, dataset, sensitivity)
    if int((dataset["status"] == COMPLETED).sum()) >= ENOUGH:
        makers["percentiles"] = partial(percentiles_figure, dataset, outputs)
    return makers


def numbers_in(dataset: xr.Dataset) -> list[str]:
    """Names of the outputs that have a number in some completed case."""
    done = (dataset["status"] == COMPLETED).values
    numbers = [str(n) for n, v in dataset.data_vars.items() if v.dtype.kind == "f" and v.dims == dataset["status"].dims]
    return [name for name in numbers if np.isfinite(dataset[name].values[done]).any()]


def of_cases(dataset: xr.Dataset, name: str) -> NDArray[Any]:
    """A variable or a coordinate, one entry a case."""
    status = dataset["status"]
    return np.asarray(dataset[name].broadcast_like(status).transpose(*status.dims)).ravel()


def grid_axes(dataset: xr.Dataset) -> list[str]:
    """Axes of one key with several values, the longest first."""
    dims = [str(d) for d in dataset["status"].dims if "key" in dataset[d].attrs and dataset.sizes[d] > 1]
    return sorted(dims, key=lambda d: -dataset.sizes[d])


def maps_figure(dataset: xr.Dataset, outputs: Sequence[str], dims: Sequence[str]) -> Figure:
    """Every output over two axes, x the longer one; the median over all further axes. Derailed cases are crossed."""
    x, y = dims
    sorted_ = dataset.sortby(list(dims))
    across, up = sorted_[x].values, sorted_[y].values
    left = [d for d in dataset["status"].dims if d not in dims]
    rows, columns = np.nonzero((sorted_["status"] != COMPLETED).mean(left).transpose(y, x).values > 0.0)

    def draw(axes: Axes, name: str) -> None:
        values = np.ma.masked_invalid(_completed(sorted_, name).median(left).transpose(y, x).values)
        mesh = axes.pcolormesh(across, up, values, cmap=pressure_map(), shading="nearest")
        bar = axes.figure.colorbar(mesh, ax=axes, pad=0.02, aspect=18)
        bar.outline.set_linewidth(0.4)  # type: ignore[operator]
        bar.ax.tick_params(labelsize=6.0)
        look: Any = {"linestyle": "none", "color": STOP_COLOUR, "markersize": 3.0, "markeredgewidth": 0.7}
        axes.plot(across[columns], up[rows], "x", **look)
        axes.set_title(label_of(dataset, name), fontsize=7.0)
        axes.set(xlabel=axis_label(dataset, x), ylabel=axis_label(dataset, y))
        axes.grid(False)

    return _figure(dataset, outputs, draw, "median over the other axes" if left else "")


def curves_figure(dataset: xr.Dataset, outputs: Sequence[str], x: str) -> Figure:
    """Every output over one axis, a line for every value of the second one; bands: range over all further axes."""
    numeric = dataset[x].dtype.kind == "f"
    sorted_ = dataset.sortby(x) if numeric else dataset
    place = sorted_[x].values if numeric else np.arange(dataset.sizes[x])
    family = next((d for d in grid_axes(dataset) if d != x), None)
    rest = [d for d in dataset["status"].dims if d not in (x, family)]
    size = 1 if family is None else dataset.sizes[family]
    chosen = np.unique(np.linspace(0, size - 1, min(size, MOST_LINES)).round().astype(int))
    lost = (sorted_["status"] != COMPLETED).any([d for d in dataset["status"].dims if d != x]).values
    pairs = zip(chosen, cycle(SERIES_COLOURS), cycle(GROUP_MARK))
    looks: list[dict[str, Any]] = [{"color": colour, "marker": mark} for _, colour, mark in pairs]

    def draw(axes: Axes, name: str) -> None:
        for look, i in zip(looks, chosen, strict=True):
            values = _completed(sorted_, name)
            if family is not None:
                values = values.isel({family: int(i)})
            if rest:
                band: Any = {"color": look["color"], "alpha": 0.15, "linewidth": 0.0}
                axes.fill_between(place, values.min(rest), values.max(rest), **band)
            axes.plot(place, values.median(rest), linewidth=0.9, **look)
        if not numeric:
            axes.set_xticks(place, [str(v) for v in sorted_[x].values], fontsize=6.0, rotation=20, ha="right")
        for case in place[lost]:
            axes.axvline(case, color=STOP_COLOUR, linewidth=0.5, linestyle=DOTS)
        axes.set_xlabel(axis_label(dataset, x))
        axes.set_title(label_of(dataset, name), fontsize=7.0)

    entries: list[Line2D] = []
    if family is not None:
        title = axis_label(dataset, family) + (f" ({len(chosen)} of {size})" if len(chosen) < size else "")
        labels = (formatted(value, ".6g") for value in dataset[family].values[chosen].tolist())
        entries = [Line2D([], [], label=label, **look) for label, look in zip(labels, looks, strict=True)]
        entries.insert(0, Line2D([], [], linestyle="none", label=title))
    return _figure(dataset, outputs, draw, "median and range over the other axes" if rest else "", entries)


def samples_figure(dataset: xr.Dataset, outputs: Sequence[str], keys: Sequence[str]) -> Figure:
    """Every output (rows) against every key that was sampled (columns), with the rank correlation of both."""
    shown = outputs[: MOST_OUTPUTS // 2]
    done = (dataset["status"] == COMPLETED).values.ravel()

    def draw(axes: Axes, name: str, key: str) -> None:
        x, values = of_cases(dataset, key), dataset[name].values.ravel()
        good = done & np.isfinite(values)
        axes.plot(x[good], values[good], ".", color=SERIES_COLOURS[0], markersize=2.4)
        for case in x[~done]:
            axes.axvline(case, ymax=0.05, color=STOP_COLOUR, linewidth=0.7)
        constant = good.sum() < 3 or np.ptp(x[good]) == 0.0 or np.ptp(values[good]) == 0.0
        rank = 0.0 if constant else scipy.stats.spearmanr(x[good], values[good]).statistic
        axes.set_title(f"rank correlation {formatted(float(rank), '.2f')}", fontsize=6.0, color=QUIET)
        if key == keys[0]:
            axes.set_ylabel(label_of(dataset, name), fontsize=6.5)
        if name == shown[-1]:
            axes.set_xlabel(axis_label(dataset, key), fontsize=6.5)

    draws = [partial(draw, name=name, key=key) for name in shown for key in keys]
    title, note, height = str(dataset.attrs["title"]), _note(dataset, outputs, shown), 16.0 + 32.0 * len(shown)
    return panels(title, draws, height, columns=len(keys), share=False, note=note)


def sensitivity_figure(dataset: xr.Dataset, table: Mapping[str, Any]) -> Figure:
    """Indices of every output as bars with their intervals, the key that decides most on top."""
    kinds = METHODS[table["method"]]
    outputs = by_output(table)
    shown = list(outputs)[:MOST_OUTPUTS]

    def draw(axes: Axes, name: str) -> None:
        keys = outputs[name]
        for j, kind in enumerate(kinds):
            rows = [indices[kind] for _, indices in keys]
            value, low, high = (np.array([row[end] for row in rows], dtype=float) for end in ("value", "low", "high"))
            y = np.arange(len(rows)) + (j - 0.5 * (len(kinds) - 1)) * 0.36
            axes.barh(y, value, height=0.34, color=SERIES_COLOURS[j], alpha=0.55, linewidth=0.0)
            axes.hlines(y, low, high, color=INK, linewidth=0.8)
        labels = ["\n".join(wrap(key.partition(".")[2], LETTERS + 10)) for key, _ in keys]  # without the table
        axes.set_yticks(range(len(keys)), labels, fontsize=6.0)
        axes.set(ylim=(len(keys) - 0.4, -0.6), title=label_of(dataset, name), xlabel=f"Sensitivity ({table['method']})")
        axes.axvline(0.0, color=QUIET, linewidth=0.6)
        axes.grid(axis="y", visible=False)

    legend = [Patch(color=SERIES_COLOURS[j], alpha=0.55, label=kind) for j, kind in enumerate(kinds.values())]
    most = max(len(outputs[name]) for name in shown)
    draws, height = [partial(draw, name=name) for name in shown], 30.0 + (14.0 + 7.0 * most) * ceil(len(shown) / 2)
    columns = min(2, len(shown))
    return panels(str(dataset.attrs["title"]), draws, height, columns=columns, share=False, legend=legend)


def percentiles_figure(dataset: xr.Dataset, outputs: Sequence[str]) -> Figure:
    """Share of the completed cases below a value, for every output, with the percentiles 5, 50 and 95."""

    def draw(axes: Axes, name: str) -> None:
        values = np.sort(_completed(dataset, name).values.ravel())
        values = values[np.isfinite(values)]
        share = 100.0 * np.arange(1, values.size + 1) / values.size
        axes.step(values, share, where="post", color=SERIES_COLOURS[0])
        for percentile, quantile in zip(PERCENTILES, np.percentile(values, PERCENTILES), strict=True):
            axes.plot([quantile, quantile], [0.0, percentile], color=INK, linewidth=0.6, linestyle=(0, (2, 2)))
            box = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8}
            point, label = (quantile, percentile), formatted(float(quantile))
            note(axes, label, point, (3.0, -6.0), fontsize=6.0, color=INK, bbox=box)
        axes.set(xlabel=label_of(dataset, name), ylabel="cases below [%]", ylim=(0.0, 102.0))
        axes.set_yticks((0, 25, 50, 75, 100))

    return _figure(dataset, outputs, draw)


def label_of(dataset: xr.Dataset, name: str) -> str:
    """Name of an output with its unit."""
    unit = str(dataset[name].attrs.get("units", "1"))
    ending = name.rpartition("_")
    repeated = {shown.suffix for shown in SHOWN.values() if shown.symbol == unit and shown.suffix}
    label = ending[0] if ending[2] in repeated else name
    label = label.replace("wheelsets_", "").replace("wheels_", "").replace("_", " ")
    return "\n".join(wrap(with_unit(label, unit), LETTERS))


def axis_label(dataset: xr.Dataset, name: str) -> str:
    """Name of an axis, or of what is sampled: the last part of its key, with its unit."""
    stem, _, last = name.rpartition(".")
    number = f" {last}" if last.isdecimal() else ""  # one of several
    last = stem.rpartition(".")[2] if number else last
    unit = unit_of(last)
    return with_unit(last.removesuffix(f"_{unit}").replace("_", " ") + number, UNITS.get(unit, ""))


def _completed(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].where(dataset["status"] == COMPLETED)


def _figure(
    dataset: xr.Dataset,
    outputs: Sequence[str],
    draw: Callable[..., None],
    heading: str = "",
    legend: Sequence[Artist] = (),
) -> Figure:
    """A figure with a panel for every output, at most so many; what: of the values, in words."""
    drawn = outputs[:MOST_OUTPUTS]
    columns, note = min(ACROSS, len(drawn)), _note(dataset, outputs, drawn)
    title = "; ".join(filter(None, (str(dataset.attrs["title"]), heading)))
    draws, height = [partial(draw, name=name) for name in drawn], 24.0 + PANEL * ceil(len(drawn) / columns)
    return panels(title, draws, height, columns=columns, share=False, legend=legend, across=8, note=note)


def _note(dataset: xr.Dataset, outputs: Sequence[str], drawn: Sequence[str]) -> str:
    """How many cases and outputs are not drawn, and why."""
    done = of_cases(dataset, "status") == COMPLETED
    lacking = int(np.isnan([of_cases(dataset, name)[done] for name in drawn]).any(axis=0).sum())
    more = f"{len(drawn)} of {len(outputs)} outputs" if len(outputs) > len(drawn) else ""
    status, counts = np.unique(dataset["status"].values.astype(str), return_counts=True)
    lost = ", ".join(f"{n} {s}" for s, n in zip(status, counts, strict=True) if s != COMPLETED)
    remarks = (f"{lost} (red)" if lost else "", f"{lacking} completed lack a value" if lacking else "")
    cases = ", ".join(filter(None, remarks))
    return "; ".join(filter(None, (f"of {dataset['status'].size} cases {cases}" if cases else "", more)))
