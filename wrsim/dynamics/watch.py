"""What a run watches on its wheels: force peaks between its samples and strikes that its steps do not resolve, and
whether every wheel runs on its rail.

Arrays of the wheels in an arena as in ``dynamics.wheel_forces``; one record WATCH a wheel.
"""

from wrsim.contact.arrays import Arrays
from wrsim.contact.records import LOBE
from wrsim.contact.strips.records import MEMO
from wrsim.dynamics.wheel_forces import ARRAYS, IN_CONTACT, POSE, wheel_total
from wrsim.jit.arena import Array, Ints, Records, record, records, vector
from wrsim.jit.compiling import kernel

WATCH = record(
    "level drop u reach face sample most most_at most_s least least_at least_s beyond force time distance "
    "earlier last last_at last_s bend bend_force bend_at bend_s bend_step",
    "flanged substitutes sampled steps",
)
"""Geometry [m]: height of the axle with the tape circle on the rail's top, how far below that a wheel has left the
rail's head, place of the flange's lowest point along the axle and its distance from it, outward coordinate of the gauge
face; whether there is a flange. Vertical force [N] at the last sample if there was one (``sampled``), the largest and
the smallest since then with time [s] and distance [m]; the force that went farthest beyond both samples around it, by
how much, when and where. Force at the last two of ``steps``; its largest second difference from step to step, with the
force, time and distance in the middle and the step [s]. substitutes: those of the strip model so far."""

PATCHES, MEMO_PLACE = Arrays._fields.index("patches"), Arrays._fields.index("memo")


@kernel
def watch_step(t: float, distance: float, sampled: bool, watched: Records, buffer: Array, index: Ints) -> None:
    """After a step: take the wheels' vertical forces into the peaks between samples and the largest second difference;
    sampled: this is a sample."""
    for i in range(watched.shape[0]):
        own, force = watched[i], wheel_total(buffer, index, i).Fb
        bend = abs(own.earlier - 2.0 * own.last + force)
        if own.steps >= 2 and bend > own.bend:
            own.bend, own.bend_force, own.bend_at, own.bend_s = bend, own.last, own.last_at, own.last_s
            own.bend_step = t - own.last_at
        if own.steps >= 2 and own.earlier < own.last > force:
            # the crest of the parabola through three steps: off by the fourth power of the step, not the second
            crest = own.last + (force - own.earlier) ** 2 / (8.0 * bend)
            if crest > own.most:
                own.most, own.most_at, own.most_s = crest, own.last_at, own.last_s
        own.earlier, own.last, own.last_at, own.last_s, own.steps = own.last, force, t, distance, own.steps + 1
        if not sampled:
            if force > own.most:
                own.most, own.most_at, own.most_s = force, t, distance
            if force < own.least:
                own.least, own.least_at, own.least_s = force, t, distance
            continue
        if own.sampled != 0:
            above, below = own.most - max(own.sample, force), min(own.sample, force) - own.least
            if above >= below and above > own.beyond:
                own.beyond, own.force, own.time, own.distance = above, own.most, own.most_at, own.most_s
            elif below > above and below > own.beyond:
                own.beyond, own.force, own.time, own.distance = below, own.least, own.least_at, own.least_s
        own.sample, own.sampled, own.most, own.least = force, 1, -float("inf"), float("inf")


@kernel
def all_on_rails(watched: Records, buffer: Array, index: Ints) -> bool:
    """True if every wheel carries a force, is on its rail, and its contact has been solved without a remark."""
    for i in range(watched.shape[0]):
        own, total = watched[i], wheel_total(buffer, index, i)
        arrays = index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS]
        if total.status != 0 or records(buffer, arrays, MEMO_PLACE, MEMO)[0].substitutes > own.substitutes:
            return False
        patches, pressed = records(buffer, arrays, PATCHES, LOBE), False
        for j in range(total.lobes):
            pressed = pressed or patches[j].N > 0.0
        pose = vector(buffer, arrays, POSE)
        climbed = own.flanged != 0 and pose[1] + own.u * pose[4] + own.reach * pose[5] > own.face
        if not pressed or climbed or pose[2] - own.level < own.drop:
            return False
    return True
