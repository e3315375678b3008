"""Forms of transitions: how curvature and cant lead from one value to another over a length (track-transition).

Sources: A. E. Bloss, Organ fuer die Fortschritte des Eisenbahnwesens 73 (1936) 319-320; all others: IFC 4.3.2
(ISO 16739-1:2024), IfcAlignmentHorizontalSegmentTypeEnum and IfcAlignmentCantSegmentTypeEnum.
"""

from collections.abc import Callable, Sequence
from math import factorial, pi
from typing import Literal, get_args

import numpy as np

from wrsim.contact.profiles.curves import gauss_integrals, subdivided
from wrsim.errors import InputError, suggest
from wrsim.track.piecewise import NODES, Array, Piecewise, interpolant

Form = Literal["clothoid", "bloss", "cosine", "sine", "cubic parabola", "helmert", "viennese"]
CantForm = Literal["linear", "bloss", "cosine", "sine", "helmert", "viennese"]
FORMS: tuple[Form, ...] = get_args(Form)
CANT_FORMS: tuple[CantForm, ...] = get_args(CantForm)
LABEL = {"bloss": "Bloss", "helmert": "Helmert", "viennese": "Viennese bend"}

STEEPEST_PARABOLA = 5.0**-0.5
"""Largest slope of y = a x^3 [1]: there its curvature 6 a x / (1 + y'^2)^(3/2) is largest, beyond it falls."""

_POWER = np.arange(30)  # of the series of sine and cosine up to pi; the next term is 3e-18
_SERIES = np.array([pi**k / factorial(k) for k in _POWER])
_COSINE, _SINE = (_SERIES * np.take(signs, _POWER % 4) for signs in ([1, 0, -1, 0], [0, 1, 0, -1]))
_HALF, _FULL = 0.5 * (_POWER == 0), 0.5 * (_POWER == 1)  # 1/2 and half of xi

VIENNESE = np.array([0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0])
RAMPS: dict[str, tuple[Array, ...]] = {
    "clothoid": (np.array([0.0, 1.0]),),
    "bloss": (np.array([0.0, 0.0, 3.0, -2.0]),),
    "cosine": (_HALF - 0.5 * _COSINE,),
    "sine": (_FULL - _SINE / (2.0 * pi), _HALF + _FULL + _SINE / (2.0 * pi)),
    "helmert": (np.array([0.0, 0.0, 0.5]), np.array([0.5, 1.0, -0.5])),
    "viennese": (VIENNESE,),
}
"""Ramps f(xi) from 0 to 1 in one or two equal parts: coefficients of rising powers of the share of the part."""
RAMPS |= {"linear": RAMPS["clothoid"], "cubic parabola": RAMPS["clothoid"]}


def check_form(where: str, key: str, form: str, allowed: tuple[str, ...]) -> None:
    """Refuse an unknown form."""
    if form not in allowed:
        hint = suggest(str(form), allowed)
        raise InputError(f"{where}: {key} = {form!r}; allowed: {', '.join(map(repr, allowed))}{hint}")


def distance_at(stretch: Callable[[Array], Array], start: Array, length: Array) -> Array:
    """x (m,) up to which the integral of ``stretch`` from start on is the length (m,), by Newton's method; a stretch of
    1 to 1.1 in pieces of one polynomial."""
    x = start + length / stretch(start)
    for _ in range(6):
        x += (length - gauss_integrals(stretch, start, x, 32)) / stretch(x)
    return np.asarray(x)


def ramp_law(edges: Array, start: Array, end: Array, forms: Sequence[str]) -> Piecewise:
    """A law of cant or gauge: pieces between the edges (m + 1,) [m], from start to end (m,) in their forms; the ramp of
    a cubic parabola is linear."""
    return Piecewise.of_rows(*_ramps(edges, start, end, forms))


def curvature_law(edges: Array, start: Array, end: Array, forms: Sequence[str], shift: Sequence[float]) -> Piecewise:
    """The law of curvature [1/m] of pieces between the edges (m + 1,) [m], from start to end (m,).

    shift: by how much the cant of the piece, from its start to its end, moves the centre of gravity of a Viennese bend
    to the left [m], (m,): height times the change of cant over its base.
    """
    fine, rows = _ramps(edges, start, end, forms)
    for i, form in enumerate(forms):
        if form not in ("cubic parabola", "viennese"):
            continue
        length, row = edges[i + 1] - edges[i], np.searchsorted(fine, edges[i])
        if form == "cubic parabola":
            rows = np.pad(rows, ((0, 0), (0, max(0, NODES.size - rows.shape[1]))))
            rows[row] = np.pad(_cubic_parabola(start[i], end[i], length), (0, rows.shape[1] - NODES.size))
        else:
            rows[row, : VIENNESE.size - 2] -= shift[i] / length**2 * np.polynomial.polynomial.polyder(VIENNESE, 2)
    return Piecewise.of_rows(fine, rows)


def checked_shift(
    where: str, form: str, start: float, end: float, length: float, lean: float, height: float | None
) -> float:
    """`curvature_law`'s shift of one piece [m], 0 but for a Viennese bend.

    start, end: curvature [1/m]; lean: change of the cant over its base; height: of the centre of gravity above the rail
    tops [m]. Raises InputError, beginning with where, for a Viennese bend whose cant changes without such a height and
    for a cubic parabola that turns too far.
    """
    if form == "cubic parabola":
        flat = _flattest(start, end, length)
        least = start + (end - start) * flat / length
        turn = 0.5 * max(abs(start + least) * flat, abs(end + least) * (length - flat))  # as a clothoid
        if turn > STEEPEST_PARABOLA:
            message = "its radius grows again; allowed: a shorter one, or a clothoid"
            raise InputError(f"{where}: cubic parabola over {turn:.3g} rad; beyond {STEEPEST_PARABOLA:.3g} {message}")
    if form != "viennese" or lean == 0.0:
        return 0.0
    if height is None:
        message = "its cant moves the centre of gravity, and with it the plan; allowed: its height, such as 1.8"
        raise InputError(f"{where}: centre_of_gravity_height_m is missing: {message} (0: the plan as without cant)")
    return height * lean


def _flattest(start: float, end: float, length: float) -> float:
    """Distance of the point of least curvature from the start of a linear law [m]."""
    if start * end < 0.0:
        return length * start / (start - end)
    return 0.0 if abs(start) <= abs(end) else length


def _cubic_parabola(start: float, end: float, length: float) -> Array:
    """Curvature over arclength of y'' = k + (end - start) x / length, with x along the tangent in the flattest point:
    coefficients of powers of xi. From or to a straight this is y = x^3/(6 R length)."""
    flat = _flattest(start, end, length)
    rate = (end - start) / length
    least = start + rate * flat

    def stretch(x: Array) -> Array:
        return np.hypot(1.0, least * x + 0.5 * rate * x**2)

    x = distance_at(stretch, np.zeros(NODES.size), length * NODES - flat)
    return interpolant((least + rate * x) / stretch(x) ** 3)


def _ramps(edges: Array, start: Array, end: Array, forms: Sequence[str]) -> tuple[Array, Array]:
    """Edges and rows of `Piecewise.of_rows` of the ramps between two values."""
    parts = [RAMPS[form] for form in forms]
    ramps = [part for each in parts for part in each]
    rows = np.zeros((len(ramps), max(map(len, ramps))))
    for row, ramp in zip(rows, ramps, strict=True):
        row[: ramp.size] = ramp
    count = np.array([len(each) for each in parts])
    rows *= np.repeat(end - start, count)[:, None]
    rows[:, 0] += np.repeat(start, count)
    return subdivided(edges, count), rows
