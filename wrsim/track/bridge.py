"""Bridges: modes of the deck below the track, of a beam over one span or several, or from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from wrsim.errors import InputError
from wrsim.inputs.mode_tables import of_modes, read_mode_table
from wrsim.inputs.values import number
from wrsim.track.beams import STIFF, bending_matrices
from wrsim.track.piecewise import Array

ROWS = 200
"""Elements of a span; and rows of a bridge from a file."""


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

    @property
    def length(self) -> float:
        """Along the track [m]."""
        return self.step * (len(self.shapes) - 1)

    def at(self, places: Array) -> tuple[Array, Array]:
        """Values [1] and slopes [1/m] of the modes at places along the track [m] (places, n), 0 beside the bridge."""
        rows = self.start + self.step * np.arange(len(self.shapes))
        spline = scipy.interpolate.CubicHermiteSpline(rows, self.shapes[..., 0], self.shapes[..., 1], extrapolate=False)
        return np.nan_to_num(spline(places)), np.nan_to_num(spline(places, 1))

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
        even = np.full(len(length), bending)
        stiffness, inertia = bending_matrices(length, even, STIFF * bending, mass, 0.0)
        free = np.setdiff1d(np.arange(2 * len(nodes)), 2 * ROWS * np.arange(len(spans) + 1))
        squares, vectors = scipy.linalg.eigh(
            *(m[np.ix_(free, free)] for m in (stiffness, inertia)), subset_by_index=[0, count - 1]
        )
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
        spline = scipy.interpolate.CubicSpline
        sampled = [spline(nodes, rows / largest[:, None], axis=1)(along) for rows in (values, slopes)]
        middle = ROWS // 2 + ROWS * np.arange(len(spans))
        return cls(
            start, step, np.sqrt(squares) / (2.0 * np.pi), np.full(count, damping), largest**-2.0,
            np.moveaxis(np.array(sampled), (0, 1, 2), (2, 1, 0)), (values / largest[:, None])[:, middle].T,
            bending * (curvature / largest[:, None])[:, middle].T,
        )  # fmt: skip


MODE_COLUMNS = of_modes(1000.0, 1e9)
PLACES = {"at_m": Annotated[float, number(0, 1e5, "m from the beginning of the bridge")]}
SHAPES = {"uz": Annotated[float, number(-1e6, 1e6, "upward per unit of the mode")]}
"""Columns of a file of a bridge's modes."""


def read_bridge(path: Path, start: float) -> Bridge:
    """Modes of a deck in a CSV file (``wrsim.inputs.mode_tables``). Raises InputError."""
    table = read_mode_table(path, MODE_COLUMNS, PLACES, SHAPES, list(SHAPES))
    places, uz = table.places[:, 0], table.shapes[:, :, 0]
    if len(places) < 4:
        raise InputError(f"{path}:{table.lines[0]}: every mode needs the same places, at least four of them")
    if np.any(np.diff(places) <= 0.0) or places[0] != 0.0:
        raise InputError(f"{path}: column at_m: every mode needs the same places, rising from 0")
    along = np.linspace(0.0, places[-1], ROWS + 1)
    spline = scipy.interpolate.CubicSpline(places, uz, axis=1)
    values, slopes = spline(along), spline(along, 1)
    largest = np.abs(values).max(axis=1)
    if not largest.all():
        raise InputError(f"{path}: column uz: mode {int(np.argmin(largest)) + 1} does not move")
    shapes = np.stack([values.T, slopes.T], axis=-1) / largest[:, None]
    middle = values[:, ROWS // 2 : ROWS // 2 + 1].T / largest
    masses = table.masses / largest**2
    return Bridge(start, float(along[1]), table.frequencies, table.damping, masses, shapes, middle, None)
