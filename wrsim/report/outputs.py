"""What commands leave in a folder besides a result: tables first, pictures last."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wrsim.results.files import KEEPER, as_csv, as_json, csv_parts, write_atomically
from wrsim.results.render import as_rows

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from wrsim.analysis.compare import Comparison
    from wrsim.analysis.stationary.rotation_test import RotationTest
    from wrsim.analysis.stationary.twist_test import TwistTest
    from wrsim.geometry.profile.profile import Profile
    from wrsim.geometry.profile.smoothing_report import SmoothingReport
    from wrsim.geometry.track.track import Track
    from wrsim.plots.vehicle import VehicleSketch
    from wrsim.recording.restoring import Restored
    from wrsim.results import Result
    from wrsim.results.assessment import Assessment
    from wrsim.results.conicity import ConicityMap
    from wrsim.results.differences import Difference
    from wrsim.results.ride import Ride
    from wrsim.vehicle.vehicle import Vehicle


def _drawn(figure: Figure, path: Path) -> Path:
    from wrsim.plots import save

    return save(figure, path)


def file_name(text: str) -> str:
    """A name of a model or a place as the name of a file."""
    return "".join(c if c.isalnum() or c in "-+._" else "_" for c in text)


def write_assessment(found: Assessment, directory: Path, pictures: bool) -> list[Path]:
    """``assessment.json``, ``assessment.csv`` and pictures."""
    from wrsim.results.assessment_tables import assessment_csv, assessment_json

    files = [
        write_atomically(directory / "assessment.json", assessment_json(found)),
        write_atomically(directory / "assessment.csv", assessment_csv(found)),
    ]
    if pictures:
        from wrsim.plots.assessment import assessment_pictures

        files += assessment_pictures(found, directory)
    return files


def write_ride(found: Ride, directory: Path, pictures: bool) -> list[Path]:
    """``ride.json``, third-octaves, spectra and pictures."""
    files = [
        write_atomically(directory / "ride.json", found.json()),
        write_atomically(directory / "third_octaves.csv", found.bands_csv()),
        write_atomically(directory / "spectra.csv", found.spectra_csv()),
    ]
    if pictures:
        from wrsim.plots.ride import ride_pictures

        files += ride_pictures(found, directory)
    return files


def write_comparison(
    found: Comparison, report: dict[str, Any], directory: Path, pictures: bool, title: str
) -> list[Path]:
    """``comparison.json``, ``comparison.csv``, the result of every model and pictures."""
    from wrsim.analysis.compare_tables import rows_of_samples
    from wrsim.plots.compare import patches_figure, values_figure
    from wrsim.results.moments import has_patches
    from wrsim.results.wheelsets import of_wheelset, wheelsets

    files = [
        write_atomically(directory / "comparison.json", as_json(report)),
        write_atomically(directory / "comparison.csv", as_csv(rows_of_samples(found))),
    ]
    files += [model.result.save(directory / file_name(model.name) / "result.nc") for model in found.models]
    if pictures:
        main = found.main
        results = {m.name: m.result.dataset for m in (main, *(m for m in found.models if m is not main))}
        files.append(_drawn(values_figure(found.values, found.reference, title), directory / "compare_values.png"))
        names = wheelsets(main.result.dataset)
        for name in names:
            each = {n: of_wheelset(d, name) for n, d in results.items()}
            own, words = (f"_{name}", f"{title}: {name}") if len(names) > 1 else ("", title)
            if all(has_patches(d) for d in each.values()):
                files.append(_drawn(patches_figure(each, words), directory / f"compare_patches{own}.png"))
    return files


def write_differences(
    found: Sequence[Difference], results: Sequence[Result], names: Sequence[str], folder: Path
) -> list[Path]:
    """``diff.csv`` and, of runs and poses, ``diff.png``."""
    from wrsim.plots.compare import has_curves, overlay_figure
    from wrsim.results.differences import table_of
    from wrsim.results.wheelsets import of_wheelset, wheelsets, worst_wheelset

    files = [write_atomically(folder / "diff.csv", as_csv(as_rows(table_of(found))))]
    one, other = (r.dataset for r in results)
    if has_curves(one) and has_curves(other) and (worst := worst_wheelset(one)) in wheelsets(other):
        pair = [of_wheelset(dataset, worst) for dataset in (one, other)]
        files.append(_drawn(overlay_figure(pair, names), folder / "diff.png"))
    return files


def write_conicity(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """``conicity.csv`` and pictures."""
    from wrsim.results.tables import write_table

    files = [write_table(result.dataset, "conicity", directory / "conicity.csv")]
    return files + (draw_result(result.dataset, directory) if pictures else [])


def write_conicity_map(found: ConicityMap, directory: Path, pictures: bool) -> list[Path]:
    """``conicity_map.csv`` and ``conicity_map.png``."""
    files = [write_atomically(directory / "conicity_map.csv", csv_parts(as_rows(found.table())))]
    if pictures:
        from wrsim.plots.conicity import conicity_map_figure

        files.append(_drawn(conicity_map_figure(found, found.title), directory / "conicity_map.png"))
    return files


def write_recording(
    restored: Restored, directory: Path, vehicle: str, speed: float | None, models: Iterable[Path], pictures: bool
) -> list[Path]:
    """All files of a restored track, none of them before it is sure that no file of the user's stands in the way."""
    from wrsim.scenario import recorded
    from wrsim.scenario.build import build
    from wrsim.scenario.loading import load

    texts = {
        recorded.COLUMNS: recorded.columns_file(restored).encode(),
        recorded.IRREGULARITIES: as_csv(recorded.irregularity_rows(restored)),
        recorded.TRACK: recorded.track_file(restored, datetime.date.today().isoformat()).encode(),
        recorded.SCENARIO: recorded.scenario_file(restored, vehicle, speed or recorded.usual_speed(restored)).encode(),
    }
    keeper = KEEPER.get()
    for name in (*texts, "recording.png"):
        if keeper is not None:
            keeper.check(directory / name)
    files = [write_atomically(directory / name, text) for name, text in texts.items()]
    build(load(directory / recorded.SCENARIO, tuple(models)))  # refuses what of the track or the vehicle cannot be
    if pictures:
        from wrsim.plots.recording import recording_figure

        files.append(_drawn(recording_figure(restored), directory / "recording.png"))
    return files


def draw_result(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """The standard pictures of a result."""
    from wrsim.plots import standard_pictures

    return standard_pictures(dataset, directory)


def draw_patches(dataset: xr.Dataset, at: list[str], directory: Path) -> list[Path]:
    """Patches and sections of one wheelset at distances [m] or poses."""
    from wrsim.plots import patch_gallery, section_gallery
    from wrsim.plots.cross_section import has_outlines
    from wrsim.results.moments import moments_at

    moments = moments_at(dataset, at, "--at")
    name = "_".join(file_name(place) for place in at)
    files = [_drawn(patch_gallery(dataset, moments), directory / f"patches_at_{name}.png")]
    if has_outlines(dataset):
        files.append(_drawn(section_gallery(dataset, moments), directory / f"sections_at_{name}.png"))
    return files


def draw_profile(profile: Profile, picture: Path, reports: Sequence[SmoothingReport]) -> Path:
    """A profile with slope and curvature, and what smoothing did to it."""
    from wrsim.plots.profile import profile_figure

    return _drawn(profile_figure(profile, reports), picture)


def draw_track(track: Track, picture: Path) -> Path:
    """Plan, curvature, cant, gauge, height, irregularities."""
    from wrsim.plots.track import track_figure

    return _drawn(track_figure(track), picture)


def draw_vehicle(vehicle: Vehicle, picture: Path) -> Path:
    """A vehicle from three sides."""
    from wrsim.plots.vehicle import vehicle_figure

    return _drawn(vehicle_figure(sketch_of(vehicle)), picture)


def draw_loops(vehicle: Vehicle, twisted: TwistTest | None, turned: Sequence[RotationTest], path: Path) -> Path:
    """The loops of a twist test, and of the rotation test of the first bogie."""
    from wrsim.plots.vehicle import Loop, loops_figure

    found = []
    if twisted is not None:
        wheels = [
            (f"{m.name} {side}", twisted.part, 1e-3 * twisted.wheel_loads[:, i, k])
            for i, m in enumerate(vehicle.wheelsets[: (len(vehicle.wheelsets) + 1) // 2])
            for k, side in enumerate(("left", "right"))
        ]
        found.append(Loop("part of the full twists", "wheel load Q [kN]", wheels))
    if turned:
        first = turned[0].bogie
        lines = [
            (f"{np.degrees(test.rate):g} deg/s", np.degrees(test.angle), 1e-3 * test.moment)
            for test in turned
            if test.bogie == first
        ]
        found.append(Loop(f"angle of {first.frame} [deg]", "moment [kNm]", lines))
    return _drawn(loops_figure(vehicle.name, found), path)


def sketch_of(vehicle: Vehicle) -> VehicleSketch:
    """The vehicle as a drawing takes it; bodies become the boxes of equal mass and inertia."""
    from wrsim.plots.vehicle import BoxSketch, ElementSketch, VehicleSketch, WheelSketch
    from wrsim.vehicle.couplings import GLYPHS
    from wrsim.vehicle.elements import KINDS

    wheels = [
        WheelSketch((mounted.x, side * 0.5 * mounted.wheelset.profile_spacing, mounted.height), wheel.radius)
        for mounted in vehicle.wheelsets
        for side, wheel in ((1.0, mounted.wheelset.left), (-1.0, mounted.wheelset.right))
    ]
    known = {kind: table.glyph for kind, table in KINDS.items()} | GLYPHS
    glyphs = [(element, known[element.kind]) for element in vehicle.elements]
    elements = [ElementSketch(element.kind, element.points, *glyph) for element, glyph in glyphs if glyph is not None]
    points = [point.at for point in vehicle.points]
    boxes = [BoxSketch(body.name, body.centre, body.box) for body in vehicle.bodies]
    return VehicleSketch(vehicle.name, boxes, wheels, elements, points)
