"""Equivalent conicity over the gauge: lines of a few pairs of profiles, a map of many."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from wrsim.plots.style import FULL_WIDTH, new_figure, pressure_map, style

if TYPE_CHECKING:
    from wrsim.results.conicity_map import ConicityMap

LINES = 6
"""As many pairs are drawn as lines."""


def conicity_map_figure(found: ConicityMap, title: str) -> Figure:
    """Conicity at 3 mm above, nonlinearity parameter below; of many pairs a map of the conicity with a row for each."""
    wheels, rails = ({pair[k] for pair in found.pairs} for k in (0, 1))
    labels = [
        w if len(rails) == 1 and len(wheels) > 1 else r if len(wheels) == 1 and len(rails) > 1 else f"{w} on {r}"
        for w, r in found.pairs
    ]
    gauges = 1e3 * np.array(found.gauges)
    with style():
        many = len(labels) > LINES
        figure = new_figure(FULL_WIDTH, 45.0 + 6.0 * len(labels) if many else 120.0)
        figure.suptitle(title, x=0.012, ha="left", fontsize=8.0)
        if many:
            axes = figure.add_subplot()
            step = gauges[1] - gauges[0] if gauges.size > 1 else 1.0
            extent = (gauges[0] - 0.5 * step, gauges[-1] + 0.5 * step, len(labels) - 0.5, -0.5)
            shown = axes.imshow(found.conicity, aspect="auto", extent=extent, cmap=pressure_map(), vmin=0.0)
            axes.set_yticks(range(len(labels)), labels)
            axes.grid(visible=False)
            axes.set_xlabel("gauge [mm]")
            figure.colorbar(shown, ax=axes, label=r"equivalent conicity $\tan\gamma_e$ at 3 mm")
            return figure
        upper, lower = figure.subplots(2, 1, sharex=True)
        for label, own, bend in zip(labels, found.conicity, found.nonlinearity, strict=True):
            upper.plot(gauges, own, ".-", label=label)
            lower.plot(gauges, bend, ".-", label=label)
        upper.set_ylim(bottom=0.0)
        upper.set_ylabel(r"equivalent conicity $\tan\gamma_e$ at 3 mm")
        lower.set(xlabel="gauge [mm]", ylabel="nonlinearity parameter [1/mm]")
        if len(labels) > 1:
            upper.legend(fontsize=6.5)
    return figure
