"""Elastic axles: a shaft in steps of its diameter with stiff wheels and discs; [wheelset.axle].

Bending with shear and rotary inertia in finite elements (``track.beams``). The wheels have the mass and the
inertia that shaft and discs leave of the wheelset's, so the modes fit the rigid wheelset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field

from wrsim.errors import InputError
from wrsim.inputs.section import Section
from wrsim.inputs.values import List, number, positive
from wrsim.track.beams import bending_matrices
from wrsim.vehicle.elements import Array
from wrsim.vehicle.flexible import Modes

ELEMENT = 0.02
"""Longest element [m]; of a shaft 0.16 m thick it adds less than 0.01 % to the first six frequencies."""


@dataclass(frozen=True)
class Disc:
    """A stiff disc at y [m] on the axle: mass [kg], moment of inertia about the axle and across it [kg m2]."""

    y: float
    mass: float
    polar: float
    across: float


@dataclass(frozen=True)
class Axle:
    """A shaft: sections (length, diameter) from left to right [m], middle at 0; discs beside the wheels; young [Pa],
    poisson, density [kg/m3]; damping ratio of its modes, and their number in each plane."""

    sections: tuple[tuple[float, float], ...]
    discs: tuple[Disc, ...] = ()
    young: float = 206e9
    poisson: float = 0.3
    density: float = 7850.0
    damping: float = 0.005
    count: int = 4

    @property
    def length(self) -> float:
        return sum(length for length, _ in self.sections)

    def nodes(self, points: Sequence[float] = ()) -> Array:
        """Places of the nodes from right to left [m]: steps, discs, these points, and between them."""
        steps = np.cumsum([0.0, *(length for length, _ in self.sections)]) - 0.5 * self.length
        fixed = np.unique(np.round([*steps, *(disc.y for disc in self.discs), *points], 9))
        fixed = fixed[np.abs(fixed) <= 0.5 * self.length + 1e-9]
        pieces = [np.linspace(a, b, int(np.ceil((b - a) / ELEMENT)) + 1)[:-1] for a, b in pairwise(fixed)]
        return np.append(np.concatenate(pieces), fixed[-1])

    def diameters(self, nodes: Array) -> Array:
        """Diameters of the elements between nodes [m]."""
        ends = 0.5 * self.length - np.cumsum([length for length, _ in self.sections])
        middles = 0.5 * (nodes[1:] + nodes[:-1])
        diameters = np.array([diameter for _, diameter in self.sections])
        return np.asarray(diameters[np.minimum(np.searchsorted(-ends, -middles), len(diameters) - 1)])

    def inertia(self) -> tuple[float, float, float]:
        """Mass, moments of inertia about the axle and across it of shaft and discs."""
        nodes = self.nodes()
        length, mass, polar = np.diff(nodes), *self._per_metre(nodes)
        middle = 0.5 * (nodes[1:] + nodes[:-1])
        across = length * (0.5 * polar + mass * (middle**2 + length**2 / 12.0))
        return (
            float(mass @ length) + sum(d.mass for d in self.discs),
            float(polar @ length) + sum(d.polar for d in self.discs),
            float(across.sum()) + sum(d.across + d.mass * d.y**2 for d in self.discs),
        )

    def _per_metre(self, nodes: Array) -> tuple[Array, Array]:
        """Mass [kg/m] and polar moment of inertia [kg m] of the elements."""
        d = self.diameters(nodes)
        return self.density * np.pi / 4.0 * d**2, self.density * np.pi / 32.0 * d**4

    def torsional_stiffness(self, half: float) -> float:
        """Stiffness between the wheels at +-half [m], [N m/rad]."""
        nodes = self.nodes((half, -half))
        between = np.abs(0.5 * (nodes[1:] + nodes[:-1])) < half
        shear = 0.5 * self.young / (1.0 + self.poisson)
        soft = np.diff(nodes) / (shear * np.pi / 32.0 * self.diameters(nodes) ** 4)
        return float(1.0 / soft[between].sum())

    def wheels(self, mass: float, spin: float, across: float, half: float) -> tuple[Disc, Disc]:
        """The wheels at +-half [m] that make up a wheelset of this mass [kg] and inertia [kg m2] with shaft and discs.
        Raises InputError where nothing is left for them."""
        shaft = self.inertia()
        left = [0.5 * (a - b) for a, b in zip((mass, spin, across), shaft, strict=True)]
        left[2] -= left[0] * half**2
        if min(left) <= 0.0:
            word = ("mass", "moment of inertia about the axle", "moment of inertia across the axle")
            i = next(i for i, value in enumerate(left) if value <= 0.0)
            raise InputError(
                f"shaft and discs leave a wheel the {word[i]} {left[i]:.4g} {'kg' if i == 0 else 'kg m2'}: of the "
                f"wheelset's {(mass, spin, across)[i]:.4g} they have {shaft[i]:.4g}; it must be above 0 for each wheel"
            )
        return Disc(half, *left), Disc(-half, *left)

    def modes(self, discs: Sequence[Disc], points: Sequence[float] = ()) -> AxleModes:
        """Bending modes of the free shaft with its own discs and these, in the vertical and the horizontal plane."""
        discs = (*self.discs, *discs)
        nodes = self.nodes([*(disc.y for disc in discs), *points])
        d, length = self.diameters(nodes), np.diff(nodes)
        mass, polar = self._per_metre(nodes)
        bending = self.young * np.pi / 64.0 * d**4
        coefficient = 6.0 * (1.0 + self.poisson) / (7.0 + 6.0 * self.poisson)  # Cowper, J. Appl. Mech. 33 (1966) 335
        shear = coefficient * 0.5 * self.young / (1.0 + self.poisson) * np.pi / 4.0 * d**2
        stiffness, inertia = bending_matrices(length, bending, shear, mass, 0.5 * polar)
        turning = 0.5 * (np.append(polar * length, 0.0) + np.append(0.0, polar * length))
        for disc in discs:
            i = int(np.argmin(np.abs(nodes - disc.y)))
            inertia[2 * i, 2 * i] += disc.mass
            inertia[2 * i + 1, 2 * i + 1] += disc.across
            turning[i] += disc.polar
        squares, vectors = scipy.linalg.eigh(stiffness, inertia, subset_by_index=[2, 1 + self.count])
        vectors = vectors.T.reshape(self.count, -1, 2)
        largest = np.abs(vectors[..., 0]).max(axis=1)
        twice = 2 * self.count
        return AxleModes(
            np.tile(np.sqrt(squares) / (2.0 * np.pi), 2), np.full(twice, self.damping), np.tile(largest**-2.0, 2),
            nodes, vectors / largest[:, None, None], turning,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class AxleModes(Modes):
    """Bending modes of a free axle, those in the vertical plane first: deflection and slope (modes of a plane, nodes,
    2) at nodes [m]; polar: moments of inertia there [kg m2]."""

    nodes: Array
    deflections: Array
    polar: Array

    def shapes(self, points: Array) -> Array:
        count = len(self.deflections)
        values = np.zeros((2 * count, len(points), 6))
        for k, (moved, turn) in enumerate(np.moveaxis(self.deflections, -1, 1)):
            w, slope = np.interp(points[:, 1], self.nodes, moved), np.interp(points[:, 1], self.nodes, turn)
            values[k, :, 2], values[k, :, 3] = w, slope
            values[count + k, :, 0], values[count + k, :, 5] = w, -slope
        return values

    def gyroscopic(self) -> tuple[Array, Array]:
        slopes = self.deflections[..., 1]
        matrix, g = slopes * self.polar @ slopes.T, slopes @ self.polar
        zero = np.zeros_like(matrix)
        turning = np.zeros((2 * len(g), 3))
        turning[: len(g), 0], turning[len(g) :, 2] = g, -g
        return np.block([[zero, matrix], [-matrix, zero]]), turning


def whirl(modes: Modes, spin: float) -> tuple[Array, NDArray[np.bool_]]:
    """Natural frequencies of a free axle that spins [rad/s], slowest first [Hz], and which of them whirl forward."""
    n, w2 = len(modes.frequencies), (2.0 * np.pi * modes.frequencies) ** 2
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:], matrix[n:, :n] = np.eye(n), -np.diag(w2)
    matrix[n:, n:] = -spin * modes.gyroscopic()[0] / modes.masses[:, None]
    values, vectors = np.linalg.eig(matrix)
    upper = np.flatnonzero(values.imag > 0.0)
    order = upper[np.argsort(values.imag[upper])]
    vertical, horizontal = vectors[: n // 2, order], vectors[n // 2 : n, order]
    # about the axle to the left a wheel that rolls on turns from up to forward
    forward = np.sum((vertical * np.conj(horizontal)).imag, axis=0) > 0.0
    return values.imag[order] / (2.0 * np.pi), forward


class DiscTable(Section, header="[[wheelset.axle.discs]]"):
    """[[wheelset.axle.discs]]: a stiff disc on the axle, as a brake disc or a gear wheel."""

    y_mm: Annotated[float, number(-1500, 1500, "mm from the middle of the axle")]
    """Where it sits; positive to the left."""
    mass_kg: Annotated[float, positive(5000, "kg")]
    """Its mass."""
    polar_inertia_kg_m2: Annotated[float, positive(1e4, "kg m2 about the axle")]
    """Its moment of inertia about the axle."""
    inertia_across_kg_m2: Annotated[float, positive(1e4, "kg m2 across the axle")]
    """Its moment of inertia about a diameter."""


_Step = Annotated[
    tuple[Annotated[float, positive(5000)], Annotated[float, number(20, 1000)]],
    Field(strict=False, description="two numbers [length mm, diameter mm]"),
]


class AxleTable(Section, header="[wheelset.axle]"):
    """[wheelset.axle]: the shaft of an elastic axle; the wheels have what it leaves of the wheelset's mass and inertia.

    The axle then bends in two planes and twists; without this table it is rigid.
    """

    sections_mm: Annotated[List[_Step], Field(min_length=1)]
    """Its steps from left to right, each its length and diameter; the middle of the whole is that of the wheelset."""
    discs: List[DiscTable] = ()
    """Stiff discs beside the wheels."""
    young_GPa: Annotated[float, number(10, 1000, "GPa")] = 206.0
    """Young's modulus."""
    poisson: Annotated[float, number(0, 0.49)] = 0.3
    """Poisson's ratio."""
    density_kg_m3: Annotated[float, number(500, 25_000, "kg/m3")] = 7850.0
    """Density."""
    modes: Annotated[int, number(1, 10)] = 4
    """Bending modes in each of the two planes."""
    damping: Annotated[float, number(0, 1, "of critical")] = 0.005
    """Damping ratio of the modes."""

    def axle(self) -> Axle:
        return Axle(
            tuple((length / 1e3, diameter / 1e3) for length, diameter in self.sections_mm),
            tuple(Disc(d.y_mm / 1e3, d.mass_kg, d.polar_inertia_kg_m2, d.inertia_across_kg_m2) for d in self.discs),
            1e9 * self.young_GPa, self.poisson, self.density_kg_m3, self.damping, self.modes,
        )  # fmt: skip
