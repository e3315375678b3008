"""A lobe in Kik and Piotrowski's contact: its edges and its strips."""

from math import ceil

from wrsim.core.compiling import kernel
from wrsim.core.contact.patch import find_edge, first_step, lay_strips
from wrsim.core.contact.records import STATUS_PROFILE_END


@kernel
def bound_lobe(wheel, rail, settings, found, i, left, right, lobes):
    """Recess and edges of lobe i, at most ``left`` and ``right`` of the main point.

    Returns status bits; without contact the width is zero.
    """
    lobe, own = lobes[i], found[i]
    delta = level = own.depth
    if settings.joint and lobe.partner >= 0 and found[lobe.partner].depth > delta:
        level += lobe.coupling * (found[lobe.partner].depth - delta)
    lobe.recess = settings.recess * level
    if delta <= lobe.recess:
        return 0
    first = first_step(delta - lobe.recess, own.curvature)
    lobe.end, beyond = find_edge(wheel, rail, lobe, settings.projected, first, 1.0, right)
    lobe.start, before = find_edge(wheel, rail, lobe, settings.projected, first, -1.0, left)
    lobe.width = lobe.end - lobe.start
    return STATUS_PROFILE_END if beyond or before else 0


@kernel
def lay_lobe(wheel, rail, settings, lobes, count, i, strips):
    """Strips of one lobe: by their width, or by their number.

    Where the model's patches are joint the lobes of a patch share the number by their widths; else every lobe has all
    of them, because its forces would jump, if slightly, with their number.
    """
    lobe = lobes[i]
    if lobe.width <= 0.0:
        return
    if settings.strip_width > 0.0:
        n = int(ceil(lobe.width / settings.strip_width))  # noqa: RUF046 (a float in compiled code)
    elif settings.joint:
        width = 0.0
        for j in range(count):
            if lobes[j].group == lobe.group:
                width += lobes[j].width
        n = int(ceil(settings.strips * lobe.width / width - 1e-9))  # noqa: RUF046
    else:
        n = settings.strips
    n = min(max(n, settings.fewest), strips.shape[0])
    lobe.half_length = lay_strips(wheel, rail, lobe, settings.projected, n, strips)
    lobe.n_strips = n
    # the main point lies within its strip: its coordinates follow along the strip's tangent
    main = min(max(int(-lobe.start / (lobe.width / n)), 0), n - 1)
    strip = strips[main]
    other = strips[main - 1] if main > 0 else strips[main + 1]
    lobe.x = strip.x - strip.s * (strip.x - other.x) / (strip.s - other.s)
    lobe.o = strip.o - strip.s * strip.nb
    lobe.b = strip.b + strip.s * strip.no
