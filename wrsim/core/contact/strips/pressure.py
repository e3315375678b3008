"""Pressures of all lobes of a wheel by the strip model: sums, damping, and what the lobes report."""

from math import pi

from wrsim.core.compiling import kernel
from wrsim.core.contact.records import STATUS_UNSETTLED
from wrsim.core.contact.resultants import set_creepages
from wrsim.core.contact.strips.model import strip_model
from wrsim.core.contact.strips.records import Unknowns

WARM_REACH = 1e-3  # how far a main point may have moved for the last contact to be a first guess [m]
NEARLY = 1e-4  # misfit over the penetration that the strip model may end with


@kernel
def press_strips(a, pose, count):
    """Pressures of all strips from their own contact conditions (`strips.model`), with damping. Returns a status.

    a: Arrays of core.contact.wheel_rail.
    """
    settings, lobes, strips, m = a.settings[0], a.patches, a.strips, a.matrices
    for i in range(count):
        lobe = lobes[i]
        if abs(lobe.arc_rail - lobe.last_arc) > WARM_REACH:
            lobe.last_strips = 0
        lobe.last_arc = lobe.arc_rail
    state = Unknowns(a.places, a.spans, a.factors, a.step, m[0], m[1], m[2], m[3], m[4])
    iterations, misfit = strip_model(lobes, strips, count, settings.E, pose.axle, settings.start, state)
    for i in range(count):
        lobe = lobes[i]
        n = lobe.n_strips
        set_creepages(pose, settings.least_speed, lobe, strips[i], n)
        factor = max(1.0 + settings.damping * lobe.closing, 0.0)
        largest = normal = area = longest = 0.0
        for j in range(n):
            row = strips[i, j]
            a = row.a
            row.N = 0.5 * pi * row.p * factor * a * a * row.ds
            row.p *= factor * a
            largest = max(largest, row.p)
            normal += row.N
            area += 2.0 * a * row.ds
            longest = max(longest, a)
        lobe.p0 = largest
        lobe.N = normal
        lobe.start = strips[i, 0].s - 0.5 * strips[i, 0].ds if n > 0 else 0.0
        lobe.end = strips[i, n - 1].s + 0.5 * strips[i, 0].ds if n > 0 else 0.0
        lobe.width = lobe.end - lobe.start
        lobe.area = area
        lobe.length = 2.0 * longest
        lobe.amplitude = largest / longest if longest > 0.0 else 0.0
    return STATUS_UNSETTLED if iterations < 0 and misfit > NEARLY else 0
