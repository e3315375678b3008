"""Channels of the stresses below a patch: extremes, a section along and one across through the largest von Mises
stress, and the line below it."""

from collections.abc import Sequence

import numpy as np

from wrsim.contact.subsurface.fatigue import FatigueLimits, passage
from wrsim.contact.subsurface.loads import SurfaceLoads
from wrsim.jit import Array

ALONG, ACROSS, DOWN = 51, 31, 25  # points of the sections
DEEPEST = 2.0  # of a section, over the size of the patch
SHALLOWEST = 0.02  # first depth, over the size: in the surface, stress at the edge of an element is infinite

Values = dict[str, Array]


def sections(loads: SurfaceLoads, limits: FatigueLimits | None = None) -> Values:
    """Channels of one patch; with limits, fatigue of the points of the section across."""
    mises, tresca = loads.extreme(), loads.extreme("tresca")
    margin = 0.5 * loads.size
    ends = (loads.patch[0], ALONG), (loads.patch[1], ACROSS)
    x, s = (np.linspace(low - margin, high + margin, n) for (low, high), n in ends)
    z = loads.size * (SHALLOWEST + DEEPEST * np.linspace(0.0, 1.0, DOWN) ** 1.5)
    below = loads.stress(mises.x, mises.s, z)
    values = {
        f"{name}_{'max' if field == 'value' else field}": np.asarray(value)
        for name, extreme in (("von_mises", mises), ("tresca", tresca))
        for field, value in extreme._asdict().items()
    }
    values |= {"section_x": x, "section_s": s, "section_depth": z}
    values |= {
        "von_mises_along": loads.stress(x, mises.s, z[:, None]).von_mises,
        "von_mises_across": loads.stress(mises.x, s, z[:, None]).von_mises,
        "von_mises_below": below.von_mises,
        "tresca_below": below.tresca,
    }
    values |= {f"principal_{i + 1}_below": below.principal[..., i] for i in range(3)}
    if limits is not None:
        by = passage(loads, s, z[:, None], limits)
        for name, field in by._asdict().items():
            i, j = np.unravel_index(int(field.argmax()), field.shape)
            values |= {f"{name}_across": field, f"{name}_max": np.asarray(field[i, j]), f"{name}_depth": z[i]}
    return values


def subsurface_channels(moments: Sequence[Sequence[Sequence[Values]]], wheels: int, patches: int) -> dict[str, Array]:
    """Channels (moment, wheel, patch, ...) of `sections` of the patches of wheels at moments."""
    first = next((patch for moment in moments for wheel in moment for patch in wheel), {})
    shape = (len(moments), wheels, patches)
    channels = {name: np.full((*shape, *np.shape(value)), np.nan) for name, value in first.items()}
    for m, moment in enumerate(moments):
        for w, wheel in enumerate(moment):
            for p, values in enumerate(wheel[:patches]):
                for name, value in values.items():
                    channels[name][m, w, p] = value
    return channels
