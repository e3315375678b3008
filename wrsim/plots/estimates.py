"""Estimated values of an assessment that go by influences: values of the sections, the fit and what it leads to."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.colours import INK, QUIET, STOP_COLOUR
from wrsim.plots.style import FULL_WIDTH, new_figure, style
from wrsim.results.assessment import Assessment, ZoneValue
from wrsim.results.regression import SHOWN

COLUMNS = 3
MOST = 12
"""Panels of a picture."""


def estimated(found: Assessment) -> list[ZoneValue]:
    """What can be drawn: quantities with a limit whose sections differ in an influence, tightest first."""
    rows = [z for z in found.zones() if z.worst.limit is not None and z.regression is not None and z.regression.over]
    return sorted(rows, key=lambda z: z.margin or 0.0)[:MOST]


def estimates_figure(found: Assessment) -> Figure:
    """A panel for each: largest value of every section over the first influence, as if the others were where the value
    is estimated."""
    rows = estimated(found)
    lines = (len(rows) + COLUMNS - 1) // COLUMNS
    with style():
        figure = new_figure(FULL_WIDTH, 16.0 + 52.0 * lines)
        words = "points: sections; line: fit; bar: from the fit to the estimated value; red: limit"
        figure.suptitle(f"{found.title}\n{words}", x=0.01, ha="left", fontsize=8.0)
        for i, row in enumerate(rows):
            fit_of(figure.add_subplot(lines, COLUMNS, i + 1), row)
    return figure


def fit_of(axes: Axes, row: ZoneValue) -> Axes:
    """Sections, fit, estimated value and limit of one quantity in one class of track."""
    r, quantity, limit = row.regression, row.worst.quantity, row.worst.limit
    if r is None or limit is None:
        return axes
    unit, factor = SHOWN[r.over[0]]
    x, y = factor * r.places, quantity.shown.factor * r.moved
    axes.plot(x, y, ".", color=INK)
    ends = [min(x.min(), factor * r.at[0]), max(x.max(), factor * r.at[0])]
    slope = r.slope[0] / factor
    axes.plot(ends, [quantity.shown.factor * (r.fit + slope * (end - factor * r.at[0])) for end in ends], color=QUIET)
    bounds = [quantity.shown.factor * value for value in (r.fit, r.estimate)]
    axes.plot([factor * r.at[0]] * 2, bounds, "_-", color=INK, markersize=8.0)
    axes.axhline(quantity.shown.factor * limit.value, color=STOP_COLOUR, linewidth=0.8)
    symbol = "" if quantity.shown.symbol == "1" else f" [{quantity.shown.symbol}]"
    axes.set(xlabel=f"{r.over[0].replace('_', ' ')} [{unit}]", ylabel=f"{quantity.symbol}{symbol}")
    axes.set_title(f"{row.worst.section.zone} ({row.sections})", fontsize=7.0)
    axes.set_ylim(bottom=min(0.0, float(y.min())))
    return axes
