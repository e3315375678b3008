"""Tractions of a contact on one of its bodies, and the stresses below them.

Every element acts as on a half-space. A curved patch is unrolled: a point is given by its place x along the rail, by
the arclength s of its profile and by its depth along the normal there, and so are its stresses. The surface then bears
exactly the tractions of the contact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from wrsim.contact.channels import ElementField
from wrsim.contact.model import ContactModel
from wrsim.contact.patches import RawContacts, patches_of
from wrsim.contact.subsurface.rectangle import add_stress
from wrsim.contact.subsurface.stress import Stress
from wrsim.contact.tables import bound_over_cells
from wrsim.contact.workspace import KernelArrays
from wrsim.errors import InputError
from wrsim.jit import Array

Body = Literal["rail", "wheel"]
SMALL = 1e-3  # of the rows' largest half length: no load has a part for that
MIDDLES, DEPTHS, SHARPEST = 250, 24, 2e-3  # of the search for an extreme: places, depths, last step over the size
ALIKE = 1e-9  # gain that is none


class LoadedRows(NamedTuple):
    """Rows of equal parts: middles s and widths ds, middles x and half lengths a (n,) [m]; tractions (3, n, parts) on
    the body, pressure, along x and across, by rising x [Pa]."""

    s: Array
    ds: Array
    x: Array
    a: Array
    tractions: Array


class Extreme(NamedTuple):
    """Largest value [Pa] of a measure of stress, and where: x, s, depth [m]."""

    value: float
    x: float
    s: float
    depth: float


@dataclass(frozen=True)
class SurfaceLoads:
    """What a contact does to the surface of one body, seen from one of its patches.

    rows: of all lobes of the wheel, s from the main point of this patch; lobes: how many of them, the first ones, are
    of this patch; patch: its smallest and largest x and s [m]; p0: its largest pressure [Pa]; poisson_ratio: of the
    body.
    """

    rows: tuple[LoadedRows, ...]
    lobes: int
    patch: tuple[tuple[float, float], tuple[float, float]]
    p0: float
    poisson_ratio: float

    def __repr__(self) -> str:
        length, width = (1e3 * (high - low) for low, high in self.patch)
        return f"SurfaceLoads(patch of {length:.3g} x {width:.3g} mm, p0 {1e-6 * self.p0:.4g} MPa)"

    @property
    def size(self) -> float:
        """Of the patch: the geometric mean of its length and width, over 2 [m]."""
        (x0, x1), (s0, s1) = self.patch
        return 0.5 * sqrt((x1 - x0) * (s1 - s0))

    def stress(self, x: ArrayLike, s: ArrayLike, depth: ArrayLike) -> Stress:
        """Stresses at points, whose coordinates are broadcast [m].

        Raises
        ------
        InputError
            For a depth below 0 and for coordinates that are not finite.
        """
        points = np.stack(np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, s, depth))), axis=-1)
        if not (np.isfinite(points).all() and (points[..., 2] >= 0.0).all()):
            raise InputError("x, s, depth: must be finite numbers, the depth 0 or above")
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        stress = np.zeros((len(flat), 6))
        for rows in self.rows:
            add_stress(*rows, self.poisson_ratio, flat, stress)
        return Stress(stress.reshape(*points.shape[:-1], 6))

    @cached_property
    def middles(self) -> Array:
        """Places x, s of the middles of this patch's elements under load, (n, 2) [m]. In the surface, stresses along
        it are infinite at the edges of uniformly loaded elements: there they are taken at middles alone."""
        places = []
        for rows in self.rows[: self.lobes]:
            parts = rows.tractions.shape[2]
            x = rows.x[:, None] + rows.a[:, None] * ((2.0 * np.arange(parts) + 1.0) / parts - 1.0)
            loaded = rows.tractions[0] > 0.0
            places.append(np.column_stack([x[loaded], np.broadcast_to(rows.s[:, None], x.shape)[loaded]]))
        return np.concatenate(places)

    def extreme(self, measure: Literal["von_mises", "tresca"] = "von_mises") -> Extreme:
        """The largest value of a measure in and below the patch: at the middles of elements at depths that grow
        finer, then between them where it lies deeper than an element is wide."""
        depths = 2.0 * self.size * np.linspace(0.0, 1.0, DEPTHS) ** 2
        element = min(float(rows.ds.min()) for rows in self.rows[: self.lobes])
        some = self.middles[:: max(1, len(self.middles) // MIDDLES)]
        best = self._largest(measure, (some[:, :1], some[:, 1:], depths))
        near = np.hypot(*(self.middles - best[1:3]).T) < 0.3 * self.size
        best = self._largest(measure, (*self.middles[near].T, best.depth))
        reach = 2.0 * self.size / DEPTHS
        while reach > SHARPEST * self.size:
            steps = reach * np.array([-1.0, 0.0, 1.0])
            sideways = steps if best.depth > element else np.zeros(1)
            down = np.maximum(best.depth + steps, 0.0)
            last, best = best, self._largest(measure, np.ix_(best.x + sideways, best.s + sideways, down))
            reach *= 0.5 if best.value <= last.value * (1.0 + ALIKE) else 1.0
        return best

    def _largest(self, measure: str, points: tuple[ArrayLike, ...]) -> Extreme:
        x, s, depth = places = np.broadcast_arrays(*points)
        values = getattr(self.stress(x, s, depth), measure)
        index = np.unravel_index(int(values.argmax()), values.shape)
        return Extreme(float(values[index]), *(float(axis[index]) for axis in places))


def surface_loads(
    model: ContactModel, body: Body = "rail", elements: Sequence[ElementField] | None = None
) -> tuple[SurfaceLoads, ...]:
    """What the contact at the pose of the last `ContactModel.evaluate` does to the surface of a body.

    Parameters
    ----------
    model : ContactModel
        Its pose is solved again, with the tractions in the cells of strips.
    body : {"rail", "wheel"}
        On whose surface the tractions act.
    elements : sequence of ElementField, optional
        Of the exact solver for this contact, where they are known: it is not solved again.

    Returns
    -------
    tuple of SurfaceLoads
        One for each patch, by falling normal force. They give the stresses below.

    Raises
    ------
    InputError
        For another body.
    """
    if body not in ("rail", "wheel"):
        raise InputError(f"body = {body!r:.20}: must be rail or wheel")
    exact = model.normal.solve is not None and model.settings.creep_forces in ("half-space", "none")
    if exact and elements is None:
        from wrsim.contact.half_space.strips import element_fields, solve_into

        elements = element_fields(solve_into(model), len(model.arrays.patches))
    solved = model if exact else model.with_tractions()
    a = solved.arrays
    raw = RawContacts.empty(1, 1, len(a.patches))
    raw.store(0, 0, a)
    member, main, present = (values[0, 0] for values in patches_of(raw))
    sign = -1.0 if body == "rail" else 1.0
    lobes = [i for i in range(int(a.total["lobes"])) if a.patches["N"][i] > 0.0]
    rows = {i: _of_elements(a, i, elements[i], sign) if elements else _of_strips(solved, i, sign) for i in lobes}
    nu = (solved.settings.rail if body == "rail" else solved.settings.wheel).poisson_ratio
    loads = []
    for patch in np.flatnonzero(present):
        origin = a.patches["arc_rail"][main[patch]]
        order = sorted(lobes, key=lambda i: not member[patch, i])
        moved = [rows[i]._replace(s=rows[i].s + a.patches["arc_rail"][i] - origin) for i in order]
        count = int(member[patch].sum())
        along = _extent([(r.x, r.a) for r in moved[:count]])
        across = _extent([(r.s, 0.5 * r.ds) for r in moved[:count]])
        p0 = float(a.patches["p0"][member[patch]].max())
        loads.append(SurfaceLoads(tuple(moved), count, (along, across), p0, nu))
    return tuple(loads)


def _extent(parts: Sequence[tuple[Array, Array]]) -> tuple[float, float]:
    """Smallest and largest place of parts: middles and half lengths."""
    return min(float((m - h).min()) for m, h in parts), max(float((m + h).max()) for m, h in parts)


def _of_strips(model: ContactModel, lobe: int, sign: float) -> LoadedRows:
    """Semi-ellipses of pressure in cells. Tractions of laws without cells are in proportion to the pressure."""
    a, cells = model.arrays, model.settings.cells
    strips = a.strips[lobe, : a.patches[lobe].n_strips]
    used = np.flatnonzero((strips["a"] > SMALL * strips["a"].max()) & (strips["N"] > 0.0))
    stored, strips = model.tractions_in_cells(lobe), strips[used]
    p = (2.0 * strips["N"] / (pi * strips["a"] * strips["ds"]))[:, None] * bound_over_cells(cells, False)
    q = np.stack([strips["Fx"], strips["Fy"]])[..., None] / strips["N"][:, None] * p
    q = q if stored is None else stored[:, used]
    s, ds, x, half = (strips[name].copy() for name in ("s", "ds", "x", "a"))
    return LoadedRows(s, ds, x, half, np.stack([p, *(sign * q)]))


def _of_elements(a: KernelArrays, lobe: int, field: ElementField, sign: float) -> LoadedRows:
    strips = a.strips[lobe, : a.patches[lobe].n_strips]
    step = field.x[1] - field.x[0] if field.x.size > 1 else 2.0 * strips["a"].max()
    n = np.ones(len(strips))
    middle, half = 0.5 * (field.x[0] + field.x[-1]), 0.5 * step * field.x.size
    tractions = np.nan_to_num(np.stack([field.p, *(sign * field.q)]))
    return LoadedRows(strips["s"].copy(), strips["ds"].copy(), middle * n, half * n, np.ascontiguousarray(tractions))
