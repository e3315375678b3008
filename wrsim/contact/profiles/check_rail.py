"""Check rails: a rail as laid with one beside its gauge side; wheels whose back ends before a guard face.

The shape of the check rail is ours, but for flangeway and height: top, corner, a working face of 6:1, root and a level
floor, as in ``models/rails/60E1_check.toml``.
"""

from dataclasses import replace

import numpy as np

from wrsim.contact.profiles.flange import FLANGE_FROM
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.profiles.sections import Chain, profile_from_sections
from wrsim.errors import InputError

FACE = float(np.arctan(6.0))  # slope of the working face, which leans away from the running rail [rad]
TOP, CORNER, ROOT = 30e-3, 8e-3, 6e-3  # width of the check rail's top, radii above and below its face [m]
FLOOR = 48e-3  # depth of the flangeway's floor [m]: below the tip of a worn flange (36 mm) on a worn rail
LARGEST_ROLL = 10e-3
"""Roll of a wheelset against its rails that no contact on the back of its flange goes beyond [rad]: 15 mm between the
heights of both treads, half of a flange."""
INSIDE = 0.5e-3
"""How far inside of its end a profile has to be so steep [m]: a contact 0.7 mm (with the roll) inside of the end of a
back of 20.5 mm loses less than 2 % of 50 kN by what lies beyond."""


def with_check_rail(rail: Profile, flangeway: float, height: float) -> Profile:
    """A rail as laid with a check rail.

    flangeway: distance of the working face from the gauge point, at its depth [m]; height: of the check rail's top
    above that of the rail [m]. Raises InputError where they leave no room.
    """
    top, (u, w) = rail.top[1], rail.gauge_point()
    depth = FLOOR - 2.0 * ROOT
    if rail.w[rail.arclength <= rail.top_arclength].min() < top - depth:
        rail = rail.clipped(float(rail.gauge_arclength(depth)), rail.length)
    side, (end_u, end_w) = float(rail.angle[0]), (float(x) for x in rail.at(0.0))
    # where the arcs of the floor end
    foot, root = (top - FLOOR + ROOT * (1.0 - np.cos(angle)) for angle in (side, FACE))
    foot_u = end_u - (end_w - foot) / np.tan(side)
    corner = top + height - CORNER * (1.0 - np.cos(FACE))
    corner_u, root_u = (u - flangeway - (level - w) / np.tan(FACE) for level in (corner, root))
    floor = foot_u - ROOT * np.sin(side) - root_u - ROOT * np.sin(FACE)
    if floor <= 0.0 or corner <= root:
        place = f"{1e3 * flangeway:g} mm beside it and {1e3 * height:g} mm above it"
        raise InputError(f"rail '{rail.name}' has no room for a check rail {place}")
    chain = Chain(corner_u - CORNER * np.sin(FACE) - TOP, top + height)
    chain.line(chain.u + TOP, chain.w)
    chain.arc(CORNER, 0.0, -FACE)
    chain.line(root_u, root)
    chain.arc(ROOT, -FACE, 0.0)
    chain.line(chain.u + floor, chain.w)
    chain.arc(ROOT, 0.0, side)
    chain.line(end_u, end_w)
    name = f"{rail.name}, check rail at {1e3 * flangeway:g} mm"
    whole = rail.preceded(profile_from_sections(rail.name, "rail", chain.sections))
    return replace(whole, name=name, source=f"{rail.source}; check rail: assumed")


def floor_of(rail: Profile) -> float:
    """Arclength of the middle of the floor between check rail and head [m]."""
    level = rail.arclength[(rail.arclength < rail.head) & (rail.w < rail.w[rail.arclength < rail.head].min() + 1e-6)]
    return 0.5 * float(level[0] + level[-1])


def ends_before_its_back(wheel: Profile, rail: Profile, offset: float) -> str:
    """How a flange ends less steep than a guard face that its back may touch; empty if it does not.

    The back of a flange bulges: it touches a face where it is as steep. offset: of the rail's origin on the wheel's
    profile of a centred wheelset [m].
    """
    tip, steep, inside = int(np.argmin(wheel.w)), -float(wheel.angle[0]), -float(wheel.slope_angle(INSIDE))
    guard = rail.angle[rail.u + offset < min(float(wheel.u[tip]), 0.0)]
    if float(wheel.angle[tip:].max()) < FLANGE_FROM or not guard.size:
        return ""
    face = -float(guard.min())
    if face < FLANGE_FROM or inside >= face + LARGEST_ROLL or steep > 0.5 * np.pi - LARGEST_ROLL:
        return ""
    needs = f"a guard face of {np.degrees(face):.1f} degrees and needs {np.degrees(face + LARGEST_ROLL):.1f} there"
    return (
        f"wheel profile '{wheel.name}' ends before the flange back, at u = {1e3 * wheel.u[0]:.2f} mm with a slope of "
        f"{np.degrees(steep):.1f} degrees ({np.degrees(inside):.1f} half a millimetre before); "
        f"rail '{rail.name}' has {needs}"
    )
