"""The root of a function that changes its sign within a bracket, and the interval that holds a number, from a guess on
or by halves."""

from math import sqrt
from typing import NamedTuple

from wrsim.jit import Array, inlined


class Bracket(NamedTuple):
    """The function is ``lo_h`` > 0 at lo and ``hi_h`` <= 0 at hi; side: the end that moved last (+1 lo, -1 hi, 0
    none)."""

    lo: float
    lo_h: float
    hi: float
    hi_h: float
    side: int


@inlined
def crossing(b: Bracket) -> float:
    """Where the chord crosses zero, for a function that is nearly linear in the square of its argument."""
    return sqrt((b.lo * b.lo * b.hi_h - b.hi * b.hi * b.lo_h) / (b.hi_h - b.lo_h))


@inlined
def narrowed(b: Bracket, s: float, h: float) -> Bracket:
    """The bracket with the value h at s in the place of one end; Illinois' regula falsi: an end that stays twice counts
    half."""
    if h > 0.0:
        return Bracket(s, h, b.hi, 0.5 * b.hi_h if b.side == 1 else b.hi_h, 1)
    return Bracket(b.lo, 0.5 * b.lo_h if b.side == -1 else b.lo_h, s, h, -1)


@inlined
def interval(knots: Array, s: float, guess: int) -> int:
    """The interval of rising knots (n,) that holds s, looked for from a guess on; the first or the last one outside."""
    i = guess
    while i > 0 and s < knots[i]:
        i -= 1
    while i < knots.size - 2 and s >= knots[i + 1]:
        i += 1
    return i


@inlined
def neighbours(knots: Array, x: float) -> tuple[int, int, float]:
    """Numbers of the rising knots (n,) below and above x, by halves, and the part of the way from one to the other. At
    the ends and beyond them it is the end, twice."""
    low, high = 0, knots.size - 1
    if x <= knots[low]:
        return low, low, 0.0
    if x >= knots[high]:
        return high, high, 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if x < knots[middle]:
            high = middle
        else:
            low = middle
    return low, high, (x - knots[low]) / (knots[high] - knots[low])
