"""Bridges: modes of the deck below the track, of a beam over one span or several, or from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh

from wrsim.errors import InputError
from wrsim.geometry.piecewise import Array
from wrsim.geometry.track.beams import bending_mass, bending_stiffness
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.values import number, positive

ROWS = 200
"""Elements of a span; and rows of a bridge from a file."""

STIFF_IN_SHEAR = 1e6
"""Shear stiffness over bending stiffness of a beam without shear [1/m2]."""


@dataclass(frozen=True, eq=False)
class Bridge:
    """A bridge whose deck moves up and down in modes.

    start: where its rows begin along the track [m]; step of the rows [m]; frequencies [Hz], damping ratios, modal
    masses [kg], each (n,); shapes: value [1] and slope [1/m] of every mode at the rows (rows, n, 2). In the middle of
    the spans: values (spans, n), and moments for a unit of every mode (spans, n) [N m/m], positive where the deck sags,
    None where they are not known.
    """

    start: float
    step: float
    frequencies: Array
    damping: Array
    masses: Array
    shapes: Array
    values: Array
    moments: Array | None

    def beneath(self, elastic_length: float) -> Bridge:
        """The bridge as wheels meet it that rails on sleepers and ballast carry.

        A beam on a uniform foundation, of the elastic length L = (4 E I / k)^(1/4) [m], spreads the load of a wheel
        over the deck by exp(-|x|/L) (cos(x/L) + sin(|x|/L)) / (2 L), and follows its deflection with the same weights.
        """
        if elastic_length == 0.0:
            return self
        reach = int(np.ceil(8.0 * elastic_length / self.step))  # where exp(-8) is left
        x = self.step / elastic_length * np.abs(np.arange(-reach, reach + 1))
        weights = np.exp(-x) * (np.cos(x) + np.sin(x))
        weights /= weights.sum()
        rows = np.pad(self.shapes, ((reach, reach), (0, 0), (0, 0)))
        shapes = np.apply_along_axis(np.convolve, 0, rows, weights, "same")
        return replace(self, start=self.start - reach * self.step, shapes=shapes)

    @classmethod
    def of_spans(
        cls, start: float, spans: Sequence[float], bending: float, mass: float, damping: float, count: int
    ) -> Bridge:
        """A continuous beam on stiff supports, without shear. spans [m], bending stiffness E I [N m2], mass [kg/m]."""
        ends = np.append(0.0, np.cumsum(spans))
        step = float(ends[-1]) / (ROWS * len(spans))
        pieces = [np.linspace(a, b, ROWS + 1)[:-1] for a, b in pairwise(ends)]
        nodes = np.append(np.concatenate(pieces), ends[-1])
        length = np.diff(nodes)
        even, shear = np.full(len(length), bending), STIFF_IN_SHEAR * bending
        own = 2 * np.arange(len(length))[:, None] + np.arange(4)
        stiffness, inertia = np.zeros((2, 2 * len(nodes), 2 * len(nodes)))
        np.add.at(stiffness, (own[:, :, None], own[:, None]), bending_stiffness(length, even, shear))
        np.add.at(inertia, (own[:, :, None], own[:, None]), bending_mass(length, even, shear, mass, 0.0))
        free = np.setdiff1d(np.arange(2 * len(nodes)), 2 * ROWS * np.arange(len(spans) + 1))
        squares, vectors = eigh(*(m[np.ix_(free, free)] for m in (stiffness, inertia)), subset_by_index=[0, count - 1])
        moved = np.zeros((count, 2 * len(nodes)))
        moved[:, free] = vectors.T
        values, slopes = moved[:, ::2], moved[:, 1::2]
        largest = np.abs(values).max(axis=1)
        # curvature at the ends of every element, from its four unknowns; a node takes the mean of both sides
        a, b, da, db = values[:, :-1], values[:, 1:], slopes[:, :-1], slopes[:, 1:]
        left = (6.0 * (b - a) / length - 4.0 * da - 2.0 * db) / length
        right = (6.0 * (a - b) / length + 2.0 * da + 4.0 * db) / length
        curvature = 0.5 * (np.pad(left, ((0, 0), (0, 1)), "edge") + np.pad(right, ((0, 0), (1, 0)), "edge"))
        along = np.linspace(0.0, ends[-1], len(nodes))
        sampled = [CubicSpline(nodes, own / largest[:, None], axis=1)(along) for own in (values, slopes)]
        middle = ROWS // 2 + ROWS * np.arange(len(spans))
        return cls(
            start, step, np.sqrt(squares) / (2.0 * np.pi), np.full(count, damping), largest**-2.0,
            np.moveaxis(np.array(sampled), (0, 1, 2), (2, 1, 0)), (values / largest[:, None])[:, middle].T,
            bending * (curvature / largest[:, None])[:, middle].T,
        )  # fmt: skip


COLUMNS = {
    "mode": Annotated[int, number(1, 1000)],
    "frequency_Hz": Annotated[float, positive(1000, "Hz")],
    "damping": Annotated[float, number(0, 1, "of critical")],
    "modal_mass_kg": Annotated[float, positive(1e9, "kg")],
    "at_m": Annotated[float, number(0, 1e5, "m from the beginning of the bridge")],
    "uz": Annotated[float, number(-1e6, 1e6, "upward per unit of the mode")],
}
"""Columns of a file of a bridge's modes, a row for every mode at every place."""


def read_bridge(path: Path, start: float) -> Bridge:
    """Modes of a deck in a CSV file (``COLUMNS``). Raises InputError."""
    table, lines = read_columns(path, COLUMNS, list(COLUMNS))
    modes, first, count = np.unique(table["mode"], return_index=True, return_counts=True)
    order = np.argsort(table["mode"], kind="stable")
    if np.any(count != count[0]) or count[0] < 4:
        line = lines[first[np.argmax((count != count[0]) | (count < 4))]]
        raise InputError(f"{path}:{line}: every mode needs the same places, at least four of them")
    at = table["at_m"][order].reshape(len(modes), -1)
    if np.any(at != at[0]) or np.any(np.diff(at[0]) <= 0.0) or at[0, 0] != 0.0:
        raise InputError(f"{path}: column at_m: every mode needs the same places, rising from 0")
    along = np.linspace(0.0, at[0, -1], ROWS + 1)
    spline = CubicSpline(at[0], table["uz"][order].reshape(at.shape), axis=1)
    values, slopes = spline(along), spline(along, 1)
    largest = np.abs(values).max(axis=1)
    if not largest.all():
        raise InputError(f"{path}: column uz: mode {int(modes[np.argmin(largest)])} does not move")
    frequencies, damping, masses = (table[name][first] for name in ("frequency_Hz", "damping", "modal_mass_kg"))
    shapes = np.stack([values.T, slopes.T], axis=-1) / largest[:, None]
    middle = values[:, ROWS // 2 : ROWS // 2 + 1].T / largest
    return Bridge(start, float(along[1]), frequencies, damping, masses / largest**2, shapes, middle, None)
