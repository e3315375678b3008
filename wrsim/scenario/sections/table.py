"""A table of a scenario that belongs to some analyses only; the register says to which."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from wrsim.inputs.section import Fault, Section


class Table(Section):
    """Base of these tables."""

    @classmethod
    def beside(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Yield faults in how the table goes together with the others of the scenario; raw: all of them."""
        yield from ()
