"""What strips along the rail leave out: a further place where a wheel out of round, or one on a rail that changes along
the track, meets its rail.

A strip has one semi-ellipse of pressure. Beside it the bodies must not overlap: the penetration less the displacement
by all strips is at most zero there. Where it is not, along the rail through a main point, the wheel rests on a further
place as well: on the other edge of a flat, or behind a dipped joint. Its force is estimated by Hertz's law
(oor-left-out).
"""

from math import pi, sin, sqrt

from wrsim.contact.records import PlacedWheel, Rail, Share
from wrsim.contact.surfaces.profile_table import profile_point
from wrsim.contact.surfaces.rail import changes, rail_and_envelope, way_ahead
from wrsim.contact.surfaces.wheel_shape import gap_along, round_angle, slope_across, touch
from wrsim.jit import Record, Records, inlined, kernel
from wrsim.jit.root import interval

COLUMN = 1e-3  # distance of places along the rail: of a radius of 50 mm between two of them 2.5 um are not seen [m]
FARTHEST = 0.06  # place of a rail that is looked at [m]: 2 R m of both in a dip of 2 x m = 65 mrad, R = 0.46 m
TAKEN = 0.5  # of its force a further place takes from the first one, over the displacement there
NODE = sqrt(0.5)  # of the half length: outer ones of three forces with the moments of a semi-ellipse, 1 : 2 : 1


@kernel
def share_left_out(wheel: PlacedWheel, rail: Rail, model: Record, lobes: Records, strips: Records, count: int) -> float:
    """Estimate of the normal force of further places, over that of all lobes (oor-left-out)."""
    missing = force = 0.0
    for i in range(count):
        lobe = lobes[i]
        if lobe.N <= 0.0:
            continue
        middle = 0
        for j in range(lobe.n_strips):
            middle = j if abs(strips[i, j].s) < abs(strips[i, middle].s) else middle
        x, a, overlap = strips[i, middle].x, strips[i, middle].a, 0.0
        if wheel.shape.depth.shape[0] > 0:
            overlap = _on_wheel(wheel, model, lobes, strips, count, lobe, x, a)
        if changes(rail):
            overlap = max(overlap, _on_rail(rail, model, lobes, strips, count, lobe, x, a))
        missing += lobe.N * (overlap / lobe.approach) ** 1.5
        force += lobe.N
    return missing / force if force > 0.0 else 0.0


@inlined
def _on_wheel(
    wheel: PlacedWheel, model: Record, lobes: Records, strips: Records, count: int, lobe: Record, middle: float,
    a: float,
) -> float:  # fmt: skip
    """Largest overlap of a wheel out of round beside a strip of the half length a about its middle [m]."""
    at = profile_point(wheel.profile, lobe.arc_wheel)
    on = touch(wheel, at.u, at.w, slope_across(at))
    size = sqrt(1.0 + on.turn * on.turn + on.p_u * on.p_u)
    touched = wheel.origin.x + at.u * wheel.axle.x + on.p * on.sine * wheel.q
    rho = wheel.radius - at.w
    ahead = abs(on.p * sin(on.theta - round_angle(wheel, -slope_across(at))))
    # from the lowest point of a round wheel places are as far as their depth makes good for
    reach = ahead + sqrt(ahead * ahead + 2.0 * rho * (rho - on.p - wheel.shape.least + lobe.approach))
    overlap, x = 0.0, -reach
    while x <= reach:
        above = lobe.approach - gap_along(wheel, at, on, x) / size
        if above > overlap and abs(touched + x - middle) > a:
            overlap = max(overlap, _left(above, model, lobes, strips, count, lobe, touched + x))
        x += COLUMN
    return overlap


@inlined
def _on_rail(
    rail: Rail, model: Record, lobes: Records, strips: Records, count: int, lobe: Record, middle: float, a: float
) -> float:  # fmt: skip
    """The same of a rail that changes along the track. Its places are those that its effective profile has at the
    stations near by, raised by the wheel's drop there and lowered by that from here."""
    here, envelope = rail_and_envelope(rail, lobe.arc_rail)
    place = rail.place + way_ahead(rail, here.u, here.w, here.tu, here.tw)
    stations, last = rail.stations, rail.stations.shape[0] - 1
    overlap, i = 0.0, interval(stations, place - FARTHEST, rail.share.at)
    while i <= last and stations[i] <= place + FARTHEST:
        k = min(i, last - 1)
        share = Share(k, k * rail.rows, (k + 1) * rail.rows, 1.0 - (i - k), 1.0 * (i - k), 0.0, 0.0)
        station = Rail(
            rail.table, rail.rates, stations, rail.step, rail.rows, share, stations[i], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            rail.o, rail.radius, 0.0,
        )  # fmt: skip
        other, touched = rail_and_envelope(station, lobe.arc_rail)
        ahead = stations[i] + touched.ahead - place
        x, r = lobe.x - envelope.ahead + ahead, rail.radius
        if abs(ahead) < FARTHEST and abs(x - middle) > a:
            drop = sqrt(r * r - touched.ahead * touched.ahead) - sqrt(r * r - ahead * ahead)
            out = other.u - rail.sine * ahead - here.u  # the track's axis goes on beside a rail that runs outward
            above = lobe.approach - out * here.tw + (other.w - drop - here.w) * here.tu
            if above > overlap:
                overlap = max(overlap, _left(above, model, lobes, strips, count, lobe, x))
        i += 1
    return overlap


@inlined
def _left(above: float, model: Record, lobes: Records, strips: Records, count: int, at: Record, x: float) -> float:
    """What the strips of all lobes leave of an overlap at a place x along the rail beside a lobe's main point [m], less
    what a force there takes from the lobe's (oor-left-out); far strips act with the cosine of the angle between the
    normals."""
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
    displacement /= pi * model.E
    return (above - displacement) * max(1.0 - TAKEN * displacement / at.approach, 0.0) ** (2.0 / 3.0)
