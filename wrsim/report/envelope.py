"""Histories thinned out so that no peak is lost: the least and the largest value of every piece of track."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PIECES = 400
"""Pieces that a history is cut into; each gives two points."""


def pieces_of(places: list[Array]) -> Array:
    """Ends (n + 1,) of equal pieces over all places, never shorter than two samples of the longest row."""
    low, high = min(float(p.min()) for p in places), max(float(p.max()) for p in places)
    count = min(PIECES, max(max(p.size for p in places) // 2, 1))
    return np.linspace(low, high if high > low else low + 1e-9, count + 1)


def points_of(pieces: Array) -> Array:
    """Abscissae (2 n,) of the two points of every piece: at a quarter and at three quarters of it."""
    width = np.diff(pieces)
    return np.stack((pieces[:-1] + 0.25 * width, pieces[:-1] + 0.75 * width), axis=1).ravel()


def envelope(places: Array, values: Array, pieces: Array) -> Array:
    """Least and largest value (2 n,) of every piece, in the order in which a rise or a fall meets them.

    places, values: (samples,), places in any order. A piece without a sample takes the value between its neighbours;
    outside of the samples, and where a piece holds nothing but not-a-number, there is none.
    """
    order = np.argsort(places, kind="stable")
    at, of = places[order], values[order]
    own = np.clip(np.searchsorted(pieces, at, side="right") - 1, 0, pieces.size - 2)
    starts = np.searchsorted(own, np.arange(pieces.size - 1))
    counts = np.diff(np.append(starts, at.size))
    found = np.full((pieces.size - 1, 2), np.nan)
    full = counts > 0
    low, high = (f.reduceat(of, starts[full]) for f in (np.fmin, np.fmax))
    falls = of[starts[full]] > of[starts[full] + counts[full] - 1]
    found[full] = np.where(falls[:, None], np.stack((high, low), 1), np.stack((low, high), 1))
    if not full.all():
        middles = 0.5 * (pieces[:-1] + pieces[1:])[~full]
        found[~full] = np.interp(middles, at, of, left=np.nan, right=np.nan)[:, None]
    return found.ravel()
