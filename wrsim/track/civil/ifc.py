"""Alignments of IFC 4.3 (ISO 16739-1:2024) in files of ISO 10303-21.

Read are the business entities of an alignment, not its geometry: IfcAlignment nests IfcAlignmentHorizontal, -Vertical
and -Cant, which nest segments. x is east and y north; directions turn counter-clockwise from x; radii are positive to
the left, 0 is straight; cant is the height of each rail; distances are in plan.
"""

import math
import re
import uuid
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal

from wrsim.errors import InputError
from wrsim.inputs.toml_files import read_text, shortened
from wrsim.track.alignment import Cant, Plan, Profile
from wrsim.track.civil.line import CivilLine
from wrsim.track.forms import CantForm, Form

MOST_ENTITIES, DEEPEST = 4_000_000, 30
PLAN_FORMS: dict[str, Form] = {
    "LINE": "clothoid", "CIRCULARARC": "clothoid", "CLOTHOID": "clothoid", "BLOSSCURVE": "bloss",
    "COSINECURVE": "cosine", "SINECURVE": "sine", "CUBIC": "cubic parabola", "HELMERTCURVE": "helmert",
    "VIENNESEBEND": "viennese",
}  # fmt: skip
PROFILE_FORMS: dict[str, Literal["parabola", "circle"]] = {
    "CONSTANTGRADIENT": "parabola",
    "PARABOLICARC": "parabola",
    "CIRCULARARC": "circle",
}
CANT_FORMS: dict[str, CantForm] = {
    "CONSTANTCANT": "linear", "LINEARTRANSITION": "linear", "BLOSSCURVE": "bloss", "COSINECURVE": "cosine",
    "SINECURVE": "sine", "HELMERTCURVE": "helmert", "VIENNESEBEND": "viennese",
}  # fmt: skip
"""PredefinedType of segments, and the forms of `wrsim.track.forms`."""
PREFIXES = {".KILO.": 3, ".HECTO.": 2, ".DECA.": 1, ".DECI.": -1, ".CENTI.": -2, ".MILLI.": -3, ".MICRO.": -6}
_COMMENT = re.compile(r"'[^']*+'|/\*(?:[^*]|\*(?!/))*+(?:\*/|\Z)")
_STATEMENT = re.compile(r"\s*((?:[^;']|'[^']*+')*+);")
_ENTITY = re.compile(r"#(\d{1,18})\s*=\s*([A-Za-z]\w*)\s*\((.*)\)\s*\Z", re.DOTALL)
_TOKEN = re.compile(
    r"""\s*(?:(?P<text>'(?:[^']|'')*+')|(?P<ref>\#\d{1,18}\b)|(?P<number>[+-]?\d+(?:\.\d*)?(?:[Ee][+-]?\d+)?(?![\w.]))
    |(?P<word>\.\w+\.|[$*])|(?P<open>\w*\s*\()|(?P<close>\))|,)""",
    re.VERBOSE,
)
_ESCAPE = re.compile(r"''|\\\\|\\X2\\((?:[0-9A-Fa-f]{4})*)\\X0\\|\\X\\([0-9A-Fa-f]{2})|\\S\\(.)|\\P[A-I]\\")


@dataclass
class Step:
    """The entities of a file by their number: name, arguments as text, place in the file; and its alignments."""

    path: Path
    text: str
    entities: dict[int, tuple[str, str, int]] = field(default_factory=dict)

    def fault(self, place: int, message: str) -> InputError:
        return InputError(f"{self.path}:{self.line(place)}: {message}")

    @cached_property
    def _ends(self) -> list[int]:
        return [match.start() for match in re.finditer("\n", self.text)]

    def line(self, place: int) -> int:
        """The line of a place in the text."""
        return bisect_left(self._ends, place) + 1

    def of(self, *names: str) -> list[int]:
        """The numbers of all entities of these names, in order."""
        return [number for number, (name, _, _) in self.entities.items() if name in names]

    def get(self, number: Any, *names: str) -> tuple[str, list[Any], int]:
        """Name, arguments and place of the entity that an argument refers to. Raises InputError for other names."""
        if not isinstance(number, int) or number not in self.entities:
            raise InputError(f"{self.path}: refers to {number!r:.40}; allowed: an entity {' or '.join(names)}")
        name, body, place = self.entities[number]
        if name not in names:
            raise self.fault(place, f"#{number} is {name}; allowed: {' or '.join(names)}")
        return name, self._arguments(body, place, name), place

    def _arguments(self, body: str, place: int, name: str) -> list[Any]:
        """Texts and keywords, numbers, references as int, None where there is no value, and lists of these."""
        rows: list[list[Any]] = [[]]
        end = 0
        while match := _TOKEN.match(body, end):
            end, kind, token = match.end(), match.lastgroup, match[0].strip()
            if kind == "open" and len(rows) < DEEPEST:
                rows.append([])
            elif kind == "close" and len(rows) > 1:
                rows[-2].append(rows.pop())
            elif kind in ("open", "close"):
                break
            elif kind is not None:
                value = float(token) if kind == "number" else int(token[1:]) if kind == "ref" else token
                rows[-1].append(_decoded(token[1:-1]) if kind == "text" else None if token in ("$", "*") else value)
        if body[end:].strip() or len(rows) != 1:
            rest = shortened(body[end : end + 40].strip() or name)
            raise self.fault(place, f"#{name}: cannot be read at {rest!r}; allowed: values of ISO 10303-21")
        return rows[0]

    @cached_property
    def parts(self) -> dict[int, dict[str, list[int]]]:
        """What an object nests and aggregates, by the names of the entities."""
        parts: dict[int, dict[str, list[int]]] = {}
        for number in self.of("IFCRELNESTS", "IFCRELAGGREGATES"):
            _, row, place = self.get(number, "IFCRELNESTS", "IFCRELAGGREGATES")
            if len(row) < 6 or not isinstance(row[4], int) or not isinstance(row[5], list):
                raise self.fault(place, f"#{number} has no object with a list of objects")
            for part in row[5]:
                name = self.entities[part][0] if isinstance(part, int) and part in self.entities else ""
                parts.setdefault(row[4], {}).setdefault(name, []).append(part)
        return parts

    @cached_property
    def wholes(self) -> dict[int, int]:
        """The alignment that an alignment is a part of."""
        return {part: whole for whole, parts in self.parts.items() for part in parts.get("IFCALIGNMENT", [])}

    def number(self, row: Sequence[Any], i: int, place: int, default: float | None = None) -> float:
        """A finite number among the arguments, also with a type around it."""
        value = row[i] if i < len(row) else None
        value = value[0] if isinstance(value, list) and len(value) == 1 else value
        if value is None and default is not None:
            return default
        if not isinstance(value, float) or not math.isfinite(value):
            raise self.fault(place, f"argument {i + 1} is {value!r:.40}; allowed: a finite number")
        return value

    @cached_property
    def units(self) -> dict[str, float]:
        """Metres in a unit of length, radians in one of angle."""
        for project in self.of("IFCPROJECT")[:1]:
            _, row, _ = self.get(project, "IFCPROJECT")
            _, assigned, _ = self.get(row[-1] if row else None, "IFCUNITASSIGNMENT")
            units = assigned[0] if assigned and isinstance(assigned[0], list) else []
            known = [unit for unit in self.of("IFCSIUNIT", "IFCCONVERSIONBASEDUNIT") if unit in units]
            factors = dict(map(self.unit, known))
            if ".LENGTHUNIT." in factors:
                return {".PLANEANGLEUNIT.": 1.0} | factors
        raise InputError(f"{self.path}: IFCPROJECT assigns no unit of length; allowed: such as metres")

    def unit(self, number: Any, depth: int = 0) -> tuple[str, float]:
        """Kind of a unit, and how many SI units it is; 1 for those of other kinds."""
        name, row, place = self.get(number, "IFCSIUNIT", "IFCCONVERSIONBASEDUNIT")
        kind = row[1] if len(row) == 4 else None
        if kind not in (".LENGTHUNIT.", ".PLANEANGLEUNIT."):
            return str(kind), 1.0
        if name == "IFCSIUNIT":
            if row[3] not in (".METRE.", ".RADIAN.") or not (row[2] is None or row[2] in PREFIXES):
                raise self.fault(place, f"a unit {row[2]} {row[3]}; allowed: metres with a prefix, radians")
            return kind, 10.0 ** PREFIXES.get(row[2], 0)
        _, measure, _ = self.get(row[3], "IFCMEASUREWITHUNIT")
        factor = self.number(measure, 0, place)
        if depth > 3 or len(measure) < 2 or not factor > 0.0:
            raise self.fault(place, "a unit that is no positive number of another one")
        return kind, factor * self.unit(measure[1], depth + 1)[1]

    def layout(self, alignment: int, kind: str) -> int | None:
        """The horizontal, vertical or cant layout of an alignment; several profiles share the plan of the whole."""
        for owner in (alignment, self.wholes.get(alignment, -1))[: 2 if kind == "HORIZONTAL" else 1]:
            for layout in self.parts.get(owner, {}).get(f"IFCALIGNMENT{kind}", []):
                return layout
        return None

    def segments(self, layout: int | None, kind: str, forms: Mapping[str, Any]) -> Iterator[tuple[list[Any], str, int]]:
        """Arguments, PredefinedType and place of the segments of a layout."""
        for member in self.parts.get(layout if layout is not None else -1, {}).get("IFCALIGNMENTSEGMENT", []):
            _, outer, place = self.get(member, "IFCALIGNMENTSEGMENT")
            _, row, place = self.get(outer[-1] if outer else None, f"IFCALIGNMENT{kind}SEGMENT")
            name = str(row[8]).strip(".").upper() if len(row) == 9 else "is missing"
            if name not in forms:
                raise self.fault(place, f"PredefinedType {name}; allowed: {', '.join(forms)}")
            yield row, name, place

    def alignment(self, number: int, name: str) -> CivilLine:
        """One alignment of the file. Raises InputError."""
        metre, radian = self.units[".LENGTHUNIT."], self.units[".PLANEANGLEUNIT."]
        plan, profile, cant = list[Plan](), list[Profile](), list[Cant]()
        end, base = None, None
        for row, kind, place in self.segments(self.layout(number, "HORIZONTAL"), "HORIZONTAL", PLAN_FORMS):
            _, point, _ = self.get(row[2], "IFCCARTESIANPOINT")
            point = point[0] if point and isinstance(point[0], list) else []
            east, north = (self.number(point, i, place) * metre for i in (0, 1))
            if (length := self.number(row, 6, place) * metre) == 0.0:  # IFC ends a row with a segment without length
                end = east, north
                continue
            radii = [self.number(row, i, place) * metre for i in (4, 5)]
            start, stop = (0.0 if radius == 0.0 else 1.0 / radius for radius in radii)
            stop = start if kind == "CIRCULARARC" and stop == 0.0 else stop
            if kind in ("LINE", "CIRCULARARC") and (start != stop or (kind == "LINE") != (start == 0.0)):
                message = f"{kind} from radius {radii[0]:g} to {radii[1]:g}; allowed: 0 for a line, one of an arc"
                raise self.fault(place, message)
            height = None if row[7] is None else self.number(row, 7, place) * metre
            pose, line = (east, north, self.number(row, 3, place) * radian), self.line(place)
            plan.append(Plan(length, start, stop, PLAN_FORMS[kind], height, pose, line))
        for row, kind, place in self.segments(self.layout(number, "VERTICAL"), "VERTICAL", PROFILE_FORMS):
            start, length, height = (self.number(row, i, place) * metre for i in (2, 3, 4))
            slopes, line = [self.number(row, i, place) for i in (5, 6)], self.line(place)
            if length:
                profile.append(Profile(start, length, slopes[0], slopes[1], PROFILE_FORMS[kind], height, line))
        if (layout := self.layout(number, "CANT")) is not None:
            _, row, place = self.get(layout, "IFCALIGNMENTCANT")
            base = self.number(row, 7, place) * metre
        for row, kind, place in self.segments(layout, "CANT", CANT_FORMS):
            start, length, *starts = (self.number(row, i, place) * metre for i in (2, 3, 4, 6))
            left, right = (self.number(row, i, place, self.number(row, i - 1, place)) * metre for i in (5, 7))
            sides, line = ((starts[0], starts[1]), (left, right)), self.line(place)
            if length:
                cant.append(Cant(start, length, *sides, CANT_FORMS[kind], line))
        if not plan:
            raise self.fault(self.entities[number][2], f"'{name}' has no segments in plan")
        notes = (
            f"IFC 4.3: lengths in plan, in units of {metre:g} m; x east, y north; radii positive to the left; cant "
            "by the heights of both rails; stations not read",
        )
        origin, rows = plan[0].pose or (0.0, 0.0, 0.0), (tuple(plan), tuple(profile), tuple(cant))
        return CivilLine(name, str(self.path), *rows, origin, base, end=end, notes=notes)


def read_step(path: Path) -> Step:
    """The entities of a file. Raises InputError for other schemas than IFC 4.3, for cut files and repeated numbers."""
    text = _COMMENT.sub(lambda m: m[0] if m[0][0] == "'" else "\n" * m[0].count("\n"), read_text(path, "IFC file"))
    step, end, schema, last = Step(path, text), 0, "", ""
    while match := _STATEMENT.match(text, end):
        place, end, last = match.start(1), match.end(), match[1]
        if not last.startswith("#"):
            schema = last if last.upper().startswith("FILE_SCHEMA") else schema
            continue
        if (entity := _ENTITY.match(last)) is None:
            raise step.fault(place, f"{shortened(last, 40)!r} is no entity; allowed: #1=NAME(...);")
        number = int(entity[1])
        if number in step.entities:
            raise step.fault(place, f"#{number} is there twice, first in line {step.line(step.entities[number][2])}")
        step.entities[number] = entity[2].upper(), entity[3], place
        if len(step.entities) > MOST_ENTITIES:
            raise step.fault(place, f"more than {MOST_ENTITIES} entities; allowed: fewer (export the alignments alone)")
    if "IFC4X3" not in schema.upper():
        shown = f"FILE_SCHEMA is {schema[11:].strip() or 'missing'}"
        raise InputError(f"{path}: {shown}; allowed: ('IFC4X3_ADD2'): only IFC 4.3 has alignments of railways")
    if last.upper() != "END-ISO-10303-21":
        raise step.fault(len(text), "the file is cut off: END-ISO-10303-21; is missing at its end")
    return step


def _decoded(text: str) -> str:
    """A text without the escapes of ISO 10303-21."""

    def letters(match: re.Match[str]) -> str:
        if match[1] is not None:
            return bytes.fromhex(match[1]).decode("utf-16-be", "replace")
        if match[2] or match[3]:
            return chr(int(match[2], 16) if match[2] else ord(match[3]) + 128)
        return "" if match[0][1] == "P" else match[0][0]

    return _ESCAPE.sub(letters, text)


def read_ifc(path: Path) -> dict[str, Any]:
    """The alignments of a file by their names, each as a function that reads it. Raises InputError."""
    step = read_step(path)
    lines: dict[str, Any] = {}
    for number in step.of("IFCALIGNMENT"):
        _, row, _ = step.get(number, "IFCALIGNMENT")
        if step.layout(number, "HORIZONTAL") is not None:
            name = row[2] if len(row) > 2 and isinstance(row[2], str) and row[2] else f"#{number}"
            name = name if name not in lines else f"{name} #{number}"
            lines[name] = partial(step.alignment, number, name)
    return lines


class Word(str):
    """What stands without quotes: a reference, a value of an enumeration."""


_DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"


def _written(value: Any) -> str:
    """A value as ISO 10303-21 has it."""
    if value is None or isinstance(value, Word):
        return value or "$"
    if isinstance(value, int | float):
        plain = repr(float(value))
        return f"{value:.16E}" if "e" in plain else plain
    if isinstance(value, str):
        plain = value.replace("\\", "\\\\").replace("'", "''")
        return "'" + re.sub(r"[^ -~]+", lambda m: f"\\X2\\{m[0].encode('utf-16-be').hex().upper()}\\X0\\", plain) + "'"
    return f"({','.join(map(_written, value))})"


def ifc_text(line: CivilLine, base: float, date: str) -> str:
    """A file of one alignment in metres. base: distance over which cant is counted [m]."""
    rows = list[str]()

    def add(name: str, *values: Any) -> Word:
        rows.append(f"#{len(rows) + 1}={name}({','.join(map(_written, values))});")
        return Word(f"#{len(rows)}")

    def root(name: str, *values: Any) -> Word:
        number = uuid.uuid5(uuid.NAMESPACE_URL, f"{line.name} {date} {len(rows)}").int
        return add(name, "".join(_DIGITS[number >> shift & 63] for shift in range(126, -1, -6)), None, *values)

    def layout(name: str, segments: Sequence[tuple[Any, ...]], *further: Any) -> Word:
        whole = root(name, None, None, None, None, None, *further)
        designs = [add(f"{name}SEGMENT", None, None, *segment) for segment in segments]
        parts = [root("IFCALIGNMENTSEGMENT", *[None] * 3, place, None, design) for design in designs]
        root("IFCRELNESTS", None, None, whole, parts)
        return whole

    axes = add("IFCAXIS2PLACEMENT3D", add("IFCCARTESIANPOINT", [0.0, 0.0, 0.0]), None, None)
    place = add("IFCLOCALPLACEMENT", None, axes)
    pairs = ((".LENGTHUNIT.", ".METRE."), (".PLANEANGLEUNIT.", ".RADIAN."))
    units = [add("IFCSIUNIT", Word("*"), Word(kind), None, Word(name)) for kind, name in pairs]
    view = add("IFCGEOMETRICREPRESENTATIONCONTEXT", None, "Model", Word("3"), 1e-6, axes, None)
    project = root("IFCPROJECT", line.name, *[None] * 4, [view], add("IFCUNITASSIGNMENT", units))
    alignment = root("IFCALIGNMENT", line.name, None, None, place, None, None)
    root("IFCRELAGGREGATES", None, None, project, [alignment])
    shape = line.level(base)
    points = [add("IFCCARTESIANPOINT", point) for point in shape.position(line.edges)[:, :2].tolist()]
    rows_of: dict[str, list[tuple[Any, ...]]] = {"HORIZONTAL": [], "VERTICAL": [], "CANT": []}
    headings = shape.heading(line.edges).tolist()
    for e, point, heading in zip(line.plan, points, headings, strict=False):
        constant = e.start == e.end and e.form != "viennese"
        radii = [0.0 if k == 0.0 else 1.0 / k for k in (e.start, e.end)]
        kind = ("CIRCULARARC" if e.start else "LINE") if constant else _kind(PLAN_FORMS, e.form)
        rows_of["HORIZONTAL"].append((point, heading, *radii, e.length, e.centre_of_gravity_height, Word(f".{kind}.")))
    rows_of["HORIZONTAL"].append((points[-1], headings[-1], 0.0, 0.0, 0.0, None, Word(".LINE.")))
    for p in line.profile_rows() if line.profile or line.cant else []:  # cant stands on a profile, be it level
        kind = "CONSTANTGRADIENT" if p.slope_start == p.slope_end else _kind(PROFILE_FORMS, p.form)
        rows_of["VERTICAL"].append((p.start, p.length, p.height, p.slope_start, p.slope_end, None, Word(f".{kind}.")))
    if rows_of["VERTICAL"]:
        last = p.end, 0.0, p.end_height, p.slope_end, p.slope_end, None, Word(".CONSTANTGRADIENT.")
        rows_of["VERTICAL"].append(last)
    for c in line.cant_rows() if line.cant else []:
        kind = "CONSTANTCANT" if c.rails_start == c.rails_end else _kind(CANT_FORMS, c.form)
        heights = (height for rail in (0, 1) for height in (c.rails_start[rail], c.rails_end[rail]))
        rows_of["CANT"].append((c.start, c.length, *heights, Word(f".{kind}.")))
    if line.cant:
        left, right = c.rails_end
        rows_of["CANT"].append((c.end, 0.0, left, left, right, right, Word(".CONSTANTCANT.")))
    further = {"CANT": (base,)}
    parts = [layout(f"IFCALIGNMENT{kind}", rows, *further.get(kind, ())) for kind, rows in rows_of.items() if rows]
    root("IFCRELNESTS", None, None, alignment, parts)
    header = (
        "FILE_DESCRIPTION(('ViewDefinition [Alignment-basedView]'),'2;1');",
        f"FILE_NAME({_written(line.name)},'{date}T00:00:00',(''),(''),'wrsim','wrsim','');",
        "FILE_SCHEMA(('IFC4X3_ADD2'));",
    )
    lines = "ISO-10303-21;", "HEADER;", *header, "ENDSEC;", "DATA;", *rows, "ENDSEC;", "END-ISO-10303-21;", ""
    return "\n".join(lines)


def _kind(forms: Mapping[str, str], form: str) -> str:
    """The last PredefinedType of a form: the first of a form are its constants."""
    return {known: name for name, known in forms.items()}[form]
