"""A table of a file: strict, frozen, and able to report all its faults at once.

pydantic checks the fields; on top of it a Section

- answers an unknown key with the one that was probably meant: a slip of spelling, another unit (``radius_mm`` for
  ``radius_m``), a name from other programs (``mu`` for ``friction``), a key of another table;
- applies ``raw_faults`` on combinations of keys even when some values are wrong; one slip is one fault (the right key
  is not reported missing as well).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from inspect import signature
from math import radians
from operator import gt, le
from typing import Any, ClassVar, Literal, NamedTuple, Self, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from wrsim.errors import nearest
from wrsim.inputs.file_kinds import TERMS, packaged
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.us_units import converted, metric, metric_key
from wrsim.inputs.values import choice, entry_of, fields, refusal, refuse, requirement, table_header, unpacked

STRICT = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)
FAULT, ABSENT, UNKNOWN = "fault", "absent", "unknown"
"""Types of faults whose messages are final; all others are pydantic's."""
MOST_FAULTS = 50
"""Faults of one file that are listed; more are counted."""
ALIASES: dict[str, dict[str, list[str]]] = packaged("wrsim.inputs", "aliases.toml")
UNITS: dict[str, str] = TERMS["units"]
"""Unit endings of keys and how they are written in a sentence."""
THERMAL = ("_W_per_mK", "_J_per_kgK", "_kg_per_m3")
TO_SI: dict[str, Callable[[float], float]] = {
    "_mm": lambda x: x / 1e3, "_kmh": lambda x: x / 3.6, "_deg": radians, "_MPa": lambda x: 1e6 * x,
    "_GPa": lambda x: 1e9 * x, "_MPa_per_mm": lambda x: 1e9 * x,
} | dict.fromkeys(
    ("_kN", "_kN_per_m", "_kNs_per_m", "_kNm_per_rad", "_kNms_per_rad"), lambda x: 1e3 * x
) | dict.fromkeys(("_m", "_s", "_s_per_m", "_Hz", "_kg_m2", "_K", "_C", *THERMAL), float)  # fmt: skip
"""Unit endings of keys and what brings their numbers to SI units; see `Section.to_si`."""


S = TypeVar("S", bound="Section")
T = TypeVar("T")


SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


_CHECKED: ContextVar[Mapping[int, Any]] = ContextVar("_CHECKED")


@contextmanager
def checked_before(sections: Mapping[int, Any]) -> Iterator[None]:
    """Within this block tables are not checked again of which the sections are known, by their ``id``."""
    before = _CHECKED.set(sections)
    try:
        yield
    finally:
        _CHECKED.reset(before)


class Fault(NamedTuple):
    """One thing wrong in the combination of keys, with a sentence about it.

    path: key of the section, keys down into a table of it, or nothing for the section itself.
    missing: the key has to be given; the message is what it must be.
    """

    path: str | KeyPath
    message: str
    missing: bool = False


class Section(BaseModel):
    """Base of all tables that users write."""

    model_config = STRICT

    header: ClassVar[str] = "this table"
    """Name of the table in messages; a subclass sets it: ``header="[vehicle]"``."""
    foreign: ClassVar[tuple[str, ...]] = ()
    """Tables of a file that are those of another kind of file and are not among its keys."""
    aliases: ClassVar[dict[str, list[str]]] = {}
    """Key -> its names in other programs (``inputs/aliases.toml``)."""
    former: ClassVar[dict[str, str]] = {}
    """Deprecated keys, which are still taken -> those in their place."""
    elsewhere: ClassVar[dict[str, str]] = {}
    """Keys of other tables -> the header of that table, before those of ``keys_elsewhere``."""
    keys_elsewhere: ClassVar[Callable[[Any], dict[str, str]]] = staticmethod(lambda table: {})
    """Gives the same of a table of a scenario."""
    one_of: ClassVar[tuple[str, ...]] = ()
    """Rows of keys (with spaces between) of which exactly one is given, the usual one first."""
    at_most_one: ClassVar[tuple[str, ...]] = ()
    """Rows of keys of which one may be given."""
    together: ClassVar[tuple[str, ...]] = ()
    """Rows of keys that are given all or not at all."""
    goes_with: ClassVar[dict[str, str]] = {}
    """Key -> the key or keys, of which one is enough, without which it means nothing."""
    above: ClassVar[dict[str, str]] = {}
    """Key -> the key whose value its own is above."""
    not_above: ClassVar[dict[str, str]] = {}
    """Key -> the key whose value its own is not above."""
    also_called: ClassVar[str] = ""
    """Names of this kind of table in other programs, with spaces between."""

    def __init_subclass__(cls, header: str = "", **rest: Any) -> None:
        super().__init_subclass__(**rest)
        named = (ALIASES.get(kind.__name__, {}) for kind in reversed(cls.__mro__))
        cls.aliases = {key: names for aliases in named for key, names in aliases.items()}
        if header:
            cls.header = header

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Yield faults in the combination of keys; called with the raw table, whatever its values."""
        yield from ()

    @classmethod
    def _ways(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Faults against `one_of`, `at_most_one`, `together` and `goes_with`."""
        for row in (*cls.one_of, *cls.at_most_one):
            first, *rest = row.split()
            present = [key for key in row.split() if key in raw]
            if len(present) > 1:
                yield Fault(present[-1], f"cannot be given with {present[0]}: give one of them")
            elif not present and row in cls.one_of:
                needed = f"must be {requirement(fields(cls)[first])} (or give {' or '.join(rest)})"
                yield Fault(first, needed, missing=True)
        for row in cls.together:
            present = [key for key in row.split() if key in raw]
            for key in row.split() if present else ():
                if key not in raw:
                    needed = f"goes with {present[0]}: must be {requirement(fields(cls)[key])}"
                    yield Fault(key, needed, missing=True)
        for key, needs in cls.goes_with.items():
            if key in raw and not any(need in raw for need in needs.split()):
                yield Fault(key, f"goes with {' or '.join(needs.split())}")

    def _order(self) -> Iterator[Fault]:
        """Faults against `above` and `not_above`."""
        for rule, must, holds in ((self.above, "must be", gt), (self.not_above, "must not be", le)):
            for key, bound in rule.items():
                value, limit = getattr(self, key), getattr(self, bound)
                if value is not None and limit is not None and not holds(value, limit):
                    yield Fault(key, f"{must} above {bound} ({limit:g})")

    def consistency(self) -> Iterator[Fault]:
        """Yield faults in the combination of values; called when every value and every rule is met."""
        yield from ()

    def of_side(self, key: str, side: str) -> tuple[str, Any]:
        """The key of one side and its value or, where that is not given, those of both sides; see both_or_sides."""
        sided = side_key(key, side)
        return (key, getattr(self, key)) if getattr(self, sided) is None else (sided, getattr(self, sided))

    def to_si(self, target: Callable[..., T], /, **extra: Any) -> T:
        """What a dataclass or a function makes of values in SI units: its parameters have the names of keys without
        their units, or are among the others. A key that is not given leaves the parameter its default."""
        values: dict[str, Any] = {}
        for key, name, convert in _si_fields(type(self), target):
            value = getattr(self, key)
            if isinstance(value, tuple) and all(isinstance(each, float) for each in value):
                values[name] = tuple(map(convert, value))
            elif value is not None:
                values[name] = convert(value) if isinstance(value, float) else value
        return target(**values | extra)

    @model_validator(mode="wrap")
    @classmethod
    def _all_at_once(cls, raw: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if isinstance(raw, cls):
            return raw
        if isinstance(before := _CHECKED.get({}).get(id(raw)), cls):
            return before
        if not isinstance(raw, dict):
            raise refuse(f"must be a table ({cls.header})")
        data, faults, guessed = cls._translate(raw)
        for name, field in cls.model_fields.items():
            if field.is_required() and name not in data:
                faults.append(_detail(ABSENT, f"must be {requirement(fields(cls)[name])}", (name,), raw))
        section: Self | None = None
        try:
            section = handler(data)
        except ValidationError as error:
            errors = error.errors(include_url=False)
            inside = {e["loc"][0] for e in errors if len(e["loc"]) > 1}
            known = {f["loc"] for f in faults}
            for e in errors:
                key = str(e["loc"][0])
                if key not in data or key in guessed:
                    continue  # named above
                if e["type"] == "too_short" and e["loc"] == (key,) and key in inside:
                    continue  # pydantic counts good entries only, and the bad ones are reported
                fault = _described(fields(cls)[key], e, data[key])
                if e["type"] in (FAULT, ABSENT, UNKNOWN) or fault["loc"] not in known:
                    faults.append(fault)
                    known.add(fault["loc"])
        named = {f["loc"] for f in faults}
        combinations = [*cls._ways(data), *cls.raw_faults(data)]
        if section is not None and not faults and not combinations:
            combinations = [*section._order(), *section.consistency()]
        for rule in combinations:
            path = (rule.path,) if isinstance(rule.path, str) else rule.path
            if path in named or (path and path[0] in guessed):
                continue
            named.add(path)
            value: Any = data
            for part in path:
                value = value.get(part) if isinstance(value, dict) else None
            faults.append(_detail(ABSENT if rule.missing else FAULT, rule.message, path, value))
        if faults or section is None:
            raise ValidationError.from_exception_data(cls.__name__, [_in_written_unit(f, raw, data) for f in faults])
        return section

    @classmethod
    def _translate(cls, raw: dict[str, Any]) -> tuple[dict[str, Any], list[InitErrorDetails], set[str]]:
        """The table with slips put right, the faults that report them, and the keys so guessed."""
        data: dict[str, Any] = {}
        faults: list[InitErrorDetails] = []
        guessed: set[str] = set()
        for written, value in raw.items():
            new = cls.former.get(written)
            key = written if new is None or new in raw else new
            if key in cls.model_fields:
                data[key] = value
                continue
            if (ours := metric(str(key))) is not None and ours.key in cls.model_fields:
                guessed |= cls._convert(key, value, raw, data, faults)
                continue
            few = len(faults) < MOST_FAULTS  # more are not listed
            message, meant = cls._unknown(str(key), raw) if few else ("unknown key", None)
            faults.append(_detail(UNKNOWN, message, (str(key),), value))
            if meant is not None and meant not in raw:
                guessed.add(meant)
                data[meant] = value
        return data, faults, guessed

    @classmethod
    def _convert(
        cls, key: str, value: Any, raw: dict[str, Any], data: dict[str, Any], faults: list[InitErrorDetails]
    ) -> set[str]:
        """Put the value of a key in US units under the metric key; or its fault, and the key that it was meant for."""
        name, convert = metric(key) or (key, float)
        twins = [twin for twin in raw if twin != key and metric_key(str(twin)) == name]
        message = f"cannot be given with {twins[0]}: give one of them" if name in {*raw, *data} else ""
        try:
            data[name] = converted(value, convert)
        except (ValueError, ZeroDivisionError):
            message = message or f"must be numbers of this unit; rows and words stand under {name}"
        if message:
            faults.append(_detail(FAULT, message, (key,), value))
            data.setdefault(name, value)
        return {name} if message else set()

    @classmethod
    def keys_meant(cls, raw: Any) -> set[str]:
        """Keys of this section that a raw table holds, slips put right."""
        return set(cls._translate(raw)[0]) if isinstance(raw, dict) else set()

    @classmethod
    def _unknown(cls, key: str, raw: dict[str, Any]) -> tuple[str, str | None]:
        """The message for an unknown key and the key of this section that was meant, if any."""
        allowed = [*cls.model_fields, *cls.foreign]
        elsewhere = cls.keys_elsewhere(cls) | cls.elsewhere
        meant = next((ours for ours, names in cls.aliases.items() if key in names), None)
        meant = meant or _same_stem(key, allowed)
        if meant is None and key not in elsewhere:
            stems = {_stem(k): k for k in allowed}
            near = nearest(key, allowed) or nearest(_stem(key), list(stems))
            meant = stems.get(near, near) if near else None
        kind = unpacked(cls.model_fields[meant].annotation).base if meant in cls.model_fields else None
        if isinstance(kind, type) and issubclass(kind, Section) and raw[key] and not kind.keys_meant(raw[key]):
            meant = None  # a table that takes none of its keys
        if meant is not None:
            unit = unit_of(meant)
            in_unit = f" (in {UNITS[unit]})" if unit and unit != unit_of(key) else ""
            if meant in raw:
                return f"unknown key; did you mean '{meant}'{in_unit}, which is given already?", meant
            return f"unknown key; did you mean '{meant}'{in_unit}?", meant
        misplaced = key if key in elsewhere else _same_stem(key, list(elsewhere))
        if misplaced is not None:
            return f"unknown key; '{misplaced}' belongs in {elsewhere[misplaced]}", None
        return f"unknown key; {cls.header} takes " + ", ".join(allowed), None


class Choice(Section):
    """Base of tables of several kinds, by the value of one key; a subclass names its own: ``kind="arc"``."""

    tag: ClassVar[str] = "kind"

    def __init_subclass__(cls, kind: str = "", **rest: Any) -> None:
        super().__init_subclass__(**rest)
        if kind:
            cls.__annotations__[cls.tag] = Literal[kind]  # type: ignore[valid-type]
            cls.header = f"{cls.header} with {cls.tag} = {kind}"


def kinds_in(union: Any) -> dict[str, Any]:
    """Kinds of tables of a union by their names."""
    members = get_args(unpacked(union).base)
    return {get_args(fields(member)[member.tag])[0]: member for member in members}


@cache
def _si_fields(section: type[Section], target: Callable[..., T]) -> list[tuple[str, str, Callable[[float], float]]]:
    """Keys of a section for the parameters of a function, their names without unit, and the conversion to SI units."""
    units = {key: max((u for u in TO_SI if key.endswith(u)), key=len, default="") for key in section.model_fields}
    named = signature(target).parameters
    rows = ((key, key.removesuffix(unit), TO_SI.get(unit, float)) for key, unit in units.items())
    return [row for row in rows if row[1] in named]


def side_key(key: str, side: str) -> str:
    """The key of one side beside the one for both: ``radius_left_mm`` beside ``radius_mm``."""
    stem, *unit = key.split("_", 1)
    return "_".join((stem, side, *unit))


def on_side(sections: Sequence[S], side: str) -> list[tuple[int, S]]:
    """Those of some tables with a key ``side`` that hold for one side, and their places among all."""
    return [(i, each) for i, each in enumerate(sections) if each.side in (side, "both")]  # type: ignore[attr-defined]


def both_or_sides(raw: dict[str, Any], common: str, *, needed: str = "", complete: bool = False) -> Iterator[Fault]:
    """Faults of a key for both sides and its two relatives for single sides, which exclude each other.

    complete: one side needs the other; needed (what the key must be): one way is needed, implies complete.
    """
    left, right = side_key(common, "left"), side_key(common, "right")
    sides = [key for key in (left, right) if key in raw]
    if common in raw and sides:
        yield Fault(common, f"is for both sides and cannot be given with {' and '.join(sides)}")
    elif common not in raw and not sides and needed:
        yield Fault(common, f"must be {needed} (or give {left} and {right})", missing=True)
    elif len(sides) == 1 and (complete or needed):
        yield Fault(left if right in raw else right, f"goes with {sides[0]} (or give {common})", missing=True)


def given(*values: T | None) -> T:
    """The first value that is given; for keys of which the rules of their section ask for one."""
    return next(value for value in values if value is not None)


def _detail(kind: str, message: str, loc: tuple[str | int, ...], value: Any) -> InitErrorDetails:
    return InitErrorDetails(type=PydanticCustomError(kind, message), loc=loc, input=value)  # type: ignore[arg-type]


def _in_written_unit(fault: InitErrorDetails, raw: dict[str, Any], data: dict[str, Any]) -> InitErrorDetails:
    """A fault of a metric key that was given in US units, at the key as it was written."""
    name, *place = fault["loc"] or ("",)
    key = next((k for k in raw if k != name and metric_key(str(k)) == name and name not in raw), None)
    if key is None or name not in data or not isinstance(error := fault["type"], PydanticCustomError):
        return fault
    message = f"{error.message_template}: it is {name} = {data[name]:.6g}" if isinstance(data[name], float) else ""
    return _detail(error.type, message or error.message_template, (key, *place), raw[key])


def _described(annotation: Any, error: Any, value: Any) -> InitErrorDetails:
    """The message for an error of pydantic in a field of this annotation and value; those of inner tables are final."""
    key, *place = error["loc"]
    kind, depth = unpacked(annotation), 0
    if entry_of(annotation) is not None and place:
        kind, depth = unpacked(entry_of(annotation)), 1
    if kind.tagged and len(place) > depth:
        del place[depth]  # pydantic's tag of the chosen type
    if error["type"] in (FAULT, ABSENT, UNKNOWN):
        return _detail(error["type"], error["msg"], (key, *place), error["input"])
    if depth and table_header(entry_of(annotation)):
        return _choice_of_table(kind.base, error, (key, *place), table_header(entry_of(annotation)))
    if kind.tagged and not place and isinstance(value, dict):
        return _choice_of_table(kind.base, error, (key,), table_header(annotation))
    return _detail(FAULT, refusal(annotation, place, value), (key,), value)


def _choice_of_table(base: Any, error: Any, place: KeyPath, header: str) -> InitErrorDetails:
    """The fault of an entry that is no table, or one of no known kind."""
    entry = error["input"]
    if "discriminator" not in error.get("ctx", {}):
        return _detail(FAULT, f"must be a table ({header})", place, entry)
    by = error["ctx"]["discriminator"].strip("'")
    allowed = tuple(tag for member in get_args(base) for tag in get_args(unpacked(fields(member)[by]).base))
    if by not in entry:
        return _detail(ABSENT, f"must be {choice(allowed)}", (*place, by), entry)
    message = choice(allowed, entry[by])
    if "did you mean" not in message:
        message += _kind_meant(base, by, entry[by])
    return _detail(FAULT, f"must be {message}", (*place, by), entry[by])


def _kind_meant(base: Any, by: str, value: Any) -> str:
    """The kind of table with this name in other programs, or with a key that takes the value, to end a sentence."""
    for member in get_args(base):
        (tag,) = get_args(unpacked(fields(member)[by]).base)
        if value in member.also_called.split():
            return f'; did you mean "{tag}"?'
        for key, annotation in fields(member).items():
            if key != by and value in get_args(unpacked(annotation).base):
                return f'; did you mean "{tag}" with {key} = "{value}"?'
    return ""


def unit_of(key: str) -> str:
    """Unit ending of a key, longest first; empty if it has none."""
    for unit in sorted(UNITS, key=len, reverse=True):
        if key.endswith("_" + unit) or key.lower().endswith("_" + unit.lower()):
            return unit
    return ""


def _stem(key: str) -> str:
    unit = unit_of(key)
    return key[: -len(unit) - 1].lower() if unit else key.lower()


def _same_stem(key: str, allowed: list[str]) -> str | None:
    """The allowed key that differs from ``key`` in its unit or its capitals only."""
    return next((a for a in allowed if a.lower() == key.lower()), None) or next(
        (a for a in allowed if _stem(a) == _stem(key)), None
    )
