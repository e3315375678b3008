"""What the columns of a recording hold, from their names and units: English, German, French, Chinese, Japanese."""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.us_units import FOOT
from wrsim.recording.columns import LENGTHS, UNITS

NO_USE = (
    r"speed|geschw|vitesse|^v\b|accel|beschl|temp|deficien|fehlbetrag|insuffis|radius|rayon|halbmesser|gradient|rampe|pente"
    r"|(?<!quer)neigung|gps|latitude|longitude|date\b|datum|\btime|zeit|heure|fahrtrichtung|messrichtung|sens\b|std|sigma|standardab|type"
    r"|change|variation|aender|warp|速|加速度|不足|欠超高|时间|時刻|日期|半径|变化率|変化|坡度|勾配|温度|(运行|检测)方向"
)
"""Names of columns that are left out though they hold words of quantities, such as cant deficiency."""
VERSINE = r"versine|pfeilho(e)?hen?|fleche|sehne|chord|corde|ordinate|mco|正矢|弦"
GUESSES: tuple[tuple[str, str], ...] = (
    ("distance", r"dist|chainage|mileage|mile.?post|^(mp|miles?|feet|foot|ft|yards?|chains?|met(er|re)s?)$|kilomet"
                 r"|stati?on|posit|locat|(^|[^a-z])pk($|[^a-z])|km$|^s$|^k?m$|abscisse|weg|里程|公里|距離|距离|キロ程"),
    ("twist", r"twist|verwind|gauchiss|^gauche(?!.*(dress|nivel|fleche))|三角坑|扭曲|平面性"),
    ("cant", r"cant|cross.?level|(?<![a-z])xl(v|$)|x.?level|super.?elev|u(e)?berho|querho|querneig|gegens|devers"
             r"|nivel.*trans|超高|水平(?!.*(弦|正矢))|水準|カント"),
    ("gauge", r"gauge|(?<![a-z])gage|spur|ecartement|轨距|軌距|軌間"),
    ("curvature", r"curv|kru(e)?mm|courbure|曲率"),
    ("level", rf"(?=.*({VERSINE})).*(vertic|vertik|senkr|profil|nivel|level|top|(?<!pfeil)ho(e)?he|垂|高低)"),
    ("alignment", rf"align|aline|richt|dress|lateral|seitenlage|horizontal|轨向|軌向|方向|通り|{VERSINE}"),
    ("level", r"level|vertical|vertikal|profil|(?<![a-z])[lr]?prof(?![a-z])|surface|(?<![a-z])[lr]?top(?![a-z])"
              r"|uneven|ho(e)?he|nivea|nivel|高低"),
)  # fmt: skip
"""Quantities and patterns of their columns' names, without accents; the first counts."""
DEVIATION = (
    r"dev|abw|erweit|widen|delta|sur.?ecart|ecart.?d.?ecart|偏差|狂い|スラック"  # of a gauge, from the nominal one
)
SIDES = {"left": r"left|link|gauche|左", "right": r"right|recht|droite?|右"}
LETTERS = {"left": {"l", "lh", "li", "g"}, "right": {"r", "rh", "re", "d"}}
JOINED = r"^{0}(?=prof|align|aline|surf|top|mco)|(?:prof|align|aline|surf|top|mco)\d*{0}$"  # LPROF62, ALIGN62R
LENGTH = re.compile(r"(\d+(?:[.,]\d+)?)\s*(m(?![a-z])|ft|feet|foot|'|米)?")
US_CHORDS = ("31", "62", "124")  # feet, of 49 CFR 213; a chord or a base of these numbers has no unit in its name
WAVES = re.compile(r"(\d+(?:[.,]\d+)?)\s*m?\s*(?:-|–|~|to|bis|a)\s*(\d+(?:[.,]\d+)?)\s*m(?![a-z])")
SPELLINGS = {
    "km-1": "1/km", "m-1": "1/m", "km^-1": "1/km", "m^-1": "1/m", "km⁻¹": "1/km", "m⁻¹": "1/m", "‰": "permille",
    "µm": "um", "μm": "um", "per_km": "1/km", "per_m": "1/m", "mm_per_m": "mm/m", "rad/km": "1/km", "mrad/m": "1/km",
    "rad/m": "1/m", "°": "deg", "deg/100ft": "deg", "°/100ft": "deg", "grad": "deg", '"': "in", "'": "ft", "mp": "mi",
    "公里": "km", "千米": "km", "米": "m", "毫米": "mm",
} | {word: unit for unit, words in {
    "m": "meter meters metre metres", "mm": "millimeter millimetre", "km": "kilometer kilometers kilometre kilometres",
    "in": "inch inches zoll pouce pouces", "ft": "foot feet fuss pied pieds", "mi": "mile miles meile meilen milepost",
    "yd": "yard yards yds", "ch": "chain chains", "deg": "degree degrees degres",
}.items() for word in words.split()}  # fmt: skip
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
    return _quantity(_folded(_without_unit(name.strip().lower())[0])) is not None


def unit_in(cell: str) -> str | None:
    """The unit that a cell consists of: ``[mm]``, ``mm``; None for another text."""
    word = cell.strip().strip("[]()").strip().lower()
    unit = SPELLINGS.get(word, word)
    return unit if unit in LENGTHS or any(unit in units for units in UNITS.values()) else None


def stated_unit(name: str, units: Mapping[str, str]) -> str | None:
    """The unit of a column: in its name, or in a row of units."""
    return _without_unit(name.strip().lower())[1] or units.get(name)


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
        plain, unit = _folded(_without_unit(name.strip().lower())[0]), stated_unit(name, units or {})
        quantity = _quantity(plain)
        if quantity is None:
            continue
        channel: dict[str, Any] = {"column": name, "quantity": quantity}
        length = _length(plain)
        if quantity in ("alignment", "level"):
            channel |= {"quantity": f"{quantity}{_side(plain)}"} | _system(plain, length, chord, band)
        elif quantity == "gauge" and re.search(DEVIATION, plain):
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
    quantity = next((q for q, pattern in GUESSES if re.search(pattern, plain)), None)
    return None if quantity is None or re.search(NO_USE, plain) else quantity


def _side(plain: str) -> str:
    """``_left`` or ``_right``, or nothing where the name has none or both."""
    words = {*re.split(r"[^a-z0-9]+", plain)}
    sides = [s for s in SIDES if re.search(f"{SIDES[s]}|{JOINED.format(s[0])}", plain) or words & LETTERS[s]]
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
    if length is not None and (re.search(VERSINE, plain) or is_us_chord(0.5 * length)):
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
