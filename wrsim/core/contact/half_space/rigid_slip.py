"""Rigid slip: velocity of the wheel's material relative to the rail's, over the rolling speed.

Both velocities, seen from the moving contact, are projected on the plane between them, as the material of the wheel
runs along its curved surface: without that the slip would err by x^2 / (2 R^2). Points lie on the undeformed surface
of the wheel.
"""

from math import sqrt

from wrsim.core.compiling import kernel
from wrsim.core.linalg import Vec, add, cross, dot, sub


@kernel
def rigid_slip(pose, least_speed, axis, x0, dx, place, w):
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
            point = Vec(x0 + i * dx, row.o + place[j, i] * row.no, row.b + place[j, i] * row.nb)
            u = add(pose.velocity, cross(pose.omega, sub(point, pose.origin)))
            # the rail's material comes at -v along the rail; the wheel's at u - v, with un along the normal
            un = dot(u, normal)
            mx = u.x - rail - rail
            size = sqrt(mx * mx + un * un)
            slip = -forward * (u.x * mx + un * un) / size if size > 1e-3 * least_speed else u.x
            w[0, j, i] = slip * inverse
            w[1, j, i] = dot(u, tangent) * inverse
