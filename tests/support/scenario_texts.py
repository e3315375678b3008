"""Small valid scenarios, and what is said about them after an edit."""

import os
from pathlib import Path

from wrsim import InputError, load
from wrsim.scenario.build import build

DATA = Path(__file__).parents[1] / "data"
CURVE = (DATA / "curve.toml").read_text()
STATIC = (DATA / "poses.toml").read_text()


def faults(text: str, folder: Path, name: str = "case.toml") -> list[str]:
    """Messages for a scenario text, one a line; empty if it is valid."""
    (folder / name).write_text(text, encoding="utf-8")
    try:
        build(load(folder / name))
    except InputError as error:
        return [line.removeprefix(f"{folder}{os.sep}") for line in str(error).split("\n")]
    return []


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)
