"""A bridge below the rails: its deck moves up and down in modes, and both rails with it.

With the deflection w(s, t) = sum_k phi_k(s) eta_k(t) a wheel at s meets rails that have risen by w and rise by w_t + v
w_s; the wheels push the modes down,

    m_k (eta_k_tt + 2 zeta_k omega_k eta_k_t + omega_k^2 eta_k) = -sum over wheels of phi_k(s) Q.

The slope w_s turns the force of the rail on a wheel. The modes are records MODE of ``dynamics.flexible``.
"""

from wrsim.jit import Array, Record, Records, kernel, record
from wrsim.jit.curves import hermite

DECK = record("""
    start [m]   beginning of the bridge
    step  [m]   distance of the rows of its shapes along the track
    first [int] number of its first mode
    count [int] number of its modes
""")


@kernel
def _between(s: float, deck: Record, rows: Array) -> tuple[int, float, bool]:
    """Row ahead of a place s [m], the part of the way to the next one, and whether it is on the bridge."""
    x = (s - deck.start) / deck.step
    i = min(max(int(x), 0), rows.shape[0] - 2)
    return i, x - i, 0.0 <= x <= rows.shape[0] - 1.0


@kernel
def _shape(k: int, i: int, x: float, step: float, rows: Array) -> tuple[float, float]:
    """Value [1] and slope [1/m] of a mode at a part x of the way from row i to the next."""
    c = 2 * k
    value, slope, _ = hermite(rows[i, c], rows[i + 1, c], step * rows[i, c + 1], step * rows[i + 1, c + 1], x)
    return value, slope / step


@kernel
def deck_motion(
    s: float, speed: float, deck: Record, rows: Array, modes: Records, q: Array, q_t: Array
) -> tuple[float, float, float]:
    """How far the deck has risen at a wheel's place s [m], how fast it rises under the wheel [m/s], and its slope.
    speed: of the wheel along the track [m/s]; rows (n, 2 modes): value and slope of every mode."""
    i, x, on = _between(s, deck, rows)
    up, rate, lean = 0.0, 0.0, 0.0
    if on:
        for k in range(deck.count):
            coordinate = modes[deck.first + k].coordinate
            value, slope = _shape(k, i, x, deck.step, rows)
            up += value * q[coordinate]
            rate += value * q_t[coordinate]
            lean += slope * q[coordinate]
    return up, rate + speed * lean, lean


@kernel
def push_deck(s: float, force: float, deck: Record, rows: Array, modes: Records, out: Array) -> None:
    """Add the accelerations of the modes by a force up [N] at a place [m]."""
    i, x, on = _between(s, deck, rows)
    if on:
        for k in range(deck.count):
            mode = modes[deck.first + k]
            value, _slope = _shape(k, i, x, deck.step, rows)
            out[mode.coordinate] += value * force / mode.mass
