"""Conicity analysis: rolling radius difference, contact points and equivalent conicity of a wheelset on its rails.

Equivalent conicity by EN 15302: the cone that would give a wheelset the wavelength it has on its real profiles.
The centre of an unyawed, massless wheelset that rolls without slip follows

    y'' + Delta r(y) / (2 e r0) = 0,    Delta r = r_left - r_right,

with 2 e = 1.5 m between the contact points and r0 the mean radius. It swings about the place where Delta r = 0. The
first integral of the equation is y'^2 / 2 + P(y) = E with P the integral of Delta r / (2 e r0), so the wavelength of
a swing from y1 to y2 with P(y1) = P(y2) = E is a quadrature,

    lambda = 2 int_y1^y2 dy / sqrt(2 (E - P(y))),

and the equivalent conicity at the amplitude (y2 - y1) / 2 is that of Klingel's cone,

    tan(gamma_e) = (2 pi / lambda)^2 e r0.

No time steps, no tolerance: the quadrature is the exact solution for the piecewise linear Delta r given.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly
from scipy.optimize import brentq

from wrsim.analysis.conicity.rigid import RigidContact, rigid_contact
from wrsim.analysis.progress import Progress, Report
from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError
from wrsim.results import Result, assemble
from wrsim.results.conicity import CONTACT_DISTANCE, Array
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.vehicle.wheelset import Wheelset

STEP = 5e-5  # distance of the shifts at which the contact is found [m]
REACH = 5e-3
"""The shifts go this far beyond the largest amplitude [m]: unequal diameters move the place it is counted from."""
KEPT = 4  # one shift out of so many is stored in the result
POINTS = 2000  # of the quadrature over a swing


def run_conicity(setup: Setup[ConicityPlan], progress: Progress | None = None) -> Result:
    """The conicity of a scenario's wheelset on its track at nominal gauge."""
    gauge = setup.track.nominal_gauge
    result = wheelset_conicity(setup.wheelset, setup.rails, gauge, setup.plan, setup.title, setup.text)
    Report(progress)(1.0)
    return result


def wheelset_conicity(
    wheelset: Wheelset, rails: tuple[Profile, Profile], gauge: float, plan: ConicityPlan, title: str, text: str = ""
) -> Result:
    """Rigid contact over the lateral shift, and the equivalent conicity over the amplitude.

    rails: left and right profile, inclined; gauge [m]; text: the scenario this belongs to.
    Raises InputError when the wheels do not rest on the rails and when the wheelset has no place to swing about.
    """
    reach = max(plan.amplitudes) + REACH
    shift = STEP * np.arange(-np.ceil(reach / STEP), np.ceil(reach / STEP) + 1.0)
    left, right = wheelset.left, wheelset.right
    profiles, radii = (left.profile, right.profile), (left.radius, right.radius)
    contact = rigid_contact(profiles, radii, rails, wheelset.profile_spacing, gauge, shift, plan.roll != "none")
    place, difference = _counted(contact, plan.roll)
    equivalent = equivalent_conicity(place, difference, wheelset.mean_radius, plan.amplitudes)
    if not np.isfinite(equivalent.equilibrium):
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
        "equivalent_conicity": equivalent.conicity,
        "conicity_wavelength": equivalent.wavelength,
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
        "equilibrium_shift_m": equivalent.equilibrium,
        "flange_from_rad": plan.flange_from,
        "curve_radii_m": " ".join(f"{radius:.15g}" for radius in plan.curves),
    }
    names = [f"y={1e3 * y + 0.0:+.3f}mm" for y in place[part]]
    return Result(assemble({"pose": names, "amplitude": equivalent.amplitude}, channels, attributes))


def _counted(contact: RigidContact, roll: str) -> tuple[Array, Array]:
    """Shifts as the plan counts them, and the rolling radius difference there.

    On a steep flange the wheelset's centre goes back while its wheels go on: no shift beyond that has a difference.
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


@dataclass(frozen=True, eq=False)
class EquivalentConicity:
    """tan(gamma_e) and wavelength [m] over the amplitude [m], all (m,); not-a-number where the wheelset does not swing
    to and fro with that amplitude. equilibrium: lateral shift with equal rolling radii [m]."""

    amplitude: Array
    conicity: Array
    wavelength: Array
    equilibrium: float


def equivalent_conicity(
    shift: Array, radius_difference: Array, mean_radius: float, amplitude: ArrayLike
) -> EquivalentConicity:
    """Equivalent conicity of a rolling radius difference given at rising shifts (n,), linear in between.

    Not-a-number in ``radius_difference`` (a wheel off its rail) bounds the range. P is lowest at the equilibrium.
    """
    amplitude = np.atleast_1d(np.asarray(amplitude, dtype=float))
    nothing = np.full(amplitude.shape, np.nan)
    known = np.ma.flatnotmasked_contiguous(np.ma.masked_invalid(radius_difference))
    part = max(known, key=lambda interval: interval.stop - interval.start, default=slice(0, 0))
    y, rate = shift[part], radius_difference[part] / (CONTACT_DISTANCE * mean_radius)
    if y.size < 3:
        return EquivalentConicity(amplitude, nothing, nothing, np.nan)
    slope = np.diff(rate) / np.diff(y)
    potential = PPoly(np.array([slope, rate[:-1]]), y).antiderivative()
    # P is lowest at an end of the range or where the rate crosses zero upwards
    crossing = np.flatnonzero((rate[:-1] <= 0.0) & (rate[1:] > 0.0))
    places = y[crossing] - rate[crossing] / slope[crossing]
    bottom = float(places[np.argmin(potential(places))]) if places.size else np.nan
    wavelength = np.array([_wavelength(potential, bottom, a) for a in amplitude])
    conicity = (2.0 * np.pi / wavelength) ** 2 * 0.5 * CONTACT_DISTANCE * mean_radius
    return EquivalentConicity(amplitude, conicity, wavelength, bottom)


def _wavelength(potential: PPoly, bottom: float, amplitude: float) -> float:
    """Wavelength of the swing of this amplitude about the bottom of the potential P; not-a-number without one."""
    low = max(bottom - 2.0 * amplitude, float(potential.x[0]))
    high = min(bottom, float(potential.x[-1]) - 2.0 * amplitude)

    def unbalance(start: float) -> float:
        return float(potential(start + 2.0 * amplitude) - potential(start))

    if not low < high or unbalance(low) > 0.0 or unbalance(high) < 0.0:
        return np.nan
    start = brentq(unbalance, low, high, xtol=1e-16)
    angle = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    left = 2.0 * (potential(start) - potential(start + amplitude * (1.0 - np.cos(angle))))
    if (left <= 0.0).any():
        return np.nan
    return float(2.0 * np.pi / POINTS * np.sum(amplitude * np.sin(angle) / np.sqrt(left)))
