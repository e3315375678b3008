"""Files of programs and instruments: SIMPACK, MiniProf, VAMPIRE. Text in, `Scan` out.

What is read of each format: docs/user/profiles.md.
"""

import re
from typing import Any

import numpy as np

from wrsim.contact.profiles.formats import METRES, Scan, begins_number, finite_number, parse_columns, split_row
from wrsim.errors import InputError, suggest

SIMPACK_KEYS = {
    "header": ("version", "type", "meas.pos.e", "meas.pos.qr"),
    "spline": (
        "approx.smooth", "file", "file.mtime", "comment", "type", "point.dist.min", "shift.y", "shift.z",
        "rotate", "bound.y.min", "bound.y.max", "bound.z.min", "bound.z.max", "mirror.y", "mirror.z",
        "inversion", "units.len", "units.ang", "units.len.f", "units.ang.f",
    ),
}  # fmt: skip
SIMPACK_TEXTS = ("file", "comment", "units.len", "units.ang")


def parse_simpack(lines: list[str], file: str) -> Scan:
    """A file of SIMPACK's profile editor: y positive on the field side, z down. Raises InputError with the line."""
    scan = Scan(file, heights="down", convention="positive")
    values: dict[str, Any] = {}
    where: list[str] = []
    ended = False
    for number, text in enumerate(lines, 1):
        text = re.sub(r"""('[^']*'|"[^"]*")|[!%].*""", lambda m: m[1] or "", text).strip()  # none within quotes
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
            values[f"{where[-1]}.{key}"] = value.strip("'\"") if text_value else finite_number(value, file, number)
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
    scan.source = str(values.get("spline.comment", ""))
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


TAPE_LINE = "WheelDiameterTaperline"
OLD_MEASURES = re.compile(r"^\W*([\d.]+)\s+([\d.]+)\s+([\d.]+)\s+\(Sd/Sh/qR\)", re.MULTILINE)


def parse_miniprof(lines: list[str], file: str) -> Scan:
    """A file of a MiniProf: a head, then points in mm; x of rails to the gauge side. InputError with the line."""
    scan = Scan(file, unit=METRES["mm"], measured=True)
    rows = [split_row(line.strip()) for line in lines]
    behind_blank = (i + 1 for i in range(len(rows) - 1) if not rows[i] and begins_number(rows[i + 1]))
    unheaded = (i for i, row in enumerate(rows) if begins_number(row) and "=" not in lines[i])
    first = next(behind_blank, next(unheaded, len(lines)))
    head = {"XOffset": ("", 0), "YOffset": ("", 0), "ColumnDef": ("X,Y", 0)}
    for number, text in enumerate(lines[:first], 1):
        if "=" in text and text.strip()[0] not in '#!%"':
            key, value = (part.strip() for part in text.split("=", 1))
            head[key.replace("offset", "Offset")] = value, number
    columns = [c.strip() for c in head["ColumnDef"][0].split(",")]
    if not {"X", "Y"} <= set(columns):
        raise InputError(f"{file}:{head['ColumnDef'][1]}: ColumnDef = {head['ColumnDef'][0]}; must name X and Y")
    for number, row in enumerate(rows[first:], first + 1):
        if not row or row[0][0] in '#!%"':
            continue
        if len(row) < len(columns):
            needed = f"ColumnDef needs {len(columns)}: {','.join(columns)}"
            raise InputError(f"{file}:{number}: {len(row)} columns; {needed}")
        scan.add(row[columns.index("X")], row[columns.index("Y")], number)
    x, y = (finite_number(value or "0", file, number) for value, number in (head["XOffset"], head["YOffset"]))
    scan.lateral, scan.height = [u + x for u in scan.lateral], [w + y for w in scan.height]
    old = OLD_MEASURES.search("\n".join(lines[:first]))
    scan.instrument = dict(zip(("Sd", "Sh", "qR"), map(float, old.groups()), strict=True)) if old else {}
    for key in ("Sd", "Sh", "qR", "W1", "W2", "W3", TAPE_LINE, "XYPoints"):
        value, number = head.get(key, ("", 0))
        if value:
            scan.instrument[key] = finite_number(value.replace(",", "."), file, number)
    counted = scan.instrument.pop("XYPoints", None)
    if counted not in (None, len(scan.line)):
        scan.notes.append(f"XYPoints={counted:g}, but the file has {len(scan.line)} points, which are used")
    if tape_line := scan.instrument.pop(TAPE_LINE, None):
        scan.back = 1e-3 * tape_line
    if head.get("ProgramName", ("", 0))[0] == "wrsim":
        scan.measured, scan.heights, scan.field_side = None, "up", "positive"
        scan.name = head.get("ID", ("", 0))[0]
    scan.convention = "negative"
    return scan


DATUMS = {"EUROPEAN": 70.0, "US1": 25.4 * (2 + 27 / 32), "US2": 25.4 * (3 + 1 / 16)}
"""Tape circles by the names of VAMPIRE, from the flange back [mm]."""


def parse_vampire(lines: list[str], file: str) -> Scan:
    """A file of VAMPIRE: a head of four lines, then y and z of the left and of the right side, y from the middle of the
    track. The right side is taken. Other files with these suffixes are of two columns. Raises InputError."""
    kind = lines[0].strip() if lines else ""
    if kind not in ("WHEELPROFILE", "RAILPROFILE"):
        return parse_columns(lines, file)
    scan = Scan(file, unit=METRES["mm"], field_side="positive", kind="wheel" if kind[0] == "W" else "rail")
    scan.source = lines[1].strip() if len(lines) > 1 else ""
    rows = [split_row(re.split(r'["!%]', line)[0].strip()) for line in lines]
    headers = {row[0]: row[1:] for row in rows[2:4] if len(row) > 1}
    origin = 0.0
    if scan.kind == "wheel":
        datum, apart = headers.get("TREADDATUM", ["none"]), headers.get("FLANGEBACK", ["none"])
        back = DATUMS.get(datum[0]) or finite_number(datum[-1], file, 3)
        scan.back, origin = 1e-3 * back, 0.5 * finite_number(apart[0], file, 4) + back
    sides = []
    for number, row in enumerate(rows[4:], 5):
        if not row:
            continue
        if len(row) < 4:
            raise InputError(f"{file}:{number}: {len(row)} columns; allowed: 4, y and z of the left and the right side")
        scan.add(row[2], row[3], number)
        sides.append([finite_number(word, file, number) for word in row[:4]])
    scan.lateral = [u - origin for u in scan.lateral]
    left, right = np.split(np.abs(np.array(sides or [[0.0] * 4])), 2, axis=1)
    if (apart_by := float(np.abs(left - right).max())) > 1e-3:
        scan.notes.append(f"the right side is taken; the left one differs by up to {apart_by:.3g} mm")
    return scan
