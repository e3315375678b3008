"""Draw docs/figures/strips.png, axes and strips of the strip model: ``python docs/figures/make_strips.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim import ContactSettings, Pose, contact_model, load_profile, solve_poses
from wrsim.contact.model import ContactModel
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
MODELS = HERE.parents[1] / "models"
MM = 1e3
UM = 1e6


def section(axes: Axes, model: ContactModel) -> None:
    """Penetration over the curved axis, its edges, and the pressure in the middle of each strip."""
    a = model.arrays
    grid, rows = a.rows.grids[0], a.rows.rows[0]
    strips = a.strips[0, : a.patches[0].n_strips]
    s = MM * (strips["s"] + a.patches[0].arc_rail)
    width = MM * strips["ds"]
    axes.bar(s, 1e-6 * strips["p"], width, color="C0", alpha=0.35, edgecolor="C0", linewidth=0.5)
    axes.set(xlabel="curved axis $s$ [mm]", ylabel="pressure $p(0)$ of the strips [MPa]")
    right_axes = axes.twinx()
    right_axes.plot(MM * rows["s"], UM * rows["d"], color="0.3")
    right_axes.set(ylabel="penetration $d$ [µm]", ylim=(0.0, None))
    for edge in (grid["start"], grid["end"]):
        axes.axvline(MM * edge, color="C3", linestyle=":", linewidth=0.9)


def plan(axes: Axes, model: ContactModel) -> None:
    """Strips from above, the three points of each, and the contact locus."""
    a = model.arrays
    rows = a.rows.rows[0]
    places = a.rows.places[: int(a.model.strips)]
    for place in places[places["y"] > 0.0]:
        half, middle = np.sqrt(place["y"]), place["x"] + place["off"]
        lo, hi = MM * place["lo"], MM * place["hi"]
        box = MM * np.array([middle - half, middle + half])
        axes.fill_between([lo, hi], box[0], box[1], color="C0", alpha=0.25, edgecolor="C0", linewidth=0.5)
        points = MM * (middle + half * np.array([-np.sqrt(0.75), 0.0, np.sqrt(0.75)]))
        axes.plot(np.full(3, MM * place["s"]), points, "k.", ms=3)
    axes.plot(MM * rows["s"], MM * rows["x"], "--", color="C3", linewidth=1.0)
    axes.set(xlabel="curved axis $s$ [mm]", ylabel="along the rail $x$ [mm]")


def draw() -> Figure:
    """Solve the pose and draw both views."""
    rail = load_profile(MODELS / "rails/60E1.toml").inclined(1 / 40)
    settings = ContactSettings(tangential="none")
    model = contact_model(load_profile(MODELS / "wheels/S1002.toml"), rail, 0.46, settings)
    solve_poses(model, [Pose("flange root", lateral=6.4e-3, yaw=8e-3, load=60e3)])
    figure = new_figure(180, 80)
    left, right = figure.subplots(1, 2)
    section(left, model)
    plan(right, model)
    return figure


def main() -> None:
    """Write the picture."""
    with style():
        print(save(draw(), HERE / "strips.png"))


if __name__ == "__main__":
    main()
