"""Contacts that grow together: one patch with several lobes, without jumps.

Two places of deepest penetration may be far apart (tread and flange), share one patch (their virtual penetrations
overlap), or be about to become one. A rule that treats them as two patches until they meet and as one patch with one
main point from then on makes the force jump, and so does a change of the main point. Here every place keeps strips,
main point and pressure amplitude of its own, and the coupling c of a lobe to its deeper neighbour (search-coupling)
goes from 0 (apart) to 1 (one patch, one amplitude: the paper's) as the saddle between them vanishes.

c > 0 says exactly that the virtual penetrations (eps delta, [S 23]) overlap: such lobes are reported as one patch. A
deeper lobe is coupled back with the share that makes both equal when the two are equally deep and vanishes when the
shallower one does.
"""

from wrsim.jit import Records, inlined, kernel

WIDEST = 0.08  # half width at which the search for an edge is given up [m]
MIN_DISTANCE = 1e-7  # of a lobe beside its main point [m]


@kernel
def distance_to_saddles(contacts: Records, i: int, count: int) -> tuple[float, float]:
    """Distances from a lobe's main point to the saddles beside it, where its neighbours begin."""
    left = right = WIDEST
    if i > 0 and contacts[i - 1].saddle >= 0.0:
        left = max(contacts[i].arc_rail - contacts[i - 1].saddle_arc, MIN_DISTANCE)
    if i < count - 1 and contacts[i].saddle >= 0.0:
        right = max(contacts[i].saddle_arc - contacts[i].arc_rail, MIN_DISTANCE)
    return left, right


@kernel
def select_deepest(contacts: Records, count: int, most: int) -> int:
    """Keep the ``most`` deepest of the contacts, in their order along the profile; saddles are carried over. Returns
    their number."""
    while count > most:
        least = 0
        for i in range(1, count):
            if contacts[i].depth < contacts[least].depth:
                least = i
        if least > 0:
            before, after = contacts[least - 1], contacts[least]
            if least == count - 1 or after.saddle < 0.0:
                before.saddle = -1.0
            elif before.saddle >= 0.0 and after.saddle < before.saddle:
                before.saddle = after.saddle
                before.saddle_arc = after.saddle_arc
        for i in range(least, count - 1):
            contacts[i] = contacts[i + 1]
        count -= 1
    return count


@kernel
def couple(contacts: Records, count: int, eps: float, lobes: Records) -> None:
    """Write the coupling of each lobe, 0 .. 1, and the partner that it is coupled to, -1 where there is none."""
    for i in range(count):
        lobe = lobes[i]
        lobe.partner = -1
        lobe.coupling = 0.0
        depth = contacts[i].depth
        saddle = -1.0
        # the deeper lobe over the higher saddle, on the one side and on the other
        for direction in range(2):
            low = 1.0
            j = i
            while True:
                edge = j if direction == 1 else j - 1
                if edge < 0 or edge >= count - 1 or contacts[edge].saddle < 0.0:
                    break
                low = min(low, contacts[edge].saddle)
                j = j + 1 if direction == 1 else j - 1
                if contacts[j].depth > depth or (contacts[j].depth == depth and j < i):
                    if low > saddle:
                        saddle = low
                        lobe.partner = j
                    break
        if lobe.partner >= 0:
            lobe.coupling = _share(depth, saddle, eps)
    for i in range(count):
        lobe = lobes[i]
        if lobe.partner >= 0:
            continue
        # the deepest lobe is coupled back to the deepest of those that couple to it
        best = _deepest_of(i, contacts, count, lobes)
        if best >= 0:
            back = lobes[best].coupling
            depth = contacts[i].depth
            saddle = contacts[best].depth * (1.0 - eps * (1.0 - back))
            share = (depth - saddle) / (eps * depth)
            ratio = (1.0 - back) / share if share > 0.0 else 1.0
            lobe.coupling = _share(depth, saddle, eps) * min(ratio, 1.0)
    # written last: the deepest must not look coupled while the others are judged
    for i in range(count):
        if lobes[i].partner < 0 and lobes[i].coupling > 0.0:
            lobes[i].partner = _deepest_of(i, contacts, count, lobes)


@kernel
def _deepest_of(i: int, contacts: Records, count: int, lobes: Records) -> int:
    """The deepest of the lobes that couple to lobe i, or -1."""
    best = -1
    for j in range(count):
        if lobes[j].partner == i and lobes[j].coupling > 0.0 and (best < 0 or contacts[j].depth > contacts[best].depth):
            best = j
    return best


@inlined
def _share(depth: float, saddle: float, eps: float) -> float:
    """The coupling (search-coupling): 1 where the saddle reaches the lobe's top, 0 below its virtual penetration."""
    return min(max(1.0 - (depth - saddle) / (eps * depth), 0.0), 1.0)
