"""Planted defects of a coach in a short type test: does the clause that one names beforehand turn red?

    python campaigns/type_test_defects.py [FOLDER] [--workers 2]

Every state of the programme is one defect, or one sound variant: a number by 5 %, tolerances of manufacture and of
service, another realisation of the track. Runs: straight track at 200 km/h, R 900 m and R 300 m, one section each, and
all stationary tests; ERRI-low. A defect counts as found where a clause that is named for it is beyond its limit; a
sound variant where no clause is.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from wrsim.api.studies import run_type_test
from wrsim.study.type_test import Verdict

ROOT = Path(__file__).parents[1]
PRIMARY, SECONDARY = "vehicle.bogie.primary.stiffness_kN_per_m", "vehicle.bogie.secondary.stiffness_kN_per_m"
LATERAL = "vehicle.bogie.secondary lateral damper.damping_kNs_per_m"
VERTICAL = "vehicle.bogie.secondary vertical damper.damping_kNs_per_m"
BAR = "vehicle.bogie.anti-roll bar.stiffness_kNm_per_rad"
STOP = "vehicle.bogie.lateral stop.travel_mm_force_kN"
CENTRE, WHEEL = "vehicle.carbody.centre_mm", "vehicle.wheelset.wheel"
BODY, FRAME, AXLE = "vehicle.carbody.mass_kg", "vehicle.frame.mass_kg", "vehicle.wheelset.mass_kg"
PRIMARY_DAMPER = "vehicle.bogie.primary damper.damping_kNs_per_m"
LEFT, RIGHT = "vehicle.radius_left_mm", "vehicle.radius_right_mm"
GAUGE, FRICTION = "track.gauge_mm", "contact.friction"
AS_DRAWN: dict[str, Any] = {
    PRIMARY: [31391, 3884, 1220], SECONDARY: [160, 160, 430], LATERAL: 32, VERTICAL: 20, BAR: 940,
    STOP: [[25, 0], [30, 0.6], [35, 1.76], [40, 3.73], [45, 6.87], [50, 11.58], [55, 17.17], [60, 29.2], [65, 230]],
    CENTRE: [0, 0, 1800], WHEEL: "wheels/S1002.toml", BODY: 32000, FRAME: 2615, AXLE: 1813, PRIMARY_DAMPER: 4,
    LEFT: 460, RIGHT: 460, GAUGE: 1435, FRICTION: 0.4,
}  # fmt: skip
RIDE = ("body, vertical", "body, vertical rms")
SWAY = ("body, lateral", "body, lateral rms")
HUNTING = ("instability, forces", "instability, accelerations", "every run comes to its end")
DEFECTS: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "primary springs six times as stiff": ({PRIMARY: [31391, 3884, 7320]}, ("twist",)),
    "anti-roll bar ten times as stiff": ({BAR: 9400}, ("twist",)),
    "secondary springs three times as stiff along the track": ({SECONDARY: [480, 160, 430]}, ("rotation",)),
    "axles held softly, both ways": ({PRIMARY: [1500, 1500, 1220]}, HUNTING),
    "anti-roll bar lost": ({BAR: 1}, ("sway",)),
    "secondary vertical dampers lost": ({VERTICAL: 0.1}, RIDE),
    "secondary vertical springs ten times as stiff": ({SECONDARY: [160, 160, 4300]}, (*RIDE, "twist")),
    "secondary lateral dampers lost": ({LATERAL: 0.1}, (*SWAY, *HUNTING)),
    "secondary lateral springs ten times as stiff": ({SECONDARY: [160, 1600, 430]}, SWAY),
    "lateral stop at 20 mm": ({STOP: [[10, 0], [15, 1], [20, 30]]}, SWAY),
    "load 250 mm beside the middle": ({CENTRE: [0, 250, 1800]}, ("wheel loads",)),
    "load 1 m higher": ({CENTRE: [0, 0, 2800]}, ("sway",)),
    "secondary vertical springs a quarter as stiff": ({SECONDARY: [160, 160, 107]}, ("sway", "buffer height")),
    "worn hollow wheels": ({WHEEL: "wheels/S1002_worn.toml"}, ("conicity",)),
    "secondary lateral dampers blocked": ({LATERAL: 1000}, SWAY),
    "secondary vertical dampers blocked": ({VERTICAL: 1000}, RIDE),
    "axles held softly along the track": ({PRIMARY: [1000, 3884, 1220]}, HUNTING),
    "axles held softly across the track": ({PRIMARY: [31391, 300, 1220]}, HUNTING),
    "primary springs blocked": ({PRIMARY: [31391, 3884, 30000]}, ("twist",)),
    "secondary springs jammed along the track": ({SECONDARY: [1600, 160, 430]}, ("rotation",)),
}
SOUND: dict[str, dict[str, Any]] = {
    f"{key.rpartition('.')[0].rpartition('.')[2]} {100 * (factor - 1):+.0f} %": {key: _scaled}
    for key in (PRIMARY, SECONDARY, LATERAL, VERTICAL, BAR)
    for factor in (0.95, 1.05)
    for value in (AS_DRAWN[key],)
    for _scaled in ([factor * v for v in value] if isinstance(value, list) else factor * value,)
}
SOUND |= {
    f"{name} {100 * (factor - 1):+.0f} %": {key: factor * AS_DRAWN[key] for key in keys}
    for name, part, keys in (
        ("all masses", 0.02, (BODY, FRAME, AXLE)), ("all dampers", 0.1, (LATERAL, VERTICAL, PRIMARY_DAMPER)),
    )
    for factor in (1.0 - part, 1.0 + part)
} | {
    "wheels of every axle 0.2 mm apart in diameter": {LEFT: 460.05, RIGHT: 459.95},
    "load 50 mm beside the middle": {CENTRE: [0, 50, 1800]},
    "gauge 1433 mm": {GAUGE: 1433},
    "dry rails of friction 0.36": {FRICTION: 0.36},
}  # fmt: skip
ELSEWHERE = "as drawn, other realisations of the track"

HEAD = """title = "Planted defects"
base = {base}
stationary = ["twist", "rotation", "cant", "weighing", "settling", "conicity"]
payload_kg = 8000
flexibility_coefficient = 0.225
[irregularities]
spectrum = "ERRI-low"
seed = {seed}
[[runs]]
name = "straight"
speed_kmh = 200
sections = 1
[[runs]]
name = "R 900"
radius_m = 900
cant_mm = 100
cant_deficiency_mm = 130
sections = 1
directions = "left"
[[runs]]
name = "R 300"
radius_m = 300
cant_mm = 100
cant_deficiency_mm = 100
sections = 1
directions = "left"
"""


def programme(changes: dict[str, dict[str, Any]], seed: int) -> str:
    """The text of a programme; changes: what every state sets; seed: of the track of the first run."""
    text = HEAD.format(base=json.dumps(str(ROOT / "scenarios" / "type_test" / "coach_base.toml")), seed=seed)
    for name, keys in changes.items():
        values = ", ".join(f"{json.dumps(key)} = {json.dumps(v)}" for key, v in (AS_DRAWN | keys).items())
        text += f"[[states]]\nname = {json.dumps(name)}\nset = {{ {values} }}\n"
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--workers", type=int)
    arguments = parser.parse_args()
    states: dict[str, dict[str, Any]] = {"as drawn": {}} | {name: keys for name, (keys, _) in DEFECTS.items()} | SOUND
    outcomes: list[Verdict] = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for seed, changes in ((1, states), (11, {ELSEWHERE: AS_DRAWN})):
            file = folder / f"defects_{seed}.toml"
            file.write_text(programme(changes, seed))
            outcomes += run_type_test(file, folder / file.stem, workers=arguments.workers, notify=print).value
    red: dict[str, list[str]] = {}
    for v in outcomes:
        red.setdefault(v.state, [])
        if v.ok is False:
            red[v.state].append(v.clause)
    seen = {name: bool(set(red[name]) & set(named)) for name, (_, named) in DEFECTS.items()}
    sound = {name: not red[name] for name in ("as drawn", *SOUND, ELSEWHERE)}
    for name in red:
        state = {True: "found", False: "NOT FOUND"}[seen[name]] if name in seen else "green" if sound[name] else "RED"
        print(f"{name:55s} {state:10s} {'; '.join(dict.fromkeys(red[name]))}")
    print(f"{sum(seen.values())} of {len(seen)} defects found by their clauses")
    print(f"{sum(sound.values())} of {len(sound)} sound variants green")


if __name__ == "__main__":
    main()
