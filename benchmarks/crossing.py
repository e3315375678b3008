"""A coach runs over the nose of a crossing: peak wheel force against speed, and how it changes with the step.

    python benchmarks/crossing.py --speeds 10 20 40 60 80 100 [--steps-us 100 50] [--begin -0.95] [--json]
        [--picture crossing.png]

The crossing 56E1-R245-1:9.25 is read from the reference folder beside the project and stands in the right rail of
straight track. Forces are those of the leading right wheel, unfiltered, at every step: the blow is over after some
milliseconds, and samples .5 ms apart miss its peak by some per cent. From .73 to .62 m before its origin the plain
rail becomes one with an inclined top, which strikes the wheel on its own; a lead-in of 1.7 m stands in its place, and
``--begin -0.95`` leaves it as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from support.crossings import write_crossing  # noqa: E402

from wrsim.analysis import run  # noqa: E402
from wrsim.scenario.loading import load  # noqa: E402

PLACE = 25.0  # of the crossing's origin along the track [m]
LEADING = 10.78  # of the coach's leading wheelset ahead of its origin [m]
BEGIN, END = -0.53, 1.0  # of it that is laid [m]
PLAIN, LEAD = -0.757, -2.2  # place of its last plain section, and where that stands before a lead-in [m]
BEFORE, AFTER = 2.4, 1.1  # way of the leading wheelset to its origin and behind it [m]
SIDE = 3.6  # [mm] the crossing's origin lies 750 mm from the middle of the track, that of 60E1 farther out


def peak(table: Path, speed: float, step_us: int) -> dict[str, Any]:
    """Largest force of the leading right wheel behind the nose's tip."""
    values: dict[str, Any] = {
        "vehicle.speed_kmh": speed,
        "track.segments": [{"kind": "straight", "length_m": 60.0}],
        "track.inclination": "none",
        "track.rail_sections": [{"at_m": PLACE, "table": str(table), "side": "right", "outward_mm": -SIDE}],
        "run.start_distance_m": PLACE - BEFORE - LEADING,
        "run.distance_m": BEFORE + AFTER,
        "run.output_interval_ms": 1e-3 * step_us,
        "run.step_us": step_us,
        "output.patches_at_m": [],
    }
    result = run(load(ROOT / "scenarios" / "manchester_r300.toml").with_values(values))
    dataset = result.wheelset(str(result.dataset["wheelset"].values[0])).sel(wheel="right")
    place = dataset["distance"].values
    near = (place > PLACE) & (place < PLACE + 1.0)
    q = dataset["Q"].values
    return {
        "speed_kmh": speed,
        "step_us": 1e6 * float(result.dataset.attrs["step_s"]),
        "status": result.status,
        "peak_kN": 1e-3 * float(q[near].max()),
        "at_m": float(place[near][q[near].argmax()] - PLACE),
        "least_kN": 1e-3 * float(q[near].min()),
        "static_kN": 1e-3 * float(np.median(q[place < PLACE + LEAD])),
    }


def lay(table: Path, begin: float) -> None:
    """Write the table of sections from ``begin`` on; behind the plain rail with its last plain section ahead."""
    write_crossing(table, begin, END)
    if begin > PLAIN:
        lead = table.with_name("lead.csv")
        write_crossing(lead, PLAIN - 1e-3, PLAIN + 1e-3)
        (_, *plain), (head, *own) = lead.read_text().splitlines(), table.read_text().splitlines()
        moved = [f"{LEAD},{line.split(',', 1)[1]}" for line in plain]
        table.write_text("\n".join([head, *moved, *own]))


def draw(rows: list[dict[str, Any]], picture: Path) -> None:
    """Peak and least force over speed, a line for every step."""
    figure = Figure(figsize=(6.5, 4.0), layout="constrained")
    axes = figure.subplots()
    steps = sorted({row["step_us"] for row in rows}, reverse=True)
    for step_us, style in zip(steps, ("o-", "x--", "+:", "s-."), strict=False):
        own = sorted((row for row in rows if row["step_us"] == step_us), key=lambda row: row["speed_kmh"])
        speeds = [row["speed_kmh"] for row in own]
        for name, colour in (("peak_kN", "C3"), ("least_kN", "C0")):
            words = f"{'largest' if name == 'peak_kN' else 'least'}, steps of {step_us:g} us"
            axes.plot(speeds, [row[name] for row in own], style, color=colour, label=words)
    axes.axhline(rows[0]["static_kN"], color="0.5", lw=0.8, label="on the plain rail")
    axes.set(xlabel="speed [km/h]", ylabel="force of the leading right wheel [kN]", xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(picture, dpi=150)


def main() -> None:
    """Print a table, or with --json one line."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--speeds", nargs="+", type=float, default=[10.0, 20.0, 40.0, 60.0, 80.0, 100.0])
    options.add_argument("--steps-us", nargs="+", type=int, default=[100, 50])
    options.add_argument("--begin", type=float, default=BEGIN, help="first section, m from the origin")
    options.add_argument("--json", action="store_true")
    options.add_argument("--picture", type=Path, help="peak over speed, for every step")
    asked = options.parse_args()
    rows = []
    folder = TemporaryDirectory()
    table = Path(folder.name) / "crossing.csv"
    lay(table, asked.begin)
    for speed in asked.speeds:
        for step_us in asked.steps_us:
            row = peak(table, speed, step_us)
            rows.append(row)
            if not asked.json:
                print(
                    f"{speed:5g} km/h, step {row['step_us']:6.1f} us: peak {row['peak_kN']:7.2f} kN "
                    f"at {row['at_m']:.3f} m, least {row['least_kN']:.2f}, "
                    f"static {row['static_kN']:.2f} ({row['status']})",
                    flush=True,
                )
    if asked.picture is not None:
        draw(rows, asked.picture)
    if asked.json:
        print(json.dumps({"crossing": rows}))


if __name__ == "__main__":
    main()
