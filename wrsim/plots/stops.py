"""Where and why a stopped analysis ended, said on its pictures."""

from __future__ import annotations

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from wrsim.plots.colours import STOP_COLOUR
from wrsim.plots.style import abscissa
from wrsim.results import CHANNELS

ONE_LINE = 124
"""Letters of a note that fit across a full-width picture."""


def is_stopped(dataset: xr.Dataset) -> bool:
    """True when the analysis ended before its time."""
    return dataset.attrs.get("status") == "stopped"


def mark_stop(axes: Axes, dataset: xr.Dataset) -> Axes:
    """A red line where a stopped run ended."""
    if is_stopped(dataset):
        axes.axvline(_place(dataset)[0], color=STOP_COLOUR, linewidth=1.0, zorder=4.0, gid="stop")
    return axes


def stop_note(dataset: xr.Dataset) -> str:
    """Where and why the analysis stopped, for a picture; empty for a completed one."""
    if not is_stopped(dataset):
        return ""
    reason = dataset.attrs.get("stop_reason", "")
    if "time" not in dataset.dims or "along the track" in reason:  # the reason knows the place
        return fill(f"Stopped: {reason}", ONE_LINE)
    at, symbol = _place(dataset)
    return fill(f"Stopped at {at:.5g} {symbol}: {reason}", ONE_LINE)


def _place(dataset: xr.Dataset) -> tuple[float, str]:
    """Abscissa of the stop and its unit."""
    x, name = abscissa(dataset)
    key = "stop_distance_m" if name == "distance" else "stop_time_s"
    at = float(dataset.attrs.get(key, np.nan))
    if not np.isfinite(at):
        at = float(x[-1]) if x.size else 0.0
    return at, CHANNELS[name].shown.symbol
