"""The contact models as one family: the register of normal models, and how a model is built.

A new normal model is a kernel that contact.wheel_rail calls, its number in contact.records, its name in
`wrsim.contact.settings.Normal` with its usual choices in ``USUAL``, and an entry here.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wrsim.contact.model import EPSILON, MOST_STRIPS, ContactModel, NormalModel
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.records import FREE_STRIPS, KIK_PIOTROWSKI
from wrsim.contact.settings import DRY, SOLVED_STRIPS, AnyFriction, ContactSettings, Friction, FrictionAlong, Normal
from wrsim.contact.surfaces.out_of_round import Part, shape_tables
from wrsim.contact.surfaces.rail_surface import RailSurface
from wrsim.contact.surfaces.rolled_rail import rolled_rail
from wrsim.errors import InputError


def _solve_exactly(model: ContactModel) -> int:
    from wrsim.contact.half_space.strips import solve_into  # brings parts of scipy that nothing else needs

    return solve_into(model).status


_KIK_PIOTROWSKI = NormalModel(KIK_PIOTROWSKI, recess=1.0 - EPSILON, joint=True, fewest=3, most=MOST_STRIPS)

FEWEST, MOST = SOLVED_STRIPS["strips"]

NORMAL_MODELS: dict[Normal, NormalModel] = {
    "kik-piotrowski": _KIK_PIOTROWSKI,
    "strips": replace(_KIK_PIOTROWSKI, kernel=FREE_STRIPS, fewest=FEWEST, most=MOST, solves_for_strips=True),
    "half-space": replace(_KIK_PIOTROWSKI, solve=_solve_exactly),
}

LARGEST = 100.0  # radius of a wheel; bodies of comparisons with ellipses are larger than any wheel [m]
LEAST_ROLLER, LARGEST_ROLLER = 0.1, 1e9  # radius of a roller; the largest one is a rail [m]


def contact_model(
    wheel: Profile,
    rail: Profile,
    radius: float,
    settings: ContactSettings | None = None,
    friction: AnyFriction = DRY,
    surface: RailSurface | None = None,
    out_of_round: Sequence[Part] = (),
    roller: float | None = None,
) -> ContactModel:
    """The contact model of one wheel on one rail.

    Parameters
    ----------
    wheel, rail : Profile
        The rail as it is laid: with its inclination, ``rail.inclined(1 / 40)``.
    radius : float
        Of the wheel at the tape circle [m].
    settings : ContactSettings, optional
        Normal model, model of the creep forces, number of strips ...; what is not given there has its usual value.
    friction : float, Friction or FrictionAlong
        Coefficient of friction, a law of contact angle and slip, or such laws along the rail.
    surface : RailSurface, optional
        A rail whose profile changes along the track, of whose kind and gauge ``rail`` is.
    out_of_round : sequence of Harmonic, Flat or RadiusTable
        What the radius of the wheel deviates by, in sum.
    roller : float, optional
        Radius at the origin of the rail's profile of a roller, which turns under the wheel in place of a rail [m].

    Returns
    -------
    ContactModel
        It is evaluated at one pose by `ContactModel.evaluate`, or at prescribed loads by `solve_poses`.

    Raises
    ------
    InputError
        For profiles of the wrong kind, and for numbers that cannot be.

    Examples
    --------
    >>> from wrsim import ContactSettings, contact_model, load_profile
    >>> rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    >>> wheel = load_profile("wheels/S1002.toml")
    >>> model = contact_model(wheel, rail, 0.46, ContactSettings(normal="strips"), friction=0.3)
    """
    settings = settings or ContactSettings()
    if not isinstance(settings, ContactSettings):
        raise InputError(f"settings: must be ContactSettings, not {type(settings).__name__}")
    settings.check()
    for profile, kind in ((wheel, "wheel"), (rail, "rail")):
        if not isinstance(profile, Profile):
            raise InputError(f"{kind} = {profile!r:.60}: must be a Profile, such as load_profile gives of a file")
        if profile.kind != kind:
            raise InputError(f"profile '{profile.name}' is a {profile.kind}; a {kind} is needed here")
    if not 0.0 < radius <= LARGEST:
        raise InputError(f"radius = {radius:g}: must be a radius above 0 and at most {LARGEST:g} m")
    rolled = None
    if surface is not None:
        rolled = None if surface.constant else rolled_rail(surface, radius)
        rail = surface.constant or rail
    law = friction if isinstance(friction, FrictionAlong) else Friction.of(friction)
    parts = (out_of_round,) if isinstance(out_of_round, Part) else tuple(out_of_round)
    normal = NORMAL_MODELS[settings.normal]
    if parts and not np.any(shape_tables(parts, wheel, radius).depth):
        parts = ()
    if roller is not None:
        if not LEAST_ROLLER <= roller <= LARGEST_ROLLER:
            raise InputError(f"roller = {roller:g}: must be a radius from {LEAST_ROLLER:g} to {LARGEST_ROLLER:g} m")
        if rolled is not None or parts:
            raise InputError("roller: is for round wheels and a profile that does not change along the rail")
    return ContactModel(wheel, rail, radius, settings, law, normal, rolled, parts, roller)


def fast_model(model: ContactModel) -> ContactModel:
    """The same wheel on the same rail with `ContactSettings.fast`, in arrays of its own."""
    return _same_bodies(model, model.settings.fast())


def exact_model(model: ContactModel) -> ContactModel:
    """The same wheel on the same rail with pressures of the half-space solver, in arrays of its own."""
    chosen = model.settings
    settings = replace(
        chosen,
        normal="half-space",
        tangential=chosen.creep_forces,
        strips=None,
        strip_width=None,
        max_patches=chosen.patch_count,
    )
    return _same_bodies(model, settings)


def _same_bodies(model: ContactModel, settings: ContactSettings) -> ContactModel:
    surface = None if model.rolled is None else model.rolled.surface
    bodies = model.wheel, model.rail, model.radius
    return contact_model(*bodies, settings, model.friction, surface, model.out_of_round, model.roller)
