"""Makes gust.svg, the gust of EN 14067-6 along the track. Run: python docs/figures/make_gust.py"""

from __future__ import annotations

from pathlib import Path

from wrsim.plots import new_figure, save, style
from wrsim.vehicle.wind import felt

HERE = Path(__file__).parent
LARGEST, BEGINS, PEAK = 28.0, 0.0, 250.0


def main() -> None:
    """Draw the wind at a point and that of a vehicle."""
    with style():
        figure = new_figure(110.0, 60.0)
        axes = figure.add_subplot()
        for length, label in ((0.5, "at a point"), (21.56, "mean over 21.6 m")):
            axes.plot(*felt(LARGEST, BEGINS, PEAK, length, gusty=True), label=label)
        axes.set(xlabel="distance along the track (m)", ylabel="wind (m/s)", ylim=(0.0, None))
        axes.legend()
        print(save(figure, HERE / "gust.svg"))


if __name__ == "__main__":
    main()
