"""Tables of a vehicle file on its wheelsets, in the user's units; and a wheelset with other wheels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, ClassVar

from pydantic import Field

from wrsim.geometry.profile.profile import Profile
from wrsim.inputs.section import Fault, Section, both_or_sides, given
from wrsim.inputs.values import Switch, Three, number, positive, text, words
from wrsim.vehicle.wheelset import Torsion, Wheel, Wheelset

Radius = Annotated[float, number(100, 1500, "radius at the tape circle in mm, such as 460")]
WheelName = Annotated[str, text('a wheel profile file such as "wheels/S1002.toml"')]
Springs = Annotated[
    Three[Annotated[float, number(0, 1e9)]],
    Field(description="three numbers not below 0: along x (forward), y (lateral), z (vertical)"),
]


class WheelsetTable(Section):
    """[wheelset]: the body and its two wheels, rigid, independent or on an axle that twists.

    Wheels that turn against each other have half of spin_inertia_kg_m2 each.
    """

    header: ClassVar[str] = "[wheelset]"
    aliases: ClassVar[dict[str, str]] = {
        "wheel": "profile wheel_profile",
        "roll_inertia_kg_m2": "ixx_kg_m2",
        "spin_inertia_kg_m2": "iyy_kg_m2 pitch_inertia_kg_m2",
        "yaw_inertia_kg_m2": "izz_kg_m2",
        "flange_back_mm": "back_to_back_mm",
    }

    mass_kg: Annotated[float, positive(20_000, "kg")]
    """Mass of the wheelset."""
    roll_inertia_kg_m2: Annotated[float, positive(1e5, "about the x axis")]
    """Moment of inertia about the track's direction."""
    spin_inertia_kg_m2: Annotated[float, positive(1e5, "about the axle")]
    """Moment of inertia about the axle."""
    yaw_inertia_kg_m2: Annotated[float, positive(1e5, "about the z axis")]
    """Moment of inertia about the vertical; equal to that of roll."""
    profile_spacing_mm: Annotated[float, number(400, 2500, "mm between the tape circles")] | None = None
    """Distance between the tape circles, on which the wheel profiles have their origins."""
    flange_back_mm: Annotated[float, number(300, 2400, "mm between the flange backs")] | None = None
    """Distance between the flange backs, in place of profile_spacing_mm."""
    back_to_tape_circle_mm: Annotated[float, number(20, 120, "mm, 70 in Europe")] = 70.0
    """Distance of the tape circle from the flange back."""
    wheel: WheelName | None = None
    """Profile of both wheels."""
    wheel_left: WheelName | None = None
    """Profile of the left wheel."""
    wheel_right: WheelName | None = None
    """Profile of the right wheel."""
    radius_mm: Radius | None = None
    """Rolling radius of both wheels at the tape circle."""
    radius_left_mm: Radius | None = None
    """Rolling radius of the left wheel."""
    radius_right_mm: Radius | None = None
    """Rolling radius of the right wheel."""
    independent_wheels: Switch = False
    """Whether each wheel turns on its own, with half of the spin inertia."""
    torsional_stiffness_kNm_per_rad: Annotated[float, positive(1e7, "between the wheels, some 5000")] | None = None
    """Stiffness of the axle between its two wheels in spin; rigid where it is not given."""
    torsional_damping_kNms_per_rad: Annotated[float, number(0, 1e5, "beside the stiffness")] | None = None
    """Damping of the axle between its two wheels in spin."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """A value for both wheels or one for each; the spacing in one of two ways."""
        yield from both_or_sides(raw, "wheel", needed=words(WheelName))
        yield from both_or_sides(raw, "radius_mm", needed=words(Radius))
        if "flange_back_mm" in raw and "profile_spacing_mm" in raw:
            yield Fault("flange_back_mm", "cannot stand next to profile_spacing_mm: give one of them")
        elif "flange_back_mm" not in raw and "profile_spacing_mm" not in raw:
            needed = "must be a distance in mm between the tape circles (or give flange_back_mm)"
            yield Fault("profile_spacing_mm", needed, missing=True)
        if raw.get("independent_wheels") and "torsional_stiffness_kNm_per_rad" in raw:
            message = "cannot stand next to independent_wheels = true, which have no axle between them"
            yield Fault("torsional_stiffness_kNm_per_rad", message)
        elif "torsional_damping_kNms_per_rad" in raw and "torsional_stiffness_kNm_per_rad" not in raw:
            yield Fault("torsional_damping_kNms_per_rad", "goes with torsional_stiffness_kNm_per_rad")
        if "back_to_tape_circle_mm" in raw and "flange_back_mm" not in raw:
            yield Fault("back_to_tape_circle_mm", "is for use with flange_back_mm only")

    def consistency(self) -> Iterator[Fault]:
        """A wheelset is a body of revolution: it spins about its axle."""
        roll, spin, yaw = self.roll_inertia_kg_m2, self.spin_inertia_kg_m2, self.yaw_inertia_kg_m2
        if abs(roll - yaw) > 1e-6 * yaw:
            message = f"must equal yaw_inertia_kg_m2 = {yaw:g}, for a wheelset spins about its axle (take their mean)"
            yield Fault("roll_inertia_kg_m2", message)
        elif spin > 2.0 * yaw:
            message = f"must be at most twice yaw_inertia_kg_m2 = {yaw:g}: no solid has more"
            yield Fault("spin_inertia_kg_m2", message)

    @property
    def torsion(self) -> Torsion | None:
        """How the wheels turn against each other; None if they do not."""
        if self.independent_wheels:
            return Torsion()
        if self.torsional_stiffness_kNm_per_rad is None:
            return None
        return Torsion(1e3 * self.torsional_stiffness_kNm_per_rad, 1e3 * (self.torsional_damping_kNms_per_rad or 0.0))

    @property
    def spacing(self) -> float:
        """Distance between the two profile origins [m]."""
        if self.flange_back_mm is not None:
            return (self.flange_back_mm + 2.0 * self.back_to_tape_circle_mm) / 1000.0
        return given(self.profile_spacing_mm) / 1000.0


class SuspensionTable(Section):
    """[suspension]: springs and dampers of each side to the frame that follows the track."""

    header: ClassVar[str] = "[suspension]"

    stiffness_kN_per_m: Springs = (0.0, 0.0, 0.0)
    """Stiffness of each side along x, y, z."""
    damping_kNs_per_m: Springs = (0.0, 0.0, 0.0)
    """Damping of each side along x, y, z."""
    half_spacing_mm: Annotated[float, positive(2000, "mm from the middle")] = 1000.0
    """Distance of the springs from the middle of the axle."""
    ahead_of_bogie_centre_mm: Annotated[
        float, number(-5000, 5000, "mm, half the wheelbase for a leading axle, negative for a trailing one")
    ] = 0.0
    """How far the wheelset is ahead of its bogie's centre: the frame turns so much in curves."""


class SprungTable(Section):
    """[sprung]: the share of the vehicle that this wheelset carries."""

    header: ClassVar[str] = "[sprung]"
    aliases: ClassVar[dict[str, str]] = {"height_above_axle_mm": "height_mm"}

    mass_kg: Annotated[float, number(0, 50_000, "kg")] = 0.0
    """Mass that presses on the axle without moving by itself."""
    height_above_axle_mm: Annotated[float, number(-1000, 5000, "mm of its centre above the axle")] = 0.0
    """Height of its centre, at which weight and centrifugal force act."""


def with_wheel(wheelset: Wheelset, side: str, profile: Profile | None, radius: float | None) -> Wheelset:
    """Return the wheelset with another profile or radius [m] on one side; None keeps what is there."""
    old = wheelset.left if side == "left" else wheelset.right
    new = Wheel(profile or old.profile, radius or old.radius)
    return replace(wheelset, left=new) if side == "left" else replace(wheelset, right=new)
