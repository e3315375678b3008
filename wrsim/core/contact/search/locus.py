"""The contact locus: the curve on a yawed wheel that can touch a straight rail.

A wheel is a surface of revolution of radius rho(u) about its axle. A straight rail along t can touch it only where
the wheel's normal has no t-component. With d the radial direction of the point,
d . t = -(dw/dL) / (du/dL) e_t, which is sin(theta) = rho'(u) e_t / sqrt(1 - e_t^2) in the angle theta around the
axle from the lowest point. Seen along t the locus is the outline of the wheel: a plane curve in (o, b) that meets
the rail profile as an unyawed wheel would; its t-coordinate is the longitudinal shift of each strip.

Curvatures follow Euler and the shape operator: with the principal curvatures k1 = (du/dL) / rho (around) and k2
(along the profile), alpha the angle between t and the circumference (sin alpha = e_t / (du/dL)):

- along the rail           k_t = cos^2(alpha) k1 + sin^2(alpha) k2
- of the outline           k1 k2 / k_t
- arclength of the profile per arclength of the outline   k1 cos(alpha) / k_t  ("shrink")
  (so the curvature of the outline is also shrink k2 / cos(alpha))

A concave flange root at a large yaw can make k_t vanish: the wheel then touches at two places, ahead and behind, and
the outline has a cusp. k_t is held at ``LEAST_ROLLING_CURVATURE`` k1 there; no wheelset in service gets near.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.profile import profile_point

LEAST_ROLLING_CURVATURE = 0.1
DRAWN_SINE = 0.25  # of theta: beyond, the outline is drawn as the plain section
LARGEST_SINE = 0.7  # of theta and alpha: beyond, the point is no candidate for contact


@inlined
def locus_point(table, step, radius, ox, oo, ob, et, eo, eb, q, arc):
    """Point of the locus at profile arclength ``arc``.

    (ox, oo, ob): profile origin on the axle; (et, eo, eb): unit vector of the axle, outward, all in rail axes
    (t, o, b); q = sqrt(1 - et^2); radius: wheel radius at the tape circle [m].
    Returns (x, o, b, normal_o, normal_b, shrink, r_t, k_profile): the point, the unit normal out of the wheel (towards
    the rail), the profile's arclength per arclength of the outline, the radius of curvature along t [m] and the
    curvature of the profile [1/m].
    """
    u, w, cu, cw, k2 = profile_point(table, step, arc)
    rho = radius - w
    if et == 0.0:
        return (
            ox,
            oo + u * eo + rho * eb,
            ob + u * eb - rho * eo,
            cw * eo + cu * eb,
            cw * eb - cu * eo,
            1.0,
            rho / max(cu, 1e-3),
            k2,
        )
    iq = 1.0 / q
    inverse_c = 1.0 / max(cu, 1e-3)
    sin_alpha = et * inverse_c
    sine = -cw * sin_alpha * iq
    if abs(sine) > LARGEST_SINE or abs(sin_alpha) > LARGEST_SINE:
        sine = min(max(sine, -LARGEST_SINE), LARGEST_SINE)
        sin_alpha = min(max(sin_alpha, -LARGEST_SINE), LARGEST_SINE)
    s2 = sine * sine
    # the series is exact to 1e-15 where it is used
    cosine = 1.0 - s2 * (0.5 + s2 * (0.125 + s2 * 0.0625)) if s2 < 4e-4 else sqrt(1.0 - s2)
    do = (cosine * eb - sine * et * eo) * iq
    db = (-cosine * eo - sine * et * eb) * iq
    r1 = rho * inverse_c
    sin2 = sin_alpha * sin_alpha
    inverse_ratio = 1.0 / max(1.0 - sin2 + sin2 * k2 * r1, LEAST_ROLLING_CURVATURE)  # k1 / k_t
    # the normal has no t-component, so its other two make a unit vector as they stand;
    # t . circumference = cos(theta) q = cos(alpha)
    return (
        ox + u * et + rho * sine * q,
        oo + u * eo + rho * do,
        ob + u * eb + rho * db,
        cw * eo + cu * do,
        cw * eb + cu * db,
        cosine * q * inverse_ratio,
        r1 * inverse_ratio,
        k2,
    )


@inlined
def locus_node(table, node, radius, oo, ob, et, eo, eb, q):
    """(o, b, normal_o, normal_b, sine) at a table node, for the search: no interpolation, no curvature.

    Where abs(sine) is not below ``LARGEST_SINE`` the locus has no point (a nearly vertical flank of a yawed wheel
    touches nowhere) and the plain section is returned.
    """
    u, w, cu, cw = table[node, 0], table[node, 1], table[node, 2], table[node, 3]
    rho = radius - w
    sine = -cw * et / (max(cu, 1e-3) * q)
    angle = sine if abs(sine) < LARGEST_SINE else 0.0
    cosine = sqrt(1.0 - angle * angle)
    do = (cosine * eb - angle * et * eo) / q
    db = (-cosine * eo - angle * et * eb) / q
    return oo + u * eo + rho * do, ob + u * eb + rho * db, cw * eo + cu * do, cw * eb + cu * db, sine


@kernel
def outline(table, step, radius, pose, arc, out):
    """Outline of a wheel seen along its rail, for drawing: (o, b) at the arclengths ``arc`` to ``out`` (2, m).

    pose: see core.contact.wheel_rail. Where a yawed wheel's flank is nearly vertical the locus climbs around the
    wheel; the plain section stands there instead.
    """
    q = sqrt(1.0 - pose[3] * pose[3])
    for i in range(arc.shape[0]):
        u, w, cu, cw, _k = profile_point(table, step, arc[i])
        rho = radius - w
        sine = -cw * pose[3] / (max(cu, 1e-3) * q)
        if abs(sine) >= DRAWN_SINE:
            sine = 0.0
        cosine = sqrt(1.0 - sine * sine)
        out[0, i] = pose[1] + u * pose[4] + rho * (cosine * pose[5] - sine * pose[3] * pose[4]) / q
        out[1, i] = pose[2] + u * pose[5] + rho * (-cosine * pose[4] - sine * pose[3] * pose[5]) / q
