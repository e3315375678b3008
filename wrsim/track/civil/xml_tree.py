"""XML as a tree of elements with their lines. A document type, and with it every entity, is refused."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar
from xml.parsers import expat

from wrsim.errors import InputError, suggest
from wrsim.inputs.toml_files import read_bytes, shortened
from wrsim.track.alignment import JOINT

T = TypeVar("T")
MOST_ELEMENTS, DEEPEST = 2_000_000, 100


@dataclass
class Element:
    """An element without its namespace."""

    path: Path
    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, *tags: str) -> list[Element]:
        """The children of these names."""
        return [child for child in self.children if child.tag in tags]

    def first(self, tag: str) -> Element | None:
        return next(iter(self.all(tag)), None)

    def below(self, tag: str) -> Iterator[Element]:
        """Every element of that name below, in order."""
        waiting = self.children[::-1]
        while waiting:
            element = waiting.pop()
            if element.tag == tag:
                yield element
            waiting += element.children[::-1]

    def fault(self, message: str) -> InputError:
        return InputError(f"{self.path}:{self.line}: {self.tag}: {message}")

    def choice(self, key: str, allowed: Mapping[str, T], default: str | None = None) -> T:
        """What an attribute of few values means. Raises InputError."""
        value = self.attributes.get(key, default)
        if value is None or value not in allowed:
            raise self.fault(f"{key} = {value!r}; allowed: {', '.join(allowed)}{suggest(str(value), [*allowed])}")
        return allowed[value]

    def number(self, key: str, default: float | None = None) -> float:
        """A finite attribute. Raises InputError, also where it is missing without a default."""
        if key not in self.attributes and default is not None:
            return default
        return self.numbers(self.attributes.get(key, ""), 1, f"{key} = {self.attributes.get(key)!r}")[0]

    def check_arc(self, length: float, arc: float) -> None:
        """Refuse a vertical curve whose length in the file is not that of its arc [m], along it or in plan: up to 1 per
        cent of slope^2/2 apart. Raises InputError."""
        if abs(length - arc) > JOINT + 1e-3 * length:
            raise self.fault(f"length {length:g} m, but radius and slopes make {arc:g} m; allowed: as these do")

    def numbers(self, text: str, least: int, name: str) -> list[float]:
        """Finite numbers in a text. Raises InputError where they are fewer, or more than three."""
        try:
            values = [float(part) for part in text.split()[:4]]
        except ValueError:
            values = []
        if not least <= len(values) <= 3 or not all(map(math.isfinite, values)):
            raise self.fault(
                f"{shortened(name)}; allowed: {'a finite number' if least == 1 else f'{least} finite numbers'}"
            )
        return values


def read_xml(path: Path, label: str) -> Element:
    """The root of an XML file. Raises InputError with file and line."""
    content = read_bytes(path, label)
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    row, count = [Element(path, "", {}, 0)], 0

    def fault(message: str) -> InputError:
        return InputError(f"{path}:{parser.CurrentLineNumber}: {message}")

    def refuse(*_: object) -> None:
        raise fault("has a document type (DOCTYPE); a civil file has none, and its entities are not read")

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > MOST_ELEMENTS or len(row) > DEEPEST:
            raise fault(f"more than {MOST_ELEMENTS} elements, or {DEEPEST} in each other; allowed: fewer")
        element = Element(path, name.rpartition(" ")[2], attributes, parser.CurrentLineNumber)
        row[-1].children.append(element)
        row.append(element)

    def text(part: str) -> None:
        row[-1].text += part

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: row.pop()
    parser.CharacterDataHandler = text
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise fault(f"is no whole XML: {expat.ErrorString(error.code)}") from None
    except (ValueError, LookupError) as error:  # an encoding that there is not
        raise fault(f"is no XML that can be read: {error}") from None
    return row[0].children[0]
