"""Two results side by side: peaks, medians in full curves, and other numbers of their summaries."""

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from wrsim.errors import InputError, suggest
from wrsim.inputs.changes import leaves
from wrsim.results.channels import PATCHES
from wrsim.results.result import Result
from wrsim.results.table import Column, Table, finite, join_names, percent, quantity
from wrsim.results.wheelsets import matched, wheelsets

LEFT_OUT = ("title", "analysis", "status", "stop", "versions", "integration", "extent", "events")
"""Parts of a summary that are no quantities."""
PLACES = ("distance_m", "time_s", "pose", "from_m", "to_m", "radius_m")  # where something is, and in which curve
LISTED = 20  # differences that are listed for people
MOST_PLACES = 6  # that are named of those that only one result has
SMALLEST = 1e-6  # values below this, in their unit for readers, count as zero


class Deviation(NamedTuple):
    """One number of two results; None where one of them does not have it. place: wheelset, wheel, curve; quantity: with
    its unit at the end; absolute: second minus first, infinite where one is missing; relative: its magnitude over the
    largest magnitude of the quantity anywhere in both results, of an energy over the largest of its balance; change: in
    percent of the first (`percent`)."""

    place: str
    quantity: str
    first: float | None
    second: float | None
    absolute: float
    relative: float
    change: float | None


def differences(first: Result, second: Result, only: Sequence[str] = (), tolerance: float = 0.0) -> list[Deviation]:
    """All numbers of the summaries of two results of one kind, the largest relative difference first. only: quantities,
    with or without the unit at the end. Raises ``InputError`` for results of two kinds of analysis, for a quantity that
    neither has, and for a tolerance that is none."""
    if not 0.0 <= tolerance < math.inf:
        raise InputError(f"--tolerance {tolerance:g}: must be a number not below 0, such as 0.01 for 1 %")
    if first.analysis != second.analysis:
        raise InputError(
            f'cannot compare analysis = "{first.analysis}" with "{second.analysis}": both must be of one kind'
        )
    same = Result(matched(second.dataset, first.dataset))
    reference, compared = (dict(_numbers(result.summary())) for result in (first, same))
    keys = list(dict.fromkeys((*reference, *compared)))
    names = list(dict.fromkeys(name for _, name in keys))
    chosen = set() if only else set(names)
    for asked in only:
        found_names = {name for name in names if name == asked or name.startswith(f"{asked}_")}
        if not found_names:
            raise InputError(
                f"--only {asked}: neither result has it{suggest(asked, names)}; there is {', '.join(names)}"
            )
        chosen |= found_names
    keys = [key for key in keys if key[1] in chosen]
    scales: dict[str, float] = {}
    for key in keys:
        numbers = (abs(values.get(key) or 0.0) for values in (reference, compared))
        scales[_scale(key)] = max(scales.get(_scale(key), SMALLEST), *numbers)
    diffs = []
    for key in keys:
        a, b = reference.get(key), compared.get(key)
        off = (0.0 if a is b else math.inf) if a is None or b is None else b - a
        scale = scales[_scale(key)]
        diffs.append(Deviation(*key, a, b, off, abs(off) / scale, percent(a, b, tolerance * scale)))
    return sorted(diffs, key=lambda d: -d.relative)


def _scale(key: tuple[str, str]) -> str:
    """What a number is measured against: its quantity, or the balance it is a part of."""
    return key[0] if key[0] == "energy" else key[1]


def inputs_apart(reference: Result, compared: Result, letters: Sequence[str] = "AB") -> list[str]:
    """Keys of the two scenarios whose values differ, and wheelsets that are matched under other names."""
    texts = [str(result.dataset.attrs.get("scenario_text", "")) for result in (reference, compared)]
    try:
        trees = [tomllib.loads(text) for text in texts]
    except tomllib.TOMLDecodeError:  # of another author
        return ["the scenario of one of the results is no TOML: its keys are not compared"]
    first, second = ({key: value for key, value in leaves(tree, lists=False) if value != {}} for tree in trees)
    keys = [key for key in dict.fromkeys((*first, *second)) if first.get(key) != second.get(key) and key != "title"]
    a, b, none = *letters, "not given"
    changed = [f"{key}: {first.get(key, none)} in {a}, {second.get(key, none)} in {b}" for key in keys]
    names = [wheelsets(result.dataset) for result in (reference, compared)]
    if names[0] != names[1]:
        changed.append(f"wheelsets are matched from the front: {', '.join(names[0])} and {', '.join(names[1])}")
    return [*changed[:LISTED], *([f"... and {len(changed) - LISTED} more keys"] if len(changed) > LISTED else [])]


def difference_table(
    diffs: Sequence[Deviation], letters: Sequence[str] = "AB", title: str = "", notes: Sequence[str] = ()
) -> Table:
    """A row a number; differences without one of the numbers are missing."""
    first, second = letters
    heads = (
        Column("place", key="place"), Column("quantity", key="quantity"),
        Column(first, "", ".5g", "a"), Column(second, "", ".5g", "b"),
        Column(f"{second} - {first}", "", ".4g", "difference"), Column("change", "%", ".3g", "change_percent"),
        Column("part of largest", "", ".2g", "relative"),
    )  # fmt: skip
    rows = [(d.place, d.quantity, d.first, d.second, finite(d.absolute), d.change, finite(d.relative)) for d in diffs]
    return Table(title, heads, rows, tuple(notes))


def beyond(diffs: Sequence[Deviation], tolerance: float) -> list[Deviation]:
    """Differences above a part of the largest value."""
    return [d for d in diffs if d.relative > tolerance]


def one_sided(diffs: Sequence[Deviation], letters: Sequence[str] = "AB") -> tuple[list[Deviation], list[str]]:
    """The differences of what both results have, and in a sentence each what only one of them has."""
    common = [d for d in diffs if math.isfinite(d.absolute)]
    texts = []
    for letter, field in zip(letters, ("second", "first"), strict=True):
        alone = [d for d in diffs if not math.isfinite(d.absolute) and getattr(d, field) is None]
        places = join_names(list(dict.fromkeys(d.place or d.quantity for d in alone)), MOST_PLACES)
        texts += [f"only in {letter}, {len(alone)} numbers: {places}"] if alone else []
    return common, texts


def other_ends(reference: Result, compared: Result) -> list[str]:
    """How the two ended, where they did not end alike."""
    if reference.status == compared.status:
        return []
    return [": ".join(filter(None, (name, r.status, r.stop_reason))) for name, r in (("A", reference), ("B", compared))]


def compared_tables(
    diffs: Sequence[Deviation], ends: Sequence[str], tolerance: float, names: Sequence[str], apart: Sequence[str] = ()
) -> list[Table]:
    """What is beyond the tolerance, or the largest differences where nothing is; the verdict."""
    wrong, most = beyond(diffs, tolerance), quantity(100.0 * tolerance, "%", "g")
    common, alone = one_sided(wrong or [d for d in diffs if d.relative > 0.0])
    more = [f"... and {len(common) - LISTED} more; --json lists all"] if wrong and len(common) > LISTED else []
    verdict = f"alike: {len(diffs)} numbers, none differs by more than {most}"
    if wrong:
        verdict = f"{len(wrong)} of {len(diffs)} numbers differ by more than {most}"
    elif ends:
        verdict = "the numbers are alike, the ends are not"
    head = Table("", notes=tuple(f"{letter}: {name}" for letter, name in zip("AB", names, strict=True)) + tuple(apart))
    shown = [difference_table(common[:LISTED])] if common else []
    return [head, *shown, Table("", notes=(*more, *alone, *ends, verdict))]


def _numbers(tree: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, str], float | None]]:
    """Every number of a summary by its place and its quantity; a peak counts as its value."""
    for key, value in tree.items():
        if (not place and key in LEFT_OUT) or key in PLACES:
            continue
        if isinstance(value, Mapping) and "value" in value:
            value = value["value"]
        if isinstance(value, Mapping):
            path = place if key in ("wheelsets", "wheels", "points") else (*place, str(key))
            yield from _numbers(value, path)
        elif isinstance(value, list):
            for i, entry in enumerate(value):
                if isinstance(entry, Mapping):
                    yield from _numbers(entry, (*place, _name(entry, key, i)))
        elif value is None or (isinstance(value, int | float) and not isinstance(value, bool)):
            yield (" ".join(place), str(key)), None if value is None else float(value)


def _name(entry: Mapping[str, Any], key: str, index: int) -> str:
    if "radius_m" in entry:
        return f"curve {index + 1}"
    return f"{PATCHES[index]} patch" if key == "patches" else f"{key}[{index}]"
