"""What commands leave in a folder besides a result: tables first, pictures last."""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim.assessment.outcome import Assessment, assessment_csv, assessment_json
from wrsim.errors import InputError, in_one_line
from wrsim.inputs.toml_files import write_toml
from wrsim.plots import patch_gallery, save, section_gallery, standard_figures, standard_pictures
from wrsim.plots.assessment import assessment_figures
from wrsim.plots.compare import has_curves, overlay_figure, patches_figure, values_figure
from wrsim.plots.conicity import conicity_map_figure
from wrsim.plots.cross_section import has_outlines
from wrsim.plots.drawing import Makers, save_all
from wrsim.plots.profile import profile_figure, profiles_figure
from wrsim.plots.ride import ride_figures
from wrsim.plots.spectra import spectra_figure
from wrsim.plots.theme import LOOK
from wrsim.plots.track import track_figure
from wrsim.plots.vehicle import campbell_figure, loops_figure, vehicle_figure
from wrsim.results.channels import WHEELS
from wrsim.results.conicity import ConicityMap
from wrsim.results.differences import Deviation, difference_table
from wrsim.results.files import KEEPER, as_csv, as_json, write_atomically
from wrsim.results.moments import has_patches, moments_at
from wrsim.results.ride import Ride
from wrsim.results.spectra import spectra_files
from wrsim.results.table import Table, as_rows, quantity
from wrsim.results.tables import tables
from wrsim.results.wheelsets import matched, of_wheelset, wheelsets, worst_wheelset

if TYPE_CHECKING:
    from wrsim.analysis.compare import Comparison
    from wrsim.analysis.stationary.loops import RotationTest, TwistTest
    from wrsim.contact.profiles.profile import Kind, Profile
    from wrsim.recording.restoring import Restored
    from wrsim.recording.track_class import ClassWindow
    from wrsim.results import Result
    from wrsim.vehicle.vehicle import Vehicle


def file_name(text: str) -> str:
    """A name of a model or a place as the name of a file."""
    return "".join(c if c.isalnum() or c in "-+._" else "_" for c in text)


def _written(directory: Path, contents: Mapping[str, bytes], figures: Makers) -> list[Path]:
    files = [write_atomically(directory / name, content) for name, content in contents.items()]
    return files + save_all(figures, directory)


def write_assessment(assessment: Assessment, directory: Path, pictures: bool) -> list[Path]:
    """``assessment.json``, ``assessment.csv`` and pictures."""
    contents = {"assessment.json": assessment_json(assessment), "assessment.csv": assessment_csv(assessment)}
    return _written(directory, contents, assessment_figures(assessment) if pictures else {})


def write_ride(ride: Ride, directory: Path, pictures: bool) -> list[Path]:
    """``ride.json``, third-octaves, spectra and pictures."""
    return _written(directory, ride.files(), ride_figures(ride) if pictures else {})


def write_spectra(data: xr.Dataset, directory: Path, pictures: bool) -> list[Path]:
    """Third-octaves and spectra of a channel, and their picture."""
    contents = spectra_files(data)
    name = next(reversed(contents)).removesuffix(".csv")
    return _written(directory, contents, {name: partial(spectra_figure, data)} if pictures else {})


def write_comparison(
    comparison: Comparison, report: dict[str, Any], directory: Path, pictures: bool, title: str
) -> list[Path]:
    """``comparison.json``, ``comparison.csv``, the result of every model and pictures."""
    from wrsim.analysis.compare import rows_of_samples

    contents = {"comparison.json": as_json(report), "comparison.csv": as_csv(rows_of_samples(comparison))}
    files = _written(directory, contents, {})
    files += [model.result.save(directory / file_name(model.name) / "result.nc") for model in comparison.models]
    if not pictures:
        return files
    models = sorted(comparison.models, key=lambda model: model is not comparison.main)
    figures: dict[str, Any] = {"compare_values": lambda: values_figure(comparison.values, comparison.reference, title)}
    names = wheelsets(comparison.main.result.dataset)
    for name in names:
        each = {model.name: of_wheelset(model.result.dataset, name) for model in models}
        suffix, heading = (f"_{name}", f"{title}: {name}") if len(names) > 1 else ("", title)
        drawn = {model: dataset for model, dataset in each.items() if has_patches(dataset)}
        if comparison.reference in drawn and len(drawn) > 1:
            figures[f"compare_patches{suffix}"] = partial(patches_figure, drawn, heading)
    return files + save_all(figures, directory)


def write_differences(
    deviations: Sequence[Deviation], results: Sequence[Result], names: Sequence[str], folder: Path
) -> list[Path]:
    """``diff.csv`` and, of runs and poses, ``diff.png``."""
    figures: dict[str, Any] = {}
    reference, compared = results[0].dataset, matched(results[1].dataset, results[0].dataset)
    if has_curves(reference) and has_curves(compared) and (worst := worst_wheelset(reference)) in wheelsets(compared):
        pair = [of_wheelset(dataset, worst) for dataset in (reference, compared)]
        figures["diff"] = lambda: overlay_figure(pair, names)
    return _written(folder, {"diff.csv": as_csv(as_rows(difference_table(deviations)))}, figures)


def write_conicity(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """``conicity.csv`` and pictures."""
    contents = {"conicity.csv": as_csv(tables(result.dataset)["conicity"])}
    return _written(directory, contents, standard_figures(result.dataset) if pictures else {})


def write_conicity_map(conicity: ConicityMap, directory: Path, pictures: bool) -> list[Path]:
    """``conicity_map.csv`` and ``conicity_map.png``."""
    figures = {"conicity_map": lambda: conicity_map_figure(conicity, conicity.title)} if pictures else {}
    return _written(directory, {"conicity_map.csv": as_csv(as_rows(conicity.table()))}, figures)


def write_recording(
    restored: Restored, directory: Path, vehicle: str, speed: float | None, models: Iterable[Path], pictures: bool,
    windows: tuple[ClassWindow, ...] = (),
) -> list[Path]:  # fmt: skip
    """All files of a restored track and of its class windows, none before it is sure that no file is in the way."""
    from wrsim.recording import scenario_file as recorded
    from wrsim.recording.picture import recording_figure
    from wrsim.recording.track_class import CLASSES, class_table
    from wrsim.scenario.build import build
    from wrsim.scenario.loading import load

    columns = recorded.noted(restored) + write_toml(restored.recording.columns.model_dump(exclude_none=True))
    contents = {
        recorded.COLUMNS: columns.encode(),
        recorded.IRREGULARITIES: as_csv(recorded.irregularity_rows(restored)),
        recorded.TRACK: recorded.track_file(restored, datetime.date.today().isoformat()).encode(),
        recorded.SCENARIO: recorded.scenario_file(restored, vehicle, speed or recorded.usual_speed(restored)).encode(),
    } | ({CLASSES: as_csv(as_rows(class_table(windows, len(windows))))} if windows else {})
    if (keeper := KEEPER.get()) is not None:
        for name in (*contents, *(f"recording.{kind}" for kind in LOOK.get().kinds)):
            keeper.check(directory / name)
    beside = [directory] if directory.is_dir() else []
    with TemporaryDirectory() as trial:
        _written(Path(trial), contents, {})
        try:
            build(load(Path(trial) / recorded.SCENARIO, (*models, *beside)))
        except InputError as error:  # of rows that the user knows, not of files that are not there yet
            reason = re.sub(rf"{re.escape(trial)}/\S+?(:\d+)?: ", "", in_one_line(error)).replace(trial, str(directory))
            raise InputError(f"{restored.recording.path}: no run over this track: {reason}") from None
    files = _written(directory, contents, {})
    return files + save_all({"recording": lambda: recording_figure(restored)} if pictures else {}, directory)


def draw_pictures(dataset: xr.Dataset, places: Sequence[str] | None, directory: Path) -> list[Path]:
    """The standard pictures of a result; at distances [m] or poses patches and sections of one wheelset there alone."""
    if not places:
        return standard_pictures(dataset, directory)
    moments = moments_at(dataset, places, "--at")
    name = "_".join(file_name(place) for place in places)
    galleries = {"patches": patch_gallery} | ({"sections": section_gallery} if has_outlines(dataset) else {})
    figures = {f"{kind}_at_{name}": partial(make, dataset, moments) for kind, make in galleries.items()}
    return save_all(figures, directory)


MODELS: dict[str, Callable[..., Figure]] = {
    "profile": profile_figure,  # a profile, and reports of its smoothing
    "track": track_figure,
    "vehicle": vehicle_figure,
    "campbell": campbell_figure,  # a title, and the numbers of every kind of elastic axle
}


def draw_model(kind: str, picture: Path, *model: object) -> Path:
    """Draw a profile with slope and curvature, a track, a vehicle, or Campbell's diagram of its axles."""
    return save(MODELS[kind](*model), picture)


def write_profiles(
    profiles: Mapping[str, Profile], tables: Mapping[Kind, Table], unworn: Profile | None, picture: Path
) -> list[Path]:
    """Profiles over each other and what was measured of them: a picture, and a table (CSV) beside it; of wheels and of
    rails where there are both."""
    files = []
    for kind, table in tables.items():
        path = picture if len(tables) == 1 else picture.with_stem(f"{picture.stem}_{kind}s")
        files.append(write_atomically(path.with_suffix(".csv"), as_csv(as_rows(table))))
        like = unworn if unworn is not None and unworn.kind == kind else None
        files.append(save(profiles_figure([p for p in profiles.values() if p.kind == kind], table, like), path))
    return files


def draw_loops(vehicle: Vehicle, twisted: TwistTest | None, turned: Sequence[RotationTest], path: Path) -> Path:
    """The loops of a twist test, and of the rotation test of the first bogie."""
    diagrams: list[tuple[str, str, list[tuple[str, Any, Any]]]] = []
    if twisted is not None:
        loads = 1e-3 * twisted.wheel_loads
        front = enumerate(vehicle.wheelsets[: (len(vehicle.wheelsets) + 1) // 2])
        lines = [(f"{m.name} {side}", twisted.part, loads[:, i, k]) for i, m in front for k, side in enumerate(WHEELS)]
        diagrams.append(("part of the full twists", "wheel load Q [kN]", lines))
    if turned:
        first = [test for test in turned if test.bogie == turned[0].bogie]
        rates = [quantity(float(np.degrees(test.rate)), "deg/s", "g") for test in first]
        lines = [(r, np.degrees(t.angle), 1e-3 * t.moment) for r, t in zip(rates, first, strict=True)]
        diagrams.append((f"angle of {first[0].bogie.frame} [deg]", "moment [kNm]", lines))
    return save(loops_figure(vehicle.name, diagrams), path)
