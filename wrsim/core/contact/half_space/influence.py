"""Displacements of an elastic half-space under uniformly loaded rectangles, in closed form.

Integrals over a rectangle dx x ds of the kernels of Boussinesq and Cerruti, seen from a point at (x, s) from its
centre. Every one is a second difference of a primitive over the four corners:

    1/r        x asinh(s/|x|) + s asinh(x/|s|)          Love 1929; Johnson, Contact Mechanics, 1985, eq. (3.25)
    x^2/r^3    s asinh(x/|s|)                           Kalker, Three-Dimensional Elastic Bodies in Rolling Contact,
    s^2/r^3    x asinh(s/|x|)                           1990, section 3.2.2; Ahmadi, Keer and Mura 1983
    x s/r^3    -r
    x/r^2      x atan(s/x) + s ln(r)                    coupling of normal and tangential loads
    s/r^2      s atan(x/s) + x ln(r)

With G and nu of each body, c_n = sum (1 - nu)/(2 pi G), c_t = sum nu/(2 pi G) over both bodies and
c_k = ((1 - 2 nu_r)/G_r - (1 - 2 nu_w)/G_w)/(4 pi) (zero for equal materials), the displacement of the wheel's surface
relative to the rail's under a unit traction on an element of the wheel is

    normal from normal               A_nn = c_n I[1/r]
    along x from along x             A_xx = c_n I[1/r] + c_t I[x^2/r^3]
    along s from along s             A_ss = c_n I[1/r] + c_t I[s^2/r^3]
    along x from along s, and back   A_xs = c_t I[x s/r^3]
    along x from normal              A_xn = c_k I[x/r^2],   and A_nx = -A_xn; the same with s.

c_n is 1/(pi E*). All integrals have the dimension of a length and scale with the element.
"""

from math import asinh, atan2, log, sqrt

from wrsim.core.jit.arena import Array
from wrsim.core.jit.compiling import kernel

NN, XX, SS, XS, XN, SN = range(6)
INTEGRALS = 6


@kernel
def _primitives(x: float, s: float) -> tuple[float, float, float, float, float, float]:
    """(1/r, x^2/r^3, s^2/r^3, x s/r^3, x/r^2, s/r^2), each integrated over x and over s."""
    along_x = s * asinh(x / abs(s)) if s != 0.0 else 0.0
    along_s = x * asinh(s / abs(x)) if x != 0.0 else 0.0
    r = sqrt(x * x + s * s)
    ln = log(r) if r > 0.0 else 0.0
    # atan(s / x) as an odd function of both: no jump where x changes sign within an element
    turn = atan2(s, abs(x)) if r > 0.0 else 0.0
    other = atan2(x, abs(s)) if r > 0.0 else 0.0
    return along_x + along_s, along_x, along_s, -r, abs(x) * turn + s * ln, abs(s) * other + x * ln


@kernel
def fill_integrals(x0: float, dx: float, s0: float, ds: float, out: Array) -> None:
    """Integrals at the points (x0 + i dx, s0 + j ds) from the centre of an element dx x ds.

    out: (INTEGRALS, n + 1, m + 1), in the order NN (1/r), XX, SS, XS, XN, SN. Its last row and column are scratch;
    all lengths in one unit.
    """
    for i in range(out.shape[1]):
        for j in range(out.shape[2]):
            corner = _primitives(x0 + (i - 0.5) * dx, s0 + (j - 0.5) * ds)
            for k in range(INTEGRALS):
                out[k, i, j] = corner[k]
    for k in range(INTEGRALS):
        for i in range(out.shape[1] - 1):
            for j in range(out.shape[2] - 1):
                out[k, i, j] = out[k, i + 1, j + 1] - out[k, i, j + 1] - out[k, i + 1, j] + out[k, i, j]
