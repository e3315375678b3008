"""Makes braking.png from a run of scenarios/braking.toml. Run: python docs/figures/make_braking.py"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent


def main() -> None:
    """Run the scenario and draw."""
    dataset = run(load(HERE.parents[1] / "scenarios" / "braking.toml")).dataset
    with style():
        print(save(draw(dataset), HERE / "braking.png"))


def draw(dataset: xr.Dataset) -> Figure:
    """Moment, creepage and work of every axle, and the speed of the vehicle, over the time."""
    figure = new_figure(180, 140)
    axes = figure.subplots(2, 2, sharex=True)
    time = dataset["time"]
    rows = (
        ("drive_moment", 1e-3, "moment, kN m"),
        ("axle_creepage", 1e2, "creepage, %"),
        ("drive_work", 1e-3, "work, kJ"),
    )
    for ax, (name, scale, label) in zip(axes.flat, rows, strict=False):
        for wheelset in dataset["wheelset"].values:
            ax.plot(time, scale * dataset[name].sel(wheelset=wheelset), label=str(wheelset))
        ax.set_ylabel(label)
    axes[0, 0].legend()
    axes[1, 1].plot(time, 3.6 * dataset["speed"], color="black")
    axes[1, 1].set_ylabel("speed, km/h")
    for ax in axes[1]:
        ax.set_xlabel("time, s")
    return figure


if __name__ == "__main__":
    main()
