"""Stress in a half-space under uniformly loaded rectangles, in closed form (sub-potentials, sub-stress).

A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) for pressures; J. J. Kalker, Three-Dimensional Elastic Bodies in
Rolling Contact, 1990, section 3 and appendix for tractions. The stresses of Boussinesq's and Cerruti's point loads are
derivatives of phi = ln(R + z) and chi = z ln(R + z) - R. Integrated over a rectangle they are differences of the
primitives below over its corners.
"""

from math import atan2, copysign, log, pi, sqrt

from wrsim.jit import Array, inlined, kernel

EDGE = 1e-12  # from where on a point is on an edge [m]
TINY = EDGE**2  # square of a distance to an edge [m2]: what is loaded alike on both sides of it cancels there


@inlined
def _corner(
    x: float, y: float, z: float, nu: float, p: float, qx: float, qy: float
) -> tuple[float, float, float, float, float, float]:
    """2 pi times the stresses xx, yy, zz, yz, xz, xy of a quarter plane that bears p, qx, qy; x, y, z: seen from its
    corner."""
    # on an edge both sides count half
    x, y = 0.0 if abs(x) < EDGE else x, 0.0 if abs(y) < EDGE else y
    rx, ry = max(x * x + z * z, TINY), max(y * y + z * z, TINY)
    r = sqrt(max(x * x + y * y + z * z, TINY))
    h = 1.0 / (r + z)
    # primitives of the derivatives of phi; those named a to c occur times z
    yy, xx = atan2(x * y * (r - z), y * y * r + x * x * z), atan2(x * y * (r - z), x * x * r + y * y * z)
    zz, xy = -xx - yy, log(r + z)
    # asinh(y / sqrt(rx)) and asinh(x / sqrt(ry))
    xz, yz = copysign(log((abs(y) + r) / sqrt(rx)), y), copysign(log((abs(x) + r) / sqrt(ry)), x)
    xzz, yzz, xyz = -y * z / (r * rx), -x * z / (r * ry), 1.0 / r
    xxz, yyz = -x * y / (r * rx), -x * y / (r * ry)
    xxy, xyy = x * h / r, y * h / r
    xxx, yyy = -xyy - xzz, -xxy - yzz
    # of chi
    cxxy, cxyy = -x * h, -y * h
    cxxx, cyyy = -cxyy - xz, -cxxy - yz
    rest = 1.0 - 2.0 * nu
    return (
        p * (2.0 * nu * zz - rest * xx - z * xxz)
        + qx * (2.0 * (1.0 + nu) * xz - z * xxx + 2.0 * nu * cxxx)
        + qy * (2.0 * nu * yz - z * xxy + 2.0 * nu * cxxy),
        p * (2.0 * nu * zz - rest * yy - z * yyz)
        + qx * (2.0 * nu * xz - z * xyy + 2.0 * nu * cxyy)
        + qy * (2.0 * (1.0 + nu) * yz - z * yyy + 2.0 * nu * cyyy),
        p * (zz + z * (xxz + yyz)) - z * (qx * xzz + qy * yzz),
        -p * z * yzz - qx * z * xyz + qy * (zz - z * yyz),
        -p * z * xzz + qx * (zz - z * xxz) - qy * z * xyz,
        p * (-rest * xy - z * xyz) + qx * (yz - z * xxy + 2.0 * nu * cxxy) + qy * (xz - z * xyy + 2.0 * nu * cxyy),
    )


@kernel
def add_stress(
    s: Array, ds: Array, x: Array, a: Array, tractions: Array, nu: float, points: Array, stress: Array
) -> None:
    """Add the stresses under rows of rectangles.

    s, ds: middles and widths of the rows (n,); x, a: middles and half lengths (n,) [m]; tractions: (3, n, columns)
    pressure and tractions on the body along x and s in equal parts of each row, by rising x [Pa]; points: (m, 3) x, s
    and depth, not below 0 [m]; stress: (m, 6) xx, ss, zz, sz, xz, xs, tension positive, z into the body.
    """
    columns = tractions.shape[2]
    factor = 0.5 / pi
    for k in range(points.shape[0]):
        px, ps, z = points[k, 0], points[k, 1], points[k, 2]
        t0 = t1 = t2 = t3 = t4 = t5 = 0.0
        for j in range(s.shape[0]):
            upper = ps - s[j] + 0.5 * ds[j]
            lower = upper - ds[j]
            step = 2.0 * a[j] / columns
            for c in range(columns + 1):
                p = qx = qy = 0.0
                if c < columns:
                    p, qx, qy = tractions[0, j, c], tractions[1, j, c], tractions[2, j, c]
                if c > 0:
                    p -= tractions[0, j, c - 1]
                    qx -= tractions[1, j, c - 1]
                    qy -= tractions[2, j, c - 1]
                if p == 0.0 and qx == 0.0 and qy == 0.0:
                    continue
                along = px - (x[j] - a[j] + c * step)
                u0, u1, u2, u3, u4, u5 = _corner(along, upper, z, nu, p, qx, qy)
                v0, v1, v2, v3, v4, v5 = _corner(along, lower, z, nu, p, qx, qy)
                t0 += u0 - v0
                t1 += u1 - v1
                t2 += u2 - v2
                t3 += u3 - v3
                t4 += u4 - v4
                t5 += u5 - v5
        stress[k, 0] += factor * t0
        stress[k, 1] += factor * t1
        stress[k, 2] += factor * t2
        stress[k, 3] += factor * t3
        stress[k, 4] += factor * t4
        stress[k, 5] += factor * t5
