"""The numbers that a study keeps of one result."""

import hashlib
import importlib.util
import symtable
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.assessment.limits import QUANTITIES
from wrsim.errors import InputError, suggest
from wrsim.inputs.toml_files import read_bytes
from wrsim.register import ANALYSES
from wrsim.results import CHANNELS, Result
from wrsim.results.filters import LEAST_SAMPLES, low_pass, on_raster, sampling_rate
from wrsim.results.summary import LATER
from wrsim.results.table import formatted
from wrsim.study.spec import REDUCTIONS, ChannelOutput, OutputsSection

USUAL = tuple(
    ChannelOutput(channel=channel, reduce=reduce)
    for channel, reduce in (
        ("Y", "peak"), ("Q", "min"), ("Q", "max"), ("Y_over_Q", "max"),
        ("T_gamma", "max"), ("p0", "max"), ("lateral_shift", "peak"), ("yaw", "peak"),
    )
)  # fmt: skip
"""Stored of runs and poses without an outputs section; of other analyses the plain numbers of their summary."""


@dataclass
class Outputs:
    """Numbers by name, their units for readers; outputs that no case can have and those that this one lacks, a sentence
    each."""

    numbers: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    absent: list[str] = field(default_factory=list)

    def add(self, name: str, value: Any, unit: str) -> None:
        """Note one number; None is not-a-number."""
        self.numbers[name] = float("nan") if value is None else float(value)
        self.units[name] = "" if unit == "1" else unit


def known_names(wanted: OutputsSection, analysis: str) -> tuple[str, ...]:
    """Names that outputs may have, before any case has run; empty where only the cases tell them."""
    kind, channels = ANALYSES[analysis], wanted.channels
    if wanted == OutputsSection() and (kind.moves or kind.compared):
        channels = USUAL
    elif wanted == OutputsSection() or wanted.hook is not None:
        return ()
    assessed = [name for key in wanted.assessment for name in (assessment_name(key), margin_name(key))]
    return (*(output.column for output in channels), *map(place_name, wanted.summary), *assessed)


def case_outputs(result: Result, wanted: OutputsSection, hook: Path | None) -> Outputs:
    """The outputs of one result. hook: the file of the hook, if there is one."""
    outputs = Outputs()
    channels = wanted.channels
    if wanted == OutputsSection():
        analysis = ANALYSES[result.analysis]
        if analysis.moves or analysis.compared:
            channels = tuple(output for output in USUAL if output.channel in result.dataset)
        else:
            for name, value in result.summary().items():
                if isinstance(value, int | float) and not isinstance(value, bool):
                    outputs.add(name, value, _unit_in(name))
    for output in channels:
        _add_channel(outputs, result, output)
    if wanted.summary:
        summary = result.summary()
        for place in wanted.summary:
            _add_place(outputs, summary, place)
    if wanted.assessment:
        _add_assessment(outputs, result, wanted.assessment)
    if wanted.hook is not None and hook is not None:
        _add_hook(outputs, result, hook, wanted.hook.rpartition(":")[2])
    return outputs


def chosen_channel(dataset: xr.Dataset, output: ChannelOutput) -> xr.DataArray:
    """A channel of a result, of the labels that are chosen. Raises InputError where the result has none of them."""
    if output.channel not in dataset:
        present = [name for name in CHANNELS if name in dataset]
        raise InputError(f"this analysis has no such channel; it has {', '.join(present)}")
    data = dataset[output.channel]
    for dim, label in output.chosen().items():
        names = [str(name) for name in dataset[dim].values]
        if label not in names:
            raise InputError(f'{dim} = "{label}": there is {", ".join(names)}{suggest(label, names)}')
        data = data.sel({dim: label})
    return data


def _add_channel(outputs: Outputs, result: Result, output: ChannelOutput) -> None:
    channel = CHANNELS[output.channel]
    label = f'outputs.channels: channel = "{output.channel}"'
    outputs.add(output.column, None, channel.shown.symbol)
    try:
        data = chosen_channel(result.dataset, output)
    except InputError as error:
        outputs.faults.append(f"{label}: {error}")
        return
    windowed = output.from_m is not None or output.to_m is not None
    if (windowed or output.low_pass_Hz) and data.dims[0] != "time":
        outputs.faults.append(f"{label}: from_m, to_m and low_pass_Hz are for channels over time")
        return
    if output.low_pass_Hz is not None:
        try:
            data = on_raster(data.to_dataset())[output.channel]
            data = data.copy(data=low_pass(data.values, sampling_rate(data["time"].values), output.low_pass_Hz))
        except InputError as error:
            (outputs.faults if data.sizes["time"] >= LEAST_SAMPLES else outputs.absent).append(f"{label}: {error}")
            return
    if windowed:
        place = result.dataset["distance"].values[: data.sizes["time"]]
        low = -np.inf if output.from_m is None else output.from_m
        high = np.inf if output.to_m is None else output.to_m
        inside = np.flatnonzero((place >= low) & (place <= high))
        if not inside.size:
            window = ", ".join(f"{word}_m = {end:g}" for word, end in (("from", low), ("to", high)) if np.isfinite(end))
            ends = " to ".join(formatted(float(x), ".1f") for x in place[[0, -1]])
            outputs.absent.append(f"{label}, {window}: the case has no value there, it lasts from {ends} m")
            return
        data = data.isel(time=inside)
    value = reduced(np.atleast_1d(data.values.astype(float)), output.reduce, output.percentile)
    outputs.add(output.column, value * channel.shown.factor, channel.shown.symbol)


def reduced(values: NDArray[np.float64], how: str, percentile: float | None = None) -> float:
    """One number of samples (n, ...): along the first axis, then the worst of all others.

    The worst is the smallest for "min", of largest magnitude for "peak", else the largest; not-a-number without any.
    """
    columns = (column[np.isfinite(column)] for column in values.reshape(len(values), prod(values.shape[1:])).T)
    arguments = () if percentile is None else (percentile,)
    each = [float(REDUCTIONS[how](column, *arguments)) for column in columns if column.size]
    if not each:
        return float("nan")
    return min(each) if how == "min" else max(each, key=abs if how == "peak" else None)


def _add_place(outputs: Outputs, summary: Mapping[str, Any], place: str) -> None:
    """A number of the summary by its dotted place. Keys may hold dots themselves."""
    name = place_name(place)
    outputs.add(name, None, _unit_in(place))
    value, rest = _walk(summary, place)
    if fault := _place_fault(place, value, rest):
        outputs.faults.append(f"outputs.summary: {fault}")
    else:
        outputs.add(name, value, _unit_in(place))


def _place_fault(place: str, value: Any, rest: str) -> str:
    """What is wrong with a place of which a rest is left at a value; nothing where it is a number."""
    if rest:
        keys = list(value) if isinstance(value, dict) else []
        hint = f"there is {', '.join(map(str, keys))}{suggest(rest.split('.')[0], keys)}" if keys else "nothing below"
        return f'"{place}": "{rest}" is not in the summary; {hint}'
    if isinstance(value, dict | list | str):
        more = f"; below it: {', '.join(map(str, value))}" if isinstance(value, dict) else ""
        return f'"{place}" is no number{more}'
    return ""


def check_place(result: Result, place: str) -> None:
    """Refuse a place that the summary of a run cannot have, by its first steps: most tables are there, lists may be
    longer at the end. Raises InputError."""
    value, rest = _walk(result.summary(), place)
    later = isinstance(value, list) or rest.split(".")[0] in LATER
    if not later and (fault := _place_fault(place, value, rest)):
        raise InputError(fault)


def place_name(place: str) -> str:
    return "_".join("".join(c if c.isalnum() else "_" for c in part) for part in place.split("."))


def _walk(tree: Any, place: str) -> tuple[Any, str]:
    """Down a tree of tables and lists as far as the place leads: the value there, of a peak too; rest of the place."""
    while place:
        parts = place.split(".")
        if isinstance(tree, list) and parts[0].isdecimal() and int(parts[0]) < len(tree):
            tree, place = tree[int(parts[0])], ".".join(parts[1:])
            continue
        heads = [".".join(parts[:n]) for n in range(len(parts), 0, -1)]
        head = next((h for h in heads if isinstance(tree, dict) and h in tree), None)
        if head is None:
            break
        tree, place = tree[head], place[len(head) + 1 :]
    if not place and isinstance(tree, dict) and "value" in tree:
        return tree["value"], ""
    return tree, place


def _unit_in(name: str) -> str:
    """Unit at the end of a name, for axes."""
    units = {c.shown.suffix: c.shown.symbol for c in CHANNELS.values() if name.endswith(f"_{c.shown.suffix}")}
    return units[max(units, key=len)] if units else ""


def assessment_name(key: str) -> str:
    return "_".join(filter(None, ("assessment", key, QUANTITIES[key].shown.suffix)))


def margin_name(key: str) -> str:
    return f"assessment_{key}_margin"


def _add_assessment(outputs: Outputs, result: Result, wanted: tuple[str, ...]) -> None:
    """The worst value of every quantity over all sections, and the least margin to its limit where it has one."""
    from wrsim.assessment.assess import assess_runs

    columns = {key: assessment_name(key) for key in wanted}
    for key, column in columns.items():
        outputs.add(column, None, QUANTITIES[key].shown.symbol)
    try:
        assessment = assess_runs(result)
    except InputError as error:
        outputs.faults.append(f"outputs.assessment: {error}")
        return
    for key, column in columns.items():
        values = assessment.of(key)
        if assessment.rules.about(key) is None:
            known = ", ".join(clause.quantity for clause in assessment.rules.clauses)
            outputs.faults.append(f'outputs.assessment: "{key}": {assessment.rules.title} has {known}')
        if not values:
            continue  # the notes of the assessment have the reason: too short a track, no vehicle
        shown = QUANTITIES[key].shown
        worst = min if QUANTITIES[key].lowest else max
        outputs.add(column, worst(v.value for v in values) * shown.factor, shown.symbol)
        margins = [v.margin for v in values if v.margin is not None]
        if margins:
            outputs.add(margin_name(key), min(margins), "1")


def _add_hook(outputs: Outputs, result: Result, file: Path, function: str) -> None:
    """What the user's function makes of the result. Whatever it raises becomes a fault with its message."""
    try:
        answer = hook_function(file, function)(result)
        if not isinstance(answer, Mapping):
            raise TypeError(f"returned {type(answer).__name__}, must be a dict of names and numbers")
        for name, value in answer.items():
            if not isinstance(name, str) or not name.isidentifier():
                raise TypeError(f"returned the name {name!r:.40}, must be of letters, digits and _")
            if isinstance(value, bool | str) or not np.isscalar(value):
                raise TypeError(f"returned {name} = {value!r:.40}, must be a number")
            outputs.add(name, value, _unit_in(name))
    except InputError as error:
        outputs.faults.append(str(error))
    except BaseException as error:  # SystemExit too; Ctrl-C does not come to the thread in which a worker runs a case
        outputs.faults.append(f"outputs.hook: {file}: {function}: {type(error).__name__}: {error}")


def hook_function(file: Path, function: str) -> Callable[[Result], Any]:
    """The function of that name in a file of the user's, which is executed: in workers only."""
    spec = importlib.util.spec_from_file_location(f"wrsim_hook_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise InputError(f"outputs.hook: {file}: is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, function)  # type: ignore[no-any-return]


def check_hook(file: Path, function: str) -> None:
    """Raises ``InputError`` for a file that is no Python or binds no such name; nothing in it is executed."""
    content = read_bytes(file, "Python file")
    try:
        symbols = symtable.symtable(content, str(file), "exec").get_symbols()  # type: ignore[arg-type]
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise InputError(f"{file}: is no Python: {error}") from None
    names = [s.get_name() for s in symbols if s.is_assigned() or s.is_imported()]
    if function not in names and b"import *" not in content:
        offered = [name for name in names if not name.startswith("_")]
        hint = f"it has {', '.join(offered)}" if offered else "it has none"
        raise InputError(f"{file} has no function '{function}'{suggest(function, offered)}; {hint}")


def outputs_digest(wanted: OutputsSection, hook: Path | None) -> str:
    """Digest of the outputs section: with another one, stored results are reduced again."""
    digest = hashlib.sha256(wanted.model_dump_json().encode())
    if hook is not None:
        digest.update(read_bytes(hook, "Python file"))
    return digest.hexdigest()[:16]
