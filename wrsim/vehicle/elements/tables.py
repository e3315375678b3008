"""What the elements of a vehicle share in the kernel: one table of numbers, and the count of their unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field

Table = tuple[tuple[float, float], ...]


@dataclass
class Tables:
    """The tables of all elements in one, as the kernel takes them, and the number of unknowns that elements bring."""

    rows: list[tuple[float, float]] = field(default_factory=list)
    unknowns: int = 0
    slips: list[int] = field(default_factory=list)
    """Numbers of the unknowns that belong to sliders."""

    def store(self, table: Table) -> tuple[int, int]:
        """Add a table; returns its first row and the number of rows."""
        start = len(self.rows)
        self.rows.extend(table)
        return start, len(table)

    def unknown(self) -> int:
        """Number of one more unknown."""
        self.unknowns += 1
        return self.unknowns - 1

    def slip(self, count: int) -> int:
        """Number of the first of so many unknowns of a slider."""
        numbers = [self.unknown() for _ in range(count)]
        self.slips += numbers
        return numbers[0]
