"""Axes of a finished picture in the units in use: the curves stay, ticks and words change."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator, NullLocator, ScalarFormatter

from wrsim.results.units import CHOICE, Conversion, heading_in, in_text


class ConvertedLocator(MaxNLocator):
    """Ticks at round numbers of another unit."""

    def __init__(self, unit: Conversion, bins: Any) -> None:
        super().__init__(nbins=bins, steps=[1, 2, 2.5, 5, 10])
        self.unit = unit

    def tick_values(self, vmin: float, vmax: float) -> Any:
        return [self.unit.back(v) for v in super().tick_values(self.unit.forward(vmin), self.unit.forward(vmax))]


class ConvertedFormatter(ScalarFormatter):
    """Ticks written in another unit."""

    def __init__(self, unit: Conversion) -> None:
        super().__init__(useOffset=False)
        self.set_scientific(False)
        self.unit = unit

    def set_locs(self, locs: Any) -> None:
        super().set_locs([self.unit.forward(v) for v in locs])

    def __call__(self, x: float, pos: int | None = None) -> str:
        return super().__call__(self.unit.forward(x), pos)


DIRECTIONS = ("x", "y")


def show_in_units(figure: Figure) -> None:
    """Give a picture the units in use, once.

    An axis has the unit in its label, in the title of its panel, or in the label of a panel in its row or column;
    logarithmic axes, and those whose ticks are set, stay as they are.
    """
    if CHOICE.get().system == "metric" or getattr(figure, "_in_units", False):
        return
    figure._in_units = True  # type: ignore[attr-defined]
    ticks = {id(t) for axes in figure.axes for a in (axes.xaxis, axes.yaxis) for t in a.get_ticklabels(which="both")}
    labels = {id(label) for axes in figure.axes for label in (axes.xaxis.label, axes.yaxis.label)}
    axis_texts = {
        direction: [(axes, _text_of(axes, direction)) for axes in figure.axes if _text_of(axes, direction)]
        for direction in DIRECTIONS
    }
    for axes in figure.axes:
        for direction in DIRECTIONS:
            beside = (text for neighbour, text in axis_texts[direction] if _aligned(axes, neighbour, direction))
            _convert(getattr(axes, f"{direction}axis"), _text_of(axes, direction) or next(beside, ""))
    for text in figure.findobj(Text):
        if id(text) not in ticks | labels and isinstance(text, Text):
            text.set_text(heading_in(in_text(text.get_text()))[0])


def _text_of(axes: Axes, direction: str) -> str:
    """The label of an axis, or of one across without a label the title of its panel where that has a unit."""
    titles = [title for place in ("left", "center", "right") if "[" in (title := axes.get_title(place))]
    label: str = getattr(axes, f"{direction}axis").get_label_text()
    return label or (titles[0] if titles and direction == "y" else "")


def _aligned(axes: Axes, neighbour: Axes, direction: str) -> bool:
    """Whether panels lie in one row (y) or column (x): the first of them has the label for all."""
    box, label_box = axes.get_position(original=True), neighbour.get_position(original=True)
    low, high = ("y0", "y1") if direction == "y" else ("x0", "x1")
    return bool(getattr(label_box, low) < 0.5 * (getattr(box, low) + getattr(box, high)) < getattr(label_box, high))


def _convert(axis: Axis, label: str) -> None:
    label, unit = heading_in(label)
    locator = axis.get_major_locator()
    if text := axis.get_label_text():
        axis.set_label_text(in_text(text))
    if unit is None or axis.get_scale() != "linear" or not isinstance(locator, MaxNLocator | NullLocator):
        return
    if text:
        axis.set_label_text(in_text(label))
    if isinstance(locator, MaxNLocator):
        bins = getattr(locator, "_nbins", "auto")
        bins = max(bins - 1, 1) if isinstance(bins, int) else bins  # numbers in inches have more digits
        axis.set_major_locator(ConvertedLocator(unit, bins))
        axis.set_major_formatter(ConvertedFormatter(unit))
