"""What a scenario describes, and values that are allowed but most likely slips: wrong units, lost zeros."""

from collections.abc import Iterator
from typing import Any

from wrsim.contact.profiles.files import notes_of
from wrsim.register import ANALYSES
from wrsim.results.dataset import ASSUMPTIONS
from wrsim.results.table import Column, Table, formatted
from wrsim.scenario.build import Setup
from wrsim.scenario.plausible_runs import run_doubts
from wrsim.vehicle.plausibility import HIGHEST, doubts
from wrsim.vehicle.plausible_values import value_doubts
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


def warnings(setup: Setup) -> list[str]:
    """One sentence for every implausible value, in the words and units of its file, and for what a run leaves out."""
    plan = setup.plan
    left_out = [
        f"output.patches_at_m: {place:g} m is not passed by the run, which is from {plan.start:.6g} to {plan.end:.6g} "
        "m; no patches are stored there"
        for place in getattr(plan, "left_out", ())
    ]
    return list(dict.fromkeys([*left_out, *vehicle_warnings(setup.vehicle), *run_doubts(setup)]))


def vehicle_warnings(vehicle: Vehicle) -> list[str]:
    """The same of a vehicle on its own."""
    unusual = {
        f"{what} = {value:.4g} {unit} is outside of the usual {low:g} to {high:g} {unit}: is it meant so?": what
        for what, value, (low, high), unit in _values(vehicle)
        if not low <= value <= high
    }
    known = [what.split("'")[1] for what in unusual.values() if what.startswith("mass")]
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
