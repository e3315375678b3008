"""Files of two columns: text in, `Scan` out; files of programs are in `wrsim.contact.profiles.program_formats`.

A `Scan` holds what is in the file, in the file's own units and axes; `wrsim.contact.profiles.files` turns it into a
profile. What is read of each format: docs/user/profiles.md.
"""

import codecs
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from wrsim.contact.profiles.profile import Kind
from wrsim.errors import InputError
from wrsim.inputs.toml_files import read_bytes

METRES = {"m": 1.0, "mm": 1e-3, "cm": 0.01, "in": 0.0254, "inch": 0.0254, "inches": 0.0254, "thou": 2.54e-5}
"""Units of length that files may use, in m."""

Side = Literal["positive", "negative"]


@dataclass
class Scan:
    """Content of a file of points; None is what the file lacks.

    lateral, height: coordinates as in the file; line: of every point, from 1; unit: metres per unit of the file;
    heights: which way its heights grow; field_side: sign of its lateral coordinate on the field side; convention: that
    sign as the format has it, which files do not state; back: distance of the tape circle from the flange back [m];
    kind, name, source, measured: as the file gives them; digits: last one of every height, in its unit;
    least_distance: points closer than this are to be dropped, in its unit; instrument: measures that the instrument
    took itself [mm]; notes: what was read with a doubt.
    """

    file: str
    lateral: list[float] = field(default_factory=list)
    height: list[float] = field(default_factory=list)
    line: list[int] = field(default_factory=list)
    unit: float | None = None
    heights: Literal["up", "down"] | None = None
    field_side: Side | None = None
    convention: Side | None = None
    back: float | None = None
    kind: Kind | None = None
    name: str = ""
    source: str = ""
    measured: bool | None = None
    digits: list[float] = field(default_factory=list)
    least_distance: float = 0.0
    instrument: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add(self, lateral: str, height: str, line: int) -> None:
        """Append one point, as written."""
        self.lateral.append(finite_number(lateral, self.file, line))
        self.height.append(finite_number(height, self.file, line))
        self.line.append(line)
        self.digits.append(_last_digit(height))

    @property
    def resolution(self) -> float:
        """Last digit of its heights, in its unit."""
        return float(np.median(self.digits)) if self.digits else 0.0


def read_lines(path: Path) -> list[str]:
    """Lines of a text file in UTF-8, UTF-16 or, as older programs write, Latin-1. InputError if it cannot be read."""
    data = read_bytes(path, "profile file")
    if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        data = data.decode("utf-16", errors="replace").encode()
    if b"\0" in data:
        raise InputError(f"{path}: not a text file; allowed: points as text")
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return data.decode("latin-1").splitlines()


def finite_number(word: str, file: str, line: int) -> float:
    """A finite number, or InputError with file and line. Fortran's exponents (1.0D+01) are numbers."""
    try:
        value = float(re.sub(r"(?<=[\d.])[dD](?=[-+\d])", "e", word))
    except ValueError:
        raise InputError(f"{file}:{line}: '{word}' is not a number") from None
    if not np.isfinite(value):
        raise InputError(f"{file}:{line}: {word} is not a finite number")
    return value


def _last_digit(word: str) -> float:
    """Value of one unit in the last digit of a number."""
    match = re.fullmatch(r"[-+]?\d*(?:\.(\d*))?(?:[eEdD]([-+]?\d+))?", word.strip())
    if match is None:
        return 0.0
    exponent = int(match[2] or 0) - len(match[1] or "")
    return 10.0**exponent if abs(exponent) < 300 else 0.0  # 0e473 is a number


MISSING = re.compile(r"[-+]?(nan|inf(inity)?)|#?n/?a|", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?")
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
STATED = re.compile(
    r"\s*[#!%]\s*(name|source|unit|kind(?=\s*[:=]\s*(wheel|rail)\s*$))s?\s*[:=]\s*(.*\S)", re.IGNORECASE
)
Row = tuple[int, str, list[str]]
"""Number of a line, its text without comments, its fields."""


def split_row(text: str) -> list[str]:
    """Fields of a line: apart by semicolons, tabs, blanks or commas. A comma is decimal beside a semicolon, and between
    the digits of one of several fields that are apart by tabs or blanks, none with a point."""
    if ";" in text:
        return [field.strip() for field in text.strip(";").replace(",", ".").split(";")]
    fields = text.split()
    if len(fields) > 1 and "." not in text and any(map(DECIMAL_COMMA.fullmatch, fields)):
        return [field.replace(",", ".") for field in fields]
    return text.replace(",", " ").split()


def is_point(fields: list[str]) -> bool:
    """Whether a line holds the numbers of a point, or what stands for missing ones."""
    return len(fields) > 1 and all(NUMBER.fullmatch(field) or MISSING.fullmatch(field) for field in fields)


def begins_number(fields: list[str]) -> bool:
    """Whether a line begins with a value, good or bad, and not with a word."""
    return bool(fields and re.match(r"[-+.\d]|nan\b|inf\b", fields[0], re.IGNORECASE))


def parse_columns(lines: list[str], file: str) -> Scan:
    """Two columns, perhaps with words before them and a column that counts them. Raises InputError with the line."""
    scan, rows = Scan(file), list[Row]()
    for number, line in enumerate(lines, 1):
        if (stated := STATED.match(line)) and stated[1].lower() == "unit":
            scan.unit = _metres(stated[3], f"{file}:{number}")
        elif stated:
            setattr(scan, stated[1].lower(), stated[3])
        text = re.split(r"#(?!n/?a)|!", line, flags=re.IGNORECASE)[0].strip()
        if text[:1] == '"' and is_point(split_row(bare := text.replace('"', ""))):
            text = bare  # a table of texts
        if text.strip(",;") and text[0] not in "%\"'*" and not text.startswith("//"):
            rows.append((number, text, split_row(text)))
    first = _first_point(rows)
    header, points = rows[max(first - 2, 0) : first], rows[first:]
    _read_header(scan, [row for row in header if not begins_number(row[2])])
    full = [i for i, row in enumerate(points) if not is_point(row[2]) or not any(map(MISSING.fullmatch, row[2]))]
    points = points[full[0] : full[-1] + 1] if full else []
    if len(points) < len(rows) - first:
        scan.notes.append(f"{len(rows) - first - len(points)} lines without numbers at the ends are left out")
    columns = _columns(scan, header[-1][2] if header else [], [fields for _, _, fields in points])
    for number, _, fields in points:
        if len(fields) != len(columns):
            allowed = "allowed: 2, lateral coordinate and height"
            raise InputError(f"{file}:{number}: {len(fields)} columns; {allowed}")
        lateral, height = (field for field, used in zip(fields, columns, strict=True) if used)
        scan.add(lateral, height, number)
    return scan


def _first_point(rows: list[Row]) -> int:
    """Index of the row where the points begin: the first of three with as many numbers, or else the first number."""
    counts = [len(fields) if is_point(fields) else 0 for _, _, fields in rows]
    alike = (i for i in range(len(rows) - 2) if counts[i] and counts[i] == counts[i + 1] == counts[i + 2])
    begin = (i for i, (_, _, fields) in enumerate(rows) if begins_number(fields))
    return next(alike, next(begin, len(rows)))


def _read_header(scan: Scan, header: list[Row]) -> None:
    """Units and axes from the two lines of words above the points."""
    for number, text, _ in header:
        bare = re.split(r"[\s,;]+", re.sub(r"[(\[][^)\]]*[)\]]", " ", text).strip(" ,;").lower())
        units = [m[1] for word in bare if (m := re.fullmatch(rf"(?:.*_)?({'|'.join(METRES)})", word))]
        if len(bare) <= 4:  # names of columns, no sentence
            units += re.findall(r"[(\[]\s*([^)\]]*?)\s*[)\]]", text)
        if len({_metres(unit, f"{scan.file}:{number}") for unit in units}) > 1:
            raise InputError(f"{scan.file}:{number}: {', '.join(units)}: one unit for both columns is needed")
        scan.unit = _metres(units[0], "") if units else scan.unit
        if [word.split("_")[0] for word in bare[:2]] == ["u", "w"]:
            scan.heights, scan.field_side = "up", "positive"


def _metres(word: str, place: str) -> float:
    """The metres of a unit. Raises InputError for a word that is none."""
    if (metres := METRES.get(word.lower().strip("'\". "))) is None:
        raise InputError(f"{place}: '{word}' is no known unit; allowed: {', '.join(METRES)}")
    return metres


def _columns(scan: Scan, names: list[str], rows: list[list[str]]) -> list[bool]:
    """Which columns are the lateral coordinate and the height: y and z by their names, or those that do not count the
    points."""
    width = len(rows[0]) if rows else 2
    bare = [re.split(r"[_\s(\[]", name.lower())[0] for name in names]
    if width > 2 and len(bare) == width and {"y", "z"} <= set(bare):
        return [name in ("y", "z") for name in bare]
    for column, name in ((0, "first"), (2, "last")) if width == 3 else ():
        values = [row[column] if len(row) == width else "" for row in rows]
        steps = np.diff([float(value) if NUMBER.fullmatch(value) else np.nan for value in values])
        if steps.size and (steps == steps[0]).all() and steps[0] in (0.0, 1.0):
            scan.notes.append(f"the {name} column {'counts the points' if steps[0] else 'is constant and left out'}")
            return [i != column for i in range(3)]
    return [True, True]
