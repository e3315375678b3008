"""Makes independent.png from runs of scenarios/independent_wheels.toml. Run: python docs/figures/make_independent.py"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
KINDS = {
    "rigid axle": "vehicles/wheelset_s1002_leading.toml",
    "independent wheels": "vehicles/wheelset_s1002_independent.toml",
}


def main() -> None:
    """Run the scenario with either wheelset and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "independent_wheels.toml")
    datasets = {name: run(scenario.with_values({"vehicle.model": file})).wheelset() for name, file in KINDS.items()}
    with style():
        print(save(draw(datasets), HERE / "independent.png"))


def draw(datasets: dict[str, xr.Dataset]) -> Figure:
    """Shift, angle of attack, longitudinal and guiding force of the outer wheel over the distance."""
    figure = new_figure(180, 140)
    axes = figure.subplots(2, 2, sharex=True)
    rows = (
        ("lateral_shift", 1e3, "lateral shift, mm"),
        ("yaw", 1e3, "angle of attack, mrad"),
        ("X", 1e-3, "longitudinal force of the right wheel, kN"),
        ("Y", 1e-3, "guiding force of the right wheel, kN"),
    )
    for ax, (name, scale, label) in zip(axes.flat, rows, strict=True):
        for kind, dataset in datasets.items():
            values = dataset[name].sel(wheel="right") if "wheel" in dataset[name].dims else dataset[name]
            ax.plot(dataset["distance"], scale * values, label=kind)
        ax.set_ylabel(label)
    axes[0, 0].legend()
    for ax in axes[1]:
        ax.set_xlabel("distance, m")
    return figure


if __name__ == "__main__":
    main()
