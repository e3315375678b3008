"""Poses that are others in disguise: a round wheel on an axle beside its centre, a straight rail laid askew.

The same bodies touch at the same places with the same velocities. So they have the figures of the pose that a source
has, while a code goes by its ways for wheels out of round and for rails that change along the track.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from reference_contact import FRICTION, HALF_SPACING, Answer, Chosen, Place, answer_of_elements, answer_of_strips

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import Contact
from wrsim.contact.models import contact_model
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.points import ProfilePoints, interpolated
from wrsim.contact.surfaces.out_of_round import RadiusTable
from wrsim.contact.surfaces.rail_surface import RailSection, RailSurface
from wrsim.simulation.pose_solver import HalfSpacePoseSolver, PoseSolver

Array = NDArray[np.float64]
BESIDE, ROLLED = 5e-3, 0.7  # distance of the axle from the centre [m]; the angle by which the wheel has rolled [rad]
ASKEW = 0.01  # angle of the rail in plan [rad]
REACH, STEP = 0.2, 0.05  # of its sections along the track [m]
POINT = 1e-4  # distance of their points [m]


def eccentric(place: Place) -> dict[str, Any]:
    """The wheel out of round: its radius about an axle beside its centre. What the profile's height changes of it is
    2 um on 30 mm."""
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    far = np.sqrt(place.radius**2 - (BESIDE * np.sin(angle)) ** 2)
    return {"out_of_round": [RadiusTable(angle, np.empty(0), (BESIDE * np.cos(angle) + far - place.radius)[:, None])]}


def axle_beside(pose: Array) -> None:
    """Move an axle (12,) from the centre of its wheel to where it is."""
    axle = pose[3:6]
    q = np.hypot(axle[1], axle[2])
    down, ahead = np.array([0.0, axle[2], -axle[1]]) / q, (np.array([1.0, 0.0, 0.0]) - axle[0] * axle) / q
    arm = -BESIDE * (np.cos(ROLLED) * down - np.sin(ROLLED) * ahead)
    pose[:3] += arm
    pose[6:9] += np.cross(pose[9:12], arm)


def askew(place: Place) -> dict[str, Any]:
    """The rail as sections that move outward along the track; oblique sections are wider."""
    u, w = place.rail.at(np.linspace(0.0, place.rail.length, round(place.rail.length / POINT)))
    wide = interpolated(ProfilePoints("wide", u / np.cos(ASKEW), w, np.arange(u.size)), "wide", "rail")
    places = np.arange(-REACH, REACH + STEP / 2.0, STEP)
    sections = (RailSection(float(s), wide.shifted(float(np.tan(ASKEW) * s), 0.0)) for s in places)
    return {"surface": RailSurface("askew", tuple(sections))}


def turned(pose: Array, way: float = 1.0) -> None:
    """Turn the wheel with its rail; vectors of three in a row."""
    c, s = np.cos(ASKEW), way * np.sin(ASKEW)
    for part in pose.reshape(-1, 3):
        part[:2] = c * part[0] - s * part[1], s * part[0] + c * part[1]


FORMS: dict[str, tuple[Callable[[Place], dict[str, Any]], Callable[[Array], None]]] = {
    "eccentric": (eccentric, axle_beside), "askew": (askew, turned),
}  # fmt: skip


def moved(chosen: Chosen, form: str, place: Place, pose: Pose, spin: float) -> Answer | None:
    """The answer of a model in a disguise; None where it finds none."""
    make, move = FORMS[form]
    settings = chosen.settings if place.rolling else replace(chosen.settings, tangential="none")
    model = contact_model(place.wheel, place.rail, place.radius, settings, FRICTION, **make(place))
    wheels = [WheelOnRail(model, 1, HALF_SPACING, place.origin)]
    pose, radius = replace(pose, wheel_angle=ROLLED), 2.0 / spin if spin else place.radius

    class Moved(PoseSolver):
        def place(self, lateral: float, height: float, yaw: float, roll: float) -> None:
            super().place(lateral, height, yaw, roll)
            for wheel in self.wheels:
                move(wheel.model.arrays.pose)

    class MovedExactly(Moved, HalfSpacePoseSolver):
        pass

    if chosen.solver is None:
        Moved(wheels, place.rolling, radius).solve(pose)
        answer = answer_of_strips(model, Contact.copy_from(model.arrays, 0), place.origin[0], 0)
    else:
        exact = MovedExactly(wheels, place.rolling, radius, chosen.solver)
        exact._fast = Moved(exact._fast.wheels, place.rolling, radius)
        exact.solve(pose)
        answer = answer_of_elements(exact.contacts[0], place.origin[0], False, 0.0)
    if answer is not None and form == "askew":
        turned(answer.force, -1.0)
    return answer
