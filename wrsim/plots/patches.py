"""Contact patches in the plane of curved axis s and rolling direction x, coloured by pressure.

As Fig. 9 of the paper. Every patch is drawn with the field side to the right and equal scales on both axes.
"""

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.path import Path

from wrsim.plots import gallery
from wrsim.plots.marks import few_ticks, minus, stop_note
from wrsim.plots.moments import PatchAt, choose_moments, select, select_elements, touching_runs
from wrsim.plots.theme import INK, QUIET, WHEEL_COLOUR, pressure_map, shown
from wrsim.results import CHANNELS
from wrsim.results.moments import Array, sample_of
from wrsim.results.table import formatted

ACROSS = 49  # points along each strip of the raster
NEAR_EDGE = np.array([0.0, 0.05, 0.2, 0.5])
"""Distances from a patch's edge, over half a strip, of the points that round its end."""
TALLEST_PANEL = 75.0  # height of a panel, mm, that the scale leaves room for
MOST_MOMENTS = 12  # in one gallery


def pressure_scale(dataset: xr.Dataset, moments: Sequence[int] | None = None) -> Normalize:
    """Colour scale from zero to the largest pressure of the moments, MPa."""
    values = shown(dataset, "strip_p")
    chosen = values if moments is None else values[list(moments)]
    return Normalize(0.0, float(np.nanmax(chosen, initial=0.0)) or 1.0)


def contact_patch(axes: Axes, dataset: xr.Dataset, where: PatchAt, scale: Normalize, *, shift: float = 0.0) -> Axes:
    """Draw one patch: every strip's semi-ellipse of pressure over (s, x) in mm, and the patch's outline. Where there
    are elements of the exact solver, their pressures are drawn. shift: added to s [mm]."""
    elements = select_elements(dataset, where)
    for s, x, a, p in islands(dataset, where, shift):
        outline_s = np.concatenate((s, s[::-1], s[:1]))
        outline_x = np.concatenate((x - a, (x + a)[::-1], (x - a)[:1]))
        (line,) = axes.plot(outline_s, outline_x, color=INK, lw=0.7)
        if elements is None:
            angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, ACROSS)
            along = np.sin(angle)[:, None] * a + x
            across, pressure = np.broadcast_to(s, along.shape), np.cos(angle)[:, None] * p
        else:
            across, along = np.meshgrid(elements[0] + shift, elements[1])
            pressure = elements[2].T
        mesh = axes.pcolormesh(across, along, pressure, shading="gouraud", cmap=pressure_map(), norm=scale)
        mesh.set_rasterized(True)
        if elements is not None:
            mesh.set_clip_path(Path(line.get_xydata()), axes.transData)
    axes.set_aspect("equal")
    return axes


def islands(dataset: xr.Dataset, where: PatchAt, shift: float = 0.0) -> list[tuple[Array, Array, Array, Array]]:
    """Islands of a patch in mm and MPa, each (s, x, a, p), closed at both ends: the interpenetration falls linearly to
    an edge, so half length and pressure fall with the square root of the distance over the last half strip."""
    islands = []
    for run in touching_runs(select(dataset, where)):
        s, ds, x, a, p = (shown(run, f"strip_{n}") for n in ("s", "ds", "x", "a", "p"))
        s = s + shift
        low = s[0] - 0.5 * ds[0] * (1.0 - NEAR_EDGE)
        high = (s[-1] + 0.5 * ds[-1] * (1.0 - NEAR_EDGE))[::-1]
        ends = np.pad(x, NEAR_EDGE.size, "edge")
        islands.append((np.concatenate((low, s, high)), ends, rounded(a), rounded(p)))
    return islands


def rounded(values: Array) -> Array:
    """Values of strips, with those at the points that round the ends of an island, where they fall to zero."""
    fall = np.sqrt(NEAR_EDGE)
    return np.concatenate((values[0] * fall, values, (values[-1] * fall)[::-1]))


def patch_note(dataset: xr.Dataset, where: PatchAt, *, force: bool = True) -> str:
    """Numbers of a patch beneath its picture: largest pressure, normal force (if wanted), contact angle. In plain
    letters: each formula of matplotlib's is parsed for some milliseconds."""
    wheel = list(dataset["wheel"].values).index(where.wheel)
    sample = "time" if "time" in dataset.dims else "pose"
    index = {sample: sample_of(dataset, where.moment), "patch": where.patch, "wheel": wheel}

    def term(name: str, symbol: str, form: str, unit: str) -> str:
        value = float(dataset.variables[name].isel(index)) * CHANNELS[name].shown.factor if name in dataset else np.nan
        return f"{symbol} = {formatted(value, form)}{unit}" if np.isfinite(value) else ""

    pressure = (term("p0", "p₀", ".0f", " MPa"), term("N", "N", ".1f", " kN") if force else "")
    angles = (term("contact_angle", "γ", ".1f", "°"), term("contact_angle_variation", "Δγ", ".1f", "°"))
    return minus("\n".join(filter(None, (", ".join(filter(None, line)) for line in (pressure, angles)))))


def patch_gallery(dataset: xr.Dataset, moments: Sequence[int] | None = None) -> Figure:
    """Patches of the chosen moments (default: up to twelve, evenly spread), to one scale. A column for every moment and
    a row for every wheel and patch in contact; long rows are folded."""
    chosen = choose_moments(dataset, MOST_MOMENTS) if moments is None else list(moments)
    columns = gallery.columns_of(dataset, chosen)
    count = len(columns)
    most = gallery.most_moments()
    folded = count > most and len(gallery.patches_in(dataset, columns)) < 2
    widths = range(most, max(most - 3, 0), -1)
    # the last line of a folded row is as full as can be
    page = gallery.Page(min(widths, key=lambda n: -count % n) if folded else max(min(count, most), 1))
    parts = (columns[i : i + page.columns] for i in range(0, len(columns), page.columns))
    blocks = [(part, gallery.patches_in(dataset, part)) for part in parts]
    reaches = {where: _reach(dataset, where) for _, rows in blocks for r in rows.values() for where in r.values()}
    wide, tall = np.max([np.ptp(reach, axis=1) for reach in reaches.values()] or [np.ones(2)], axis=0)
    wide = max(wide, tall * page.panel / TALLEST_PANEL)
    scale = pressure_scale(dataset, chosen)

    def draw(axes: Axes, where: PatchAt, up: float, first: bool) -> None:
        contact_patch(axes, dataset, where, scale)
        (s, x), (half, long) = np.mean(reaches[where], axis=1), (0.5 * wide, 0.5 * up)
        axes.set(xlim=(s - half, s + half), ylim=(x - long, x + long))
        few_ticks(axes, 4, 6.2)
        note = patch_note(dataset, where, force=page.panel > 28.0)
        axes.set_xlabel(f"s [mm]\n{note}", fontsize=6.0, color=QUIET, labelpad=1.0)
        if first:
            axes.set_ylabel("x [mm]", labelpad=1.0, fontsize=6.8)

    def row(wheel: str, patch: int, places: dict[int, PatchAt]) -> gallery.GalleryRow:
        up = max(float(np.ptp(reaches[where][1])) for where in places.values())
        cells = {j: partial(draw, where=where, up=up, first=j == min(places)) for j, where in places.items()}
        label = f"{wheel} wheel" * bool(wheel) + "\n" * bool(wheel and patch)
        label += gallery.PATCH_NAMES[patch] if patch or not wheel else ""
        return gallery.GalleryRow(label, WHEEL_COLOUR.get(wheel, INK), page.panel / wide * up, 15.0, cells)

    rows = [(part, [row(*key, r) for key, r in patches.items()]) for part, patches in blocks]
    reading = (
        "Across: curved axis s, field side to the right. Up: rolling direction x.\n"
        "One scale everywhere; every panel is cut out around its patch." + gallery.selection_note(dataset, chosen)
    )
    return gallery.draw_gallery(dataset.attrs.get("title", ""), stop_note(dataset), dataset, page, rows, scale, reading)


def _reach(dataset: xr.Dataset, where: PatchAt) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits in s and x of a patch with a margin, mm."""
    if (extent := extent_of_patches([(dataset, where, 0.0)])) is None:
        return (-1.0, 1.0), (-1.0, 1.0)
    (low, high), (back, front) = extent
    margin = 0.05 * (high - low) + 0.3
    return (low - margin, high + margin), (back - margin, front + margin)


def extent_of_patches(patches: Iterable[tuple[xr.Dataset, PatchAt, float]]) -> tuple[tuple[float, float], ...] | None:
    """Smallest and largest s, smallest and largest x of patches (with what is added to s) of some datasets, mm."""
    drawn = [island for dataset, where, shift in patches for island in islands(dataset, where, shift)]
    if not drawn:
        return None
    s, x, a, _ = (np.concatenate(parts) for parts in zip(*drawn, strict=True))
    return (float(s.min()), float(s.max())), (float((x - a).min()), float((x + a).max()))
