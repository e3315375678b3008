"""Makes freight.png from runs of scenarios/freight_r300.toml and freight_r300_laden.toml.

Run: python docs/figures/make_freight.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
RUNS = (("empty", "freight_r300"), ("laden", "freight_r300_laden"))


def channel(dataset: xr.Dataset, name: str, of: str) -> np.ndarray:
    """A channel of an element."""
    return np.asarray(dataset[name].sel(suspension=of).values)


def draw(datasets: dict[str, xr.Dataset]) -> Figure:
    """Guiding force of the leading wheelset's outer wheel, pusher and guide of its box, bearer of the front bogie."""
    figure = new_figure(180, 140)
    force, pusher, guide, bearer = figure.subplots(2, 2).flat
    for name, dataset in datasets.items():
        distance = dataset["distance"]
        force.plot(distance, 1e-3 * dataset["Y"].sel(wheelset="front.outer", wheel="right"), label=name)
        for ax, element, axis in (
            (pusher, "front.pusher outer right", "x"),
            (guide, "front.guide outer right", "z"),
            (bearer, "front.bearer friction right", "x"),
        ):
            travel, pull = (channel(dataset, f"suspension_{kind}{axis}", element) for kind in "df")
            ax.plot(1e3 * travel, -1e-3 * pull)
    force.set_xlabel("distance, m")
    force.set_ylabel("Y of the leading outer wheel, kN")
    force.legend()
    for ax, name in ((pusher, "pusher, along"), (guide, "guide, vertical"), (bearer, "side bearer, along")):
        ax.set_xlabel("travel, mm")
        ax.set_ylabel(f"{name}, kN")
    return figure


def main() -> None:
    """Run the scenarios and draw."""
    scenarios = HERE.parents[1] / "scenarios"
    datasets = {name: run(load(scenarios / f"{file}.toml")).dataset for name, file in RUNS}
    with style():
        print(save(draw(datasets), HERE / "freight.png"))


if __name__ == "__main__":
    main()
