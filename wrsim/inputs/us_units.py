"""Keys in US units beside the metric ones: the ending of a key gives its unit, ``speed_mph`` for ``speed_kmh``."""

from collections.abc import Callable
from functools import lru_cache, partial
from math import radians, sin
from operator import mul
from typing import Any, NamedTuple

FOOT = 0.3048
KIP = 4.4482216152605  # [kN]
FACTORS: dict[str, tuple[str, float]] = {
    "ft": ("m", FOOT), "in": ("mm", 25.4), "mph": ("kmh", 1.609344), "kip": ("kN", KIP), "lb": ("kg", 0.45359237),
    "kip_per_in": ("kN_per_m", KIP / 0.0254), "ksi": ("MPa", KIP / 0.64516),
}  # fmt: skip
"""Unit endings, the metric ones in their place, and factors to those."""
TERMS = {"superelevation": "cant"}
"""US words at the beginning of keys."""


def chord_curvature(degrees: float) -> float:
    """Curvature [1/m] of so many degrees of curve: the angle of a chord of 100 ft, R = 50 ft / sin(D / 2)."""
    return sin(radians(0.5 * degrees)) / (50.0 * FOOT)


class Metric(NamedTuple):
    """A metric key, and what brings a number of the key in US units to it."""

    key: str
    convert: Callable[[float], float]


@lru_cache(maxsize=4096)
def metric(key: str) -> Metric | None:
    """The metric key of one in US units; None for other keys."""
    if key == "radius_deg":
        return Metric("radius_m", lambda degrees: 1.0 / chord_curvature(degrees))
    word = next((word for word in TERMS if key.startswith(f"{word}_")), None)
    plain = key if word is None else TERMS[word] + key.removeprefix(word)
    for unit in sorted(FACTORS, key=len, reverse=True):
        if plain.endswith(f"_{unit}"):
            name, factor = FACTORS[unit]
            return Metric(f"{plain.removesuffix(unit)}{name}", partial(mul, factor))
    return None


def metric_key(key: str) -> str:
    """The metric key of one in US units; other keys as they are."""
    return ours.key if (ours := metric(key)) else key


def us_keys(key: str) -> tuple[str, ...]:
    """The keys in US units of a metric key."""
    named = sorted(((name, unit) for unit, (name, _) in FACTORS.items()), key=lambda pair: len(pair[0]), reverse=True)
    plain = next((f"{key.removesuffix(name)}{unit}" for name, unit in named if key.endswith(f"_{name}")), "")
    renamed = (f"{word}{plain.removeprefix(ours)}" for word, ours in TERMS.items() if plain.startswith(f"{ours}_"))
    return tuple(filter(None, (plain, *renamed, "radius_deg" if key == "radius_m" else "")))


def converted(value: Any, convert: Callable[[float], float]) -> Any:
    """A number, a list of numbers, or a range in the metric unit. Raises ValueError for other values, such as rows,
    whose numbers have several units."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(f"{convert(float(value)):.13g}")  # 3 in are 76.2 mm
    if isinstance(value, list | tuple) and not any(isinstance(each, list | tuple) for each in value):
        return [converted(each, convert) for each in value]
    if isinstance(value, dict) and set(value) == {"from", "to", "step"}:
        return {key: converted(each, convert) for key, each in value.items()}
    raise ValueError
