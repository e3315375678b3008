"""The picture of what bends: rails on sleepers or a bridge, and elastic axles, at the largest vertical force."""

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels, remark
from wrsim.plots.theme import GROUP_LINE, INK, QUIET, SERIES_COLOURS, WHEEL_COLOUR, shown
from wrsim.results.table import quantity
from wrsim.results.wheelsets import numbered, wheelsets


def bent_figures(dataset: xr.Dataset) -> dict[str, partial[Figure]]:
    """The maker of the picture where anything bends, by its file name without ending."""
    return {"bent": partial(bent_figure, dataset)} if "bent_at_m" in dataset.attrs else {}


def bent_figure(dataset: xr.Dataset) -> Figure:
    """Shapes magnified, with the factor above them."""
    a = dataset.attrs
    place = quantity(a["bent_at_m"], "m", ".2f")
    title = f"{a['title']}\nat the largest vertical force: {a['bent_by']} wheel, {place} along the track"
    draws = [
        partial(draw, dataset=dataset)
        for name, draw in (("rail", _rails), ("axle_y", _axles))
        if f"bent_{name}" in dataset
    ]
    return panels(title, draws, 15.0 + 60.0 * len(draws), share=False)


def _rails(axes: Axes, dataset: xr.Dataset) -> None:
    place, moved = dataset["bent_place"].values, shown(dataset, "bent_rail")
    if (moved[:, 0] == moved[:, 1]).all():
        axes.plot(place, moved[:, 0], color=INK, label="both rails")
    else:
        for side, shape in zip(WHEEL_COLOUR, moved.T, strict=True):
            axes.plot(place, shape, color=WHEEL_COLOUR[side], label=f"{side} rail")
    places, station = dataset["wheelset_distance"].values, float(dataset.attrs["bent_at_m"])
    first = [str(name) for name in wheelsets(dataset)].index(str(dataset.attrs["bent_by"]).rpartition(" ")[0])
    for distances in places.T:
        wheel = float(np.interp(station, places[:, first], distances))
        axes.axvline(wheel, color=QUIET, linewidth=0.5, zorder=1.2)
    axes.set(xlabel="Distance along the track [m]", ylabel="Rail, up [mm]")
    axes.legend(loc="lower right")
    _magnified(axes, "vertical lines: wheelsets")


def _axles(axes: Axes, dataset: xr.Dataset) -> None:
    for i, name in enumerate(numbered(wheelsets(dataset)).values()):
        for axis, line in zip("zx", GROUP_LINE, strict=False):
            y, moved = dataset["bent_axle_y"].values[i], shown(dataset, f"bent_axle_{axis}")[i]
            label = name if axis == "z" else None
            axes.plot(y, moved, color=SERIES_COLOURS[i % len(SERIES_COLOURS)], linestyle=line, label=label)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.set(xlabel="Along the axle, to the left [m]", ylabel="Axle [mm]")
    axes.invert_xaxis()  # seen from behind
    axes.legend(loc="best", ncols=2)
    _magnified(axes, "middle lines against rigid axles; full: up, broken: forward")


def _magnified(axes: Axes, explanation: str) -> None:
    """Note how many times larger than lengths along the axis of m those along the axis of mm are drawn."""
    box = axes.get_window_extent()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    factor = 1e3 * box.height / (high - low) / (box.width / abs(right - left))
    remark(axes, f"magnified {quantity(float(f'{factor:.1g}'), form='.0f')} times; {explanation}")
