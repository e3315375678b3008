"""Contact models for both wheels of a set-up, and the force law of its vehicle."""

from dataclasses import replace

import numpy as np

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.settings import Array, ContactSettings, Friction, FrictionAlong
from wrsim.inputs.section import SIDES
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.static import StaticPlan
from wrsim.simulation.law import VehicleOnTrack, placed_on_rails
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.wheelset import Wheelset


def contact_models(setup: Setup, wheelset: Wheelset | None = None) -> tuple[ContactModel, ContactModel]:
    """Models of the left and the right wheel on their rails, by default of the first wheelset.

    Poses that are solved without rolling have no friction.
    """
    frictionless = isinstance(setup.plan, StaticPlan) and not setup.plan.rolling
    settings = replace(setup.contact, tangential="none") if frictionless else setup.contact
    wheelset = wheelset or setup.wheelset
    wheels = (wheelset.left, wheelset.right)
    left, right = (
        contact_model(wheel.profile, rail, wheel.radius, settings, friction, surface, wheel.out_of_round, setup.roller)
        for wheel, rail, friction, surface in zip(wheels, setup.rails, settings.friction, setup.surfaces, strict=True)
    )
    return left, right


def contact_at(setup: Setup, place: float) -> ContactSettings:
    """The set-up's contact with the friction of one place [m] of the centre line: for track that is laid elsewhere."""
    left, right = (
        law.at(float(setup.track.rail_distance(side, place))) if isinstance(law, FrictionAlong) else law
        for side, law in zip(SIDES, setup.contact.friction, strict=True)
    )
    return replace(setup.contact, friction=(left, right))


def friction_channels(setup: Setup, distance: Array) -> dict[str, Array]:
    """Coefficients of friction at no slip of both rails at distances (n,) along the centre line [m], each (n, 2).

    On the top and on the gauge corner. Empty where they are the same everywhere.
    """
    laws = setup.contact.friction
    if not any(isinstance(friction, FrictionAlong) for friction in laws):
        return {}
    coefficients = np.empty((2, len(distance), 2))
    for i, (side, friction) in enumerate(zip(SIDES, laws, strict=True)):
        law = friction if isinstance(friction, FrictionAlong) else FrictionAlong((0.0,), (Friction.of(friction),))
        coefficients[:, :, i] = law.numbers(setup.track.rail_distance(side, distance))[:, :2].T
    return {"rail_friction": coefficients[0], "rail_friction_corner": coefficients[1]}


def wheels_on_rails(setup: Setup, wheelset: Wheelset | None = None) -> tuple[WheelOnRail, WheelOnRail]:
    """The same with their places: on the wheelset and in the track's cross-section at nominal gauge."""
    wheelset = wheelset or setup.wheelset
    return placed_on_rails(wheelset, contact_models(setup, wheelset), setup.track)


def force_law(
    setup: Setup[RunPlan], speed: float | None = None, drive: Drive | None = None, stepped: bool = False
) -> VehicleOnTrack:
    """The law of the set-up's vehicle on its track; constant speed and drive, where given, in the place of its own;
    stepped: for a `Stepper`."""
    run = setup.plan
    kind = VehicleOnTrack
    if setup.contact.normal == "half-space":
        from wrsim.simulation.half_space_law import HalfSpaceOnTrack  # brings parts of scipy that nothing else needs

        kind = HalfSpaceOnTrack
    return kind(
        setup.vehicle,
        setup.track,
        [contact_models(setup, wheelset=mounted.wheelset) for mounted in setup.vehicle.wheelsets],
        speed=run.speed if speed is None else speed,
        start=run.start,
        drive=setup.drive if drive is None else drive,
        threads=setup.threads,
        profile=run.profile if speed is None else None,
        stepped=stepped,
    )


def held_by(setup: Setup[RunPlan]) -> Drive:
    """What holds the speed of a steady motion: a pull along the track, unless the frames do."""
    return "free" if setup.drive == "free" and setup.vehicle.runs_with_frame else "train"
