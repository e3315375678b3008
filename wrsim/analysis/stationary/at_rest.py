"""A vehicle at rest in numbers: mass, wheel loads, modes, sway, unloading on twisted track, rotation of bogies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import asin, degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.assessment.sections import CANT_BASE
from wrsim.analysis.stationary.rotation_test import LIMIT, RATES, RotationTest, rotation_test, turning_bogies
from wrsim.analysis.stationary.statics import StaticState, canted, static_state
from wrsim.analysis.stationary.twist_test import UNLOADING_LIMIT, TwistTest, twist_test
from wrsim.errors import InputError, SimulationError
from wrsim.results.table import Cell, Column, Table, formatted, quantity
from wrsim.simulation.modes import natural_modes
from wrsim.vehicle.vehicle import Vehicle

Facts = Mapping[str, Any]


def facts_at_rest(vehicle: Vehicle, cant_deficiency: float | None = None, twist: float | None = None) -> dict[str, Any]:
    """Numbers of a vehicle at rest; cant_deficiency [mm], twist [per mille]: of tests, none unless given."""
    trimmed = replace(vehicle, loads=())
    rest = static_state(trimmed)
    facts = {
        "name": vehicle.name,
        "source": vehicle.source,
        "mass_kg": vehicle.mass,
        "centre_mm": [1e3 * float(c) for c in vehicle.centre],
        "bodies": [b.name for b in vehicle.bodies],
        "elements": len(vehicle.elements),
        **wheel_loads(vehicle, rest.wheel_loads),
        "modes": [
            {"frequency_Hz": mode.frequency, "damping": mode.damping, "motion": mode.name}
            for mode in natural_modes(trimmed)
        ],
    }
    if vehicle.loads:
        facts["under_loads"] = _under_loads(vehicle)
    if cant_deficiency is not None:
        facts["leaning"] = leaning_facts(trimmed, rest, cant_deficiency)
    if twist is not None:
        facts["twisted"] = twisted_facts(trimmed, rest, twist)
    return facts


def _under_loads(vehicle: Vehicle) -> dict[str, Any]:
    """How it stands under its loads; why not, where it does not."""
    try:
        rest = static_state(vehicle)
    except SimulationError as error:
        return {"problem": str(error)}
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
    return {"loads_kN": forces, **wheel_loads(vehicle, rest.wheel_loads), "bodies": bodies, "bump_stops": stops}


def twist_loop(vehicle: Vehicle, twists: tuple[float, float] | None) -> TwistTest:
    """The twist test; twists [per mille] under body and bogie, those of the standard unless given."""
    for twist in twists or ():
        if not 0.0 <= twist <= 20.0:
            raise InputError(f"--twists {twist:g}: must be from 0 to 20 per mille")
    return twist_test(vehicle) if twists is None else twist_test(vehicle, *(1e-3 * t for t in twists))


def rotation_loops(vehicle: Vehicle, radius: float) -> tuple[RotationTest, ...]:
    """The rotation test of every bogie at both rates."""
    return tuple(rotation_test(vehicle, bogie, rate, radius) for bogie in turning_bogies(vehicle) for rate in RATES)


def test_facts(vehicle: Vehicle, twisted: TwistTest | None, turned: Sequence[RotationTest]) -> dict[str, Any]:
    """Numbers of the stationary tests that were done."""
    found: dict[str, Any] = {} if twisted is None else {"twist_test": twist_facts(vehicle, twisted)}
    return found | ({"rotation_test": rotation_facts(turned)} if turned else {})


def twist_facts(vehicle: Vehicle, test: TwistTest) -> dict[str, Any]:
    """Numbers of a twist test."""
    return {
        "body_twist_permille": 1e3 * test.body,
        "bogie_twist_permille": 1e3 * test.bogie,
        "static_kN": _by_wheel(vehicle, test.static / 1e3),
        "unloading": _by_wheel(vehicle, test.unloading),
        "of_friction": _by_wheel(vehicle, test.friction),
        "largest_unloading": float(test.unloading.max()),
        "limit": UNLOADING_LIMIT,
    }


def rotation_facts(tests: Sequence[RotationTest]) -> list[dict[str, Any]]:
    """Numbers of rotation tests."""
    return [
        {
            "bogie": test.bogie.frame,
            "rate_deg_per_s": degrees(test.rate),
            "angle_deg": degrees(float(test.angle.max())),
            "moment_kNm": test.largest / 1e3,
            "axle_load_kN": test.axle_load / 1e3,
            "wheelbase_mm": 1e3 * test.bogie.wheelbase,
            "X": test.factor,
            "limit": LIMIT,
        }
        for test in tests
    ]


def leaning_facts(vehicle: Vehicle, level: StaticState, deficiency_mm: float) -> dict[str, Any]:
    """How a vehicle without loads stands on rails canted by so much; level: how it does on level ones."""
    angle = asin(deficiency_mm / 1e3 / CANT_BASE)
    facts = {"cant_deficiency_mm": deficiency_mm}
    try:
        rest = static_state(canted(vehicle, angle))
    except SimulationError as error:
        return facts | {"problem": str(error)}
    rolls = {b.name: -float(roll) for b, roll in zip(vehicle.bodies, rest.moved[:, 2], strict=True)}
    sway = {
        "flexibility_coefficient": {name: roll / angle for name, roll in rolls.items()},
        "roll_deg": {name: degrees(roll) for name, roll in rolls.items()},
    }
    return facts | _unloading(vehicle, level, rest) | sway


def twisted_facts(vehicle: Vehicle, level: StaticState, twist: float) -> dict[str, Any]:
    """How it stands on a track of this twist, in parts of a thousand; see `leaning_facts`."""
    facts = {"twist_permille": twist}
    try:
        rest = static_state(vehicle, twist / 1e3 / CANT_BASE)
    except SimulationError as error:
        return facts | {"problem": str(error)}
    return facts | _unloading(vehicle, level, rest)


def _unloading(vehicle: Vehicle, level: StaticState, rest: StaticState) -> dict[str, Any]:
    """Wheel loads, and the part of its load on level rails that every wheel has lost."""
    lost = 1.0 - rest.wheel_loads / level.wheel_loads
    loads = wheel_loads(vehicle, rest.wheel_loads)
    return loads | {"unloading": _by_wheel(vehicle, lost), "largest_unloading": float(lost.max())}


def wheel_loads(vehicle: Vehicle, loads: NDArray[np.float64]) -> dict[str, Any]:
    """Wheel loads (wheelsets, 2) [N] and their sum."""
    return {"wheel_loads_kN": _by_wheel(vehicle, loads / 1e3), "weight_kN": float(loads.sum()) / 1e3}


def _by_wheel(vehicle: Vehicle, values: NDArray[np.float64]) -> dict[str, dict[str, float]]:
    """Numbers of the wheels (wheelsets, 2) by the wheelsets' names."""
    pairs = zip(vehicle.wheelsets, values.tolist(), strict=True)
    return {m.name: {"left": left, "right": right} for m, (left, right) in pairs}


def tables_at_rest(found: Facts) -> list[Table]:
    """What people read of a vehicle at rest, of whatever was asked for."""
    centre = ", ".join(
        f"{axis} {formatted(round(c, 3) + 0.0, 'g')}" for axis, c in zip("xyz", found["centre_mm"], strict=True)
    )
    mass = f"mass {quantity(found['mass_kg'], 'kg', '.6g')}, centre at {centre} mm"
    tables = [Table(found["name"], notes=(found["source"], mass)), _loads_table(found, "static wheel loads")]
    tables += _under_loads_tables(found.get("under_loads"))
    if "leaning" in found:
        tables += _leaning_tables(found["leaning"])
    if "twisted" in found:
        twist = formatted(found["twisted"]["twist_permille"], "g")
        tables.append(_unloading_table(found["twisted"], f"on a twist of {twist} per mille"))
    if "twist_test" in found:
        tables.append(_twist_table(found["twist_test"]))
    if "rotation_test" in found:
        tables.append(_rotation_table(found["rotation_test"]))
    heads = (Column("frequency", "Hz", ".3f"), Column("damping", "", ".3f"), Column("motion"))
    rows = [(m["frequency_Hz"], m["damping"], m["motion"]) for m in found["modes"]]
    return [*tables, *([Table("modes on its springs, wheelsets held", heads, rows)] if rows else [])]


def _loads_table(found: Facts, title: str) -> Table:
    rows: list[Sequence[Cell]] = [(name, q["left"], q["right"]) for name, q in found["wheel_loads_kN"].items()]
    heads = (Column("wheelset"), Column("left", "kN", ".3f"), Column("right", "kN", ".3f"))
    return Table(title, heads, [*rows, ("together", found["weight_kN"], "")])


def _under_loads_tables(found: Facts | None) -> list[Table]:
    """How a vehicle stands under its loads."""
    if found is None or "problem" in found:
        return [] if found is None else [Table("", notes=(found["problem"],))]
    heads = (Column("load"), *(Column(axis, "kN", ".3f") for axis in "xyz"))
    loads = Table("loads, at their largest", heads, [(name, *force) for name, force in found["loads_kN"].items()])
    tables = [loads, _loads_table(found, "under the loads")]
    if found["bodies"]:
        heads = (Column("body"), Column("lateral", "mm", ".2f"), Column("vertical", "mm", ".2f"))
        rows = [(name, *moved.values()) for name, moved in found["bodies"].items()]
        tables.append(Table("bodies under the loads", (*heads, Column("roll", "mrad", ".2f")), rows))
    if found["bump_stops"]:
        heads = (Column("bump stop"), Column("travel", "mm", ".2f"), Column("force", "kN", ".3f"))
        tables.append(Table("bump stops in contact", heads, [tuple(stop.values()) for stop in found["bump_stops"]]))
    return tables


def _unloading_table(found: Facts, title: str) -> Table:
    """Wheel loads and the part of them that is lost."""
    if "problem" in found:
        return Table("", notes=(f"{title}: {found['problem']}",))
    rows = [(name, *q.values(), *found["unloading"][name].values()) for name, q in found["wheel_loads_kN"].items()]
    words = (("left", "kN"), ("right", "kN"), ("left ΔQ/Q₀", ""), ("right ΔQ/Q₀", ""))
    heads = (Column("wheelset"), *(Column(word, unit, ".3f") for word, unit in words))
    return Table(f"{title}: unloading up to {formatted(found['largest_unloading'], '.3f')}", heads, rows)


def _leaning_tables(found: Facts) -> list[Table]:
    """Unloading and roll under cant deficiency."""
    title = f"at {quantity(found['cant_deficiency_mm'], 'mm', 'g')} of cant deficiency"
    if "problem" in found:
        return [_unloading_table(found, title)]
    rows = [(name, s, found["roll_deg"][name]) for name, s in found["flexibility_coefficient"].items()]
    heads = (Column("body"), Column("flexibility coefficient", "", ".3f"), Column("roll", "°", ".2f"))
    note = "49 CFR 213.57(d): no unloading above 0.4, a passenger car's floor rolls by 8.6 degrees at most [pub]"
    return [
        _unloading_table(found, title),
        Table("bodies against the track, outward", heads if rows else (), rows, (note,)),
    ]


def _twist_table(found: Facts) -> Table:
    """The twist test of EN 14363."""
    keys = ("static_kN", "unloading", "of_friction")
    rows = [(name, *(q for key in keys for q in found[key][name].values())) for name in found["unloading"]]
    words = (
        ("Q₀ left", "kN"),
        ("right", "kN"),
        ("ΔQ/Q₀ left", ""),
        ("right", ""),
        ("of friction left", ""),
        ("right", ""),
    )
    heads = (Column("wheelset"), *(Column(word, unit, ".3f") for word, unit in words))
    twists = f"{formatted(found['body_twist_permille'], '.3g')} per mille under the body"
    if found["bogie_twist_permille"]:
        twists += f" and {formatted(found['bogie_twist_permille'], '.3g')} under every bogie"
    most = found["largest_unloading"]
    title = f"twist test, {twists}, there and back: unloading up to {formatted(most, '.3f')}"
    return Table(title, heads, rows, (_verdict(most, found["limit"]),))


def _rotation_table(found: Sequence[Facts]) -> Table:
    """The rotation test of EN 14363."""
    heads = {
        "bogie": Column("bogie"), "rate_deg_per_s": Column("rate", "°/s"), "angle_deg": Column("angle", "°"),
        "moment_kNm": Column("moment", "kN m"), "axle_load_kN": Column("axle load", "kN"), "X": Column("X"),
    }  # fmt: skip
    largest = max(test["X"] for test in found)
    rows = [tuple(test[key] for key in heads) for test in found]
    title = f"rotation test: X factor up to {formatted(largest, '.3f')}"
    return Table(title, tuple(heads.values()), rows, (_verdict(largest, found[0]["limit"]),))


def _verdict(value: float, limit: float) -> str:
    words = "within the limit:" if value <= limit else "BEYOND THE LIMIT:"
    return f"{words} EN 14363 allows {formatted(limit, 'g')} [mem]"
