"""What keys may hold: pydantic's own types with limits, and the text of what they allow.

Limits and an example are beside the type::

    Friction = Annotated[float, number(0, 2, "dry steel 0.3 to 0.5")]

``requirement`` makes "a number from 0 to 2 (dry steel 0.3 to 0.5)" of it. Other descriptions take its place;
``{each}`` in one is replaced by the requirement of an entry.
"""

import datetime
import math
import types
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from wrsim.errors import nearest
from wrsim.inputs.file_kinds import TERMS

MOST_POINTS = 100_000
"""Longest series that ``{from, to, step}`` may describe."""
T = TypeVar("T")


def number(low: float | None = None, high: float | None = None, example: str = "") -> Any:
    """Limits of a finite number."""
    return Field(ge=low, le=high, description=example or None)


def positive(high: float | None = None, example: str = "") -> Any:
    """Limits of a number above 0."""
    return Field(gt=0, le=high, description=example or None)


def text(meaning: str) -> Any:
    """A text with at least one visible character; meaning: what it is, such as "a title"."""
    return Field(pattern=r"^[^\x00]*[^\s\x00][^\x00]*$", description=f"{meaning} in quotes")


def refuse(message: str) -> PydanticCustomError:
    """The error of a validator, with its reason."""
    return PydanticCustomError("fault", message)  # type: ignore[arg-type]


def spread(value: Any) -> Any:
    """A number or a range as its numbers; the end of a range is included if met within 1e-9 of a step."""
    if not isinstance(value, dict):
        return value if isinstance(value, (list, tuple)) else (value,)
    if set(value) != {"from", "to", "step"}:
        raise refuse("a range needs exactly the keys from, to and step")
    try:
        first, last, step = (math.nan if isinstance(v, bool | str) else float(v) for v in (value[k] for k in RANGE))
    except (TypeError, OverflowError):
        first = last = step = math.nan
    if not math.isfinite(first + last + step):
        raise refuse("from, to and step must be finite numbers")
    if step <= 0.0 or last < first:
        raise refuse("a range needs a step above 0 and from <= to")
    if (last - first) / step >= MOST_POINTS:
        raise refuse(f"this range has more than {MOST_POINTS} values; must be a larger step")
    count = math.floor((last - first) / step + 1e-9) + 1
    return tuple(min(first + i * step, last) for i in range(count))


RANGE = ("from", "to", "step")
List = Annotated[tuple[T, ...], Field(strict=False)]
"""A list, perhaps empty, of numbers, words or tables."""
Series = Annotated[
    tuple[T, ...],
    Field(strict=False, min_length=1, description="{each}, a list of such numbers, or {from = .., to = .., step = ..}"),
    BeforeValidator(spread),
]
"""One or many numbers: a number, a list, or a range."""
Two = Annotated[tuple[T, T], Field(strict=False)]
Three = Annotated[
    tuple[T, T, T],
    Field(strict=False, description="three numbers for x (forward), y (left), z (up), each {each}"),
]
Source = Annotated[str, text("where the data come from")]
Day = Annotated[datetime.date, Field(description="a date without quotes, like 2026-01-31")]

Plain = TypeVar("Plain")
OrTable = Annotated[
    Annotated[Plain, Tag("plain")] | Annotated[T, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, dict) else "plain"),
]
"""A plain value, or a table with more."""


class Kind(NamedTuple):
    """The annotation of a field in its parts: type, limits, description, and whether a tag chooses among types."""

    base: Any
    limits: tuple[Any, ...]
    description: str
    tagged: bool


@cache
def fields(section: type) -> dict[str, Any]:
    """Annotation of every field of a section, with what is written beside its type."""
    return get_type_hints(section, include_extras=True)


def unpacked(annotation: Any) -> Kind:
    """The parts of an annotation; ``| None`` counts for nothing."""
    limits: list[Any] = []
    description, tagged = "", False
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *beside = get_args(annotation)
            for mark in beside:
                if isinstance(mark, FieldInfo):
                    limits += mark.metadata
                    description = mark.description or description
                    tagged |= mark.discriminator is not None
                tagged |= isinstance(mark, Discriminator)
        elif is_union(annotation) and type(None) in get_args(annotation) and len(get_args(annotation)) == 2:
            annotation = next(a for a in get_args(annotation) if a is not type(None))
        else:
            return Kind(annotation, tuple(limits), description, tagged)


def is_union(annotation: Any) -> bool:
    """True for ``A | B``."""
    return get_origin(annotation) in (Union, types.UnionType)


def entry_of(annotation: Any) -> Any:
    """The annotation of the entries of a list; None for what is no list."""
    base = unpacked(annotation).base
    return get_args(base)[0] if get_origin(base) is tuple else None


def table_header(annotation: Any) -> str:
    """How a table, or one of several kinds of tables, is called in messages; empty for what is none."""
    base = unpacked(annotation).base
    if is_union(base):
        headers = [table_header(member) for member in get_args(base)]
        return headers[0].partition(" with ")[0] if all(headers) else ""
    return getattr(base, "header", "")


def requirement(annotation: Any) -> str:
    """Text of what is allowed, to follow "must be"."""
    base, limits, description, _ = unpacked(annotation)
    if base in (int, float):
        return _number_text(base, limits, description)
    if description:
        return description.replace("{each}", requirement(entry_of(annotation)) if entry_of(annotation) else "")
    if get_origin(base) is Literal:
        return choice(get_args(base))
    if base is bool:
        return "true or false (without quotes)"
    if table_header(annotation):
        return f"a table ({table_header(annotation)})"
    if is_union(base):
        return " or ".join(requirement(member) for member in get_args(base))
    if get_origin(base) is tuple:
        each = entry_of(annotation)
        return f"a list of tables ({table_header(each)})" if table_header(each) else f"a list, each {requirement(each)}"
    if get_origin(base) is dict:
        return f"tables ({table_header(get_args(base)[1])})"
    return "text in quotes"


ELSEWHERE: dict[str, list[str]] = TERMS["elsewhere"]
"""Words of other programs and of the field, and what comes nearest to them here."""


def choice(allowed: tuple[Any, ...], value: Any = None) -> str:
    """Text: which words are allowed, and which of them ``value`` was probably meant to be."""
    quoted = [f'"{word}"' if isinstance(word, str) else str(word) for word in allowed]
    near = meant(value, [w for w in allowed if isinstance(w, str)]) if isinstance(value, str) else ""
    # nobody reads a list of a hundred words beside the right one
    return (one_of(quoted) if len(quoted) < 40 or not near else f"one of {len(quoted)} words") + near


def meant(word: str, allowed: Sequence[str]) -> str:
    """What comes nearest to a word of other programs, or the word that is like it, to end a sentence; or nothing."""
    if names := [f'"{name}"' for name in ELSEWHERE.get(word.lower().replace("_", "-"), ()) if name in allowed]:
        return f"; did you mean {one_of(names)}?"
    near = nearest(word, allowed)
    return f'; did you mean "{near}"?' if near else ""


def repeated(names: Iterable[T]) -> list[T]:
    """Names that are there more than once."""
    return [name for name, count in Counter(names).items() if count > 1]


def one_of(quoted: Sequence[str]) -> str:
    """Words with commas and an or."""
    return ", ".join(quoted[:-1]) + " or " + quoted[-1] if len(quoted) > 1 else quoted[0]


def number_limits(limits: tuple[Any, ...]) -> tuple[float, float, bool]:
    """Lowest and highest number allowed, and whether the lowest itself is excluded."""
    low, high, excluded = -math.inf, math.inf, False
    for limit in limits:
        if isinstance(limit, Ge | Gt):
            low, excluded = (limit.ge, False) if isinstance(limit, Ge) else (limit.gt, True)  # type: ignore[assignment]
        elif isinstance(limit, Le):
            high = limit.le  # type: ignore[assignment]
    return low, high, excluded


def _number_text(base: type, limits: tuple[Any, ...], description: str) -> str:
    if description and not limits:
        return description
    lowest, highest, excluded = number_limits(limits)
    phrase = "a whole number" if base is int else "a number"
    low, high = (plain_number(v) if math.isfinite(v) else "" for v in (lowest, highest))
    if low and high:
        phrase += f" above {low} and at most {high}" if excluded else f" from {low} to {high}"
    elif low:
        phrase += f" above {low}" if excluded else f" not below {low}"
    elif high:
        phrase += f" not above {high}"
    elif base is float:
        phrase = "a finite number"
    return phrase + (f" ({description})" if description else "")


def plain_number(value: float) -> str:
    """Write a number without an exponent where that is shorter to read."""
    return str(int(value)) if value == int(value) and (abs(value) < 1e7 or isinstance(value, int)) else f"{value:g}"


def refusal(annotation: Any, place: list[Any], value: Any) -> str:
    """The sentence on a value, or on its entry at ``place``, that pydantic refused."""
    base = unpacked(annotation).base
    if place and isinstance(value, list | tuple) and (each := entry_of(annotation)) and place[0] < len(value):
        return f"entry [{place[0]}] {refusal(each, place[1:], value[place[0]])}"
    if place and isinstance(value, dict) and get_origin(base) is tuple:  # a range
        return f"{'from' if place[0] == 0 else 'to'} must be {requirement(entry_of(annotation))}"
    if get_origin(base) is Literal:
        return "must be " + choice(get_args(base), value)
    empty = "the list is empty: " if value in ([], ()) and get_origin(base) is tuple else ""
    return f"{empty}must be {requirement(annotation)}"


Row = TypeVar("Row")
Rows = TypeVar("Rows", bound=tuple[tuple[float, ...], ...])


def rising(rows: Rows) -> Rows:
    """Rows whose first numbers rise, from 0 on."""
    for position, (before, row) in enumerate(pairwise(rows), 1):
        if row[0] <= before[0]:
            raise refuse(f"row [{position}] must lie behind the row before it: the first numbers rise")
    if rows[0][0] < 0.0:
        raise refuse(f"row [0] begins with {rows[0][0]:g}: must not lie before 0")
    return rows


RisingRows = Annotated[
    tuple[Row, ...],
    Field(strict=False, min_length=1, description="a list of rows in rising order, each {each}"),
    AfterValidator(rising),
]
"""A table of rows whose first numbers rise from 0 on."""


def within(low: float, high: float, unit: str) -> AfterValidator:
    """Limits of the numbers of rows, but for the first of each."""

    def check(rows: Rows) -> Rows:
        for position, row in enumerate(rows):
            for value in row[1:]:
                if not low <= value <= high:
                    raise refuse(f"row [{position}] has {value:g} {unit}: must be from {low:g} to {high:g} {unit}")
        return rows

    return AfterValidator(check)
