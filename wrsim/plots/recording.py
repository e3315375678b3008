"""Picture of a recorded track: what was measured, the design that was found, and what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wrsim.plots.colours import CANT_COLOUR, INK, WHEEL_COLOUR
from wrsim.plots.style import FULL_WIDTH, new_figure, style
from wrsim.recording.columns import kind_of
from wrsim.recording.restoring import Restored

Array = NDArray[np.float64]
Line = tuple[str, Array, str]
"""Name, values and colour of a line."""

LABELS = {
    "curvature": "Curvature\n[1/km]",
    "cant": "Cant\n[mm]",
    "twist": "Twist\n[mm]",
    "gauge": "Gauge\n[mm]",
    "gauge_deviation": "Gauge\n[mm]",
    "alignment": "Alignment\n[mm]",
    "level": "Level\n[mm]",
}
SIDES = ("left", "right")


def recording_figure(restored: Restored) -> Figure:
    """Recorded channels above, with the design in its own; the rails beside the design below."""
    recording = restored.recording
    s = recording.start + recording.distance
    kinds = list(dict.fromkeys(kind_of(c.quantity) for c, _ in recording.records))
    kinds.sort(key=list(LABELS).index)
    with style():
        figure = new_figure(FULL_WIDTH, 26.0 + 27.0 * (len(kinds) + 2))
        grid = figure.add_gridspec(len(kinds) + 2, 1)
        first = figure.add_subplot(grid[0])
        panels = [first, *(figure.add_subplot(grid[k], sharex=first) for k in range(1, len(kinds) + 2))]
        for axes, kind in zip(panels, kinds, strict=False):
            _recorded(axes, restored, kind, s)
        for axes, shape, label in zip(
            panels[-2:], (restored.lateral, restored.vertical), ("lateral", "vertical"), strict=True
        ):
            _draw(
                axes,
                s,
                [(f"{name} rail", 1e3 * row, WHEEL_COLOUR[name]) for name, row in zip(SIDES, shape, strict=True)],
            )
            axes.set_ylabel(f"What is left,\n{label} [mm]")
        for axes in panels[:-1]:
            axes.tick_params(axis="x", labelbottom=False)
        panels[-1].set_xlabel("Distance in the recording [m]")
        first.set_xlim(s[0], s[-1])
        first.set_title(f"{recording.path.name}: recorded, designed, and what is left")
        figure.align_ylabels(panels)
    return figure


def _recorded(axes: Axes, restored: Restored, kind: str, s: Array) -> None:
    """The records of a kind, and the design where it has any."""
    local = restored.recording.distance
    factor = 1e3
    lines: list[Line] = []
    for channel, record in restored.recording.records:
        if kind_of(channel.quantity) == kind:
            side = channel.quantity.rpartition("_")[2]
            lines.append((f"recorded, {channel.column}", factor * record, WHEEL_COLOUR.get(side, INK)))
    law, gauge = restored.law, restored.recording.columns.gauge_mm / 1e3
    designs: dict[str, Callable[[Array], Array]] = {
        "curvature": law.curvature,
        "cant": law.cant,
        "gauge": lambda x: gauge + law.widening(x),
        "gauge_deviation": law.widening,
    }
    if kind in designs:
        lines.insert(0, ("design", factor * designs[kind](local), CANT_COLOUR))
    _draw(axes, s, lines)
    axes.set_ylabel(LABELS[kind])


def _draw(axes: Axes, s: Array, lines: Sequence[Line]) -> None:
    for name, values, colour in lines:
        axes.plot(s, values, color=colour, linewidth=1.8 if name == "design" else 0.5, label=name)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.25 * (high - low))  # room for the legend
    axes.legend(loc="upper right", ncols=len(lines), fontsize=6.0)
