"""Area, peak and edges of a pressure field, better than by counting elements.

Near its edge a pressure rises with the root of the distance, so p^2 extrapolated linearly from the two outermost
elements of a row vanishes at the edge, within the two elements' width.
"""

from typing import NamedTuple

from wrsim.core.jit.arena import Array
from wrsim.core.jit.compiling import kernel


class Figures(NamedTuple):
    """Of a pressure field: area [m2], largest pressure [Pa], sum of p dA [N], length of the longest row [m]."""

    area: float
    p0: float
    force: float
    length: float


@kernel
def measure(p: Array, dx: float, ds: float, starts: Array, ends: Array) -> Figures:
    """Figures of the pressures p (rows, columns) on elements dx x ds.

    Writes the edges of every row's longest run, in elements from the first column's outer side, zero without contact.
    """
    columns = p.shape[1]
    area = 0.0
    p0 = 0.0
    force = 0.0
    longest = 0.0
    for j in range(p.shape[0]):
        starts[j] = 0.0
        ends[j] = 0.0
        i = 0
        while i < columns:
            if p[j, i] <= 0.0:
                i += 1
                continue
            first = i
            while i < columns and p[j, i] > 0.0:
                force += p[j, i]
                p0 = max(p0, p[j, i])
                i += 1
            last = i - 1
            start = first + 0.5 - _to_edge(p[j, first], p[j, min(first + 1, last)])
            end = last + 0.5 + _to_edge(p[j, last], p[j, max(last - 1, first)])
            area += end - start
            if end - start > ends[j] - starts[j]:
                starts[j] = start
                ends[j] = end
        longest = max(longest, ends[j] - starts[j])
    return Figures(area * dx * ds, p0, force * dx * ds, longest * dx)


@kernel
def _to_edge(outer: float, inner: float) -> float:
    """Distance from the outermost centre to the edge, in elements."""
    rise = inner * inner - outer * outer
    if rise <= 0.0:
        return 0.5
    return min(outer * outer / rise, 1.0)
