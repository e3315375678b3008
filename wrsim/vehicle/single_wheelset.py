"""A wheelset on its own as a vehicle."""

from __future__ import annotations

from wrsim.vehicle.elements import GUIDE, ZERO, Element, Spring, Triple
from wrsim.vehicle.loads import CarriedMass
from wrsim.vehicle.vehicle import MountedWheelset, Vehicle
from wrsim.vehicle.wheelset import Wheelset


def single_wheelset(
    wheelset: Wheelset,
    *,
    stiffness: Triple = ZERO,
    damping: Triple = ZERO,
    half_spacing: float = 1.0,
    ahead: float = 0.0,
    carried_mass: float = 0.0,
    carried_height: float = 0.0,
) -> Vehicle:
    """A wheelset on its own, held to the guide frame by one set of springs and dampers on each side.

    stiffness [N/m], damping [N s/m]: along x, y, z of each side, at +-half_spacing [m] from the middle of the axle. Yaw
    and roll stiffness follow from it, 2 kx half_spacing^2 and 2 kz half_spacing^2.
    ahead: of the centre of the bogie [m], 0 for one that steers itself. In a curve of curvature kappa the axle is held
    at an angle of attack of -ahead kappa.
    carried_mass [kg] at carried_height above the axle [m].
    """
    name, height = "wheelset", wheelset.mean_radius
    springs: tuple[Element, ...] = ()
    if any(stiffness) or any(damping):
        sides = (("left", half_spacing), ("right", -half_spacing))
        springs = tuple(
            Spring(f"guide {side}", "spring", GUIDE, name, (0.0, y, height), stiffness, damping) for side, y in sides
        )
    return Vehicle(
        wheelset.name,
        (MountedWheelset(name, wheelset, 0.0, height),),
        (),
        springs,
        source=wheelset.source,
        carried=(CarriedMass(name, carried_mass, carried_height),) if carried_mass else (),
        guide_ahead=ahead,
        drive="free",
    )
