"""The data of the strip model: records that its kernels write in place.

A grid is what one system of strips lies over: a lobe, part of one, or lobes that are nearly one. Places of a grid
follow each other, grid after grid; s is the rail's arclength throughout.
"""

from collections import namedtuple
from typing import Any, NamedTuple

from wrsim.jit.arena import record

OF_A_STRIP = 2  # unknowns: squares of half lengths, factors
EDGES = 2  # unknowns of a grid behind those of its strips
MIDDLES = 2  # unknowns of a grid behind its edges: a line over the locus that has the middles of its strips
ROWS = 48  # of the table of the geometry of a grid

ROW = record("s arc d x o b no nb r_t slope bend density xi closing")
"""A row of the table of a grid's geometry: place s, arclength opposite on the wheel, penetration d, shift x, centre
(o, b), normal (no, nb), radius along the rail, slope of the rail, mean of the radius' inverse over what a strip runs
over, density of strips and its integral; closing of the gap, penetration less displacement."""

PLACE = record(
    "lo hi s lo_start lo_end hi_start hi_end d d_s bend bend_s x x_s no nb y q k off z gap bow turn"
    # for the derivatives
    " root half lean mid_start mid_end",
    "lobe row",
)
"""A strip: from lo to hi, middle s; slopes of lo and hi over both edges; penetration d and its slope; 1/R_x and its
slope; shift x of the locus and its slope; normal; a^2 (0 out of contact), amplitude, factor k, how far its middle lies
off the locus, its number from -1 to 1; residuals of its three conditions, over the deepest penetration:
u - d in its middle, how much more that is at its outer points, and the difference of both. a; amplitude over k; slope
of the logarithm of 1/R_x; slopes of s over both edges.
Lobe and strip of it that it was handed out to."""

GRID = record(
    "start end least most deepest spacing x reach stairs weight arc place chain",
    "on start_held end_held first last entries",
)
"""A grid: edges of its contact, their bounds, largest penetration, spacing of its rows; shift and half length of the
overlap where it is deepest; how firmly a^2 is held on a parabola; sum of the weights of strips in the conditions of
their middles; arclengths on wheel and rail of a pair of opposite points; how far what reaches it reaches the next one.
Whether it is in contact, whether its edges are held at their bounds, its first and last lobe; how often it has come
into contact in a solution."""

MEMO = record(
    "rate stiffness modulus deepest together apart",
    "known grids alone shifted curved turn inverted unknowns iterations factorisations strips substitutes",
)
"""Of the whole system: about the worst of what the last steps left of the residual, pi E*, E*, deepest penetration,
distances of grids up to which they press each other down fully and from which on not at all [m].
Number of grids in the last call (0: nothing is known), grids now; whether they are solved for one by
one; whether shifts along x count, and the angles between strips; how often creep forces were found in this call;
whether ``matrix`` is an inverse of use, and of how many unknowns; residuals taken and Jacobians made in this call, and
with how many strips of a grid it was solved (0: not); calls so far without a whole solution."""

V = namedtuple(
    "V",
    "X F STEP SAVED NEXT LAST WISH PIVOT SCALE SOLVED FADING FROM TO INVERSE PUSH MIDDLE NO NB SIDE LIFT SOUND TERMS",
)(*range(22))
"""Rows of ``vectors``: unknowns, residuals, step, unknowns before a step; of the unknowns that are solved for the next
step, the last one and the residuals; rows exchanged in the factors; weights of the unknowns; numbers of those that are
solved for; how much of the influence of a grid reaches another one, row after row; of all strips both ends, 1/a,
amplitude times a^2 (0 out of contact), middle along x, normal (0, 1 where angles do not count), lateral
over normal force, and that times nu/(1 - nu); in ``jacobian`` WISH has the derivatives of a strip's third condition;
unknowns of the last solution while grids come to press each other down; from TERMS on what all strips do to the
derivatives at three points (`influence.find_terms`)."""
POINTS, OF_A_POINT = 3, 5
VECTORS = V.TERMS + POINTS * OF_A_POINT


class System(NamedTuple):
    """What Newton's method solves for, and with.

    wheel, rail: the bodies; table: of the influence (`influence`); rows: (grids, ROWS) ROW; places: (grids * n,) PLACE;
    grids: (grids,) GRID; vectors: (VECTORS, unknowns); matrix: (unknowns, unknowns), of the derivatives, their factors
    or their inverse; memo: (1,) MEMO.
    """

    wheel: Any
    rail: Any
    table: Any
    rows: Any
    places: Any
    grids: Any
    vectors: Any
    matrix: Any
    memo: Any
