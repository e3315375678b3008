"""Makes low_adhesion.png from runs of scenarios/low_adhesion.toml. Run: python docs/figures/make_low_adhesion.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
LIMITS = (0.002, 0.004, 0.008, 0.02, 0.06, 0.1, 0.2, 0.3)
CASES = {
    "drying, layer": {},
    "drying, no layer": {"contact.layer.thickness_mm": 1e-6},
    "no drying, layer": {"contact.temperature.friction_change": 0.0},
}


def main() -> None:
    """Run the scenario with limits of the slip control, with and without drying and layer, and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "low_adhesion.toml")
    common = {"run.time_s": 1.5}
    runs = {
        name: [
            run(scenario.with_values(common | changes | {"vehicle.slip_control.creepage": limit})).dataset
            for limit in LIMITS
        ]
        for name, changes in CASES.items()
    }
    with style():
        print(save(draw(runs), HERE / "low_adhesion.png"))


def draw(runs: dict[str, list[xr.Dataset]]) -> Figure:
    """Pull of the leading axle over its load, and temperature, over its creepage at the end of the runs."""
    figure = new_figure(180, 70)
    axes = figure.subplots(1, 2)
    for name, datasets in runs.items():
        last = [dataset.isel(time=-1, wheelset=0) for dataset in datasets]
        creepage = [100.0 * abs(float(sample["axle_creepage"])) for sample in last]
        pull = [abs(float(sample["X"].sum() / sample["Q"].sum())) for sample in last]
        axes[0].plot(creepage, pull, marker="o", label=name)
        axes[1].plot(creepage, [float(np.nanmax(sample["temperature"])) for sample in last], marker="o")
        for each, heat, force in zip(creepage, last, pull, strict=True):
            print(f"{name}: creepage {each:.2f} %, X/Q {force:.3f}, {float(np.nanmax(heat['temperature'])):.0f} degC")
    axes[0].set_ylabel("pull over load of the leading axle")
    axes[0].legend()
    axes[1].set_ylabel("largest surface temperature, °C")
    for ax in axes:
        ax.set_xlabel("creepage, %")
        ax.set_xscale("log")
    return figure


if __name__ == "__main__":
    main()
