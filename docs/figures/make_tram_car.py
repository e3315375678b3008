"""Makes tram_car.png from a run of scenarios/tram_car_r25.toml. Run: python docs/figures/make_tram_car.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent


def main() -> None:
    """Run the scenario and draw."""
    dataset = run(load(HERE.parents[1] / "scenarios" / "tram_car_r25.toml")).dataset
    with style():
        print(save(draw(dataset), HERE / "tram_car.png"))


def draw(dataset: xr.Dataset) -> Figure:
    """What flanges and backs of flanges press sideways, and forces lengthwise, over the place of each wheelset."""
    figure = new_figure(180, 80)
    left, right = figure.subplots(1, 2)
    angle, normal = dataset["contact_angle"].values, 1e-3 * dataset["N"].values
    pressed = np.where(np.abs(angle) > 0.5, normal * np.sin(angle), 0.0)
    for i, name in enumerate(dataset["wheelset"].values):
        place, colour = dataset["wheelset_distance"].values[:, i], f"C{i}"
        # backs of the inner wheels push the other way than their flanges
        guard = -np.nansum(np.where(pressed[:, i, 1] < 0.0, pressed[:, i, 1], 0.0), axis=-1)
        flange = np.nansum(np.where(pressed[:, i] > 0.0, pressed[:, i], 0.0), axis=(-2, -1))
        left.plot(place, guard, color=colour, label=f"{name}")
        left.plot(place, -flange, color=colour, linestyle=":")
        right.plot(place, 1e-3 * dataset["X"].values[:, i, 0], color=colour)
    left.axhline(0.0, color="0.5", linewidth=0.5)
    left.set(xlabel="place of the wheelset, m", ylabel="guard faces up, flanges down (dotted), kN", ylim=(-35, 60))
    right.set(xlabel="place of the wheelset, m", ylabel="X of the outer wheel, kN")
    left.legend(loc="upper right", fontsize=7)
    return figure


if __name__ == "__main__":
    main()
