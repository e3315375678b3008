"""What one wheel on one rail computes in: arrays in an arena (core.jit.arena), and the first look at them."""

from typing import Any, NamedTuple

from wrsim.core.contact.rail import share_at
from wrsim.core.contact.records import (
    FOUND,
    LOBE,
    SETTINGS,
    STRIP,
    TOTAL,
    PlacedWheel,
    ProfileTable,
    Rail,
    Share,
    WheelPose,
    read_pose,
)
from wrsim.core.contact.search.locus import placed
from wrsim.core.contact.strips.records import GRID, MEMO, PLACE, ROW
from wrsim.core.contact.tangential.friction import set_law
from wrsim.core.jit.arena import Array, Ints, Record, Records, block, matrix, record_rows, records, vector
from wrsim.core.jit.compiling import inlined, kernel


class Arrays(NamedTuple):
    """Arrays of one wheel on one rail, in the order of the arena.

    wheel, rail: profile tables, the rail's in (o, b) with its inclination, of one that changes along the track station
    by station; rates: of these along s; stations: (2, n) their places and the numbers of their fields, one for a rail
    of one profile; field: signed distances of the rail, one grid behind the other; creep:
    (20, 3) Kalker coefficients; shape: (cells,) bound over the cells; settings: (1,) SETTINGS; pose: (POSE,).
    found: (8,) FOUND, work: (12, >= strips, >= 8): scratch; influence to memo: of the strip model
    (core.contact.strips.records); friction: (rows, 7) along the rail (core.contact.tangential.friction), no rows where
    it is the same everywhere. Results: patches: (lobes,) LOBE; strips: (lobes, n) STRIP; total: (1,) TOTAL.
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
    total: Any


ARRAYS = len(Arrays._fields)
TABLES = tuple(
    Arrays._fields.index(name)
    for name in ("wheel", "rail", "rates", "stations", "field", "creep", "shape", "influence", "friction")
)
"""Arrays that kernels only read."""
SETTINGS_PLACE = Arrays._fields.index("settings")


@kernel
def arrays(buffer: Array, index: Ints) -> Arrays:
    """The arrays in an arena of one wheel."""
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
        records(buffer, index, first + 21, TOTAL),
    )


@inlined
def results(buffer: Array, index: Ints) -> Records:
    """The TOTAL record in an arena of one wheel, as an array (1,)."""
    return records(buffer, index, index.shape[0] - 1, TOTAL)


@inlined
def settings_of(buffer: Array, index: Ints) -> Record:
    """The SETTINGS record in an arena of one wheel."""
    return records(buffer, index, index.shape[0] - ARRAYS + SETTINGS_PLACE, SETTINGS)[0]


@kernel
def bodies(a: Arrays) -> tuple[PlacedWheel, Rail, WheelPose]:
    """The wheel in its place, the rail there, and the pose."""
    settings, pose = a.settings[0], read_pose(a.pose)
    wheel = placed(ProfileTable(a.wheel, settings.wheel_step), settings.radius, pose)
    place = settings.place + pose.origin.x
    if a.friction.shape[0] > 0:
        set_law(a.friction, place, settings)
    share = Share(0, 0, 0, 1.0, 0.0, 0.0, 0.0)
    if a.rates.shape[0] > 0:
        share = share_at(a.stations[0], settings.rows, place, settings.station)
        settings.station = share.at
    rail = Rail(
        a.rail, a.rates, a.stations[0], settings.rail_step, settings.rows, share, place, settings.twist, settings.bow_o,
        settings.bow_b, pose.axle.x, pose.origin.y, settings.radius,
    )  # fmt: skip
    return wheel, rail, pose
