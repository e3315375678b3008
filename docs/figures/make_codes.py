"""Tables of docs/user/codes_differ.md. Run: python docs/figures/make_codes.py [--run]

With --run the cases run, some minutes, and docs/data/codes.csv is written; without it the tables are made from that
file.
"""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from wrsim import Result, Track, load, run
from wrsim.contact.tables import _kalker_table, creep_asymptotes, creep_coefficients
from wrsim.results.summary import filtered
from wrsim.scenario.track_build import rails_of, track_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
DATA = HERE.parent / "data" / "codes.csv"
PAGE = HERE.parent / "user" / "codes_differ.md"
NU = 0.28
"""Poisson's ratio of the table of creep coefficients."""

CURVE = "scenarios/steady_coach_r300.toml"
CASES = {
    "contact": {
        "strips, FaStrip (default)": {},
        "strips, FASTSIM": {"contact.tangential": "fastsim"},
        "strips, FASTSIM, parabolic bound": {"contact.tangential": "fastsim", "contact.traction_bound": "parabolic"},
        "strips, FASTSIM, three flexibilities": {"contact.tangential": "fastsim", "contact.flexibility": "three"},
        "strips, Polach": {"contact.tangential": "polach"},
        "Kik-Piotrowski, FASTSIM": {"contact.normal": "kik-piotrowski"},
        "Kik-Piotrowski, one approach along all normals": {
            "contact.normal": "kik-piotrowski", "contact.approach": "constant",
        },
    },
    "gauge": {f"gauge {depth} mm below the top": {"track.gauge_depth_mm": depth} for depth in (14, 10, 15.9, 16)},
}  # fmt: skip
"""Variants of the coach in the steady curve, the reference first."""
STEADY = (
    ("Y outer", "Y", "right", 1e-3, "kN"),
    ("Y inner", "Y", "left", 1e-3, "kN"),
    ("Tγ outer", "T_gamma", "right", 1.0, "N"),
    ("shift", "lateral_shift", None, 1e3, "mm"),
    ("angle of attack", "yaw", None, 1e3, "mrad"),
)
"""Quantities of the leading wheelset: name, channel, wheel, factor, unit."""

RUN = "scenarios/manchester_r300.toml"
UNEVEN: dict[str, Any] = {
    "track.irregularities": [
        {"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 25], "from_m": 20},
        {"kind": "dip", "at_m": 140, "length_m": 2, "amplitude_mm": 5, "shape": "kink", "rail": "right"},
    ],
    "run.output_interval_ms": 1,
}
MOVING = {"track.structure": {"kind": "moving mass"}}


def steady_rows() -> Iterator[list[str]]:
    """The coach in the steady curve."""
    base = load(ROOT / CURVE)
    for topic, variants in CASES.items():
        for label, values in variants.items():
            sample = run(base.with_values(values) if values else base).dataset.isel(pose=0, wheelset=0)
            for name, channel, wheel, factor, unit in STEADY:
                value = sample[channel] if wheel is None else sample[channel].sel(wheel=wheel)
                yield [topic, label, name, f"{factor * float(value):.5g}", unit]
            if topic == "contact":
                xi = np.abs(sample["xi"].values[np.isfinite(sample["xi"].values)]).max()
                yield [topic, label, "largest ξ", f"{1e3 * xi:.4g}", "‰"]


def peaks(result: Result) -> dict[str, float]:
    """Largest Y and Q of the wheel on the outer rail, and |ΣY|, of the leading wheelset beyond 30 m [kN]."""
    wheelset = result.wheelset("front.outer")
    smooth = filtered(wheelset)
    assert smooth is not None
    largest = {}
    for label, data in (("raw", wheelset), ("below 20 Hz", smooth)):
        late = data.isel(time=np.flatnonzero(data["distance"].values > 30.0))
        for name in ("Y", "Q"):
            largest[f"{name}, {label}"] = float(np.nanmax(late[name].sel(wheel="right"))) / 1e3
    largest["ΣY, raw"] = (
        float(np.nanmax(np.abs(wheelset["Y"].sel(wheel="left") - wheelset["Y"].sel(wheel="right")))) / 1e3
    )
    largest["ΣY, below 20 Hz, mean over 2 m"] = float(np.nanmax(np.abs(smooth["sum_Y"]))) / 1e3
    return largest


def without_slope(result: Result, track: Track) -> tuple[list[dict[str, Any]], float]:
    """Loads on the axles, above every wheel, that take off what the slope of the rails turns of the forces on wheels
    along the track, and the largest of them on the leading wheelset [kN]."""
    loads, largest = [], 0.0
    for name in map(str, result.dataset["wheelset"].values):
        wheelset = result.wheelset(name)
        s = wheelset["distance"].values
        places = np.arange(max(s[0], 0.0), s[-1], 0.05)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            ahead, behind = (track.irregularity(side, s + x) for x in (0.01, -0.01))
            lateral, vertical = ((a - b) / 0.02 for a, b in zip(ahead, behind, strict=True))
            wheel = wheelset.sel(wheel=side)
            force = (wheel["Q"].values * vertical - sign * wheel["Y"].values * lateral) / 1e3
            largest = max(largest, float(np.abs(force).max()) if name == "front.outer" else 0.0)
            rows = [[float(x), float(f), 0.0, 0.0] for x, f in zip(places, np.interp(places, s, force), strict=True)]
            point = {"on": name, "at_mm": [0, sign * 750.0, 0], "axes": "track"}
            loads.append({"name": f"{name} {side}".replace(".", " "), **point, "distance_m_force_kN": rows})
    return loads, largest


def run_rows() -> Iterator[list[str]]:
    """The coach along a curve: filters, rails, pivot of cant, slope of irregularities."""
    base = load(ROOT / RUN)
    variants = (
        ("track", "rigid rails", UNEVEN),
        ("track", "mass on springs under each wheel", UNEVEN | MOVING),
        ("pivot", "cant about the centre line", {}),
        ("pivot", "cant about the low rail", {"track.pivot": "low rail"}),
        ("pivot", "cant about the high rail", {"track.pivot": "high rail"}),
    )
    for topic, label, values in variants:
        result = run(base.with_values(values) if values else base)
        assert result.status == "completed", label
        for name, value in peaks(result).items():
            if topic == "track" or name.endswith("raw"):
                yield [topic, label, name, f"{value:.4g}", "kN"]
            if label == "rigid rails" and name.endswith("raw"):
                yield ["slope", "normal leans with the rail (wrsim)", name, f"{value:.4g}", "kN"]
        if label == "rigid rails":
            scenario = base.with_values(values)
            loads, largest = without_slope(result, track_of(scenario, rails_of(scenario)))
            level = run(scenario.with_values({"vehicle.loads": loads}))
            assert level.status == "completed"
            for name in ("Y, raw", "Q, raw", "ΣY, raw"):
                yield ["slope", "normal in the cross-section", name, f"{peaks(level)[name]:.4g}", "kN"]
            yield ["along", "leading wheelset", "largest", f"{1e3 * largest:.3g}", "N"]


def coefficients(aspect: float) -> dict[str, np.ndarray]:
    """C11, C22, C23 at a/b: of wrsim, of the asymptote alone, of the end of the table."""
    table = creep_coefficients(NU)
    places = np.geomspace(1e-3, 1e3, len(table))
    ours = np.exp([np.interp(np.log(aspect), np.log(places), np.log(column)) for column in table.T])
    end = np.exp([np.interp(np.log(np.clip(aspect, 0.1, 10.0)), np.log(places), np.log(c)) for c in table.T])
    return {"wrsim": ours, "asymptote": creep_asymptotes(np.array([aspect]), NU)[0][0], "end of the table": end}


def kalker_rows() -> Iterator[str]:
    """Creep coefficients beyond the ends of the table, and between its rows."""
    yield "| a/b | C11, C22, C23 of wrsim | asymptote from the end on | value at the end held |\n|---|---|---|---|\n"
    for aspect in (0.02, 0.05, 0.0999, 10.01, 20.0, 50.0):
        values = coefficients(aspect)
        cells = [", ".join(f"{c:.3g}" for c in values["wrsim"])]
        for name in ("asymptote", "end of the table"):
            cells.append(
                ", ".join(f"{100 * (a / b - 1):+.1f} %" for a, b in zip(values[name], values["wrsim"], strict=True))
            )
        yield f"| {aspect:.3g} | {' | '.join(cells)} |\n"


def between_rows() -> float:
    """Largest relative difference of a coefficient from linear interpolation in a/b, columns quadratic in C."""
    aspects, columns = _kalker_table()
    weights = ((NU - 0.25) * (NU - 0.5) / 0.125, -NU * (NU - 0.5) / 0.0625, NU * (NU - 0.25) / 0.125)
    rows = np.einsum("i,kij->kj", weights, columns)
    places = np.linspace(aspects[0], aspects[-1], 2000)
    ours = np.array([coefficients(place)["wrsim"] for place in places])
    plain = np.column_stack([np.interp(places, aspects, row) for row in rows.T])
    return float(np.abs(plain / ours - 1.0).max())


def difference_table(rows: list[dict[str, str]], topic: str) -> Iterator[str]:
    """Values of the first variant, differences of the others."""
    rows_of_topic = [row for row in rows if row["topic"] == topic]
    labels = list(dict.fromkeys(row["variant"] for row in rows_of_topic))
    names = list(dict.fromkeys((row["quantity"], row["unit"]) for row in rows_of_topic))
    value = {(row["variant"], row["quantity"]): float(row["value"]) for row in rows_of_topic}
    yield f"| | {' | '.join(f'{name} {unit}' for name, unit in names)} |\n|---|{'---|' * len(names)}\n"
    for label in labels:
        cells = []
        for name, _ in names:
            first, number = value[labels[0], name], value[label, name]
            cells.append(f"{number:.4g}" + ("" if label == labels[0] else f" ({number - first:+.2g})"))
        yield f"| {label} | {' | '.join(cells)} |\n"


def filter_table(rows: list[dict[str, str]]) -> Iterator[str]:
    """Raw and filtered peaks beside each other."""
    value = {(row["variant"], row["quantity"]): row["value"] for row in rows if row["topic"] == "track"}
    yield "| rails | max Y raw, filtered kN | max Q raw, filtered kN | max ΣY raw, filtered kN |\n|---|---|---|---|\n"
    for label in dict.fromkeys(variant for variant, _ in value):
        of = {name: number for (variant, name), number in value.items() if variant == label}
        pairs = [
            f"{of[f'{x}, raw']}, {next(v for n, v in of.items() if n.startswith(f'{x}, below'))}"
            for x in ("Y", "Q", "ΣY")
        ]
        yield f"| {label} | {' | '.join(pairs)} |\n"


def sentences(rows: list[dict[str, str]]) -> dict[str, str]:
    """Figures that stand in sentences."""
    value = {(row["topic"], row["variant"], row["quantity"]): float(row["value"]) for row in rows}
    xi = value["contact", "strips, FaStrip (default)", "largest ξ"]
    along = value["along", "leading wheelset", "largest"]
    return {
        "speed": f"The largest longitudinal creepage of the coach in R 300 m is {xi:.2g} ‰. "
        f"The mean of both speeds changes its creepages by up to {0.05 * xi:.2g} %.\n",
        "along": f"The largest of these forces on the leading wheelset is {along:.3g} N.\n",
        "between": f"Between the rows both rules differ by up to {100 * between_rows():.1f} % (ν = {NU}).\n",
    }


def page() -> str:
    """The text of the page with its tables."""
    with DATA.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    made = {topic: "".join(difference_table(rows, topic)) for topic in ("contact", "gauge", "pivot", "slope")}
    made |= {"kalker": "".join(kalker_rows()), "filters": "".join(filter_table(rows))} | sentences(rows)
    text = PAGE.read_text(encoding="utf-8")
    for name, table in made.items():
        mark = re.compile(rf"(<!-- made by docs/figures/make_codes.py: {name} -->\n).*?(<!-- end -->)", re.S)
        text, count = mark.subn(lambda m, table=table: f"{m[1]}{table}{m[2]}", text)
        assert count == 1, name
    return text


def main(arguments: list[str]) -> None:
    """Run the cases where asked to, and write the page."""
    if "--run" in arguments:
        rows: list[Any] = [*steady_rows(), *run_rows()]
        with DATA.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["topic", "variant", "quantity", "value", "unit"], *rows])
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
