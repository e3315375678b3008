"""Heights at which wheels carry a vertical load, and many poses in one call.

The search knows force and approach at the heights evaluated. By Hertz force^(2/3) is about proportional to the
approach, so the search is a secant of force^(2/3) over the height, within a bracket that is halved where three steps of
the secant do not halve it. Without contact the wheel comes down by the distance between the profiles, which it cannot
pass, and by the approach that a sphere of the wheel's radius needs.

The strip model starts cold at the first height with contact and from there on from the last contact. What two grids
share may have two solutions: there the contact returned is a cold one. Where this does not lead to the load, the search
begins anew with cold starts alone. No pose knows of another one.
"""

from math import inf

from wrsim.contact.arrays import Arrays, call_of, results
from wrsim.contact.records import (
    COLD_START,
    CONTACT,
    FREE_STRIPS,
    FROM_LAST,
    LOBE,
    MODEL,
    POSES,
    STATE,
    STATUS_DISCONTINUOUS,
    STATUS_LOAD_UNSOLVED,
    STATUS_NO_CONTACT,
    STATUS_NOT_CONVERGED,
    STATUS_OUT_OF_REACH,
    TOTAL,
)
from wrsim.contact.strips.records import MEMO
from wrsim.jit import (
    Array,
    Ints,
    Record,
    Records,
    inlined,
    kernel,
    matrix,
    parallel,
    prange,
    record,
    record_rows,
    records,
    stages,
    vector,
)
from wrsim.jit.dense import copy

SEARCH = record("""
    load        [N]     vertical force; 0 for the contact at the height as it is, below 0 for nothing at all
    tolerance   [1]     of the load
    farthest    [m]     largest distance from the first height with contact
    scale       [m]     approach to begin with
    start       [m]     height of the first contact asked for
    height      [m]     height of the next contact, or of the last one
    first       [m]     first height with contact
    rate        [N^(2/3)/m] of force^(2/3) with the height
    last_height [m]     last height
    last_excess [N^(2/3)] excess of force^(2/3) there
    low         [m]     height with too much force
    high        [m]     height with too little force
    width       [m]     their distance three steps ago
    angle       [rad]   by which a wheel out of round has rolled, of many poses
    low_excess  [N^(2/3)] excess at ``low``
    high_excess [N^(2/3)] excess at ``high``
    asked       [int]   contacts asked for
    touched     [int]   whether any one touched
    bracketed   [int]   steps within the bracket
    residuals   [int]   residuals that the strip model took
""")
"""A search for the height at which a wheel carries a load."""

SEARCHING, REACHED = -1, 0
"""Outcomes of a step of the search besides the STATUS bits of a load that is not reached."""

NOISE = 1e-4  # of the load's 2/3 power: a difference of two forces that gives the rate to a thousandth of it
IDLE = 0.1  # of the excess: a step that takes less of it, within the noise, was far too short; the next one is twice it
STEEPEST = 100.0  # slope of force^(2/3) within the bracket over Hertz's, force^(2/3) over approach: beyond it is a jump
MOST_RESIDUALS = 1200  # of the strip model at a load: fifty times the median of random poses, 24
HIGHEST = 0.1  # above its rail, from where a wheel is let down [m]
CLOSEST = 1e-6  # distance of profiles that do not touch, at least [m]

BATCH = 4  # arrays in a workspace before those of the contact: poses, searches, and of each TOTAL and LOBE records
_MODEL, _POSE, _STATE, _PATCHES, _MEMO = (
    Arrays._fields.index(name) for name in ("model", "pose", "state", "patches", "memo")
)
_HELD = len(Arrays._fields)


@inlined
def _power(force: float) -> float:
    """force^(2/3) with the force's sign."""
    return abs(force) ** (2.0 / 3.0) if force > 0.0 else -(abs(force) ** (2.0 / 3.0))


@kernel
def begin_search(s: Record) -> None:
    """Begin, or begin anew, at the height ``s.start``."""
    s.height, s.first = s.start, s.start
    s.rate = s.last_height = s.last_excess = 0.0
    s.asked = s.touched = 0
    _open(s)


@inlined
def _open(s: Record) -> None:
    """Forget the bracket."""
    s.low, s.high, s.width = -inf, inf, inf
    s.bracketed = 0


@kernel
def next_height(s: Record, force: float, approach: float, tolerance: float) -> int:
    """One step: vertical force [N] and largest approach [m] at ``s.height``; without contact the approach is less than
    zero by the distance of the profiles. Returns SEARCHING with another ``s.height``; REACHED; or a STATUS bit."""
    target = _power(s.load)
    excess = _power(force) - target
    touches = approach > 0.0
    s.asked += 1
    if touches and abs(force / s.load - 1.0) <= tolerance:
        return REACHED
    if excess < 0.0 and s.height < s.high:
        s.high, s.high_excess = s.height, excess
    elif excess >= 0.0 and s.height > s.low:
        s.low, s.low_excess = s.height, excess
    if touches and s.touched == 0:
        s.first = s.height
    change = excess - s.last_excess
    if touches and s.rate == 0.0:
        s.rate = -max((excess + target) / max(approach, 1e-12), 0.1 * target / max(approach, s.scale))
    elif touches and abs(change) <= min(NOISE * target, IDLE * abs(s.last_excess)):
        s.rate *= 0.5
    elif touches and change * (s.height - s.last_height) < 0.0:
        s.rate = change / (s.height - s.last_height)
    if touches:
        s.touched, s.last_height, s.last_excess = 1, s.height, excess
    new = s.height + approach - s.scale
    if touches:
        most = max(approach, s.scale)
        new = s.height + min(max(-excess / s.rate, -most), most)
    if s.low > -inf and s.high < inf:
        middle = 0.5 * (s.low + s.high)
        most_change = STEEPEST * (excess + target) / max(approach, CLOSEST) * (s.high - s.low)
        if not s.low < middle < s.high or (touches and s.low_excess - s.high_excess > most_change):
            return STATUS_DISCONTINUOUS
        slow = s.bracketed % 3 == 2 and s.high - s.low > 0.5 * s.width
        if s.bracketed % 3 == 0:
            s.width = s.high - s.low
        s.bracketed += 1
        if slow or not s.low < new < s.high:
            new = middle
    if s.touched == 0 and not s.start - new <= HIGHEST:
        return STATUS_NO_CONTACT
    if s.touched != 0 and not abs(new - s.first) <= s.farthest:
        return STATUS_OUT_OF_REACH
    s.height = new
    return SEARCHING


@kernel
def approach_of(lobes: Records, total: Record) -> float:
    """Largest approach of a contact, without one the distance of the profiles, less than 0 [m]."""
    if total.lobes == 0:
        return -max(total.closest, CLOSEST)
    approach = 0.0
    for i in range(total.lobes):
        approach = max(approach, lobes[i].approach)
    return approach


@inlined
def _search(buffer: Array, index: Ints, s: Record) -> int:
    """Search; the workspace then holds the contact asked for last. Returns REACHED or STATUS bits.
    The load is unsolved where the strip model takes more than MOST_RESIDUALS in all contacts together."""
    contact_index = index[index.shape[0] - _HELD :]
    pose, lobes, total = (
        vector(buffer, contact_index, _POSE),
        records(buffer, contact_index, _PATCHES, LOBE),
        results(buffer, contact_index)[0],
    )
    memo = records(buffer, contact_index, _MEMO, MEMO)[0]
    outcome = SEARCHING
    while outcome == SEARCHING:
        pose[2] = s.height
        stages.run(CONTACT, buffer, contact_index)
        s.residuals += 0 if total.lobes == 0 else memo.iterations
        if total.status & STATUS_NOT_CONVERGED != 0:
            return STATUS_NOT_CONVERGED
        if s.residuals > MOST_RESIDUALS:  # type: ignore[operator]
            return STATUS_LOAD_UNSOLVED
        outcome = next_height(s, total.Fb, approach_of(lobes, total), s.tolerance)
    return outcome


@kernel
def meet_load(buffer: Array, index: Ints, s: Record) -> int:
    """Contact of one wheel at the height at which its vertical force is the load, from ``s.start`` on; all but the
    height is set in the workspace. Returns the status of the contact, and why the load is not met, if so; also written
    to the TOTAL record. With STATE.start = FROM_LAST the first guess is the contact of the last call."""
    contact_index = index[index.shape[0] - _HELD :]
    state, memo = records(buffer, contact_index, _STATE, STATE)[0], records(buffer, contact_index, _MEMO, MEMO)[0]
    start = state.start
    outcome, s.residuals = SEARCHING, 0
    begin_search(s)
    if records(buffer, contact_index, _MODEL, MODEL)[0].normal == FREE_STRIPS:
        if start == COLD_START:
            memo.grids_before = 0
        state.start = FROM_LAST
        outcome = _search(buffer, contact_index, s)
        if outcome == REACHED and memo.grids > 1:
            state.start = COLD_START
            _open(s)
            outcome = _search(buffer, contact_index, s)
        if outcome != REACHED and s.residuals <= MOST_RESIDUALS:  # type: ignore[operator]
            begin_search(s)
            outcome = SEARCHING
    state.start = COLD_START
    if outcome == SEARCHING:
        outcome = _search(buffer, contact_index, s)
    state.start = start
    total = results(buffer, contact_index)[0]
    total.status |= outcome
    return total.status


@kernel
def contact_at_load(buffer: Array, index: Ints) -> int:
    """A stage: `meet_load` of the SEARCH record that stands before the contact in a workspace."""
    return meet_load(buffer, index, records(buffer, index, index.shape[0] - _HELD - 1, SEARCH)[0])


@kernel
def some_poses(buffer: Array, index: Ints) -> int:
    """A stage: contacts at the poses of a workspace, each at its load. Returns 0."""
    contact_index = index[index.shape[0] - _HELD :]
    first = index.shape[0] - _HELD - BATCH
    poses, searches = matrix(buffer, index, first), records(buffer, index, first + 1, SEARCH)
    totals, lobes = records(buffer, index, first + 2, TOTAL), record_rows(buffer, index, first + 3, LOBE)
    pose, lobes_of_pose, total = (
        vector(buffer, contact_index, _POSE),
        records(buffer, contact_index, _PATCHES, LOBE),
        results(buffer, contact_index),
    )
    call, state = call_of(buffer, contact_index), records(buffer, contact_index, _STATE, STATE)[0]
    state.start = COLD_START
    for i in range(poses.shape[0]):
        s = searches[i]
        if s.load < 0.0:
            continue
        copy(pose.shape[0], poses[i], pose)
        call.wheel_angle = s.angle
        if s.load > 0.0:
            meet_load(buffer, contact_index, s)
            poses[i, 2] = pose[2]
        else:
            stages.run(CONTACT, buffer, contact_index)
        totals[i] = total[0]
        for k in range(total[0].lobes):
            lobes[i, k] = lobes_of_pose[k]
    return 0


@parallel
def side_by_side(buffers: Array, index: Ints) -> None:
    """`some_poses` of every row of buffers (threads, size), on as many threads as numba is set to use."""
    for k in prange(buffers.shape[0]):
        stages.run(POSES, buffers[k], index)
