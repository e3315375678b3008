"""The data of the strip model: records that its kernels write in place.

A place is one strip; places of a lobe follow each other, lobe after lobe.
"""

from typing import Any, NamedTuple

from wrsim.core.arena import record
from wrsim.core.compiling import inlined

FACTORS = 7  # values of k along a lobe
FEWEST_FREE_STRIPS = 12  # of a lobe

PLACE = record("d r_t hertz q a a_before weight misfit s ds x o b no nb at", "lobe slot touching let_go")
"""A strip: penetration d, radius along the rail; Hertz's amplitude for k = 1, amplitude q, half length a (0 out of
contact) and before it was laid anew; weight and misfit of the curvature; position, width, shift x, centre and normal;
place among the factors. Its lobe, its number among the strips in contact or -1, the place of the strip that has this
place's number among those, times that it has been let go."""

EDGE = record("at limit shift wished moved bound before went")
"""An edge of a contact [m]: where it is, how far out it may go, how far it should move (in strip widths), what was
wished and how far it moved last, bound of its next move, where it was before the lobe was last widened, its last move
whatever made it."""

SPAN = record(
    "weight slope_ss slope_se slope_es slope_ee", "first n on loaded widened moves", start=EDGE, end=EDGE
)  # fmt: skip
"""The strips of a lobe: sum of their weights, slopes of the wishes of both edges over their moves; first place, number
of places, whether it takes part and has strips in contact, times that it was widened and that its edges moved."""


class Unknowns(NamedTuple):
    """What Newton's method solves for, and with.

    places: (m,) PLACE, spans: (lobes,) SPAN; factors: (lobes * FACTORS,) values of k, kept from call to call; step:
    (m + lobes * FACTORS,) misfits, then steps. Of strip j on the centre of strip i, (m, m): u and c, influence on the
    displacement and the curvature; du and dc, their derivatives by ln a_j. jacobian: of all unknowns.
    """

    places: Any
    spans: Any
    factors: Any
    step: Any
    u: Any
    c: Any
    du: Any
    dc: Any
    jacobian: Any


MATRICES = 5  # of the unknowns


@inlined
def touching(places, i):
    """The i-th strip in contact."""
    return places[places[i].touching]


@inlined
def of_span(places, span):
    """The places of a lobe."""
    return places[span.first : span.first + span.n]
