"""The arrays of the contact kernel by their names, and the kernel run on them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.arena import Arena
from wrsim.core.contact import records as k
from wrsim.core.contact.arrays import Arrays
from wrsim.core.contact.strips.records import X
from wrsim.core.contact.wheel_rail import search, wheel_rail

Array = NDArray[np.float64]
Records = NDArray[np.void]
"""Records of core.contact.records: fields by their names."""


class KernelArrays:
    """The arrays of an arena of one wheel on one rail by their names (core.contact.arrays.Arrays), and the kernel
    that computes in them."""

    def __init__(self, arena: Arena, follows: bool) -> None:
        """follows: whether the normal model can start from the contact of the last call."""
        self.buffer, self.index, self._follows = arena.buffer, arena.index, follows
        self.rows = Arrays(*arena.views)
        self.wheel: Array = self.rows.wheel
        self.rail: Array = self.rows.rail
        self.settings: Any = self.rows.settings[0]
        self.pose: Array = self.rows.pose
        self.found: Records = self.rows.found
        self.patches: Records = self.rows.patches
        self.strips: Records = self.rows.strips
        self.total: Any = self.rows.total[0]
        # views of one number each: a run reads them after every step
        self._status, self._substitutes = self.rows.total["status"], self.rows.memo["substitutes"]

    @property
    def force(self) -> Array:
        """On the wheel (t, o, b) [N]."""
        return np.array([self.total.Ft, self.total.Fo, self.total.Fb])

    @property
    def moment(self) -> Array:
        """On the wheel about its profile origin (t, o, b) [N m]."""
        return np.array([self.total.Mt, self.total.Mo, self.total.Mb])

    def call(self) -> int:
        """Run the kernel on the pose that is set; returns its status."""
        return int(wheel_rail(self.buffer, self.index))

    def search(self) -> tuple[int, int]:
        """Look for contacts at the pose that is set, see ``found``; returns their number and the status."""
        count, status = search(self.buffer, self.index)
        return int(count), int(status)

    @property
    def status(self) -> int:
        """Status of the contact found last, see `wrsim.contact.status`."""
        return self._status.item()

    @property
    def substitutes(self) -> int:
        """Calls so far in which the strip model was not solved and a substitute stood for it."""
        return self._substitutes.item()

    def follow(self, on: bool) -> None:
        """From now on the strip model starts from the contact asked for last (in runs), or cold each time.

        Its answer is the same to its tolerance.
        """
        self.settings.start = k.FROM_LAST if on else k.AFRESH
        self.rows.memo["known"] = 0

    def kept(self) -> tuple[NDArray[Any], ...]:
        """Views on what one call leaves for the next: the last contact, if the model follows it.

        Who puts them back gives up the inverse that is kept besides (``rows.memo``).
        """
        if not (self._follows and self.settings.start):
            return ()
        grids, places = self.rows.grids, self.rows.places
        memo = self.rows.memo
        return (
            memo["known"], memo["strips"], memo["substitutes"], self.rows.vectors[X],
            *(grids[name] for name in ("on", "start_held", "end_held")),
            *(places[name] for name in ("lo", "hi", "s")),
        )  # fmt: skip
