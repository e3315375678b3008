"""A profile as a table over its arclength.

Rows stand at uniform arclength ``step`` from L = 0; columns: u (outward), w (height), du/dL, dw/dL, curvature
(rate of the tangent angle, positive where the curve bends upwards). Position and tangent are read by cubic Hermite
interpolation, the curvature linearly; an index costs a division, no search.
"""

from wrsim.core.compiling import inlined


@inlined
def profile_point(table, step, arc):
    """Point of a profile at arclength ``arc`` [m]: (u, w, tangent_u, tangent_w, curvature).

    The tangent's length differs from 1 by the fourth power of step times curvature (1e-10 for 0.1 mm on 13 mm).
    Beyond either end the profile goes on straight.
    """
    last = table.shape[0] - 1
    x = arc / step
    if x <= 0.0:
        d = arc
        return table[0, 0] + d * table[0, 2], table[0, 1] + d * table[0, 3], table[0, 2], table[0, 3], 0.0
    if x >= last:
        d = arc - last * step
        return (
            table[last, 0] + d * table[last, 2],
            table[last, 1] + d * table[last, 3],
            table[last, 2],
            table[last, 3],
            0.0,
        )
    i = int(x)
    r = x - i
    u0, w0, tu0, tw0, k0 = table[i, 0], table[i, 1], table[i, 2], table[i, 3], table[i, 4]
    u1, w1, tu1, tw1, k1 = table[i + 1, 0], table[i + 1, 1], table[i + 1, 2], table[i + 1, 3], table[i + 1, 4]
    r2 = r * r
    r3 = r2 * r
    h01 = 3.0 * r2 - 2.0 * r3
    h10 = (r3 - 2.0 * r2 + r) * step
    h11 = (r3 - r2) * step
    u = u0 + h01 * (u1 - u0) + h10 * tu0 + h11 * tu1
    w = w0 + h01 * (w1 - w0) + h10 * tw0 + h11 * tw1
    d01 = 6.0 * (r - r2) / step
    d10 = 3.0 * r2 - 4.0 * r + 1.0
    d11 = 3.0 * r2 - 2.0 * r
    tu = d01 * (u1 - u0) + d10 * tu0 + d11 * tu1
    tw = d01 * (w1 - w0) + d10 * tw0 + d11 * tw1
    return u, w, tu, tw, k0 + r * (k1 - k0)
