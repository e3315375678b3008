"""What a key may hold: annotations for the fields of a Section.

Each annotation checks a value and, when it is refused, says in one sentence what is allowed. Use::

    friction: Annotated[float, Quantity(0, 2)] = 0.35
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

MOST_POINTS = 100_000
"""Longest series that ``{from, to, step}`` may describe."""


def refuse(message: str) -> PydanticCustomError:
    """Return the error that says why a value is refused."""
    return PydanticCustomError("value", message)  # type: ignore[arg-type]


class Annotation:
    """Base of the annotations: ``check`` returns the value to keep or raises ``refuse(...)``."""

    def words(self) -> str:
        """Say what is allowed, to follow "must be"."""
        raise NotImplementedError

    def check(self, value: Any) -> Any:
        """Return the value in its final type."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.check)

    def refusal(self) -> PydanticCustomError:
        """Return the error for a value that is not allowed."""
        return refuse("must be " + self.words())


@dataclass(frozen=True)
class Quantity(Annotation):
    """A finite number from ``low`` to ``high``; ``above`` excludes the lower end, ``example`` helps users."""

    low: float = -math.inf
    high: float = math.inf
    above: float | None = None
    example: str = ""

    def words(self) -> str:
        low = self.above if self.above is not None else self.low
        if math.isfinite(low) and math.isfinite(self.high):
            text = (
                f"a number above {plain(low)} and at most {plain(self.high)}"
                if self.above is not None
                else f"a number from {plain(low)} to {plain(self.high)}"
            )
        elif math.isfinite(low):
            text = f"a number above {plain(low)}" if self.above is not None else f"a number not below {plain(low)}"
        elif math.isfinite(self.high):
            text = f"a number not above {plain(self.high)}"
        else:
            text = "a finite number"
        return text + (f" ({self.example})" if self.example else "")

    def check(self, value: Any) -> float:
        number = as_float(value)
        if number is None or not self.holds(number):
            raise self.refusal()
        return number

    def holds(self, number: float) -> bool:
        """True if the number is finite and in range."""
        return self.low <= number <= self.high and math.isfinite(number) and (self.above is None or number > self.above)


@dataclass(frozen=True)
class AwayFromZero(Annotation):
    """A number of either sign with a size from ``least`` to ``most``: the radius of a curve."""

    least: float
    most: float
    example: str = ""

    def words(self) -> str:
        text = f"a number of size {plain(self.least)} to {plain(self.most)}, of either sign"
        return text + (f" ({self.example})" if self.example else "")

    def check(self, value: Any) -> float:
        number = as_float(value)
        if number is None or not self.least <= abs(number) <= self.most:
            raise self.refusal()
        return number


@dataclass(frozen=True)
class Whole(Annotation):
    """A whole number from ``low`` to ``high``."""

    low: int
    high: int

    def words(self) -> str:
        return f"a whole number from {self.low} to {self.high}"

    def check(self, value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not self.low <= value <= self.high:
            raise self.refusal()
        return value


@dataclass(frozen=True)
class Text(Annotation):
    """A text of at least one visible character."""

    meaning: str = "text"

    def words(self) -> str:
        return f"{self.meaning} in quotes"

    def check(self, value: Any) -> str:
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            raise self.refusal()
        return value


@dataclass(frozen=True)
class Switch(Annotation):
    """true or false."""

    def words(self) -> str:
        return "true or false (without quotes)"

    def check(self, value: Any) -> bool:
        if not isinstance(value, bool):
            raise self.refusal()
        return value


@dataclass(frozen=True)
class Day(Annotation):
    """A date."""

    def words(self) -> str:
        return "a date without quotes, like 2026-01-31"

    def check(self, value: Any) -> datetime.date:
        if not isinstance(value, datetime.date):
            raise self.refusal()
        return value


@dataclass(frozen=True)
class Choice(Annotation):
    """One word out of ``allowed``."""

    allowed: tuple[str, ...]

    def words(self) -> str:
        quoted = [f'"{word}"' for word in self.allowed]
        return quoted[0] if len(quoted) == 1 else ", ".join(quoted[:-1]) + " or " + quoted[-1]

    def check(self, value: Any) -> str:
        if isinstance(value, str) and value in self.allowed:
            return value
        near = nearest(value, self.allowed) if isinstance(value, str) else None
        raise refuse(f"must be {self.words()}" + (f'; did you mean "{near}"?' if near else ""))


@dataclass(frozen=True)
class Series(Annotation):
    """One or many numbers in the range of ``each``: a number, a list, or ``{from = .., to = .., step = ..}``.

    The check returns a tuple of floats. The end of a range is kept when it is met within 1e-9 of a step.
    """

    each: Quantity

    def words(self) -> str:
        return f"{self.each.words()}, a list of such numbers, or {{from = .., to = .., step = ..}}"

    def check(self, value: Any) -> tuple[float, ...]:
        if isinstance(value, dict):
            return self._range(value)
        if not isinstance(value, (list, tuple)):
            number = as_float(value)
            if number is None or not self.each.holds(number):
                raise self.refusal()
            return (number,)
        if not value:
            raise refuse("the list is empty: must be " + self.words())
        numbers = [as_float(v) for v in value]
        for position, number in enumerate(numbers):
            if number is None or not self.each.holds(number):
                raise refuse(f"entry [{position}] must be {self.each.words()}")
        return tuple(n for n in numbers if n is not None)

    def _range(self, value: dict[str, Any]) -> tuple[float, ...]:
        if set(value) != {"from", "to", "step"}:
            raise refuse("a range needs exactly the keys from, to and step")
        first, last, step = (as_float(value[k]) for k in ("from", "to", "step"))
        if first is None or last is None or step is None:
            raise refuse("from, to and step must be finite numbers")
        for name, end in (("from", first), ("to", last)):
            if not self.each.holds(end):
                raise refuse(f"{name} must be {self.each.words()}")
        if step <= 0.0 or last < first:
            raise refuse("a range needs a step above 0 and from <= to")
        if (last - first) / step >= MOST_POINTS:
            raise refuse(f"this range has more than {MOST_POINTS} values; must be a larger step")
        count = math.floor((last - first) / step + 1e-9) + 1
        return tuple(min(first + i * step, last) for i in range(count))


@dataclass(frozen=True)
class Numbers(Annotation):
    """A list, perhaps empty, of numbers in the range of ``each``; the check returns a tuple of floats."""

    each: Quantity

    def words(self) -> str:
        return f"a list, each {self.each.words()}"

    def check(self, value: Any) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)):
            raise self.refusal()
        return Series(self.each).check(value) if value else ()


@dataclass(frozen=True)
class TableList(Annotation):
    """A list of tables, each of the kind that its key ``by`` names; the check returns a tuple of sections."""

    by: str
    sections: Callable[[], dict[str, Any]]
    header: str

    def words(self) -> str:
        return f"a list of tables ({self.header})"

    def check(self, value: Any) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)):
            raise self.refusal()
        return collected(value, self._entry)

    def _entry(self, entry: Any) -> Any:
        sections = self.sections()
        if not isinstance(entry, dict):
            raise one_fault((), f"must be a table ({self.header})", entry)
        choice = Choice(tuple(sections))
        if self.by not in entry:
            raise one_fault((self.by,), f"must be {choice.words()}", entry, kind="missing")
        try:
            name = choice.check(entry[self.by])
        except PydanticCustomError as error:
            raise one_fault((self.by,), error.message(), entry[self.by]) from None
        return sections[name].model_validate(entry)


def faults_at(place: tuple[str | int, ...], error: ValidationError) -> list[InitErrorDetails]:
    """Return the faults of a table that stands at ``place`` of a larger one."""
    return [
        InitErrorDetails(
            type=PydanticCustomError(e["type"], e["msg"]),  # type: ignore[arg-type]
            loc=(*place, *e["loc"]),
            input=e["input"],
        )
        for e in error.errors(include_url=False)
    ]


@dataclass(frozen=True)
class OrTable(Annotation):
    """A plain number, or a table that says more; the check returns a float or the section."""

    number: Quantity
    section: Callable[[], Any]
    header: str

    def words(self) -> str:
        return f"{self.number.words()} or a table ({self.header})"

    def check(self, value: Any) -> Any:
        if isinstance(value, dict):
            return self.section().model_validate(value)
        number = as_float(value)
        if number is None or not self.number.holds(number):
            raise self.refusal() if isinstance(value, str | list | bool) else self.number.refusal()
        return number


@dataclass(frozen=True)
class Tables(Annotation):
    """A list of tables of one kind; the check returns a tuple of sections."""

    section: Any
    header: str

    def words(self) -> str:
        return f"a list of tables ({self.header})"

    def check(self, value: Any) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)):
            raise self.refusal()
        return collected(value, self._entry)

    def _entry(self, entry: Any) -> Any:
        if not isinstance(entry, dict):
            raise one_fault((), f"must be a table ({self.header})", entry)
        return self.section.model_validate(entry)


def collected(values: Any, check: Callable[[Any], Any]) -> tuple[Any, ...]:
    """Every entry of a list checked; one validation error with the faults of all, each with its place."""
    kept: list[Any] = []
    faults: list[InitErrorDetails] = []
    for position, entry in enumerate(values):
        try:
            kept.append(check(entry))
        except ValidationError as error:
            faults += [
                InitErrorDetails(
                    type=PydanticCustomError(e["type"], e["msg"]),  # type: ignore[arg-type]
                    loc=(position, *e["loc"]),
                    input=e["input"],
                )
                for e in error.errors(include_url=False)
            ]
    if faults:
        raise ValidationError.from_exception_data("tables", faults)
    return tuple(kept)


def one_fault(loc: tuple[str | int, ...], message: str, value: Any, kind: str = "value") -> ValidationError:
    """Return a validation error with a single fault at ``loc``."""
    fault = PydanticCustomError(kind, message)  # type: ignore[arg-type]
    return ValidationError.from_exception_data("fault", [InitErrorDetails(type=fault, loc=loc, input=value)])


def plain(number: float) -> str:
    """Write a number without an exponent where that is shorter to read."""
    return str(int(number)) if number == int(number) and abs(number) < 1e7 else f"{number:g}"


def as_float(value: Any) -> float | None:
    """Return a finite float for an integer or float, None for anything else (switches, text, nan, inf)."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def nearest(word: str, allowed: tuple[str, ...] | list[str]) -> str | None:
    """Return the allowed word most like ``word``, regardless of capitals, or None."""
    from difflib import get_close_matches

    small = {a.lower(): a for a in allowed}
    near = get_close_matches(word.lower(), list(small), n=1, cutoff=0.6)
    return small[near[0]] if near else None
