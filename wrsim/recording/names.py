"""What the columns of a recording hold, from their names and units: English, German, French, Chinese, Japanese."""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.file_kinds import packaged
from wrsim.inputs.us_units import FOOT
from wrsim.recording.columns import LENGTHS, UNITS

_TABLES = packaged("wrsim.recording", "data/names.toml")


def _pattern(patterns: Sequence[str], versine: str = "") -> re.Pattern[str]:
    """One of several patterns; versine: what takes the place of ``{versine}`` in them."""
    return re.compile("|".join(patterns).replace("{versine}", versine))


NO_USE, VERSINE, DEVIATION = (_pattern(_TABLES[name]) for name in ("no_use", "versine", "deviation"))
GUESSES = [(row["quantity"], _pattern(row["patterns"], VERSINE.pattern)) for row in _TABLES["quantities"]]
"""Quantities and patterns of their columns' names, without accents; the first counts."""
JOINED = r"^{0}(?=prof|align|aline|surf|top|mco)|(?:prof|align|aline|surf|top|mco)\d*{0}$"  # LPROF62, ALIGN62R
LENGTH = re.compile(r"(\d+(?:[.,]\d+)?)\s*(m(?![a-z])|ft|feet|foot|'|米)?")
US_CHORDS = ("31", "62", "124")  # feet, of 49 CFR 213; a chord or a base of these numbers has no unit in its name
WAVES = re.compile(r"(\d+(?:[.,]\d+)?)\s*m?\s*(?:-|–|~|to|bis|a)\s*(\d+(?:[.,]\d+)?)\s*m(?![a-z])")
SPELLINGS = {word: unit for unit, spellings in _TABLES["spellings"].items() for word in spellings}
"""Other spellings of units."""
BRACKET = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]")
NO_UNIT = re.compile(r"d[123]|.*\d.*m|.*(弦|chord)")
TAIL = re.compile(
    r"\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|\s/\s*(\S+)|\sin\s+(\S+)"
    r"|(?:_|(?<!\d)\s)(mm_per_m|per_km|per_m|1/km|1/m|mm/m|permille|mm|cm|um|km|deg|in|ft"
    r"|met(?:er|re)s?|feet|yards|miles|chains|inch(?:es)?|degrees)|_(m|yd|mi|ch))$"
)
FINEST = 0.01  # [m]; no car has rows closer than that: a distance of no stated unit with such rows is in km


def known(name: str) -> bool:
    """Whether a name is that of a column that counts."""
    return _quantity(_split(name)[0]) is not None


def unit_in(cell: str) -> str | None:
    """The unit that a cell consists of: ``[mm]``, ``mm``; None for another text."""
    word = cell.strip().strip("[]()").strip().lower()
    unit = SPELLINGS.get(word, word)
    return unit if unit in LENGTHS or any(unit in units for units in UNITS.values()) else None


def stated_unit(name: str, units: Mapping[str, str]) -> str | None:
    """The unit of a column: in its name, or in a row of units."""
    return _split(name)[1] or units.get(name)


def guessed(
    header: Sequence[str], where: str, chord: Sequence[float] | None, band: str | None,
    units: Mapping[str, str] | None = None,
) -> list[dict[str, Any]]:  # fmt: skip
    """Channels (tables of a column map) from the names of columns.

    chord [m], band: of alignment and level without a system in their names; where: file and line of the header; units:
    of columns, from a row of their own. Raises InputError for an unknown unit.
    """
    channels: list[dict[str, Any]] = []
    for name in header:
        plain, unit = _split(name)[0], stated_unit(name, units or {})
        quantity = _quantity(plain)
        if quantity is None:
            continue
        channel: dict[str, Any] = {"column": name, "quantity": quantity}
        length = _length(plain)
        if quantity in ("alignment", "level"):
            channel |= {"quantity": f"{quantity}{_side(plain)}"} | _system(plain, length, chord, band)
        elif quantity == "gauge" and DEVIATION.search(plain):
            channel["quantity"] = "gauge_deviation"
        elif quantity == "twist" and length is not None:
            channel["base_m"] = length
        if unit is not None:
            allowed = UNITS.get(quantity, LENGTHS)
            if unit not in allowed:
                must = f"must be {', '.join(allowed)}{suggest(unit, list(allowed))}"
                raise InputError(f"{where}: column '{name}': unit '{unit}' is unknown for {quantity}: {must}")
            channel["unit"] = unit
        channels.append(channel)
    cants = [c for c in channels if c["quantity"] == "cant"]
    whole = [c for c in cants if not re.search(r"level|水", c["column"].lower())]
    if whole:  # beside it the cross-level is what is left over the cant of the design
        channels = [c for c in channels if c not in cants or c in whole]
    return channels


def _quantity(plain: str) -> str | None:
    quantity = next((q for q, pattern in GUESSES if pattern.search(plain)), None)
    return None if quantity is None or NO_USE.search(plain) else quantity


def _side(plain: str) -> str:
    """``_left`` or ``_right``, or nothing where the name has none or both."""
    tokens = {*re.split(r"[^a-z0-9]+", plain)}
    sides = [
        side
        for side, names in _TABLES["sides"].items()
        if tokens & {*names["letters"]} or _pattern([*names["patterns"], JOINED.format(side[0])]).search(plain)
    ]
    return f"_{sides[0]}" if len(sides) == 1 else ""


def _length(plain: str) -> float | None:
    """A length [m] with its unit, or one of the chords in feet, in a name."""
    for digits, unit in LENGTH.findall(plain):
        if unit or digits in US_CHORDS:
            return float(digits.replace(",", ".")) * (1.0 if unit in ("m", "米") else FOOT)
    return None


def _system(plain: str, length: float | None, chord: Sequence[float] | None, band: str | None) -> dict[str, Any]:
    """The measuring system of alignment or level: that of the name, or the one given."""
    if named := re.search(r"(?:^|[^a-z0-9])(d[123])(?:$|[^a-z0-9])", plain):
        return {"band": named[1].upper()}
    if waves := WAVES.search(plain):
        return {"band_m": [float(end.replace(",", ".")) for end in waves.groups()]}
    if length is not None and (VERSINE.search(plain) or is_us_chord(0.5 * length)):
        return {"chord_m": [0.5 * length, 0.5 * length]}
    if chord is not None:
        return {"chord_m": list(chord)}
    return {} if band is None else {"band": band}


def is_us_chord(half: float) -> bool:
    """Whether half a chord [m] is that of one of US cars, whose records are in inches."""
    return round(2.0 * half / FOOT, 6) in map(float, US_CHORDS)


def _folded(name: str) -> str:
    """A name in letters from a to z: without accents, umlauts by ae, oe, ue."""
    for letter, plain in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("ß", "ss")):
        name = name.replace(letter, plain)
    return "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))


def _split(name: str) -> tuple[str, str | None]:
    """The folded name of a column without its unit, and that."""
    plain, unit = _without_unit(name.strip().lower())
    return _folded(plain), unit


def _without_unit(name: str) -> tuple[str, str | None]:
    """The name of a column and its unit: ``level [mm]``, ``level (mm) left``, ``level_mm``, ``level mm``,
    ``level / mm``, ``level in mm``, ``curvature_per_km``; ``km`` alone. Brackets with a side or a chord are none."""
    name = unicodedata.normalize("NFKC", name)
    for bracket in BRACKET.finditer(name):
        if unit := unit_in(bracket[1]):
            return name[: bracket.start()] + name[bracket.end() :] or name, unit
    if (tail := TAIL.search(name)) is None or not (unit := next(filter(None, tail.groups()), None)):
        return name, "km" if name.endswith("km") else unit_in(name)
    if unit_in(unit) is None and (_side(_folded(unit)) or NO_UNIT.fullmatch(unit)):
        return name, None
    return name[: tail.start()] or name, SPELLINGS.get(unit, unit)
