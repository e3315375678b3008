"""The contact models as one family: the register of normal models, and how a model is built.

A new normal model is a kernel that core.contact.wheel_rail calls, its number in core.contact.records, its name in
`wrsim.contact.settings.Normal` with its usual choices in ``USUAL``, and an entry here.
"""

from __future__ import annotations

from dataclasses import replace

from wrsim.contact.half_space.strips import solve_into
from wrsim.contact.model import EPSILON, MOST_STRIPS, ContactModel, NormalModel
from wrsim.contact.settings import ContactSettings, Friction, Normal
from wrsim.core.contact.records import FREE_STRIPS, KIK_PIOTROWSKI
from wrsim.core.contact.strips.records import FEWEST_FREE_STRIPS
from wrsim.geometry.profile.profile import Profile

_KIK_PIOTROWSKI = NormalModel(KIK_PIOTROWSKI, recess=1.0 - EPSILON, joint=True, fewest=3, most=MOST_STRIPS)

NORMAL_MODELS: dict[Normal, NormalModel] = {
    "kik-piotrowski": _KIK_PIOTROWSKI,
    "strips": NormalModel(
        FREE_STRIPS, recess=0.0, joint=False, fewest=FEWEST_FREE_STRIPS, most=200, solves_for_strips=True
    ),
    "half-space": replace(_KIK_PIOTROWSKI, solve=lambda model: solve_into(model).status),
}


def contact_model(
    wheel: Profile, rail: Profile, radius: float, settings: ContactSettings, friction: float | Friction
) -> ContactModel:
    """The model of one wheel on one rail. The rail profile is given with its inclination; radius [m]."""
    return ContactModel(wheel, rail, radius, settings, Friction.of(friction), NORMAL_MODELS[settings.normal])


def fast_model(model: ContactModel) -> ContactModel:
    """The same wheel on the same rail with `ContactSettings.fast`, in arrays of its own."""
    return contact_model(model.wheel, model.rail, model.radius, model.settings.fast(), model.friction)
