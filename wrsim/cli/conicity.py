"""``wrsim conicity``: the equivalent conicity of any pair of profiles."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures
from wrsim.cli.showing import print_json, print_result, print_tables, say
from wrsim.cli.storing import writing

if TYPE_CHECKING:
    from wrsim.geometry.profile.profile import Kind, Profile
    from wrsim.results import Result
    from wrsim.results.conicity_map import ConicityMap

MOST_GAUGES = 200


def conicity(
    wheel: Annotated[
        str, typer.Argument(metavar="WHEEL", help="Wheel profile, such as wheels/S1002.toml, or a folder of them.")
    ],
    rail: Annotated[
        str, typer.Argument(metavar="RAIL", help="Rail profile, such as rails/60E1.toml, or a folder of them.")
    ],
    gauge_mm: Annotated[float, typer.Option(help="14 mm below the rail tops.")] = 1435.0,
    gauges_mm: Annotated[
        tuple[float, float, float] | None,
        typer.Option(metavar="FROM TO STEP", help="A map over the gauge, in place of --gauge-mm."),
    ] = None,
    flange_back_mm: Annotated[float, typer.Option(help="Distance of the flange backs.")] = 1360.0,
    inclination: Annotated[str, typer.Option(help='Of the rails: 1:40, 1:20 ... or "none".')] = "1:40",
    radius_mm: Annotated[float, typer.Option(help="Of both wheels at the tape circle.")] = 460.0,
    diameters_mm: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LEFT RIGHT", help="In place of --radius-mm.")
    ] = None,
    wheel_right: Annotated[str | None, typer.Option(metavar="WHEEL", help="Where the right wheel differs.")] = None,
    rail_right: Annotated[str | None, typer.Option(metavar="RAIL", help="Where the right rail differs.")] = None,
    roll: Annotated[
        str, typer.Option(help='none (EN 15302), rail-top or centre: see "Equivalent conicity" in docs/conicity.md.')
    ] = "none",
    curve_m: Annotated[
        list[float] | None,
        typer.Option(metavar="RADIUS", help="Radial steering index in such a curve; as often as wanted."),
    ] = None,
    flange_from_deg: Annotated[
        float, typer.Option(help="Contact angle from which the outer wheel is on its flange, for that index.")
    ] = 40.0,
    models: Models = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Leave there a table with a line every 0.1 mm, and a picture."
        ),
    ] = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Rolling radius difference, contact angles and equivalent conicity (EN 15302) of a wheelset on its rails."""
    with reporting_errors(as_json), writing(force):
        from wrsim.analysis.conicity.conicity import conicity as analyse
        from wrsim.analysis.conicity.maps import conicity_map
        from wrsim.errors import InputError
        from wrsim.geometry.profile.flange import BACK
        from wrsim.inputs.checking import check_value
        from wrsim.inputs.values import number
        from wrsim.scenario.sections.conicity import AMPLITUDES, ConicityPlan, CurveRadius, FlangeAngle, Roll
        from wrsim.vehicle.wheelset import Wheel, Wheelset

        check_value(Annotated[float, number(400, 2000)], gauge_mm, "--gauge-mm")
        check_value(Annotated[float, number(300, 1900)], flange_back_mm, "--flange-back-mm")
        factor = 1 if diameters_mm is None else 2
        diameters = diameters_mm or (2.0 * radius_mm, 2.0 * radius_mm)
        for diameter in diameters:
            key = "--radius-mm" if diameters_mm is None else "--diameters-mm"
            check_value(Annotated[float, number(100 * factor, 1500 * factor)], 0.5 * factor * diameter, key)
        for radius in curve_m or ():
            check_value(CurveRadius, radius, "--curve-m")
        flange_from = radians(check_value(FlangeAngle, flange_from_deg, "--flange-from-deg"))
        spacing = (flange_back_mm + 2e3 * BACK) / 1e3
        slope = _slope(inclination)
        way = check_value(Roll, roll, "--roll")
        if gauges_mm is not None or Path(wheel).is_dir() or Path(rail).is_dir():
            if diameters_mm or wheel_right or rail_right or curve_m:
                refused = "--diameters-mm, -right and --curve-m"
                raise InputError(f"a map is of wheelsets with like wheels on like rails, at any radius: no {refused}")
            found = conicity_map(
                _profiles(models, wheel, "wheel"),
                {name: p.inclined(slope) for name, p in _profiles(models, rail, "rail").items()},
                [g / 1e3 for g in ([gauge_mm] if gauges_mm is None else _gauges(*gauges_mm))],
                spacing,
                radius_mm / 1e3,
                way,
            )
            words = f", inclined {inclination}" if slope else ""
            _tell_map(found, f"{wheel} on {rail}{words}", output, pictures, as_json)
            return
        left_wheel = _profile(models, wheel, "wheel")
        left_rail = _profile(models, rail, "rail").inclined(slope)
        right_wheel = left_wheel if wheel_right is None else _profile(models, wheel_right, "wheel")
        right_rail = left_rail if rail_right is None else _profile(models, rail_right, "rail").inclined(slope)
        wheelset = Wheelset(
            name="wheelset",
            mass=0.0,
            inertia=(0.0, 0.0, 0.0),
            profile_spacing=spacing,
            left=Wheel(left_wheel, 0.5e-3 * diameters[0]),
            right=Wheel(right_wheel, 0.5e-3 * diameters[1]),
        )
        names = [_both(p.name, q.name) for p, q in ((left_wheel, right_wheel), (left_rail, right_rail))]
        plan = ConicityPlan(tuple(a / 1e3 for a in AMPLITUDES), way, tuple(curve_m or ()), flange_from)
        title = f"{names[0]} on {names[1]}" + (f", inclined {inclination}" if slope else "")
        result = analyse(wheelset, (left_rail, right_rail), gauge_mm / 1e3, plan, title)
        files = [] if output is None else _files(result, output, pictures)
        if as_json:
            print_json({**_numbers(result), "files": [str(f) for f in files]})
        else:
            print_result(result)
            for file in files:
                say(str(file))


def _slope(text: str) -> float:
    from wrsim.inputs.checking import check_value
    from wrsim.scenario.sections.track import Inclination

    try:
        slope: Any = float(text)
    except ValueError:
        slope = text
    return check_value(Inclination, slope, "--inclination")  # type: ignore[no-any-return]


def _profile(models: Sequence[Path] | None, name: str, kind: Kind) -> Profile:
    from wrsim.geometry.profile.models import load_profile
    from wrsim.inputs.lookup import model_file

    return load_profile(model_file(name, models), kind)


def _profiles(models: Sequence[Path] | None, name: str, kind: Kind) -> dict[str, Profile]:
    """One profile by the name of its file, or those of a folder."""
    from wrsim.analysis.conicity.maps import profiles_of

    if Path(name).is_dir():
        return profiles_of(Path(name), kind)
    return {Path(name).stem: _profile(models, name, kind)}


def _gauges(low: float, high: float, step: float) -> list[float]:
    """Gauges [mm] from one to the other."""
    from wrsim.errors import InputError
    from wrsim.inputs.checking import check_value
    from wrsim.inputs.values import number

    for gauge in (low, high):
        check_value(Annotated[float, number(400, 2000)], gauge, "--gauges-mm")
    count = (high - low) / step if step > 0.0 and high >= low else -1.0
    if not 0.0 <= count <= MOST_GAUGES:
        words = f"must be FROM, a TO not below it, and a STEP above 0 that makes at most {MOST_GAUGES} of them"
        raise InputError(f"--gauges-mm {low:g} {high:g} {step:g}: {words}")
    return [low + i * step for i in range(int(count + 1e-9) + 1)]


def _tell_map(found: ConicityMap, title: str, output: Path | None, pictures: bool, as_json: bool) -> None:
    """``conicity_map.csv`` and ``conicity_map.png``, and the same on the screen."""
    from wrsim.results.files import csv_parts, write_atomically
    from wrsim.results.render import as_records, as_rows

    table = found.table(title)
    files = []
    if output is not None:
        files.append(write_atomically(output / "conicity_map.csv", csv_parts(as_rows(table))))
        if pictures:
            from wrsim.plots import save
            from wrsim.plots.conicity_map import conicity_map_figure

            files.append(save(conicity_map_figure(found, title), output / "conicity_map.png"))
    if as_json:
        cells = as_records(table)
        print_json({"title": title, "map": cells, "gaps": list(found.reasons), "files": [str(f) for f in files]})
        return
    print_tables([table])
    for file in files:
        say(str(file))


def _both(left: str, right: str) -> str:
    return left if left == right else f"{left} / {right}"


def _files(result: Result, directory: Path, pictures: bool) -> list[Path]:
    """``conicity.csv`` and ``conicity.png``."""
    from wrsim.results.tables import write_table

    files = [write_table(result.dataset, "conicity", directory / "conicity.csv")]
    if pictures:
        from wrsim.plots import standard_pictures

        files += standard_pictures(result.dataset, directory)
    return files


def _numbers(result: Result) -> dict[str, Any]:
    """What --json tells."""
    from wrsim.results.conicity import conicity_summary

    dataset = result.wheelset()
    summary = conicity_summary(dataset)
    return {
        "title": result.title,
        **summary,
        "amplitude_mm": [round(1e3 * a, 9) for a in dataset["amplitude"].values.tolist()],
        "tan_gamma_e": [None if v != v else v for v in dataset["equivalent_conicity"].values.tolist()],
    }
