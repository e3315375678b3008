"""The edges of a contact in the strip model: where they should be, and how they get there."""

from wrsim.core.compiling import kernel
from wrsim.core.contact.strips.layout import (
    A_,
    BOUND,
    END_,
    FIRST,
    LEAST,
    MOST,
    MOVED,
    MOVES,
    OTHER,
    SHIFT,
    SLOPE,
    START_,
    WENT,
    WISHED,
)

EDGE_RATIO = 0.28  # of a^2 in the two outer strips; Hertz's ellipses then keep their width
EDGE_SLOPE = 0.8  # how fast it falls per strip width
STEEPEST = -8.0  # believable slope of what an edge wishes over where it lies
FARTHEST_SHIFT = 1.0  # of an edge at once, in strip widths
FARTHEST_STRIDE = 6.0  # the same for an edge that goes on and on


@kernel
def forget(i, lobes):
    """Forget how the edges of lobe i moved."""
    lobes[MOVED, i] = lobes[MOVED + 1, i] = 0.0
    lobes[WISHED, i] = lobes[WISHED + 1, i] = 0.0
    lobes[BOUND, i] = lobes[BOUND + 1, i] = 1.0
    lobes[MOVES, i] = 0.0
    _plain_slopes(i, lobes)


@kernel
def edge_shifts(patches, i, v, lobes):
    """How far the edges of lobe i should move, in strip widths.

    Near the edge of a contact p^2, and with it a^2, grows in proportion to the distance: a contact drawn too narrow
    carries a punch's singular pressure in its outer strip, one drawn too wide would have to pull there. The ratio of
    a^2 in the two outer strips tells which, and falls steadily as the edge moves out. Positive shifts go along +s.
    Writes SHIFT; returns the larger amount.
    """
    n = patches[i].n_strips
    first = int(lobes[FIRST, i])
    left, right = _gone(v, first, n)
    width = (lobes[END_, i] - lobes[START_, i]) / n
    largest = 0.0
    for side in range(2):
        outer = first + left if side == 0 else first + n - 1 - right
        inwards = 1 if side == 0 else -1
        ratio = (v[A_, outer] / v[A_, outer + inwards]) ** 2 if v[A_, outer + inwards] > 0.0 else 1.0
        out = (ratio - EDGE_RATIO) / EDGE_SLOPE
        gone = left if side == 0 else right
        # strips that left take the edge with them, whatever the next one carries
        out = min(max(out, -FARTHEST_SHIFT), FARTHEST_SHIFT if gone == 0 else 0.5 * FARTHEST_SHIFT)
        room = (lobes[START_, i] - lobes[LEAST, i] if side == 0 else lobes[MOST, i] - lobes[END_, i]) / width
        out = min(out - gone, room)
        lobes[SHIFT + side, i] = -out if side == 0 else out
        largest = max(largest, abs(out))
    return largest


@kernel
def _gone(v, first, n):
    """How many strips at both ends of a lobe are out of contact."""
    left = 0
    while left < n and v[A_, first + left] <= 0.0:
        left += 1
    right = 0
    while right < n - left and v[A_, first + n - 1 - right] <= 0.0:
        right += 1
    return left, right


@kernel
def in_contact(patches, i, v, lobes):
    """Number of strips between the first and the last one of lobe i in contact."""
    n = patches[i].n_strips
    left, right = _gone(v, int(lobes[FIRST, i]), n)
    return n - left - right


@kernel
def move_edges(patches, i, v, lobes):
    """Move the edges of lobe i by SHIFT; half lengths keep their place relative to the strips in contact."""
    n = patches[i].n_strips
    first = int(lobes[FIRST, i])
    left, right = _gone(v, first, n)
    width = (lobes[END_, i] - lobes[START_, i]) / n
    w0, w1 = lobes[SHIFT, i] * width, lobes[SHIFT + 1, i] * width
    if left > 0 or right > 0:
        # strips that left say nothing of the slope
        lobes[MOVED, i] = lobes[MOVED + 1, i] = 0.0
        _plain_slopes(i, lobes)
        m0, m1 = w0, w1
    else:
        m0, m1 = _broyden(i, lobes, w0, w1)
    # an edge that keeps wishing to go out is far from its place: longer steps each time
    far0 = FARTHEST_SHIFT * width
    far1 = far0
    if w0 <= -0.9 * far0 and lobes[MOVED, i] < 0.0:
        m0 = min(m0, 2.0 * lobes[MOVED, i])
        far0 *= FARTHEST_STRIDE
    if w1 >= 0.9 * far1 and lobes[MOVED + 1, i] > 0.0:
        m1 = max(m1, 2.0 * lobes[MOVED + 1, i])
        far1 *= FARTHEST_STRIDE
    m0 = min(max(m0, -far0), far0) if left == 0 else m0
    m1 = min(max(m1, -far1), far1) if right == 0 else m1
    m0 = _bounded(i, lobes, 0, w0, m0)
    m1 = _bounded(i, lobes, 1, w1, m1)
    m0 = max(m0, lobes[LEAST, i] - lobes[START_, i])
    m1 = min(m1, lobes[MOST, i] - lobes[END_, i])
    lobes[WISHED, i], lobes[WISHED + 1, i] = w0, w1
    if left == 0 and right == 0:
        lobes[MOVED, i], lobes[MOVED + 1, i] = m0, m1
    lobes[START_, i] += m0
    lobes[END_, i] += m1
    if left == 0 and right == 0:
        return
    stretch = (n - left - right) / n
    for j in range(n):
        v[OTHER, first + j] = v[A_, first + j]
    for j in range(n):
        x = left + (j + 0.5) * stretch - 0.5
        c = min(max(int(x), left), n - right - 2)
        r = min(max(x - c, 0.0), 1.0)
        v[A_, first + j] = v[OTHER, first + c] * (1.0 - r) + v[OTHER, first + c + 1] * r
        if x < left or x > n - right - 1:
            v[A_, first + j] *= 0.7


@kernel
def _bounded(i, lobes, side, wish, move):
    """An edge that turns round has gone too far: its next moves are at most half as long, until it goes on again."""
    if wish * lobes[WISHED + side, i] < 0.0:
        lobes[BOUND + side, i] = 0.5 * min(lobes[BOUND + side, i], abs(lobes[WENT + side, i]))
    elif abs(lobes[WENT + side, i]) >= lobes[BOUND + side, i]:
        lobes[BOUND + side, i] *= 2.0
    bound = lobes[BOUND + side, i]
    move = min(max(move, -bound), bound)
    lobes[WENT + side, i] = move
    return move


@kernel
def _plain_slopes(i, lobes):
    """A wish that is fulfilled vanishes: what is assumed until moves have shown more."""
    lobes[SLOPE, i] = lobes[SLOPE + 3, i] = -1.0
    lobes[SLOPE + 1, i] = lobes[SLOPE + 2, i] = 0.0


@kernel
def _broyden(i, lobes, w0, w1):
    """Moves of both edges that should fulfil both wishes; the slopes are learnt from the last move (Broyden)."""
    m0, m1 = lobes[MOVED, i], lobes[MOVED + 1, i]
    square = m0 * m0 + m1 * m1
    j00, j01, j10, j11 = lobes[SLOPE, i], lobes[SLOPE + 1, i], lobes[SLOPE + 2, i], lobes[SLOPE + 3, i]
    if square > 0.0:
        r0 = (w0 - lobes[WISHED, i] - j00 * m0 - j01 * m1) / square
        r1 = (w1 - lobes[WISHED + 1, i] - j10 * m0 - j11 * m1) / square
        j00 += r0 * m0
        j01 += r0 * m1
        j10 += r1 * m0
        j11 += r1 * m1
    determinant = j00 * j11 - j01 * j10
    if determinant < 0.1 or not (STEEPEST < j00 < -0.1 and STEEPEST < j11 < -0.1):
        _plain_slopes(i, lobes)
        return w0, w1
    lobes[SLOPE, i], lobes[SLOPE + 1, i], lobes[SLOPE + 2, i], lobes[SLOPE + 3, i] = j00, j01, j10, j11
    return (-w0 * j11 + w1 * j01) / determinant, (-w1 * j00 + w0 * j10) / determinant
