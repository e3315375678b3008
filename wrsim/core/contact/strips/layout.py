"""Where each number stands in the scratch arrays of the strip model.

A place is one strip; places of a lobe follow each other, lobe after lobe.
"""

# rows of the vectors, one number a place: penetration d, radius R_x, width, lobe, place among the factors, position s,
# shift x, centre (o, b), normal (o, b), half length a (0 out of contact), amplitude Q and Hertz's Q for k = 1, weight
# and misfit of the curvature, slot in the matrices, times that a strip has been let go, half lengths on another grid;
# then the unknowns' steps; the factors k of the lobes, kept from call to call
(
    D, R, WIDTH_, LOBE, AT, POS, X_, O_, B_, NO_, NB_, A_, Q_, HERTZ, WEIGHT, MISFIT, SLOT, LEFT, OTHER, STEP, FACTOR,
) = range(21)  # fmt: skip
VECTORS = 21

A_MATRIX, B_MATRIX, DA_MATRIX, DB_MATRIX, JACOBIAN = range(5)
MATRICES = 5

# rows of the lobes' own numbers: first place, edges of the contact, their limits, in contact or not, wanted shifts of
# both edges in strip widths, last wanted shifts and last moves of both edges,
# with strips or without, times that it has been widened, moves of its edges, slopes of the wishes (2 x 2), bounds of
# the next moves, edges before it was last widened, how far they went last
FIRST, START_, END_, LEAST, MOST, ON, HAS, RETURNED, MOVES = range(9)
SHIFT, WISHED, MOVED, SLOPE, BOUND, BEFORE, WENT = 9, 11, 13, 15, 19, 21, 23
LOBE_ROWS = 25

FACTORS = 7  # values of k along a lobe
FEWEST_FREE_STRIPS = 12  # of a lobe
