"""Histories of a run against distance, of a wheelset or a vehicle, with the curvature and cant of the track beneath."""

from collections.abc import Callable, Collection, Sequence
from functools import partial
from itertools import cycle
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from wrsim.assessment.limits import LimitContext
from wrsim.assessment.rules import rule_set
from wrsim.inputs.section import given
from wrsim.plots import marks, theme
from wrsim.plots.gallery import PATCH_NAMES
from wrsim.plots.moments import snapshot_letter
from wrsim.results import CHANNELS
from wrsim.results.moments import is_history
from wrsim.results.netcdf import PART
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets

ANGLE_JUMP = 6.0
"""Degrees between two samples beyond which a contact has jumped elsewhere: the line is interrupted."""
SMALLEST, STEADY = 1e-5, 0.02
"""Least span of an axis in its unit, below what steps are solved to (1e-4 mm, 1 N), and as a part of its values."""
CLOSE = 0.015  # share of the axis within which letters of snapshots are written together
ANGLES = ("contact_angle", "contact_angle_min", "contact_angle_max", "contact_angle_mean")

FINE: Any = {"color": theme.INK, "linewidth": 0.6, "zorder": 3.1}
SNAPSHOT: Any = {"color": theme.QUIET, "linewidth": 0.5, "linestyle": theme.DOTS, "zorder": 1.2}
CROWDED = 60
"""How often a line goes through its whole range before it is drawn thin and transparent."""
SEEN = 2.5
"""A limit is drawn as a line up to so many times the largest value; beyond that it is given in words."""

HEAD, FOOT, GAP, LEFT, RIGHT, LABEL = 10.0, 17.0, 3.4, 19.0, 14.5, 11.2
"""Room over, beneath and between panels, beside them, and distance of their labels, mm."""
LETTERS, LINE = 115, 4.2
"""Letters in a line of the legend of a picture of 170 mm, counting seven for the look of each entry, its height, mm."""
MANY = 4
"""From so many panels on they have two columns."""
MOST_COUPLINGS = 16
"""Couplings of a train that are drawn as lines."""
OWN_PLACE, ORIGIN = "of each wheelset", "of the vehicle's origin"
Panel = Callable[[Axes, xr.Dataset], object]
PIECES = 5000
"""Pieces of a long run in a picture, four to a dot of a panel 137 mm wide at 220 dots an inch."""
UNDERLAID = ("distance", "wheelset_distance", "curvature", "cant", "contact_angle")
"""Channels that any picture of others may need."""


def enveloped(dataset: xr.Dataset, names: Collection[str]) -> xr.Dataset:
    """Some channels of a run for pictures: of a long one the least and the largest value of each of its ``PIECES``, in
    the order in which a rise or a fall meets them."""
    long = {dim for dim in ("time", "fast_time") if dataset.sizes.get(dim, 0) > 2 * PIECES}
    if not long:
        return dataset
    drawn = {
        str(name): (variable.dims, _envelope(variable), variable.attrs)
        for name, variable in dataset.variables.items()
        if variable.dims and variable.dims[0] in long and variable.dtype.kind in "fi"
        and (name in (*long, *UNDERLAID, *names) or str(name).startswith("fast_"))
    }  # fmt: skip
    coords = {name: drawn.pop(name) for name in [*drawn] if name in dataset.coords}
    return dataset.drop_dims(long).assign_coords(coords).assign(drawn)


def _envelope(variable: xr.Variable) -> NDArray[np.float64]:
    ends = np.linspace(0, variable.shape[0], PIECES + 1).astype(int)
    envelope = np.zeros((PIECES, 2, *variable.shape[1:]))
    at_once = max(PART * PIECES // max(variable.nbytes, 1), 1)
    for piece in range(0, PIECES, at_once):
        of = ends[piece : piece + at_once + 1]
        values = np.asarray(variable[of[0] : of[-1]])
        values = np.where(np.isfinite(values), values, np.nan)
        low, high = (f.reduceat(values, of[:-1] - of[0], axis=0) for f in (np.fmin, np.fmax))
        falls = values[of[:-1] - of[0]] > values[of[1:] - of[0] - 1]
        pair = np.where(falls, high, low), np.where(falls, low, high)
        envelope[piece : piece + at_once] = np.stack(pair, axis=1)
    return envelope.reshape(-1, *variable.shape[1:])


def history(axes: Axes, dataset: xr.Dataset, name: str, *, largest: float | None = None) -> Axes:
    """Draw a channel: one line, one a wheel, or one a wheel and patch, as its dimensions ask, interrupted where contact
    jumps or patches change their order. largest: magnitude in all panels on one scale, by default in this one."""
    x, _ = theme.abscissa(dataset)
    values = theme.shown(dataset, name)
    if values.ndim == 1:
        marks.draw_line(axes, x, values, color=theme.INK)
    else:
        of_patches = values.ndim == 3
        values = values.reshape(*values.shape[:2], -1)
        for j, k in zip(*np.nonzero(np.isfinite(values).any(axis=0)), strict=True):
            line = x, values[:, j, k]
            if of_patches and "contact_angle" in dataset:
                line = marks.broken(*line, ANGLE_JUMP, by=theme.shown(dataset, "contact_angle")[:, j, k])
            look: Any = {"color": theme.WHEEL_COLOUR[str(dataset["wheel"].values[j])], "linestyle": theme.GROUP_LINE[k]}
            marks.draw_line(axes, *line, **(look | crowded(values[:, j, k])))
    if name == "Y_over_Q":
        _derailment_limit(axes, dataset, largest or float(np.nanmax(np.abs(values), initial=0.0)))
    low, high = axes.get_ylim()
    if high - low < (least := max(SMALLEST, STEADY * max(abs(low), abs(high)))):  # round-off is a straight line
        axes.set_ylim(0.5 * (low + high - least), 0.5 * (low + high + least))
    before = "$" if CHANNELS[name].symbol else "["
    axes.set_ylabel(CHANNELS[name].label.replace(f" {before}", f"\n{before}", 1))
    return axes


def crowded(values: NDArray[Any]) -> dict[str, Any]:
    """Look of a line that goes up and down so often that it fills its panel and hides the others."""
    known = values[np.isfinite(values)]
    often = known.size > 1 and float(np.abs(np.diff(known)).sum()) > CROWDED * float(np.ptp(known)) > 0.0
    return {"linewidth": 0.45, "alpha": 0.6} if often else {}


def _derailment_limit(axes: Axes, dataset: xr.Dataset, largest: float) -> None:
    """The limit of the filtered quotient where there is one: a red line, or words alone where that is far above."""
    x, _ = theme.abscissa(dataset)
    curvature = dataset["curvature"].values if "curvature" in dataset else np.zeros(x.shape)
    clause = given(rule_set().about("Y_over_Q"))
    rule = given(clause.limit)
    most = given(clause.limit_at(LimitContext())).value
    limit = np.where(np.abs(curvature) * (rule.from_radius_m or 0.0) <= 1.0 + 1e-6, most, np.nan)
    if not np.isfinite(limit).any():
        return
    if largest * SEEN >= most:
        axes.plot(x, limit, color=theme.STOP_COLOUR, linewidth=0.8, gid="limit")
        axes.set_ylim(top=max(axes.get_ylim()[1], 1.08 * most))
    label = f"limit {most:g} after {clause.low_pass_Hz:g} Hz\nand {clause.window_m:g} m ({rule.source})"
    look: Any = {"xycoords": "axes fraction", "rotation": 90, "ha": "left", "va": "center", "color": theme.STOP_COLOUR}
    marks.note(axes, label, (1.0, 0.5), (2.5, 0.0), **look)


def contact_angle(axes: Axes, dataset: xr.Dataset, wheel: str) -> Axes:
    """Contact angles of one wheel: main point (line), mean over strips (thin), least to largest (band, lone: bar)."""
    x, _ = theme.abscissa(dataset)
    colour = theme.WHEEL_COLOUR[wheel]
    of_wheel = dataset[[*ANGLES]].sel(wheel=wheel)
    main, low, high, mean = (theme.shown(of_wheel, name) for name in ANGLES)
    for k in np.flatnonzero(np.isfinite(main).any(axis=0)):
        for values, look in ((main, {"color": colour, "zorder": 3.0}), (mean, FINE)):
            thin: Any = look | crowded(values[:, k])
            marks.draw_line(axes, *marks.broken(x, values[:, k], ANGLE_JUMP), linestyle=theme.GROUP_LINE[k], **thin)
        shade: Any = {"color": colour, "alpha": 0.28 if k == 0 else 0.16, "zorder": 2.0}
        (band_x, least), (_, largest) = (marks.broken(x, end[:, k], ANGLE_JUMP, by=main[:, k]) for end in (low, high))
        axes.fill_between(band_x, least, largest, linewidth=0.0, **shade)
        alone = marks.without_neighbours(least)
        if alone.any():
            axes.vlines(band_x[alone], least[alone], largest[alone], linewidth=1.5, **shade)
    axes.set_ylabel(f"{wheel.capitalize()} wheel\ncontact angle [°]")
    return axes


def track_layout(axes: Axes, dataset: xr.Dataset) -> Axes:
    """Curvature (grey area, left axis) and cant (dashed, right axis) in a slim panel; up is to the left."""
    x, name = theme.abscissa(dataset)
    axes.set_xlabel(CHANNELS[name].label)
    curvature = theme.shown(dataset, "curvature")
    axes.fill_between(x, 0.0, curvature, color="#ccd2da", linewidth=0.0, zorder=1.5)
    marks.draw_line(axes, x, curvature, color="#8f98a5", linewidth=0.7)
    _limits_with_zero(axes, curvature, least=1.0, margin=0.12)
    axes.set_ylabel("Curvature\n[1/km]", color=theme.QUIET)
    if "cant" in dataset:
        cant = theme.shown(dataset, "cant")
        right = marks.right_axis(axes)
        marks.draw_line(right, x, cant, color=theme.CANT_COLOUR, linestyle=theme.GROUP_LINE[1], linewidth=1.0)
        _limits_with_zero(right, cant, least=20.0, margin=0.5)
        right.set_ylabel("Cant\n[mm]", color=theme.CANT_COLOUR, labelpad=1.5)
        right.tick_params(axis="y", colors=theme.CANT_COLOUR)
    return axes


def _limits_with_zero(axes: Axes, values: NDArray[Any], least: float, margin: float) -> None:
    """Limits that hold all values and zero, with a margin on the sides that are used."""
    low, high = (float(f(values, initial=0.0)) for f in (np.nanmin, np.nanmax))
    if high - low < 1e-9 * least:
        low, high = -0.5 * least, 0.5 * least
    space = margin * (high - low)
    axes.set_ylim(low - space if low < 0.0 else -0.04 * (high - low), high + space if high > 0.0 else 0.0)
    axes.yaxis.set_major_locator(theme.InView(3))


def mark_snapshots(axes: Axes, dataset: xr.Dataset, *, letters: bool = True) -> Axes:
    """Fine dotted lines at the snapshots, with the letters that name them in the pictures of patches. Letters of
    snapshots close together are one word over their middle."""
    if "snapshot" not in dataset.dims:
        return axes
    x, _ = theme.abscissa(dataset)
    places = np.interp(dataset["snapshot_time"].values, dataset["time"].values, x)
    up = np.tile((0.0, 1.0, np.nan), places.size)
    axes.add_line(Line2D(np.repeat(places, 3), up, transform=axes.get_xaxis_transform(), **SNAPSHOT))
    close = np.diff(places, prepend=-np.inf) <= CLOSE * np.ptp(x)
    for group in np.split(np.arange(places.size), np.flatnonzero(~close))[1:] if letters else ():
        marks.note_above(axes, " ".join(map(snapshot_letter, group.tolist())), float(places[group].mean()))
    return axes


@theme.style()
def stacked(
    dataset: xr.Dataset,
    panels: Sequence[Panel],
    *,
    panel_height_mm: float = 36.0,
    legend: Sequence[Artist] = (),
    titled: bool = False,
    whose: str = "",
) -> Figure:
    """Panels above each other, many in two columns, over a slim one of the track, unless that is straight and level;
    one horizontal axis. legend: labelled artists of one legend beneath everything; titled: panels have titles; whose:
    whose distance it is. Every panel has a place of
    its own in mm: a layout that measures all words first takes half of the drawing time."""
    title, note = dataset.attrs.get("title", ""), marks.stop_note(dataset)
    if dataset.sizes["time"] == 0:
        figure = theme.new_figure(theme.full_width(), 24.0, constrained=False)
        theme.headline(figure, title, note)
        figure.text(0.5, 0.2, "No samples to draw.", ha="center", color=theme.QUIET)
        return figure
    across = theme.full_width()
    columns = 2 if len(panels) >= MANY and across >= theme.TWO_COLUMNS else 1
    gap = GAP + (2.6 if titled else 0.0)
    cells = [panels[i : i + columns] for i in range(0, len(panels), columns)]
    heights = [panel_height_mm - gap] * len(cells)
    if any(np.nan_to_num(dataset[n].values).any() for n in ("curvature", "cant") if n in dataset):
        cells.append([track_layout] * columns)
        heights.append(17.0 - GAP)
    top = HEAD + theme.head_height(title, note, across) + gap - GAP
    legend = list(legend)
    if count := dataset.sizes.get("snapshot", 0):
        letters = snapshot_letter(0) + (f" to {snapshot_letter(count - 1)}" if count > 1 else "")
        legend.append(Line2D([], [], label=f"{letters}: see patches, sections", **(SNAPSHOT | {"linewidth": 0.8})))
    lines = _legend_lines([7 + len(str(e.get_label())) for e in legend], LETTERS * across / 170.0)
    total = top + sum(heights) + gap * (len(cells) - 1) + FOOT + LINE * (lines - 1)
    figure = theme.new_figure(across, total, constrained=False)
    theme.headline(figure, title, note)
    width = across / columns - LEFT - RIGHT
    x, name = theme.abscissa(dataset)
    along = CHANNELS[name].label
    along = along.replace("Distance ", f"Distance {whose} ") if whose and name == "distance" else along
    for i, (row, height) in enumerate(zip(cells, heights, strict=True)):
        for j, panel in enumerate(row):
            axes = theme.mm_axes(figure, LEFT + j * across / columns, top, width, height)
            if i or j:
                axes.sharex(figure.axes[0])
            lowest = all(j >= len(below) for below in cells[i + 1 :])
            axes.yaxis.set_label_coords(-LABEL / width, 0.5)
            panel(axes, dataset)
            axes.tick_params(labelbottom=lowest)
            axes.set_xlabel(along if lowest else "")
            mark_snapshots(axes, dataset, letters=i == 0)
            marks.mark_stop(axes, dataset)
        top += height + gap
    if x[-1] > x[0]:
        axes.set_xlim(x[0], x[-1] + (0.01 * (x[-1] - x[0]) if marks.is_stopped(dataset) else 0.0))
    if legend:
        marks.legend_beneath(figure, legend, ceil(len(legend) / lines))
    return figure


def _legend_lines(letters: Sequence[int], most: float) -> int:
    """Lines of a legend of entries of so many letters, whose columns have at most so many together, at most five."""
    for lines in range(1, len(letters) + 1):
        columns = ceil(len(letters) / lines)
        if columns <= 5 and sum(part.max() for part in np.array_split(letters, columns)) <= most:
            return lines
    return max(len(letters), 1)


def overview_figure(dataset: xr.Dataset) -> Figure:
    """The run at a glance: contact angles of both wheels, Y/Q, wear number, lateral shift, yaw."""
    panels: list[Panel] = [partial(contact_angle, wheel=str(wheel)) for wheel in dataset["wheel"].values]
    names = ("Y_over_Q", "T_gamma", "lateral_shift", "yaw")
    panels += [partial(history, name=name) for name in names if name in dataset]
    legend = [
        *marks.wheel_entries(dataset["wheel"].values),
        Line2D([], [], color=theme.QUIET, linewidth=1.6, label="main contact point"),
        Line2D([], [], color=theme.INK, linewidth=0.6, label="mean over the strips"),
        Patch(facecolor=theme.QUIET, alpha=0.3, label="smallest to largest"),
        *_later_patches(dataset["contact_angle"]),
    ]
    return stacked(dataset, panels, panel_height_mm=32.0, legend=legend)


def channels_figure(dataset: xr.Dataset, names: Sequence[str]) -> Figure:
    """Histories of the named channels above each other; channels that the dataset lacks are left out."""
    present = [name for name in names if name in dataset]
    of_wheels = any("wheel" in dataset[name].dims for name in present)
    legend = marks.wheel_entries(dataset["wheel"].values) if of_wheels else []
    of_patches = [dataset[name] for name in present if "patch" in dataset[name].dims]
    legend += _later_patches(of_patches[0]) if of_patches else []
    return stacked(dataset, [partial(history, name=name) for name in present], legend=legend)


def _later_patches(data: xr.DataArray) -> list[Artist]:
    used = [k for k in range(1, data.sizes["patch"]) if np.isfinite(data.isel(patch=k)).any()]
    return [Line2D([], [], color=theme.QUIET, linestyle=theme.GROUP_LINE[k], label=PATCH_NAMES[k]) for k in used]


VEHICLE_PICTURES = {
    "vehicle_guiding": ("wheelset", "Y"),
    "vehicle_shifting": ("wheelset", "sum_Y"),
    "vehicle_loads": ("wheelset", "Q"),
    "vehicle_derailment": ("wheelset", "Y_over_Q"),
    "vehicle_steering": ("wheelset", "lateral_shift yaw"),
    "vehicle_bodies": ("body", "body_roll body_yaw body_vertical"),
    "vehicle_accelerations": ("point", "point_ay point_az"),
    "vehicle_couplings": (
        "coupling",
        "coupling_force coupling_fy_ahead coupling_fy_behind coupling_offset coupling_yaw",
    ),
    "bridge": ("span", "deck_deflection deck_moment deck_acceleration"),
    "vehicle_external_loads": ("external_load", "external_fx external_fy external_fz"),
}
"""Dimension and channels of every picture, by file name without ending."""


def vehicle_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of those ``VEHICLE_PICTURES`` of a run of which there are data."""
    figures: dict[str, Callable[[], Figure]] = {}
    if not is_history(dataset):
        return figures
    for picture, (dim, channels) in VEHICLE_PICTURES.items():
        if not (len(wheelsets(dataset)) > 1 if dim == "wheelset" else dim in dataset.dims):
            continue
        names = [name for name in channels.split() if name in dataset]
        if names and "wheel" in dataset[names[0]].dims:
            figures[picture] = partial(wheelsets_figure, dataset, names[0])
        elif names and dim == "coupling" and dataset.sizes[dim] > MOST_COUPLINGS:
            figures[picture] = partial(long_train_figure, dataset, names)
        elif names:
            figures[picture] = partial(together_figure, dataset, dim, names)
    return figures


def wheelsets_figure(dataset: xr.Dataset, name: str) -> Figure:
    """A channel of the wheels, a panel for each wheelset against its own distance, on one scale."""
    values, names = theme.shown(dataset, name), numbered(wheelsets(dataset))
    low, high = (float(f(values, initial=0.0)) for f in (np.nanmin, np.nanmax))
    space = 0.05 * max(high - low, 1e-9)

    def panel(axes: Axes, _: xr.Dataset, wheelset: str) -> None:
        history(axes, of_wheelset(dataset, wheelset), name, largest=max(-low, high))
        limited = any(line.get_gid() == "limit" for line in axes.lines)
        top = max(axes.get_ylim()[1], high + space) if limited else high + space
        axes.set(ylim=(low - space, top), title=names[wheelset], ylabel=CHANNELS[name].short_label)

    panels = [partial(panel, wheelset=wheelset) for wheelset in names]
    track = _track_of(dataset)
    track.attrs["title"] += f": {CHANNELS[name].long_name}"
    return stacked(track, panels, panel_height_mm=28.0, legend=marks.wheel_entries(), titled=True, whose=OWN_PLACE)


def long_train_figure(dataset: xr.Dataset, channels: Sequence[str]) -> Figure:
    """Forces of all couplings of a train over distance and place in the train, and channels of those of its vehicles in
    full."""
    full = {str(name).split(".")[0] for name in dataset["body"].values}
    joined = [set(str(name).split("-")) & full != set() for name in dataset["coupling"].values]
    force = theme.shown(dataset, "coupling_force")

    def overview(axes: Axes, _: xr.Dataset) -> None:
        number, most = np.arange(1, force.shape[1] + 1), float(np.abs(force).max())
        look: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -most, "vmax": most, "shading": "nearest", "rasterized": True}
        mesh = axes.pcolormesh(theme.abscissa(dataset)[0], number, force.T, **look)
        axes.set(ylim=(number[-1], 1), ylabel="Coupling")
        axes.figure.colorbar(mesh, cax=axes.inset_axes((1.01, 0.0, 0.015, 1.0)))
        axes.set_title(f"{CHANNELS['coupling_force'].label}, pull positive", fontsize="small")

    return together_figure(dataset.isel(coupling=np.flatnonzero(joined)), "coupling", channels, [overview])


def together_figure(dataset: xr.Dataset, dim: str, channels: Sequence[str], above: Sequence[Panel] = ()) -> Figure:
    """Channels of wheelsets, bodies or points, a panel each, and a line for each of them, the smallest in front; above:
    panels ahead of them."""
    names = [str(n) for n in dataset[dim].values]
    labels = numbered(names).values() if dim == "wheelset" else names
    pairs = zip(cycle(theme.SERIES_COLOURS), cycle(theme.GROUP_LINE), labels)
    looks: list[dict[str, Any]] = [{"color": colour, "linestyle": line} for colour, line, _ in pairs]

    def panel(axes: Axes, _: xr.Dataset, name: str) -> None:
        (x, _name), values = theme.abscissa(dataset), theme.shown(dataset, name)
        for i in np.argsort(-np.ptp(values, axis=0), kind="stable"):  # small ones last, or large ones hide them
            places = dataset["wheelset_distance"].values[:, i] if dim == "wheelset" else x
            marks.draw_line(axes, places, values[:, i], **(looks[i] | crowded(values[:, i])))
        axes.set_ylabel(
            CHANNELS[name].label.replace(" of the body", "").replace(" of the bridge", "").replace(" [", "\n[")
        )

    legend = [Line2D([], [], label=label, **look) for label, look in zip(labels, looks, strict=True)]
    panels: list[Panel] = [*above, *(partial(panel, name=name) for name in channels)]
    return stacked(_track_of(dataset), panels, legend=legend, whose=OWN_PLACE if dim == "wheelset" else ORIGIN)


def _track_of(dataset: xr.Dataset) -> xr.Dataset:
    """The first wheelset's dataset for the track beneath the panels, without moments, under the vehicle's title."""
    first = of_wheelset(dataset, wheelsets(dataset)[0]).drop_dims("snapshot", errors="ignore")
    return first.assign_attrs(title=dataset.attrs["title"])
