"""Equivalent linear elements: springs and dampers with the first harmonic of an element's force in a harmonic stroke.

For the travel e = A sin(w t) the force f of a damper or a slider has the equivalent stiffness and damping

    k = 1/(pi A) int f sin(p) dp,   c = 1/(pi w A) int f cos(p) dp,   p = w t over a period

(harmonic balance; Krylov and Bogoliubov). Springs that are a function of the travel keep their slope at rest.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.dynamics import friction

Array = NDArray[np.float64]

PHASES = (np.arange(2000) + 0.5) * np.pi / 2000
"""Midpoints of half a period; the integrands have kinks, the rule is within 1e-6 of them."""
UNBOUNDED = 1e15
"""Added to the largest force of a slider so that it sticks [N]."""
LEAST = 1e-12
"""Smallest stiffness of an equivalent slider over that where it sticks: its spring divides by it."""


@dataclass(frozen=True)
class Stroke:
    """Harmonic travel for which elements are linearised: amplitude [m], frequency [Hz]."""

    amplitude: float
    frequency: float

    @property
    def rate(self) -> float:
        """Angular frequency [rad/s]."""
        return 2.0 * np.pi * self.frequency

    @property
    def label(self) -> str:
        velocity = 1e3 * self.rate * self.amplitude
        travel = f"{1e3 * self.amplitude:.4g} mm and {self.frequency:.4g} Hz ({velocity:.4g} mm/s)"
        return f"dampers and friction linearised at {travel}"


SMALL_STROKE = Stroke(1e-3, 1.0)
"""The one where none is given, that of a car body which swings little on its springs. The friction of steel guides
(10 kN behind 5 to 20 kN/mm) sticks at it, and dampers stay below the velocities at which they blow off."""


def equivalent_elements(elements: Any, readings: Array, tables: Array, stroke: Stroke) -> Any:
    """Records ELEMENT (n,) of the linear elements in place of these; readings (n, 6): at the state, tables (., 2)."""
    rows = elements.copy()
    for row, reading in zip(rows, readings, strict=True):
        if row.damper_rows > 0:
            table = tables[row.damper_start : row.damper_start + row.damper_rows]
            series = float(row.series) if row.state >= 0 else None
            row.c = damper_coefficient(table if series is None else table[:, ::-1], stroke, series)
            row.damper_rows = 0
        if row.slider != friction.NO_SLIDER:
            pressing = reading if row.normal < 0 else readings[row.normal]
            normal = 0.0 if row.normal < 0 else max(0.0, float(np.dot(row.load.tolist(), pressing[:3])))
            stiffness, loss = slider_coefficients(row.slider, row.stick, row.bound + normal, stroke.amplitude)
            row.stick_damping = row.stick_damping * stiffness / row.stick + loss / stroke.rate
            row.stick, row.slider, row.bound = stiffness, friction.COULOMB, row.bound + UNBOUNDED
    return rows


def damper_coefficient(table: Array, stroke: Stroke, series: float | None = None) -> float:
    """Equivalent damping [N s/m] of a table of rows (velocity [m/s], force [N]); series: stiffness behind it [N/m].

    Behind a spring the damper moves by A k_s / |k_s + i w c|, so that its coefficient is the root of an equation,
    which is unique: the force does not fall with the velocity.
    """
    from scipy.optimize import brentq

    slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])

    def coefficient(velocity: float) -> float:
        v = velocity * np.cos(np.concatenate([PHASES, PHASES + np.pi]))
        i = np.clip(np.searchsorted(table[:, 0], v) - 1, 0, len(slopes) - 1)
        force = table[i, 1] + slopes[i] * (v - table[i, 0])
        return float(np.mean(force * v)) * 2.0 / velocity**2

    velocity = stroke.rate * stroke.amplitude
    if series is None:
        return coefficient(velocity)

    def excess(logarithm: float) -> float:
        c = np.exp(logarithm)
        return coefficient(velocity * series / float(np.hypot(series, stroke.rate * c))) / c - 1.0

    low, high = np.log(slopes.min() * (1.0 - 1e-9)), np.log(slopes.max() * (1.0 + 1e-9))
    return float(np.exp(brentq(excess, low, high)))


def slider_coefficients(law: int, stick: float, bound: float, amplitude: float) -> tuple[float, float]:
    """Equivalent stiffness [N/m] and damping times the angular frequency [N/m] of a slider of ``dynamics.friction``.

    stick: its stiffness [N/m]; bound of its force [N]. In its loop the force on the way up, over the bound, begins at
    the return -s and comes to s at the end of the stroke.
    """
    if bound <= 0.0:
        return LEAST * stick, 0.0
    from scipy.optimize import brentq

    stroke = amplitude * stick / bound
    s = brentq(lambda s: float(_way_up(law, s, np.array(2.0 * stroke))) - s, 0.0, 1.0)
    force = _way_up(law, s, stroke * (1.0 - np.cos(PHASES)))
    in_phase, across = (2.0 / stroke * float(np.mean(force * wave)) for wave in (-np.cos(PHASES), np.sin(PHASES)))
    return stick * max(in_phase, LEAST), stick * across


def _way_up(law: int, s: float, way: Array) -> Array:
    """Force of a slider over its bound after a way from the return at -s; way: in units of bound over stiffness."""
    if law == friction.FANCHER:
        return np.asarray(1.0 - (1.0 + s) * np.exp(-way))
    if law == friction.BERG:
        return np.asarray(way * (1.0 + s) / (1.0 + s + way) - s)
    part = 1.0 - friction.STUCK
    yielding = 1.0 - part * np.exp(-np.maximum(way - s - friction.STUCK, 0.0) / part)
    return np.where(way - s < friction.STUCK, way - s, yielding)
