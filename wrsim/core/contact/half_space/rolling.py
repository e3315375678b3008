"""Steady rolling of half-spaces with Coulomb friction on a grid: steps of a semismooth Newton method.

Wanted are tractions q on the wheel, |q| <= g = mu p, such that the slip of every element

    s = w + (u(x) - u(x + dx)) / dx,   u = A q,

vanishes where |q| < g and is opposite to q where |q| = g (Kalker 1990, chapter 4: the material of an element was one
element further ahead a moment ago; x is the direction of rolling here). w is the rigid slip over the rolling speed:
each element has its own, so creepage and spin may vary over a curved patch.

Both conditions in one: F(q) = q - P(q - rho s) = 0 with P the projection on the disc of radius g. Where
|q - rho s| <= g that is s = 0 (adhesion), else q = g n, n = (q - rho s)/|q - rho s| (slip). Newton's steps are solved
by GMRES with convolutions in Fourier space by the caller (wrsim.contact.half_space.solvers). In adhesion the equations
of a row are summed up from the leading end of each run, which turns differences into displacements and lets the
inverse symbol of A precondition them.

Arrays are (rows, columns), x rising with the column; ``state`` is 0 outside contact, 1 in adhesion, 2 in slip.
"""

from math import sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.half_space.surface import AT_B, AT_NB, AT_NO, AT_O

OUTSIDE, ADHESION, SLIP = 0.0, 1.0, 2.0


@kernel
def natural_map(qx, qs, sx, ss, bound, rho, scale, forward, state, nx, ns, ratio, rhs):
    """State of every element and the right hand side -F of Newton's equations.

    nx, ns: direction of q - rho s; ratio: g / |q - rho s|; rhs: (2, rows, columns), in adhesion the sum of -s from
    the leading end of the run times ``scale``, in slip g n - q. forward: +1 when x rises towards the leading edge.
    Returns the largest error, as a traction, and the numbers of elements in adhesion and in slip.
    """
    rows, columns = bound.shape
    worst = 0.0
    sticking = 0
    slipping = 0
    for j in range(rows):
        sum_x = 0.0
        sum_s = 0.0
        for m in range(columns):
            i = columns - 1 - m if forward > 0.0 else m
            g = bound[j, i]
            rhs[0, j, i] = 0.0
            rhs[1, j, i] = 0.0
            if g <= 0.0:
                state[j, i] = OUTSIDE
                sum_x = 0.0
                sum_s = 0.0
                continue
            zx = qx[j, i] - rho * sx[j, i]
            zs = qs[j, i] - rho * ss[j, i]
            size = sqrt(zx * zx + zs * zs)
            if size <= g:
                state[j, i] = ADHESION
                sticking += 1
                sum_x -= sx[j, i]
                sum_s -= ss[j, i]
                rhs[0, j, i] = scale * sum_x
                rhs[1, j, i] = scale * sum_s
                worst = max(worst, rho * abs(sx[j, i]), rho * abs(ss[j, i]))
            else:
                state[j, i] = SLIP
                slipping += 1
                sum_x = 0.0
                sum_s = 0.0
                nx[j, i] = zx / size
                ns[j, i] = zs / size
                ratio[j, i] = g / size
                rhs[0, j, i] = g * nx[j, i] - qx[j, i]
                rhs[1, j, i] = g * ns[j, i] - qs[j, i]
                worst = max(worst, abs(rhs[0, j, i]), abs(rhs[1, j, i]))
    return worst, sticking, slipping


@kernel
def derivative(d, r, rho, scale, forward, state, nx, ns, ratio, out):
    """Newton's matrix times a change d of q; r: change of slip, (2, rows, columns) like d and out."""
    rows, columns = state.shape
    for j in range(rows):
        sum_x = 0.0
        sum_s = 0.0
        for m in range(columns):
            i = columns - 1 - m if forward > 0.0 else m
            if state[j, i] == ADHESION:
                sum_x += r[0, j, i]
                sum_s += r[1, j, i]
                out[0, j, i] = scale * sum_x
                out[1, j, i] = scale * sum_s
                continue
            sum_x = 0.0
            sum_s = 0.0
            if state[j, i] == SLIP:
                zx = d[0, j, i] - rho * r[0, j, i]
                zs = d[1, j, i] - rho * r[1, j, i]
                along = zx * nx[j, i] + zs * ns[j, i]
                out[0, j, i] = d[0, j, i] - ratio[j, i] * (zx - along * nx[j, i])
                out[1, j, i] = d[1, j, i] - ratio[j, i] * (zs - along * ns[j, i])
            else:
                out[0, j, i] = 0.0
                out[1, j, i] = 0.0


@kernel
def pick(v, state, wanted, out):
    """out = v where the state is the wanted one, else zero; (2, rows, columns)."""
    for j in range(state.shape[0]):
        for i in range(state.shape[1]):
            keep = state[j, i] == wanted
            out[0, j, i] = v[0, j, i] if keep else 0.0
            out[1, j, i] = v[1, j, i] if keep else 0.0


@kernel
def join(smooth, v, state, out):
    """out = smooth in adhesion, v in slip, zero outside; (2, rows, columns)."""
    for c in range(2):
        for j in range(state.shape[0]):
            for i in range(state.shape[1]):
                if state[j, i] == ADHESION:
                    out[c, j, i] = smooth[c, j, i]
                elif state[j, i] == SLIP:
                    out[c, j, i] = v[c, j, i]
                else:
                    out[c, j, i] = 0.0


@kernel
def update(q, d, share, bound):
    """q += share d, brought back into the disc |q| <= g where it has left it."""
    for j in range(bound.shape[0]):
        for i in range(bound.shape[1]):
            g = bound[j, i]
            if g <= 0.0:
                q[0, j, i] = 0.0
                q[1, j, i] = 0.0
                continue
            x = q[0, j, i] + share * d[0, j, i]
            s = q[1, j, i] + share * d[1, j, i]
            size = sqrt(x * x + s * s)
            back = g / size if size > g else 1.0
            q[0, j, i] = back * x
            q[1, j, i] = back * s


@kernel
def march(wx, ws, bound, l1, l2, step, forward, q):
    """A first guess: rigid slip summed up from the leading end with one flexibility along x and one along s.

    l1, l2: displacement over traction [m/Pa]; step: dx. The simplified theory of rolling contact (Kalker 1982).
    """
    rows, columns = bound.shape
    for j in range(rows):
        x = 0.0
        s = 0.0
        for m in range(columns):
            i = columns - 1 - m if forward > 0.0 else m
            g = bound[j, i]
            if g <= 0.0:
                x = 0.0
                s = 0.0
            else:
                x -= wx[j, i] * step / l1
                s -= ws[j, i] * step / l2
                size = sqrt(x * x + s * s)
                if size > g:
                    x *= g / size
                    s *= g / size
            q[0, j, i] = x
            q[1, j, i] = s


@kernel
def rigid_slip(pose, least_speed, axis, rows, x0, dx, ahead, place, wx, ws):
    """Rigid slip of every element: velocity of the wheel's material relative to the rail's, over the rolling speed.

    Both velocities, seen from the moving contact, are projected on the plane between them, as the material of the
    wheel runs along its curved surface: without that the slip would err by x^2 / (2 R^2). Points lie on the
    undeformed surface of the wheel. ahead: how far ahead of the element's centre the slip is taken, in elements.
    Writes wx, ws (rows, columns). Returns the rolling direction, +1 or -1.
    """
    vt, vo, vb = pose[6], pose[7], pose[8]
    wt, wo, wb = pose[9], pose[10], pose[11]
    forward = 1.0 if vt >= 0.0 else -1.0
    speed = sqrt(vt * vt + least_speed * least_speed)
    inverse = 1.0 / speed
    for j in range(rows):
        row = axis[j]
        no, nb = row[AT_NO], row[AT_NB]
        for i in range(wx.shape[1]):
            rx = x0 + (i + forward * ahead) * dx - pose[0]
            ro = row[AT_O] + place[j, i] * no - pose[1]
            rb = row[AT_B] + place[j, i] * nb - pose[2]
            ut = vt + wo * rb - wb * ro
            uo = vo + wb * rx - wt * rb
            ub = vb + wt * ro - wo * rx
            # the rail's material comes at -vt along the rail; the wheel's at ut - vt, with un along the normal
            un = uo * no + ub * nb
            x = ut - vt
            mx = x - vt
            size = sqrt(mx * mx + un * un)
            if size > 1e-3 * least_speed:
                slip = -forward * (ut * mx + un * un) / size
            else:
                slip = ut
            wx[j, i] = slip * inverse
            ws[j, i] = (uo * nb - ub * no) * inverse
    return forward


@kernel
def orthogonalise(basis, k, h):
    """Make row k + 1 of the basis orthogonal to rows 0 .. k (modified Gram and Schmidt) and of unit length.

    Writes the column h (k + 2,) of Arnoldi's matrix. Plain loops: a threaded library would wait for busy cores.
    """
    n = basis.shape[1]
    w = basis[k + 1]
    for j in range(k + 1):
        product = 0.0
        v = basis[j]
        for i in range(n):
            product += v[i] * w[i]
        h[j] = product
        for i in range(n):
            w[i] -= product * v[i]
    size = 0.0
    for i in range(n):
        size += w[i] * w[i]
    size = sqrt(size)
    h[k + 1] = size
    if size > 0.0:
        for i in range(n):
            w[i] /= size


@kernel
def rotate(h, k, cosines, sines, g):
    """Givens' rotations on the column h of Arnoldi's matrix; g: right hand side. Returns the new residual."""
    for j in range(k):
        a = cosines[j] * h[j] + sines[j] * h[j + 1]
        h[j + 1] = -sines[j] * h[j] + cosines[j] * h[j + 1]
        h[j] = a
    size = sqrt(h[k] * h[k] + h[k + 1] * h[k + 1])
    cosines[k] = h[k] / size if size > 0.0 else 1.0
    sines[k] = h[k + 1] / size if size > 0.0 else 0.0
    h[k] = size
    h[k + 1] = 0.0
    g[k + 1] = -sines[k] * g[k]
    g[k] = cosines[k] * g[k]
    return abs(g[k + 1])


@kernel
def combine(basis, columns, k, g, y, out):
    """out = sum of y_j basis_j with the upper triangle columns[j, i <= j] y = g, j < k."""
    for i in range(k - 1, -1, -1):
        value = g[i]
        for j in range(i + 1, k):
            value -= columns[j, i] * y[j]
        y[i] = value / columns[i, i] if columns[i, i] != 0.0 else 0.0
    for i in range(out.shape[0]):
        out[i] = 0.0
    for j in range(k):
        v = basis[j]
        c = y[j]
        for i in range(out.shape[0]):
            out[i] += c * v[i]
