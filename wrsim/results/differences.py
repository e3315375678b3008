"""Two results side by side: peaks, medians in full curves, and other numbers of their summaries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.results.channels import PATCHES
from wrsim.results.result import Result
from wrsim.results.table import Column, Table, quantity

LEFT_OUT = ("title", "analysis", "status", "stop", "versions", "integration", "extent", "events")
"""Parts of a summary that are no quantities."""
PLACES = ("distance_m", "time_s", "pose", "from_m", "to_m")
"""Where something is."""
LISTED = 20
"""Differences that are listed for people."""
SMALLEST = 1e-6
"""Values below this, in their unit for readers, count as zero."""


@dataclass(frozen=True)
class Deviation:
    """One number of two results; None where one of them does not have it.

    place: wheelset, wheel, curve; quantity: with its unit at the end; scale: the largest magnitude of that quantity
    anywhere in both results, which differences are measured by: a force that is near zero on one wheel is not judged
    by itself.
    """

    place: str
    quantity: str
    first: float | None
    second: float | None
    scale: float

    @property
    def absolute(self) -> float:
        """Second minus first; infinite where one is missing."""
        if self.first is None or self.second is None:
            return 0.0 if self.first is self.second else math.inf
        return self.second - self.first

    @property
    def relative(self) -> float:
        """Magnitude of the difference over the scale."""
        return abs(self.absolute) / self.scale


def differences(first: Result, second: Result, only: Sequence[str] = (), tolerance: float = 0.0) -> list[Deviation]:
    """All numbers of the summaries of two results of one kind, the largest relative difference first.

    only: quantities, with or without the unit at the end. Raises ``InputError`` for results of two kinds of analysis,
    for a quantity that neither has, and for a tolerance that is none.
    """
    if not 0.0 <= tolerance < math.inf:
        raise InputError(f"--tolerance {tolerance:g}: must be a number not below 0, such as 0.01 for 1 %")
    if first.analysis != second.analysis:
        raise InputError(
            f'cannot compare analysis = "{first.analysis}" with "{second.analysis}": both must be of one kind'
        )
    one, other = (dict(_numbers(result.summary())) for result in (first, second))
    keys = list(dict.fromkeys((*one, *other)))
    names = list(dict.fromkeys(quantity for _, quantity in keys))
    for asked in only:
        if not any(_is_asked(name, asked) for name in names):
            raise InputError(
                f"--only {asked}: neither result has it{suggest(asked, names)}; there is {', '.join(names)}"
            )
    if only:
        keys = [key for key in keys if any(_is_asked(key[1], asked) for asked in only)]
    scales: dict[str, float] = {}
    for key in keys:
        scales[key[1]] = max(scales.get(key[1], SMALLEST), *(abs(values.get(key) or 0.0) for values in (one, other)))
    found = [Deviation(p, q, one.get((p, q)), other.get((p, q)), scales[q]) for p, q in keys]
    return sorted(found, key=lambda d: -d.relative)


def difference_table(found: Sequence[Deviation]) -> Table:
    """A row a number; differences without one of the numbers are missing."""
    heads = (
        Column("place", key="place"), Column("quantity", key="quantity"),
        Column("A", "", ".5g", "a"), Column("B", "", ".5g", "b"),
        Column("B - A", "", ".3g", "difference"), Column("part of largest", "", ".2g", "relative"),
    )  # fmt: skip
    both = [(d, (d.absolute, d.relative) if math.isfinite(d.absolute) else (None, None)) for d in found]
    return Table("", heads, [(d.place, d.quantity, d.first, d.second, *numbers) for d, numbers in both])


def beyond(found: Sequence[Deviation], tolerance: float) -> list[Deviation]:
    """Differences above a part of the largest value."""
    return [d for d in found if d.relative > tolerance]


def other_ends(one: Result, other: Result) -> list[str]:
    """How the two ended, where they did not end alike."""
    if one.status == other.status:
        return []
    ends = (("A", one), ("B", other))
    return [f"{name}: {r.status}" + (f": {r.stop_reason}" if r.stop_reason else "") for name, r in ends]


def compared_tables(
    found: Sequence[Deviation], ends: Sequence[str], tolerance: float, names: Sequence[str]
) -> list[Table]:
    """What is beyond the tolerance, or the largest differences where nothing is; the verdict."""
    wrong, percent = beyond(found, tolerance), quantity(100.0 * tolerance, "%", "g")
    listed = (wrong or [d for d in found if d.relative > 0.0])[:LISTED]
    more = [f"... and {len(wrong) - LISTED} more; --json lists all"] if len(wrong) > LISTED else []
    if wrong:
        verdict = f"{len(wrong)} of {len(found)} numbers differ by more than {percent}"
    elif ends:
        verdict = "the numbers are alike, the ends are not"
    else:
        verdict = f"alike: {len(found)} numbers, none differs by more than {percent}"
    head = Table("", notes=tuple(f"{letter}: {name}" for letter, name in zip("AB", names, strict=True)))
    return [head, *([difference_table(listed)] if listed else []), Table("", notes=(*more, *ends, verdict))]


def _is_asked(name: str, asked: str) -> bool:
    return name == asked or name.startswith(f"{asked}_")


def _numbers(tree: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, str], float | None]]:
    """Every number of a summary by its place and its quantity; a peak counts as its value."""
    for key, value in tree.items():
        if (not place and key in LEFT_OUT) or key in PLACES:
            continue
        if isinstance(value, Mapping) and "value" in value:
            value = value["value"]
        if isinstance(value, Mapping):
            yield from _numbers(value, place if key in ("wheelsets", "wheels", "points") else (*place, str(key)))
        elif isinstance(value, list):
            for i, entry in enumerate(value):
                if isinstance(entry, Mapping):
                    yield from _numbers(entry, (*place, _name(entry, key, i)))
        elif value is None or (isinstance(value, int | float) and not isinstance(value, bool)):
            yield (" ".join(place), str(key)), None if value is None else float(value)


def _name(entry: Mapping[str, Any], key: str, index: int) -> str:
    """What an entry of a list is called."""
    if "radius_m" in entry:
        return f"curve {index + 1} (R {entry['radius_m']:.0f} m)"
    return f"{PATCHES[index]} patch" if key == "patches" else f"{key}[{index}]"
