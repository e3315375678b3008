"""The data of the strip model: records that its kernels write in place.

A grid is what one system of strips lies over: a lobe, part of one, or lobes that are nearly one. Strips follow each
other in one array, grid after grid; s is the rail's arclength throughout.
"""

from typing import NamedTuple

from wrsim.contact.records import PlacedWheel, Rail
from wrsim.jit import Array, Records, record

UNKNOWNS_PER_STRIP = 2  # squares of half lengths, factors
EDGES = 2  # unknowns of a grid behind those of its strips
MIDDLES = 2  # unknowns of a grid behind its edges: the line of (strip-middles)
ROWS = 48  # of the table of the geometry of a grid

ROW = record("""
    s          [m]    arclength on the rail
    arc_wheel  [m]    arclength of the point of the wheel opposite
    d          [m]    penetration
    x          [m]    shift of the contact locus along the rail
    o          [m]    middle between both points, outward
    b          [m]    middle between both points, upward
    no         [1]    outward component of the normal from rail to wheel
    nb         [1]    upward component
    r_t        [m]    radius along the rail of both bodies
    slope      [1]    slope of the rail along the track
    curvature  [1/m]  mean of 1/r_t over what a strip runs over
    density    [1]    density of strips (strip-density)
    xi         [m]    integral of the density up to the row
    overlap    [m]    penetration less displacement
    corner     [int]  row of the next corner of the concave hull
    side       [1]    lateral creep force over normal force of the last strips over the row (strip-turned)
""")
"""A row of the table of a grid's geometry."""

PLACE = record("""
    lo              [m]     end of the strip at its lower s
    hi              [m]     other end
    s               [m]     middle
    lo_start        [1]     slope of lo over the start edge of the grid
    lo_end          [1]     slope of lo over its end edge
    hi_start        [1]     slope of hi over the start edge
    hi_end          [1]     slope of hi over the end edge
    d               [m]     penetration
    d_s             [1]     its slope over s
    curvature       [1/m]   1/R_x
    curvature_s     [1/m2]  its slope over s
    x               [m]     shift of the contact locus along the rail
    x_s             [1]     its slope over s
    no              [1]     outward component of the normal from rail to wheel
    nb              [1]     upward component
    y               [m2]    square of the half length; 0 out of contact
    q               [Pa/m]  amplitude of the pressure
    k               [1]     factor of the amplitude
    off             [m]     distance of the strip's middle from the locus
    z               [1]     number of the strip in its grid, from -1 to 1
    gap             [1]     (strip-points) in the middle: u - d over the deepest penetration
    bow             [1]     (strip-points): by how much that is more than at the outer points
    tilt            [1]     (strip-points): difference of the outer points
    a               [m]     half length
    q_k             [Pa/m]  derivative of q by k
    log_slope       [1/m]   slope of the logarithm of the curvature over s
    s_start         [1]     slope of s over the start edge
    s_end           [1]     slope of s over the end edge
    turn            [1/m]   slope of the normal's angle over s
    side_s          [1/m]   slope of lateral over normal force over s
    lobe            [int]   lobe that the strip is reported in
    row             [int]   strip of that lobe
""")
"""A strip of a grid."""

GRID = record("""
    start           [m]    edge of the contact at lower s
    end             [m]    other edge
    least           [m]    bound of the start: the grid's first row
    most            [m]    bound of the end: its last row
    deepest         [m]    largest penetration
    spacing         [m]    distance of rows
    x               [m]    shift of the locus where the overlap is deepest
    half_length     [m]    half length of the overlap there
    stair_variance  [1]    variance of steps between strips (strip-stairs)
    weight          [N/m]  sum of the weights in (strip-means)
    arc_wheel       [m]    arclength on the wheel of a pair of opposite points
    arc_rail        [m]    arclength on the rail of that pair
    coupling        [1]    share of what reaches this grid that reaches the next one too
    active          [int]  whether it is in contact
    start_held      [int]  whether the start is held at its bound
    end_held        [int]  whether the end is held at its bound
    first           [int]  first lobe over it
    last            [int]  last lobe over it
    entries         [int]  times that it has come into contact in a solution
""")
"""A grid."""

MEMO = record("""
    rate            [1]    share of the residual that one of the worst of the last steps left
    budget          [1]    residuals of one grid that calls may take from when ``work`` is 0; inf: any number
    work            [1]    those taken, Jacobians by their price
    reserve         [1]    what half as many strips take to follow the last contact
    spare           [1]    what a Jacobian leaves of the budget
    left            [1]    residual of a contact that the budget left unsolved, over the deepest penetration; 0: solved
    stiffness       [Pa]   pi E*
    modulus         [Pa]   E*
    transverse      [1]    nu/(1 - nu)
    deepest         [m]    deepest penetration of all grids
    together        [m]    distance of grids up to which they press each other down fully
    apart           [m]    distance from which on they do not
    grids_before    [int]  grids of the last call; 0: there is no solution to start from
    grids           [int]  grids of this call
    uncoupled       [int]  whether grids are solved for one by one
    has_shifts      [int]  whether shifts along the rail count
    curved          [int]  whether angles between strips count
    traction_pass   [int]  times that creep forces have been computed in this call
    inverted        [int]  whether ``matrix`` is an inverse of use
    unknowns        [int]  unknowns that are solved for
    iterations      [int]  residuals taken in this call
    factorisations  [int]  Jacobians made in this call
    all_strips      [int]  strips of a grid that are asked for
    laid            [int]  strips of a grid that the unknowns belong to
    unsolved        [int]  residuals of calls in a row that the budget left without a solution
    strips          [int]  strips of a grid that it was solved with; 0: it was not
    substitutes     [int]  calls so far that have no solution
""")
"""State of the whole system, from call to call."""


class VectorRows(NamedTuple):
    """Rows of ``vectors``, each as long as all unknowns; from FROM to LIFT as all strips."""

    X: int  # unknowns
    F: int  # residuals
    STEP: int  # step of all unknowns
    SAVED: int  # unknowns before a step
    NEXT: int  # step of the unknowns that are solved for
    LAST_STEP: int  # step before that
    RHS: int  # negative residuals of the unknowns that are solved for
    PIVOT: int  # rows exchanged in the factors
    SCALE: int  # weights of the unknowns in products of steps
    UNKNOWN_INDEX: int  # numbers of the unknowns that are solved for
    FADING: int  # share of the influence of each grid that reaches each other one, (grids, grids)
    FROM: int  # ends of strips at lower s [m]
    TO: int  # other ends [m]
    INVERSE: int  # 1/a [1/m]; 1.0 out of contact
    PUSH: int  # amplitudes times a^2 [Pa m]; 0 out of contact
    MIDDLE: int  # middles along the rail [m]
    NO: int  # outward components of normals; 0 where angles do not count
    NB: int  # upward components; 1 where angles do not count
    SIDE: int  # lateral over normal force
    LIFT: int  # SIDE times nu/(1 - nu)
    LAST_SOLUTION: int  # unknowns of the last solution of a continuation, or of the one with half as many strips
    TILT: int  # derivatives of a strip's ``tilt``
    BEFORE: int  # two numbers of each strip from before its grid is placed anew
    WEIGHTED: int  # last step times the weights of its unknowns
    PRODUCT: int  # WEIGHTED times the inverse
    TERMS: int  # of `influence`: of all strips what a displacement or its derivatives are made of; last rows


V = VectorRows(*range(len(VectorRows._fields)))
POINTS, TERMS_PER_POINT = 3, 5
RESTS = V.TERMS + POINTS * TERMS_PER_POINT  # of coordinates beyond whole steps: three rows
VECTORS = RESTS + 3


class System(NamedTuple):
    """What Newton's method solves for, and with."""

    wheel: PlacedWheel
    rail: Rail
    table: Array  # of the influence (`influence`)
    rows: Records  # ROW, (grids, ROWS)
    places: Records  # PLACE, (grids * n,)
    grids: Records  # GRID, (grids,)
    vectors: Array  # (VECTORS, unknowns), see `VectorRows`
    matrix: Array  # (unknowns, unknowns): derivatives, their factors or their inverse
    memo: Records  # MEMO, (1,)
