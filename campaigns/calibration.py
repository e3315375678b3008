"""Calibrations whose truth is known: twins of hidden parameters, a planted yaw stiffness, another program's series.

Run: python campaigns/calibration.py FOLDER twins [COUNT] | curves | gz18 REFERENCE. Cases are kept in FOLDER: started
again, it goes on.

twins: a coach on uneven track, six parameters drawn from their data sheet (deviation 10 %), six channels with noise of
5 % of their rms: how many of the 90 % intervals hold the true value. curves: the longitudinal primary stiffness from 30
steady curves with 2 % noise. gz18: a metro car with parameters off by 20 to 40 % against the series of another program.
"""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gz18 import CANT_MM, STEADY, _profiles

from wrsim import calibrate, load, run
from wrsim.results import CHANNELS

ROOT = Path(__file__).parents[1]
NOISE, SPREAD, CONFIDENCE = 0.05, 0.1, 90.0
TWIN = """\
base = "{scenarios}/manchester_ride_160.toml"
[[track.segments]]
kind = "straight"
length_m = 200
[[track.irregularities]]
kind = "spectrum"
spectrum = "ERRI-high"
seed = 160
wavelength_m = [3, 100]
from_m = 3
[contact]
tangential = "polach"
strips = 12
[run]
distance_m = {length}
output_interval_ms = 5
[ride]
from_m = 5
[output]
patches_at_m = []
"""
KEYS = {
    "vehicle.bogie.primary.stiffness_kN_per_m.1": 3884.0,
    "vehicle.bogie.primary.stiffness_kN_per_m.2": 1220.0,
    "vehicle.bogie.secondary.stiffness_kN_per_m.2": 430.0,
    'vehicle.bogie."secondary vertical damper".damping_kNs_per_m': 20.0,
    'vehicle.bogie."secondary lateral damper".damping_kNs_per_m': 32.0,
    "vehicle.carbody.mass_kg": 32000.0,
}
"""Hidden parameters of the twins and what the data sheet has."""
CHOSEN = (
    {"channel": "point_ay", "point": "floor front"},
    {"channel": "point_az", "point": "floor front"},
    {"channel": "point_ay", "point": "frame front"},
    {"channel": "point_az", "point": "frame front"},
    {"channel": "Q", "wheelset": "front.outer", "wheel": "left"},
    {"channel": "suspension_dz", "suspension": "front.secondary left"},
)
"""Channels of the twins."""
YAW = "vehicle.bogie.primary.stiffness_kN_per_m.0"
CURVES = """\
base = "{scenarios}/steady_manchester.toml"
[contact]
friction = 0.32
normal = "kik-piotrowski"
tangential = "fastsim"
strips = 20
cells = 10
[steady]
radius_m = {radii}
cant_mm = 100
speed_kmh = 70
"""
OF_CURVES = (
    {"channel": "yaw", "wheelset": "front.outer"},
    {"channel": "yaw", "wheelset": "front.inner"},
    {"channel": "lateral_shift", "wheelset": "front.outer"},
    {"channel": "Y", "wheelset": "front.outer", "wheel": "left"},
)


def table(rows: Mapping[str, Any]) -> str:
    """Keys of a table of a file; names with blanks in keys need single quotes."""
    values = {key: f"'{value}'" if isinstance(value, str) else str(value) for key, value in rows.items()}
    return "".join(f"{key} = {value}\n" for key, value in values.items())


def measured(
    folder: Path, base: Path, truth: Mapping[str, float], chosen: Sequence[Mapping[str, str]], noise: float, seed: int
) -> str:
    """Write ``measured.csv``, channels of the run with the true values and noise, and give its [[measured]] tables."""
    dataset = run(load(base).with_values(dict(truth))).dataset
    rng, columns, tables = np.random.default_rng(seed), {}, []
    if "time" in dataset.dims:
        columns["distance [m]"] = dataset["distance"].values
    for i, where in enumerate(chosen):
        channel = CHANNELS[where["channel"]]
        labels = {dim: label for dim, label in where.items() if dim != "channel"}
        values = channel.shown.factor * dataset[channel.name].sel(labels).values
        about = values - (values.mean() if "time" in dataset.dims else 0.0)
        name = f"{channel.name} {i} [{channel.shown.symbol}]"
        columns[name] = values + noise * np.sqrt(np.mean(about**2)) * rng.normal(size=values.size)
        tables.append("\n[[measured]]\n" + table({"series": name} | dict(where)))
    header = ",".join(columns)
    np.savetxt(folder / "measured.csv", np.column_stack([*columns.values()]), "%.9g", ",", header=header, comments="")
    return "".join(tables)


def twin(folder: Path, seed: int, length: float = 60.0) -> Path:
    """The calibration of a vehicle whose parameters are hidden in ``truth.csv``."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "base.toml").write_text(TWIN.format(scenarios=ROOT / "scenarios", length=length))
    rng = np.random.default_rng(1000 + seed)
    truth = {key: value * (1.0 + SPREAD * float(np.clip(rng.normal(), -2.5, 2.5))) for key, value in KEYS.items()}
    np.savetxt(folder / "truth.csv", [[*truth.values()]], "%.10g", ",")
    tables = measured(folder, folder / "base.toml", truth, CHOSEN, NOISE, seed)
    text = f'title = "Twin {seed}"\nconfidence_percent = {CONFIDENCE}\n\n[[scenario]]\n'
    text += table({"name": "line", "base": "base.toml", "file": "measured.csv", "distance": "distance [m]"})
    for key, value in KEYS.items():
        bounds = {"low": 0.6 * value, "high": 1.4 * value, "prior": value, "tolerance": 2.0 * SPREAD * value}
        text += "\n[[vary]]\n" + table({"key": key} | bounds)
    file = folder / "calibration.toml"
    file.write_text(text + tables)
    return file


def hits(file: Path, workers: int = 1) -> tuple[list[bool], list[float]]:
    """Calibrate a twin: which intervals hold the true value; errors over half of their intervals."""
    truth = np.loadtxt(file.parent / "truth.csv", delimiter=",")
    keys = calibrate(file, file.parent / "out", pictures=False, workers=workers, force=True)["keys"]
    inside = [row["low"] <= true <= row["high"] for row, true in zip(keys, truth, strict=True)]
    errors = [2.0 * (row["value"] - true) / (row["high"] - row["low"]) for row, true in zip(keys, truth, strict=True)]
    return inside, errors


def curves(folder: Path, true: float = 24000.0, count: int = 30, noise: float = 0.02) -> Path:
    """The calibration of a planted longitudinal primary stiffness [kN/m] by steady curves."""
    folder.mkdir(parents=True, exist_ok=True)
    radii = [float(round(r)) for r in np.geomspace(250.0, 3000.0, count)]
    (folder / "base.toml").write_text(CURVES.format(scenarios=ROOT / "scenarios", radii=radii))
    tables = measured(folder, folder / "base.toml", {YAW: true}, OF_CURVES, noise, 3)
    text = (
        'title = "Planted yaw stiffness"\n\n[[scenario]]\nname = "curves"\nbase = "base.toml"\nfile = "measured.csv"\n'
    )
    file = folder / "calibration.toml"
    file.write_text(text + "\n[[vary]]\n" + table({"key": YAW, "low": 10000.0, "high": 60000.0}) + tables)
    return file


ORVD = {
    "yaw [mrad]": ({"channel": "yaw"}, (7.520, 3.468), 0.15),
    "lateral [mm]": ({"channel": "lateral_shift"}, (8.834, 7.991), 0.1),
    "X left [kN]": ({"channel": "X", "wheel": "left"}, (-10.51, -14.76), 1.0),
    "X right [kN]": ({"channel": "X", "wheel": "right"}, (10.85, 14.98), 1.0),
    "Y left [kN]": ({"channel": "Y", "wheel": "left"}, (21.69, np.nan), 1.0),
    "Y right [kN]": ({"channel": "Y", "wheel": "right"}, (13.66, np.nan), 1.0),
    "Q left [kN]": ({"channel": "Q", "wheel": "left"}, (78.34, np.nan), 1.0),
    "Q right [kN]": ({"channel": "Q", "wheel": "right"}, (58.91, np.nan), 1.0),
}
"""Leading wheelset in R 300 and R 600 by ORVD 4706df9, in our axes: channel, values, how near the two contact laws are
(campaign tests of that car: 0.15 mrad, 0.1 mm, 5 % of mu N, 2 % of N)."""
OFF = {
    ("vehicle.carbody.mass_kg",): (30551.0, 1.3),
    tuple(f"vehicle.bogie.{name}.stiffness_kN_per_m.0" for name in ("bushing", '"bushing trailing"')): (17000.0, 0.7),
    tuple(f"vehicle.bogie.{name}.stiffness_kN_per_m.1" for name in ("bushing", '"bushing trailing"')): (9000.0, 1.4),
    tuple(f'vehicle.bogie."air spring".stiffness_kN_per_m.{axis}' for axis in (0, 1)): (185.0, 0.75),
    ("vehicle.bogie.primary.stiffness_kN_per_m.2",): (1400.0, 1.2),
    ("contact.friction.static",): (0.3, 0.7),
}
"""Keys of the metro car, their true values, and by which factor the start is off."""


def metro_car(reference: Path, folder: Path) -> Path:
    """The calibration of GZ18 with parameters off by 20 to 40 % to the series of ORVD."""
    folder.mkdir(parents=True, exist_ok=True)
    files = _profiles(reference, folder, "gz18")
    curves = STEADY.format(**files, car="gz18", radius="[300]", cant=0).replace("-[300]", "[-300, -600]")
    cants = f"cant_mm = {[CANT_MM[line] for line in ('r300', 'r600')]}\ncombine = 'rows'"
    (folder / "base.toml").write_text(curves.replace("cant_mm = 0", cants))
    columns = np.column_stack([values for _, values, _ in ORVD.values()])
    np.savetxt(folder / "measured.csv", columns, "%.6g", ",", header=",".join(ORVD), comments="")
    text = 'title = "GZ18 to the series of ORVD"\n\n[[scenario]]\n'
    text += table({"name": "curves", "base": "base.toml", "file": "measured.csv"})
    for keys, (true, factor) in OFF.items():
        start = true * factor
        bounds = {"low": 0.4 * start, "high": 2.0 * start, "start": start, "prior": start, "tolerance": 0.8 * start}
        text += "\n[[vary]]\n" + table({"key": list(keys)} | bounds)
    for name, (where, _, noise) in ORVD.items():
        text += "\n[[measured]]\n" + table({"series": name, "wheelset": "front.leading", "noise": noise} | where)
    file = folder / "calibration.toml"
    file.write_text(text)
    return file


def main(arguments: Sequence[str]) -> int:
    """Print what is found."""
    if len(arguments) < 2 or arguments[1] not in ("twins", "curves", "gz18"):
        raise SystemExit(__doc__)
    folder = Path(arguments[0])
    if arguments[1] == "gz18":
        outcome = calibrate(metro_car(Path(arguments[2]).resolve(), folder / "gz18"), folder / "gz18/out", force=True)
        for row, (true, _) in zip(outcome["keys"], OFF.values(), strict=True):
            off = 100.0 * (row["value"] / true - 1.0)
            told = "told" if row["told"] else "NOT TOLD"
            print(
                f"{row['key']}: {row['value']:.5g} ({row['low']:.5g} to {row['high']:.5g}), "
                f"true {true:g}, {off:+.1f} %, {told}"
            )
        print("\n".join(outcome["notes"]))
        return 0
    if arguments[1] == "curves":
        (row,) = calibrate(curves(folder / "curves"), folder / "curves/out", pictures=False, force=True)["keys"]
        print(f"found {row['value']:.0f} ({row['low']:.0f} to {row['high']:.0f}), planted 24000 kN/m")
        return 0
    held: list[bool] = []
    for seed in range(int(arguments[2]) if len(arguments) > 2 else 20):
        file = folder / f"twin_{seed}" / "calibration.toml"
        inside, errors = hits(file if file.exists() else twin(file.parent, seed), 2)
        held += inside
        counts = f"{sum(inside)} of {len(inside)}, all {sum(held)} of {len(held)}"
        print(f"twin {seed}: {counts}; errors {np.round(errors, 2)}", flush=True)
    print(f"{100.0 * np.mean(held):.1f} % of {len(held)} intervals of {CONFIDENCE:g} % hold the true value")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
