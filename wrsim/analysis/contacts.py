"""Contact models for both wheels of a set-up."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import ContactModel
from wrsim.contact.models import contact_model
from wrsim.scenario.sections.static import StaticPlan

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.vehicle.wheelset import Wheelset


def contact_models(
    setup: Setup, frictionless: bool = False, wheelset: Wheelset | None = None
) -> tuple[ContactModel, ContactModel]:
    """Models of the left and the right wheel on their rails, by default of the first wheelset."""
    settings = replace(setup.contact, tangential="none") if frictionless else setup.contact
    wheelset = wheelset or setup.wheelset
    wheels = (wheelset.left, wheelset.right)
    left, right = (
        contact_model(wheel.profile, rail, wheel.radius, settings, friction, surface)
        for wheel, rail, friction, surface in zip(wheels, setup.rails, settings.friction, setup.surfaces, strict=True)
    )
    return left, right


def wheels_on_rails(
    setup: Setup, models: tuple[ContactModel, ContactModel], wheelset: Wheelset | None = None
) -> tuple[WheelOnRail, WheelOnRail]:
    """The same with their places: on the wheelset and in the track's cross-section at nominal gauge."""
    wheelset = wheelset or setup.wheelset
    left, right = (
        WheelOnRail(model, side, 0.5 * wheelset.profile_spacing, origin)
        for model, side, origin in zip(models, (1, -1), setup.track.rail_origins, strict=True)
    )
    return left, right


def is_frictionless(setup: Setup) -> bool:
    """True for poses that are solved without rolling."""
    return isinstance(setup.plan, StaticPlan) and not setup.plan.rolling
