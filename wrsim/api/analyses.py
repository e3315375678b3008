"""Assessment, ride, conicity, profiles, a vehicle at rest, differences of results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wrsim.api.outcome import Given, Outcome, as_list, as_result, as_scenario, paths_among
from wrsim.errors import DIFFERENT, InputError, SimulationError

if TYPE_CHECKING:
    from wrsim.scenario.loading import Scenario
    from wrsim.vehicle.vehicle import Vehicle


def assess(
    results: Given | Sequence[Given],
    scenario: Scenario | str | Path | None = None,
    output: str | Path | None = None,
    pictures: bool = True,
    rules: str | Path | None = None,
) -> Outcome:
    """Assess a run, or several runs of one vehicle as one test, by a rule set.

    Parameters
    ----------
    results : Result, path, or a sequence of these
        Runs along the track.
    scenario : Scenario, str or Path, optional
        With the settings, [assessment]; those of the results unless given.
    output : str or Path, optional
        Folder for tables and pictures.
    pictures : bool
        Whether pictures are drawn there.
    rules : str or Path, optional
        Name or TOML file of a rule set; that of the settings unless given.

    Returns
    -------
    Outcome
        ``found`` is the assessment.

    Raises
    ------
    InputError
        For results that are no runs, or not of one vehicle.
    """
    from wrsim.assessment.assess import assess_runs
    from wrsim.assessment.outcome import assessment_dict, assessment_numbers
    from wrsim.assessment.settings import AssessmentSection
    from wrsim.report.output_folder import names_apart, naming
    from wrsim.report.outputs import write_assessment

    several = as_list(results)
    paths = paths_among(*several)
    names = names_apart(paths) if len(paths) == len(several) else [str(i + 1) for i in range(len(several))]
    settings = None if scenario is None else as_scenario(scenario, ()).table(AssessmentSection).settings()
    loaded = [as_result(each) for each in several]
    with naming(*paths):
        found = assess_runs(loaded, settings, names, rules)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_assessment(found, folder, pictures)
    return Outcome(assessment_numbers(found), assessment_dict(found), files, found, folder=folder)


def ride(
    result: Given,
    scenario: Scenario | str | Path | None = None,
    output: str | Path | None = None,
    pictures: bool = True,
) -> Outcome:
    """Accelerations at the points of a vehicle: spectra, third-octaves, comfort.

    Parameters
    ----------
    result : Result, str or Path
        A run whose vehicle has points.
    scenario : Scenario, str or Path, optional
        With the settings, [ride]; those of the result unless given.
    output : str or Path, optional
        Folder for tables and pictures.
    pictures : bool
        Whether pictures are drawn there.

    Returns
    -------
    Outcome
        ``found`` has spectra and bands.

    Raises
    ------
    InputError
        For a result without points, or one too short.
    """
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_ride
    from wrsim.scenario.sections.run import RideSection

    loaded, section = as_result(result), None if scenario is None else as_scenario(scenario, ()).table(RideSection)
    with naming(*paths_among(result)):
        found = evaluate_ride(loaded, section)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_ride(found, folder, pictures)
    return Outcome([found.table()], found.as_dict(), files, found, folder=folder)


def spectra(
    result: Given, channel: str, *, derivative: int = 0, from_m: float | None = None, to_m: float | None = None,
    resolution_Hz: float = 2.0, piece_m: float = 2.0, output: str | Path | None = None, pictures: bool = True,
) -> Outcome:  # fmt: skip
    """Power spectral density, third-octaves and spectrogram of a channel of a run, of the fast one where it is stored.

    Parameters
    ----------
    result : Result, str or Path
        A run.
    channel : str
        Such as ``"Q"``, ``"axle_box_acceleration"``, ``"rail_displacement_z"``.
    derivative : int
        1 or 2: spectra of its first or second derivative, such as the acceleration of a displacement.
    from_m, to_m : float, optional
        The stretch that counts, by the distance of the vehicle's origin; the whole run unless given.
    resolution_Hz : float
        Distance between two lines of the density; more in runs that are too short for three segments.
    piece_m : float
        Length of track of one spectrum of the spectrogram.
    output : str or Path, optional
        Folder for tables and a picture.
    pictures : bool
        Whether the picture is drawn there.

    Returns
    -------
    Outcome
        ``found`` is an xarray.Dataset in SI units: ``density`` (frequency, ...), one-sided; ``band_rms`` (band, ...)
        with ``band_low`` and ``band_high``; ``spectrogram`` (place, line, ...), densities over the distance; ``rms``.

    Raises
    ------
    InputError
        For a channel that the result does not have over time, or one too short.
    """
    from wrsim.analysis.spectra import evaluate_spectra
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_spectra
    from wrsim.results.spectra import spectra_table
    from wrsim.results.table import as_records

    with naming(*paths_among(result)):
        found = evaluate_spectra(as_result(result), channel, derivative, (from_m, to_m), resolution_Hz, piece_m)
    folder, table = None if output is None else Path(output), spectra_table(found)
    files = [] if folder is None else write_spectra(found, folder, pictures)
    numbers = {"title": found.attrs["title"], "channel": channel, "spectra": as_records(table)}
    return Outcome([table], numbers, files, found, folder=folder)


def conicity(
    wheel: str, rail: str, *, gauge_mm: float = 1435.0, gauges_mm: tuple[float, float, float] | None = None,
    flange_back_mm: float = 1360.0, inclination: str = "1:40", radius_mm: float = 460.0,
    diameters_mm: tuple[float, float] | None = None, wheel_right: str | None = None, rail_right: str | None = None,
    roll: str = "none", curve_m: Sequence[float] = (), flange_from_deg: float = 40.0,
    models: Sequence[str | Path] = (), output: str | Path | None = None, pictures: bool = True, **reading: Any,
) -> Outcome:  # fmt: skip
    """Rolling radius difference and equivalent conicity (EN 15302) of a wheelset on its rails.

    Parameters
    ----------
    wheel, rail : str
        Profile files, or folders of them, which give a map. All others as of ``wrsim conicity``.
    unit, heights, field_side, origin, back_to_tape_circle_mm, measured, cutoff
        How files of points are read, unless they say it themselves; cutoff of smoothing [mm].

    Returns
    -------
    Outcome
        ``found`` is a Result, or a map over profiles and gauges.

    Raises
    ------
    InputError
        For profiles that cannot be used, and for options that do not go together.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.report.outputs import write_conicity, write_conicity_map
    from wrsim.results.conicity import conicity_numbers
    from wrsim.results.table import as_records

    pairing = Pairing(flange_back_mm / 1e3, inclination, roll, list(map(Path, models)), reading)
    if gauges_mm is not None or Path(wheel).is_dir() or Path(rail).is_dir():
        if diameters_mm or wheel_right or rail_right or curve_m:
            refused = "--diameters-mm, -right and --curve-m"
            raise InputError(f"a map is of wheelsets with like wheels on like rails, at any radius: no {refused}")
        over = pairing.map(wheel, rail, gauges_mm or (gauge_mm, gauge_mm, 1.0), radius_mm / 1e3)
        numbers = {"title": over.title, "map": as_records(over.table()), "gaps": list(over.reasons)}
        numbers |= {"profiles": list(over.notes)} if over.notes else {}
        return Outcome(
            [over.table()], numbers, write_conicity_map(over, Path(output), pictures) if output else [], over
        )
    left, right = diameters_mm or (2.0 * radius_mm, 2.0 * radius_mm)
    wheels, rails, diameters = (wheel, wheel_right or wheel), (rail, rail_right or rail), (left / 1e3, right / 1e3)
    found = pairing.conicity(wheels, rails, gauge_mm / 1e3, diameters, curve_m, flange_from_deg)
    numbers = {"title": found.title, **conicity_numbers(found.wheelset())}
    numbers |= {"profiles": notes.splitlines()} if (notes := str(found.dataset.attrs.get("profile_notes", ""))) else {}
    return Outcome(found.numbers(), numbers, write_conicity(found, Path(output), pictures) if output else [], found)


def profiles(
    files: str | Sequence[str], output: str | Path | None = None, *, kind: str | None = None,
    cutoff: Sequence[float] = (), reference: str | None = None, on: str | None = None,
    gauge_mm: float | None = None, flange_back_mm: float | None = None, inclination: str | None = None,
    radius_mm: float | None = None, load_kN: float | None = None, align: str | None = None,
    models: Sequence[str | Path] = (), **reading: Any,
) -> Outcome:  # fmt: skip
    """Profiles as workshops measure them: Sh, Sd, qR and hollow of wheels, W1, W2, W3 of rails, one row each.

    Parameters
    ----------
    files : str or sequence of str
        Profile files, and folders of them: their files that cannot be read are named in the notes of the table.
    output : str or Path, optional
        Picture; of several profiles with a table (CSV) beside it.
    reference : str, optional
        The unworn profile: head wear of rails is measured against it.
    on : str, optional
        A rail (of wheels) or a wheel (of rails) for conicity and pressure.
    align : str, optional
        An unworn profile onto which scans are moved and turned by the parts that do not wear.
    unit, heights, field_side, origin, back_to_tape_circle_mm, measured
        How files of points are read, unless they say it themselves.
    gauge_mm, inclination, radius_mm, load_kN : float or str, optional
        Of that; 1435 mm, "1:40", 460 mm, 60 kN a wheel unless given. All others as of ``wrsim profile``.

    Returns
    -------
    Outcome
        ``found`` holds the profiles by their names.

    Raises
    ------
    InputError
        For profiles that cannot be used, and for options that do not go together.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.analysis.profiles import Partner, measured_tables, wheelsets_table
    from wrsim.contact.profiles.files import check_alignable, reading_options
    from wrsim.contact.profiles.models import load_profile, readings_of
    from wrsim.inputs.lookup import model_file
    from wrsim.report.outputs import draw_model, write_profiles
    from wrsim.results.smoothing import body_of, check_cutoffs, smoothing_reports, smoothing_table
    from wrsim.results.table import as_records

    of_pairs = {"--gauge-mm": gauge_mm, "--inclination": inclination, "--radius-mm": radius_mm, "--load-kn": load_kN}
    if on is None and (without := [option for option, value in of_pairs.items() if value is not None]):
        raise InputError(f"{', '.join(without)} without --on: only conicity and p0 on that FILE need it")
    names, body = [files] if isinstance(files, str) else list(files), body_of(kind)
    unworn, other, onto = (
        None if name is None else load_profile(model_file(name, models)) for name in (reference, on, align)
    )
    pairing = Pairing((flange_back_mm or 1360.0) / 1e3, inclination or "1:40", "none", list(map(Path, models)), reading)
    gauge, radius, load = (gauge_mm or 1435.0) / 1e3, (radius_mm or 460.0) / 1e3, 1e3 * (load_kN or 60.0)
    partner = None if other is None else Partner(other, pairing, gauge, radius, load)
    alone = len(names) == 1 and not Path(names[0]).is_dir()
    if cutoff and not alone:
        raise InputError("--cutoff compares cut-offs of one file: give one, or describe each in a TOML file")
    check_cutoffs(cutoff)
    with reading_options(**reading, cutoff=next(iter(cutoff), None), align=onto):
        readings, faults = readings_of(names, body, models)
    if align is not None and onto is not None:
        check_alignable(readings, align, onto)
    reports = smoothing_reports(next(iter(readings.values())), cutoff) if alone else ()
    found = {name: reading.profile for name, reading in readings.items()}
    tables = measured_tables(readings, faults, unworn, partner)
    numbers: dict[str, Any] = {f"{each}s": as_records(table) for each, table in tables.items()}
    numbers |= {"notes": [note for table in tables.values() for note in table.notes]}
    shown = [table for table in tables.values() if table.columns[1:] or not alone]
    wheels = {name: reading.close for name, reading in readings.items() if reading.profile.kind == "wheel"}
    if flange_back_mm is not None and (len(wheels) > 1 or partner is None):
        shown.append(wheelsets_table(wheels, flange_back_mm / 1e3))
        numbers["wheelsets"] = as_records(shown[-1])
    if alone and reports:
        shown.append(smoothing_table(reports))
        numbers["smoothing"] = [report.numbers() for report in reports]
    written: Sequence[Path] = ()
    if output is not None and alone:
        written = [draw_model("profile", Path(output), next(iter(found.values())), reports)]
    elif output is not None:
        written = write_profiles(found, tables, unworn, Path(output))
    return Outcome(shown, numbers, written, found)


def stationary(
    vehicle: Vehicle | str, *, cant_deficiency: float | None = None, twist: float | None = None,
    twist_test: bool = False, twists: tuple[float, float] | None = None, rotation_test: bool = False,
    rotation_radius_m: float = 150.0, amplitude_mm: float = 1.0, frequency_Hz: float = 1.0,
    picture: Path | None = None, loops: Path | None = None,
    campbell: Path | None = None, models: Sequence[str | Path] = (),
) -> Outcome:  # fmt: skip
    """Mass, centre, static wheel loads, natural modes and stationary tests of a vehicle.

    Parameters
    ----------
    vehicle : Vehicle or str
        A vehicle or its file.
    cant_deficiency : float, optional
        Roll and unloading at this cant deficiency [mm].
    twist : float, optional
        Wheel loads on track of this twist [per mille].
    twist_test, rotation_test : bool
        Tests of EN 14363; twists: of the first under body and bogie [per mille], rotation_radius_m: of the second.
    amplitude_mm, frequency_Hz : float
        Travel at which dampers and friction are linearised for the modes.
    picture, loops : Path, optional
        Where the vehicle, and the loops of these tests, are drawn.
    campbell : Path, optional
        Where the natural frequencies of its elastic axles over the speed are drawn.

    Returns
    -------
    Outcome
        With ``["warnings"]`` of implausible values.

    Raises
    ------
    InputError, SimulationError
        For a vehicle file that cannot be used, and for options that do not go together; for a vehicle that does not
        come to rest, with what of it is implausible.
    """
    from wrsim.analysis.stationary import at_rest
    from wrsim.scenario.plausibility import vehicle_warnings
    from wrsim.scenario.vehicle_build import vehicle_model
    from wrsim.vehicle.equivalent import Stroke

    if twists is not None and not twist_test:
        raise InputError("--twists belongs to --twist-test")
    if loops is not None and not (twist_test or rotation_test):
        raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
    loaded = vehicle_model(vehicle, list(models)) if isinstance(vehicle, str) else vehicle
    if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
        raise InputError(f"{vehicle}: is a train; tests at rest are for one vehicle: give the file of one of them")
    doubts, stroke = vehicle_warnings(loaded), Stroke(amplitude_mm / 1e3, frequency_Hz)
    try:
        found = at_rest.numbers_at_rest(loaded, cant_deficiency, twist, stroke) | {"warnings": doubts}
    except SimulationError as error:  # what is implausible is most likely why
        raise SimulationError("\n".join((str(error), *doubts))) from None
    tested, twisted, turned = at_rest.stationary_tests(loaded, twist_test, twists, rotation_test, rotation_radius_m)
    found |= tested
    if campbell is not None and not found["axles"]:
        raise InputError("--campbell draws elastic axles: this vehicle has none; [wheelset.axle] gives them")
    if picture is not None or loops is not None or campbell is not None:
        from wrsim.report.outputs import draw_loops, draw_model

        found |= {"picture": str(draw_model("vehicle", picture, loaded))} if picture else {}
        found |= {"loops": str(draw_loops(loaded, twisted, turned, loops))} if loops else {}
        found |= {"campbell": str(draw_model("campbell", campbell, loaded.name, found["axles"]))} if campbell else {}
    files = [Path(found[key]) for key in ("picture", "loops", "campbell") if key in found]
    return Outcome(at_rest.tables_at_rest(found), found, files, (twisted, turned))


def diff(
    first: Given, second: Given, tolerance: float = 0.01, only: Sequence[str] = (), output: str | Path | None = None
) -> Outcome:
    """Compare two results: peaks, medians in full curves, other numbers.

    Parameters
    ----------
    first, second : Result, str or Path
        Results of one kind of analysis.
    tolerance : float
        Largest difference allowed, as a part of the quantity's largest value.
    only : sequence of str
        Quantities that count; all unless given.
    output : str or Path, optional
        Folder for a table and an overlay picture.

    Returns
    -------
    Outcome
        ``code`` 4 where they differ; ``found`` lists the deviations.

    Raises
    ------
    InputError
        For results of two kinds, and a quantity that neither has.
    """
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_differences
    from wrsim.results.differences import (
        beyond,
        compared_tables,
        difference_table,
        differences,
        inputs_apart,
        other_ends,
    )
    from wrsim.results.table import as_records

    names = tuple(str(g) if isinstance(g, str | Path) else g.title for g in (first, second))
    results, paths = (as_result(first), as_result(second)), paths_among(first, second)
    with naming(*paths):
        found = differences(*results, only, tolerance)
    ends = other_ends(*results)
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_differences(found, results, names, folder)
    alike = not beyond(found, tolerance) and not ends
    records = as_records(difference_table(found))
    apart = inputs_apart(*results)
    numbers = {"alike": alike, "tolerance": tolerance, "ends": ends, "inputs": apart, "differences": records}
    tables = compared_tables(found, ends, tolerance, names, apart)
    return Outcome(tables, numbers, files, found, 0 if alike else DIFFERENT, folder)
