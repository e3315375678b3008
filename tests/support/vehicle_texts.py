"""A vehicle's file in short, and what is said of it when it is changed."""

from pathlib import Path

from support.vehicles import read_vehicle
from wrsim.errors import InputError

GOOD = """\
name = "a car"
source = "made up"
date = 2026-01-31
[wheelset]
mass_kg = 1000
roll_inertia_kg_m2 = 600
spin_inertia_kg_m2 = 100
yaw_inertia_kg_m2 = 600
flange_back_mm = 1360
radius_mm = 450
wheel = "wheels/S1002.toml"
[wheelsets]
front.x_mm = 2000
rear.x_mm = -2000
[bodies.body]
mass_kg = 8000
inertia_kg_m2 = [4000, 9000, 9500]
centre_mm = [0, 0, 1200]
[[elements]]
kind = "spring"
name = "primary"
body = "body"
to = ["front", "rear"]
origin = "to"
at_mm = [0, 900, 0]
both_sides = true
stiffness_kN_per_m = [5000, 3000, 800]
[[elements]]
kind = "damper"
name = "damper"
body = "body"
to = ["front", "rear"]
origin = "to"
at_mm = [0, 900, 0]
both_sides = true
direction = "z"
damping_kNs_per_m = 8
"""


def fault(folder: Path, *changes: tuple[str, str], text: str = GOOD) -> str:
    """The message about a file with the changes; no message if it loads."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    file = folder / "car.toml"
    file.write_text(text)
    try:
        read_vehicle(file)
    except InputError as error:
        return str(error).replace(f"{folder}/", "")
    return ""
