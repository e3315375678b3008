"""What one wheel on one rail computes in: arrays in a workspace (jit.arena), and the first look at them."""

from typing import Any, NamedTuple

from wrsim.contact.records import FOUND, LOBE, SETTINGS, STRIP, TOTAL
from wrsim.contact.strips.records import GRID, MEMO, PLACE, ROW
from wrsim.jit import Array, Ints, Record, Records, block, inlined, kernel, matrix, record_rows, records, vector


class Arrays(NamedTuple):
    """Arrays of one wheel on one rail, in the order of the workspace.

    wheel, rail: profile tables, the rail's in (o, b) with its inclination, of one that changes along the track station
    by station; rates: of these along s; stations: (4, n) their places, numbers of their fields, sines of the rail's own
    axes and the rates of these, (2, 1) for a rail of one profile; field: signed distances of the rail, one grid behind
    the other; creep: (ASPECTS, 3) Kalker coefficients; shape: (cells,) bound over the cells; settings: (1,) SETTINGS;
    pose: (POSE,). found: (8,) FOUND, work: (14, >= strips, >= 8): scratch; influence to memo: of the strip model
    (contact.strips.records); friction: (rows, 7) along the rail (contact.creep.friction), no rows where
    it is the same everywhere; depth, branches: of a wheel out of round (contact.records.Shape), no rows for a
    round one. Results: patches: (lobes,) LOBE; strips: (lobes, n) STRIP; total: (1,) TOTAL.
    """

    wheel: Any
    rail: Any
    rates: Any
    stations: Any
    field: Any
    creep: Any
    shape: Any
    settings: Any
    pose: Any
    found: Any
    patches: Any
    strips: Any
    work: Any
    influence: Any
    rows: Any
    places: Any
    grids: Any
    vectors: Any
    matrix: Any
    memo: Any
    friction: Any
    depth: Any
    branches: Any
    total: Any


ARRAYS = len(Arrays._fields)
TABLES = tuple(
    Arrays._fields.index(name)
    for name in ("wheel", "rail", "rates", "stations", "field", "creep", "shape", "influence", "friction", "depth")
)
"""Arrays that kernels only read."""
SETTINGS_PLACE = Arrays._fields.index("settings")


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
        records(buffer, index, first + 7, SETTINGS),
        vector(buffer, index, first + 8),
        records(buffer, index, first + 9, FOUND),
        records(buffer, index, first + 10, LOBE),
        record_rows(buffer, index, first + 11, STRIP),
        matrix(buffer, index, first + 12),
        matrix(buffer, index, first + 13),
        record_rows(buffer, index, first + 14, ROW),
        records(buffer, index, first + 15, PLACE),
        records(buffer, index, first + 16, GRID),
        matrix(buffer, index, first + 17),
        matrix(buffer, index, first + 18),
        records(buffer, index, first + 19, MEMO),
        matrix(buffer, index, first + 20),
        matrix(buffer, index, first + 21),
        matrix(buffer, index, first + 22),
        records(buffer, index, first + 23, TOTAL),
    )


@inlined
def results(buffer: Array, index: Ints) -> Records:
    """The TOTAL record in a workspace of one wheel, as an array (1,)."""
    return records(buffer, index, index.shape[0] - 1, TOTAL)


@inlined
def settings_of(buffer: Array, index: Ints) -> Record:
    """The SETTINGS record in a workspace of one wheel."""
    return records(buffer, index, index.shape[0] - ARRAYS + SETTINGS_PLACE, SETTINGS)[0]
