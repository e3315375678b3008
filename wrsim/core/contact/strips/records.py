"""The data of the strip model: records that its kernels write in place.

A grid is what one system of strips lies over: a lobe, or neighbouring lobes that are nearly one. Places of a grid
follow each other, grid after grid; s is the rail's arclength throughout.
"""

from typing import Any, NamedTuple

from wrsim.core.jit.arena import record

FACTORS = 7  # values of k along a grid
EDGES = 2  # unknowns of a grid behind its factors
FEWEST_FREE_STRIPS = 12  # of a grid
ROWS = 48  # of the table of the geometry of a grid

ROW = record("s arc d x o b no nb r_t slope bend density xi closing")
"""A row of the table of a grid's geometry: place s, arclength opposite on the wheel, penetration d, shift x, centre
(o, b), normal (no, nb), radius along the rail, slope of the rail, mean of the radius' inverse over what a strip runs
over, density of strips and its integral; closing of the gap, penetration less displacement."""

PLACE = record(
    "lo hi s lo_start lo_end hi_start hi_end d d_s bend bend_s x x_s at y over q weight gap miss off"
    # for the derivatives
    " root half lean growing mid_start mid_end bent bent_y"
)
"""A strip: from lo to hi, middle s; slopes of lo and hi over both edges; penetration d and its slope; 1/R_x and its
slope; shift x and its slope; place among the factors; a^2 (0 out of contact) and what its amplitude is more than k asks
for, amplitude, weight of its curvature; u - d and the misfit of the curvature; how far its middle lies off the locus
along x. a; amplitude over k; slope of the logarithm of 1/R_x, and of d R_x where a is as long as it can be; slopes of s
over both edges; how much of what it does to the curvature counts, and the slope of its logarithm over that of a^2
(`tails`)."""

GRID = record(
    "start end least most deepest spacing x reach arc place along stretch pivot evenness calm bond link chain "
    "line_s line_x line_slope line_reach wide soft waist",
    "on start_held end_held first last tail reaches pressing beyond linked",
)
"""A grid: edges of its contact, their bounds, largest penetration, spacing of its rows; shift and half length along x;
arclengths on wheel and rail of a pair of opposite points; mean of its shifts, how the middles of its strips lie off the
locus (`shifts.off_locus`), how much more evenly its factors run and how firmly its half lengths are held together;
least penetration over its concave hull between it and the next grid (`ground`), how firmly its last factor is held to
the first of that one, how far the overlaps of both are one; of a tail (`tails`) a place, its shift and the slope of the
line that the locus has under its hump, how far off that line it begins, and how much it counts as one, by its width;
how much two humps on it ask for looser factors, and where it lies lowest between them (`ground`).
Whether it is in contact, whether its edges
are held at their bounds, its first and last lobe; of a tail the number of its hump's grid less its own, else 0; how
often its edges have moved out over a gap in this solution; its first strip in contact and the one beyond its last
(equal: none); the grid whose first factor its last one is held to, -1: none."""

MEMO = record(
    "rate stiffness modulus deepest together apart",
    "known strips grids parted tails known_tails shifted inverted unknowns iterations factorisations result "
    "substitutes",
)
"""Of the whole system: about the worst of what the last steps left of the misfit, pi E*, E*, deepest penetration;
distances of grids up to which they press each other down fully and from which on not at all [m]; number of grids in the
last call (0: nothing is known), strips of a grid in it, grids now; whether any of them is a part of a lobe or of lobes
that hang together; which are tails, now and in the last call, as a number; whether shifts along x count; whether
``matrix`` is an inverse of use, and of how many unknowns; residuals taken and Jacobians made in this call, and how it
ended (`solution`); calls so far without a whole solution."""

(X, F, STEP, SAVED, NEXT, LAST, WISH, PIVOT, SCALE, SOLVED, FADING, FROM, TO, INVERSE, PUSH, CURVE, MIDDLE, TERMS) = (
    range(18)
)
"""Rows of ``vectors``: unknowns, misfits, step, unknowns before a step; of the unknowns that are solved for the next
step, the last one and the misfits; rows exchanged in the factors; weights of the unknowns; numbers of those that are
solved for; how much of the influence of a grid reaches another one, row after row; of all strips both
ends, 1/a, amplitude times a^2, amplitude (0 out of contact), middle along x; from TERMS on what all strips do to the
derivatives at one place (`influence.find_terms`, `influence.put_beside`)."""
VECTORS = TERMS + 10


class System(NamedTuple):
    """What Newton's method solves for, and with.

    table: of the influence (`influence`); rows: (grids, ROWS) ROW; places: (grids * n,) PLACE; grids: (grids,) GRID;
    vectors: (VECTORS, unknowns); matrix: (unknowns, unknowns), of the derivatives, their factors or their inverse;
    memo: (1,) MEMO.
    """

    table: Any
    rows: Any
    places: Any
    grids: Any
    vectors: Any
    matrix: Any
    memo: Any
