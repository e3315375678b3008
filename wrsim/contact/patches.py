"""Quantities of patches from the kernel's records: which lobes make which patch.

Raw arrays are stacked over samples and wheels, one row per lobe. Lobes that share a patch (contact.search.lobes)
are joined here: forces and areas add up, extremes are taken over all, the main point is that of the deepest lobe.
Patches are put in the order of their normal force, largest first; absent ones become not-a-number.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wrsim.contact import records as k
from wrsim.contact.contact_angle import mean_contact_angle
from wrsim.contact.workspace import KernelArrays
from wrsim.jit import Array, Records

_SUMS = {"N": "N", "Fx": "Fx", "Fy": "Fy", "area": "area", "n_strips": "n_strips"}
_LARGEST = {"p0": "p0", "contact_angle_max": "angle_max", "length": "length", "temperature": "temperature"}
_OF_MAIN = {"contact_angle": "angle", "approach": "approach", "xi": "xi", "eta": "eta", "phi": "phi", "x_contact": "x"}

NO_CONTACT = tuple(np.nan if k.TOTAL[name].kind == "f" else 0 for name in k.TOTAL.names)


@dataclass(frozen=True)
class RawContacts:
    """Copies of the kernel's results over samples: LOBE records (S, W, P) and TOTAL records (S, W)."""

    patches: Records
    totals: Records

    @classmethod
    def empty(cls, samples: int, wheels: int, patches: int) -> "RawContacts":
        return cls(np.zeros((samples, wheels, patches), k.LOBE), np.zeros((samples, wheels), k.TOTAL))

    def store(self, sample: int, wheel: int, arrays: KernelArrays) -> None:
        """Copy what the kernel computed last."""
        self.patches[sample, wheel] = arrays.patches
        self.totals[sample, wheel] = arrays.total

    def clear(self, sample: int) -> None:
        """Nothing was found at this sample."""
        self.patches[sample] = np.zeros((), k.LOBE)
        self.totals[sample] = NO_CONTACT

    def first(self, samples: int) -> "RawContacts":
        return RawContacts(self.patches[:samples], self.totals[:samples])

    def used(self) -> "RawContacts":
        """Without the rooms for lobes that are empty in all samples: most wheels have one or two."""
        return RawContacts(self.patches[:, :, : max(1, int(self.totals["lobes"].max(initial=0)))], self.totals)


class PatchesOf(NamedTuple):
    """Which lobes make which patch: member (S, W, patch, lobe), main lobe (S, W, patch), present (S, W, patch)."""

    member: NDArray[np.bool_]
    main: NDArray[np.intp]
    present: NDArray[np.bool_]


def patches_of(raw: RawContacts) -> PatchesOf:
    """Lobes by patch, patches in the order of their normal force."""
    lobes = raw.patches.shape[2]
    loaded = (np.arange(lobes) < raw.totals["lobes"][..., None]) & (raw.patches["N"] > 0.0)
    group = np.where(loaded, raw.patches["group"], -1.0)
    member = group[..., None, :] == np.arange(lobes)[:, None]
    force = np.where(member, raw.patches["N"][..., None, :], 0.0).sum(axis=-1)
    order = np.argsort(-force, axis=-1, kind="stable")
    member = np.take_along_axis(member, order[..., None], axis=2)
    depth = np.where(member, raw.patches["approach"][..., None, :], -1.0)
    return PatchesOf(member, depth.argmax(axis=-1), np.any(member, axis=-1))


def patch_channels(raw: RawContacts) -> dict[str, Array]:
    """Channels (sample, wheel, patch) that need no more than the kernel's results; not-a-number without a patch."""
    p, _main, channels = patches_with_main(raw)
    return {name: where_present(p, values, raw.patches.shape[2]) for name, values in channels.items()}


def patches_with_main(raw: RawContacts) -> tuple[PatchesOf, Records, dict[str, Array]]:
    """Patches, their main lobes' records (S, W, patch) and their channels, any number where there is none."""
    used = raw.used()
    p = patches_of(used)
    main = np.take_along_axis(used.patches, p.main, axis=2)
    return p, main, _of_patches(used, p, main)


def where_present(p: PatchesOf, values: Array, count: int) -> Array:
    """Values of patches (S, W, patch), and not-a-number where there is none, for so many patches."""
    out = np.full((*values.shape[:2], count), np.nan)
    np.copyto(out[:, :, : values.shape[2]], values, where=p.present)
    return out


def _joined(p: PatchesOf, values: Array, join: Callable[[Array, Array], Array] = np.add, none: float = 0.0) -> Array:
    """Values of lobes (S, W, lobe), joined to those of their patches (S, W, patch); none: of those of other patches."""
    of_patch = (np.where(p.member[..., i], values[:, :, i, None], none) for i in range(values.shape[2]))
    return reduce(join, of_patch, np.full((), none))


def _over(raw: RawContacts, p: PatchesOf, name: str) -> Array:
    """Values of every lobe, seen from every patch: (S, W, patch, lobe)."""
    return np.broadcast_to(raw.patches[name][..., None, :], p.member.shape)


def _of_patches(raw: RawContacts, p: PatchesOf, main: Records) -> dict[str, Array]:
    """Channels (sample, wheel, patch) of patches, of which main lobes are given, and any number where there is none."""
    over, lobes = partial(_over, raw, p), raw.patches
    channels = {name: _joined(p, lobes[c]) for name, c in _SUMS.items()}
    channels |= {name: _joined(p, lobes[c], np.maximum, -np.inf) for name, c in _LARGEST.items()}
    channels |= {name: main[c] for name, c in _OF_MAIN.items()}
    channels["contact_angle_min"] = _joined(p, lobes["angle_min"], np.minimum, np.inf)
    channels["contact_angle_mean"] = mean_contact_angle(over("angle_mean"), np.where(p.member, over("N"), 0.0))
    place = lobes["arc_rail"]
    ends = _joined(p, place + lobes["end"], np.maximum, -np.inf)
    starts = _joined(p, place + lobes["start"], np.minimum, np.inf)
    channels["width"] = np.where(p.present, ends, 0.0) - np.where(p.present, starts, 0.0)
    # moments of the lobes about their own main points, brought to the patch's one
    lever_s = over("arc_rail") - main["arc_rail"][..., None]
    lever_x = over("x") - main["x"][..., None]
    moments = over("Mz") + lever_x * over("Fy") - lever_s * over("Fx")
    channels["spin_moment"] = np.where(p.member, moments, 0.0).sum(axis=-1, initial=0.0)  # never -0
    return channels


def patch_wear_numbers(raw: RawContacts) -> Array:
    """T-gamma of every patch [N], (sample, wheel, patch); not-a-number where there is none."""
    p = patches_of(used := raw.used())
    return where_present(p, _joined(p, used.patches["wear"]), raw.patches.shape[2])
