"""The cases of a study: their names, their folders, and what a worker needs to know of them.

A case is named by a digest of its merged scenario, but for the title, and of the bytes of every file that it reads. So
a case keeps its name, and its result, when other values are added to the study, and gets another one when a profile
is edited.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from wrsim.errors import InputError, suggest
from wrsim.inputs.checking import check_section, fault_line, opened
from wrsim.inputs.lookup import Finder
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import noting_reads, shown_value, texts_in
from wrsim.results.files import digest_of
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load, load_text
from wrsim.scenario.vehicle_build import vehicle_of
from wrsim.study.axes import AxisPoints, axis_points
from wrsim.study.outputs import check_hook, known_names, outputs_digest
from wrsim.study.sensitivity import axis_of
from wrsim.study.spec import MOST_CASES, CasesSection, OutputsSection, SensitivitySection, StudyFile, short_name

CASES, PLAN = "cases", "plan.json"
MOST_FAULTS = 20
"""Faults of cases that are listed."""
Refused = tuple[tuple[int, ...], str]
"""A case that cannot be: its place along every axis, and why."""


@dataclass(frozen=True)
class Case:
    """name: see the module; values: by key; place: along every axis; label: values in words; files: its set."""

    name: str
    values: dict[str, Any]
    place: tuple[int, ...]
    label: str
    files: int


@dataclass(frozen=True)
class Plan:
    """A study in full, as in ``plan.json``.

    folder: of the study; source: the study file; text, folders: the base scenario and where its models are looked up;
    files: sets of files, by path with digest, that cases read; axes: name, columns and values of each; outputs, hook:
    what is stored; digest: of the outputs; sensitivity: whose design the cases are; vehicle: name of that
    of the first case.
    """

    folder: str
    title: str
    analysis: str
    source: str
    text: str
    folders: tuple[str, ...]
    axes: tuple[AxisPoints, ...]
    cases: tuple[Case, ...]
    files: tuple[dict[str, str], ...]
    outputs: OutputsSection
    hook: str
    outputs_digest: str
    time_limit: float
    keep: str
    sensitivity: SensitivitySection | None = None
    vehicle: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along every axis."""
        return tuple(len(axis.values) for axis in self.axes)

    def folder_of(self, case: Case) -> Path:
        """Where a case is stored."""
        return Path(self.folder) / CASES / case.name[:2] / case.name

    @cached_property
    def base(self) -> Scenario:
        """The scenario that all cases start from."""
        return load_text(self.text, self.folders[0], self.folders[1:])

    def scenario(self, case: Case) -> Scenario:
        """The merged scenario of a case."""
        return self.base.with_values(case.values | {"title": f"{self.title}: {case.label}"})

    def dumped(self) -> bytes:
        """Content of ``plan.json``."""
        return _PLAN.dump_json(self, exclude_none=True) + b"\n"


_PLAN = TypeAdapter(Plan)


@lru_cache(maxsize=4)
def plan_in(folder: str, digest: str) -> Plan:
    """The plan in the folder of a study. Raises InputError when it is another one by now."""
    content = (Path(folder) / PLAN).read_bytes()
    if digest_of(content) != digest:
        raise InputError(f"{folder}: the plan of the study has changed while it was running")
    return replace(_PLAN.validate_json(content), folder=folder)


class FileInput:
    """A file about many runs: its sections, and where the files are looked up that it names."""

    def __init__(self, file: Path, label: str, kind: type[Section], models: Sequence[str | Path]) -> None:
        """Raises InputError with file, key and what is allowed."""
        data, self.locate = opened(file, label)
        self.file, self.text, self.models = file, file.read_text(encoding="utf-8"), tuple(models)
        self.spec: Any
        self.spec = check_section(kind, data, self.locate)
        self.finder = Finder.of((file.parent,), models)

    def file_of(self, *key: str | int, name: str) -> Path:
        """The file that a key names."""
        with self.naming(*key, value=name):
            return self.finder.find(name)

    @contextmanager
    def naming(self, *key: str | int, value: Any = None) -> Iterator[None]:
        """Give faults the place of a key."""
        try:
            yield
        except InputError as error:
            raise InputError(fault_line(key, str(error), self.locate, value)) from None

    def hook_file(self, hook: str | None, *key: str | int) -> str:
        """The file of a hook, checked; empty without one."""
        if hook is None:
            return ""
        name, _, function = hook.rpartition(":")
        with self.naming(*key, value=hook):
            file = self.finder.find(name).resolve()
            check_hook(file, function)
        return str(file)

    def plan_of(
        self, base: Scenario, title: str, folder: Path, axes: tuple[AxisPoints, ...], outputs: OutputsSection,
        cases: CasesSection, hook: str = "",
    ) -> Plan:  # fmt: skip
        """The plan of all cases of a scenario on these axes, none of which is made yet."""
        return Plan(
            folder=str(folder.resolve()),
            title=title,
            analysis=base.analysis,
            source=self.text,
            text=base.text,
            folders=tuple(str(p.resolve()) for p in dict.fromkeys((*base.finder.folders, *self.finder.folders))),
            axes=axes,
            cases=(),
            files=(),
            outputs=outputs,
            hook=hook,
            outputs_digest=outputs_digest(outputs, Path(hook) if hook else None),
            time_limit=cases.time_limit_s,
            keep=cases.keep,
        )


class StudyInput(FileInput):
    """A file of a study or a profile evolution, with its cases' scenario."""

    def __init__(self, file: Path, label: str, kind: type[Section], models: Sequence[str | Path]) -> None:
        """Raises InputError with file, key and what is allowed."""
        super().__init__(file, label, kind, models)
        self.base = load(self.file_of("base", name=self.spec.base), models)
        self.title: str = self.spec.title or self.base.title


def planned(file: Path, folder: Path, models: Sequence[str | Path] = ()) -> tuple[Plan, tuple[Path, ...]]:
    """The plan of a study file, every case checked, and all files that were read.

    Raises InputError with all faults, one line each.
    """
    with noting_reads() as seen:
        study = StudyInput(file, "study file", StudyFile, models)
        spec: StudyFile = study.spec
        axes = tuple(axis_points(axis, study.finder, study.locate(("vary", i))) for i, axis in enumerate(spec.vary))
        if spec.sensitivity is not None:
            with study.naming("sensitivity"):
                axes = (axis_of(spec.sensitivity, study.locate(("sensitivity",))),)
        owners: dict[str, str] = {}
        for axis, key in ((each, key) for each in axes for group in each.keys for key in group):
            if key in owners:
                raise InputError(f"{axis.places[0]}: {key}: is varied by axis '{owners[key]}' already")
            owners[key] = axis.name
        count = prod(len(axis.values) for axis in axes)
        if count > MOST_CASES:
            with study.naming("vary"):
                raise InputError(f"describes {count} cases; must be at most {MOST_CASES}")
        hook = study.hook_file(spec.outputs.hook, "outputs", "hook")
        names = known_names(spec.outputs, study.base.analysis)
        for name in spec.sensitivity.outputs if spec.sensitivity is not None and names else ():
            if name not in names:
                with study.naming("sensitivity", "outputs", value=name):
                    raise InputError(f"is no output{suggest(name, names)}; there are {', '.join(names)}")
        plan = study.plan_of(study.base, study.title, folder, axes, spec.outputs, spec.cases, hook)
        plan = replace(plan, sensitivity=spec.sensitivity)
    plan, models_read = with_cases(plan, study.base)
    return plan, tuple(dict.fromkeys((*seen, *models_read)))


def with_cases(plan: Plan, base: Scenario, refused: list[Refused] | None = None) -> tuple[Plan, list[Path]]:
    """The plan with its cases, all checked, models once for every set of names, and files read.

    Cases that cannot be raise InputError, or are left out and listed in ``refused``."""
    cases: list[Case] = []
    files: list[dict[str, str]] = []
    read: list[Path] = []
    groups: dict[tuple[str, ...], int] = {}
    changed, vehicle = {"{}"}, ""
    faults: list[str] = []
    known = set[str | tuple[str, ...]]()
    for place in product(*(range(n) for n in plan.shape)):
        values: dict[str, Any] = {}
        for axis, i in zip(plan.axes, place, strict=True):
            for keys, value in zip(axis.keys, axis.values[i], strict=True):
                values |= dict.fromkeys(keys, value)
        owner = " and ".join(dict.fromkeys(axis.places[i] for axis, i in zip(plan.axes, place, strict=True)))
        label = _label(plan.axes, place)
        try:
            scenario = base.with_values(values, owner)
            group = tuple(texts_in(scenario.merged.data, "title"))  # cases that share them read the same files
            if (changes := str(scenario.spec.vehicle.changes)) not in changed:
                changed.add(changes)
                vehicle_of(scenario)
            if group not in groups:
                with noting_reads() as seen:
                    setup = build(scenario)
                vehicle, named = vehicle or setup.vehicle.name, setup.files
                groups[group] = len(files)
                contents = {path: seen[path] for path in named}
                digests = {path: hashlib.sha256(content).hexdigest() for path, content in sorted(contents.items())}
                files.append({str(path.resolve()): digest for path, digest in digests.items()})
                read += contents
        except InputError as error:
            if refused is not None:
                refused.append((place, str(error)))
                continue
            told = error.unknown or str(error)  # an unknown key once, whatever its values
            if told not in known:
                known.add(told)
                faults.append(str(error) if owner in str(error) else f"{owner}: case {label}: {error}")
            if len(faults) > MOST_FAULTS:
                break
            continue
        cases.append(Case(_name(scenario.merged.data, files[groups[group]]), values, place, label, groups[group]))
    if faults:
        more = ["... and more faults"] if len(faults) > MOST_FAULTS else []
        raise InputError("\n".join(faults[:MOST_FAULTS] + more))
    return replace(plan, cases=tuple(cases), files=tuple(files), vehicle=vehicle), read


def _label(axes: Sequence[AxisPoints], place: tuple[int, ...]) -> str:
    """The values of a case in words."""
    parts = []
    for axis, i in zip(axes, place, strict=True):
        if axis.labels:
            parts.append(f"{axis.name} {axis.labels[i]}")
        elif axis.listed and len(axis.columns) > 3:
            parts.append(f"{axis.name} {i}")
        else:
            pairs = zip(axis.columns, axis.values[i], strict=True)
            parts += [f"{short_name(column)} {value_text(value)}" for column, value in pairs]
    return ", ".join(parts)


def value_text(value: Any) -> str:
    """A varied value for labels: six digits, texts without quotes."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return value if isinstance(value, str) else shown_value(value, 40)


def _name(tables: dict[str, Any], files: dict[str, str]) -> str:
    """The name of a case: twenty hexadecimal digits."""
    untitled = {key: value for key, value in tables.items() if key != "title"}
    text = json.dumps(untitled, sort_keys=True, default=str, ensure_ascii=False)
    digest = hashlib.sha256(text.encode())
    for content in sorted(files.values()):
        digest.update(content.encode())
    return digest.hexdigest()[:20]


@lru_cache(maxsize=4096)
def _content(path: str, modified: int, size: int) -> str:
    """Digest of a file of this age and size."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def changed_file(files: dict[str, str]) -> str:
    """The first of these files that is not as it was when the study was planned; empty if all are."""
    for path, digest in files.items():
        try:
            now = os.stat(path)
        except OSError:
            return path
        if _content(path, now.st_mtime_ns, now.st_size) != digest:
            return path
    return ""
