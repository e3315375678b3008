"""Differences of a vehicle's forces for changes of its state, several coordinates at once.

Coordinates of one group act on rows of their own, so they are changed together (Curtis, Powell and Reid, J. Inst. Math.
Appl. 13 (1974) 117).
"""

from typing import Any

from wrsim.jit.arena import Array, Ints
from wrsim.jit.compiling import kernel
from wrsim.vehicle.dynamics.vehicle_forces import add_forces_on_bodies, add_forces_on_wheels

HERE, HERE_RATE, STATE, RATE, MORE, MORE_RATE, SPAN, UP, DOWN = range(9)
"""Rows (size,) to compute with: the state and its rates, those that are changed, by how much, over how much of a
coordinate the difference is taken; forces."""
ROWS = 9

ON_BODIES, ON_WHEELS = 0, 1
"""Parts of a vehicle's forces: everything but the contacts, and the contacts."""


@kernel
def add_differences(
    t: float, part: int, central: bool, columns: Ints, rows: Any, work: Array, matrix: Array, buffer: Array, index: Ints
) -> int:
    """Add the derivative of a part of the forces to the matrix (size, size), by central or forward differences.

    columns (groups, n): coordinates that are changed at once, behind them -1; rows (groups, n, m): what each of them
    acts on, behind that the first of them again. Returns a status.
    """
    up, down = work[UP], work[DOWN]
    status = 0
    if not central:
        status |= _forces(part, t, work, down, buffer, index)
    for g in range(columns.shape[0]):
        _change(1.0, columns[g], work)
        status |= _forces(part, t, work, up, buffer, index)
        if central:
            _change(-1.0, columns[g], work)
            status |= _forces(part, t, work, down, buffer, index)
        _change(0.0, columns[g], work)
        for j in range(columns.shape[1]):
            c = columns[g, j]
            for i in range(rows.shape[2] if c >= 0 else 0):
                r = rows[g, j, i]
                if i == 0 or r != rows[g, j, 0]:
                    matrix[r, c] += (up[r] - down[r]) / work[SPAN, c]
    return status


@kernel
def _change(by: float, columns: Ints, work: Array) -> None:
    """Put these coordinates so many changes away from the state."""
    for c in columns:
        if c >= 0:
            work[STATE, c] = work[HERE, c] + by * work[MORE, c]
            work[RATE, c] = work[HERE_RATE, c] + by * work[MORE_RATE, c]


@kernel
def _forces(part: int, t: float, work: Array, out: Array, buffer: Array, index: Ints) -> int:
    """This part of the forces at the changed state; a status."""
    out[:] = 0.0
    if part == ON_WHEELS:
        add_forces_on_wheels(work[STATE], work[RATE], out, buffer, index)  # a contact that is lost carries nothing
        return 0
    return add_forces_on_bodies(t, work[STATE], work[RATE], out, buffer, index)
