"""Makes tram.png from runs of scenarios/tram_r25.toml. Run: python docs/figures/make_tram.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from wrsim import load, load_profile, run
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
SHIFTED = 3.14
"""Of the wheelset at a gauge of 1435 mm [mm]."""
GAUGES = np.arange(1432.9, 1434.01, 0.05)


def main() -> None:
    """Run the scenario over the gauge and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "tram_r25.toml")
    rows = []
    for gauge in GAUGES:
        wheelset = run(scenario.with_values({"track.gauge_mm": float(gauge)})).wheelset()
        last = wheelset.isel(time=int(np.argmin(np.abs(wheelset["distance"].values - 15.0))))
        angle, normal = last["contact_angle"].values, 1e-3 * last["N"].values
        steep = np.where(np.abs(angle) > 0.5, np.abs(np.sin(angle)) * normal, 0.0)
        rows.append(np.nansum(steep, axis=1))
    with style():
        print(save(draw(np.array(rows)), HERE / "tram.png"))


def draw(rows: np.ndarray) -> Figure:
    """The wheel in the narrow groove where its back touches, and who guides over the gauge."""
    figure = new_figure(180, 80)
    left, right = figure.subplots(1, 2)
    rail, wheel = load_profile("rails/grooved_narrow.toml"), load_profile("wheels/tram.toml")
    shift = 756.0 - 752.5 + SHIFTED  # of the wheel against the rail, towards the middle of the track
    left.fill_between(1e3 * rail.u, 1e3 * rail.w, -55.0, color="0.85")
    left.plot(1e3 * rail.u, 1e3 * rail.w, color="0.3")
    left.plot(1e3 * wheel.u - shift, 1e3 * wheel.w, color="tab:blue")
    left.set(xlabel="outward, mm", ylabel="up, mm", aspect="equal", xlim=(-90, 35), ylim=(-52, 15))
    left.set_title("inner rail and wheel at the axle, gauge 1435 mm", fontsize=8)
    right.plot(GAUGES, rows[:, 0], ".-", label="outer wheel, flange")
    right.plot(GAUGES, rows[:, 1], ".-", label="inner wheel, back on guard face")
    right.set(ylim=(-0.5, 16.0), xlabel="gauge, mm", ylabel="sideways part of normal forces, kN")
    right.legend(loc="upper right")
    return figure


if __name__ == "__main__":
    main()
