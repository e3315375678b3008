"""What strips along the rail leave out: a further place where a wheel out of round meets the rail.

A strip has one semi-ellipse of pressure. Beside it the bodies must not overlap: the penetration less the displacement
by all strips is at most zero there. Where it is not, along the rail through a main point, the wheel rests on a further
place as well, on the other edge of a flat. Its force is estimated by Hertz's law (oor-left-out).
"""

from math import pi, sin, sqrt

from wrsim.contact.records import PlacedWheel
from wrsim.contact.surfaces.profile_table import profile_point
from wrsim.contact.surfaces.wheel_shape import gap_along, round_angle, slope_across, touch
from wrsim.jit import Record, Records, inlined, kernel

COLUMN = 1e-3  # distance of places along the rail: of a radius of 50 mm between two of them 2.5 um are not seen [m]
NODE = sqrt(0.5)  # of the half length: outer ones of three forces with the moments of a semi-ellipse, 1 : 2 : 1


@kernel
def share_left_out(wheel: PlacedWheel, model: Record, lobes: Records, strips: Records, count: int) -> float:
    """Estimate of the normal force of further places, over that of all lobes (oor-left-out)."""
    least, missing, force = wheel.shape.least, 0.0, 0.0
    for i in range(count):
        lobe = lobes[i]
        if lobe.N <= 0.0:
            continue
        at = profile_point(wheel.profile, lobe.arc_wheel)
        on = touch(wheel, at.u, at.w, slope_across(at))
        size = sqrt(1.0 + on.turn * on.turn + on.p_u * on.p_u)
        touched = wheel.origin.x + at.u * wheel.axle.x + on.p * on.sine * wheel.q
        rho, middle = wheel.radius - at.w, 0
        ahead = abs(on.p * sin(on.theta - round_angle(wheel, -slope_across(at))))
        for j in range(lobe.n_strips):
            middle = j if abs(strips[i, j].s) < abs(strips[i, middle].s) else middle
        inside, a = strips[i, middle].x - touched, strips[i, middle].a
        # from the lowest point of a round wheel places are as far as their depth makes good for
        reach = ahead + sqrt(ahead * ahead + 2.0 * rho * (rho - on.p - least + lobe.approach))
        overlap, x = 0.0, -reach
        while x <= reach:
            above = lobe.approach - gap_along(wheel, at, on, x) / size
            if above > overlap and abs(x - inside) > a:
                overlap = max(overlap, above - _displacement(model, lobes, strips, count, lobe, touched + x))
            x += COLUMN
        missing += lobe.N * (overlap / lobe.approach) ** 1.5
        force += lobe.N
    return missing / force if force > 0.0 else 0.0


@inlined
def _displacement(model: Record, lobes: Records, strips: Records, count: int, at: Record, x: float) -> float:
    """By the strips of all lobes at a place x along the rail beside a lobe's main point [m]; far ones act with the
    cosine of the angle between the normals."""
    displacement = 0.0
    for i in range(count):
        facing = at.no * lobes[i].no + at.nb * lobes[i].nb
        factor = 1.0 + model.damping * lobes[i].closing  # damping loads a strip, but moves nothing
        if facing <= 0.0 or factor <= 0.0:
            continue
        pushed = 0.0
        for j in range(lobes[i].n_strips):
            strip = strips[i, j]
            o, b, ahead, away = strip.o - at.o, strip.b - at.b, x - strip.x, NODE * strip.a
            beside = o * o + b * b + 0.0625 * strip.ds * strip.ds  # ds/4: mean distance from a strip's middle
            pushed += strip.N * (
                0.5 / sqrt(ahead * ahead + beside)
                + 0.25 / sqrt((ahead - away) ** 2 + beside)
                + 0.25 / sqrt((ahead + away) ** 2 + beside)
            )
        displacement += facing * pushed / factor
    return displacement / (pi * model.E)
