"""The data of one wheel on one rail: records that kernels write in place, tuples that they pass on.

Everything is in rail axes (t, o, b): along the rail, outward, up; origin at the rail's profile origin beside the
wheel. A ``Vec`` in these axes has its components in that order.
"""

from typing import Any, NamedTuple

from wrsim.jit import Array, inlined, record
from wrsim.jit.frames import vec_at
from wrsim.jit.linalg import Vec

SETTINGS = record(
    "E G eps recess damping kA kS strip_width least_speed mu mu_gauge zone_start zone_end fall_ratio fall_decay"
    " wheel_step radius rail_step field_o field_b field_spacing hollow together apart tolerance place twist bow_o bow_b"
    " sine about slack wheel_angle averaged depth_first depth_step depth_least"
    " slope_k0 slope_alpha_inf slope_beta",
    "tangential parabolic blended stride normal projected joint strips fewest start rows station field_rows curved"
    " depth_rows",
)
"""Numbers of a contact model.

E, G: of the pair of bodies [Pa]; eps: Kik-Piotrowski's [1]; recess: of the depth, where strips begin [1]; damping
[s/m]; kA, kS: Polach's [1]; strip_width: 0 where their number rules [m]; least_speed [m/s].
slope_k0, slope_alpha_inf, slope_beta: of the slope reduction of FASTSIM and FaStrip [1].
mu, mu_gauge: friction on the top and on the gauge corner [1]; zone_start, zone_end: tangents of half the angles of the
ramp between them; fall_ratio, fall_decay: of its fall with the slip [1, s/m].
wheel_step, rail_step: of the tables [m]; radius: of the wheel [m]; field_o, field_b, field_spacing: grid of the rail's
distances [m]; slack: how far these may be off [m]; hollow: largest hollows of both bodies [1/m]; together, apart:
distances of two places of contact that press each other down fully, and not at all [m], tolerance: of a contact that
starts from the last one, of the deepest penetration [1] (strip model).
place: distance along the rail [m]; twist, bow_o, bow_b: how it turns [rad/m] and bends [1/m] there; sine: of the angle
in plan by which it runs outward, about a point at the distance ``about`` from the place [m].
wheel_angle: by which a wheel out of round has rolled [rad]; averaged: half length over which its curvature along the
rail is a mean [m]; depth_first, depth_step: of the columns of its depth [m]; depth_least: of all [m]; depth_rows:
around the wheel.
tangential, normal, start: see below; projected, parabolic, blended: 0 or 1; joint: whether lobes of a patch share
recess and strips; stride: nodes between two samples of the search; strips, fewest: their number on a lobe; rows: of a
section of the rail; station: its last one; field_rows: of the distances of a section; curved: whether the
influence of strips is turned with their normals.
"""

NO_CREEP_FORCES, FASTSIM, FASTRIP, POLACH, LINEAR, SHEN_HEDRICK_ELKINS = range(6)
"""SETTINGS.tangential."""

KIK_PIOTROWSKI, FREE_STRIPS, CREEP_FORCES, CONTACT = range(4)
"""Stages (contact.wheel_rail). The first two are SETTINGS.normal; `wrsim.contact.models` lists the models."""
POSES = 7
"""Stage of many poses (contact.prescribed_load), behind those of a vehicle (dynamics.wheel_forces)."""

COLD_START, FROM_LAST = range(2)
"""SETTINGS.start of the strip model: cold, or from the last contact."""

FOUND = record("""
    arc_wheel   [m]    arclength on the wheel
    arc_rail    [m]    arclength on the rail
    depth       [m]    penetration
    curvature   [1/m]  relative curvature across
    saddle      [m]    least penetration between this contact and the next; -1 where the profiles separate in between
    saddle_arc  [m]    rail arclength of that place
""")
"""A contact that the search found."""

STRIP = record("s ds x a p no nb slope o b N Fx Fy Mz xi eta phi r_t mu penetration")
"""A strip: centre s and width ds across, middle x and half length a along the rail [m], largest pressure p [Pa]; unit
normal (no, nb) from rail to wheel, slope of the rail along the track there, and centre (o, b) [m]; normal force, creep
forces [N], moment about the centre [N m]; creepages [1], spin [1/m]; radius of curvature along the rail [m];
coefficient of friction; penetration [m]."""

LOBE = record(
    "N Fx Fy Mz p0 area length width approach angle angle_min angle_max angle_mean xi eta phi closing wear"
    " arc_wheel arc_rail x o b no nb slope start end recess half_length coupling amplitude",
    "group partner n_strips",
)
"""A lobe of a patch. Forces on the wheel [N], Mz about the main point [N m]; largest pressure [Pa], area [m2], length,
width and approach [m]; contact angles [rad]; creepages [1], spin [1/m], rate of approach [m/s]; wear: what creep
dissipates [N].
The main point: arclengths, place (x, o, b) [m], normal (no, nb), slope along the track. Edges along s and the recess
that the strips are laid over, half length at the main point [m]; coupling to ``partner`` [1], amplitude p / a of the
pressure [Pa/m]. Number of the patch, lobe that this one is coupled to or -1, number of strips."""

TOTAL = record("Ft Fo Fb Mt Mo Mb wear closest", "lobes patches status")
"""Force [N] and moment [N m] on the wheel about its profile origin, wear number [N], closest distance [m]; numbers of
lobes and of patches (lobes that share a patch count once); sum of the STATUS bits."""

STATUS_NOT_REFINED = 1  # a main point was not found to round-off
STATUS_PROFILE_END = 2  # contact reaches the end of a profile
STATUS_TOO_DEEP = 4  # an overlap, not a contact
STATUS_NOT_CONVERGED = 8  # the strip model was not solved, a substitute is used
STATUS_BESIDE, STATUS_OUT_OF_REACH, STATUS_IN_A_JUMP, STATUS_LOAD_UNSOLVED = 16, 32, 512, 2048
"""Of a prescribed load: no contact at any height; it is not met within the approach allowed; the force jumps over it;
the strip model does not meet it in the residuals allowed.
`wrsim.contact.status` has the text of each, and every analysis reports it."""


class WheelPose(NamedTuple):
    """A wheel: its profile origin on the axle, the axle (a unit vector outward), velocity of that origin, rotation."""

    origin: Vec
    axle: Vec
    velocity: Vec
    omega: Vec


POSE = 12
"""Numbers of a pose in an array, in this order."""


@inlined
def read_pose(row: Array) -> WheelPose:
    """The pose in a row of 12 numbers."""
    return WheelPose(vec_at(row, 0), vec_at(row, 3), vec_at(row, 6), vec_at(row, 9))


class ProfileTable(NamedTuple):
    """A profile: its table (n, 5), see ``contact.surfaces.profile_table``, and the arclength between rows [m]."""

    table: Any
    step: float


class Share(NamedTuple):
    """Between two stations of a rail: number of the first, first rows of both, weights of their values and rates."""

    at: int
    low: int
    high: int
    a: float
    b: float
    c: float
    d: float


class Rail(NamedTuple):
    """A rail: one profile, or sections that change along the track (`wrsim.contact.surfaces.rolled_rail`).

    table: (stations * rows, 5 or 8); rates: of the same shape, (0, 0) for one profile; stations: their places (n,);
    step: arclength between rows [m]; rows: of one section; share: between which stations the wheel is; place:
    distance along the rail about which its own axes are turned in plan; sine: of that angle; beside: how far ahead of
    it the axle is [m]; twist: how the section turns along it, positive where its outer side rises [rad/m]; bow_o,
    bow_b: curvature of the rail outward and up [1/m]; yaw: axle's component along the rail; o, radius: of the wheel.
    """

    table: Any
    rates: Any
    stations: Any
    step: float
    rows: int
    share: Share
    place: float
    sine: float
    beside: float
    twist: float
    bow_o: float
    bow_b: float
    yaw: float
    o: float
    radius: float


class Shape(NamedTuple):
    """How a wheel is out of round, see ``contact.surfaces.wheel_shape``.

    depth: (columns * rows, 4) of values, rates over a row and a column, and of both, no rows for a round wheel;
    branches: (n, 4); rows: around; first, step: first column and distance of columns [m]; least: depth [m]; angle: by
    which it has rolled [rad]; averaged: half length of contact [m]."""

    depth: Any
    branches: Any
    rows: int
    first: float
    step: float
    least: float
    angle: float
    averaged: float


class PlacedWheel(NamedTuple):
    """A wheel in its place: radius at the tape circle, profile origin on the axle, axle e, q = sqrt(1 - e_t^2); lean:
    e_t of a round wheel, 0 of one out of round."""

    profile: ProfileTable
    radius: float
    origin: Vec
    axle: Vec
    q: float
    lean: float
    shape: Shape


class Field(NamedTuple):
    """Signed distances of a rail, see ``contact.search.points``, on a square grid from (o, b): so many ``rows`` of
    ``values`` (n, n_b, 2) from ``first`` on. slack: how far it may be off; 0 for a rail of one profile."""

    values: Any
    first: int
    rows: int
    o: float
    b: float
    spacing: float
    slack: float
