"""Pressures of all lobes of a wheel by the strip model: sums, damping, and what the lobes report."""

from math import pi

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    AMPLITUDE,
    ARC_RAIL,
    AREA,
    CLOSING,
    DAMPING,
    DS,
    END,
    FORCE,
    LENGTH,
    MODULUS,
    N_STRIPS,
    P0,
    START,
    STATUS_UNSETTLED,
    WARM,
    WARM_ARC,
    WARM_STRIPS,
    WIDTH,
    A,
    N,
    P,
    S,
)
from wrsim.core.contact.resultants import set_creepages
from wrsim.core.contact.strips.layout import VECTORS
from wrsim.core.contact.strips.model import strip_model

WARM_REACH = 1e-3  # how far a main point may have moved for the last contact to be a first guess [m]
NEARLY = 1e-4  # misfit over the penetration that the strip model may end with


@kernel
def press_strips(settings, pose, patches, strips, count, vectors, matrices):
    """Pressures of all strips from their own contact conditions (`strips.model`), with damping. Returns a status."""
    for i in range(count):
        if abs(patches[i, ARC_RAIL] - patches[i, WARM_ARC]) > WARM_REACH:
            patches[i, WARM_STRIPS] = 0.0
        patches[i, WARM_ARC] = patches[i, ARC_RAIL]
    iterations, misfit = strip_model(
        patches, strips, count, settings[MODULUS], pose, settings[WARM], vectors, vectors[VECTORS + 1 :], matrices,
        vectors[VECTORS],
    )  # fmt: skip
    for i in range(count):
        lobe = patches[i]
        n = int(lobe[N_STRIPS])
        set_creepages(pose, settings, lobe, strips[i], n)
        factor = max(1.0 + settings[DAMPING] * lobe[CLOSING], 0.0)
        largest = normal = area = longest = 0.0
        for j in range(n):
            row = strips[i, j]
            a = row[A]
            row[FORCE] = 0.5 * pi * row[P] * factor * a * a * row[DS]
            row[P] *= factor * a
            largest = max(largest, row[P])
            normal += row[FORCE]
            area += 2.0 * a * row[DS]
            longest = max(longest, a)
        lobe[P0] = largest
        lobe[N] = normal
        lobe[START] = strips[i, 0, S] - 0.5 * strips[i, 0, DS] if n > 0 else 0.0
        lobe[END] = strips[i, n - 1, S] + 0.5 * strips[i, 0, DS] if n > 0 else 0.0
        lobe[WIDTH] = lobe[END] - lobe[START]
        lobe[AREA] = area
        lobe[LENGTH] = 2.0 * longest
        lobe[AMPLITUDE] = largest / longest if longest > 0.0 else 0.0
    return STATUS_UNSETTLED if iterations < 0 and misfit > NEARLY else 0
