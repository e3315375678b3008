"""On which level of suspension a body stands: wheelset, bogie frame, car body."""

from __future__ import annotations

from typing import Literal

from wrsim.vehicle.vehicle import Vehicle

Level = Literal["wheelset", "bogie frame", "car body"]


def level_of(vehicle: Vehicle, body: str) -> Level:
    """A frame is joined to wheelsets and to another body as well; all other bodies are car bodies."""
    axles = {mounted.name for mounted in vehicle.wheelsets}
    if body in axles:
        return "wheelset"
    others = _joined(vehicle, body)
    bodies = {b.name for b in vehicle.bodies}
    return "bogie frame" if others & axles and others & bodies else "car body"


def bogie_mass(vehicle: Vehicle, body: str) -> float:
    """Mass of a bogie frame and the wheelsets joined to it [kg]; not-a-number for any other body."""
    if level_of(vehicle, body) != "bogie frame":
        return float("nan")
    joined = _joined(vehicle, body)
    frame = next(b.mass for b in vehicle.bodies if b.name == body)
    return frame + sum(mounted.mass for mounted in vehicle.wheelsets if mounted.name in joined)


def _joined(vehicle: Vehicle, body: str) -> set[str]:
    """Names of what suspension elements join to a body; a wheelset in the place of its axle boxes."""
    between = {name for coupling in vehicle.couplings for name in coupling.elements}
    own = (element for element in vehicle.elements if element.name not in between)
    pairs = ((vehicle.carrier(element.first), vehicle.carrier(element.second)) for element in own)
    return {b if a == body else a for a, b in pairs if body in (a, b)} - {body}
