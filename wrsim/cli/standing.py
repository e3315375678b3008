"""Stationary tests in ``wrsim vehicle``: sway, wheel unloading on twisted track, rotation resistance of bogies."""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, degrees
from typing import TYPE_CHECKING, Any

from wrsim.cli.showing import print_table, say

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from wrsim.analysis.stationary.rotation_test import RotationTest
    from wrsim.analysis.stationary.twist_test import TwistTest
    from wrsim.simulation.statics import Standing
    from wrsim.vehicle.vehicle import Vehicle


def check_asked(twist_test: bool, twists: tuple[float, float] | None, rotation_test: bool, loops: Path | None) -> None:
    """Raise InputError for options without the test that they belong to, and for twists beyond all tracks."""
    from wrsim.errors import InputError

    if twists is not None and not twist_test:
        raise InputError("--twists belongs to --twist-test")
    if loops is not None and not (twist_test or rotation_test):
        raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
    for twist in twists or ():
        if not 0.0 <= twist <= 20.0:
            raise InputError(f"--twists {twist:g}: must be from 0 to 20 per mille")


def twist_loop(vehicle: Vehicle, twists: tuple[float, float] | None) -> TwistTest:
    """The twist test; twists [per mille] under body and bogie, those of the standard unless given."""
    from wrsim.analysis.stationary.twist_test import twist_test

    return twist_test(vehicle) if twists is None else twist_test(vehicle, *(1e-3 * t for t in twists))


def rotation_loops(vehicle: Vehicle, radius: float) -> tuple[RotationTest, ...]:
    """The rotation test of every bogie at both rates."""
    from wrsim.analysis.stationary.rotation_test import RATES, rotation_test, turning_bogies

    return tuple(rotation_test(vehicle, bogie, rate, radius) for bogie in turning_bogies(vehicle) for rate in RATES)


def twist_facts(vehicle: Vehicle, test: TwistTest) -> dict[str, Any]:
    """What the command tells of a twist test."""
    from wrsim.analysis.stationary.twist_test import UNLOADING_LIMIT

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
    """What the command tells of rotation tests."""
    from wrsim.analysis.stationary.rotation_test import LIMIT

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


def loops_picture(vehicle: Vehicle, twisted: TwistTest | None, turned: Sequence[RotationTest], path: Path) -> Path:
    """Draw the loops of the tests."""
    from wrsim.plots import save
    from wrsim.plots.stationary import Loop, loops_figure

    found = []
    if twisted is not None:
        wheels = [
            (f"{m.name} {side}", 1e-3 * twisted.wheel_loads[:, i, k])
            for i, m in enumerate(vehicle.wheelsets[: (len(vehicle.wheelsets) + 1) // 2])
            for k, side in enumerate(("left", "right"))
        ]
        found.append(Loop("part of the full twists", "wheel load Q [kN]", [(n, twisted.part, q) for n, q in wheels]))
    if turned:
        first = turned[0].bogie
        lines = [
            (f"{degrees(test.rate):g} deg/s", [degrees(a) for a in test.angle], 1e-3 * test.moment)
            for test in turned
            if test.bogie == first
        ]
        found.append(Loop(f"angle of {first.frame} [deg]", "moment [kNm]", lines))
    return save(loops_figure(vehicle.name, found), path)


def leaning_facts(vehicle: Vehicle, level: Standing, deficiency_mm: float) -> dict[str, Any]:
    """How a vehicle without loads stands on rails canted by so much; level: how it does on level ones."""
    from wrsim.analysis.assessment.sections import CANT_BASE
    from wrsim.errors import SimulationError
    from wrsim.simulation.statics import leaning, standing

    angle = asin(deficiency_mm / 1e3 / CANT_BASE)
    facts = {"cant_deficiency_mm": deficiency_mm}
    try:
        rest = standing(leaning(vehicle, angle))
    except SimulationError as error:
        return facts | {"problem": str(error)}
    rolls = {b.name: -float(roll) for b, roll in zip(vehicle.bodies, rest.moved[:, 2], strict=True)}
    sway = {
        "flexibility_coefficient": {name: roll / angle for name, roll in rolls.items()},
        "roll_deg": {name: degrees(roll) for name, roll in rolls.items()},
    }
    return facts | _unloading(vehicle, level, rest) | sway


def twisted_facts(vehicle: Vehicle, level: Standing, twist: float) -> dict[str, Any]:
    """How it stands on a track of this twist, in parts of a thousand; see `leaning_facts`."""
    from wrsim.analysis.assessment.sections import CANT_BASE
    from wrsim.errors import SimulationError
    from wrsim.simulation.statics import standing

    facts = {"twist_permille": twist}
    try:
        rest = standing(vehicle, twist / 1e3 / CANT_BASE)
    except SimulationError as error:
        return facts | {"problem": str(error)}
    return facts | _unloading(vehicle, level, rest)


def _unloading(vehicle: Vehicle, level: Standing, rest: Standing) -> dict[str, Any]:
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


def print_standing(found: dict[str, Any]) -> None:
    """Whatever was asked for."""
    if "leaning" in found:
        _print_leaning(found["leaning"])
    if "twisted" in found:
        own = found["twisted"]
        _print_unloading(own, f"on a twist of {own['twist_permille']:g} per mille")
    if "twist_test" in found:
        _print_twist_test(found["twist_test"])
    if "rotation_test" in found:
        _print_rotation_test(found["rotation_test"])


def _print_twist_test(found: dict[str, Any]) -> None:
    sides = ("left", "right")
    rows = [
        [
            name,
            *(f"{found[key][name][side]:z.3f}" for key in ("static_kN", "unloading", "of_friction") for side in sides),
        ]
        for name in found["unloading"]
    ]
    heads = ("wheelset", "Q0 left kN", "right kN", "dQ/Q0 left", "right", "of friction left", "right")
    twists = f"{found['body_twist_permille']:.3g} per mille under the body"
    if found["bogie_twist_permille"]:
        twists += f" and {found['bogie_twist_permille']:.3g} under every bogie"
    title = f"twist test, {twists}, there and back: unloading up to {found['largest_unloading']:.3f}"
    print_table(heads, rows, title=title, left=("wheelset",))
    say(f"{_verdict(found['largest_unloading'], found['limit'])} EN 14363 allows {found['limit']:g} [mem]")


def _print_rotation_test(found: list[dict[str, Any]]) -> None:
    keys = ("rate_deg_per_s", "angle_deg", "moment_kNm", "axle_load_kN", "X")
    rows = [[test["bogie"], *(f"{test[key]:.4g}" for key in keys)] for test in found]
    heads = ("bogie", "deg/s", "angle deg", "moment kNm", "axle load kN", "X")
    largest, limit = max(test["X"] for test in found), found[0]["limit"]
    title = f"rotation test: X factor up to {largest:.3f}"
    print_table(heads, rows, title=title, left=("bogie",))
    say(f"{_verdict(largest, limit)} EN 14363 allows {limit:g} [mem]")


def _verdict(value: float, limit: float) -> str:
    return "within the limit:" if value <= limit else "BEYOND THE LIMIT:"


def _print_leaning(found: dict[str, Any]) -> None:
    _print_unloading(found, f"at {found['cant_deficiency_mm']:g} mm of cant deficiency")
    if "problem" in found:
        return
    rows = [
        [name, f"{s:z.3f}", f"{found['roll_deg'][name]:z.2f}"] for name, s in found["flexibility_coefficient"].items()
    ]
    if rows:
        heads = ("body", "flexibility coefficient", "roll deg")
        print_table(heads, rows, title="bodies against the track, outward", left=("body",))
    say("49 CFR 213.57(d): no unloading above 0.4, a passenger car's floor rolls by 8.6 degrees at most [pub]")


def _print_unloading(found: dict[str, Any], title: str) -> None:
    if "problem" in found:
        say(f"{title}: {found['problem']}")
        return
    rows = [
        [
            name,
            *(f"{q[side]:.3f}" for side in ("left", "right")),
            *(f"{found['unloading'][name][side]:z.3f}" for side in ("left", "right")),
        ]
        for name, q in found["wheel_loads_kN"].items()
    ]
    heads = ("wheelset", "left kN", "right kN", "left dQ/Q0", "right dQ/Q0")
    print_table(heads, rows, title=f"{title}: unloading up to {found['largest_unloading']:.3f}", left=("wheelset",))
