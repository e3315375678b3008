"""Conicity analysis: rolling radius difference, contact points and equivalent conicity of a wheelset on its rails."""

from __future__ import annotations

import numpy as np

from wrsim.analysis.conicity.equivalent import equivalent_conicity
from wrsim.analysis.conicity.rigid import RigidContact, rigid_contact
from wrsim.analysis.progress import Progress, Report
from wrsim.errors import InputError
from wrsim.geometry.profile.profile import Profile
from wrsim.results import Result, assemble
from wrsim.results.conicity import Array
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.vehicle.wheelset import Wheelset

STEP = 5e-5  # distance of the shifts at which the contact is found [m]
REACH = 5e-3
"""The shifts go this far beyond the largest amplitude [m]: unequal diameters move the place it is counted from."""
KEPT = 4  # one shift out of so many is kept in the result


def run_conicity(setup: Setup[ConicityPlan], progress: Progress | None = None) -> Result:
    """The conicity of a scenario's wheelset on its track at nominal gauge."""
    gauge = setup.track.nominal_gauge
    result = conicity(setup.wheelset, setup.rails, gauge, setup.plan, setup.title, setup.text)
    Report(progress)(1.0)
    return result


def conicity(
    wheelset: Wheelset, rails: tuple[Profile, Profile], gauge: float, plan: ConicityPlan, title: str, text: str = ""
) -> Result:
    """Rigid contact over the lateral shift, and the equivalent conicity over the amplitude.

    rails: left and right profile, inclined; gauge [m]; text: the scenario this belongs to.
    Raises InputError when the wheels do not stand on the rails and when the wheelset has no place to swing about.
    """
    reach = max(plan.amplitudes) + REACH
    shift = STEP * np.arange(-np.ceil(reach / STEP), np.ceil(reach / STEP) + 1.0)
    left, right = wheelset.left, wheelset.right
    profiles, radii = (left.profile, right.profile), (left.radius, right.radius)
    contact = rigid_contact(profiles, radii, rails, wheelset.profile_spacing, gauge, shift, plan.roll != "none")
    place, difference = _counted(contact, plan.roll)
    found = equivalent_conicity(place, difference, wheelset.mean_radius, plan.amplitudes)
    if not np.isfinite(found.equilibrium):
        raise InputError(
            f"{title}: the rolling radius difference does not rise through zero within {1e3 * reach:g} mm of the "
            "centre: the wheelset has no place to swing about"
        )
    part = slice(None, None, KEPT)
    channels = {
        "lateral_shift": place[part],
        "vertical_shift": contact.lift[part],
        "roll": contact.roll[part],
        "rolling_radius_difference": contact.radius_difference[part],
        "rolling_radius": contact.radius[part],
        "contact_angle": contact.angle[part, :, None],
        "u_wheel": contact.u_wheel[part, :, None],
        "u_rail": contact.u_rail[part, :, None],
        "y_contact": contact.lateral[part, :, None],
        "equivalent_conicity": found.conicity,
        "conicity_wavelength": found.wavelength,
    }
    attributes: dict[str, str | float | int] = {
        "title": title,
        "analysis": "conicity",
        "status": "completed",
        "scenario_text": text,
        "roll": plan.roll,
        "gauge_m": gauge,
        "profile_spacing_m": wheelset.profile_spacing,
        "radius_left_m": radii[0],
        "radius_right_m": radii[1],
        "equilibrium_shift_m": found.equilibrium,
        "flange_from_rad": plan.flange_from,
        "curve_radii_m": " ".join(f"{radius:.15g}" for radius in plan.curves),
    }
    names = [f"y={1e3 * y + 0.0:+.3f}mm" for y in place[part]]
    return Result(assemble({"pose": names, "amplitude": found.amplitude}, channels, attributes))


def _counted(contact: RigidContact, roll: str) -> tuple[Array, Array]:
    """Shifts as the plan counts them, and the rolling radius difference there.

    On a steep flange the wheelset's centre goes back while its wheels go on: only the shifts before that have a
    difference.
    """
    if roll != "centre":
        return contact.shift, contact.radius_difference
    place = np.where(np.isfinite(contact.centre_shift), contact.centre_shift, contact.shift)
    middle = place.size // 2
    rising = np.concatenate([np.diff(place) > 0.0, [True]])
    good = np.isfinite(contact.roll) & rising
    last = middle + int(np.argmin(np.append(good[middle:], False)))
    first = middle - int(np.argmin(np.append(good[middle::-1], False)))
    keep = slice(first + 1, last)
    difference = np.full_like(place, np.nan)
    difference[keep] = contact.radius_difference[keep]
    return place, difference
