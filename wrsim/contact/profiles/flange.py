"""Dimensions of a wheel: flange thickness Sd, height Sh, qR for its steepness (EN 15313, UIC 510-2); tread hollow."""

from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from wrsim.contact.profiles.curves import Array
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.profiles.sections import Chain, profile_from_sections
from wrsim.errors import InputError

LEVEL = 10e-3  # depth below the tread at the tape circle at which thickness is measured [m]
TIP = 2e-3  # height above the tip of the flange of the other point of qR [m]
BACK = 70e-3  # distance of the flange back from the tape circle [m], EN 13715
ROUND = 5e-3, 100e-3  # radii of arcs that lead to the back: S1002 has 20.5 mm [m]
PLANE = 10e-3  # height of the back's plane that is added above the arc [m]
AS_STEEP = radians(0.1)  # angles of drawings are whole tenths of a degree: a flank is as steep as its steepest place
FLANGE_FROM = radians(40.0)  # contact angle from which a wheel counts as on its flange unless given otherwise [rad]


@dataclass(frozen=True)
class FlangeDimensions:
    """thickness Sd: from the flange back to the face, 10 mm below the tread at the tape circle; height Sh: from that
    tread to the tip; steepness qR: across, from the same point of the face to that 2 mm above the tip [m]."""

    thickness: float
    height: float
    steepness: float


def flange_dimensions(wheel: Profile, back: float | None = None) -> FlangeDimensions:
    """Sd, Sh and qR of a wheel profile; back: distance of the flange back from the tape circle [m], by default that of
    the profile or 70 mm.

    Raises InputError for a profile without a flange or without a face at these heights.
    """
    tread = float(wheel.at(wheel.arclength_of(0.0))[1])
    tip = int(np.argmin(wheel.w))
    height = tread - float(wheel.w[tip])
    if wheel.u[tip] >= 0.0 or height < LEVEL + TIP:
        raise InputError(f"profile '{wheel.name}' has no flange that could be measured")
    face = _face_at(wheel, tip, tread - LEVEL)
    near_tip = _face_at(wheel, tip, float(wheel.w[tip]) + TIP)
    return FlangeDimensions(face + (back or wheel.back or BACK), height, face - near_tip)


def with_back(wheel: Profile, back: float) -> Profile:
    """A wheel whose profile ends before the back of its flange, with an arc from its end to the plane of the back,
    ``back`` from the tape circle [m], and 10 mm of that. Raises InputError where no arc leads there."""
    steep, gap = -float(wheel.angle[0]), float(wheel.u[0]) + back
    radius = gap / (1.0 - np.sin(steep)) if 0.0 < steep < 0.5 * np.pi else 0.0
    if not ROUND[0] <= radius <= ROUND[1]:
        fact = f"profile '{wheel.name}' ends {1e3 * gap:.4g} mm before it with a slope of {degrees(steep):.4g} degrees"
        bound = "{:g} to {:g} mm".format(*(1e3 * r for r in ROUND))
        raise InputError(f"flange_back_mm = {1e3 * back:g}: {fact}; no arc with a radius of {bound} leads there")
    chain = Chain(-back, float(wheel.w[0]) + radius * np.cos(steep) + PLANE)
    chain.line(-back, chain.w - PLANE)
    chain.arc(radius, -0.5 * np.pi, -steep)
    return wheel.preceded(profile_from_sections(wheel.name, "wheel", chain.sections))


def _face_at(wheel: Profile, tip: int, level: float) -> float:
    """Lateral place at which the face, coming from the tip, passes a height [m]."""
    beyond = np.flatnonzero(wheel.w[tip:] >= level)
    if not beyond.size:
        raise InputError(f"profile '{wheel.name}': its flange has no face at {1e3 * level:.4g} mm")
    arc = wheel.root_in_interval(1, np.array(level), np.array(tip + int(beyond[0]) - 1))
    return float(wheel.at(arc)[0])


def tread_hollow(wheel: Profile) -> float:
    """Depth of the hollow: how far the tread's outer part lies nearer to the rail than the tread between it and the
    flange, at most [m]; zero where the profile rises from the tip of the flange to the field side, as new ones do."""
    w = wheel.w[int(np.argmin(wheel.w)) :]
    return float((np.maximum.accumulate(w) - w).max())


@dataclass(frozen=True)
class Flank:
    """The steepest part of a flange's face and what follows towards its tip.

    angle: largest angle of the face against the axle [rad]; arcs, angles (n,): arclengths on the profile from where it
    is reached first, coming from the tread, to the tip [m, falling], and the angles there [rad].
    """

    angle: float
    arcs: Array
    angles: Array

    @property
    def end(self) -> float:
        """Arclength on the profile at which the steepest part ends, towards the tip [m]."""
        return self.place(self.angle - 2.0 * AS_STEEP)

    def place(self, angle: float) -> float:
        """Arclength on the profile at which the angle has fallen to this one to the tip [m]. Raises InputError."""
        if not (below := self.angles <= angle).any():
            raise InputError(f"the profile ends before its flange is as flat as {degrees(angle):.1f} degrees")
        beyond = int(np.argmax(below))
        return float(np.interp(angle, self.angles[[beyond, beyond - 1]], self.arcs[[beyond, beyond - 1]]))

    def length(self, angle: float) -> float:
        """Way on the profile from the begin of the steepest part to where the angle has fallen to this one [m]."""
        return float(self.arcs[0]) - self.place(angle)


def flank_of(wheel: Profile) -> Flank:
    """The flank of a wheel. Raises InputError for a profile without a flange, from its face to its tip."""
    tip = int(np.argmin(wheel.w))
    arcs = np.linspace(float(wheel.arclength_of(0.0)), float(wheel.arclength[tip]), 4001)
    angles = wheel.slope_angle(arcs)
    steepest = float(angles.max())
    if wheel.u[tip] >= 0.0 or steepest < FLANGE_FROM:
        raise InputError(f"profile '{wheel.name}' has no flange that a wheel could climb")
    first = int(np.argmax(angles >= steepest - AS_STEEP))
    return Flank(steepest, arcs[first:], angles[first:])
