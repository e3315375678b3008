"""Wheel and rail profiles: equivalent conicity, measures of workshops."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Unpack

from wrsim.api import options
from wrsim.api.options import AnyPath, Argument, Option, Reading, documented, into
from wrsim.api.outcome import Outcome
from wrsim.errors import InputError


@documented
def conicity(
    wheel: Annotated[str, Argument("Wheel profile, such as wheels/S1002.toml, or a folder of them.", "WHEEL")],
    rail: Annotated[str, Argument("Rail profile, such as rails/60E1.toml, or a folder of them.", "RAIL")],
    *,
    cutoff: Annotated[
        float | None, Option("Cut-off wavelength of measured points; default: 5.", "MM", 0.01, 100.0)
    ] = None,
    gauge_mm: Annotated[float, Option("Gauge, 14 mm below the rail tops.", least=400.0, most=2000.0)] = 1435.0,
    gauges_mm: Annotated[
        tuple[float, float, float] | None, Option("Map over a range of gauges.", "FROM TO STEP")
    ] = None,
    flange_back_mm: Annotated[float, Option("Distance of the flange backs.", least=300.0, most=1900.0)] = 1360.0,
    inclination: Annotated[str, Option('Inclination of the rails: 1:40, 1:20 ... or "none".')] = "1:40",
    radius_mm: Annotated[float, Option("Radius of both wheels at the tape circle.", least=100.0, most=1500.0)] = 460.0,
    diameters_mm: Annotated[tuple[float, float] | None, Option("In place of --radius-mm.", "LEFT RIGHT")] = None,
    wheel_right: Annotated[str | None, Option("Profile of the right wheel where it differs.", "WHEEL")] = None,
    rail_right: Annotated[str | None, Option("Profile of the right rail where it differs.", "RAIL")] = None,
    roll: Annotated[str, Option("none (EN 15302), rail-top or centre: see docs/user/conicity.md.")] = "none",
    curve_m: Annotated[Sequence[float], Option("Radial steering index in this curve; may be repeated.", "RADIUS")] = (),
    flange_from_deg: Annotated[float, Option("Contact angle where the flange begins, for --curve-m.")] = 40.0,
    models: options.Models = (),
    output: Annotated[AnyPath, into("Folder for a table, every 0.1 mm, and pictures.", "DIR")] = None,
    pictures: options.Pictures = True,
    **reading: Unpack[Reading],
) -> Outcome:
    """Rolling radius difference, contact angles and equivalent conicity (EN 15302) of a wheelset on its rails.

    Returns
    -------
    Outcome
        ``value`` is a Result, or a map over profiles and gauges.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.report.outputs import write_conicity, write_conicity_map
    from wrsim.results.conicity import conicity_numbers
    from wrsim.results.table import as_records

    pairing = Pairing(flange_back_mm / 1e3, inclination, roll, models, dict(cutoff=cutoff, **reading))
    if gauges_mm is not None or Path(wheel).is_dir() or Path(rail).is_dir():
        if diameters_mm or wheel_right or rail_right or curve_m:
            refused = "--diameters-mm, -right and --curve-m"
            raise InputError(f"a map is of wheelsets with like wheels on like rails, at any radius: no {refused}")
        over = pairing.map(wheel, rail, gauges_mm or (gauge_mm, gauge_mm, 1.0), radius_mm / 1e3)
        numbers = {"title": over.title, "map": as_records(over.table()), "gaps": list(over.reasons)}
        numbers |= {"profiles": list(over.notes)} if over.notes else {}
        files = write_conicity_map(over, Path(output), pictures) if output else []
        return Outcome([over.table()], numbers, files, over)
    left, right = diameters_mm or (2.0 * radius_mm, 2.0 * radius_mm)
    wheels, rails, diameters = (wheel, wheel_right or wheel), (rail, rail_right or rail), (left / 1e3, right / 1e3)
    result = pairing.conicity(wheels, rails, gauge_mm / 1e3, diameters, curve_m, flange_from_deg)
    numbers = {"title": result.title, **conicity_numbers(result.wheelset())}
    numbers |= {"profiles": notes.splitlines()} if (notes := str(result.dataset.attrs.get("profile_notes", ""))) else {}
    return Outcome(result.numbers(), numbers, write_conicity(result, Path(output), pictures) if output else [], result)


@documented
def profiles(
    files: Annotated[
        str | Sequence[str],
        Argument("Profiles, TOML or points, such as wheels/S1002.toml; folders of them.", "FILE...", kind=list[str]),
    ],
    output: Annotated[
        AnyPath, into("Picture; of several profiles with a table (CSV) beside it.", "PNG|SVG|PDF", default="<FILE>.png")
    ] = None,
    *,
    kind: Annotated[str | None, Option("For files of two columns only.", "wheel|rail")] = None,
    cutoff: Annotated[
        Sequence[float], Option("Cut-off wavelength of measured points; up to four to compare.", "MM")
    ] = (),
    reference: Annotated[str | None, Option("Unworn profile for the head wear of rails: W1, W2, W3.", "FILE")] = None,
    align: Annotated[str | None, Option("Unworn profile to align scans to, by parts that do not wear.", "FILE")] = None,
    on: Annotated[str | None, Option("Mating profile for conicity and contact pressure.", "FILE")] = None,
    gauge_mm: Annotated[float | None, Option("Gauge for --on; default: 1435.", least=400.0, most=2000.0)] = None,
    flange_back_mm: Annotated[
        float | None, Option("Distance of the flange backs, for active faces and --on.", least=300.0, most=1900.0)
    ] = None,
    inclination: Annotated[
        str | None, Option('Inclination of rails for --on: 1:20 ... or "none"; default: 1:40.')
    ] = None,
    radius_mm: Annotated[float | None, Option("Wheel radius for --on; default: 460.", least=100.0, most=1500.0)] = None,
    load_kN: Annotated[float | None, Option("Wheel load for --on; default: 60.", least=1.0, most=500.0)] = None,
    models: options.Models = (),
    **reading: Unpack[Reading],
) -> Outcome:
    """Draw and measure profiles: Sh, Sd, qR, hollow of wheels, wear of rail heads; what smoothing does to points.

    Files in folders that cannot be read are named in the notes of the table.

    Returns
    -------
    Outcome
        ``value`` holds the profiles by their names.
    """
    from wrsim.analysis.conicity.pairs import Pairing
    from wrsim.analysis.profiles import Partner, measured_tables, wheelsets_table
    from wrsim.contact.profiles.files import check_alignable, reading_options
    from wrsim.contact.profiles.models import load_profile, readings_of
    from wrsim.inputs.lookup import model_file
    from wrsim.report.outputs import draw_model, write_profiles
    from wrsim.results.smoothing import body_of, check_cutoffs, smoothing_reports, smoothing_table
    from wrsim.results.table import as_records

    paired = {"--gauge-mm": gauge_mm, "--inclination": inclination, "--radius-mm": radius_mm, "--load-kn": load_kN}
    if on is None and (without := [option for option, value in paired.items() if value is not None]):
        raise InputError(f"{', '.join(without)} without --on: only conicity and p0 on that FILE need it")
    names, body = [files] if isinstance(files, str) else list(files), body_of(kind)
    unworn, mating, onto = (
        None if name is None else load_profile(model_file(name, models)) for name in (reference, on, align)
    )
    pairing = Pairing((flange_back_mm or 1360.0) / 1e3, inclination or "1:40", "none", models, reading)
    gauge, radius, load = (gauge_mm or 1435.0) / 1e3, (radius_mm or 460.0) / 1e3, 1e3 * (load_kN or 60.0)
    partner = None if mating is None else Partner(mating, pairing, gauge, radius, load)
    alone = len(names) == 1 and not Path(names[0]).is_dir()
    if cutoff and not alone:
        raise InputError("--cutoff compares cut-offs of one file: give one, or describe each in a TOML file")
    check_cutoffs(cutoff)
    with reading_options(**reading, cutoff=next(iter(cutoff), None), align=onto):
        readings, faults = readings_of(names, body, models)
    if align is not None and onto is not None:
        check_alignable(readings, align, onto)
    reports = smoothing_reports(next(iter(readings.values())), cutoff) if alone else ()
    shapes = {name: reading.profile for name, reading in readings.items()}
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
        written = [draw_model("profile", Path(output), next(iter(shapes.values())), reports)]
    elif output is not None:
        written = write_profiles(shapes, tables, unworn, Path(output))
    return Outcome(shown, numbers, written, shapes)
