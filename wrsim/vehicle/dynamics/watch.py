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
    status      [int] sum of the STATUS bits of the steps since the last look
    sampled     [int] 1: there was a sample
    steps       [int] number of steps
""")
"""Geometry of a wheel, and its vertical force between samples."""

GROWTH = record("""
    longest   [s]  longest step that resolves the growing oscillation
    looked    [s]  time of the last look for it
    bend      [N]  second difference of the force there
    finds     [1]  number of looks at which something grew
    frequency [Hz] frequency of what grows
    wheel     [1]  number of its wheel
    force     [N]  vertical force of that wheel at the last step
    passed    [s]  time of its last upward passage of the mean load
    cycles    [1]  number of cycles from one passage to the next
    cycling   [s]  duration of these in all
""")
"""A growing oscillation of a wheel."""

LONGEST_CYCLE = 3.0
"""Periods of the growing motion beyond which two passages of the mean load do not belong to one cycle: contacts that
open make it slower by some 30 %."""

SLIP, GIVEN = 0.02, 0.99
"""An axle is driven or braked beyond adhesion where its slip is more than this part of the speed, creep forces are at
their limit long before, or where slip control gives less than this part of the requested moment."""

WHEELS, GROWS, PARTS = 1, 2, 4
"""Remarks of `look`: a wheel is not on its rail, was not at the last look, or its contact has a remark; motions that
grow are to be looked for; elements or axles are marked."""

PATCHES = Arrays._fields.index("patches")


@kernel
def watch_step(
    t: float, distance: float, sampled: bool, mean_load: float, watched: Records, growing: Records, buffer: Array,
    index: Ints,
) -> None:  # fmt: skip
    """After a step: take the wheels' vertical forces into the peaks between samples, the largest second difference and
    the cycles of a growing oscillation (a record GROWTH) about the mean load [N]; sampled: this is a sample."""
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
        watch.status |= total.status
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
    growth = growing[0]
    if growth.finds > 0.0:
        force = watched[int(growth.wheel)].last
        if growth.force < mean_load <= force:
            period = t - growth.passed
            if period * growth.frequency < LONGEST_CYCLE:  # else it has been calm
                growth.cycles, growth.cycling = growth.cycles + 1.0, growth.cycling + period
            growth.passed = t
        growth.force = force


@kernel
def look(
    t: float, distance: float, bend_limit: float, pause: float, watched: Records, growing: Records, looked: Array,
    bends: Array, last: Array, last_contact: Array, stops: Array, marks: Ints, elements: Records, readings: Array,
    axles: Records, buffer: Array, index: Ints,
) -> int:  # fmt: skip
    """What a look at the last evaluation has to note, as a sum of remarks.

    bend_limit [N]: second difference of a wheel's force from look to look, into ``bends``, beyond which growing motions
    are to be looked for, after a pause [s] or where it has doubled. looked (2, wheels): forces at the last two looks;
    last: time and distance of the last one; last_contact (wheels, 2): of each wheel on its rail. stops (n, 4): element,
    place in its reading, limits; place -1: slider with a normal force. marks: 1 for each of these at its end, or loose,
    and each axle beyond adhesion.
    """
    remarks, most, growth = 0, 0.0, growing[0]
    for i in range(watched.shape[0]):
        watch, total = watched[i], wheel_total(buffer, index, i)
        bends[i] = abs(looked[0, i] - 2.0 * looked[1, i] + watch.last)
        looked[0, i], looked[1, i] = looked[1, i], watch.last
        if bends[i] > most:  # not where there was no look yet
            most = bends[i]
        arrays = index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS]
        patches, pressed, pose = records(buffer, arrays, PATCHES, LOBE), False, vector(buffer, arrays, POSE)
        for j in range(total.lobes):
            pressed = pressed or patches[j].N > 0.0
        climbed = watch.flanged != 0 and pose[1] + watch.u * pose[4] + watch.reach * pose[5] > watch.face
        solved = total.status | watch.status == 0 and memo_of(buffer, index, i).substitutes <= watch.substitutes
        if not (solved and pressed) or climbed or pose[2] - watch.level < watch.drop or last_contact[i, 0] < last[0]:
            remarks = WHEELS
    if remarks == 0:
        last_contact[:, 0], last_contact[:, 1] = t, distance
    if most > bend_limit and (t - growth.looked >= pause or most > 2.0 * growth.bend):  # what grows doubles soon
        growth.looked, growth.bend = t, most
        remarks |= GROWS
    for k in range(marks.size):
        marks[k] = 0
        if k >= stops.shape[0]:
            axle = axles[k - stops.shape[0]]
            if axle.requested != 0.0:
                marks[k] = axle.moment / axle.requested < GIVEN or abs(axle.slip) > SLIP * abs(axle.speed)
        elif stops[k, 1] >= 0.0:
            marks[k] = not stops[k, 2] <= readings[int(stops[k, 0]), int(stops[k, 1])] <= stops[k, 3]
        else:
            load, force = elements[int(stops[k, 0])].load, readings[elements[int(stops[k, 0])].normal]
            marks[k] = load.x * force[0] + load.y * force[1] + load.z * force[2] <= 0.0
        if marks[k] != 0:
            remarks |= PARTS
    return remarks


@kernel
def add_phase_error(
    t: float, step: float, tolerance: float, rest: float, rates: Array, forces: Array, errors: Array, last: Array,
    clock: Array,
) -> None:  # fmt: skip
    """Take lateral forces (wheels,) [N] at the end of a step into the errors (modes, wheels, 2) [N] of modes with these
    eigenvalues (modes, 2) [1/s] in steps of one length [s], (int-phase). last (2, wheels): forces and their rates at
    the last step; clock: time and length of that, not-a-number before the first one, 1 from an error beyond the
    tolerance [N] on until it is within this part ``rest`` of it, and the largest error."""
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
    clock[0], clock[1], clock[3] = t, length, sqrt(largest)
    clock[2] = clock[3] > (rest if clock[2] != 0.0 else 1.0) * tolerance
