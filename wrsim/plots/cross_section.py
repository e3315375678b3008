"""Wheel on rail in the cross-section of the rail, with the patch on it (as Fig. 8 of the paper).

Axes are o (outward) and b (up) from the rail's profile origin; the field side is to the right on both wheels.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from wrsim.plots import gallery
from wrsim.plots.marks import few_ticks, stop_note
from wrsim.plots.moments import PatchAt, choose_moments, patches_at, select, touching_runs
from wrsim.plots.patches import NEAR_EDGE, Array, patch_note, pressure_scale, rounded
from wrsim.plots.theme import INK, QUIET, RAIL_FILL, WHEEL_COLOUR, WHEEL_FILL, pressure_map, shown
from wrsim.results.moments import Strips, moment_dim

OVERVIEW = (-88.0, 58.0, -42.0, 22.0)  # window of the overview: o and b, mm
FAN = 0.38  # length of the longest pressure line over the height of the zoomed window


def has_outlines(dataset: xr.Dataset) -> bool:
    """True when the dataset holds what cross-sections need."""
    return {f"{part}_profile_{n}" for part in ("rail", "wheel") for n in "yz"} <= set(dataset)


def outlines(axes: Axes, dataset: xr.Dataset, moment: int, wheel: str) -> None:
    """Draw the rail and the wheel of one moment as cut solids, in mm."""
    index = {"wheel": list(dataset["wheel"].values).index(wheel), moment_dim(dataset): moment}
    for part, fill, beyond, order in (("rail", RAIL_FILL, -300.0, 1.0), ("wheel", WHEEL_FILL, 300.0, 1.1)):
        coordinates = (dataset.variables[f"{part}_profile_{n}"] for n in "yz")
        y, z = (1e3 * line.isel(index, missing_dims="ignore").values for line in coordinates)
        finite = np.isfinite(y) & np.isfinite(z)
        if not finite.any():
            continue
        y, z = y[finite], z[finite]
        solid = np.column_stack((np.pad(y, 1, "edge"), np.pad(z, 1, constant_values=beyond)))
        axes.add_artist(Polygon(solid, facecolor=fill, edgecolor="none", zorder=order))
        axes.plot(*solid.T, color=INK, linewidth=0.7, zorder=order + 0.5, gid=part)
    axes.set_aspect("equal")
    axes.grid(False)


def patch_on_section(
    axes: Axes, dataset: xr.Dataset, where: PatchAt, scale: Normalize, *, thickness: float, fan: float = 0.0
) -> None:
    """Draw a patch as a band of ``thickness`` mm along the curved axis, coloured by pressure. With ``fan`` > 0 also the
    pressure along the strips' normals, into the wheel; the largest of the scale is ``fan`` mm long."""
    for run in touching_runs(select(dataset, where)):
        curve, normal, p = pressed_curve(run)
        band = np.stack((curve - 0.5 * thickness * normal, curve + 0.5 * thickness * normal))
        look: Any = {"shading": "gouraud", "cmap": pressure_map(), "norm": scale, "zorder": 3.0, "gid": "patch"}
        axes.pcolormesh(band[..., 0], band[..., 1], np.tile(p, (2, 1)), rasterized=True, **look)
        if fan > 0.0:
            tips = curve + normal * (fan * p / float(scale.vmax or 1.0))[:, None]
            axes.add_artist(Polygon(np.vstack((tips, curve[::-1])), facecolor="white", alpha=0.75, zorder=2.5))
            axes.plot(*tips.T, color=INK, linewidth=0.7, zorder=2.7, gid="pressure")
            inner = np.arange(len(NEAR_EDGE), len(p) - len(NEAR_EDGE))
            few = inner[:: max(1, len(inner) // 16)]
            lines = list(np.stack((curve, tips), axis=1)[few])
            axes.add_collection(LineCollection(lines, colors=QUIET, linewidths=0.4, zorder=2.6, gid="normals"))


def pressed_curve(strips: Strips) -> tuple[Array, Array, Array]:
    """Points (n, 2) along an island from edge to edge in mm, normals (n, 2) and pressures (n,) in MPa. Towards an edge
    the pressure falls with the square root of the distance, as in ``patches``."""
    y, z, angle, p, ds = (shown(strips, f"strip_{n}") for n in ("y", "z", "angle", "p", "ds"))
    slope = np.radians(angle)
    along = np.column_stack((np.cos(slope), np.sin(slope)))
    centre = np.column_stack((y, z))
    out = (0.5 * (1.0 - NEAR_EDGE))[:, None]
    start = centre[0] - out * ds[0] * along[0]
    end = (centre[-1] + out * ds[-1] * along[-1])[::-1]
    normal = np.pad(np.column_stack((-along[:, 1], along[:, 0])), ((NEAR_EDGE.size,) * 2, (0, 0)), "edge")
    return np.vstack((start, centre, end)), normal, rounded(p)


def cross_section(axes: Axes, dataset: xr.Dataset, moment: int, wheel: str, scale: Normalize) -> Axes:
    """Overview of one wheel on its rail: outlines and all patches."""
    outlines(axes, dataset, moment, wheel)
    for where in patches_at(dataset, moment, wheel):
        patch_on_section(axes, dataset, where, scale, thickness=4.0)
    axes.set(xlim=OVERVIEW[:2], ylim=OVERVIEW[2:])
    return axes


def cross_section_zoom(axes: Axes, dataset: xr.Dataset, where: PatchAt, scale: Normalize) -> Axes:
    """Close view of one patch with its pressure along the normals, in a square window that fits the patch."""
    outlines(axes, dataset, where.moment, where.wheel)
    o, b, half = zoom_window(dataset, where)
    patch_on_section(axes, dataset, where, scale, thickness=0.05 * half, fan=2.0 * FAN * half)
    axes.set(xlim=(o - half, o + half), ylim=(b - half, b + half))
    return axes


def zoom_window(dataset: xr.Dataset, where: PatchAt) -> tuple[float, float, float]:
    """Centre (o, b) and half side of the close view, mm: patch and pressure lines fit."""
    strips = select(dataset, where)
    y, z, angle = (shown(strips, f"strip_{n}") for n in ("y", "z", "angle"))
    half = max(0.65 * float(np.hypot(np.ptp(y), np.ptp(z))), 2.5) + 0.5
    slope = float(np.radians(np.mean(angle)))
    o = 0.5 * float(y[0] + y[-1]) - 0.3 * half * np.sin(slope)
    b = 0.5 * float(z[0] + z[-1]) + 0.3 * half * np.cos(slope)
    return o, b, half


def section_gallery(dataset: xr.Dataset, moments: Sequence[int] | None = None) -> Figure:
    """Cross-sections of the chosen moments (default: up to six): overviews of wheels, close views of patches."""
    chosen = choose_moments(dataset, gallery.most_moments()) if moments is None else list(moments)
    columns = gallery.columns_of(dataset, chosen)
    page = gallery.Page(max(len(columns), 1))
    scale = pressure_scale(dataset, chosen)
    flat = page.panel * (OVERVIEW[3] - OVERVIEW[2]) / (OVERVIEW[1] - OVERVIEW[0])

    def overview(axes: Axes, moment: int, wheel: str, first: bool) -> None:
        _framed(axes, 3, first)
        if not first:  # the window of the first one
            axes.set(xticks=(), yticks=(), xlabel="")
        cross_section(axes, dataset, moment, wheel, scale)
        for o, b, half in (zoom_window(dataset, where) for where in patches_at(dataset, moment, wheel)):
            look: Any = {"fill": False, "edgecolor": QUIET, "linewidth": 0.5, "zorder": 4.0}
            axes.add_artist(Rectangle((o - half, b - half), 2 * half, 2 * half, **look))

    def close(axes: Axes, where: PatchAt, first: bool) -> None:
        _framed(axes, 4, first, "\n" + patch_note(dataset, where, force=page.panel > 28.0))
        cross_section_zoom(axes, dataset, where, scale)

    rows = []
    patches = gallery.patches_in(dataset, columns)
    for wheel in [""] if any(c.wheel for c in columns) else [str(w) for w in dataset["wheel"].values]:
        colour, label = WHEEL_COLOUR.get(wheel, INK), f"{wheel} wheel" if wheel else ""
        whole = [partial(overview, moment=c.moment, wheel=wheel or c.wheel, first=not j) for j, c in enumerate(columns)]
        rows.append(gallery.GalleryRow(label, colour, flat, 8.5, dict(enumerate(whole))))
        for (_, patch), places in (row for row in patches.items() if row[0][0] == wheel):
            cells = {j: partial(close, where=where, first=j == min(places)) for j, where in places.items()}
            rows.append(gallery.GalleryRow(gallery.PATCH_NAMES[patch], colour, page.panel, 15.0, cells))
    reading = (
        "Axes: outward o (field side to the right) and up b from the rail's profile origin.\n"
        "Thin lines: pressure along the normals." + gallery.selection_note(dataset, chosen)
    )
    title = dataset.attrs.get("title", "")
    return gallery.draw_gallery(title, stop_note(dataset), dataset, page, [(columns, rows)], scale, reading)


def _framed(axes: Axes, ticks: int, first: bool, beneath: str = "") -> None:
    """A full frame, few ticks, names of the axes, the upward one at the first panel of a row; a note beneath."""
    few_ticks(axes, ticks, 6.0)
    axes.spines[:].set_visible(True)
    axes.set_xlabel(f"o [mm]{beneath}", fontsize=6.0, color=QUIET, labelpad=1.0)
    axes.set_ylabel("b [mm]" if first else "", fontsize=6.0, color=QUIET, labelpad=1.0)
