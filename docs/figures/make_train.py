"""Makes train.png from a run of scenarios/train_s_curve.toml. Run: python docs/figures/make_train.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
COLOURS = {"left": "#0072B2", "right": "#D55E00", "hook": "#222222"}


def main() -> None:
    """Run the scenario and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "train_s_curve.toml")
    with style():
        print(save(draw(run(scenario).dataset), HERE / "train.png"))


def draw(d: xr.Dataset) -> Figure:
    """Buffers and hook between the first two coaches, lateral forces, offset of the ends, guiding forces."""
    figure = new_figure(180, 150)
    (forces, strokes), (lateral, guiding) = axes = figure.subplots(2, 2, sharex=True)
    x, gap = d["distance"].values, str(d["coupling"].values[0])
    for side in ("left", "right"):
        name = f"{gap} buffer {side}"
        forces.plot(x, -1e-3 * of(d, "suspension_fx", name), color=COLOURS[side], label=f"{side} buffers")
        strokes.plot(x, -1e3 * of(d, "suspension_dx", name), color=COLOURS[side], label=f"{side} buffers")
    forces.plot(x, 1e-3 * of(d, "suspension_fx", f"{gap} draw gear"), color=COLOURS["hook"], label="hook, pull")
    strokes.plot(x, 1e3 * d["coupling_offset"].values[:, 0], color=COLOURS["hook"], ls="--", label="offset of the ends")
    for name, colour, label in (("ahead", "#009E73", "on the coach ahead"), ("behind", "#9467A9", "on that behind")):
        lateral.plot(x, 1e-3 * d[f"coupling_fy_{name}"].values[:, 0], color=colour, label=label)
    for k, colour in enumerate(("#0072B2", "#D55E00", "#009E73")):
        wheelset = d.sel(wheelset=f"coach{k + 1}.front.outer")
        distance = wheelset["wheelset_distance"]
        guiding.plot(distance, 1e-3 * wheelset["sum_Y"], color=colour, lw=0.7, label=f"coach {k + 1}, leading wheelset")
    for ax, label in (
        (forces, "force between coaches 1 and 2, kN"), (strokes, "way, mm (buffers: pressed positive)"),
        (lateral, "lateral force, to the left, kN"), (guiding, "track shifting force, to the left, kN"),
    ):  # fmt: skip
        finish(ax, label)
    for ax in axes[1]:
        ax.set_xlabel("distance of the first coach (last: of each wheelset), m")
    return figure


def of(d: xr.Dataset, channel: str, element: str) -> np.ndarray:
    """A channel of an element."""
    return np.asarray(d[channel].sel(suspension=element).values)


def finish(ax: Axes, label: str) -> None:
    """Label a panel."""
    ax.set_ylabel(label)
    ax.legend(fontsize=6.0)


if __name__ == "__main__":
    main()
