"""Forces on a vehicle at many states in the order of time, while other threads of Python go on."""

from wrsim.jit import Array, Ints, released
from wrsim.vehicle.dynamics.vehicle_forces import vehicle_forces
from wrsim.vehicle.dynamics.wheel_forces import OFF_TRACK


@released
def forces_in_turn(
    times: Array, q: Array, q_t: Array, seeds: Ints, starts: Array, kept: Ints, forces: Array, rows: Array,
    buffer: Array, index: Ints,
) -> int:  # fmt: skip
    """Generalised forces (n, .) at times (n,) and states (n, .), each from the contacts of the one before, and what
    these left in the workspace: the numbers (n, m) in the places ``kept`` (m,) of the buffer.

    seeds (k,): places of distances at which searches on the track begin; starts (n, k): these [m]. Returns how many
    states come before the first one that has no place on the track.
    """
    for i in range(times.size):
        for j in range(seeds.size):
            buffer[seeds[j]] = starts[i, j]
        if vehicle_forces(times[i], q[i], q_t[i], forces[i], buffer, index) & OFF_TRACK:
            return i
        for j in range(kept.size):
            rows[i, j] = buffer[kept[j]]
    return times.size
