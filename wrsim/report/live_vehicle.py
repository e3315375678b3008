"""The page in which a vehicle runs while one watches: its program, its workspace, and where in that each number is.

The program is the co-simulation unit (`simulation.fmu`), compiled to WebAssembly; what the page changes and shows lies
in the unit's workspace, so that it is the `Stepper` of the scenario to round-off.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from wrsim.analysis.motion.run import holding_stepper
from wrsim.assessment.limits import LimitContext
from wrsim.assessment.rules import USUAL, rule_set
from wrsim.contact.library.build import compiler_for
from wrsim.contact.models import NORMAL_MODELS
from wrsim.contact.records import LOBE, STATUS_COARSE, STRIP
from wrsim.plots.theme import pressure_map
from wrsim.report.live import live_page
from wrsim.report.view_data import BEYOND, PATH_STEP, centre_line, outline_points, packed, vehicle_shapes
from wrsim.results.wheelsets import numbered
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario, loaded
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.fmu import unit_program
from wrsim.simulation.stepper import Stepper
from wrsim.vehicle.dynamics import outputs, vehicle_forces, wheel_forces
from wrsim.vehicle.dynamics import stepper as kernel
from wrsim.vehicle.vehicle import Vehicle

Array = NDArray[Any]
LIMITED = ("Y_over_Q", "Q")
"""Quantities of rule sets whose limits are drawn across histories."""
SIDE_TERMS = r"\b(left|right|outer|inner|front|rear|middle|leading|trailing|\d+)\b"
STRETCHED = {"stiffness": ("k", "series", "stiffness", "turning"), "damping": ("c", "damping", "turning_damping")}
"""Fields of a record ELEMENT."""
TOKEN = "live"
POINTS, ERROR = 800, 0.005  # of a profile; how far a drawn one is off [mm]
STRETCH = 5.0
"""By which stiffness and damping may be divided and multiplied: the unit's inverse belongs to those of the scenario;
what its two iterations leave is told in the page."""


def live_vehicle_page(
    scenario: Scenario | str | Path, step: float | None = None, budget: float | None = None
) -> tuple[str, Stepper]:
    """The page as HTML, and the stepper that runs in it.

    step: of the integration [s]; none: one that holds over the run. budget: as `stepper` takes it.
    Raises InputError and SimulationError as `stepper`, WrsimError where the program cannot be compiled.
    """
    scenario = loaded(scenario)
    compiler_for("wasm")
    bench, setup = holding_stepper(scenario, step, budget), build(scenario)
    normal = NORMAL_MODELS[setup.contact.normal].kernel
    program = unit_program(bench, normal, TOKEN, "wasm")
    return live_page("live_vehicle.html", scenario.title, program, live_data(bench, setup)), bench


def live_data(bench: Stepper, setup: Setup[RunPlan]) -> dict[str, Any]:
    """All that the page knows of a scenario besides the program: shapes, places of numbers, what may be changed."""
    places, vehicle = Places(bench), setup.vehicle
    names = [mounted.name for mounted in vehicle.wheelsets]
    called = numbered(names)
    ahead = [part.centre[0] for part in vehicle.parts]
    first, last = setup.plan.start + min(ahead) - BEYOND, setup.track.length + BEYOND
    s = np.arange(np.floor(first), last, PATH_STEP)
    track = setup.track
    curvature = track.curvature(s)
    line = centre_line(curvature, track.cant(s), track.grade(s), track.cant_base)
    return {
        "about": _assumed(setup, bench),
        "colours": [to_hex(c) for c in pressure_map()(np.linspace(0.0, 1.0, 32))],
        "vehicle": vehicle_shapes(setup),
        "track": {"start": float(s[0]), "step": PATH_STEP, "line": packed(line, "f8")},
        "end": float(setup.track.length - max(ahead)),
        "called": called,
        "wheel": int(curvature.sum() > 0.0),  # the outer one of the first wheelset
        "wheelsets": names,
        "bodies": [{"name": part.name, "centre": list(part.centre)} for part in vehicle.parts],
        "places": places.of_motion() | {"wheels": places.of_wheels(), "speed": places.of_speed()},
        "profiles": _profiles(vehicle, setup),
        "friction": places.of_friction(),
        "inputs": list(_inputs(bench, places, vehicle)),
        "elements": list(_elements(bench, places)),
        "limits": _limits(),
        "speed": _speeds(setup.plan),
        "token": TOKEN,
        "records": {"lobe": list(LOBE.names), "strip": list(STRIP.names)},
    }


class Places:
    """Where numbers are in the buffer of a unit, counted in doubles."""

    def __init__(self, bench: Stepper) -> None:
        self.bench, self.buffer = bench, bench.memory.buffer

    def of(self, view: Array) -> int:
        """Of the first number of a view."""
        return (view.ctypes.data - self.buffer.ctypes.data) // self.buffer.itemsize

    def of_motion(self) -> dict[str, Any]:
        """Coordinates, motions of bodies and forces of wheels: first place, and numbers of a row."""
        views = self.bench.memory.views
        step = views[kernel.STEP_RECORD]
        return {
            "coordinates": self.of(views[kernel.STATE][kernel.Q]),
            "bodies": {"first": self.of(views[kernel.SEEN]), "names": list(outputs.BODY_SEEN.names)},
            "forces": {"first": self.of(views[kernel.WHEELS]), "names": list(outputs.WHEEL_SEEN.names)},
            "residual": self.of(step["residual"]),
            "count": int(self.buffer.size),
            "weight": float(self.bench.law.vehicle.weight),
            "step": self.bench.step_size,
        }

    def of_wheels(self) -> list[dict[str, int]]:
        """Of each wheel its pose, number of lobes, lobes, strips, with strips a lobe."""
        wheels = []
        for arrays in self._wheels():
            strips = arrays["strips"]
            wheels.append({
                "pose": self.of(arrays["pose"]), "lobes": self.of(arrays["total"]["lobes"]),
                "status": self.of(arrays["total"]["status"]),
                "patches": self.of(arrays["patches"]), "strips": self.of(strips), "most": strips.shape[1],
            })  # fmt: skip
        return wheels

    def of_friction(self) -> dict[str, Any]:
        """Of both coefficients of every wheel, with the first of them; no places where friction varies along a rail."""
        arrays = list(self._wheels())
        if any(len(each["friction"]) for each in arrays):
            return {"places": []}
        places = [self.of(each["call"][name]) for each in arrays for name in ("mu", "mu_gauge")]
        return {"places": places, "value": float(self.buffer[places[0]])}

    def of_speed(self) -> dict[str, Any]:
        """Of the pieces of the run's motion: first place and their number."""
        pieces = self.bench.law.workspace.views[vehicle_forces.MOTION]
        return {"first": self.of(pieces), "pieces": len(pieces)}

    def _wheels(self) -> Iterator[Mapping[str, Array]]:
        views = self.bench.law.workspace.views[vehicle_forces.FIRST_WHEEL :]
        for first in range(wheel_forces.IN_CONTACT, len(views), wheel_forces.ARRAYS):
            yield dict(zip(wheel_forces.Arrays._fields, views[first:], strict=False))


def _assumed(setup: Setup[RunPlan], bench: Stepper) -> str:
    """What the numbers of the page rest on, in one line."""
    support = setup.support or "rigid rails"
    return (
        f"{setup.vehicle.name}; contact: {setup.contact.normal}, {setup.contact.creep_forces}; rails: {support}; "
        f"step {1e3 * bench.step_size:g} ms with two iterations; start: the steady motion of the scenario. "
        f"{(line := bench.budget_line) and f'{line} (status {STATUS_COARSE}). '}"
        "*: limit from memory of the standard"
    )


def _speeds(plan: RunPlan) -> dict[str, float]:
    """Of the slider [m/s]: from half of the run's least speed to one and a half of its highest."""
    least, most = plan.speeds
    return {"least": 0.5 * least, "most": 1.5 * most, "value": plan.speed}


def _profiles(vehicle: Vehicle, setup: Setup[RunPlan]) -> dict[str, Any]:
    """Wheels as points (u, radius), rails as points (o, b) [m], each once; of every wheel the numbers of both."""
    curves: list[list[list[float]]] = []
    pairs = []
    for mounted in vehicle.wheelsets:
        for wheel, rail in zip((mounted.wheelset.left, mounted.wheelset.right), setup.rails, strict=True):
            u, w = outline_points(wheel.profile, POINTS, ERROR)
            o, b = outline_points(rail, POINTS, ERROR)
            pair = []
            for curve in (np.stack((u, wheel.radius - w), 1), np.stack((o, b), 1)):
                points = curve.round(7).tolist()
                if points not in curves:
                    curves.append(points)
                pair.append(curves.index(points))
            pairs.append(pair)
    return {"curves": curves, "pairs": pairs}


def _inputs(bench: Stepper, places: Places, vehicle: Vehicle) -> Iterator[dict[str, Any]]:
    """Inputs of the unit with their values. Reach of the sliders: the static load of a wheelset, times its radius."""
    load = vehicle.weight / len(vehicle.wheelsets)
    radius = vehicle.wheelsets[0].wheelset.left.radius
    for name, view in bench.inputs.items():
        unit = "N m" if name.endswith("_Nm") else "N"
        reach = load * (radius if unit == "N m" else 1.0)
        label = re.sub(r"_(Nm|N)$", "", name).replace("_", " ")
        yield {"words": label, "unit": unit, "reach": reach, "value": float(view[0]), "place": places.of(view)}


def _elements(bench: Stepper, places: Places) -> Iterator[dict[str, Any]]:
    """Stiffness and damping of elements of one name but for their side: words, values, places. Not of those that a
    table gives."""
    rows = bench.law.elements
    groups: dict[tuple[str, str], list[int]] = {}
    for i, element in enumerate(bench.law.vehicle.elements):
        name = " ".join(re.sub(SIDE_TERMS, "", element.name.rpartition(".")[2]).split()) or element.name
        for quantity, fields in STRETCHED.items():
            table = rows["spring_rows" if quantity == "stiffness" else "damper_rows"][i]
            numbers = [] if table else [*_nonzero(rows[i : i + 1], fields, places)]
            groups.setdefault((name, quantity), []).extend(numbers)
    for (name, quantity), numbers in groups.items():
        if numbers:
            values = [float(places.buffer[place]) for place in numbers]
            yield {"words": f"{quantity} of {name}", "places": numbers, "values": values, "stretch": STRETCH}


def _nonzero(row: Array, fields: Iterable[str], places: Places) -> Iterator[int]:
    """Places of the numbers other than 0 in fields of a record."""
    for name in fields:
        first = places.of(row[name])
        for k in range(row[name].nbytes // 8 if row.dtype[name].names is None else row.dtype[name].itemsize // 8):
            if places.buffer[first + k] != 0.0:
                yield first + k


def _limits() -> dict[str, list[dict[str, Any]]]:
    """Limits of the usual rule set that hold everywhere, by channel, in units for readers."""
    drawn: dict[str, list[dict[str, Any]]] = {}
    for clause in rule_set(USUAL).clauses:
        limit = clause.limit_at(LimitContext()) if clause.quantity in LIMITED else None
        if limit is not None:
            shown = clause.judged.shown
            value = f"{shown.factor * limit.value:g} {shown.unit}".strip()
            label = f"{clause.judged.symbol} {value}, {limit.source}{limit.star}"
            drawn.setdefault(clause.quantity, []).append({"value": shown.factor * limit.value, "words": label})
    return drawn
