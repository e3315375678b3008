"""Units that people read: metric, or those of US railways in tables, pictures and reports.

Numbers stay in the metric units of the register until a table, a picture or a page is made; JSON and datasets stay so.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from math import asin, ceil, degrees, log10
from operator import mul
from typing import Literal, NamedTuple, get_args

from wrsim.errors import InputError
from wrsim.inputs.toml_files import parse_toml
from wrsim.inputs.us_units import FOOT, KIP, chord_curvature
from wrsim.results.channels import Shown

System = Literal["metric", "us"]


class Conversion(NamedTuple):
    """symbol, suffix: of the other unit, as in `channels.Shown`; forward, back: of numbers to it and from it."""

    symbol: str
    suffix: str
    forward: Callable[[float], float]
    back: Callable[[float], float]


def _linear(symbol: str, suffix: str, size: float) -> Conversion:
    """size: of the other unit in the metric one."""
    return Conversion(symbol, suffix, partial(mul, 1.0 / size), partial(mul, size))


def _degrees_of_curve(per_km: float) -> float:
    """Degrees of a chord of 100 ft; radii below 50 ft, of which there are none, as 180."""
    return 2.0 * degrees(asin(max(-1.0, min(1.0, 50.0 * FOOT * 1e-3 * per_km))))


US = {
    "m": _linear("ft", "ft", FOOT), "km": _linear("mi", "mi", 1.609344), "mm": _linear("in", "in", 25.4),
    "mm²": _linear("in²", "in2", 645.16), "km/h": _linear("mph", "mph", 1.609344), "m/s": _linear("ft/s", "ft_s", FOOT),
    "m/s²": _linear("ft/s²", "ft_s2", FOOT), "kN": _linear("kip", "kip", KIP), "N": _linear("lbf", "lbf", KIP),
    "kN m": _linear("kip ft", "kip_ft", KIP * FOOT), "N m": _linear("lbf ft", "lbf_ft", KIP * FOOT),
    "N/mm": _linear("lbf/in", "lbf_per_in", KIP / 25.4), "MPa": _linear("ksi", "ksi", KIP / 0.64516),
    "kg": _linear("lb", "lb", 0.45359237), "t": _linear("ton", "ton", 0.90718474),
    "1/km": Conversion("°/100 ft", "deg", _degrees_of_curve, lambda of_chord: 1e3 * chord_curvature(of_chord)),
}  # fmt: skip
"""What takes the place of a metric unit, by its symbol; units that are not here are common to both."""


@dataclass
class Choice:
    """The system of units in use; open: a scenario or a result may still choose it."""

    system: System = "metric"
    open: bool = False


CHOICE: ContextVar[Choice] = ContextVar("units", default=Choice())  # noqa: B039 (of no block: never open, never changed)


@contextmanager
def shown_in(system: str | None) -> Iterator[None]:
    """Tables, pictures and pages of the block have these units; None: those of the scenario or result that is read
    last, or metric. Raises InputError for an unknown system."""
    if system is not None and system not in get_args(System):
        raise InputError(f'--units {system}: must be "metric" or "us"')
    token = CHOICE.set(Choice("us" if system == "us" else "metric", system is None))
    try:
        yield
    finally:
        CHOICE.reset(token)


def prefer(system: str) -> None:
    """Take the units that a scenario asks for, where they are open."""
    choice = CHOICE.get()
    if choice.open:
        choice.system = "us" if system == "us" else "metric"


def prefer_those_of(scenario_text: str) -> None:
    """Take the units of the scenario of a result, where they are open."""
    if CHOICE.get().open and scenario_text:
        prefer(str(parse_toml(scenario_text, "scenario").get("units")))


def conversion(symbol: str) -> Conversion | None:
    """From a metric unit to that in use; None where they are the same."""
    return US.get(symbol) if CHOICE.get().system == "us" else None


_NUMBER = r"[-−+±]?\d+(?:\.\d+)?"
_UNIT = "|".join(map(re.escape, sorted(US, key=len, reverse=True)))
_WITH_UNIT = re.compile(
    rf"(?<![\w.])({_NUMBER}(?:(?: to | and | or | of | of at least |, | \+ | / |/|–|-){_NUMBER})*)"
    rf"([ \N{{NO-BREAK SPACE}}])({_UNIT})(?![\w/²³·]| m/)"
)
_RADIUS = re.compile(rf"\bR ({_NUMBER})(?! ?(?:m|ft|\d)\b)(?![\w.])")


def in_text(text: str) -> str:
    """Words with their metric quantities, ``70 to 170 m``, in the units in use, to as many digits, three at least."""
    if CHOICE.get().system == "metric":
        return text
    text = _RADIUS.sub(lambda match: f"R {numbers_in(match[1], US['m'])} ft", text)
    return _WITH_UNIT.sub(lambda match: f"{numbers_in(match[1], US[match[3]])}{match[2]}{US[match[3]].symbol}", text)


def numbers_in(text: str, unit: Conversion) -> str:
    """Words with all of their numbers in another unit."""

    def replacement(match: re.Match[str]) -> str:
        sign, digits = match[1], match[2]
        most = max(3, len(digits.replace(".", "").lstrip("0")))
        if (value := unit.forward(float(digits))) == 0.0:
            return match[0]
        places = max(0, most - 1 - (int(log10(value)) if value >= 1.0 else 0))
        return f"{sign}{value:.{places}f}" if value < 10.0**most else f"{sign}{value:.0f}"

    return re.sub(r"(?<![\w.])([-−+±]?)(\d+(?:\.\d+)?)", replacement, text)


def finer(form: str, unit: Conversion) -> str:
    """The format of a number in another unit: with more decimals where that is larger."""
    digits = re.fullmatch(r"\.(\d+)f", form)
    more = max(0, ceil(-log10(abs(unit.forward(1.0))) - 0.2))
    return f".{int(digits[1]) + more}f" if digits else form


def heading_in(heading: str) -> tuple[str, Conversion | None]:
    """A heading or label with the unit in use in its brackets, and the conversion to it."""
    match = re.search(r"\[([^\]]+)\]", heading)
    unit = conversion(match[1]) if match else None
    return (heading, None) if match is None or unit is None else (heading.replace(match[0], f"[{unit.symbol}]"), unit)


_TEXTS = re.compile(r"(<(script|style|pre|svg|textarea)\b.*?</\2>)|(?<=>)[^<]+", re.DOTALL)


def in_page(page: str) -> str:
    """A page with the words that it shows in the units in use."""
    return page if CHOICE.get().system == "metric" else _TEXTS.sub(lambda match: match[1] or in_text(match[0]), page)


def converted(shown: Shown) -> Shown:
    """The unit for readers in the units in use; of numbers in a file, where degrees of curve stay 1/km."""
    unit = conversion(shown.symbol)
    if unit is None or not isinstance(unit.forward, partial):
        return shown
    return Shown(unit.symbol, unit.suffix, shown.factor * unit.forward(1.0))
