"""The register of analyses: tables of each in a scenario, what runs it, what is shown of its results.

Functions and classes are named as ``package.module:name`` and imported when they are used: all layers import the
register. A new analysis is a table of the scenario (``scenario.sections``), a function that runs it (``analysis``), its
summary and tables (``results``), its pictures (``plots``), and one entry in ``register.toml``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from wrsim.inputs.file_kinds import packaged


@dataclass(frozen=True)
class Analysis:
    """One analysis.

    tables: its own tables of a scenario, besides [vehicle], [track] and [contact]; the first makes the plan. run:
    function of the set-up, a progress function and, for runs along the track, of the record in which it is stored.
    recorded: function of the set-up and the path of such a record. summary, csv_files, pictures: functions of a
    result's dataset: its few numbers, its tables as text, the makers of its pictures. numbers: function of the dataset
    and the summary: the tables that people read. further: function of a result, a folder and whether there are
    pictures, which writes the other files of a command.

    own_track: it lays its own track, and something has to hold the speed; loaded: loads act in it; points: it needs
    points at which accelerations are stored; origins: rails may be placed by the origins of their profiles; conical:
    wheels may be conical with a prescribed creep law; rollers: wheels may be on rollers; compared: contact models can
    be compared in it.
    """

    name: str
    tables: Mapping[str, str]
    run: str
    recorded: str = ""
    summary: str = "wrsim.results.summary:summarise_contacts"
    csv_files: str = "wrsim.results.tables:csv_of_contacts"
    pictures: str = "wrsim.plots.pictures:of_contacts"
    numbers: str = "wrsim.results.summary_tables:run_tables"
    further: str = ""
    own_track: bool = False
    loaded: bool = True
    points: bool = False
    origins: bool = False
    conical: bool = False
    rollers: bool = False
    compared: bool = False

    @property
    def unused(self) -> tuple[str, ...]:
        """Tables of other analyses: refused in a file, dropped where they come from its base."""
        return tuple(name for name in TABLES if name not in self.tables)

    @property
    def moves(self) -> bool:
        """True if it runs along the track: it needs a speed, and a run can be stored and resumed."""
        return bool(self.recorded)


def _analysis(name: str, entry: dict[str, Any]) -> Analysis:
    """An entry of the register; ``shown_by``: room of the functions that show results that are no contacts."""
    if room := entry.pop("shown_by", ""):
        entry |= {
            "summary": f"wrsim.results.{room}:summarise_{room}",
            "csv_files": f"wrsim.results.{room}:csv_of_{room}",
        }
        entry |= {"pictures": f"wrsim.plots.{room}:{room}_figures", "numbers": f"wrsim.results.{room}:{room}_tables"}
    return Analysis(name, **entry)


ANALYSES = {name: _analysis(name, entry) for name, entry in packaged("wrsim", "register.toml").items()}
"""All kinds by name."""

TABLES = {name: kind for analysis in ANALYSES.values() for name, kind in analysis.tables.items()}
"""All tables of a scenario that belong to some analyses only, by name."""
