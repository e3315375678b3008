"""Loops of stationary tests: wheel loads over the twist, moment over the angle of a bogie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from wrsim.plots.style import FULL_WIDTH, new_figure, style


@dataclass(frozen=True)
class Loop:
    """Lines (label, x, y) of one panel, and what stands at its axes."""

    x: str
    y: str
    lines: Sequence[tuple[str, object, object]]


def loops_figure(title: str, loops: Sequence[Loop]) -> Figure:
    """One panel for each test, beside each other."""
    with style():
        figure = new_figure(FULL_WIDTH, 80.0)
        figure.suptitle(title, x=0.012, ha="left", fontsize=8.0)
        for axes, loop in zip(np.atleast_1d(figure.subplots(1, len(loops))), loops, strict=True):
            for label, x, y in loop.lines:
                axes.plot(x, y, label=label)
            axes.set(xlabel=loop.x, ylabel=loop.y)
            axes.legend(fontsize=6.5)
    return figure
