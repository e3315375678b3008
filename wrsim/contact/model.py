"""The contact model of one wheel on one rail: names and checks the choices, runs the kernel, labels the results."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from math import tan

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.contact.creep_coefficients import creep_coefficients
from wrsim.contact.settings import MOST_FREE_STRIPS, ContactSettings, Friction, Tangential
from wrsim.core.contact import layout as k
from wrsim.core.contact.search.points import FOUND_COLUMNS
from wrsim.core.contact.strips.layout import FACTOR, FACTORS, FEWEST_FREE_STRIPS, LOBE_ROWS, MATRICES, VECTORS
from wrsim.core.contact.wheel_rail import wheel_rail
from wrsim.geometry.profile.distance_field import DistanceField, distance_field
from wrsim.geometry.profile.profile import Profile

Array = NDArray[np.float64]

TABLE_STEP = 0.1e-3  # of the profile tables [m]
SEARCH_REACH = 0.75e-3  # distance of the search's samples near the rail [m]
EPSILON = 0.55  # [S 23]
MOST_STRIPS = 2000
TANGENTIAL: dict[Tangential, int] = {
    "none": k.NO_CREEP_FORCES,
    "fastsim": k.FASTSIM,
    "fastrip": k.FASTRIP,
    "polach": k.POLACH,
    "linear": k.LINEAR,
    "shen-hedrick-elkins": k.SHEN_HEDRICK_ELKINS,
    "half-space": k.NO_CREEP_FORCES,  # not the kernel's: contact.half_space
}
LEAST_SPEED = 0.05  # rolling speed below which creepages are regularised [m/s]


@dataclass(frozen=True)
class ContactModel:
    """One wheel profile on one (inclined) rail profile with the chosen settings, ready for the kernel.

    wheel, rail: profiles, the rail already inclined; radius: of the wheel at the tape circle [m]; friction: of this
    rail. The arrays are what the kernel takes; scratch arrays belong to the model, so one model serves one thread.
    """

    wheel: Profile
    rail: Profile
    radius: float
    settings: ContactSettings
    friction: Friction
    arrays: KernelArrays = field(repr=False, compare=False)

    @classmethod
    def build(
        cls, wheel: Profile, rail: Profile, radius: float, settings: ContactSettings, friction: float | Friction
    ) -> ContactModel:
        """Prepare tables and scratch. The rail profile is given with its inclination."""
        law = Friction.of(friction)
        return cls(wheel, rail, radius, settings, law, _arrays(wheel, rail, radius, settings, law))

    def fast(self) -> ContactModel:
        """The same wheel on the same rail with `ContactSettings.fast`, in arrays of its own."""
        return ContactModel.build(self.wheel, self.rail, self.radius, self.settings.fast(), self.friction)

    def evaluate(
        self,
        origin: ArrayLike,
        axle: ArrayLike = (0.0, 1.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        omega: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Contact:
        """Contact for one pose.

        origin: wheel profile origin on the axle; axle: unit vector outward; velocity of that origin; omega: angular
        velocity; all (3,) in rail axes (t, o, b) of this side, m and rad; see docs/conventions.md.
        """
        a = self.arrays
        a.pose[:] = np.concatenate([np.asarray(x, dtype=float) for x in (origin, axle, velocity, omega)])
        return Contact.copy_from(a, self.solve())

    def solve(self) -> int:
        """Contact at the pose set in the arrays, written into them; returns the status."""
        if self.settings.normal == "half-space":
            from wrsim.contact.half_space.strips import solve_into  # which builds on this module

            return solve_into(self).status
        return self.arrays.call()


@dataclass(frozen=True)
class KernelArrays:
    """Arguments of `core.contact.wheel_rail.wheel_rail`, in its order."""

    wheel: Array
    rail: Array
    field: Array
    creep: Array
    shape: Array
    settings: Array
    pose: Array
    found: Array
    patches: Array
    strips: Array
    work: Array
    vectors: Array
    matrices: Array
    total: Array

    def arguments(self) -> tuple[Array, ...]:
        """All arrays, in the kernel's order."""
        return (
            self.wheel, self.rail, self.field, self.creep, self.shape, self.settings, self.pose, self.found,
            self.patches, self.strips, self.work, self.vectors, self.matrices, self.total,
        )  # fmt: skip

    def follow(self, on: bool, sharp: bool = False) -> None:
        """From now on the strip model starts from the contact asked for last (in runs), or afresh each time.

        sharp: first afresh, then from the last one, and always as sharply as afresh.
        """
        self.settings[k.WARM] = (2.0 if sharp else 1.0) if on else 0.0
        if sharp:
            self.patches[:, k.WARM_STRIPS] = 0.0

    def memory(self) -> Array:
        """Everything that one call leaves for the next, one row: the strip model's last contact, if it follows it."""
        if not (self.settings[k.STRIP_MODEL] and self.settings[k.WARM]):
            return np.zeros(0)
        return np.concatenate([part.ravel() for part in self._kept()])

    def recall(self, memory: Array) -> int:
        """Put back what ``memory`` gave at the front of a longer row; returns how much of it that was."""
        place = 0
        if self.settings[k.STRIP_MODEL] and self.settings[k.WARM]:
            for part in self._kept():
                part[...] = memory[place : place + part.size].reshape(part.shape)
                place += part.size
        return place

    def _kept(self) -> tuple[Array, ...]:
        """Views on the strip model's last contact."""
        return (
            self.patches[:, k.WARM_STRIPS : k.WARM_END + 1],
            self.strips[:, :, k.WARM_A],
            self.vectors[FACTOR, : FACTORS * len(self.patches)],
        )

    def call(self) -> int:
        """Run the kernel on the pose that is set; returns its status."""
        return int(wheel_rail(*self.arguments()))


@dataclass(frozen=True)
class Contact:
    """What one evaluation gave, copied out of the kernel.

    force, moment: on the wheel, (3,) in rail axes, the moment about the wheel's profile origin [N, N m];
    patches: (n, PATCH_COLUMNS), largest approach first; strips: one (n_strips, STRIP_COLUMNS) array per patch;
    wear_number: T-gamma [N]; closest: smallest distance between the profiles met, negative in contact [m].
    """

    force: Array
    moment: Array
    patches: Array
    strips: tuple[Array, ...]
    wear_number: float
    closest: float
    status: int

    @classmethod
    def copy_from(cls, a: KernelArrays, status: int) -> Contact:
        """Copy the present results out of the kernel's arrays."""
        n = int(a.total[k.COUNT])
        return cls(
            a.total[:3].copy(),
            a.total[3:6].copy(),
            a.patches[:n].copy(),
            tuple(a.strips[i, : int(a.patches[i, k.N_STRIPS])].copy() for i in range(n)),
            float(a.total[k.WEAR]),
            float(a.total[k.CLOSEST]),
            status,
        )

    @property
    def normal_force(self) -> float:
        """Sum of the strips' normal forces over all patches [N]."""
        return float(self.patches[:, k.N].sum())


@lru_cache(maxsize=16)
def _cached_field(rail: Profile) -> DistanceField:
    return distance_field(rail)


@lru_cache(maxsize=32)
def _cached_table(profile: Profile) -> tuple[Array, float]:
    table, step = profile.table(TABLE_STEP)
    return np.ascontiguousarray(table), step


def combined_modulus(settings: ContactSettings) -> float:
    """E* = 1 / ((1 - nu_w^2)/E_w + (1 - nu_r^2)/E_r) [Pa]."""
    compliance = sum((1.0 - m.poisson_ratio**2) / m.youngs_modulus for m in (settings.wheel, settings.rail))
    return 1.0 / compliance


def bound_over_cells(cells: int, parabolic: bool) -> Array:
    """Mean of sqrt(1 - X^2) (or 1 - X^2) over each of the cells of -1 < X < 1, from the leading edge on."""
    x = np.linspace(1.0, -1.0, cells + 1)
    if parabolic:
        primitive = x - x**3 / 3.0
    else:
        primitive = 0.5 * (x * np.sqrt(np.maximum(1.0 - x**2, 0.0)) + np.arcsin(x))
    return np.ascontiguousarray((primitive[:-1] - primitive[1:]) / (x[:-1] - x[1:]))


def _arrays(
    wheel: Profile, rail: Profile, radius: float, settings: ContactSettings, friction: Friction
) -> KernelArrays:
    wheel_table, wheel_step = _cached_table(wheel)
    rail_table, rail_step = _cached_table(rail)
    field_ = _cached_field(rail)
    # FaStrip knows no other bound than the pressure's
    parabolic = settings.traction_bound == "parabolic" and settings.tangential == "fastsim"
    # Kalker's combined elastic constants: means of the compliances
    shear_compliance = 0.5 * sum(1.0 / m.shear_modulus for m in (settings.wheel, settings.rail))
    poisson = 0.5 * sum(m.poisson_ratio / m.shear_modulus for m in (settings.wheel, settings.rail)) / shear_compliance
    numbers = np.zeros(k.SETTINGS)
    numbers[k.MODULUS] = combined_modulus(settings)
    numbers[k.SHEAR_MODULUS] = 1.0 / shear_compliance
    numbers[k.EPSILON] = EPSILON
    numbers[k.PROJECTED] = settings.approach == "projected"
    numbers[k.DAMPING] = settings.damping
    numbers[k.FRICTION] = friction.static
    numbers[k.FRICTION_GAUGE] = friction.at_corner
    numbers[k.ZONE_START], numbers[k.ZONE_END] = (tan(0.5 * angle) for angle in friction.ramp)
    numbers[k.FALL_RATIO] = friction.falling_ratio
    numbers[k.FALL_DECAY] = friction.falling_decay
    numbers[k.BLENDED] = settings.flexibility == "blended"
    numbers[k.ADHESION_FACTOR] = settings.polach_adhesion
    numbers[k.SLIP_FACTOR] = settings.polach_slip
    numbers[k.PARABOLIC] = parabolic
    numbers[k.STRIPS] = settings.strips or 0
    numbers[k.STRIP_WIDTH] = settings.strip_width or 0.0
    numbers[k.TANGENTIAL] = TANGENTIAL[settings.tangential]
    numbers[k.LEAST_SPEED] = LEAST_SPEED
    numbers[k.WHEEL_STEP] = wheel_step
    numbers[k.RADIUS] = radius
    numbers[k.RAIL_STEP] = rail_step
    numbers[k.FIELD_O], numbers[k.FIELD_B] = field_.origin
    numbers[k.FIELD_SPACING] = field_.spacing
    numbers[k.STRIDE] = max(1, round(SEARCH_REACH / wheel_step))
    # yaw makes the outline a little more hollow than the profile, distance the rail's curves of equal distance
    hollows = max(float(-wheel_table[:, 4].min()), 0.0) + max(float(rail_table[:, 4].max()), 0.0)
    numbers[k.HOLLOW] = max(1.5 * hollows, 1.0)
    most = settings.strips if settings.strips is not None and settings.normal != "half-space" else MOST_STRIPS
    if settings.normal == "strips":
        most = min(max(most, FEWEST_FREE_STRIPS), MOST_FREE_STRIPS)
    together = settings.max_patches * (most + FACTORS) if settings.normal == "strips" else 1
    numbers[k.STRIP_MODEL] = settings.normal == "strips"
    return KernelArrays(
        wheel_table,
        rail_table,
        field_.values,
        creep_coefficients(poisson),
        bound_over_cells(settings.cells, parabolic),
        numbers,
        np.zeros(k.POSE),
        np.zeros((8, FOUND_COLUMNS)),
        np.zeros((settings.max_patches, k.PATCH_COLUMNS)),
        np.zeros((settings.max_patches, most, k.STRIP_COLUMNS)),
        np.zeros((12, max(most, 8))),
        np.zeros((VECTORS + 1 + LOBE_ROWS, max(together, settings.max_patches))),
        np.zeros((MATRICES, together, together)),
        np.zeros(k.TOTAL),
    )
