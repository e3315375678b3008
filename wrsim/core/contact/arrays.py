"""What one wheel on one rail computes in: arrays in an arena (core.arena), and the first look at them."""

from typing import Any, NamedTuple

from wrsim.core.arena import block, matrix, record_rows, records, vector
from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.records import FOUND, LOBE, SETTINGS, STRIP, TOTAL, Profile, read_pose
from wrsim.core.contact.search.locus import placed
from wrsim.core.contact.strips.records import GRID, MEMO, PLACE, ROW


class Arrays(NamedTuple):
    """Arrays of one wheel on one rail, in the order of the arena.

    wheel, rail: profile tables, the rail's in (o, b) with its inclination; field: signed distances of the rail; creep:
    (20, 3) Kalker coefficients; shape: (cells,) bound over the cells; settings: (1,) SETTINGS; pose: (POSE,).
    found: (8,) FOUND, work: (12, >= strips, >= 8): scratch; influence to memo: of the strip model
    (core.contact.strips.records). Results: patches: (lobes,) LOBE; strips: (lobes, n) STRIP; total: (1,) TOTAL.
    """

    wheel: Any
    rail: Any
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
    total: Any


ARRAYS = len(Arrays._fields)


@kernel
def arrays(buffer, index):
    """The arrays in an arena of one wheel."""
    first = index.shape[0] - ARRAYS  # 0; written as a literal, every helper would be compiled anew for each number
    return Arrays(
        matrix(buffer, index, first),
        matrix(buffer, index, first + 1),
        block(buffer, index, first + 2),
        matrix(buffer, index, first + 3),
        vector(buffer, index, first + 4),
        records(buffer, index, first + 5, SETTINGS),
        vector(buffer, index, first + 6),
        records(buffer, index, first + 7, FOUND),
        records(buffer, index, first + 8, LOBE),
        record_rows(buffer, index, first + 9, STRIP),
        matrix(buffer, index, first + 10),
        matrix(buffer, index, first + 11),
        record_rows(buffer, index, first + 12, ROW),
        records(buffer, index, first + 13, PLACE),
        records(buffer, index, first + 14, GRID),
        matrix(buffer, index, first + 15),
        matrix(buffer, index, first + 16),
        records(buffer, index, first + 17, MEMO),
        records(buffer, index, first + 18, TOTAL),
    )


@inlined
def results(buffer, index):
    """The TOTAL record in an arena of one wheel, as an array (1,)."""
    return records(buffer, index, index.shape[0] - 1, TOTAL)


@kernel
def bodies(a):
    """The wheel in its place, the rail's profile, and the pose."""
    settings, pose = a.settings[0], read_pose(a.pose)
    wheel = placed(Profile(a.wheel, settings.wheel_step), settings.radius, pose)
    return wheel, Profile(a.rail, settings.rail_step), pose
