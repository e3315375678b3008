"""A comparison as data: a file of cases with the figures of others, and how far a code may be off."""

import csv
import random
import re
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from campaigns.benchmark.adapter import Answer, Code
from wrsim.errors import InputError, SimulationError
from wrsim.inputs.checking import check_section, opened
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, choice, number, positive, text

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FUNCTIONS = tuple(name for name in vars(Code) if not name.startswith("_") and name not in ("name", "points"))
Word = Annotated[str, text("a word")]
Tolerance = Annotated[float, positive()]
Row = dict[str, Any]
FEW = 20  # cases that 95 % of means something


class CasesSection(Section, header="[cases]"):
    """Where the cases come from: a table of the reference folder or of the repository, or rows in place."""

    one_of = ("file rows",)
    together = ("head rows",)

    file: Annotated[str, text("a CSV file of the reference folder, or of the repository under tests/")] | None = None
    """Table of cases, a line each; lines that begin with # are not read."""
    where: dict[str, List[Word]] = {}
    """Columns and the values that count."""
    below: dict[str, float] = {}
    """Columns and the values up to which a line counts."""
    head: List[Word] = ()
    """Names of the columns of rows."""
    rows: List[List[Any]] = ()
    """Cases in place."""
    draw: Annotated[int, number(1)] | None = None
    """Number of cases that are drawn at random, always the same ones; all of them unless given."""
    short: Annotated[int, number(1)] | None = None
    """The same for a short run."""

    def read(self, reference: Path, name: str, short: bool) -> list[Row]:
        """The cases that count; numbers are numbers."""
        rows = [dict(zip(self.head, row, strict=True)) for row in self.rows]
        if self.file is not None:
            inside = self.file.startswith("tests/")
            rows = [dict(row) for row in _table((ROOT if inside else reference) / self.file)]
        rows = [r for r in rows if all(r.get(key) in values for key, values in self.where.items())]
        rows = [r for r in rows if all(float(r[key]) <= most for key, most in self.below.items())]
        count = (self.short if short else None) or self.draw or len(rows)
        kept = sorted(random.Random(name).sample(range(len(rows)), min(count, len(rows))))
        return [{key: _number(value) for key, value in rows[i].items()} for i in kept]


class QuantitySection(Section, header="[[quantities]]"):
    """A quantity of the answer beside a column of the table, and how far it may be off."""

    name: Word
    """Its name in the answer, with its unit."""
    column: Word | None = None
    """Column of the table with the figure of the source; the name unless given. Empty cells do not count."""
    error: Literal["relative", "absolute"] = "relative"
    """Of the figure, or a difference in its unit."""
    over: Word | None = None
    """Column that differences are divided by."""
    median: Tolerance | None = None
    """Largest median of the errors."""
    most: Tolerance | None = None
    """Largest error of 95 % of the cases, where there are 20 or more."""
    worst: Tolerance | None = None
    """Largest error of all cases."""
    why: Annotated[str, text("where the tolerances come from")]
    """Where the tolerances come from."""

    def consistency(self) -> Iterator[Fault]:
        if self.limits.count(None) == 3:
            yield Fault("median", "must be a number above 0 (or give most or worst)", missing=True)
        if self.over is not None and self.error == "relative":
            yield Fault("over", 'goes with error = "absolute"')

    @property
    def limits(self) -> tuple[float | None, float | None, float | None]:
        """Of median, 95 % and largest error."""
        return self.median, self.most, self.worst


class ComparisonFile(Section, header="a comparison"):
    """A comparison with figures of others."""

    title: Annotated[str, text("a title")]
    """What is compared."""
    beside: Word
    """The source: its name in [references] of docs/data/validation.toml, which has its licence."""
    function: Annotated[Literal[FUNCTIONS], choice(FUNCTIONS)]  # type: ignore[valid-type]
    """Function of the adapter."""
    cost: Annotated[float, positive()]
    """About how long it takes [s]: cheap ones run first."""
    whole: bool = False
    """Whether the function takes columns as lists, and not a case at a time."""
    short: bool = True
    """Whether it is part of a short run."""
    inputs: dict[str, Word] = {}
    """Arguments of the function and the columns that they come from."""
    given: dict[str, Any] = {}
    """Arguments that are the same in all cases."""
    cases: CasesSection
    quantities: List[QuantitySection]


@dataclass(frozen=True)
class Outcome:
    """Errors of one quantity of a comparison: median, 95 %, largest, and the case of that."""

    comparison: str
    quantity: str
    cases: int
    errors: tuple[float, float, float]
    limits: tuple[float | None, float | None, float | None]
    case: str

    @property
    def word(self) -> str:
        """Green where all errors are within their limits, else red; no figure at all is red."""
        return "green" if self.cases > 0 and not self.beyond else "red"

    @property
    def beyond(self) -> list[str]:
        """What is beyond its limit, in words."""
        names = ("median", "95 %" if self.cases >= FEW else "", "worst")
        told = zip(names, self.errors, self.limits, strict=True)
        return [f"{name} {e:.3g} > {most:g}" for name, e, most in told if name and most is not None and not e <= most]


@dataclass(frozen=True)
class Verdict:
    """What came of a comparison; no outcomes where a code does not offer it; problem: the first one that stopped it."""

    comparison: str
    outcomes: tuple[Outcome, ...]
    seconds: float
    problem: str = ""

    @property
    def word(self) -> str:
        """Green, red or not offered."""
        return (
            "not offered" if not self.outcomes else "green" if all(o.word == "green" for o in self.outcomes) else "red"
        )


def read_comparison(path: Path) -> ComparisonFile:
    """A comparison by its file. Raises InputError that names file, line and key."""
    data, locate = opened(path, "comparison")
    comparison = check_section(ComparisonFile, data, locate)
    known = references()
    if comparison.beside not in known:
        raise InputError(f"{locate(('beside',))}: beside = {comparison.beside!r}: must be one of {', '.join(known)}")
    return comparison


@cache
def references() -> dict[str, dict[str, str]]:
    """Sources and licences by their names."""
    return tomllib.loads((ROOT / "docs/data/validation.toml").read_text(encoding="utf-8"))["references"]


def run_comparison(name: str, comparison: ComparisonFile, code: Code, short: bool = False) -> Verdict:
    """Ask a code for all cases of a comparison."""
    began = time.perf_counter()
    rows = comparison.cases.read(code.reference, name, short)
    ask = getattr(code, comparison.function)
    constants, problems = comparison.given, list[str]()

    def answer(**arguments: Any) -> Answer:
        try:
            return ask(**arguments | constants)
        except (InputError, SimulationError, ArithmeticError, ValueError, IndexError) as problem:
            problems.append(str(problem).splitlines()[0])
            return None

    try:
        if comparison.whole:
            columns = {key: [row[column] for row in rows] for key, column in comparison.inputs.items()}
            answers = _split(answer(**columns), len(rows))
        else:
            answers = [answer(**{key: row[column] for key, column in comparison.inputs.items()}) for row in rows]
    except NotImplementedError:
        return Verdict(name, (), time.perf_counter() - began)
    outcomes = tuple(_outcome(name, quantity, rows, answers) for quantity in comparison.quantities)
    return Verdict(name, outcomes, time.perf_counter() - began, next(iter(problems), ""))


def _outcome(name: str, quantity: QuantitySection, rows: Sequence[Row], answers: Sequence[Answer]) -> Outcome:
    """Errors of a quantity."""
    errors, cases = [], []
    for i, (row, answer) in enumerate(zip(rows, answers, strict=True)):
        truth = row[quantity.column or quantity.name]
        if truth == "":
            continue
        error = np.inf if answer is None else abs(float(answer[quantity.name]) - truth)  # type: ignore[arg-type]
        scale = abs(truth) if quantity.error == "relative" else row[quantity.over] if quantity.over else 1.0
        errors.append(error / scale if np.isfinite(error) else np.inf)
        cases.append(str(row.get("case_id", row.get("case", i + 1))))
    if not errors:
        return Outcome(name, quantity.name, 0, (np.inf,) * 3, quantity.limits, "")
    ordered = np.sort(errors)
    two = (float(np.percentile(ordered, p, method="higher")) for p in (50.0, 95.0))
    worst = int(np.argmax(errors))
    return Outcome(name, quantity.name, len(errors), (*two, errors[worst]), quantity.limits, cases[worst])


def _split(answer: Answer, count: int) -> list[Answer]:
    """An answer of lists as one for every case."""
    if answer is None:
        return [None] * count
    return [{key: np.asarray(values)[i] for key, values in answer.items()} for i in range(count)]


@cache
def _table(path: Path) -> tuple[Row, ...]:
    if not path.is_file():
        raise InputError(f"{path}: no such table; REFERENCE must be the folder of reference tables")
    with path.open(encoding="utf-8", newline="") as file:
        return tuple(csv.DictReader(line for line in file if not line.startswith("#")))


NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]\d+)?")
"""A number in a table; 60E1 is none."""


def _number(value: Any) -> Any:
    return float(value) if isinstance(value, int) or NUMBER.fullmatch(str(value)) else value
