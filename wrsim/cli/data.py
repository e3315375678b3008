"""``wrsim profile``, ``track``, ``recording``, ``export``, ``fmu``: data from and for other programs."""

from pathlib import Path
from typing import Annotated, Any

import typer

import wrsim
from wrsim.api.outcome import Outcome
from wrsim.cli import options
from wrsim.cli.console import print_error, print_lines, print_outcome
from wrsim.cli.errors import writing_files


@options.drawing_to
@options.writing(reads="files")
@options.reading_profiles
def profile(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Profiles, TOML or points, such as wheels/S1002.toml; folders of them."),
    ],
    output: Annotated[Path | None, options.into(metavar="PNG|SVG|PDF", help="Default: <FILE>.png here.")] = None,
    kind: Annotated[str | None, typer.Option(metavar="wheel|rail", help="For files of two columns only.")] = None,
    cutoff: Annotated[
        list[float] | None,
        typer.Option(metavar="MM", help="Smooth measured points, halving waves of this length; up to four to compare."),
    ] = None,
    reference: Annotated[
        str | None, typer.Option(metavar="FILE", help="Unworn profile: W1, W2, W3 of rails are measured against it.")
    ] = None,
    align: Annotated[
        str | None, typer.Option(metavar="FILE", help="Lay scans on this unworn profile by the parts that do not wear.")
    ] = None,
    on: Annotated[
        str | None, typer.Option(metavar="FILE", help="Rail of wheels, wheel of rails: conicity and p0 on it.")
    ] = None,
    gauge_mm: Annotated[float | None, typer.Option(min=400.0, max=2000.0, help="--on: track; default: 1435.")] = None,
    flange_back_mm: Annotated[
        float | None, typer.Option(min=300.0, max=1900.0, help="Measured, for active faces; --on: 1360 if none.")
    ] = None,
    inclination: Annotated[str | None, typer.Option(help='--on: of rails, 1:20 ... or "none"; default: 1:40.')] = None,
    radius_mm: Annotated[float | None, typer.Option(min=100.0, max=1500.0, help="--on: wheels; default: 460.")] = None,
    load_kn: Annotated[float | None, typer.Option(min=1.0, max=500.0, help="--on: for p0; default: 60.")] = None,
    models: options.Models = None,
    **reading: Any,
) -> Outcome:
    """Draw and measure profiles: Sh, Sd, qR, hollow of wheels, wear of rail heads; what smoothing does to points."""
    picture = output or Path(Path(files[0]).resolve().stem + ".png")
    options.check_ending("-o", picture, *options.PICTURES)
    return wrsim.profiles(
        files, picture, kind=kind, cutoff=cutoff or (), reference=reference, on=on, gauge_mm=gauge_mm,
        flange_back_mm=flange_back_mm, inclination=inclination, radius_mm=radius_mm, load_kN=load_kn, align=align,
        models=models or (), **reading,
    )  # fmt: skip


@options.drawing_to
@options.writing(reads="file")
def track(
    file: options.ScenarioFile,
    output: Annotated[Path | None, options.into(metavar="PNG|SVG|PDF", help="Default: <FILE>_track.png here.")] = None,
    models: options.Models = None,
) -> Outcome:
    """Draw the track of a scenario or of a track file: plan, curvature, cant, gauge, height, irregularities."""
    picture = output or Path(f"{file.stem}_track.png")
    options.check_ending("-o", picture, *options.PICTURES)
    return wrsim.draw_track(file, picture, models or ())


@options.drawing
def recording(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of a recording (CSV).")],
    output: Annotated[Path | None, options.into(metavar="DIR", help="Default: <name of FILE> here.")] = None,
    columns: Annotated[
        Path | None,
        typer.Option(metavar="TOML", help="Column map; default: the TOML of FILE's name beside it, or columns' names."),
    ] = None,
    chord_m: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="BEHIND AHEAD", help="Chord of alignment and level, where no map gives it."),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="D1|D2|D3", help="Inertial band of alignment and level, if no map gives it.")
    ] = None,
    wavelength_m: Annotated[
        tuple[float, float], typer.Option(metavar="SHORT LONG", help="Waves of alignment and level that are wanted.")
    ] = (3.0, 70.0),
    amplification: Annotated[float, typer.Option(help="Largest factor with which a wave of a chord is undone.")] = 8.0,
    transitions: Annotated[
        str, typer.Option(metavar="clothoid|bloss|either", help="Their form; either: the one that comes nearer.")
    ] = "either",
    from_m: Annotated[float | None, typer.Option(help="Take the recording from this distance on.")] = None,
    to_m: Annotated[float | None, typer.Option(help="Take it up to this distance.")] = None,
    vehicle: Annotated[str, typer.Option(metavar="MODEL", help="Of the scenario.")] = "vehicles/manchester_1.toml",
    speed_kmh: Annotated[
        float | None, typer.Option(help="Speed of the scenario; default: 100 mm of cant deficiency, 160 at most.")
    ] = None,
    models: options.Models = None,
    pictures: options.Pictures = True,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Make a track, its irregularities and a scenario of a track recording car's table (docs/user/recording.md)."""
    beside = file.with_suffix(".toml")
    chosen = columns if columns is not None else beside if beside.is_file() else None
    with writing_files(as_json, force, *([file] if chosen is None else [file, chosen])):
        directory = output or Path(file.stem)
        found = wrsim.read_recording(
            file, directory, columns=chosen, chord_m=chord_m, band=band, wavelength_m=wavelength_m,
            amplification=amplification, transitions=transitions, from_m=from_m, to_m=to_m, vehicle=vehicle,
            speed_kmh=speed_kmh, models=models or (), pictures=pictures,
        )  # fmt: skip
        for words in [] if as_json else found["warnings"]:
            print_error(f"{file}: warning: {words}")
        print_outcome(as_json, found)
        if not as_json:
            print_lines(f"run it with: wrsim run {directory / 'scenario.toml'}")


@options.writing(of="result")
def export_command(
    result: options.ResultFile,
    to: Annotated[
        str,
        typer.Option("--to", metavar="FORMAT,...", help="mat, csv, parquet, mdf, tables; one or more with commas."),
    ],
    output: options.BesideResult = None,
) -> Outcome:
    """Write a result for other programs: MATLAB, CSV, Parquet, MDF (result.mat, .csv, .parquet, .mf4), all tables."""
    return wrsim.export(result, to, output)


@options.writing(reads="file")
def fmu(
    file: options.ScenarioFile,
    output: Annotated[Path | None, options.into(metavar="FMU", help="Default: <name of FILE>.fmu here.")] = None,
    values: options.Set = None,
    step_ms: Annotated[float, typer.Option(min=1e-3, max=5.0, help="Step of the integration.")] = 1.0,
    models: options.Models = None,
) -> Outcome:
    """Write the vehicle of a run as a co-simulation unit (FMI 3.0, Linux, a C compiler is needed)."""
    options.check_ending("-o", output, ".fmu")
    return wrsim.write_unit(file, output, values or (), step=1e-3 * step_ms, models=models or ())
