"""Butterworth filters in sections of second order, run forward and backward: to the bit what ``scipy.signal`` computes,
whose import takes half a second, as it brings scipy.stats."""

from collections.abc import Callable, Iterator

import numpy as np

from wrsim.jit.arena import Array
from wrsim.jit.compiling import kernel


def butterworth(order: int, corner: float, highpass: bool, rate: float) -> Array:
    """Sections (order/2, 5) of a filter of even order, by the bilinear transform: b0, b1, b2, a1, a2 with a0 = 1.

    corner: where the gain is -3 dB; rate: samples, in the same unit.
    """
    warped = 4.0 * float(np.tan(np.pi * (corner / (0.5 * rate)) / 2.0))
    poles = -np.exp(1j * np.pi * np.arange(1.0 - order, order, 2.0) / (2.0 * order))
    gain = np.real(1.0 / np.prod(-poles)) if highpass else warped**order
    poles = warped / poles if highpass else warped * poles
    gain *= np.real((4.0**order if highpass else 1.0) / np.prod(4.0 - poles))
    poles = ((4.0 + poles) / (4.0 - poles))[order // 2 :]  # one of each pair
    poles = poles[np.argsort(-np.abs(1.0 - np.abs(poles)))]  # those of the least damping last
    sections = np.empty((order // 2, 5))
    sections[:, :3] = 1.0, -2.0 if highpass else 2.0, 1.0
    sections[:, 3:] = [np.poly((pole, pole.conj()))[1:] for pole in poles]
    sections[0, :3] *= gain
    return sections


def at_rest(sections: Array) -> Array:
    """States (s, 2) of sections after a value of 1 that has stood for ever."""
    scale, states = 1.0, np.empty((len(sections), 2))
    for row, (b0, b1, b2, a1, a2) in zip(states, sections, strict=True):
        row[:] = scale * np.linalg.solve([[1.0 + a1, -1.0], [a2, 1.0]], [b1 - a1 * b0, b2 - a2 * b0])
        scale *= (b0 + b1 + b2) / (1.0 + a1 + a2)
    return states


def passed(sections: Array, signal: Array, states: Array) -> tuple[Array, Array]:
    """A signal (n, ...) once through sections, from states (s, 2, ...) on, and the states behind it."""
    rows = np.array(signal.reshape(len(signal), -1).T, dtype=float, order="C")
    rows_states = np.array(states.reshape(len(sections), 2, -1).transpose(2, 0, 1), order="C")
    filter_rows(sections, rows_states, rows)
    return rows.T.reshape(signal.shape), rows_states.transpose(1, 2, 0).reshape(states.shape)


def zero_phase(sections: Array, signal: Array, pad: int) -> Array:
    """A signal (n, ...) forward and backward through sections; see `zero_phase_parts`."""
    parts = zero_phase_parts(sections, lambda first, last: signal[first:last], len(signal), pad, len(signal))
    return np.ascontiguousarray(np.concatenate([*parts]))


def zero_phase_parts(
    sections: Array, read: Callable[[int, int], Array], count: int, pad: int, rows: int
) -> Iterator[Array]:
    """A signal of so many samples forward and backward through sections, ``rows`` samples at a time, to the bit as all
    at once: the states of both passes go from part to part.

    read: gives the samples (n, ...) from one to another. The signal is mirrored about its ends over ``pad`` < count
    samples. Both passes start as if the first value had stood for ever.
    """
    edges = [*range(0, count, rows), count]
    first, last, parts = read(0, pad + 1), read(count - pad - 1, count), len(edges) - 1
    before, after = 2.0 * first[:1] - first[:0:-1], 2.0 * last[-1:] - last[-2::-1]
    rest = at_rest(sections).reshape(-1, 2, *(1,) * (first.ndim - 1))

    def forward(k: int) -> tuple[Array, Array]:
        signal = read(edges[k], edges[k + 1])
        signal = np.concatenate([*[before] * (k == 0), signal, *[after] * (k == parts - 1)])
        return passed(sections, signal, ahead[k])

    def backward(k: int) -> tuple[Array, Array]:
        signal = result if k == parts - 1 else forward(k)[0]
        return passed(sections, signal[::-1], behind[k + 1])

    ahead = {0: rest * (2.0 * first[0] - first[-1])}
    for k in range(parts):
        result, ahead[k + 1] = forward(k)
    behind = {parts: rest * result[-1]}
    for k in range(parts - 1, 0, -1):
        behind[k] = backward(k)[1]
    for k in range(parts):
        yield backward(k)[0][::-1][pad * (k == 0) :][: edges[k + 1] - edges[k]]


@kernel
def filter_rows(sections: Array, state: Array, rows: Array) -> None:
    """Run sections (s, 5) over each of the rows (k, n), from states (k, s, 2) on, in place: the second direct form
    transposed."""
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            value = rows[k, i]
            for s in range(sections.shape[0]):
                result = sections[s, 0] * value + state[k, s, 0]
                state[k, s, 0] = sections[s, 1] * value - sections[s, 3] * result + state[k, s, 1]
                state[k, s, 1] = sections[s, 2] * value - sections[s, 4] * result
                value = result
            rows[k, i] = value
