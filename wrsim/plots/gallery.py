"""Layout of galleries: columns of moments, rows of wheels and patches, sizes in mm.

With one or two moments and both wheels, every wheel gets a column of its own and the rows tell the patches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wrsim.plots.colours import INK, QUIET, WHEEL_COLOUR
from wrsim.plots.moments import PatchAt, moment_title
from wrsim.plots.style import FULL_WIDTH, place, pressure_map, write
from wrsim.results.channels import PATCHES
from wrsim.results.moments import moment_dim, with_patches

PATCH_NAMES = tuple(f"{name} patch" for name in PATCHES)
LEFT, RIGHT, GAP = 16.0, 3.0, 7.0
"""Margins and the space between panels, mm."""
WIDEST_PANEL = 46.0
FOOT = 14.0
"""Height of the colour bar with its label, mm."""
_NARROWEST = 142.0
_LETTER = 1.35  # mean width of a letter of the titles, mm


@dataclass(frozen=True)
class Column:
    """A moment (index and order in the picture) and its wheel; no wheel when the rows tell the wheels."""

    moment: int
    order: int
    wheel: str = ""


@dataclass(frozen=True)
class Row:
    """A wheel (none when the columns tell the wheels), a patch, and where that is in every column."""

    wheel: str
    patch: int
    places: tuple[PatchAt | None, ...]

    @property
    def label(self) -> str:
        """Words for the left edge."""
        if not self.wheel:
            return PATCH_NAMES[self.patch]
        return f"{self.wheel} wheel" + (f"\n{PATCH_NAMES[self.patch]}" if self.patch else "")

    @property
    def used(self) -> list[tuple[int, PatchAt]]:
        """Numbers of the columns in which the patch is, and where it is there."""
        return [(j, where) for j, where in enumerate(self.places) if where is not None]

    @property
    def colour(self) -> str:
        """Colour of the label."""
        return WHEEL_COLOUR.get(self.wheel, INK)


def columns_of(dataset: xr.Dataset, moments: Sequence[int]) -> list[Column]:
    """Columns for the moments, in their order."""
    wheels = [str(w) for w in dataset["wheel"].values]
    if len(moments) <= 2 and len(wheels) == 2:
        return [Column(moment, i, wheel) for i, moment in enumerate(moments) for wheel in wheels]
    return [Column(moment, i) for i, moment in enumerate(moments)]


def rows_of(dataset: xr.Dataset, columns: Sequence[Column]) -> list[Row]:
    """Rows that have a patch in some column."""
    finite = np.isfinite(dataset["strip_p"].values).any(axis=-1)
    wheels = [str(w) for w in dataset["wheel"].values]
    rows = []
    for wheel in [""] if any(c.wheel for c in columns) else wheels:
        for patch in range(finite.shape[2]):
            wanted = [PatchAt(c.moment, wheel or c.wheel, patch) for c in columns]
            places = tuple(w if finite[w.moment, wheels.index(w.wheel), patch] else None for w in wanted)
            if any(places):
                rows.append(Row(wheel, patch, places))
    return rows


@dataclass(frozen=True)
class Page:
    """Width of a gallery and of its panels, mm, for a number of columns."""

    columns: int

    @property
    def panel(self) -> float:
        """Width of a panel."""
        return min(WIDEST_PANEL, (FULL_WIDTH - LEFT - RIGHT - (self.columns - 1) * GAP) / self.columns)

    @property
    def width(self) -> float:
        """Width of the figure."""
        return max(_NARROWEST, LEFT + RIGHT + self.columns * self.panel + (self.columns - 1) * GAP)

    def axes(self, figure: Figure, column: int, top: float, height: float) -> Axes:
        """Axes of a column at a distance from the upper edge."""
        return place(figure, LEFT + column * (self.panel + GAP), top, self.panel, height)


def selection_words(dataset: xr.Dataset, chosen: Sequence[int]) -> str:
    """How many of the moments that have patches are drawn, where it is not all of them; on a line of its own."""
    there = int(with_patches(dataset).sum())
    what = "moments" if moment_dim(dataset) == "snapshot" else "poses"
    return f"\n{len(chosen)} of {there} {what}; any other: wrsim plot --at." if len(chosen) < there else ""


def titles_height(page: Page, dataset: xr.Dataset, columns: Sequence[Column]) -> float:
    """Height of the columns' titles, mm."""
    return 5.0 + 3.0 * max((_title(page, dataset, c).count("\n") for c in columns), default=0)


def draw_titles(figure: Figure, page: Page, dataset: xr.Dataset, columns: Sequence[Column], top: float) -> None:
    """Titles of the columns, hanging from ``top`` (mm from the upper edge)."""
    for j, column in enumerate(columns):
        colour = WHEEL_COLOUR.get(column.wheel, INK)
        write(figure, LEFT + j * (page.panel + GAP), top, _title(page, dataset, column), fontsize=6.8, color=colour)


def _title(page: Page, dataset: xr.Dataset, column: Column) -> str:
    """Title of a column, its lines wrapped to the panel."""
    text = moment_title(dataset, column.moment, column.order)
    lines = [*text.split("\n"), f"{column.wheel} wheel"] if column.wheel else text.split("\n")
    widest = int((page.panel + 0.5 * GAP) / _LETTER)
    return "\n".join(line if "$" in line else fill(line, widest) for line in lines)


def draw_label(figure: Figure, text: str, colour: str, middle: float) -> None:
    """Upright words at the left edge, centred on ``middle`` (mm from the upper edge)."""
    write(figure, 2.0, middle, text, rotation=90, va="center", color=colour, fontsize=7.0)


def colour_bar(figure: Figure, scale: Normalize, top: float, reading: str) -> None:
    """Pressure scale beneath the panels, with a few words on how to read the picture beside it."""
    axes = place(figure, LEFT, top, 55.0, 2.2)
    bar = figure.colorbar(ScalarMappable(scale, pressure_map()), cax=axes, orientation="horizontal")
    bar.set_label("Contact pressure p [MPa]", labelpad=1.0)
    bar.ax.tick_params(width=0.4)
    write(figure, LEFT + 60.0, top, reading, fontsize=6.8, color=QUIET)
