"""The data of one wheel on one rail: records that kernels write in place, tuples that they pass on.

Everything is in rail axes (t, o, b): along the rail, outward, up; origin at the rail's profile origin beside the
wheel. A ``Vec`` in these axes has its components in that order.
"""

from typing import Any, NamedTuple

from wrsim.jit import Array, inlined, record
from wrsim.jit.frames import vec_at
from wrsim.jit.linalg import Vec

MODEL = record("""
    E            [Pa]   combined modulus E* of the pair of bodies
    G            [Pa]   shear modulus of the pair: inverse of the mean compliance
    eps          [1]    share of the approach that the virtual penetration has (Kik-Piotrowski)
    recess       [1]    share of the depth at which strips begin
    damping      [s/m]  of the normal force, over the rate of approach
    kA           [1]    reduction of the initial slope in adhesion (Polach)
    kS           [1]    reduction of the initial slope in slip (Polach)
    strip_width  [m]    width of strips; 0 where their number rules
    least_speed  [m/s]  rolling speed below which creepages are regularised
    wheel_step   [m]    arclength between rows of the wheel's table
    radius       [m]    of the wheel at the tape circle
    roller       [1/m]  inverse of the radius of a roller, at its profile's origin; 0 for a rail
    rail_step    [m]    arclength between rows of the rail's table
    field_o      [m]    outward coordinate at which the rail's distances begin
    field_b      [m]    height at which the rail's distances begin
    field_spacing [m]   grid of the rail's distances
    hollow       [1/m]  largest hollows of both bodies
    together     [m]    distance up to which contacts press each other down fully
    apart        [m]    distance from which on contacts do not act on each other
    slack        [m]    how far the rail's distances may be off
    depth_first  [m]    first column of the depth of a wheel out of round
    depth_step   [m]    distance of these columns
    depth_least  [m]    least depth
    slope_k0     [1]    initial slope reduction of FASTSIM and FaStrip
    slope_alpha_inf [1] slope reduction at large creepages, over the initial one
    slope_beta   [1]    decay of the slope reduction
    layer        [m/Pa] shear of a layer between the bodies over the traction
    yield_stress [Pa]   of that layer, inf where it does not yield
    hardening    [Pa/m] rise of that with the plastic slip
    warming      [K m2 s^0.5/J] temperature by heat over the root of its duration
    bulk         [degC] temperature of both bodies before the contact
    heat_from    [degC] temperature from which friction changes
    heat_slope   [1/K]  change of friction per degree
    heat_change  [1]    largest change of friction, with its sign
    tangential   [int]  creep law, of ``wrsim.contact.models``
    parabolic    [int]  whether the traction bound is a parabola along the strip
    blended      [int]  whether FASTSIM has one flexibility, blended of three
    stride       [int]  nodes between two samples of the search
    normal       [int]  stage of the normal model
    projected    [int]  whether the approach is projected on the strip's normal
    joint        [int]  whether lobes of a patch share recess and strips
    strips       [int]  number of strips on a lobe
    fewest       [int]  least number of strips on a lobe
    rows         [int]  rows of a section in the rail's table
    field_rows   [int]  rows of the distances of a section
    curved       [int]  whether the influence of strips is turned with their normals
    depth_rows   [int]  rows of the depth of a wheel out of round, around it
    history      [int]  whether the bound of tractions depends on heat or plastic slip on the way
""")
"""Numbers of a contact model, which no kernel changes."""

CALL = record("""
    place        [m]     distance of the wheel along the rail
    twist        [rad/m] how the rail turns along the track, positive where its outer side rises
    bow_o        [1/m]   curvature of the rail outward
    bow_b        [1/m]   curvature of the rail up
    wheel_angle  [rad]   angle by which a wheel out of round has rolled
    sine         [1]     of the angle in plan by which the rail runs outward
    about        [m]     distance of the point, from the place, about which the rail's axes are turned
    averaged     [m]     half length over which the curvature of a wheel out of round along the rail is a mean
    mu           [1]     friction on the top of the rail
    mu_gauge     [1]     friction on its gauge corner
    zone_start   [1]     tangent of half the contact angle at which the ramp between both begins
    zone_end     [1]     tangent of half the contact angle at which it ends
    fall_ratio   [1]     friction at large slip over that at rest
    fall_decay   [s/m]   decay of friction with the slip
""")
"""One evaluation: what the caller sets besides the pose, and what holds at that place of the rail."""

STATE = record("""
    tolerance  [1]    residual of a contact that starts from the last one, over the deepest penetration
    start      [int]  COLD_START or FROM_LAST
    station    [int]  station of the rail found last
""")
"""What one evaluation leaves for the next, and how it is used; the strip model's own is its MEMO."""

KIK_PIOTROWSKI, FREE_STRIPS, CREEP_FORCES, CONTACT = range(4)
"""Stages (contact.wheel_rail). The first two are MODEL.normal; `wrsim.contact.models` lists the models."""
POSES = 7
"""Stage of many poses (contact.prescribed_load), behind those of a vehicle (dynamics.wheel_forces)."""

COLD_START, FROM_LAST = range(2)
"""STATE.start of the strip model: cold, or from the last contact."""

MAIN_POINT = record("""
    arc_wheel   [m]    arclength on the wheel
    arc_rail    [m]    arclength on the rail
    depth       [m]    penetration
    curvature   [1/m]  relative curvature across
    saddle      [m]    least penetration between this contact and the next; -1 where the profiles separate in between
    saddle_arc  [m]    rail arclength of that place
""")
"""A contact that the search found."""

STRIP = record("""
    s     [m]    centre across, by the rail's arclength from the main point
    ds    [m]    width across
    x     [m]    middle along the rail
    a     [m]    half length along the rail
    p     [Pa]   largest pressure
    no    [1]    outward component of the normal from rail to wheel
    nb    [1]    upward component of the normal
    slope [1]    of the rail along the track
    o     [m]    centre, outward
    b     [m]    centre, up
    N     [N]    normal force
    Fx    [N]    creep force on the wheel, along the rail
    Fy    [N]    creep force on the wheel, across
    Mz    [N m]  moment of the creep forces about the centre
    xi    [1]    longitudinal creepage
    eta   [1]    lateral creepage
    phi   [1/m]  spin
    r_t   [m]    radius of curvature along the rail
    mu    [1]    coefficient of friction
    temperature [degC] largest of the surface, where it is computed
    penetration [m] of the undeformed bodies
""")
"""A strip."""

LOBE = record("""
    N           [N]     normal force
    Fx          [N]     creep force on the wheel, along the rail
    Fy          [N]     creep force on the wheel, across
    Mz          [N m]   spin moment about the main point
    p0          [Pa]    largest pressure
    area        [m2]    contact area
    length      [m]     along the track
    width       [m]     across
    approach    [m]     of the undeformed bodies
    angle       [rad]   contact angle at the main point
    angle_min   [rad]   least contact angle
    angle_max   [rad]   largest contact angle
    angle_mean  [rad]   contact angle of the resultant of the pressures
    xi          [1]     longitudinal creepage at the main point
    eta         [1]     lateral creepage at the main point
    phi         [1/m]   spin at the main point
    closing     [m/s]   rate of approach
    wear        [N]     what creep dissipates over the distance
    arc_wheel   [m]     arclength of the main point on the wheel
    arc_rail    [m]     arclength of the main point on the rail
    x           [m]     main point, along the track
    o           [m]     main point, outward
    b           [m]     main point, up
    no          [1]     outward component of the normal from rail to wheel at the main point
    nb          [1]     upward component of the normal at the main point
    slope       [1]     of the rail along the track at the main point
    start       [m]     lower edge along s
    end         [m]     upper edge along s
    recess      [m]     over which the strips are laid
    half_length [m]     at the main point
    coupling    [1]     to ``partner``
    amplitude   [Pa/m]  p / a of the pressure
    temperature [degC]  largest of the surface, where it is computed
    group       [int]   number of the patch
    partner     [int]   lobe that this one is coupled to, or -1
    n_strips    [int]   number of strips
""")
"""A lobe of a patch."""

TOTAL = record("""
    Ft      [N]    force on the wheel, along the track
    Fo      [N]    force on the wheel, outward
    Fb      [N]    force on the wheel, up
    Mt      [N m]  moment on the wheel about its profile origin, along the track
    Mo      [N m]  moment, outward
    Mb      [N m]  moment, up
    wear    [N]    wear number T-gamma
    closest [m]    smallest distance between the profiles, negative in contact
    lobes   [int]  number of lobes
    patches [int]  number of patches: lobes that share one count once
    status  [int]  sum of the STATUS bits
""")
"""The sums over all lobes."""

STATUS_NOT_REFINED = 1  # a main point was not found to round-off
STATUS_PROFILE_END = 2  # contact reaches the end of a profile
STATUS_TOO_DEEP = 4  # an overlap, not a contact
STATUS_NOT_CONVERGED = 8  # the strip model was not solved, a substitute is used
STATUS_LEFT_OUT = 8192  # a further place of contact along the rail is left out
STATUS_COARSE = 4096  # the strip model's budget was spent: half as many strips, or a larger residual
STATUS_NO_CONTACT, STATUS_OUT_OF_REACH, STATUS_DISCONTINUOUS, STATUS_LOAD_UNSOLVED = 16, 32, 512, 2048
"""At a prescribed load: no contact at any height; it is not met within the approach allowed; the force jumps over it;
the strip model does not meet it in the residuals allowed.
`wrsim.contact.status` has the text of each, and every analysis reports it."""


class WheelPose(NamedTuple):
    """Place and motion of a wheel."""

    origin: Vec  # profile origin on the axle [m]
    axle: Vec  # unit vector outward [1]
    velocity: Vec  # of that origin [m/s]
    omega: Vec  # angular velocity [rad/s]


POSE = 12
"""Numbers of a pose in an array, in this order."""


@inlined
def read_pose(row: Array) -> WheelPose:
    """The pose in a row of 12 numbers."""
    return WheelPose(vec_at(row, 0), vec_at(row, 3), vec_at(row, 6), vec_at(row, 9))


class ProfileTable(NamedTuple):
    """A profile over its arclength."""

    table: Any  # (n, 5), see ``contact.surfaces.profile_table``
    step: float  # arclength between rows [m]


class Share(NamedTuple):
    """A place between two stations of a rail: cubic weights of their values and rates."""

    at: int  # number of the first station
    low: int  # first row of that station
    high: int  # first row of the next one
    a: float  # weight of the first station's values [1]
    b: float  # weight of the next one's values [1]
    c: float  # weight of the first one's rates [m]
    d: float  # weight of the next one's rates [m]


class Rail(NamedTuple):
    """A rail: one profile, or sections that change along the track (`wrsim.contact.surfaces.rolled_rail`)."""

    table: Any  # (stations * rows, 5 or 8)
    rates: Any  # of the same shape; (0, 0) for one profile
    stations: Any  # (n,) places of the sections [m]
    step: float  # arclength between rows [m]
    rows: int  # of one section
    share: Share  # between which stations the wheel is
    place: float  # distance along the rail about which its own axes are turned in plan [m]
    sine: float  # of that angle [1]
    beside: float  # how far ahead of that place the axle is [m]
    twist: float  # how the section turns along the rail, positive where its outer side rises [rad/m]
    bow_o: float  # curvature outward [1/m]
    bow_b: float  # curvature up [1/m]
    yaw: float  # component of the axle along the rail [1]
    o: float  # outward coordinate of the wheel [m]
    radius: float  # of the wheel [m]
    roller: float  # inverse of the radius of a roller [1/m]


class Shape(NamedTuple):
    """How a wheel is out of round, see ``contact.surfaces.wheel_shape``."""

    depth: Any  # (columns * rows, 4) values, rates over a row and a column, and of both; no rows for a round wheel
    branches: Any  # (n, 4)
    rows: int  # around the wheel
    first: float  # first column [m]
    step: float  # distance of columns [m]
    least: float  # least depth [m]
    angle: float  # by which the wheel has rolled [rad]
    averaged: float  # half length of contact [m]


class PlacedWheel(NamedTuple):
    """A wheel in its place."""

    profile: ProfileTable
    radius: float  # at the tape circle [m]
    origin: Vec  # profile origin on the axle [m]
    axle: Vec  # unit vector e outward [1]
    q: float  # sqrt(1 - e_t^2) [1]
    lean: float  # e_t of a round wheel, 0 of one out of round [1]
    roller: float  # inverse of the radius of the roller under it [1/m]
    shape: Shape


class Field(NamedTuple):
    """Signed distances of a rail on a square grid, see ``contact.search.points``."""

    values: Any  # (n, n_b, 2) distances and arclengths [m]
    first: int  # first row of the section
    rows: int  # rows of a section
    o: float  # outward coordinate of the first row [m]
    b: float  # height of the first column [m]
    spacing: float  # of the grid [m]
    slack: float  # how far a distance may be off; 0 for a rail of one profile [m]
