"""Data from and for other programs, and templates."""

import json
from pathlib import Path
from typing import Annotated, Literal

from wrsim.api import options
from wrsim.api.options import AnyPath, Argument, Option, documented, into
from wrsim.api.outcome import Outcome, as_result, as_scenario, folder_beside, folder_or_none
from wrsim.errors import InputError
from wrsim.inputs.file_kinds import FILES, OTHER_NAMES
from wrsim.register import ANALYSES

Kind = Annotated[
    str, Argument(f"{', '.join(ANALYSES)} (scenarios), vehicle, train, track, profile, study, wear.", "KIND")
]
SYSTEMS = "linux", "linux-arm", "windows", "macos"
TEMPLATES = (
    "vehicle: coach, metro, freight, three-piece, tram, locomotive, wheelset; track: curve, line; "
    "profile: wheel, rail, worn-wheel."
)


@documented
def export(
    result: options.ResultFile,
    to: Annotated[str, Option("mat, csv, parquet, mdf, tables; one or more with commas.", "FORMAT,...")],
    output: options.BesideResult = None,
) -> Outcome:
    """Write a result for other programs: MATLAB, CSV, Parquet, MDF (result.mat, .csv, .parquet, .mf4), all tables.

    Raises
    ------
    InputError
        For an unknown format, a missing library, and a Result without ``output``.
    """
    from wrsim.results.exports import export_result, formats

    names, folder = formats(to), folder_beside(result, output)
    loaded = as_result(result)
    return Outcome([], {}, [file for name in names for file in export_result(loaded, name, folder)])


@documented
def dataset(
    study: Annotated[str | Path, Argument("Folder of a study or an optimisation.", "STUDY", kind=Path)],
    output: options.BesideResult = None,
) -> Outcome:
    """Labelled runs of a study for training: inputs, outputs, scenario digest, a row a case (dataset.parquet).

    Returns
    -------
    Outcome
        ``files`` has the table; ``value`` is the dataset of the study.

    Raises
    ------
    InputError
        For a folder without a study, and without pyarrow.
    """
    from wrsim.results import write_atomically
    from wrsim.study.collect import read_study
    from wrsim.study.labelled import as_parquet, labelled_table

    runs, folder = read_study(Path(study)), folder_beside(Path(study), output)
    file = write_atomically(folder / "dataset.parquet", as_parquet(runs))
    return Outcome([labelled_table(runs)], {"rows": int(runs["status"].size)}, [file], runs)


@documented
def read_recording(
    file: Annotated[str | Path, Argument("Table of a recording (CSV).", "FILE")],
    output: Annotated[AnyPath, into("Folder for the files.", "DIR", default="<FILE>")] = None,
    *,
    columns: Annotated[
        AnyPath, Option("Column map; default: the TOML of FILE's name beside it, or columns' names.", "TOML")
    ] = None,
    chord_m: Annotated[
        tuple[float, float] | None, Option("Chord of alignment and level, if no map gives it.", "BEHIND AHEAD")
    ] = None,
    band: Annotated[str | None, Option("Inertial band, if no map gives it.", "D1|D2|D3")] = None,
    wavelength_m: Annotated[tuple[float, float], Option("Wavelengths that are restored.", "SHORT LONG")] = (3.0, 70.0),
    amplification: Annotated[float, Option("Maximum gain of the inverse filter.")] = 8.0,
    transitions: Annotated[
        str, Option("Form of transitions; either: the better fit.", "clothoid|bloss|either")
    ] = "either",
    from_m: Annotated[float | None, Option("Start of the distance that is used.", "M")] = None,
    to_m: Annotated[float | None, Option("End of the distance that is used.", "M")] = None,
    vehicle: Annotated[str, Option("Vehicle of the scenario.", "MODEL")] = "vehicles/manchester_1.toml",
    speed_kmh: Annotated[
        float | None, Option("Speed of the scenario; default: 100 mm of cant deficiency, 160 at most.")
    ] = None,
    track_class: Annotated[bool, Option("Class of track by 49 CFR 213 of every 100 ft.")] = False,
    models: options.Models = (),
    pictures: options.Pictures = True,
) -> Outcome:
    """Restore track and irregularities from a track recording car's table; writes a scenario (docs/user/recording.md).

    Returns
    -------
    Outcome
        ``value`` is the restored track.

    Raises
    ------
    InputError
        For a table that cannot be read, with line and column.
    """
    from wrsim.inputs.checking import check_value, kind_of
    from wrsim.inputs.values import number
    from wrsim.recording.scenario_file import restored_track
    from wrsim.recording.tables import recording_numbers, recording_tables
    from wrsim.recording.track_class import class_table, missing, quantities, track_classes
    from wrsim.report.outputs import write_recording

    check_value(Annotated[float, number(1, 500, "km/h")] | None, speed_kmh, "--speed-kmh")
    path, folder = Path(file), folder_or_none(output)
    if path.suffix.lower() != ".csv" and (kind := kind_of(path)):
        raise InputError(f"{path}: is {kind}; the table of a recording is needed here")
    chosen = columns_of(path, columns)
    track = restored_track(path, chosen, chord_m, band, (from_m, to_m), wavelength_m, amplification, transitions)
    limited = quantities(track) if track_class else {}
    windows = track_classes(track, limited) if track_class else ()
    tables = recording_tables(track) + ([class_table(windows, lacking=missing(limited))] if windows else [])
    numbers = recording_numbers(track) | ({"track_class": [w._asdict() for w in windows]} if windows else {})
    if folder is None:
        return Outcome(tables, numbers, value=track)
    files = write_recording(track, folder, vehicle, speed_kmh, list(map(Path, models)), pictures, windows)
    lines = [f"run it with: wrsim run {folder / 'scenario.toml'}"]
    return Outcome(tables, numbers, files, track, folder=folder, lines=lines)


def columns_of(file: Path, columns: str | Path | None) -> Path | None:
    """The column map of a recording: the one that is named, else the TOML file beside it."""
    beside = file.with_suffix(".toml")
    return Path(columns) if columns is not None else beside if beside.is_file() else None


@documented
def write_unit(
    scenario: options.ScenarioFile,
    output: Annotated[AnyPath, into("The unit; <name of FILE>.fmu here unless given.", "FMU")] = None,
    values: options.Values = (),
    *,
    step: Annotated[float | None, "Step of the integration [s]; None: one that holds over the run."] = None,
    budget: options.Budget = None,
    fmi: Annotated[Literal["2", "3"], Option("Version of FMI: 2.0 or 3.0.", "2|3")] = "3",
    systems: Annotated[
        str,
        Option("Systems it runs on; default: all that there is a C compiler for.", ",".join(SYSTEMS), flags="--for"),
    ] = "",
    models: options.Models = (),
) -> Outcome:
    """Write the vehicle of a run as a co-simulation unit (FMI 3.0 or 2.0).

    The unit starts from the start of the run; it needs no Python when it runs. Without --step-ms the step is 1 ms,
    halved until it holds: in 95 % of the steps of the run at most 1 % of the weight is left without balance.
    Machine code for this system needs a C compiler, that for others zig (pip install ziglang).

    Returns
    -------
    Outcome
        ``["inputs"]``: their names; ``["fmi"]``, ``["systems"]``, ``["step_s"]``.

    Raises
    ------
    InputError, SimulationError
        As `stepper`; WrsimError without a C compiler.
    """
    from wrsim.analysis.motion.fmu import export_fmu
    from wrsim.inputs.values import choice
    from wrsim.results import write_atomically
    from wrsim.results.files import KEEPER

    loaded = as_scenario(scenario, models).with_set(values)
    path = Path(output or f"{loaded.path.stem if loaded.path else 'vehicle'}.fmu")
    if (keeper := KEEPER.get()) is not None:
        keeper.check(path)  # before the work
    chosen = [system.strip() for system in systems.split(",") if system.strip()]
    for system in chosen:
        if system not in SYSTEMS:
            raise InputError(f'--for "{system}": must be {choice(SYSTEMS, system)}, or several of them with commas')
    unit = export_fmu(loaded, path.stem, step, list(dict.fromkeys(chosen)), fmi, budget)
    lines = [f"FMI {fmi}.0, for {', '.join(unit.systems)}; steps of {1e3 * unit.step:g} ms"]
    lines += [*filter(None, [unit.budget]), *(f"not for {missing}" for missing in unit.missing)]
    numbers = {"inputs": unit.inputs, "fmi": fmi, "systems": unit.systems, "step_s": unit.step}
    return Outcome([], numbers, [write_atomically(path, unit.content)], lines=lines)


@documented
def new_file(
    kind: Kind = "curving",
    template: Annotated[str | None, Argument(TEMPLATES, "[TEMPLATE]")] = None,
    output: Annotated[AnyPath, into("The file; <TEMPLATE or KIND>.toml here unless given.", "FILE")] = None,
) -> Outcome:
    """Write a template: a scenario that names all keys, or another kind of file.

    Returns
    -------
    Outcome
        ``files``, those that the first one names included.
    """
    from wrsim.results import write_atomically
    from wrsim.scenario.templates import template_files

    texts = template_files(kind, template, Path(output or f"{template or kind}.toml"))
    files = [write_atomically(path, text.encode()) for path, text in texts.items()]
    command = "run" if kind in ANALYSES else "vehicle" if kind == "train" else kind
    of_kind = "" if kind in ANALYSES else f" --file {OTHER_NAMES.get(kind, kind)}"
    use = [f"use it with: wrsim {command} {files[0]}", f"wrsim keys{of_kind} explains its keys"]
    return Outcome([], {}, files, lines=use)


@documented
def keys(
    section: Annotated[
        str | None, Argument("A table or a key, such as track.segments or contact.normal; default: all.", "SECTION")
    ] = None,
    file: Annotated[str, Option(f"{', '.join(FILES)}.", "KIND")] = "scenario",
    schema: Annotated[bool, Option("Print the JSON schema of that kind of file, for editors.")] = False,
) -> Outcome:
    """List the keys of a table: unit, what is allowed, default, other names, an example.

    Returns
    -------
    Outcome
        ``lines``, and the same as ``numbers``.
    """
    from wrsim.scenario.reference import keys_numbers, keys_text, kind_of_file, schema_text

    kind = kind_of_file(file)
    if schema:
        text = schema_text(kind)
        return Outcome([], json.loads(text), lines=[text])
    return Outcome([], keys_numbers(kind, section), lines=[keys_text(kind, section)])
