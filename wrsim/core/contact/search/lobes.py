"""Contacts that grow together: one patch with several lobes, without jumps.

Two places of deepest penetration may be far apart (tread and flange), share one patch (their virtual penetrations
overlap), or be about to become one. A rule that treats them as two patches until they meet and as one patch with one
main point from then on makes the force jump, and so does a change of the main point. Here every place keeps strips,
main point and pressure amplitude of its own, and the coupling c of a lobe to its deeper neighbour goes from 0 (apart)
to 1 (one patch, one amplitude: the paper's) as the saddle between them vanishes:

    c = 1 - (delta - sigma) / (eps delta), kept within 0 .. 1,

delta the lobe's penetration, sigma the penetration at the saddle. c > 0 says exactly that the virtual penetrations
(eps delta, [S 23]) overlap: such lobes are reported as one patch. A deeper lobe is coupled back with the share that
makes both equal when the two are equally deep and vanishes when the shallower one does.
"""

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.search.points import DEPTH, SADDLE_DEPTH


@kernel
def select_deepest(found, count, most):
    """Keep the ``most`` deepest of the contacts, in their order along the profile; saddles are carried over.

    Returns their number.
    """
    while count > most:
        least = 0
        for i in range(1, count):
            if found[i, DEPTH] < found[least, DEPTH]:
                least = i
        if least > 0:
            if least == count - 1 or found[least, SADDLE_DEPTH] < 0.0:
                found[least - 1, SADDLE_DEPTH] = -1.0
            elif found[least - 1, SADDLE_DEPTH] >= 0.0 and (
                found[least, SADDLE_DEPTH] < found[least - 1, SADDLE_DEPTH]
            ):
                for c in range(4, found.shape[1]):
                    found[least - 1, c] = found[least, c]
        for i in range(least, count - 1):
            for c in range(found.shape[1]):
                found[i, c] = found[i + 1, c]
        count -= 1
    return count


@kernel
def couple(found, count, eps, coupling, partner):
    """Coupling of each lobe and the lobe it is coupled to.

    Writes coupling (count,), 0 .. 1, and partner (count,), as a float index, -1 where there is none.
    """
    for i in range(count):
        partner[i] = -1.0
        coupling[i] = 0.0
        depth = found[i, DEPTH]
        saddle = -1.0
        # the deeper lobe over the higher saddle, on the one side and on the other
        for direction in range(2):
            low = 1.0
            j = i
            while True:
                edge = j if direction == 1 else j - 1
                if edge < 0 or edge >= count - 1 or found[edge, SADDLE_DEPTH] < 0.0:
                    break
                low = min(low, found[edge, SADDLE_DEPTH])
                j = j + 1 if direction == 1 else j - 1
                if found[j, DEPTH] > depth or (found[j, DEPTH] == depth and j < i):
                    if low > saddle:
                        saddle = low
                        partner[i] = j
                    break
        if partner[i] >= 0.0:
            coupling[i] = _share(depth, saddle, eps)
    for i in range(count):
        if partner[i] >= 0.0:
            continue
        # the deepest lobe is coupled back to the deepest of those that couple to it
        best = -1
        for j in range(count):
            if int(partner[j]) == i and coupling[j] > 0.0 and (best < 0 or found[j, DEPTH] > found[best, DEPTH]):
                best = j
        if best >= 0:
            saddle = found[best, DEPTH] * (1.0 - eps * (1.0 - coupling[best]))
            own = (found[i, DEPTH] - saddle) / (eps * found[i, DEPTH])
            ratio = (1.0 - coupling[best]) / own if own > 0.0 else 1.0
            coupling[i] = _share(found[i, DEPTH], saddle, eps) * min(ratio, 1.0)
    # written last: the deepest must not look coupled while the others are judged
    for i in range(count):
        if partner[i] < 0.0 and coupling[i] > 0.0:
            for j in range(count):
                if int(partner[j]) == i and coupling[j] > 0.0:
                    k = int(partner[i])
                    if k < 0 or found[j, DEPTH] > found[k, DEPTH]:
                        partner[i] = j


@inlined
def _share(depth, saddle, eps):
    """1 where the saddle reaches the lobe's top, 0 where it has left its virtual penetration."""
    return min(max(1.0 - (depth - saddle) / (eps * depth), 0.0), 1.0)
