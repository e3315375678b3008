"""Makes motor_coach.png from a run of scenarios/motor_coach.toml. Run: python docs/figures/make_motor_coach.py"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from wrsim import load, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
AXLES = ("front.bogie.outer", "front.bogie.inner")


def main() -> None:
    """Run the scenario and draw."""
    dataset = run(load(HERE.parents[1] / "scenarios" / "motor_coach.toml")).dataset
    with style():
        print(save(draw(dataset), HERE / "motor_coach.png"))


def draw(dataset: xr.Dataset) -> Figure:
    """Moments of motor and hollow axle, load of the driven axles, torque arms and speed over the time."""
    figure = new_figure(180, 130)
    moments, loads, arms, speed = figure.subplots(2, 2, sharex=True).flat
    time = dataset["time"]
    moments.plot(time, 1e-3 * dataset["drive_moment"].sel(wheelset=AXLES[0]), color="black", label="motor times ratio")
    for axle in AXLES:
        moments.plot(time, 1e-3 * dataset["shaft_moment"].sel(wheelset=axle), label=f"hollow axle {axle}")
        loads.plot(time, 1e-3 * dataset["Q"].sel(wheelset=axle).sum("wheel"), label=axle)
    for end in ("leading", "trailing"):
        arms.plot(time, 1e-3 * dataset["suspension_fx"].sel(suspension=f"front.{end} torque arm"), label=end)
    speed.plot(time, 3.6 * dataset["speed"], color="black")
    for ax, label in ((moments, "moment, kN m"), (loads, "axle load, kN"), (arms, "tension of torque arm, kN")):
        ax.set_ylabel(label)
        ax.legend(fontsize=6.5)
    speed.set_ylabel("speed, km/h")
    for ax in (arms, speed):
        ax.set_xlabel("time, s")
    return figure


if __name__ == "__main__":
    main()
