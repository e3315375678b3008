"""Rigid slip: velocity of the wheel's material relative to the rail's, over the rolling speed.

Both velocities, seen from the moving contact, are projected on the plane between them, as the material of the wheel
runs along its curved surface: without that the slip would err by x^2 / (2 R^2). Points lie on the undeformed surface
of the wheel.
"""

from math import sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.half_space.surface import centre_at
from wrsim.core.linalg import Vec, add, cross, dot, shifted, sub


@kernel
def rigid_slip(pose, least_speed, axis, incline, x0, dx, place, w):
    """Write the slip w (2, rows, columns) at x0 + i dx on the surface that ``surface.fill_gap`` has found.

    least_speed: the rolling speed is held above it [m/s].
    """
    forward = 1.0 if pose.velocity.x >= 0.0 else -1.0
    rail = pose.velocity.x
    inverse = 1.0 / sqrt(rail * rail + least_speed * least_speed)
    for j in range(axis.size):
        row = axis[j]
        normal = Vec(0.0, row.no, row.nb)
        tangent = Vec(0.0, row.nb, -row.no)
        for i in range(w.shape[2]):
            point = shifted(centre_at(row, incline, x0 + i * dx), place[j, i], normal)
            u = add(pose.velocity, cross(pose.omega, sub(point, pose.origin)))
            # the rail's material comes at -v along the rail; the wheel's at u - v, with un along the normal
            ux, un = u.x, dot(u, normal)
            if row.slope != 0.0:
                upright = 1.0 / sqrt(1.0 + row.slope * row.slope)
                ux, un = (ux + row.slope * un) * upright, (un - row.slope * ux) * upright
            mx = ux - rail - rail
            size = sqrt(mx * mx + un * un)
            slip = -forward * (ux * mx + un * un) / size if size > 1e-3 * least_speed else ux
            w[0, j, i] = slip * inverse
            w[1, j, i] = dot(u, tangent) * inverse
