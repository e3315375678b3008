"""Table 2 of the paper beside ours: the four static cases, with a stand-in wheel that was fitted to that table.

    python campaigns/table2.py            # runs scenarios/static_paper.toml and prints both
    python campaigns/table2.py --write    # and renews tables and pictures of docs/developers/static_paper.md

See docs/developers/static_paper.md for what agreement means here and what it does not.
"""

import argparse
import csv
from collections.abc import Sequence
from math import pi
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipk

from wrsim import load, run
from wrsim.plots.cross_section import section_gallery
from wrsim.plots.patches import patch_gallery
from wrsim.plots.theme import style

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[1]
SCENARIO = ROOT / "scenarios" / "static_paper.toml"
PUBLISHED = ROOT / "campaigns" / "paper_table2.csv"
PAGE = ROOT / "docs" / "developers" / "static_paper.md"
PICTURES = ROOT / "docs" / "figures"

QUANTITIES = ("strips", "p0_MPa", "variation_deg")

DEGREES = 180.0 / pi
EPSILON = 0.55
MODULUS = 208e9 / (2.0 * (1.0 - 0.3**2))
"""E / (2 (1 - sigma^2)) of table 1 [Pa]."""
RADIUS, LOAD = 0.375, 24e3
"""Of the wheel [m]; vertical [N]."""
RAIL_RADII = (0.300, 0.013, 0.013, 0.013)
"""Of the 54E1 where the four contacts lie [m]."""


def published() -> tuple[Array, Array]:
    """Lateral shifts (4,) [mm] and the paper's numbers (4, 3) in the order of QUANTITIES."""
    lines = [line for line in PUBLISHED.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = [[float(row[name]) for name in ("lateral_mm", *QUANTITIES)] for row in csv.DictReader(lines)]
    table = np.array(rows)
    return table[:, 0], table[:, 1:]


def ours(dataset: xr.Dataset) -> Array:
    """The same numbers (4, 3) of the patch that carries most."""
    main = dataset.isel(wheel=0, patch=0)
    columns = (("n_strips", 1.0), ("p0", 1e-6), ("contact_angle_variation", DEGREES))
    return np.column_stack([main[name].values * factor for name, factor in columns])


def comparison(dataset: xr.Dataset) -> str:
    """Both tables as one in Markdown, and what the paper does not tell of each case."""
    shifts, paper = published()
    computed = ours(dataset)
    main = dataset.isel(wheel=0, patch=0)
    lines = _head(shifts)
    names = ("number of strips", "largest pressure [MPa]", "variation of the contact angle [deg]")
    for i, (name, form) in enumerate(zip(names, ("{:.0f}", "{:.0f}", "{:.2f}"), strict=True)):
        lines.append(_row(f"**{name}**, paper", [f"{v:g}" for v in paper[:, i]]))
        lines.append(_row("with the stand-in wheel", [form.format(v) for v in computed[:, i]]))
        lines.append(_row("difference", [f"{v:+.0f} %" for v in 100.0 * (computed[:, i] / paper[:, i] - 1.0)]))
    rise = dataset["vertical_shift"] - dataset["vertical_shift"][0]
    quantities = {
        "contact angle at the main point [deg]": (main["contact_angle"] * DEGREES, "{:.1f}"),
        "normal force [kN]": (main["N"] / 1e3, "{:.1f}"),
        "approach [um]": (main["approach"] * 1e6, "{:.0f}"),
        "length of the patch along the rail [mm]": (main["length"] * 1e3, "{:.1f}"),
        "width along the curved axis [mm]": (main["width"] * 1e3, "{:.2f}"),
        "height over the wheel's place at 0 mm [mm]": (rise * 1e3, "{:.2f}"),
        "number of patches": (dataset["n_patches"].isel(wheel=0), "{:.0f}"),
    }
    lines += [_row(name, [form.format(float(v)) for v in values.values]) for name, (values, form) in quantities.items()]
    return "\n".join(lines)


def hertzian(normal: float, along: float, across: float) -> tuple[float, float]:
    """Half width across [m] and p0 [Pa] of Kik and Piotrowski's model for constant radii [m] and a normal force [N].

    The patch is an ellipse with half axes sqrt(2 R eps delta), the pressure a half ellipsoid, whose displacement at
    the middle is p0 b K(m) / E* (Johnson, Contact Mechanics, 3.2), b the smaller half axis, m = 1 - (b/a)^2.
    """

    def state(approach: float) -> tuple[float, float, float]:
        a, b = np.sqrt(2.0 * EPSILON * approach * np.array([along, across]))
        short, long = min(a, b), max(a, b)
        p0 = approach * MODULUS / (short * float(ellipk(1.0 - (short / long) ** 2)))
        return float(b), p0, 2.0 / 3.0 * pi * float(a * b) * p0

    approach = brentq(lambda d: state(d)[2] - normal, 1e-7, 1e-2, xtol=1e-16)
    b, p0, _ = state(float(approach))
    return b, p0


def each_alone(dataset: xr.Dataset) -> str:
    """What the paper's numbers say of each case by itself, if wheel and rail were arcs across the patch.

    The contact angle, which the paper does not give, is ours; it matters little, for the normal force and the radius
    along the rail grow alike with it.
    """
    shifts, paper = published()
    angles = dataset["contact_angle"].isel(wheel=0, patch=0).values
    rows: list[tuple[float, ...]] = []
    for (strips, p0, variation), angle, rail in zip(paper, angles, RAIL_RADII, strict=True):
        normal, along = LOAD / np.cos(angle), RADIUS / np.cos(angle)
        relative = float(brentq(lambda r, n=normal, a=along, p=p0: hertzian(n, a, r)[1] / 1e6 - p, 1e-3, 10.0))
        width = 2.0 * hertzian(normal, along, relative)[0]
        rows.append(
            (
                1e3 * relative,
                1e3 * width,
                1e3 * width / strips,
                1e3 / (1.0 / rail - 1.0 / relative),
                np.degrees(width * (1.0 / rail - 0.5 / relative)),
                variation,
            )
        )
    names = (
        ("relative radius across that gives p0 [mm]", "{:.3g}"),
        ("width of the patch then [mm]", "{:.2f}"),
        ("width of a strip then [mm]", "{:.3f}"),
        ("radius of the wheel then, hollow [mm]", "{:.3g}"),
        ("variation of the angle then [deg]", "{:.2f}"),
        ("variation in the paper [deg]", "{:.2f}"),
    )
    lines = _head(shifts)
    lines += [_row(name, [form.format(row[i]) for row in rows]) for i, (name, form) in enumerate(names)]
    return "\n".join(lines)


def _head(shifts: Array) -> list[str]:
    return [_row("lateral shift [mm]", [f"{s:g}" for s in shifts]), "|---|" + "---|" * len(shifts)]


def _row(name: str, cells: Sequence[str]) -> str:
    return f"| {name} | " + " | ".join(c.replace("-", "\N{MINUS SIGN}") for c in cells) + " |"


def marks(name: str) -> tuple[str, str]:
    """What stands around a generated table of the page."""
    return f"<!-- {name}: made by campaigns/table2.py --write -->", f"<!-- end of {name} -->"


def write(dataset: xr.Dataset) -> None:
    """Renew the tables of the documentation page between their marks, and its pictures."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in {"comparison": comparison(dataset), "each alone": each_alone(dataset)}.items():
        begin, end = marks(name)
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n{table}\n{end}{rest.partition(end)[2]}"
    PAGE.write_text(text, encoding="utf-8")
    _save(patch_gallery(dataset), "static_paper_patches.png")
    _save(section_gallery(dataset), "static_paper_sections.png")


def _save(figure: Figure, name: str) -> None:
    with style():
        figure.savefig(PICTURES / name, dpi=150, metadata={"Software": None})


def main() -> None:
    """Run the scenario and compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--write", action="store_true", help="renew docs/developers/static_paper.md and its pictures")
    arguments = parser.parse_args()
    dataset = run(load(SCENARIO)).wheelset()
    print(comparison(dataset))
    print("\nEach case alone, for arcs across the patch:")
    print(each_alone(dataset))
    if arguments.write:
        write(dataset)


if __name__ == "__main__":
    main()
