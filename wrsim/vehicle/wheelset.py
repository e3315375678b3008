"""A wheelset with its suspension to a track-following frame: plain data, SI units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wrsim.geometry.profile.profile import Profile

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s2]."""


@dataclass(frozen=True)
class Wheel:
    """One wheel: its profile and the radius at the tape circle [m]."""

    profile: Profile
    radius: float


@dataclass(frozen=True)
class Suspension:
    """Springs and viscous dampers between the wheelset and the track-following frame, one set at each side.

    Stiffness [N/m] and damping [N s/m] along x (track), y (lateral), z (vertical) of each of the two sets, which
    sit at ``+-half_spacing`` [m] from the centre of mass. Yaw and roll stiffness follow from the spacing:
    ``2 kx half_spacing**2`` and ``2 kz half_spacing**2``.

    ahead_of_bogie_centre: where the axle sits in a bogie [m]; 0 for one that steers itself. In a curve of curvature
    kappa a bogie stands along the chord, so its leading axle is held at an angle of attack of -ahead kappa.
    """

    stiffness: tuple[float, float, float] = (0.0, 0.0, 0.0)
    damping: tuple[float, float, float] = (0.0, 0.0, 0.0)
    half_spacing: float = 1.0
    ahead_of_bogie_centre: float = 0.0


@dataclass(frozen=True)
class SprungMass:
    """What the wheelset carries: a mass [kg] that follows the track frame at a height [m] above the axle.

    Its weight and its centrifugal force press on the wheelset; the height gives the load transfer in curves.
    The mass does not oscillate: it is the quasi-static load of a vehicle without the vehicle.
    """

    mass: float = 0.0
    height: float = 0.0


@dataclass(frozen=True)
class Wheelset:
    """A rigid wheelset.

    mass [kg]; inertia about the centre of mass (roll, pitch/spin, yaw) [kg m2]; profile_spacing: distance H between
    the two wheel profile origins [m]; constant_force: extra force (x, y, z) at the centre of mass in the track frame
    [N].
    """

    name: str
    mass: float
    inertia: tuple[float, float, float]
    profile_spacing: float
    left: Wheel
    right: Wheel
    suspension: Suspension = field(default_factory=Suspension)
    sprung: SprungMass = field(default_factory=SprungMass)
    constant_force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    source: str = ""

    @property
    def mean_radius(self) -> float:
        """Mean of the two tape-circle radii [m]."""
        return 0.5 * (self.left.radius + self.right.radius)

    @property
    def static_axle_load(self) -> float:
        """Vertical force on the rails at rest on level track [N]."""
        return (self.mass + self.sprung.mass) * STANDARD_GRAVITY - self.constant_force[2]
