"""A vehicle's file in short, and what is said of it when it is changed."""

import os
from pathlib import Path

from support.vehicles import read_vehicle
from wrsim.errors import InputError

GOOD = (Path(__file__).parents[1] / "data/car.toml").read_text()


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
        return str(error).replace(f"{folder}{os.sep}", "")
    return ""
