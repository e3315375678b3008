"""One wheel on one rail: from a pose and a motion to forces, all stages in one call.

On the right side the rail's axes (t, o, b) are left-handed; a mirrored angular velocity (sign changed once more) makes
every formula hold unchanged, so the kernel knows no side.

The normal models, the creep forces and, for a vehicle, the whole contact are stages (jit.stages): `STAGES`. A
stage takes the lobes that the search has found, their number in ``total``, and returns status bits.
"""

from math import sqrt
from typing import Any

from wrsim.contact.arrays import Arrays, arrays
from wrsim.contact.creep.creep_forces import creep_forces
from wrsim.contact.creep.friction import set_law
from wrsim.contact.creep.laws import NO_CREEP_FORCES
from wrsim.contact.kik_piotrowski import bound_lobe, build_strips, press_lobes
from wrsim.contact.left_out import share_left_out
from wrsim.contact.records import (
    CONTACT,
    CREEP_FORCES,
    FREE_STRIPS,
    KIK_PIOTROWSKI,
    STATUS_LEFT_OUT,
    STATUS_NOT_CONVERGED,
    STATUS_PROFILE_END,
    STATUS_TOO_DEEP,
    Field,
    PlacedWheel,
    ProfileTable,
    Rail,
    Shape,
    Share,
    WheelPose,
    read_pose,
)
from wrsim.contact.resultants import add_lobe
from wrsim.contact.search.lobes import couple, distance_to_saddles, select_deepest
from wrsim.contact.search.locus import locus_point, placed
from wrsim.contact.search.points import NEAR, find_contacts
from wrsim.contact.strips.model import solve_pressure
from wrsim.contact.strips.records import System
from wrsim.contact.surfaces.profile_table import profile_point
from wrsim.contact.surfaces.rail import along, rail_and_envelope, share_at
from wrsim.contact.surfaces.wheel_shape import contact_length, find_branches
from wrsim.jit import Array, Ints, Record, Records, inlined, kernel, stages
from wrsim.jit.linalg import Vec

TURNS = 2  # of creep forces and pressures that act on each other: each leaves a hundredth of the last change
LEAST_LEFT_OUT = 0.05  # of the normal force that strips leave out, beyond which a status says so
DEEPEST = 3e-3  # approach beyond which the state is called an overlap, not a contact [m]


@inlined
def turned(a: Vec, sine: float) -> Vec:
    """A vector in axes that are turned outward in plan by the angle with this sine."""
    cosine = sqrt(1.0 - sine * sine)
    return Vec(cosine * a.x + sine * a.y, cosine * a.y - sine * a.x, a.z)


@kernel
def pose_in_rail_axes(a: Arrays) -> WheelPose:
    """The pose in the axes of the rail that ``place_bodies`` sets: turned about the rail beside the wheel's origin."""
    pose, sine = read_pose(a.pose), a.call[0].sine
    if sine == 0.0:
        return pose
    origin = turned(Vec(0.0, pose.origin.y, pose.origin.z), sine)
    return WheelPose(
        Vec(pose.origin.x + origin.x, origin.y, origin.z),
        turned(pose.axle, sine), turned(pose.velocity, sine), turned(pose.omega, sine),
    )  # fmt: skip


@kernel
def in_track_axes(a: Arrays) -> None:
    """Turn force, moment and places of lobes and strips back from the rail's own axes."""
    call, total = a.call[0], a.total[0]
    sine, about = call.sine, call.about
    if sine == 0.0:
        return
    force, moment = Vec(total.Ft, total.Fo, total.Fb), Vec(total.Mt, total.Mo, total.Mb)
    force, moment = turned(force, -sine), turned(moment, -sine)
    total.Ft, total.Fo, total.Mt, total.Mo = force.x, force.y, moment.x, moment.y
    for i in range(total.lobes):
        lobe = a.patches[i]
        place = turned(Vec(lobe.x - about, lobe.o, 0.0), -sine)
        lobe.x, lobe.o = about + place.x, place.y
        for j in range(lobe.n_strips):
            strip = a.strips[i, j]
            place = turned(Vec(strip.x - about, strip.o, 0.0), -sine)
            strip.x, strip.o = about + place.x, place.y


@kernel
def place_bodies(a: Arrays) -> tuple[PlacedWheel, Rail, WheelPose]:
    """The wheel in its place, the rail there, and the pose; in the own axes of a rail that runs outward."""
    model, call, state, pose = a.model[0], a.call[0], a.state[0], read_pose(a.pose)
    shape = Shape(
        a.depth, a.branches, model.depth_rows, model.depth_first, model.depth_step, model.depth_least,
        call.wheel_angle, call.averaged,
    )  # fmt: skip
    wheel = placed(ProfileTable(a.wheel, model.wheel_step), model.radius, pose, shape, model.roller)
    place = call.place + pose.origin.x
    if a.friction.shape[0] > 0:
        set_law(a.friction, place, call)
    share, ahead = Share(0, 0, 0, 1.0, 0.0, 0.0, 0.0), 0.0
    call.sine = 0.0
    if a.rates.shape[0] > 0:
        share = share_at(a.stations[0], model.rows, place, state.station)
        sines, rates, i = a.stations[2], a.stations[3], share.at
        sine = share.a * sines[i] + share.b * sines[i + 1] + share.c * rates[i] + share.d * rates[i + 1]
        if sine != 0.0:
            call.sine, call.about = sine, pose.origin.x
            pose = pose_in_rail_axes(a)
            wheel = placed(wheel.profile, model.radius, pose, shape, model.roller)
            ahead = pose.origin.x - call.about
            share = share_at(a.stations[0], model.rows, place + ahead * sqrt(1.0 - sine * sine), i)
        state.station = share.at
    rail = Rail(
        a.rail, a.rates, a.stations[0], model.rail_step, model.rows, share, place, call.sine, ahead,
        call.twist, call.bow_o, call.bow_b, pose.axle.x, pose.origin.y, model.radius, model.roller,
    )  # fmt: skip
    return wheel, rail, pose


@kernel
def wheel_rail(buffer: Array, index: Ints) -> int:
    """Contact of one wheel and one rail at the pose set in the workspace; see `contact.arrays.Arrays`. Forces act
    on the wheel; a lobe with N = 0 is none. Returns a status, also written to ``total``: 0, or a sum of the STATUS
    bits."""
    a = arrays(buffer, index)
    model, lobes = a.model[0], a.patches
    a.call[0].averaged = 0.0
    wheel, rail, pose = place_bodies(a)
    count, status = _search(a, wheel, rail)
    if count == 0:
        return status
    count = select_deepest(a.contacts, count, lobes.shape[0])
    couple(a.contacts, count, model.eps, lobes)
    for i in range(count):
        status |= _start_lobe(wheel, rail, a.contacts[i], lobes[i])
    _group(a.contacts, model.eps, lobes, count)
    a.total[0].lobes = count
    a.memo[0].traction_pass = 0
    pressed = stages.run(model.normal, buffer, index)
    for turn in range(TURNS if model.curved and model.tangential != NO_CREEP_FORCES else 0):
        stages.run(CREEP_FORCES, buffer, index)
        a.memo[0].traction_pass = turn + 1
        pressed = stages.run(model.normal, buffer, index)
    status |= pressed
    if a.depth.shape[0] > 0 or a.rates.shape[0] > 0:
        left_out = share_left_out(wheel, rail, model, lobes, a.strips, count)
        status |= STATUS_LEFT_OUT if left_out > LEAST_LEFT_OUT else 0
    _sum_up(a, pose, buffer, index)
    in_track_axes(a)
    a.total[0].status = status
    return status


@kernel
def search(buffer: Array, index: Ints) -> tuple[int, int]:
    """Contacts at the pose set in the workspace, before any force, written to ``found``. Returns their number and a
    status; the closest distance is written to ``total``."""
    a = arrays(buffer, index)
    a.call[0].averaged = 0.0
    wheel, rail, _pose = place_bodies(a)
    return _search(a, wheel, rail)


@kernel
def apply_creep_forces(buffer: Array, index: Ints, count: int) -> None:
    """Creep forces of ``count`` lobes whose pressures are known, and the sums over all of them."""
    a = arrays(buffer, index)
    a.total[0].lobes = count
    _sum_up(a, pose_in_rail_axes(a), buffer, index)


@kernel
def _search(a: Arrays, wheel: PlacedWheel, rail: Rail) -> tuple[int, int]:
    """Clears the totals; returns the number of contacts found and a status."""
    model, total = a.model[0], a.total[0]
    total.Ft = total.Fo = total.Fb = 0.0
    total.Mt = total.Mo = total.Mb = 0.0
    total.wear = 0.0
    total.lobes = total.patches = 0
    if a.depth.shape[0] > 0:
        find_branches(wheel)
    first = int(a.stations[1, rail.share.at]) * model.field_rows
    field = Field(a.field, first, model.field_rows, model.field_o, model.field_b, model.field_spacing, model.slack)
    count, closest, status = find_contacts(wheel, rail, field, model.stride, model.hollow, a.contacts)
    total.closest = closest
    deepest = 0.0
    for i in range(count):
        deepest = max(deepest, a.contacts[i].depth)
    if closest < -deepest - NEAR:  # deepest where a profile ends: no contact is there
        status |= STATUS_PROFILE_END
    total.status = status
    if a.depth.shape[0] > 0 and count > 0:
        a.call[0].averaged = _length(wheel, a.contacts, count)
    return count, status


@kernel
def _length(wheel: PlacedWheel, contacts: Records, count: int) -> float:
    """Half length over which a wheel out of round is bent in the mean where it is deepest [m]."""
    deepest = 0
    for i in range(1, count):
        deepest = i if contacts[i].depth > contacts[deepest].depth else deepest
    contact = contacts[deepest]
    return contact_length(wheel, profile_point(wheel.profile, contact.arc_wheel), contact.depth)


@kernel
def _sum_up(a: Arrays, pose: WheelPose, buffer: Array, index: Ints) -> None:
    """Creep forces, and the sums over all lobes."""
    lobes, total = a.patches, a.total[0]
    if a.model[0].tangential != NO_CREEP_FORCES:
        stages.run(CREEP_FORCES, buffer, index)
    loaded = -1
    for i in range(total.lobes):
        add_lobe(pose, lobes[i], a.strips[i], lobes[i].n_strips, total)
        if lobes[i].N > 0.0 and lobes[i].group != loaded:
            loaded = lobes[i].group
            total.patches += 1


@kernel
def _start_lobe(wheel: PlacedWheel, rail: Rail, contact: Record, lobe: Record) -> int:
    """Main point of a lobe that the search has found, so far without pressure. Returns status bits."""
    on_wheel = locus_point(wheel, contact.arc_wheel)
    on_rail, envelope = rail_and_envelope(rail, contact.arc_rail)
    lobe.approach = contact.depth
    lobe.arc_wheel = contact.arc_wheel
    lobe.arc_rail = contact.arc_rail
    lobe.no = -on_rail.tw
    lobe.nb = on_rail.tu
    lobe.slope = along(rail, envelope, on_rail, on_wheel.x, on_wheel.to_axle).slope
    lobe.n_strips = 0
    lobe.N = lobe.p0 = lobe.area = lobe.length = lobe.width = lobe.recess = 0.0
    return STATUS_TOO_DEEP if contact.depth > DEEPEST else 0


@kernel
def _group(contacts: Records, eps: float, lobes: Records, count: int) -> None:
    """Number the patches: neighbours whose virtual penetrations overlap share one."""
    group = -1
    for i in range(count):
        joined = (
            i > 0
            and contacts[i - 1].saddle >= 0.0
            and contacts[i - 1].saddle > (1.0 - eps) * min(contacts[i - 1].depth, contacts[i].depth)
        )
        if not joined:
            group += 1
        lobes[i].group = group


@kernel
def kik_piotrowski(buffer: Array, index: Ints) -> int:
    """Strips and pressures by Kik and Piotrowski's model."""
    return _press_by_overlap(arrays(buffer, index))


@kernel
def free_strips(buffer: Array, index: Ints) -> int:
    """Strips and pressures by the strip model; by Kik and Piotrowski's where that has no solution."""
    a = arrays(buffer, index)
    wheel, rail, pose = place_bodies(a)
    system = System(wheel, rail, a.influence, a.rows, a.places, a.grids, a.vectors, a.matrix, a.memo)
    status = solve_pressure(system, a.model[0], a.state[0], pose, a.contacts, a.patches, a.strips, a.total[0].lobes)
    if status & STATUS_NOT_CONVERGED:
        status |= _press_by_overlap(a)
    return status


@kernel
def _press_by_overlap(a: Arrays) -> int:
    """Strips and pressures of all lobes by Kik and Piotrowski's model."""
    model, lobes, count = a.model[0], a.patches, a.total[0].lobes
    wheel, rail, pose = place_bodies(a)
    status = 0
    for i in range(count):
        left, right = distance_to_saddles(a.contacts, i, count)
        status |= bound_lobe(wheel, rail, model, a.contacts, i, left, right, lobes)
    for i in range(count):
        build_strips(wheel, rail, model, lobes, count, i, a.strips[i])
    press_lobes(model, pose, lobes, a.strips, count, a.work)
    return status


@kernel
def all_creep_forces(buffer: Array, index: Ints) -> int:
    """Creep forces; the pressures are known."""
    a = arrays(buffer, index)
    speed, count = pose_in_rail_axes(a).velocity.x, a.total[0].lobes
    for i in range(count):
        creep_forces(a, speed, count, i)
    return 0


STAGES: dict[int, Any] = {
    KIK_PIOTROWSKI: kik_piotrowski,
    FREE_STRIPS: free_strips,
    CREEP_FORCES: all_creep_forces,
    CONTACT: wheel_rail,
}


def compile_stages(*numbers: int) -> None:
    """See `jit.stages.make_ready`."""
    for number in numbers:
        stages.make_ready(number, STAGES[number])
