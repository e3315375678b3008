"""What one wheel on one rail computes in: arrays in a workspace (jit.arena), and the first look at them."""

from typing import Any, NamedTuple

from wrsim.contact.records import CALL, LOBE, MAIN_POINT, MODEL, STATE, STRIP, TOTAL
from wrsim.contact.strips.records import GRID, MEMO, PLACE, ROW
from wrsim.jit import Array, Ints, Record, Records, block, inlined, kernel, matrix, record_rows, records, vector


class Arrays(NamedTuple):
    """Arrays of one wheel on one rail, in the order of the workspace.

    Those of a rail that changes along the track have its stations one behind the other; a rail of one profile is one
    station.
    """

    wheel: Any  # (n, 5) table of the profile (contact.surfaces.profile_table)
    rail: Any  # the same of the rail in (o, b), with its inclination
    rates: Any  # of the rail's table along s; (0, 0) for one profile
    stations: Any  # (4, n): place, number of the field, sine of the rail's axes and its rate; (2, 1) for one profile
    field: Any  # signed distances of the rail, see contact.search.points
    creep: Any  # (ASPECTS, 3) Kalker's coefficients
    shape: Any  # (cells,) traction bound over the cells of a strip
    model: Any  # (1,) MODEL
    call: Any  # (1,) CALL
    pose: Any  # (POSE,)
    state: Any  # (1,) STATE
    contacts: Any  # (8,) MAIN_POINT: of the search
    patches: Any  # (lobes,) LOBE: result
    strips: Any  # (lobes, n) STRIP: result
    work: Any  # (SCRATCH, >= strips, >= 8) scratch; with lobes * cells rows more for tractions over their bound, and
    # twice as many behind them for the tractions themselves
    influence: Any  # table of the strip model (contact.strips.influence)
    rows: Any  # (grids, ROWS) ROW of the strip model
    places: Any  # (grids * n,) PLACE of the strip model
    grids: Any  # (grids,) GRID of the strip model
    vectors: Any  # (VECTORS, unknowns) of the strip model
    matrix: Any  # (unknowns, unknowns) of the strip model
    memo: Any  # (1,) MEMO of the strip model
    friction: Any  # (rows, 7) along the rail (contact.creep.friction); no rows where it is the same everywhere
    depth: Any  # of a wheel out of round (Shape); no rows for a round one
    branches: Any  # (n, 4) of a wheel out of round
    total: Any  # (1,) TOTAL: result


ARRAYS = len(Arrays._fields)
SCRATCH = 14  # rows of ``work`` that kernels need
READ_ONLY = {"wheel", "rail", "rates", "stations", "field", "creep", "shape", "model", "influence", "friction", "depth"}
TABLES = tuple(i for i, name in enumerate(Arrays._fields) if name in READ_ONLY)
"""Arrays that kernels only read."""
_CALL = Arrays._fields.index("call")


@kernel
def arrays(buffer: Array, index: Ints) -> Arrays:
    """The arrays in a workspace of one wheel."""
    first = index.shape[0] - ARRAYS  # 0; written as a literal, every helper would be compiled anew for each number
    return Arrays(
        matrix(buffer, index, first),
        matrix(buffer, index, first + 1),
        matrix(buffer, index, first + 2),
        matrix(buffer, index, first + 3),
        block(buffer, index, first + 4),
        matrix(buffer, index, first + 5),
        vector(buffer, index, first + 6),
        records(buffer, index, first + 7, MODEL),
        records(buffer, index, first + 8, CALL),
        vector(buffer, index, first + 9),
        records(buffer, index, first + 10, STATE),
        records(buffer, index, first + 11, MAIN_POINT),
        records(buffer, index, first + 12, LOBE),
        record_rows(buffer, index, first + 13, STRIP),
        matrix(buffer, index, first + 14),
        matrix(buffer, index, first + 15),
        record_rows(buffer, index, first + 16, ROW),
        records(buffer, index, first + 17, PLACE),
        records(buffer, index, first + 18, GRID),
        matrix(buffer, index, first + 19),
        matrix(buffer, index, first + 20),
        records(buffer, index, first + 21, MEMO),
        matrix(buffer, index, first + 22),
        matrix(buffer, index, first + 23),
        matrix(buffer, index, first + 24),
        records(buffer, index, first + 25, TOTAL),
    )


@inlined
def results(buffer: Array, index: Ints) -> Records:
    """The TOTAL record in a workspace of one wheel, as an array (1,)."""
    return records(buffer, index, index.shape[0] - 1, TOTAL)


@inlined
def call_of(buffer: Array, index: Ints) -> Record:
    """The CALL record in a workspace of one wheel."""
    return records(buffer, index, index.shape[0] - ARRAYS + _CALL, CALL)[0]
