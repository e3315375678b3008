"""What a function of the API returns, and how what it is given is read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from wrsim.api.options import ResultLike
from wrsim.errors import INTERRUPTED, STOPPED, InputError
from wrsim.results.table import Table, as_html, as_text
from wrsim.results.units import in_text, shown_in

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of a function of the API."""

    tables: Sequence[Table]
    """For people: printed, and shown in notebooks."""
    numbers: dict[str, Any]
    """The same as plain records, as of ``--json``."""
    files: Sequence[Path] = ()
    """Files that were written."""
    value: Any = None
    """The object behind the tables."""
    code: int = 0
    """Exit code of the command, 0 where all went well."""
    folder: Path | None = None
    """Folder of the files, where they share one."""
    lines: Sequence[str] = ()
    """Lines that follow the tables."""

    @property
    def shown_lines(self) -> tuple[str, ...]:
        """The lines in the units in use."""
        return tuple(map(in_text, self.lines))

    def __repr__(self) -> str:
        return "\n".join(filter(None, (as_text(self.tables), *self.shown_lines, *map(str, self.files))))

    def _repr_html_(self) -> str:
        text = "\n".join((*self.shown_lines, *map(str, self.files)))
        block = Markup("<pre>{}</pre>").format(text) if text else ""
        return Markup("<div>{}{}</div>").format(Markup("").join(map(as_html, self.tables)), block)

    def __getitem__(self, key: str) -> Any:
        return self.numbers[key]


in_units = shown_in
"""A block whose tables, pictures and pages have units."""


def as_result(result: ResultLike) -> Result:
    from wrsim.inputs.lookup import as_path
    from wrsim.report.output_folder import read
    from wrsim.results import Result

    return result if isinstance(result, Result) else read(as_path(result, "a result"))


def as_list(results: ResultLike | Sequence[ResultLike]) -> list[ResultLike]:
    from wrsim.results import Result

    return [results] if isinstance(results, Result | str | Path) else list(results)


def paths_in(*results: ResultLike) -> list[Path]:
    return [Path(each) for each in results if isinstance(each, str | Path)]


def name_of(result: ResultLike) -> str:
    """The file of a result, or the title of one in memory."""
    return str(result) if isinstance(result, str | Path) else result.title


def as_scenario(scenario: Scenario | str | Path, models: Sequence[str | Path] | None) -> Scenario:
    from wrsim.scenario.loading import loaded

    return loaded(scenario, models or ())


def folder_or_none(output: str | Path | None) -> Path | None:
    return None if output is None else Path(output)


@contextmanager
def no_bar() -> Iterator[Callable[[float, float], None]]:
    yield lambda fraction, seconds_left: None


def exit_code(result: Result) -> int:
    """Exit code of a command: 0 for a run that came to its end, else 3, and 130 where Ctrl-C stopped it."""
    if result.status == "completed":
        return 0
    interrupted = result.dataset.attrs.get("stop_cause") == "interrupt"
    return INTERRUPTED if interrupted or result.stop_reason.startswith("interrupted") else STOPPED


def folder_beside(result: ResultLike, output: str | Path | None = None) -> Path:
    """Folder of files about a result: ``output``, else beside it. Raises InputError."""
    from wrsim.results.files import folder_of_result

    if output is not None:
        return Path(output)
    if not isinstance(result, str | Path):
        raise InputError("output is missing: the result is in no folder")
    return folder_of_result(Path(result))


def results_folder(file: str | Path, output: str | Path | None) -> Path:
    """Folder of what a file describes: ``output``, else results/<name of the file>."""
    from wrsim.inputs.lookup import as_path

    return Path(output) if output else Path("results") / as_path(file, "a file").stem
