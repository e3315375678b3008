"""From a file to a Scenario: read, merged with its base, every key checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from datetime import date, time
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from wrsim.errors import InputError
from wrsim.inputs.changes import changed, full_path, key_path
from wrsim.inputs.checking import check_section, dotted, fault_line, refuse_other_kind
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.lookup import Finder, as_path
from wrsim.inputs.notebook import card, folded
from wrsim.inputs.section import Section, checked_before
from wrsim.inputs.toml_files import parse_value, shortened, value_hint, write_toml
from wrsim.register import ANALYSES
from wrsim.results.units import prefer
from wrsim.scenario.merging import BASE, TRACK_FILE, Merged, holds_key, of_text, read_merged, value_at, with_track_file
from wrsim.scenario.schema import ScenarioFile, ScenarioSpec
from wrsim.scenario.sections.vehicle import VehicleSection
from wrsim.vehicle.vehicle_sections import TrainFile, VehicleFile, WheelsetFile

OF_FILES = {*VehicleFile.model_fields, *WheelsetFile.model_fields, *TrainFile.model_fields}
"""Keys at the top of vehicle and train files."""

T = TypeVar("T")
S = TypeVar("S", bound=Section)


@dataclass(frozen=True)
class Scenario:
    """A scenario file that has passed every check of its keys, in the file's own units.

    spec: the tables; path: the file, None for a text; finder: folders in which model files are looked up.
    `wrsim.scenario.build.build` turns it into SI.
    """

    spec: ScenarioSpec
    path: Path | None
    finder: Finder
    merged: Merged = field(repr=False, compare=False)

    def __repr__(self) -> str:
        return f"Scenario({self.title!r}, {self.analysis}, {self.path or 'from a text'})"

    def _repr_html_(self) -> str:
        rows = (("analysis", self.analysis), ("file", self.path or "from a text"))
        return card(self.title, rows, folded("the whole as TOML", self.text))

    @cached_property
    def text(self) -> str:
        """The whole as TOML, with everything that came from ``base``."""
        return self.merged.text or write_toml(self.merged.data)

    @property
    def title(self) -> str:
        """The title in the file."""
        return self.spec.title

    @property
    def analysis(self) -> str:
        """Kind of the analysis, as in the register."""
        return self.spec.analysis

    def table(self, kind: type[S]) -> S:
        """The table of this class. Raises InputError where the file has none."""
        for name in type(self.spec).model_fields:
            if isinstance(table := getattr(self.spec, name), kind):
                return table
        raise InputError(f"{self.path or 'scenario'}: has no table {kind.header}")

    def locate(self, path: KeyPath) -> str:
        """Return file and line of a key, for messages."""
        return self.merged.locate(path)

    def fault(self, path: KeyPath, message: str) -> InputError:
        """Return the error for a key whose value passed the schema but does not fit the rest."""
        try:
            value = value_at(self.merged.data, path)
        except (KeyError, IndexError, TypeError):
            value = None  # the key is not given: its default does not fit
        return InputError(fault_line(path, message, self.locate, value))

    @contextmanager
    def faults_at(self, path: KeyPath) -> Iterator[None]:
        """Errors of this block are faults of the key at ``path``."""
        try:
            yield
        except InputError as error:
            raise self.fault(path, str(error)) from None

    def find(self, path: KeyPath, name: str) -> Path:
        """The model file that the key at ``path`` names. Raises InputError with that key."""
        with self.faults_at(path):
            return self.finder.find(name)

    def read(self, path: KeyPath, name: str, reader: Callable[[Path], T]) -> T:
        """Read the model file that the key at ``path`` names. Errors in it also name that key."""
        file = self.find(path, name)
        try:
            with self.spec.profiles.reading():
                return reader(file)
        except InputError as error:
            named, message = f"{dotted(path)} in {self.locate(path)}", str(error)
            raise InputError(f"{message}\nnamed by {named}" if "\n" in message else f"{message} ({named})") from None

    def with_set(self, options: Sequence[str] | Mapping[str, Any]) -> Scenario:
        """The scenario with keys changed by ``--set key=value``: values as in TOML, bare words are texts; model
        files are looked up in the working directory, too. A mapping has values, as `with_values` takes them.

        Raises InputError.
        """
        scenario = self
        if options and not self.finder.closed:  # names typed here are meant from here
            scenario = replace(self, finder=replace(self.finder, folders=(*self.finder.folders, Path())))
        if isinstance(options, Mapping):
            return scenario.with_values(options)
        for option in [options] if isinstance(options, str) else options:
            key, _, value = (part.strip() for part in option.partition("="))
            if not key or not value:
                raise InputError(f"--set {shortened(option)}: must be key=value, such as vehicle.speed_kmh=60")
            owner, parsed = f"--set {shortened(option)}", parse_value(value)
            try:
                scenario = scenario.with_values({key: parsed}, owner)
            except InputError as error:  # bare words are texts here, only numbers may be meant otherwise
                if isinstance(parsed, float):
                    with suppress(InputError):  # the name 60E1 is a number in TOML
                        scenario = scenario.with_values({key: value}, owner)
                        continue
                raise InputError(f"{error}{value_hint(value) if value[0] in '+-.0123456789' else ''}") from None
        return scenario

    def with_values(self, values: Mapping[str, Any], owner: str = "new value", without: Sequence[str] = ()) -> Scenario:
        """The scenario with some keys changed, checked again.

        Parameters
        ----------
        values : mapping
            From dotted keys to values in the file's units: ``{"vehicle.speed_kmh": 60}``. Places in lists are numbers
            or names: ``"track.segments[2].radius_m"``. Keys of the vehicle's file follow behind ``vehicle``, by the
            names of its parts and elements: ``"vehicle.bogie.primary.stiffness_kN_per_m.2"``. Values may be tables,
            lists, numbers and arrays of numpy.
        owner : str
            From where the values come, for messages.
        without : sequence of str
            Dotted keys to be left out.

        Returns
        -------
        Scenario

        Raises
        ------
        InputError
            With all faults, like `load`.

        Examples
        --------
        >>> from wrsim import load
        >>> slow = load("scenarios/curve_r300.toml").with_values({"vehicle.speed_kmh": 36, "contact.friction": 0.2})
        """
        if TRACK_FILE in values and len(values) > 1:  # what else is changed lies over the file
            rest = {key: value for key, value in values.items() if key != TRACK_FILE}
            return self.with_values({TRACK_FILE: values[TRACK_FILE]}, owner).with_values(rest, owner, without)
        data, owners = self.merged.data, dict(self.merged.owners)
        for key, value in (*values.items(), *dict.fromkeys(without).items()):
            try:
                path = full_path(data, own_path(key), by_name=False)
                new = next((end for end in range(1, len(path)) if not holds_key(data, path[:end])), len(path))
                data = changed(data, path, _plain(key, value) if key in values else None)
            except InputError as error:
                raise InputError(f"{owner}: {error}") from None
            owners |= {path[:end]: owner for end in range(new, len(path) + 1)}
        unchanged = {name: table for name, table in self.merged.data.items() if data.get(name) is table}
        with checked_before({id(table): getattr(self.spec, name, None) for name, table in unchanged.items()}):
            scenario = _checked(replace(self.merged, data=data, text="", owners=owners), self.path, self.finder)
        prefer(scenario.spec.units)
        return scenario


def load(path: str | Path, models: Sequence[str | Path] = ()) -> Scenario:
    """Read and check a scenario file.

    Parameters
    ----------
    path : str or Path
        The file (TOML); ``wrsim new`` writes one to start from.
    models : sequence of str or Path
        Folders with model files of your own. Names are looked up beside the scenario file (then beside the files it
        starts from), in these folders, in those of the environment variable WRSIM_MODELS, and in the models that come
        with wrsim.

    Returns
    -------
    Scenario

    Raises
    ------
    InputError
        With all faults of the file, one line each; for a vehicle or a profile that it names and that is not there.

    Examples
    --------
    >>> from wrsim import load, run
    >>> result = run(load("scenarios/curve_r300.toml"))
    """
    path = as_path(path, "a scenario file")
    merged = read_merged(path)
    analysis = ANALYSES.get(str(merged.data.get("analysis")))
    inherited = {key for key in merged.data if merged.owners.get((key,)) != str(merged.files[0])}
    if analysis is not None and (unused := inherited & {*analysis.unused}):
        merged.data = {key: value for key, value in merged.data.items() if key not in unused}
        merged.text = write_toml(merged.data)
    scenario = _scenario(merged, path, models)
    prefer(scenario.spec.units)
    vehicle, track = scenario.spec.vehicle, scenario.spec.track
    named = {"vehicle": (vehicle, ("model", "wheel", "wheel_left", "wheel_right"))}
    for table, (section, keys) in (named | {"track": (track, ("rail", "rail_left", "rail_right"))}).items():
        for key in keys:
            if (name := getattr(section, key)) is not None:
                scenario.find((table, key), name)
    return scenario


def loaded(source: Scenario | str | Path, models: Sequence[str | Path] = ()) -> Scenario:
    """What is given, or the scenario of that file."""
    return source if isinstance(source, Scenario) else load(source, models)


def load_text(
    text: str, folder: str | Path = ".", models: Sequence[str | Path] = (), *, closed: bool = False
) -> Scenario:
    """Check a scenario given as TOML text, such as the one that a result carries.

    Parameters
    ----------
    text : str
        What a scenario file holds; ``result.dataset.attrs["scenario_text"]`` is one.
    folder : str or Path
        Where names of model files are looked up first.
    models : sequence of str or Path
        As for `load`.
    closed : bool
        True for a text that somebody else may have written: files outside of ``folder`` and of the folders with models
        are not opened, neither now nor by what the scenario is used for.

    Returns
    -------
    Scenario

    Raises
    ------
    InputError
        With all faults of the text, one line each.
    """
    if not isinstance(text, str):
        raise InputError(f"{text!r:.60}: must be the text of a scenario")
    merged = of_text(text, "scenario", ())
    if BASE in merged.data:
        raise InputError("scenario: base: needs a file; this text has to be whole")
    return _scenario(merged, None, models, Path(folder), closed)


def _scenario(
    merged: Merged, path: Path | None, models: Sequence[str | Path], folder: Path = Path(), closed: bool = False
) -> Scenario:
    beside = [file.parent for file in merged.files] or [folder]
    if len(merged.files) > 1:  # keys of its base hide what the file itself is
        top = {key: value for key, value in merged.data.items() if merged.owners.get((key,)) == str(merged.files[0])}
        refuse_other_kind(ScenarioFile, top, lambda _: str(merged.files[0]))
    return _checked(merged, path, Finder.of(beside, models, closed))


def _checked(merged: Merged, path: Path | None, finder: Finder) -> Scenario:
    count = len(merged.files)
    with finder.guard():
        merged = with_track_file(merged, finder)
    if len(merged.files) > count:  # what a track file names may lie beside it
        finder = replace(finder, folders=tuple(dict.fromkeys((*finder.folders, merged.files[-1].parent))))
    return Scenario(check_section(ScenarioFile, merged.data, merged.locate), path, finder, merged)


def own_path(dotted_key: str) -> KeyPath:
    """The path of a key in a scenario; what [vehicle] does not have is of the vehicle's file: ``vehicle.changes``."""
    path = key_path(dotted_key)
    if path[:2] == ("vehicle", "wheel_changes") and len(path) > 2:  # keys of the profile's file are one text as well
        return (*path[:2], dotted_key.split(".", 2)[2])
    if path[0] != "vehicle" or len(path) < 2 or path[1] in VehicleSection.model_fields:
        return path
    if len(path) == 2 and path[1] not in OF_FILES:
        return path
    return ("vehicle", "changes", dotted_key.partition(".")[2])


def _plain(key: str, value: Any) -> Any:
    """A value as from a TOML file. Raises InputError for one that no file can hold."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(f"{key}.{name}", inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(f"{key}[{i}]", inner) for i, inner in enumerate(value)]
    if isinstance(value, bool | int | float | str | date | time):
        return value
    allowed = "a number, a text, true or false, a date, or a list or table of such"
    raise InputError(f"{key} = {value!r:.60}: must be {allowed}")
