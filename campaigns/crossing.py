"""A coach runs over the nose of a crossing: peak wheel force against speed, and how it changes with the step.

    python campaigns/crossing.py REFERENCE --speeds 10 20 40 60 80 100 [--steps-us 100 50] [--elastic] [--begin -0.95]
        [--json] [--picture crossing.png] [--flight crossing_flight.png]

The crossing 56E1-R245-1:9.25 is read from the folder of reference tables (crossing_56e1 in it) and stands in the right
rail of straight track. Forces are those of the leading right wheel, unfiltered, at every step: the blow is over after
some milliseconds, and samples .5 ms apart miss its peak by some per cent. From .73 to .62 m before its origin the plain
rail becomes one with an inclined top, which strikes the wheel on its own; a lead-in of 1.7 m stands in its place, and
``--begin -0.95`` leaves it as it is. ``--elastic`` lays the rails on springs with a mass under each wheel.

``--flight`` draws force and height of the wheel beside the way that it would roll at 60 and 80 km/h on rigid rails, and
prints a hand check of the blow on the nose: a mass M that closes on a Hertz spring C d^1.5 with the speed V presses it
with (5/4 M V^2)^(3/5) C^(2/5), because M V^2 / 2 = 2/5 C d^(5/2).
"""

import argparse
import json
import sys
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import brentq

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from support.contacts import HALF_SPACING, RADIUS, wheel_profile  # noqa: E402
from support.crossings import on, write_crossing  # noqa: E402

from wrsim.analysis import run  # noqa: E402
from wrsim.contact.model import ContactModel  # noqa: E402
from wrsim.contact.surfaces.rail_surface import RailSurface, read_sections  # noqa: E402
from wrsim.results.result import Result  # noqa: E402
from wrsim.scenario.loading import load  # noqa: E402

Array = NDArray[np.float64]

PLACE = 25.0  # of the crossing's origin along the track [m]
LEADING = 10.78  # of the coach's leading wheelset ahead of its origin [m]
BEGIN, END = -0.53, 1.0  # of it that is laid [m]
PLAIN, LEAD = -0.757, -2.2  # place of its last plain section, and where that stands before a lead-in [m]
BEFORE, AFTER = 2.4, 1.1  # way of the leading wheelset to its origin and behind it [m]
ELASTIC = {
    "kind": "moving mass",  # of the order of 60E1 on concrete sleepers and ballast, see docs/user/track.md
    "lateral_stiffness_MN_per_m": 25, "vertical_stiffness_MN_per_m": 50,
    "lateral_damping_kNs_per_m": 40, "vertical_damping_kNs_per_m": 60,
    "lateral_mass_kg": 120, "vertical_mass_kg": 160,
}  # fmt: skip
MASS = 1.0 / (1.0 / 1813.0 + HALF_SPACING**2 / 1120.0)  # of the coach's wheelset as one wheel feels it [kg]
LIGHT = 500.0  # force that a slow wheel is carried by [N]
SUNK = 1.5e-4  # at which the contact's spring is measured [m]
SIDE = 3.6  # [mm] the crossing's origin lies 750 mm from the middle of the track, that of 60E1 farther out


def ride(table: Path, speed: float, step_us: int, elastic: bool) -> Result:
    """A coach over the crossing."""
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
    if elastic:
        values["track.structure"] = ELASTIC
    return run(load(ROOT / "scenarios" / "manchester_r300.toml").with_values(values))


def leading(result: Result) -> Any:
    """Channels of the leading right wheel."""
    return result.wheelset(str(result.dataset["wheelset"].values[0])).sel(wheel="right")


def peak(table: Path, speed: float, step_us: int, elastic: bool) -> dict[str, Any]:
    """Largest force of the leading right wheel behind the nose's tip."""
    result = ride(table, speed, step_us, elastic)
    dataset = leading(result)
    place = dataset["distance"].values
    near = (place > PLACE) & (place < PLACE + 1.0)
    q = dataset["Q"].values
    return {
        "speed_kmh": speed,
        "rails": "elastic" if elastic else "rigid",
        "step_us": 1e6 * float(result.dataset.attrs["step_s"]),
        "status": result.status,
        "peak_kN": 1e-3 * float(q[near].max()),
        "at_m": float(place[near][q[near].argmax()] - PLACE),
        "least_kN": 1e-3 * float(q[near].min()),
        "static_kN": 1e-3 * float(np.median(q[place < PLACE + LEAD])),
    }


def lay(reference: Path, table: Path, begin: float) -> None:
    """Write the table of sections from ``begin`` on; behind the plain rail with its last plain section ahead."""
    write_crossing(reference, table, begin, END)
    if begin > PLAIN:
        lead = table.with_name("lead.csv")
        write_crossing(reference, lead, PLAIN - 1e-3, PLAIN + 1e-3)
        (_, *plain), (head, *rows) = lead.read_text().splitlines(), table.read_text(encoding="utf-8").splitlines()
        moved = [f"{LEAD},{line.split(',', 1)[1]}" for line in plain]
        table.write_text("\n".join([head, *moved, *rows]), encoding="utf-8")


def draw(rows: list[dict[str, Any]], picture: Path) -> None:
    """Peak and least force over speed; the longest step of a speed as circles, shorter ones as crosses."""
    figure = Figure(figsize=(6.5, 4.0), layout="constrained")
    axes = figure.subplots()
    for rails, style in (("rigid", "-"), ("elastic", "--")):
        rows_of_rails = sorted(
            (row for row in rows if row["rails"] == rails), key=lambda row: (row["speed_kmh"], -row["step_us"])
        )
        first = [
            row
            for i, row in enumerate(rows_of_rails)
            if i == 0 or row["speed_kmh"] != rows_of_rails[i - 1]["speed_kmh"]
        ]
        for name, colour, word in (("peak_kN", "C3", "largest"), ("least_kN", "C0", "least")):
            for part, mark in ((first, "o" + style), ([row for row in rows_of_rails if row not in first], "x")):
                label = f"{word}, {rails} rails" if part is first and part else None
                axes.plot(
                    [row["speed_kmh"] for row in part], [row[name] for row in part], mark, color=colour, label=label
                )
    axes.axhline(rows[0]["static_kN"], color="0.5", lw=0.8, label="on the plain rail")
    axes.set(xlabel="speed [km/h]", ylabel="force of the leading right wheel [kN]", xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(picture, dpi=150)


@dataclass(frozen=True)
class Way:
    """How high a wheel stands that rolls over the rail, at places from the crossing's origin [m], shifted outward by
    so much [m]; carried by hardly any force."""

    model: ContactModel
    outward: float

    def force(self, place: float, height: float) -> float:
        """Of a wheel that stands so high [N]."""
        return float(self.model.evaluate((0.0, self.outward, RADIUS + height), place=place).force[2])

    def heights(self, places: Array) -> Array:
        """Where it begins to be carried [m]."""
        tops = [2e-3]
        for place in places:
            high = tops[-1] + 2e-4
            while self.force(place, high) > LIGHT:
                high += 2e-4
            low = high
            while self.force(place, low) < LIGHT:
                low -= 5e-5
            tops.append(brentq(lambda z, position=place: self.force(position, z) - LIGHT, low, high, xtol=1e-8))
        return np.array(tops[1:])


def way(table: Path, outward: float) -> Way:
    """The way of an S1002 wheel over the table's rail."""
    surface = RailSurface("crossing", tuple(read_sections(table)))
    return Way(on(surface, "kik-piotrowski", wheel_profile("S1002")), outward)


def flight(table: Path, picture: Path) -> None:
    """Draw and check the wheel that leaves the wing and lands."""
    figure = Figure(figsize=(6.5, 6.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    places = np.arange(0.1, 0.6, 4e-3)
    for speed, colour in ((60.0, "C0"), (80.0, "C1")):
        dataset = leading(ride(table, speed, 50, elastic=False))
        x, t, q = dataset["distance"].values - PLACE, dataset["time"].values, dataset["Q"].values
        height = dataset["vertical_shift"].values - HALF_SPACING * dataset["roll"].values
        rolled_way = way(table, -float(np.interp(0.26, x, dataset["lateral_shift"].values)))
        rolled = rolled_way.heights(places)
        lowest = int(rolled.argmin())
        slope = float(np.diff(rolled[lowest + 2 : lowest + 4])[0] / 4e-3)
        falls = float(np.interp(places[lowest], x, np.gradient(height, t)))
        closing = slope * speed / 3.6 - falls
        spring = rolled_way.force(places[lowest + 3], rolled[lowest + 3] - SUNK) / SUNK**1.5
        check = (1.25 * MASS * closing**2) ** 0.6 * spring**0.4
        near = np.abs(x - places[lowest]) < 0.05
        print(
            f"{speed:g} km/h: nose from {places[lowest]:.3f} m, rises {1e3 * slope:.1f} mrad, "
            f"vertical speed of the wheel there {falls:.3f} m/s, closing {closing:.3f} m/s; "
            f"hand check {1e-3 * check:.0f} kN, run {1e-3 * q[near].max():.0f} kN"
        )
        above.plot(x, 1e-3 * q, color=colour, label=f"{speed:g} km/h")
        start = np.interp(places[0], x, height)
        below.plot(x, 1e3 * (height - start), color=colour, label=f"wheel, {speed:g} km/h")
        below.plot(places, 1e3 * (rolled - rolled[0]), "--", color=colour, label="rolled slowly")
    above.set(ylabel="Q [kN]", xlim=(places[0], places[-1]))
    below.set(xlabel="from the crossing's origin [m]", ylabel="height [mm]")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.legend()
    figure.savefig(picture, dpi=150)


def main() -> None:
    """Print a table, or with --json one line."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("reference", type=Path, metavar="REFERENCE")
    options.add_argument("--speeds", nargs="+", type=float, default=[10.0, 20.0, 40.0, 60.0, 80.0, 100.0])
    options.add_argument("--steps-us", nargs="+", type=int, default=[100, 50])
    options.add_argument("--begin", type=float, default=BEGIN, help="first section, m from the origin")
    options.add_argument("--json", action="store_true")
    options.add_argument("--elastic", action="store_true", help="rigid rails, then elastic ones")
    options.add_argument("--flight", type=Path, help="force and height of the wheel over the nose; nothing else")
    options.add_argument("--picture", type=Path, help="peak over speed")
    asked = options.parse_args()
    rows = []
    folder = TemporaryDirectory()
    table = Path(folder.name) / "crossing.csv"
    lay(asked.reference / "crossing_56e1", table, asked.begin)
    if asked.flight is not None:
        flight(table, asked.flight)
        return
    for elastic in (False, True)[: 1 + asked.elastic]:
        for speed, step_us in product(asked.speeds, asked.steps_us):
            row = peak(table, speed, step_us, elastic)
            rows.append(row)
            if not asked.json:
                print(
                    f"{row['rails']} rails, {speed:5g} km/h, step {row['step_us']:6.1f} us: "
                    f"peak {row['peak_kN']:7.2f} kN at {row['at_m']:.3f} m, least {row['least_kN']:.2f}, "
                    f"static {row['static_kN']:.2f} ({row['status']})",
                    flush=True,
                )
    if asked.picture is not None:
        draw(rows, asked.picture)
    if asked.json:
        print(json.dumps({"crossing": rows}))


if __name__ == "__main__":
    main()
