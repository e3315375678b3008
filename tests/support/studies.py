"""Short studies of a wheelset that runs into a curve."""

from pathlib import Path

from support.runs import SCENARIOS

AXES = """
[[vary]]
kind = "grid"
key = "contact.friction"
values = [0.1, 0.3]
[[vary]]
kind = "grid"
key = "vehicle.speed_kmh"
values = { from = 40, to = 50, step = 5 }
"""


def study_file(folder: Path, axes: str = AXES, more: str = "", seconds: float = 0.2) -> Path:
    """A study of a wheelset that runs for a short time into a curve."""
    base = f'base = "{SCENARIOS / "curve_r300.toml"}"\n[run]\ntime_s = {seconds}\nstart_distance_m = 40\n'
    contact = '[contact]\nnormal = "kik-piotrowski"\ntangential = "fastsim"\nstrips = 12\ncells = 6\n'
    (folder / "base.toml").write_text(f"{base}{contact}[output]\npatches_at_m = []\n")
    file = folder / "study.toml"
    file.write_text('title = "Friction and speed"\nbase = "base.toml"\n' + axes + more)
    return file
