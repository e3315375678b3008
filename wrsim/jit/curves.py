"""Cubics between two rows of a table."""

from wrsim.jit import inlined


@inlined
def hermite(a: float, b: float, da: float, db: float, r: float) -> tuple[float, float, float]:
    """Value and two derivatives of the cubic from a to b with slopes da, db, at r in 0 .. 1."""
    c = 3.0 * (b - a) - 2.0 * da - db
    e = 2.0 * (a - b) + da + db
    return a + r * (da + r * (c + r * e)), da + r * (2.0 * c + 3.0 * r * e), 2.0 * c + 6.0 * r * e
