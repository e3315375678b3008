"""The edges of a contact in the strip model: where they should be, and how they get there."""

from wrsim.core.compiling import kernel

EDGE_RATIO = 0.28  # of a^2 in the two outer strips; Hertz's ellipses then keep their width
EDGE_SLOPE = 0.8  # how fast it falls per strip width
STEEPEST = -8.0  # believable slope of what an edge wishes over where it lies
FARTHEST_SHIFT = 1.0  # of an edge at once, in strip widths
FARTHEST_STRIDE = 6.0  # the same for an edge that goes on and on


@kernel
def forget(span):
    """Forget how the edges of a lobe moved."""
    for edge in (span.start, span.end):
        edge.moved = edge.wished = 0.0
        edge.bound = 1.0
    span.moves = 0
    _plain_slopes(span)


@kernel
def edge_shifts(span, own):
    """How far the edges of a lobe should move, in strip widths; own: its places.

    Near the edge of a contact p^2, and with it a^2, grows in proportion to the distance: a contact drawn too narrow
    carries a punch's singular pressure in its outer strip, one drawn too wide would have to pull there. The ratio of
    a^2 in the two outer strips tells which, and falls steadily as the edge moves out. Positive shifts go along +s.
    Writes ``shift``; returns the larger amount.
    """
    n = span.n
    left, right = _gone(own)
    width = (span.end.at - span.start.at) / n
    largest = 0.0
    for side in range(2):
        edge, sign, gone = (span.start, -1.0, left) if side == 0 else (span.end, 1.0, right)
        outer = left if side == 0 else n - 1 - right
        inner = min(left + 1, n - 1) if side == 0 else max(outer - 1, 0)
        ratio = (own[outer].a / own[inner].a) ** 2 if own[inner].a > 0.0 else 1.0
        out = (ratio - EDGE_RATIO) / EDGE_SLOPE
        # strips that left take the edge with them, whatever the next one carries
        out = min(max(out, -FARTHEST_SHIFT), FARTHEST_SHIFT if gone == 0 else 0.5 * FARTHEST_SHIFT)
        out = min(out - gone, sign * (edge.limit - edge.at) / width)
        edge.shift = sign * out
        largest = max(largest, abs(out))
    return largest


@kernel
def _gone(own):
    """How many strips at both ends of a lobe are out of contact."""
    n = own.size
    left = 0
    while left < n and own[left].a <= 0.0:
        left += 1
    right = 0
    while right < n - left and own[n - 1 - right].a <= 0.0:
        right += 1
    return left, right


@kernel
def in_contact(own):
    """Number of strips between the first and the last one in contact."""
    left, right = _gone(own)
    return own.size - left - right


@kernel
def move_edges(span, own):
    """Move the edges of a lobe by ``shift``; half lengths keep their place relative to the strips in contact."""
    n = span.n
    left, right = _gone(own)
    whole = left == 0 and right == 0
    width = (span.end.at - span.start.at) / n
    if whole:
        move_start, move_end = _broyden(span, span.start.shift * width, span.end.shift * width)
    else:
        # strips that left say nothing of the slope
        span.start.moved = span.end.moved = 0.0
        _plain_slopes(span)
        move_start, move_end = span.start.shift * width, span.end.shift * width
    for side in range(2):
        edge, sign, gone = (span.start, -1.0, left) if side == 0 else (span.end, 1.0, right)
        move = move_start if side == 0 else move_end
        wish = edge.shift * width
        far = FARTHEST_SHIFT * width
        if sign * wish >= 0.9 * far and sign * edge.moved > 0.0:
            # an edge that keeps wishing to go out is far from its place: longer steps each time
            move = sign * max(sign * move, 2.0 * sign * edge.moved)
            far *= FARTHEST_STRIDE
        if gone == 0:
            move = min(max(move, -far), far)
        move = _bounded(edge, wish, move)
        move = sign * min(sign * move, sign * (edge.limit - edge.at))
        edge.wished = wish
        if whole:
            edge.moved = move
        edge.at += move
    if whole:
        return
    stretch = (n - left - right) / n
    for j in range(n):
        own[j].a_before = own[j].a
    for j in range(n):
        x = left + (j + 0.5) * stretch - 0.5
        c = min(max(int(x), left), n - right - 2)
        r = min(max(x - c, 0.0), 1.0)
        own[j].a = own[c].a_before * (1.0 - r) + own[c + 1].a_before * r
        if x < left or x > n - right - 1:
            own[j].a *= 0.7


@kernel
def _bounded(edge, wish, move):
    """An edge that turns round has gone too far: its next moves are at most half as long, until it goes on again."""
    if wish * edge.wished < 0.0:
        edge.bound = 0.5 * min(edge.bound, abs(edge.went))
    elif abs(edge.went) >= edge.bound:
        edge.bound *= 2.0
    edge.went = min(max(move, -edge.bound), edge.bound)
    return edge.went


@kernel
def _plain_slopes(span):
    """A wish that is fulfilled vanishes: what is assumed until moves have shown more."""
    span.slope_ss = span.slope_ee = -1.0
    span.slope_se = span.slope_es = 0.0


@kernel
def _broyden(span, w_start, w_end):
    """Moves of both edges that should fulfil both wishes; the slopes are learnt from the last move (Broyden)."""
    m_s, m_e = span.start.moved, span.end.moved
    square = m_s * m_s + m_e * m_e
    ss, se, es, ee = span.slope_ss, span.slope_se, span.slope_es, span.slope_ee
    if square > 0.0:
        r_s = (w_start - span.start.wished - ss * m_s - se * m_e) / square
        r_e = (w_end - span.end.wished - es * m_s - ee * m_e) / square
        ss += r_s * m_s
        se += r_s * m_e
        es += r_e * m_s
        ee += r_e * m_e
    determinant = ss * ee - se * es
    if determinant < 0.1 or not (STEEPEST < ss < -0.1 and STEEPEST < ee < -0.1):
        _plain_slopes(span)
        return w_start, w_end
    span.slope_ss, span.slope_se, span.slope_es, span.slope_ee = ss, se, es, ee
    return (-w_start * ee + w_end * se) / determinant, (-w_end * ss + w_start * es) / determinant
