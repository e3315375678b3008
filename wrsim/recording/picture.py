"""Picture of a recorded track: what was measured, the design that was found, and what is left."""

from collections.abc import Callable, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from wrsim.plots.marks import panels
from wrsim.plots.theme import CANT_COLOUR, INK, TWO_COLUMNS, WHEEL_COLOUR, full_width
from wrsim.recording.restoring import Restored
from wrsim.results.channels import WHEELS
from wrsim.results.moments import Array

KINDS = ("curvature", "cant", "twist", "gauge", "gauge_deviation", "alignment", "level")


def recording_figure(restored: Restored) -> Figure:
    """Recorded channels above, with the design in its own; the rails beside the design below."""
    recording = restored.recording
    kinds = sorted({c.kind for c, _ in recording.records}, key=KINDS.index)
    draws = [partial(_recorded, restored=restored, kind=kind) for kind in kinds]
    for rows, label in ((restored.lateral, "lateral"), (restored.vertical, "vertical")):
        lines = [(f"{name} rail", 1e3 * row, WHEEL_COLOUR[name]) for name, row in zip(WHEELS, rows, strict=True)]
        draws.append(partial(_draw, restored=restored, lines=lines, label=f"What is left,\n{label} [mm]"))
    title = f"{recording.path.name}: recorded, designed, and what is left"
    return panels(title, draws, 26.0 + 27.0 * len(draws))


def _recorded(axes: Axes, restored: Restored, kind: str) -> None:
    """The records of a kind, and the design where it has any."""
    local, law, gauge = restored.recording.distance, restored.law, restored.recording.columns.gauge_mm / 1e3
    designs: dict[str, Callable[[Array], Array]] = {
        "curvature": law.curvature,
        "cant": law.cant,
        "gauge": lambda x: gauge + law.widening(x),
        "gauge_deviation": law.widening,
    }
    lines = [("design", 1e3 * designs[kind](local), CANT_COLOUR)] if kind in designs else []
    for channel, record in restored.recording.records:
        if channel.kind == kind:
            side = channel.quantity.rpartition("_")[2]
            lines.append((f"recorded, {channel.column}", 1e3 * record, WHEEL_COLOUR.get(side, INK)))
    unit = "1/km" if kind == "curvature" else "mm"
    _draw(axes, restored, lines, f"{kind.partition('_')[0].capitalize()}\n[{unit}]")


def _draw(axes: Axes, restored: Restored, lines: Sequence[tuple[str, Array, str]], label: str) -> None:
    s = restored.recording.start + restored.recording.distance
    for name, values, colour in lines:
        axes.plot(s, values, color=colour, linewidth=1.8 if name == "design" else 0.5, label=name)
    axes.set(xlim=(s[0], s[-1]), xlabel="Distance in the recording [m]", ylabel=label)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    low, high = axes.get_ylim()
    rows = len(lines) if full_width() < TWO_COLUMNS else 1
    axes.set_ylim(low, high + 0.25 * rows * (high - low))  # room for the legend
    axes.legend(loc="upper right", ncols=len(lines) // rows, fontsize=6.0)
