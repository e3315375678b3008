"""Two results over each other: the first drawn through, the second dashed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.colours import INK, WHEEL_COLOUR
from wrsim.plots.marks import wheel_entries
from wrsim.plots.style import FULL_WIDTH, abscissa, headline, new_figure, shown, style
from wrsim.results import CHANNELS

CHANNELS_DRAWN = ("Y", "Q", "Y_over_Q", "T_gamma", "lateral_shift", "yaw")
LINES: tuple[Any, Any] = ("-", (0, (3.0, 1.5)))


def has_curves(dataset: xr.Dataset) -> bool:
    """True if there is something to lay over each other: a run of several samples, or poses."""
    return any(n in dataset for n in CHANNELS_DRAWN) and max(dataset.sizes.get(d, 0) for d in ("time", "pose")) > 1


def overlay_figure(one: xr.Dataset, other: xr.Dataset, names: Sequence[str]) -> Figure:
    """Forces, wear number, shift and angle of attack of one wheelset in two results; names: what these are called."""
    present = [name for name in CHANNELS_DRAWN if name in one and name in other]
    with style():
        figure = new_figure(FULL_WIDTH, 20.0 + 33.0 * len(present))
        first = None
        for row, name in enumerate(present):
            axes = figure.add_subplot(len(present), 1, row + 1, sharex=first)
            first = first or axes
            for dataset, line in zip((one, other), LINES, strict=True):
                x, x_name = (
                    (np.arange(dataset.sizes["pose"], dtype=float), "pose")
                    if "pose" in dataset.dims
                    else abscissa(dataset)
                )
                values = shown(dataset, name)
                if "wheel" not in dataset[name].dims:
                    axes.plot(x, values, color=INK, linestyle=line, linewidth=0.9)
                    continue
                for wheel in dataset["wheel"].values:
                    own = dataset[name].sel(wheel=wheel).values * CHANNELS[name].shown.factor
                    axes.plot(x, own, color=WHEEL_COLOUR[str(wheel)], linestyle=line, linewidth=0.9)
            unit = f" [{CHANNELS[name].shown.symbol}]" if CHANNELS[name].shown.suffix else ""
            axes.set_ylabel(f"${CHANNELS[name].symbol}${unit}" if CHANNELS[name].symbol else CHANNELS[name].label)
            if row < len(present) - 1:
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel("Pose" if x_name == "pose" else CHANNELS[x_name].label)
        entries = wheel_entries(one["wheel"].values)
        lines = [Line2D([], [], color=INK, linestyle=line, label=name) for line, name in zip(LINES, names, strict=True)]
        figure.legend(handles=[*lines, *entries], loc="outside lower center", ncols=4)
        height = figure.get_figheight() * 25.4
        figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - 8.0 / height))  # type: ignore[union-attr, call-arg]
        headline(figure, f"{one.attrs['title']} | {other.attrs['title']}")
    return figure
