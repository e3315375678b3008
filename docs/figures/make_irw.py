"""Makes irw.png: the light rail vehicle with independent wheels into its curve.

Run: python docs/figures/make_irw.py REFERENCE. With the wheel and the rail of its source, which are not shipped;
REFERENCE: see campaigns/gz18.py.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from wrsim import run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "campaigns"))
import gz18  # noqa: E402


def main() -> None:
    """Run from the straight into the curve and draw."""
    if len(sys.argv) != 2:
        raise SystemExit("python docs/figures/make_irw.py REFERENCE")
    reference = gz18.reference_folder(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        result = run(gz18.scenario(reference, Path(folder), "r300", car="irw"))
    with style():
        print(save(draw(result.dataset.isel(wheelset=0)), HERE / "irw.png"))


def draw(dataset: xr.Dataset) -> Figure:
    """Shift, yaw, wheel loads and guiding forces of the leading wheelset over the distance."""
    figure = new_figure(180, 140)
    axes = figure.subplots(2, 2, sharex=True)
    distance = dataset["distance"]
    axes[0, 0].plot(distance, 1e3 * dataset["lateral_shift"], color="black")
    axes[0, 0].set_ylabel("lateral shift, mm (left, outward, +)")
    axes[0, 1].plot(distance, 1e3 * dataset["yaw"], color="black")
    axes[0, 1].set_ylabel("yaw, mrad (nose outward +)")
    for ax, name, label in ((axes[1, 0], "Q", "wheel load, kN"), (axes[1, 1], "Y", "guiding force, kN (outward +)")):
        for wheel, side in (("left", "left, outer wheel"), ("right", "right, inner wheel")):
            ax.plot(distance, 1e-3 * dataset[name].sel(wheel=wheel), label=side)
        ax.set_ylabel(label)
        ax.set_xlabel("distance, m")
    axes[1, 1].legend()
    return figure


if __name__ == "__main__":
    main()
