"""Table 2 of the paper beside ours: the four static cases, with a stand-in wheel that was fitted to that table.

    python benchmarks/table2.py            # runs scenarios/static_paper.toml and prints both
    python benchmarks/table2.py --write    # and renews table and picture of docs/static_paper.md

See docs/static_paper.md for what agreement means here and what it does not.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim import load, run
from wrsim.plots.patches import patch_gallery
from wrsim.plots.style import save, style

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[1]
SCENARIO = ROOT / "scenarios" / "static_paper.toml"
PUBLISHED = ROOT / "benchmarks" / "paper_table2.csv"
PAGE = ROOT / "docs" / "static_paper.md"
PICTURE = ROOT / "docs" / "figures" / "static_paper_patches.png"
BEGIN, END = "<!-- begin: benchmarks/table2.py --write -->", "<!-- end -->"

QUANTITIES = ("strips", "p0_MPa", "variation_deg")


def published() -> tuple[Array, Array]:
    """Lateral shifts (4,) [mm] and the paper's numbers (4, 3) in the order of QUANTITIES."""
    lines = [line for line in PUBLISHED.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = [[float(row[name]) for name in ("lateral_mm", *QUANTITIES)] for row in csv.DictReader(lines)]
    table = np.array(rows)
    return table[:, 0], table[:, 1:]


def ours(dataset: xr.Dataset) -> Array:
    """The same numbers (4, 3) of the patch that carries most."""
    main = dataset.isel(wheel=0, patch=0)
    columns = [main["n_strips"], main["p0"] / 1e6, np.degrees(main["contact_angle_variation"])]
    return np.column_stack([np.asarray(c.values, dtype=float) for c in columns])


def comparison(dataset: xr.Dataset) -> str:
    """Both tables as one in Markdown, and what the paper does not tell of each case."""
    shifts, paper = published()
    here = ours(dataset)
    main = dataset.isel(wheel=0, patch=0)
    lines = ["| lateral shift [mm] | " + " | ".join(f"{s:g}" for s in shifts) + " |"]
    lines.append("|---|" + "---|" * len(shifts))
    names = ("number of strips", "largest pressure [MPa]", "variation of contact angle [deg]")
    for i, (name, form) in enumerate(zip(names, ("{:.0f}", "{:.0f}", "{:.2f}"), strict=True)):
        lines.append(_row(f"{name}, paper", [f"{v:g}" for v in paper[:, i]]))
        lines.append(_row("wrsim, stand-in wheel", [form.format(v) for v in here[:, i]]))
        lines.append(_row("difference", [f"{v:+.0f} %" for v in 100.0 * (here[:, i] / paper[:, i] - 1.0)]))
    others = {
        "contact angle at the main point [deg]": (np.degrees(main["contact_angle"]), "{:.1f}"),
        "normal force [kN]": (main["N"] / 1e3, "{:.1f}"),
        "approach [um]": (main["approach"] * 1e6, "{:.0f}"),
        "length of the patch along the rail [mm]": (main["length"] * 1e3, "{:.1f}"),
        "width along the curved axis [mm]": (main["width"] * 1e3, "{:.2f}"),
        "height of the wheel above its place at 0 mm [mm]": (
            1e3 * (dataset["vertical_shift"] - dataset["vertical_shift"][0]),
            "{:.2f}",
        ),
        "patches": (dataset["n_patches"].isel(wheel=0), "{:.0f}"),
    }
    for name, (values, form) in others.items():
        lines.append(_row(name, [form.format(float(v)) for v in values.values]))
    return "\n".join(lines)


def _row(name: str, cells: list[str]) -> str:
    return f"| {name} | " + " | ".join(c.replace("-", "\N{MINUS SIGN}") for c in cells) + " |"


def write(dataset: xr.Dataset) -> None:
    """Renew the table of the documentation page between its marks, and its picture."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}\n{comparison(dataset)}\n{END}{after}", encoding="utf-8")
    with style():
        save(patch_gallery(dataset), PICTURE)


def main() -> None:
    """Run the scenario and compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--write", action="store_true", help="renew docs/static_paper.md and its picture")
    arguments = parser.parse_args()
    dataset = run(load(SCENARIO)).dataset
    print(comparison(dataset))
    if arguments.write:
        write(dataset)


if __name__ == "__main__":
    main()
