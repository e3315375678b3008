"""The equivalent conicity over gauges and pairs of profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

    def rows(self) -> list[list[str]]:
        """A table, its header first: one row per pair and gauge."""
        head = ["wheel", "rail", "gauge_mm", "equivalent_conicity_3_mm", "nonlinearity_per_mm"]
        found = [head]
        for i, pair in enumerate(self.pairs):
            for j, gauge in enumerate(self.gauges):
                values = (self.conicity[i, j], self.nonlinearity[i, j])
                found.append([*pair, f"{1e3 * gauge:.6g}", *("" if v != v else f"{v:.6g}" for v in values)])
        return found
