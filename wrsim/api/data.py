"""Data from and for other programs, and files to start from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from wrsim.api.outcome import Given, Outcome, Values, as_result, as_scenario, folder_beside
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.scenario.loading import Scenario


def export(result: Given, to: str, output: str | Path | None = None) -> Outcome:
    """Write a result for other programs.

    Parameters
    ----------
    result : Result, str or Path
        Any result.
    to : str
        ``"mat"``, ``"csv"``, ``"parquet"``, ``"mdf"``, ``"tables"``, or several with commas between.
    output : str or Path, optional
        Folder; beside the result unless given.

    Returns
    -------
    Outcome
        ``files``.

    Raises
    ------
    InputError
        For an unknown format, a missing library, and a Result without ``output``.
    """
    from wrsim.results.exports import export_result, formats

    names, folder = formats(to), folder_beside(result, output)
    loaded = as_result(result)
    return Outcome([], {}, [file for name in names for file in export_result(loaded, name, folder)])


def read_recording(
    file: str | Path, output: str | Path | None = None, *, columns: str | Path | None = None,
    chord_m: tuple[float, float] | None = None, band: str | None = None,
    wavelength_m: tuple[float, float] = (3.0, 70.0), amplification: float = 8.0, transitions: str = "either",
    from_m: float | None = None, to_m: float | None = None, vehicle: str = "vehicles/manchester_1.toml",
    speed_kmh: float | None = None, models: Sequence[str | Path] = (), pictures: bool = True,
) -> Outcome:  # fmt: skip
    """Make a track, its irregularities and a scenario of a track recording car's table.

    Parameters
    ----------
    file : str or Path
        Table of the recording (CSV).
    output : str or Path, optional
        Folder for the files; without it nothing is written. All others as of ``wrsim recording``.

    Returns
    -------
    Outcome
        ``found`` is the restored track.

    Raises
    ------
    InputError
        For a table that cannot be read, with line and column.
    """
    from wrsim.inputs.checking import check_value, kind_of
    from wrsim.inputs.values import number
    from wrsim.recording.scenario_file import restored_track
    from wrsim.recording.tables import recording_numbers, recording_tables
    from wrsim.report.outputs import write_recording

    check_value(Annotated[float, number(1, 500, "km/h")] | None, speed_kmh, "--speed-kmh")
    path, beside = Path(file), Path(file).with_suffix(".toml")
    if path.suffix.lower() != ".csv" and (kind := kind_of(path)):
        raise InputError(f"{path}: is {kind}; the table of a recording is needed here")
    chosen = Path(columns) if columns is not None else beside if beside.is_file() else None
    found = restored_track(path, chosen, chord_m, band, (from_m, to_m), wavelength_m, amplification, transitions)
    files = []
    if output is not None:
        files = write_recording(found, Path(output), vehicle, speed_kmh, list(map(Path, models)), pictures)
    folder = None if output is None else Path(output)
    return Outcome(recording_tables(found), recording_numbers(found), files, found, folder=folder)


def write_unit(
    scenario: Scenario | str | Path, output: str | Path | None = None, values: Values = (), *,
    step: float = 1e-3, models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Write the vehicle of a run as a co-simulation unit of FMI 3.0, for Linux; it needs no Python when it runs.

    Parameters
    ----------
    scenario : Scenario, str or Path
        Of a run along the track, from whose start the unit starts.
    output : str or Path, optional
        The file; <name of the scenario's file>.fmu here unless given.
    values : sequence of str, or mapping
        Keys to be changed, ``"vehicle.drive=free"``.
    step : float
        Of the integration [s]. models: as of `check`.

    Returns
    -------
    Outcome
        ``["inputs"]``: their names.

    Raises
    ------
    InputError, SimulationError
        As `stepper`; WrsimError without a C compiler.
    """
    from wrsim.analysis.motion.unit import packed_unit
    from wrsim.results import write_atomically
    from wrsim.results.files import KEEPER

    loaded = as_scenario(scenario, models).with_set(values)
    path = Path(output or f"{loaded.path.stem if loaded.path else 'vehicle'}.fmu")
    if (keeper := KEEPER.get()) is not None:
        keeper.check(path)  # before the work
    content, inputs = packed_unit(loaded, path.stem, step)
    return Outcome([], {"inputs": inputs}, [write_atomically(path, content)])


def new_file(kind: str = "curving", template: str | None = None, output: str | Path | None = None) -> Outcome:
    """Write a file to start from, which can be used as it is: a scenario that names all keys, or another kind.

    Parameters
    ----------
    kind, template : str
        As of ``wrsim new``.
    output : str or Path, optional
        The file; <template or kind>.toml here unless given.

    Returns
    -------
    Outcome
        ``files``, those that the first one names included.

    Raises
    ------
    InputError
        For a kind or a template that there is not.
    """
    from wrsim.inputs.file_kinds import OTHER_NAMES
    from wrsim.register import ANALYSES
    from wrsim.results import write_atomically
    from wrsim.scenario.templates import template_files

    texts = template_files(kind, template, Path(output or f"{template or kind}.toml"))
    files = [write_atomically(path, text.encode()) for path, text in texts.items()]
    command = "run" if kind in ANALYSES else "vehicle" if kind == "train" else kind
    of_kind = "" if kind in ANALYSES else f" --file {OTHER_NAMES.get(kind, kind)}"
    use = [f"use it with: wrsim {command} {files[0]}", f"wrsim keys{of_kind} explains its keys"]
    return Outcome([], {}, files, lines=use)


def keys(section: str | None = None, file: str = "scenario", schema: bool = False) -> Outcome:
    """The keys of a table: unit, what is allowed, default, other names, an example.

    Parameters
    ----------
    section : str, optional
        A table such as ``"contact"``; all tables unless given.
    file : str
        Kind of file, as of ``wrsim keys``.
    schema : bool
        Whether ``lines`` are the JSON schema of that kind of file.

    Returns
    -------
    Outcome
        ``lines``, and the same as ``numbers``.

    Raises
    ------
    InputError
        For a kind of file or a table that there is not.
    """
    from wrsim.scenario.reference import keys_numbers, keys_text, kind_of_file, schema_text

    kind = kind_of_file(file)
    return Outcome([], keys_numbers(kind, section), lines=[schema_text(kind) if schema else keys_text(kind, section)])
