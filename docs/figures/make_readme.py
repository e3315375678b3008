"""Makes readme.png from a run of scenarios/curve_r150_sharp.toml. Run: python docs/figures/make_readme.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style
from wrsim.plots.cross_section import cross_section_zoom
from wrsim.plots.histories import contact_angle, history, track_layout
from wrsim.plots.moments import PatchAt
from wrsim.plots.patches import contact_patch, pressure_scale
from wrsim.plots.theme import pressure_map

HERE = Path(__file__).parent


def main() -> None:
    """Run the scenario and draw."""
    dataset = run(load(HERE.parents[1] / "scenarios" / "curve_r150_sharp.toml")).wheelset()
    with style():
        print(save(draw(dataset), HERE / "readme.png"))


def draw(dataset: xr.Dataset) -> Figure:
    """Contact angle, Y/Q and shift over the track; section and patch where the outer patch is steepest."""
    figure = new_figure(230, 150)
    grid = figure.add_gridspec(4, 2, width_ratios=(1.5, 1.0), height_ratios=(1.2, 1.0, 1.0, 0.5))
    left = [figure.add_subplot(grid[i, 0]) for i in range(4)]
    contact_angle(left[0], dataset, "right")
    history(left[1], dataset, "Y_over_Q")
    history(left[2], dataset, "lateral_shift")
    track_layout(left[3], dataset)
    for axes in left[:-1]:
        axes.sharex(left[-1])
        axes.tick_params(labelbottom=False)
        axes.set_xlabel("")
    moment = int(np.argmax(dataset.strip_angle.sel(wheel="right").max(("patch", "strip")).values))
    place = PatchAt(moment, "right", 0)
    scale = pressure_scale(dataset, [moment])
    section = figure.add_subplot(grid[:2, 1])
    cross_section_zoom(section, dataset, place, scale)
    section.set_title("Outer wheel: pressure on the curved patch", fontsize="medium", loc="left")
    patch = figure.add_subplot(grid[2:, 1])
    contact_patch(patch, dataset, place, scale)
    patch.set_xlabel("curved axis $s$ [mm], field side to the right")
    patch.set_ylabel("along the rail $x$ [mm]")
    colours = figure.colorbar(ScalarMappable(scale, pressure_map()), ax=patch, shrink=0.9)
    colours.set_label("pressure [MPa]")
    section.set_xlabel("outward [mm]")
    section.set_ylabel("up [mm]")
    return figure


if __name__ == "__main__":
    main()
