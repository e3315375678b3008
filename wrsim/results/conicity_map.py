"""The equivalent conicity over gauges and pairs of profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.results.table import Column, Table

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConicityMap:
    """Over pairs of profiles, wheels before rails, and gauges [m]: equivalent conicity at 3 mm and Polach's
    nonlinearity parameter [1/mm], both (pairs, gauges), not-a-number where the wheelset has none; ``reasons`` says
    why."""

    pairs: tuple[tuple[str, str], ...]
    gauges: tuple[float, ...]
    conicity: Array
    nonlinearity: Array
    reasons: tuple[str, ...]
    title: str = ""

    def table(self) -> Table:
        """One row per pair and gauge; what has no conicity says why beneath."""
        rows = [
            (*pair, 1e3 * gauge, float(self.conicity[i, j]), float(self.nonlinearity[i, j]))
            for i, pair in enumerate(self.pairs)
            for j, gauge in enumerate(self.gauges)
        ]
        heads = (
            Column("wheel", key="wheel"),
            Column("rail", key="rail"),
            Column("gauge", "mm", ".6g", "gauge_mm"),
            Column("tan γe, 3 mm", "", ".3f", "equivalent_conicity_3_mm"),
            Column("nonlinearity", "1/mm", ".3f", "nonlinearity_per_mm"),
        )
        return Table(self.title, heads, rows, self.reasons)
