"""What a scenario describes, and values that are allowed but most likely slips: wrong units, lost zeros."""

from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

from wrsim.contact.profiles.files import notes_of
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import Friction, FrictionAlong
from wrsim.contact.surfaces.rail_surface import INNERMOST
from wrsim.register import ANALYSES
from wrsim.results.dataset import ASSUMPTIONS
from wrsim.results.table import Column, Table, formatted
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.steady import SteadyPlan
from wrsim.track.path import COLUMNS
from wrsim.vehicle.plausibility import HIGHEST, doubts
from wrsim.vehicle.plausible_values import value_doubts
from wrsim.vehicle.speed import SpeedProfile
from wrsim.vehicle.vehicle import Vehicle

MOST_LISTED = 20  # segments that the terminal lists
USUAL_WHEELSET = (100.0, 5_000.0)
"""Masses of wheelsets [kg], from trams to heavy haul with gears."""
USUAL_SPRUNG, USUAL_HEIGHT = (10.0, 50e3), (0.0, HIGHEST)
"""Masses that press on a wheelset [kg], and heights of their centres above the rails [m]."""
USUAL_BODY = (10.0, 150e3)
"""Masses of bodies that hang on springs [kg]."""
USUAL_WHEEL_LOAD = (1.0, 250.0)
"""Static wheel loads [kN]."""
USUAL_RADIUS = (150.0, 750.0)
"""Radii of wheels at the tape circle [mm]."""
MOST_DEFICIENCY = 0.3
"""Cant deficiency over 1.5 m [m], of trains that tilt (EN 13803 [mem]); others run at 0.15 m."""
LEAST_CANT, LEAST_CURVATURE = 5e-3, 1.0 / 5000.0
"""What counts as cant [m] and as a curve [1/m]: tamping leaves errors of some 5 mm."""
MOST_FRICTION = 1.0
"""Coefficient of friction: dry steel on steel has 0.5 to 0.7, sanded up to 0.8."""
SHORTEST_STEP = 20e-6
"""Step [s] below that of rk44 in its hardest case, 26 us at 1 m/s (``simulation.step_size``)."""
MOST_BENT = 0.15
"""Curvature of a rail along the track over the wheel's: a contact pressed as deep bears some 5 % more or less there,
3 to 6 % on the tread of S1002 on 60E1."""
MOST_ASKEW = 7e-3
"""Slope in plan of a check rail's working face: a flange that is yawed by 10 mrad presses on one of 6:1 by 4 % too much
with 7 mm per metre, by 16 % with 9 (docs/theory/surfaces.md)."""
PEAK, PEAK_REACH, WIDE = 1.3e-3, 10e-3, 90e-3
"""How far a flange falls from its tip within 10 mm to both sides, on a profile wider than 90 mm [m]: with its radius of
12 to 20 mm 2.7 mm and more, the crown of a rail (80 mm and more) up to 0.63 mm; 1.3 mm is their geometric mean."""


def warnings(setup: Setup) -> list[str]:
    """One sentence for every implausible value, in the words and units of its file, and for what a run leaves out."""
    plan = setup.plan
    left_out = [
        f"output.patches_at_m: {place:g} m is not passed by the run, which is from {plan.start:.6g} to {plan.end:.6g} "
        "m; no patches are stored there"
        for place in getattr(plan, "left_out", ())
    ]
    return list(dict.fromkeys([*left_out, *vehicle_warnings(setup.vehicle), *run_doubts(setup)]))


def run_doubts(setup: Setup) -> Iterator[str]:
    """One sentence for every implausible value."""
    yield from _curve_doubts(setup)
    yield from _bridged(setup)
    yield from _askew(setup)
    laws = [each.laws if isinstance(each, FrictionAlong) else [each] for each in setup.contact.friction]
    largest = max(max(law.static, law.at_corner) for law in map(Friction.of, chain(*laws)))
    if largest > MOST_FRICTION and setup.conical is None:
        yield f"contact.friction = {largest:g}: plausible is up to {MOST_FRICTION:g}; dry steel on steel has 0.5 to 0.7"
    step = getattr(setup.plan, "step", None)
    if step is not None and step < SHORTEST_STEP * (1.0 - 1e-9):
        message = f"run.step_us = {1e6 * step:g}: plausible is {1e6 * SHORTEST_STEP:g} and more"
        yield f"{message}; without it a good one is chosen"
    for name in dict.fromkeys(rail.name for rail in setup.rails if _peaks(rail)):
        yield f"profile '{name}' of a rail is shaped like a wheel: the scan of another body?"


def _curve_doubts(setup: Setup) -> Iterator[str]:
    """The largest cant deficiency, and the largest cant that leans outward."""
    plan = setup.plan
    if isinstance(plan, RunPlan) and plan.speed > 0.0:
        profile = plan.profile or SpeedProfile.constant(plan.speed)
        times = np.linspace(0.0, min(plan.duration, 1e6), 20_001)
        places = np.clip(plan.start + profile.way(times), 0.0, setup.track.length)
        speeds, curvatures = profile.speed(times), setup.track.curvature(places)
        cants = setup.track.cant(places) * np.sign(curvatures)
    elif isinstance(plan, SteadyPlan):
        speeds, curvatures, cants = np.transpose([(p.speed, 1.0 / p.radius, p.cant) for p in plan.points])
        places = None
    else:
        return
    curved = np.abs(curvatures) > LEAST_CURVATURE
    deficiencies = np.where(curved, 1.5 * speeds**2 * np.abs(curvatures) / 9.81 - cants, 0.0)
    outward = np.where(curved, -cants, 0.0)
    for quantity, values, most, hint in (
        ("cant deficiency", deficiencies, MOST_DEFICIENCY, "plausible is up to 300 mm, of trains that tilt"),
        ("cant that leans outward", outward, LEAST_CANT, "positive cant_mm leans inside, in curves to either side"),
    ):
        k = int(np.argmax(values))
        if values[k] > most:
            where = "" if places is None else f", at {places[k]:.5g} m"
            curve = f"R {abs(1.0 / curvatures[k]):.4g} m, {3.6 * speeds[k]:.4g} km/h{where}"
            yield f"track: {1e3 * values[k]:.4g} mm of {quantity} ({curve}); {hint}"


def _bridged(setup: Setup) -> Iterator[str]:
    """Where irregularities bend a rail so much along the track that a wheel's contact is another one."""
    plan, wheels = setup.plan, setup.vehicle.wheelsets
    if not isinstance(plan, RunPlan) or not setup.track.is_uneven or not wheels:
        return
    round_by = 1.0 / max(mounted.wheelset.mean_radius for mounted in wheels)
    for side, path in (("left", setup.track.left), ("right", setup.track.right)):
        up = path.table[:, COLUMNS.index("kz")]
        k = int(np.argmax(up if up.max() > round_by else np.abs(up)))
        if abs(up[k]) > MOST_BENT * round_by:
            fault = "is more hollow than a wheel, which bridges it" if up[k] > round_by else "bends under the contact"
            bend = f"{up[k]:.3g} 1/m at {k * path.step:.5g} m of the {side} rail, of {round_by:.3g} 1/m of a wheel"
            yield f"track.irregularities: the rail {fault} ({bend}); contacts take it as straight: use rail_sections"


def _askew(setup: Setup) -> Iterator[str]:
    """Where a check rail's flare is so sharp that a yawed flange presses on it too much."""
    for side, surface in zip(("left", "right"), setup.surfaces, strict=True):
        for piece in surface.pieces if surface and setup.conical is None else ():
            middles = 0.5 * (piece.spline.x[1:] + piece.spline.x[:-1])
            u, _w, tu, tw = np.moveaxis(piece.spline(middles), -1, 0)
            face = (u < INNERMOST) & (np.abs(tw) > np.abs(tu))
            slopes = np.where(face, np.abs(piece.spline(middles, 1)[:, :, 0]), 0.0).max(axis=1)
            k = int(np.argmax(slopes))
            if slopes[k] > MOST_ASKEW:
                flare = f"{1e3 * slopes[k]:.3g} mm per metre at {middles[k]:.5g} m of the {side} rail"
                error = "a yawed flange presses on it too much, by 16 % with 9 mm per metre and 10 mrad"
                yield f"track.rail_sections: a check rail's face runs aside by {flare}: {error}"


def _peaks(rail: Profile) -> bool:
    """Whether a rail's top is the tip of a flange."""
    u, w = rail.at(np.linspace(0.0, rail.length, 2001))
    top = int(np.argmax(w))
    beside = [w[int(np.argmin(np.abs(u - u[top] - reach)))] for reach in (-PEAK_REACH, PEAK_REACH)]
    return bool(np.ptp(u) > WIDE and w[top] - max(beside) > PEAK)


def vehicle_warnings(vehicle: Vehicle) -> list[str]:
    """The same of a vehicle on its own."""
    unusual = {
        f"{quantity} = {value:.4g} {unit} is outside of the usual {low:g} to {high:g} {unit}: is it meant so?": quantity
        for quantity, value, (low, high), unit in _values(vehicle)
        if not low <= value <= high
    }
    known = [quantity.split("'")[1] for quantity in unusual.values() if quantity.startswith("mass")]
    return [*doubts(vehicle, known), *unusual, *value_doubts(vehicle)]


def _values(vehicle: Vehicle) -> Iterator[tuple[str, float, tuple[float, float], str]]:
    """Values with a usual range: name, value, range, unit."""
    for mounted in {id(mounted.wheelset): mounted for mounted in vehicle.wheelsets[::-1]}.values():
        wheelset = mounted.wheelset
        yield f"mass_kg of wheelset '{mounted.name}'", wheelset.mass, USUAL_WHEELSET, "kg"
        for side, wheel in (("left", wheelset.left), ("right", wheelset.right)):
            yield f"radius_mm of the {side} wheel of '{mounted.name}'", 1e3 * wheel.radius, USUAL_RADIUS, "mm"
    for body in {body.mass: body for body in vehicle.bodies[::-1]}.values():
        yield f"mass_kg of body '{body.name}'", body.mass, USUAL_BODY, "kg"
    for carried in (each for each in vehicle.carried if each.mass > 0.0):
        yield f"sprung_mass_kg of '{carried.body}'", carried.mass, USUAL_SPRUNG, "kg"
        height = vehicle.place(carried.body)[2] + carried.height
        yield f"height of the centre of the sprung mass of '{carried.body}'", float(height), USUAL_HEIGHT, "m"
    load = 0.5 * vehicle.weight / len(vehicle.wheelsets) / 1e3
    yield f"mean static wheel load of '{vehicle.name}'", load, USUAL_WHEEL_LOAD, "kN"


def facts(setup: Setup) -> dict[str, Any]:
    """What a scenario describes, for its author to check."""
    vehicle = setup.vehicle
    facts: dict[str, Any] = {
        "title": setup.title,
        "analysis": setup.analysis,
        "vehicle": vehicle.name,
        "wheelsets": [mounted.name for mounted in vehicle.wheelsets],
        "axle_load_kN": vehicle.weight / len(vehicle.wheelsets) / 1e3,
        "drive": setup.drive,
        "gauge_mm": 1e3 * setup.track.nominal_gauge,
        "rails": [rail.name for rail in setup.rails],
        **{name: setup.assumptions[name] for name in ASSUMPTIONS if name in setup.assumptions},
        "files": [str(f) for f in setup.files],
    }
    if notes := notes_of(setup.profiles):
        facts["profiles"] = list(notes)
    if setup.conical is None:
        chosen = setup.contact
        facts |= {"normal": chosen.normal, "tangential": chosen.creep_forces, "max_patches": chosen.patch_count}
        facts |= {"strip_width_mm": 1e3 * chosen.strip_width} if chosen.strip_width else {"strips": chosen.strip_count}
    else:
        facts["contact"] = f"conical wheels, {setup.conical.conicity:g}, with a prescribed creep law"
    if ANALYSES[setup.analysis].moves:
        facts["segments"] = [f.label if f.label == f.kind else f"{f.kind} {f.label}" for f in setup.track.features()]
    return facts | setup.plan.facts()


def facts_table(title: str, facts: dict[str, Any]) -> Table:
    """Facts, one a line; of a long list the first `MOST_LISTED`."""

    def text(value: object) -> str:
        if not isinstance(value, list):
            return formatted(value, ".6g")
        more = len(value) - MOST_LISTED
        return ", ".join(map(text, value[:MOST_LISTED])) + (f" and {more} more" if more > 0 else "")

    return Table(title, (Column(), Column()), [(name, text(value)) for name, value in facts.items()])
