"""A wheelset: plain data, SI units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.contact.profiles.profile import Profile
    from wrsim.contact.surfaces.out_of_round import Part
    from wrsim.vehicle.axle import Axle

SAME_BACK = 0.05e-3
"""How far distances of the tape circle from the flange back may differ [m]: they are given in tenths of a mm."""
STANDARD_GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s2]."""


@dataclass(frozen=True)
class Wheel:
    """One wheel: its profile, the radius at the tape circle [m], and how it is out of round."""

    profile: Profile
    radius: float
    out_of_round: tuple[Part, ...] = ()


@dataclass(frozen=True)
class Torsion:
    """Torsional stiffness [N m/rad] and damping [N m s/rad] between the two wheels of a wheelset; 0 for independent
    wheels."""

    stiffness: float = 0.0
    damping: float = 0.0

    @property
    def independent(self) -> bool:
        return self.stiffness == 0.0


@dataclass(frozen=True)
class Wheelset:
    """A wheelset.

    mass [kg]; inertia about the centre of mass (roll, pitch/spin, yaw) [kg m2]; profile_spacing: distance H between
    the two wheel profile origins [m]; torsion: of an axle whose wheels turn against each other, each with half of the
    spin inertia; None: rigid; axle: an elastic one; None: rigid in bending; back: distance of the tape circle from the
    flange back that the spacing holds, if any [m]. Raises InputError for wheel profiles with another one.
    """

    name: str
    mass: float
    inertia: tuple[float, float, float]
    profile_spacing: float
    left: Wheel
    right: Wheel
    source: str = ""
    torsion: Torsion | None = None
    axle: Axle | None = None
    back: float | None = None

    def __post_init__(self) -> None:
        for wheel in (self.left.profile, self.right.profile):
            if self.back is not None and wheel.back is not None and abs(wheel.back - self.back) > SAME_BACK:
                apart = f"{1e3 * wheel.back:.6g} mm from its flange back, that of the wheelset {1e3 * self.back:.6g} mm"
                hint = f"set back_to_tape_circle_mm = {1e3 * wheel.back:.6g}"
                raise InputError(f"the tape circle of profile '{wheel.name}' is {apart}: {hint}")

    @property
    def independent(self) -> bool:
        """True if each wheel turns on its own."""
        return self.torsion is not None and self.torsion.independent

    @property
    def mean_radius(self) -> float:
        """Mean of the two tape-circle radii [m]."""
        return 0.5 * (self.left.radius + self.right.radius)

    def with_wheel(self, side: str, profile: Profile | None, radius: float | None) -> Wheelset:
        """The same with another profile or radius [m] on one side; None: unchanged."""
        old = self.left if side == "left" else self.right
        new = replace(old, profile=profile or old.profile, radius=radius or old.radius)
        return replace(self, left=new) if side == "left" else replace(self, right=new)
