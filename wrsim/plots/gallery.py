"""Galleries: columns of moments, rows of wheels and patches, sizes in mm, one scale of pressure beneath.

With one or two moments and both wheels, every wheel gets a column of its own and the rows are for the patches.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wrsim.plots import theme
from wrsim.plots.moments import PatchAt, moment_title
from wrsim.results.channels import PATCHES
from wrsim.results.moments import moment_dim, with_patches

PATCH_NAMES = tuple(f"{name} patch" for name in PATCHES)
FOOT = 14.0  # height of the colour bar with its label, mm
_NARROWEST, _LETTER = 142.0, 1.35  # least width of a gallery, mean width of a letter of the titles, mm


@dataclass(frozen=True)
class GalleryColumn:
    """A moment (index and order in the picture) and its wheel; no wheel where the rows are for wheels."""

    moment: int
    order: int
    wheel: str = ""


@dataclass(frozen=True)
class GalleryRow:
    """Words at the left edge, their colour, height of panels and of the room beneath, mm; what draws, by column."""

    label: str
    colour: str
    height: float
    beneath: float
    cells: Mapping[int, Callable[[Axes], object]]


@dataclass(frozen=True)
class Page:
    """Width of a gallery and of its panels, mm, for a number of columns; upright: labels are at the left edge."""

    columns: int
    left: float = 16.0
    right: float = 3.0
    gap: float = 7.0
    widest: float = 46.0
    upright: bool = True

    @property
    def panel(self) -> float:
        """Width of a panel."""
        room = theme.full_width() - self.left - self.right - (self.columns - 1) * self.gap
        return min(self.widest, room / self.columns)

    @property
    def width(self) -> float:
        """Width of the figure."""
        return max(min(_NARROWEST, theme.full_width()), self.place_of(self.columns) - self.gap + self.right)

    def place_of(self, column: int) -> float:
        """Distance of a column from the left edge."""
        return self.left + column * (self.panel + self.gap)


def most_moments() -> int:
    """How many moments there is room for beside each other, six at most."""
    return max(1, min(6, int((theme.full_width() - 16.0) / 24.0)))


def columns_of(dataset: xr.Dataset, moments: Sequence[int]) -> list[GalleryColumn]:
    """Columns for the moments, in their order."""
    wheels = [str(w) for w in dataset["wheel"].values]
    sides = wheels if len(moments) <= most_moments() // 2 and len(moments) <= 2 and len(wheels) == 2 else [""]
    return [GalleryColumn(moment, i, wheel) for i, moment in enumerate(moments) for wheel in sides]


def patches_in(dataset: xr.Dataset, columns: Sequence[GalleryColumn]) -> dict[tuple[str, int], dict[int, PatchAt]]:
    """Patches of each row by column. Rows: wheel (none where the columns have one) and number of the patch."""
    finite = np.isfinite(dataset["strip_p"].values).any(axis=-1)
    wheels = [str(w) for w in dataset["wheel"].values]
    rows = {}
    for wheel, patch in product([""] if any(c.wheel for c in columns) else wheels, range(finite.shape[2])):
        wanted = [PatchAt(c.moment, wheel or c.wheel, patch) for c in columns]
        if cells := {j: w for j, w in enumerate(wanted) if finite[w.moment, wheels.index(w.wheel), patch]}:
            rows[wheel, patch] = cells
    return rows


def selection_note(dataset: xr.Dataset, chosen: Sequence[int]) -> str:
    """How many of the moments that have patches are drawn, where it is not all of them; on a line of its own."""
    count = int(with_patches(dataset).sum())
    noun = "moments" if moment_dim(dataset) == "snapshot" else "poses"
    return f"\n{len(chosen)} of {count} {noun}; any other: wrsim plot --at." if len(chosen) < count else ""


@theme.style()
def draw_gallery(
    title: str,
    note: str,
    dataset: xr.Dataset,
    page: Page,
    blocks: Sequence[tuple[Sequence[GalleryColumn], Sequence[GalleryRow]]],
    scale: Normalize,
    reading: str,
) -> Figure:
    """Blocks of rows beneath the titles of their columns. note: in red, of a stopped analysis; dataset: of the moments
    in the columns; reading: how to read the picture."""
    titles = [[_title(page, dataset, column) for column in columns] for columns, _ in blocks]
    above = 5.0 + 3.0 * max((text.count("\n") for texts in titles for text in texts), default=0)
    top = 7.0 + theme.head_height(title, note, page.width)
    heights = sum(row.height + row.beneath for _, rows in blocks for row in rows)
    beside = page.width >= _NARROWEST  # the words on how to read it are beside the scale of pressure, or beneath it
    reading = theme.wrapped(theme.caption(reading), page.width - (78.0 if beside else 8.0), 6.8)
    foot = FOOT + (max(0.0, 3.0 * reading.count("\n") - 6.0) if beside else 3.0 * reading.count("\n") + 4.0)
    figure = theme.new_figure(page.width, top + heights + len(blocks) * above + foot, constrained=False)
    theme.headline(figure, title, note)
    for (columns, rows), row_titles in zip(blocks, titles, strict=True):
        for j, (column, text) in enumerate(zip(columns, row_titles, strict=True)):
            colour = theme.WHEEL_COLOUR.get(column.wheel, theme.INK)
            theme.write_text(figure, page.place_of(j), top + 0.8, text, fontsize=6.8, color=colour)
        top += above
        for row in rows:
            look: Any = {"rotation": 90, "va": "center", "fontsize": 7.0} if page.upright else {"fontsize": 6.0}
            left, down = (2.0, 0.5) if page.upright else (1.5, 0.3)
            theme.write_text(figure, left, top + down * row.height, row.label, color=row.colour, **look)
            for j, draw in row.cells.items():
                draw(theme.mm_axes(figure, page.place_of(j), top, page.panel, row.height))
            top += row.height + row.beneath
    colours, place = ScalarMappable(scale, theme.pressure_map()), theme.mm_axes(figure, 16.0, top + 1.0, 55.0, 2.2)
    bar = figure.colorbar(colours, cax=place, orientation="horizontal")
    bar.set_label("Contact pressure p [MPa]", labelpad=1.0)
    bar.ax.tick_params(width=0.4)
    corner = (76.0, top + 1.0) if beside else (6.0, top + FOOT - 2.0)
    theme.write_text(figure, *corner, reading, fontsize=6.8, color=theme.QUIET)
    return figure


def _title(page: Page, dataset: xr.Dataset, column: GalleryColumn) -> str:
    lines = moment_title(dataset, column.moment, column.order).split("\n")
    lines += [f"{column.wheel} wheel"] if column.wheel else []
    widest = int((page.panel + 0.5 * page.gap) / _LETTER)
    return "\n".join(line if "$" in line else fill(line, widest) for line in lines)
