"""Kinds of files that users write: the classes that read them, the commands that take them.

Classes are named as ``package.module:name`` and imported when they are used: all rooms read files.
"""

from importlib import import_module
from typing import Any

FILES = {
    "scenario": ("a scenario", "wrsim.scenario.schema:ScenarioFile"),
    "study": ("a study", "wrsim.study.spec:StudyFile"),
    "programme": ("a type test", "wrsim.study.programme:ProgrammeFile"),
    "evolution": ("a profile evolution", "wrsim.study.spec:EvolutionFile"),
    "vehicle": ("a vehicle file", "wrsim.vehicle.vehicle_files:VehicleFile"),
    "wheelset": ("a vehicle file of one wheelset", "wrsim.vehicle.vehicle_files:WheelsetFile"),
    "train": ("a train file", "wrsim.vehicle.vehicle_files:TrainFile"),
    "track": ("a track file", "wrsim.scenario.merging:TrackFile"),
    "profile": ("a profile file", "wrsim.contact.profiles.models:AnyProfileFile"),
    "crossing": ("a crossing file", "wrsim.track.crossing:CrossingFile"),
    "rules": ("a rule set", "wrsim.assessment.rules:RulesFile"),
    "columns": ("the column map of a recording", "wrsim.recording.columns:ColumnsFile"),
}
"""Kinds of files that users write, and the class of each, or the classes that it may be one of."""

COMMANDS = {
    "scenario": "wrsim run", "study": "wrsim study", "programme": "wrsim type-test",
    "evolution": "wrsim wear", "vehicle": "wrsim vehicle",
    "wheelset": "wrsim vehicle", "train": "wrsim vehicle", "track": "wrsim track", "profile": "wrsim profile",
    "rules": "wrsim assess --rules", "columns": "wrsim recording --columns",
}  # fmt: skip
"""The commands that take these kinds of files."""

ENDINGS = {
    ".nc": "a file of numbers (wrsim show, wrsim report)", ".part": "a run that was cut off (wrsim show)",
    ".csv": "a table (wrsim recording, wrsim profile)", ".json": "a JSON file", ".html": "a page", ".fmu": "a unit",
    ".prr": "a rail profile (wrsim profile)", ".prw": "a wheel profile (wrsim profile)",
    ".ban": "a rail profile (wrsim profile)", ".whl": "a wheel profile (wrsim profile)",
    ".rai": "a rail profile (wrsim profile)", ".whe": "a wheel profile (wrsim profile)",
    ".rail": "a rail profile (wrsim profile)", ".wheel": "a wheel profile (wrsim profile)",
    ".slcs": "sections of a rail ([[track.rail_sections]])", ".slcw": "sections of a wheel ([[wheelset.out_of_round]])",
    ".png": "a picture", ".svg": "a picture", ".pdf": "a picture", ".jpg": "a picture",
}  # fmt: skip
"""Files that are not TOML, by the ending of their name, and the commands that take them."""

OTHER_NAMES = {"service": "evolution", "wear": "evolution"}
"""Other names of kinds of files, that are understood."""


def resolved(name: str) -> Any:
    """The function or class of a name of the register."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)
