"""A vehicle at rest in numbers: mass, wheel loads, modes, sway, unloading on twisted track, rotation of bogies."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.conicity.conicity import wheelset_conicity
from wrsim.analysis.stationary import loops
from wrsim.analysis.stationary.loops import RotationTest, TwistTest
from wrsim.analysis.stationary.statics import StaticState, canted, static_state
from wrsim.assessment.limits import Limit, LimitContext
from wrsim.assessment.rules import rule_set
from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError, SimulationError
from wrsim.inputs.section import given
from wrsim.results.table import Column, Table, formatted, quantity
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.simulation.modes import natural_modes
from wrsim.track.cant import CANT_BASE, cant_angle
from wrsim.vehicle.axle import whirl
from wrsim.vehicle.equivalent import SMALL_STROKE, Stroke
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Vehicle

Numbers = Mapping[str, Any]

LOOPS, CANTED = "en14363-stationary", "49cfr213"
"""Rule sets by which stationary tests, and the rest on canted track, are judged."""
CONICITY_AMPLITUDE = 3e-3
"""At which the equivalent conicity is judged [m], [mem] EN 14363, for 7 mm of clearance or more."""
TINY = 1.0  # load of a lifted wheel in a ratio of loads [N]


def numbers_at_rest(
    vehicle: Vehicle, cant_deficiency: float | None = None, twist: float | None = None, stroke: Stroke = SMALL_STROKE
) -> dict[str, Any]:
    """Numbers of a vehicle at rest; cant_deficiency [mm], twist [per mille]: of tests, none unless given; stroke: of
    its modes."""
    trimmed = replace(vehicle, loads=())
    level = static_state(trimmed)
    numbers = {
        "name": vehicle.name,
        "source": vehicle.source,
        "mass_kg": vehicle.mass,
        "centre_mm": [1e3 * float(c) for c in vehicle.centre],
        "bodies": [b.name for b in vehicle.bodies],
        "elements": len(vehicle.elements),
        **_wheel_loads(vehicle, level.wheel_loads),
        "weighing": weighing(level),
        "modes": [
            {"frequency_Hz": mode.frequency, "damping": mode.damping, "motion": mode.name}
            for mode in natural_modes(trimmed, stroke)
        ],
        **({"linearised": stroke.label} if any(e.is_linearised for e in vehicle.elements) else {}),
        "axles": campbell(vehicle),
    }
    tests: dict[str, tuple[dict[str, float], Callable[[], dict[str, Any]]]] = {}
    if vehicle.loads:
        tests["under_loads"] = {}, lambda: _under_loads(vehicle)
    if cant_deficiency is not None:
        tests["leaning"] = {"cant_deficiency_mm": cant_deficiency}, lambda: leaning(trimmed, level, cant_deficiency)
    if twist is not None:
        turned = twist / 1e3 / CANT_BASE
        tests["twisted"] = {"twist_permille": twist}, lambda: _unloading(trimmed, level, static_state(trimmed, turned))
    for name, (known, test) in tests.items():
        try:
            numbers[name] = known | test()
        except SimulationError as error:  # it does not come to rest
            numbers[name] = known | {"problem": str(error)}
    return numbers


def judged(
    rules: str, quantity: str, value: float, about: LimitContext | None = None, limit_instead: Limit | None = None
) -> dict[str, Any]:
    """A value [SI units] of a vehicle at rest beside its limit in a rule set, both in the unit for readers.

    about: what the limit depends on, where it is no constant; limit_instead: a limit in its place.
    """
    clause = given(rule_set(rules).about(quantity))
    limit, shown = limit_instead or given(clause.limit_at(about or LimitContext())), clause.judged.shown
    return {
        "clause": clause.id,
        "symbol": clause.judged.symbol,
        "unit": shown.unit,
        "value": value * shown.factor,
        "limit": limit.value * shown.factor,
        "margin": clause.judged.margin(value, limit.value),
        "passed": bool(clause.judged.within(value, limit.value)),
        "lowest": clause.judged.lowest,
        "limit_source": limit.reference,
    }


def weighing(level: StaticState) -> dict[str, Any]:
    """The verdict on the wheel loads of every wheelset at rest on level track."""
    loads = level.wheel_loads
    return judged(LOOPS, "wheel_load_ratio", float((loads.max(axis=1) / np.maximum(loads.min(axis=1), TINY)).max()))


def settling(vehicle: Vehicle, payload: float) -> dict[str, Any]:
    """The verdict on how far the car body sinks under a payload [kg] at its centre."""
    body = vehicle.parts[vehicle.reference]
    load = Load.constant("payload", body.name, (0.0, 0.0, -payload * vehicle.gravity), body.centre)
    names = [each.name for each in vehicle.bodies]
    rest = static_state(replace(vehicle, loads=(load,)))
    return judged(LOOPS, "settling", -float(rest.moved[names.index(body.name), 1]))


def conicity(vehicle: Vehicle, rails: tuple[Profile, Profile], gauge: float, speed: float) -> dict[str, Any]:
    """The verdict on the largest equivalent conicity of the wheelsets at `CONICITY_AMPLITUDE`, with the gauge [m].

    speed: the highest one of the vehicle [m/s]. Raises InputError where a wheelset has no place to swing about.
    """
    plan = ConicityPlan((CONICITY_AMPLITUDE,))
    kinds = dict.fromkeys(mounted.wheelset for mounted in vehicle.wheelsets)
    datasets = [wheelset_conicity(item, rails, gauge, plan, vehicle.name).dataset for item in kinds]
    largest = max(float(item["equivalent_conicity"].max()) for item in datasets)
    return judged(LOOPS, "conicity", largest, LimitContext(speed=speed))


def _under_loads(vehicle: Vehicle) -> dict[str, Any]:
    rest = static_state(vehicle)
    stops = [
        {"name": e.name, "travel_mm": 1e3 * reading[e.travel_place], "force_kN": 1e-3 * reading[e.travel_place - 3]}
        for e, reading in zip(vehicle.elements, rest.readings.tolist(), strict=True)
        if e.limits and abs(reading[e.travel_place - 3]) > 0.0
    ]
    bodies = {
        body.name: {"lateral_mm": 1e3 * y, "vertical_mm": 1e3 * z, "roll_mrad": 1e3 * roll}
        for body, (y, z, roll) in zip(vehicle.bodies, rest.moved.tolist(), strict=True)
    }
    forces = {load.name: [1e-3 * f for f in load.largest] for load in vehicle.loads}
    return {"loads_kN": forces, **_wheel_loads(vehicle, rest.wheel_loads), "bodies": bodies, "bump_stops": stops}


def leaning(vehicle: Vehicle, level: StaticState, cant_deficiency: float, most: Limit | None = None) -> dict[str, Any]:
    """Wheel loads and roll of a vehicle on rails canted by so much [mm]; level: its state on level ones.

    The verdicts are those of 49 CFR 213.57, and that on the flexibility coefficient of the car body; most: its limit.
    """
    angle = float(cant_angle(cant_deficiency / 1e3, CANT_BASE))
    rest = static_state(canted(vehicle, angle))
    rolls = {b.name: -float(roll) for b, roll in zip(vehicle.bodies, rest.moved[:, 2], strict=True)}
    sway = {
        "flexibility_coefficient": {name: roll / angle for name, roll in rolls.items()},
        "roll_deg": {name: degrees(roll) for name, roll in rolls.items()},
    }
    body = vehicle.parts[vehicle.reference].name
    floor = angle + rolls[body]  # against the horizontal
    share = float((rest.wheel_loads / level.wheel_loads).min())
    verdicts = [judged(CANTED, "lean_Q_share", share), judged(CANTED, "lean_roll", abs(floor))]
    verdicts.append(judged(LOOPS, "flexibility", rolls[body] / angle, limit_instead=most))
    return _unloading(vehicle, level, rest) | sway | {"verdicts": verdicts}


def _unloading(vehicle: Vehicle, level: StaticState, rest: StaticState) -> dict[str, Any]:
    """Wheel loads, and the part of its load on level rails that every wheel has lost."""
    lost = 1.0 - rest.wheel_loads / level.wheel_loads
    loads = _wheel_loads(vehicle, rest.wheel_loads)
    return loads | {"unloading": _by_wheel(vehicle, lost), "largest_unloading": float(lost.max())}


def _wheel_loads(vehicle: Vehicle, loads: NDArray[np.float64]) -> dict[str, Any]:
    return {"wheel_loads_kN": _by_wheel(vehicle, loads / 1e3), "weight_kN": float(loads.sum()) / 1e3}


CAMPBELL = tuple(range(0, 401, 25))
"""Speeds of Campbell's diagram [km/h]."""


def campbell(vehicle: Vehicle) -> list[dict[str, Any]]:
    """Natural frequencies of the free elastic axles over the speed, of every kind of axle once; of none where all are
    rigid. ``backward_Hz`` and ``forward_Hz`` (speeds, modes) are those that whirl against the rolling and with it."""
    axles: list[dict[str, Any]] = []
    kinds: list[tuple[Any, ...]] = []
    for mounted in vehicle.wheelsets:
        kind = (mounted.wheelset.axle, mounted.mass, mounted.inertia)
        if mounted.modes is None or kind in kinds:
            continue
        kinds.append(kind)
        ways: tuple[list[list[float]], list[list[float]]] = [], []
        for speed in CAMPBELL:
            # at rest both ways are one motion in two planes
            frequencies, forward = whirl(mounted.modes, max(speed, 1e-3) / 3.6 / mounted.wheelset.mean_radius)
            for way, of_way in zip(ways, (~forward, forward), strict=True):
                way.append(frequencies[of_way].tolist())
        axles.append({"wheelset": mounted.name, "speed_kmh": CAMPBELL, "backward_Hz": ways[0], "forward_Hz": ways[1]})
    return axles


def _by_wheel(vehicle: Vehicle, values: NDArray[np.float64]) -> dict[str, dict[str, float]]:
    """Numbers of the wheels (wheelsets, 2) by the wheelsets' names."""
    pairs = zip(vehicle.wheelsets, values.tolist(), strict=True)
    return {m.name: {"left": left, "right": right} for m, (left, right) in pairs}


def stationary_tests(
    vehicle: Vehicle, twist: bool, twists: tuple[float, float] | None, rotation: bool, radius: float
) -> tuple[dict[str, Any], TwistTest | None, tuple[RotationTest, ...]]:
    """The twist test, and the rotation test of every bogie at both rates, where wanted; before them their numbers.

    twists [per mille]: under body and bogie, those of the standard unless given; radius: of the curve [m].
    """
    for value in twists or ():
        if not 0.0 <= value <= 20.0:
            raise InputError(f"--twists {value:g}: must be from 0 to 20 per mille")
    numbers: dict[str, Any] = {}
    twisted = loops.twist_test(vehicle, *(1e-3 * t for t in twists or ())) if twist else None
    pairs = [(bogie, rate) for bogie in loops.turning_bogies(vehicle) for rate in loops.RATES] if rotation else []
    turned = tuple(loops.rotation_test(vehicle, bogie, rate, radius) for bogie, rate in pairs)
    if twisted is not None:
        numbers["twist_test"] = {
            "body_twist_permille": 1e3 * twisted.body,
            "bogie_twist_permille": 1e3 * twisted.bogie,
            "static_kN": _by_wheel(vehicle, twisted.static / 1e3),
            "unloading": _by_wheel(vehicle, twisted.unloading),
            "of_friction": _by_wheel(vehicle, twisted.friction),
            "largest_unloading": float(twisted.unloading.max()),
            **judged(LOOPS, "twist_unloading", float(twisted.unloading.max())),
        }
    if turned:
        numbers["rotation_test"] = [
            {
                "bogie": test.bogie.frame,
                "rate_deg_per_s": degrees(test.rate),
                "angle_deg": degrees(float(test.angle.max())),
                "moment_kNm": test.largest / 1e3,
                "axle_load_kN": test.axle_load / 1e3,
                "wheelbase_mm": 1e3 * test.bogie.wheelbase,
                "X": test.factor,
                **judged(LOOPS, "X_factor", test.factor),
            }
            for test in turned
        ]
    return numbers, twisted, turned


def tables_at_rest(numbers: Numbers) -> list[Table]:
    """What people read of a vehicle at rest, of all that was computed."""
    centre = ", ".join(
        f"{axis} {formatted(round(c, 3) + 0.0, 'g')}" for axis, c in zip("xyz", numbers["centre_mm"], strict=True)
    )
    mass = f"mass {quantity(numbers['mass_kg'], 'kg', '.6g')}, centre at {centre} mm"
    loads = replace(_loads_table(numbers, "static wheel loads"), notes=(_verdict(numbers["weighing"]),))
    tables = [Table(numbers["name"], notes=(numbers["source"], mass)), loads]
    if "under_loads" in numbers:
        tables += _under_loads_tables(numbers["under_loads"])
    if "leaning" in numbers:
        tables += _leaning_tables(numbers["leaning"])
    if "twisted" in numbers:
        twist = formatted(numbers["twisted"]["twist_permille"], "g")
        tables.append(_unloading_table(numbers["twisted"], f"on a twist of {twist} per mille"))
    if "twist_test" in numbers:
        tables.append(_twist_table(numbers["twist_test"]))
    if "rotation_test" in numbers:
        tables.append(_rotation_table(numbers["rotation_test"]))
    for axle in numbers["axles"]:
        columns = (Column("speed", "km/h", "g"), *(Column(word, "Hz", ".2f") for word in ("backward", "forward") * 2))
        pairs = zip(axle["speed_kmh"], axle["backward_Hz"], axle["forward_Hz"], strict=True)
        cells = [(v, b[0], f[0], b[1], f[1]) for v, b, f in pairs if v % 100 == 0 and len(b) > 1]
        tables.append(Table(f"bending of the free elastic axle '{axle['wheelset']}'", columns, cells))
    heads = (Column("frequency", "Hz", ".3f"), Column("damping", "", ".3f"), Column("motion"))
    notes = (numbers["linearised"],) if "linearised" in numbers else ()
    rows = [(m["frequency_Hz"], m["damping"], m["motion"]) for m in numbers["modes"]]
    return [*tables, *([Table("modes on its springs, wheelsets held", heads, rows, notes)] if rows else [])]


def _wheels_table(
    numbers: Numbers, title: str, columns: Mapping[str, tuple[str, str, str]], notes: tuple[str, ...] = ()
) -> Table:
    """Numbers of wheels, a row a wheelset; columns: by key, words of the left and the right wheel, unit."""
    names = numbers[next(iter(columns))]
    rows = [(name, *(v for key in columns for v in numbers[key][name].values())) for name in names]
    heads = (Column(word, unit, ".3f") for left, right, unit in columns.values() for word in (left, right))
    return Table(title, (Column("wheelset"), *heads), rows, notes)


def _loads_table(numbers: Numbers, title: str) -> Table:
    table = _wheels_table(numbers, title, {"wheel_loads_kN": ("left", "right", "kN")})
    return replace(table, rows=[*table.rows, ("together", numbers["weight_kN"], "")])


def _under_loads_tables(numbers: Numbers) -> list[Table]:
    if "problem" in numbers:
        return [Table("", notes=(numbers["problem"],))]
    heads = (Column("load"), *(Column(axis, "kN", ".3f") for axis in "xyz"))
    loads = Table("loads, at their largest", heads, [(name, *force) for name, force in numbers["loads_kN"].items()])
    tables = [loads, _loads_table(numbers, "under the loads")]
    if numbers["bodies"]:
        heads = (Column("body"), Column("lateral", "mm", ".2f"), Column("vertical", "mm", ".2f"))
        rows = [(name, *moved.values()) for name, moved in numbers["bodies"].items()]
        tables.append(Table("bodies under the loads", (*heads, Column("roll", "mrad", ".2f")), rows))
    if numbers["bump_stops"]:
        heads = (Column("bump stop"), Column("travel", "mm", ".2f"), Column("force", "kN", ".3f"))
        tables.append(Table("bump stops in contact", heads, [tuple(stop.values()) for stop in numbers["bump_stops"]]))
    return tables


def _unloading_table(numbers: Numbers, title: str) -> Table:
    if "problem" in numbers:
        return Table("", notes=(f"{title}: {numbers['problem']}",))
    title = f"{title}: unloading up to {formatted(numbers['largest_unloading'], '.3f')}"
    columns = {"wheel_loads_kN": ("left", "right", "kN"), "unloading": ("left ΔQ/Q₀", "right ΔQ/Q₀", "")}
    return _wheels_table(numbers, title, columns)


def _leaning_tables(numbers: Numbers) -> list[Table]:
    title = f"at {quantity(numbers['cant_deficiency_mm'], 'mm', 'g')} of cant deficiency"
    if "problem" in numbers:
        return [_unloading_table(numbers, title)]
    rows = [(name, s, numbers["roll_deg"][name]) for name, s in numbers["flexibility_coefficient"].items()]
    heads = (Column("body"), Column("flexibility coefficient", "", ".3f"), Column("roll", "°", ".2f"))
    verdicts = tuple(map(_verdict, numbers["verdicts"]))
    bodies = Table("bodies against the track, outward", heads if rows else (), rows, verdicts)
    return [_unloading_table(numbers, title), bodies]


def _twist_table(numbers: Numbers) -> Table:
    twists = f"{formatted(numbers['body_twist_permille'], '.3g')} per mille under the body"
    if numbers["bogie_twist_permille"]:
        twists += f" and {formatted(numbers['bogie_twist_permille'], '.3g')} under every bogie"
    most = numbers["largest_unloading"]
    title = f"twist test, {twists}, there and back: unloading up to {formatted(most, '.3f')}"
    columns = {
        "static_kN": ("Q₀ left", "right", "kN"),
        "unloading": ("ΔQ/Q₀ left", "right", ""),
        "of_friction": ("of friction left", "right", ""),
    }
    return _wheels_table(numbers, title, columns, (_verdict(numbers),))


def _rotation_table(tests: Sequence[Numbers]) -> Table:
    heads = {
        "bogie": Column("bogie"), "rate_deg_per_s": Column("rate", "°/s"), "angle_deg": Column("angle", "°"),
        "moment_kNm": Column("moment", "kN m"), "axle_load_kN": Column("axle load", "kN"), "X": Column("X"),
    }  # fmt: skip
    largest = max(test["X"] for test in tests)
    rows = [tuple(test[key] for key in heads) for test in tests]
    title = f"rotation test: X factor up to {formatted(largest, '.3f')}"
    return Table(title, tuple(heads.values()), rows, (_verdict(max(tests, key=lambda test: test["X"])),))


def _verdict(numbers: Numbers) -> str:
    outcome = "ok:" if numbers["passed"] else "EXCEEDED:"
    value, limit = (quantity(numbers[key], numbers["unit"], ".3g") for key in ("value", "limit"))
    bound = "at least" if numbers["lowest"] else "at most"
    return f"{outcome} {numbers['symbol']} = {value} ({bound} {limit}; {numbers['limit_source']})"
