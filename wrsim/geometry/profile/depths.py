"""From areas that a profile's section has lost, place by place, to a table of depths along its normals.

Areas stand at the middles of equal bins of the arclength of the *unworn* profile: what is gone there over the bin's
width [m], which is the depth where the profile is straight. So losses of one unworn profile add up: however many steps
of wear there were, the profile is built and smoothed once.

Smoothing is by a Gaussian that halves a wave of the cut-off's length: it keeps the sum to round-off and puts no
material back, as a smoothing spline does beside a groove. A depth e along the normals of a curve of curvature k takes
off the area e (1 + c k e / 2), c = 1 on rails and -1 on wheels. e follows from the area with the curvature smoothed
alike, so that it does not jump where the curvature does; one factor near 1 then makes the area off the whole profile
the one that was lost.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from scipy.ndimage import gaussian_filter1d

from wrsim.errors import InputError
from wrsim.geometry.profile.profile import Array, Profile
from wrsim.geometry.profile.wear import DepthTable, lengths_along

HALVING = sqrt(0.5 * np.log(2.0)) / np.pi
"""Standard deviation of the Gaussian over the wavelength that passes with half its amplitude."""
REACH = 6.0
"""Where it ends, over the deviation."""
PARTS = 5
"""Gauss points between two places, for areas."""


def bin_edges(profile: Profile, step: float) -> Array:
    """Edges (n + 1,) of equal bins of arclength, at most a step wide [m]."""
    return np.linspace(0.0, profile.length, int(np.ceil(profile.length / step)) + 1)


def smoothed_table(values: Array, width: float, cutoff: float) -> Array:
    """Values at places a width apart, smoothed; cutoff: wavelength that passes with half its amplitude [m]."""
    return np.asarray(gaussian_filter1d(values, HALVING * cutoff / width, mode="reflect", truncate=REACH))


def depths_of(profile: Profile, areas: Array, cutoff: float) -> DepthTable:
    """The table of depths that takes areas (n,) over bin widths off an unworn profile, smoothed.

    Raises InputError where the section is not thick enough: normals meet before so much is gone.
    """
    width = profile.length / areas.size
    middles = (np.arange(areas.size) + 0.5) * width
    sign = 1.0 if profile.kind == "rail" else -1.0
    smooth = smoothed_table(areas, width, cutoff)
    bend = sign * smoothed_table(profile.curvature(middles), width, cutoff)
    root = 1.0 + 2.0 * bend * smooth
    if not (root > 0.0).all():
        u = 1e3 * float(profile.at(middles[int(np.argmin(root))])[0])
        raise InputError(
            f"the removed material makes the profile overlap itself at u = {u:.4g} mm; allowed: less depth"
        )
    table = DepthTable(
        np.asarray(middles - float(profile.arclength_of(0.0))),
        np.asarray(2.0 * smooth / (1.0 + np.sqrt(root)), dtype=float),
    )
    plain, bent = _area_off(profile, table)
    if not plain > 0.0:
        return table
    lost = float(areas.sum()) * width
    factor = 2.0 * lost / (plain + sqrt(max(plain**2 + 4.0 * bent * lost, 0.0)))
    return DepthTable(table.places, factor * table.depths)


def on_unworn(profile: Profile, table: DepthTable | None, length: float, lost: Array, count: int) -> Array:
    """Areas (count,) by bins of the unworn profile from those (n,) by equal bins of the worn one; their sum stays.

    table: what wore it so far, if anything; length: of the worn profile; areas over bin widths [m].
    """
    edges = np.linspace(0.0, profile.length, count + 1)
    places = edges if table is None else lengths_along(profile, [table], edges)
    places = places * (length / places[-1])
    own = np.linspace(0.0, length, lost.size + 1)
    gone = np.concatenate([[0.0], np.cumsum(lost * (own[1] - own[0]))])
    return np.diff(np.interp(places, own, gone)) / (edges[1] - edges[0])


def area_off(profile: Profile, table: DepthTable) -> float:
    """Area of the section that a table takes off a profile [m2]."""
    return sum(_area_off(profile, table))


def _area_off(profile: Profile, table: DepthTable) -> tuple[float, float]:
    """Integrals of the depth and of c k e^2 / 2 over the arclength [m2]."""
    x, weight = np.polynomial.legendre.leggauss(PARTS)
    # the curvature jumps at nodes, the spline changes at places
    origin = float(profile.arclength_of(0.0))
    edges = np.unique(np.concatenate([profile.arclength, np.clip(table.places + origin, 0.0, profile.length)]))
    half = 0.5 * np.diff(edges)
    L = (0.5 * (edges[1:] + edges[:-1]) + np.multiply.outer(x, half)).ravel()
    own = np.multiply.outer(weight, half).ravel()
    depth = table.at(L - origin)[0]
    sign = 1.0 if profile.kind == "rail" else -1.0
    return float((own * depth).sum()), float((own * 0.5 * sign * profile.curvature(L) * depth**2).sum())
