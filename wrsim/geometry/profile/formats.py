"""File formats of profile points: two columns, SIMPACK .prr/.prw, MiniProf .ban/.whl. Text in, `Scan` out.

A `Scan` holds what is in the file, in the file's own units and axes; `wrsim.geometry.profile.files` turns it into a
profile. What is read of each format: docs/user/profiles.md.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from wrsim.errors import InputError, suggest
from wrsim.geometry.profile.profile import Kind
from wrsim.inputs.toml_files import read_bytes

METRES = {"m": 1.0, "mm": 1e-3, "in": 0.0254}  # units of length that files may use, in m


@dataclass
class Scan:
    """Content of a file of points; None is what the file lacks.

    lateral, height: coordinates as in the file; line: of every point, from 1; unit: metres per unit of the file;
    heights: which way its heights grow; field_side: sign of its lateral coordinate on the field side; kind, name,
    source, measured: as the file gives them; digits: last one of every height, in its unit;
    least_distance: points closer than this are to be dropped, in its unit.
    """

    file: str
    lateral: list[float] = field(default_factory=list)
    height: list[float] = field(default_factory=list)
    line: list[int] = field(default_factory=list)
    unit: float | None = None
    heights: Literal["up", "down"] | None = None
    field_side: Literal["positive", "negative"] | None = None
    kind: Kind | None = None
    name: str = ""
    source: str = ""
    measured: bool | None = None
    digits: list[float] = field(default_factory=list)
    least_distance: float = 0.0

    def add(self, lateral: str, height: str, line: int) -> None:
        """Append one point, as written."""
        self.lateral.append(_number(lateral, self.file, line))
        self.height.append(_number(height, self.file, line))
        self.line.append(line)
        self.digits.append(_last_digit(height))

    @property
    def resolution(self) -> float:
        """Last digit of its heights, in its unit."""
        return float(np.median(self.digits)) if self.digits else 0.0


def read_lines(path: Path) -> list[str]:
    """Lines of a text file in UTF-8 or, as older programs write, Latin-1. InputError if it cannot be read."""
    data = read_bytes(path, "profile file")
    if b"\0" in data:
        raise InputError(f"{path}: not a text file; allowed: points as text")
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return data.decode("latin-1").splitlines()


def _number(word: str, file: str, line: int) -> float:
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


def parse_columns(lines: list[str], file: str) -> Scan:
    scan = Scan(file)
    headed = False
    for number, text in enumerate(lines, 1):
        stated = re.match(r"\s*[#!%]\s*(name|source|kind(?=\s*[:=]\s*(wheel|rail)\s*$))\s*[:=]\s*(.*\S)", text)
        if stated and not scan.line:
            setattr(scan, stated[1], stated[3])
        text = re.split(r"[#!]", text)[0].strip()
        if not text.strip(",;") or text[0] in "%\"'*" or text.startswith("//"):
            continue
        if ";" in text:
            row = [w.strip() for w in text.replace(",", ".").strip(";").split(";")]
        else:
            row = text.replace(",", " ").split()
        if not headed and not scan.line and not _starts_numbers(row):
            headed = True
            units = {m[1] for w in row if (m := re.search(r"[_\s(\[](mm|m|in)[)\]]?$", w))}
            if len(units) == 1:
                scan.unit = METRES[units.pop()]
            if [re.split(r"[_\s(\[]", w)[0] for w in row[:2]] == ["u", "w"]:
                scan.heights, scan.field_side = "up", "positive"
            continue
        if len(row) != 2:
            raise InputError(f"{file}:{number}: {len(row)} columns; allowed: 2, lateral coordinate and height")
        scan.add(row[0], row[1], number)
    return scan


def _starts_numbers(row: list[str]) -> bool:
    """True for a row of values, good or bad; False for a row of words."""
    return bool(re.match(r"[-+.\d]|nan\b|inf\b", row[0], re.IGNORECASE))


SIMPACK_KEYS = {
    "header": ("version", "type"),
    "spline": (
        "approx.smooth", "file", "file.mtime", "comment", "type", "point.dist.min", "shift.y", "shift.z",
        "rotate", "bound.y.min", "bound.y.max", "bound.z.min", "bound.z.max", "mirror.y", "mirror.z",
        "inversion", "units.len", "units.ang", "units.len.f", "units.ang.f",
    ),
}  # fmt: skip
SIMPACK_TEXTS = ("file", "comment", "units.len", "units.ang")


def parse_simpack(lines: list[str], file: str) -> Scan:
    scan = Scan(file, heights="down")
    values: dict[str, Any] = {}
    where: list[str] = []
    ended = False
    for number, text in enumerate(lines, 1):
        text = re.sub(r"""('[^']*'|"[^"]*")|!.*""", lambda m: m[1] or "", text).strip()  # no ! outside of quotes
        if not text:
            continue
        mark = re.fullmatch(r"(header|spline|point)\.(begin|end)", text)
        if mark and mark[2] == "begin":
            if where != (["spline"] if mark[1] == "point" else []):
                inside = f" inside {where[-1]}" if where else ""
                raise InputError(f"{file}:{number}: {text} is out of place{inside}")
            where.append(mark[1])
        elif mark:
            if not where or where.pop() != mark[1]:
                raise InputError(f"{file}:{number}: {text} without {mark[1]}.begin")
            ended = ended or text == "spline.end"
        elif where[-1:] == ["point"]:
            row = text.split()
            if len(row) not in (2, 3):
                raise InputError(f"{file}:{number}: {len(row)} columns; allowed: y, z and perhaps a weight")
            scan.add(row[0], row[1], number)
        elif "=" in text and where:
            key, value = (part.strip() for part in text.split("=", 1))
            allowed = SIMPACK_KEYS[where[-1]]
            if key not in allowed:
                raise InputError(f"{file}:{number}: unknown key '{key}' in {where[-1]}{suggest(key, allowed)}")
            text_value = where[-1] == "spline" and key in SIMPACK_TEXTS
            values[f"{where[-1]}.{key}"] = value.strip("'\"") if text_value else _number(value, file, number)
        else:
            raise InputError(f"{file}:{number}: '{text}' is out of place; is this a SIMPACK profile?")
    if not ended:
        raise InputError(f"{file}: ends without spline.end: cut off, or not a SIMPACK profile")
    _simpack_values(scan, values)
    return scan


def _simpack_values(scan: Scan, values: dict[str, Any]) -> None:
    """Apply the keys of the sections header and spline to the points."""

    def get(key: str, default: float = 0.0) -> float:
        return float(values.get("spline." + key, default))

    kind = values.get("header.type")
    if kind is not None:
        if kind not in (0, 1):
            raise InputError(f"{scan.file}: header type = {kind:g}; allowed: 0 (rail), 1 (wheel)")
        scan.kind = "wheel" if kind == 1 else "rail"
    if get("rotate") != 0.0:
        hint = "Turn the profile with turn_mrad in a TOML file that names this file"
        raise InputError(f"{scan.file}: rotate = {get('rotate'):g} is not supported; allowed: 0. {hint}")
    if get("units.len.f", 1.0) <= 0.0:
        raise InputError(f"{scan.file}: units.len.f = {get('units.len.f'):g}; allowed: above 0 (mm: 1000)")
    scan.unit = 1.0 / get("units.len.f", 1.0)
    scan.name = str(values.get("spline.comment", ""))
    scan.least_distance = get("point.dist.min")
    scan.measured = True if get("approx.smooth") > 0.0 else None
    keep = np.ones(len(scan.line), dtype=bool)
    axes = {}
    for axis, values_of in (("y", scan.lateral), ("z", scan.height)):
        a = np.array(values_of) + get(f"shift.{axis}")
        low, high = get(f"bound.{axis}.min", 1.0), get(f"bound.{axis}.max")
        if low < high:
            keep &= (a >= low) & (a <= high)
        axes[axis] = -a if get(f"mirror.{axis}") == 1.0 else a
    scan.lateral, scan.height = axes["y"][keep].tolist(), axes["z"][keep].tolist()
    scan.line = np.array(scan.line)[keep].tolist()


def parse_miniprof(lines: list[str], file: str) -> Scan:
    scan = Scan(file, unit=METRES["mm"], measured=True)
    head: dict[str, tuple[str, int]] = {"XOffset": ("", 0), "YOffset": ("", 0), "ID": ("", 0), "ProgramName": ("", 0)}
    columns = ["X", "Y"]
    for number, text in enumerate(lines, 1):
        text = text.strip()
        if not text.strip(",") or text[0] in '#!%"':
            continue
        if "=" in text and not scan.line:
            key, value = (part.strip() for part in text.split("=", 1))
            head[key.replace("offset", "Offset")] = value, number
            if key == "ColumnDef":
                columns = [c.strip() for c in value.split(",")]
                if not {"X", "Y"} <= set(columns):
                    raise InputError(f"{file}:{number}: ColumnDef = {value}; must name X and Y")
            continue
        row = text.replace(",", " ").split()
        if not scan.line and not _starts_numbers(row):
            continue  # old files: words without '=' in the head
        if len(row) < len(columns):
            needed = f"ColumnDef needs {len(columns)}: {','.join(columns)}"
            raise InputError(f"{file}:{number}: {len(row)} columns; {needed}")
        scan.add(row[columns.index("X")], row[columns.index("Y")], number)
    x, y = (_number(value or "0", file, number) for value, number in (head["XOffset"], head["YOffset"]))
    scan.lateral, scan.height = [u + x for u in scan.lateral], [w + y for w in scan.height]
    if "XYPoints" in head:
        value, number = head["XYPoints"]
        if _number(value, file, number) != len(scan.line):
            raise InputError(f"{file}:{number}: XYPoints={value}, but the file has {len(scan.line)} points")
    scan.name = head["ID"][0]
    if head["ProgramName"][0] == "wrsim":
        scan.measured, scan.heights = None, "up"
    return scan
