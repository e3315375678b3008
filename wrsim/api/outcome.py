"""What a function of the API returns, and how what it is given is read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from markupsafe import Markup

from wrsim.errors import INTERRUPTED, STOPPED, InputError
from wrsim.results.table import Table, as_html, as_text
from wrsim.results.units import in_text, shown_in

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario

Given: TypeAlias = "Result | str | Path"
Values: TypeAlias = Sequence[str] | Mapping[str, Any]
Bar: TypeAlias = Callable[[], AbstractContextManager[Any]]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a function found.

    tables: for people, printed and shown in notebooks; numbers: the same as plain records, as of ``--json``; files:
    that were written; found: the object behind; code: exit code of the command, 0 where all went well; folder: of the
    files, where they share one; lines: that follow the tables.
    """

    tables: Sequence[Table]
    numbers: dict[str, Any]
    files: Sequence[Path] = ()
    found: Any = None
    code: int = 0
    folder: Path | None = None
    lines: Sequence[str] = ()

    @property
    def shown_lines(self) -> tuple[str, ...]:
        """The lines in the units in use."""
        return tuple(map(in_text, self.lines))

    def __repr__(self) -> str:
        return "\n".join(filter(None, (as_text(self.tables), *self.shown_lines, *map(str, self.files))))

    def _repr_html_(self) -> str:
        words = "\n".join((*self.shown_lines, *map(str, self.files)))
        listed = Markup("<pre>{}</pre>").format(words) if words else ""
        return Markup("<div>{}{}</div>").format(Markup("").join(map(as_html, self.tables)), listed)

    def __getitem__(self, key: str) -> Any:
        return self.numbers[key]


def in_units(system: str | None) -> AbstractContextManager[None]:
    """A block whose tables, pictures and pages have units; see `wrsim.results.units.shown_in`."""
    return shown_in(system)


def as_result(given: Given) -> Result:
    from wrsim.inputs.lookup import as_path
    from wrsim.report.output_folder import read
    from wrsim.results import Result

    return given if isinstance(given, Result) else read(as_path(given, "a result"))


def as_list(given: Given | Sequence[Given]) -> list[Given]:
    from wrsim.results import Result

    return [given] if isinstance(given, Result | str | Path) else list(given)


def paths_among(*given: Given) -> list[Path]:
    return [Path(each) for each in given if isinstance(each, str | Path)]


def as_scenario(given: Scenario | str | Path, models: Sequence[str | Path]) -> Scenario:
    from wrsim.scenario.loading import loaded

    return loaded(given, models)


@contextmanager
def no_bar() -> Iterator[Callable[[float, float], None]]:
    yield lambda fraction, seconds_left: None


def exit_code(result: Result) -> int:
    """Of a command: 0 for a run that came to its end, else 3, and 130 where Ctrl-C stopped it."""
    if result.status == "completed":
        return 0
    interrupted = result.dataset.attrs.get("stop_cause") == "interrupt"
    return INTERRUPTED if interrupted or result.stop_reason.startswith("interrupted") else STOPPED


def folder_beside(given: Given, output: str | Path | None) -> Path:
    """Where files about a result go: ``output``, else beside it. Raises InputError."""
    from wrsim.results.files import folder_of_result

    if output is not None:
        return Path(output)
    if not isinstance(given, str | Path):
        raise InputError("output is missing: the result is in no folder")
    return folder_of_result(Path(given))


def results_folder(file: str | Path, output: str | Path | None) -> Path:
    """Where what a file asks for is written: ``output``, else results/<name of the file>."""
    from wrsim.inputs.lookup import as_path

    return Path(output) if output else Path("results") / as_path(file, "a file").stem
