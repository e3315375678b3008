"""What a run watches on its wheels: force peaks between its samples and strikes that its steps do not resolve, and
whether every wheel runs on its rail.

Arrays of the wheels in an arena as in ``dynamics.wheel_forces``; one record WATCH a wheel.
"""

from math import cos, exp, sin, sqrt

from wrsim.contact.arrays import Arrays
from wrsim.contact.records import LOBE
from wrsim.jit.arena import Array, Ints, Records, record, records, vector
from wrsim.jit.compiling import kernel
from wrsim.vehicle.dynamics.wheel_forces import ARRAYS, IN_CONTACT, POSE, memo_of, wheel_total

WATCH = record("""
    level       [m]   height of the axle with the tape circle on the rail's top
    drop        [m]   distance below that at which a wheel has left the rail's head
    u           [m]   place of the flange's lowest point along the axle
    reach       [m]   distance of that point from the axle
    face        [m]   outward coordinate of the gauge face
    sample      [N]   vertical force at the last sample
    most        [N]   largest force since then
    most_at     [s]   time of that
    most_s      [m]   distance of that
    least       [N]   smallest force since then
    least_at    [s]   time of that
    least_s     [m]   distance of that
    beyond      [N]   largest excess of a force over both samples around it
    force       [N]   that force
    time        [s]   time of that
    distance    [m]   distance of that
    earlier     [N]   force at the step before the last
    last        [N]   force at the last step
    last_at     [s]   time of that
    last_s      [m]   distance of that
    lateral     [N]   outward force at the last step
    bend        [N]   largest second difference of the force from step to step
    bend_force  [N]   force in the middle of that
    bend_at     [s]   time of that
    bend_s      [m]   distance of that
    bend_step   [s]   step there
    flanged     [int] 1: the wheel has a flange
    substitutes [int] number of substitutes of the strip model so far
    sampled     [int] 1: there was a sample
    steps       [int] number of steps
""")
"""Geometry of a wheel, and its vertical force between samples."""

PATCHES = Arrays._fields.index("patches")


@kernel
def watch_step(t: float, distance: float, sampled: bool, watched: Records, buffer: Array, index: Ints) -> None:
    """After a step: take the wheels' vertical forces into the peaks between samples and the largest second difference;
    sampled: this is a sample."""
    for i in range(watched.shape[0]):
        watch, total = watched[i], wheel_total(buffer, index, i)
        force = total.Fb
        bend = abs(watch.earlier - 2.0 * watch.last + force)
        if watch.steps >= 2 and bend > watch.bend:
            watch.bend, watch.bend_force, watch.bend_at, watch.bend_s = bend, watch.last, watch.last_at, watch.last_s
            watch.bend_step = t - watch.last_at
        if watch.steps >= 2 and watch.earlier < watch.last > force:
            # the crest of the parabola through three steps: off by the fourth power of the step, not the second
            crest = watch.last + (force - watch.earlier) ** 2 / (8.0 * bend)
            if crest > watch.most:
                watch.most, watch.most_at, watch.most_s = crest, watch.last_at, watch.last_s
        watch.earlier, watch.last, watch.last_at, watch.last_s = watch.last, force, t, distance
        watch.lateral = total.Fo
        watch.steps += 1
        if not sampled:
            if force > watch.most:
                watch.most, watch.most_at, watch.most_s = force, t, distance
            if force < watch.least:
                watch.least, watch.least_at, watch.least_s = force, t, distance
            continue
        if watch.sampled != 0:
            above, below = watch.most - max(watch.sample, force), min(watch.sample, force) - watch.least
            if above >= below and above > watch.beyond:
                watch.beyond, watch.force, watch.time, watch.distance = above, watch.most, watch.most_at, watch.most_s
            elif below > above and below > watch.beyond:
                watch.beyond, watch.force = below, watch.least
                watch.time, watch.distance = watch.least_at, watch.least_s
        watch.sample, watch.sampled, watch.most, watch.least = force, 1, -float("inf"), float("inf")


@kernel
def all_on_rails(watched: Records, buffer: Array, index: Ints) -> bool:
    """True if every wheel carries a force, is on its rail, and its contact has been solved without a remark."""
    for i in range(watched.shape[0]):
        watch, total = watched[i], wheel_total(buffer, index, i)
        arrays = index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS]
        if total.status != 0 or memo_of(buffer, index, i).substitutes > watch.substitutes:
            return False
        patches, pressed = records(buffer, arrays, PATCHES, LOBE), False
        for j in range(total.lobes):
            pressed = pressed or patches[j].N > 0.0
        pose = vector(buffer, arrays, POSE)
        climbed = watch.flanged != 0 and pose[1] + watch.u * pose[4] + watch.reach * pose[5] > watch.face
        if not pressed or climbed or pose[2] - watch.level < watch.drop:
            return False
    return True


@kernel
def add_phase_error(
    t: float, step: float, rates: Array, forces: Array, errors: Array, last: Array, clock: Array
) -> float:
    """Take lateral forces (wheels,) [N] at the end of a step into the errors (modes, wheels, 2) [N] of modes with these
    eigenvalues (modes, 2) [1/s] in steps of one length [s], (int-phase). last (2, wheels): forces and their rates at
    the last step; clock: time and length of that, not-a-number before the first one. Returns the largest error."""
    length, before = t - clock[0], clock[1]
    largest = 0.0
    for m in range(rates.shape[0] if before > 0.0 else 0):
        size, angle = exp(rates[m, 0] * length), rates[m, 1] * length
        c, s = size * cos(angle), size * sin(angle)
        share = length / 6.0 * rates[m, 1] * 2.0 * step * step / (length + before)
        for i in range(forces.shape[0]):
            x, y = errors[m, i, 0], errors[m, i, 1]
            x, y = c * x - s * y, s * x + c * y
            x += share * ((forces[i] - last[0, i]) / length - last[1, i])
            errors[m, i, 0], errors[m, i, 1] = x, y
            largest = max(largest, x * x + y * y)
    for i in range(forces.shape[0]):
        last[0, i], last[1, i] = forces[i], (forces[i] - last[0, i]) / length
    clock[0], clock[1] = t, length
    return sqrt(largest)
