"""``wrsim assess``, ``ride``, ``spectra``, ``conicity``, ``vehicle``: runs by rule sets, comfort, profiles, rest."""

from pathlib import Path
from typing import Annotated, Any

import typer

import wrsim
from wrsim.api.outcome import Outcome, folder_beside
from wrsim.cli import options
from wrsim.errors import InputError


@options.drawing
@options.writing(of="results")
def assess_command(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Runs: files, folders, cut off or not. Several count as one test."),
    ],
    output: options.BesideResult = None,
    scenario: options.SectionsOf = None,
    rules: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE",
            help="Rule set: en14363, uic518, 49cfr213, 49cfr238 or a TOML file; en14363 unless given.",
        ),
    ] = None,
    pictures: options.Pictures = True,
) -> Outcome:
    """Assess a run by a rule set: quantities section by section, limits, margins; writes tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).
    """
    if len(results) > 1 and output is None:
        raise InputError("-o DIR is missing: an assessment of several runs belongs to none of their folders")
    return wrsim.assess(results, scenario, folder_beside(results[0], output), pictures, rules)


@options.drawing
@options.writing(of="result")
def ride_command(
    result: options.ResultFile,
    output: options.BesideResult = None,
    scenario: options.SectionsOf = None,
    pictures: options.Pictures = True,
) -> Outcome:
    """Ride: accelerations at the points of a vehicle, their spectra, third-octaves and comfort."""
    return wrsim.ride(result, scenario, folder_beside(result, output), pictures)


@options.drawing
@options.writing(of="result")
def spectra_command(
    result: options.ResultFile,
    channel: Annotated[str, typer.Argument(metavar="CHANNEL", help="Such as Q or axle_box_acceleration.")],
    output: options.BesideResult = None,
    derivative: Annotated[int, typer.Option(min=0, max=2, help="Of the channel: 2 of a displacement.")] = 0,
    from_m: Annotated[float | None, typer.Option(metavar="M", help="Where the stretch that counts begins.")] = None,
    to_m: Annotated[float | None, typer.Option(metavar="M", help="Where it ends.")] = None,
    resolution_Hz: Annotated[
        float, typer.Option("--resolution-hz", metavar="HZ", min=1e-3, help="Between two lines of the density.")
    ] = 2.0,
    piece_m: Annotated[
        float, typer.Option(metavar="M", min=1e-3, help="Track of one spectrum of the spectrogram.")
    ] = 2.0,
    pictures: options.Pictures = True,
) -> Outcome:
    """Spectra of a channel of a run: power spectral density, third-octaves, spectrogram over the distance."""
    return wrsim.spectra(
        result, channel, derivative=derivative, from_m=from_m, to_m=to_m, resolution_Hz=resolution_Hz,
        piece_m=piece_m, output=folder_beside(result, output), pictures=pictures,
    )  # fmt: skip


@options.drawing
@options.writing()
@options.reading_profiles
def conicity_command(
    wheel: Annotated[
        str, typer.Argument(metavar="WHEEL", help="Wheel profile, such as wheels/S1002.toml, or a folder of them.")
    ],
    rail: Annotated[
        str, typer.Argument(metavar="RAIL", help="Rail profile, such as rails/60E1.toml, or a folder of them.")
    ],
    output: Annotated[
        Path | None, options.into(metavar="DIR", help="Write a table, every 0.1 mm, and pictures there.")
    ] = None,
    cutoff: Annotated[
        float | None, typer.Option(metavar="MM", min=0.01, max=100.0, help="Of smoothed points; default: 5.")
    ] = None,
    gauge_mm: options.Gauge = 1435.0,
    gauges_mm: Annotated[
        tuple[float, float, float] | None, typer.Option(metavar="FROM TO STEP", help="A map over the gauge instead.")
    ] = None,
    flange_back_mm: Annotated[float, typer.Option(min=300.0, max=1900.0, help="Between the flange backs.")] = 1360.0,
    inclination: options.Inclination = "1:40",
    radius_mm: options.Radius = 460.0,
    diameters_mm: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LEFT RIGHT", help="In place of --radius-mm.")
    ] = None,
    wheel_right: Annotated[str | None, typer.Option(metavar="WHEEL", help="Where the right wheel differs.")] = None,
    rail_right: Annotated[str | None, typer.Option(metavar="RAIL", help="Where the right rail differs.")] = None,
    roll: Annotated[str, typer.Option(help="none (EN 15302), rail-top or centre: see docs/user/conicity.md.")] = "none",
    curve_m: Annotated[
        list[float] | None, typer.Option(metavar="RADIUS", help="Radial steering index in this curve; may be repeated.")
    ] = None,
    flange_from_deg: Annotated[float, typer.Option(help="For that: contact angle where the flange begins.")] = 40.0,
    models: options.Models = None,
    pictures: options.Pictures = True,
    **reading: Any,
) -> Outcome:
    """Rolling radius difference, contact angles and equivalent conicity (EN 15302) of a wheelset on its rails."""
    return wrsim.conicity(
        wheel, rail, gauge_mm=gauge_mm, gauges_mm=gauges_mm, flange_back_mm=flange_back_mm, inclination=inclination,
        radius_mm=radius_mm, diameters_mm=diameters_mm, wheel_right=wheel_right, rail_right=rail_right, roll=roll,
        curve_m=curve_m or (), flange_from_deg=flange_from_deg, models=models or (), output=output, pictures=pictures,
        cutoff=cutoff, **reading,
    )  # fmt: skip


@options.drawing_to
@options.writing()
def vehicle(
    file: Annotated[str, typer.Argument(metavar="FILE", help="Vehicle file, such as vehicles/manchester_1.toml.")],
    output: Annotated[Path | None, options.into(metavar="PNG|SVG|PDF", help="Draw it there, from three sides.")] = None,
    cant_deficiency: Annotated[
        float | None,
        typer.Option(metavar="MM", min=1.0, max=400.0, help="Static roll and unloading at this cant deficiency."),
    ] = None,
    twist: Annotated[
        float | None, typer.Option(metavar="PERMILLE", min=0.01, max=20.0, help="Wheel loads on track of this twist.")
    ] = None,
    twist_test: Annotated[
        bool, typer.Option("--twist-test", help="Wheel unloading on twisted track, there and back (EN 14363).")
    ] = False,
    twists: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="BODY BOGIE", help="Twists of that test in per mille; default: those of the standard."),
    ] = None,
    rotation_test: Annotated[
        bool, typer.Option("--rotation-test", help="Rotation resistance of its bogies: X factor (EN 14363).")
    ] = False,
    rotation_radius_m: Annotated[
        float, typer.Option(metavar="M", min=10.0, max=10_000.0, help="Radius of the curve of that test.")
    ] = 150.0,
    amplitude_mm: Annotated[
        float, typer.Option(min=1e-3, max=1000.0, help="Travel at which dampers and friction are linearised for modes.")
    ] = 1.0,
    frequency_hz: Annotated[float, typer.Option(min=0.01, max=1000.0, help="Frequency of that travel.")] = 1.0,
    loops: Annotated[
        Path | None, typer.Option("--loops", metavar="PNG|SVG|PDF", help="Draw the loops of these two tests there.")
    ] = None,
    campbell: Annotated[
        Path | None,
        typer.Option(metavar="PNG|SVG|PDF", help="Draw the frequencies of its elastic axles over the speed there."),
    ] = None,
    models: options.Models = None,
) -> Outcome:
    """Print mass, centre, static wheel loads, natural modes and stationary tests of a vehicle; draw it."""
    for option, picture in (("-o", output), ("--loops", loops), ("--campbell", campbell)):
        options.check_ending(option, picture, *options.PICTURES)
    return wrsim.stationary(
        file, cant_deficiency=cant_deficiency, twist=twist, twist_test=twist_test, twists=twists,
        rotation_test=rotation_test, rotation_radius_m=rotation_radius_m, amplitude_mm=amplitude_mm,
        frequency_Hz=frequency_hz, picture=output, loops=loops, campbell=campbell, models=models or (),
    )  # fmt: skip
