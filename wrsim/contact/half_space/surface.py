"""The curved reference surface of a patch and elements on it: the shell of contact.half_space.surface_kernel."""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.contact_angle import contact_angles
from wrsim.contact.half_space import surface_kernel as surface
from wrsim.contact.model import ContactModel
from wrsim.contact.records import PlacedWheel, Rail, WheelPose
from wrsim.contact.surfaces.rail_surface import RailSurface
from wrsim.contact.wheel_rail import place_bodies
from wrsim.jit import Array

Rows = NDArray[np.void]
"""Rows of contact.half_space.surface_kernel.AXIS."""


@dataclass(frozen=True)
class Bodies:
    """Wheel and rail at a pose, as kernels take them; of a rail that changes along the track its surface, and the
    distance along it where x counts from [m]. All in axes turned in plan, about ``about`` [m], by the angle with that
    sine."""

    wheel: PlacedWheel
    rail: Rail
    pose: WheelPose
    surface: RailSurface | None
    place: float
    sine: float
    about: float

    @classmethod
    def of(cls, model: ContactModel) -> "Bodies":
        """At the pose set in a model's arrays."""
        surface = None if model.rolled is None else model.rolled.surface
        wheel, rail, pose = place_bodies(model.arrays.rows)
        call = model.arrays.inputs
        return cls(wheel, rail, pose, surface, *(float(call[name]) for name in ("place", "sine", "about")))

    @property
    def changes(self) -> bool:
        """Whether the rail's section changes along x: of such a rail, and of a roller."""
        return self.surface is not None or self.rail.roller > 0.0

    def roller_velocity(self, arms: Array) -> Array:
        """Of a roller's material against a rail's, at places that far from the wheel's origin (3, ...) [m/s]."""
        rate = self.rail.roller * self.pose.velocity.x
        x, _o, b = arms + np.reshape(self.pose.origin, (3, *(1,) * (arms.ndim - 1)))
        return np.stack((-rate * b, 0.0 * x, rate * x))

    def sections(self, x: Array, out: float) -> tuple[Array, NDArray[np.int64]]:
        """`RailSurface.rows` at x (n,), seen along the axes; out: about where they are of use [m]."""
        if self.surface is None:
            u, w, tu, tw = self.rail.table[:, :4].T
            sine = x[:, None] * self.rail.roller / (1.0 + w * self.rail.roller)
            cosine = np.sqrt(1.0 - sine**2)
            rows = np.stack(np.broadcast_arrays(u, w - x[:, None] * sine / (1.0 + cosine), tu, tw / cosine), axis=-1)
            return np.ascontiguousarray(rows), np.array([0, u.size])
        cosine = sqrt(1.0 - self.sine**2)
        way = (x - self.about) * cosine - out * self.sine
        rows, parts = self.surface.rows(self.place + self.about + way)
        rows[..., [0, 2]] *= cosine
        rows[..., 0] -= self.sine * way[:, None]
        return rows, parts

    def holds(self, rows: Rows) -> NDArray[np.bool_]:
        """Which rows of an axis lie on both profiles, not where these are continued straight."""
        on_wheel, on_rail, profile = rows["arc_wheel"], rows["arc_rail"], self.wheel.profile
        held = (on_wheel >= 0.0) & (on_wheel <= (len(profile.table) - 1) * profile.step)
        return held & (on_rail >= 0.0) & (on_rail <= (self.rail.rows - 1) * self.rail.step)


@dataclass(frozen=True)
class Axis:
    """The curved axis through a pair of opposite points; level: see contact.half_space.surface_kernel."""

    bodies: Bodies
    arc_wheel: float
    arc_rail: float
    level: bool

    def lay(self, step: float, first: int, last: int) -> Rows:
        """Rows first .. last at multiples of ``step`` from the main point (row 0)."""
        rows = np.zeros(last - first + 1, surface.AXIS)
        if last >= 0:
            inner = max(first, 0)
            self._walk(inner * step, step, rows[inner - first :])
        if first < 0:
            outer = min(last, -1)
            back = np.zeros(outer - first + 1, surface.AXIS)
            self._walk(outer * step, -step, back)
            rows[: len(back)] = back[::-1]
        return rows

    def _walk(self, start: float, step: float, rows: Rows) -> None:
        surface.build_axis(
            self.bodies.wheel, self.bodies.rail, self.arc_wheel, self.arc_rail, self.level, start, step, rows
        )
        if not self.bodies.changes:
            rows["slope"] = 0.0


@dataclass(frozen=True)
class Grid:
    """Elements dx x ds over a patch. bodies: at the pose; axis: (rows,); x: (columns,) centres along the rail [m];
    main: row of the main point."""

    bodies: Bodies
    axis: Rows
    x: Array
    dx: float
    ds: float
    main: int

    @cached_property
    def incline(self) -> surface.Incline:
        """Slope of the reference, that of the rail at the main point."""
        row = self.axis[self.main]
        return surface.Incline(float(row["slope"]), float(row["no"]), float(row["nb"]))

    @property
    def length(self) -> float:
        """Length of an element along the rail, which may be inclined [m]."""
        return self.dx * sqrt(1.0 + self.incline.slope**2)

    @property
    def cell(self) -> float:
        """Area of an element [m2]."""
        return self.length * self.ds

    @property
    def s(self) -> Array:
        """Curved axis at the rows' centres [m]."""
        return self.axis["s"]

    @cached_property
    def normal(self) -> Array:
        """Normals of the rows from rail to wheel (o, b), (rows, 2)."""
        return np.column_stack([self.axis["no"], self.axis["nb"]])

    @cached_property
    def axes(self) -> Array:
        """Directions (along the rail, across, normal) of the rows, (3, rows, 3) in rail axes."""
        no, nb, slope = (self.axis[name] for name in ("no", "nb", "slope"))
        ahead, upright = np.ones_like(slope), 1.0 / np.sqrt(1.0 + slope**2)
        along, normal = (ahead, slope * no, slope * nb), (-slope, no, nb)
        flat = (0.0 * no, nb, -no)
        return (
            np.stack([np.column_stack(d) for d in (along, flat, normal)])
            * np.stack([upright, ahead, upright])[..., None]
        )

    @cached_property
    def centre(self) -> Array:
        """Places of the rows in the rail's section (o, b), (rows, 2) [m]."""
        return np.column_stack([self.axis["o"], self.axis["b"]])

    @property
    def angle(self) -> Array:
        """Contact angle of the rows [rad]."""
        return contact_angles(self.axis["no"], self.axis["nb"])

    @property
    def pen(self) -> Array:
        """Interpenetration of the undeformed bodies along the rows' normals, (rows, columns) [m]."""
        return self._gap[0]

    @cached_property
    def _gap(self) -> Array:
        """Interpenetration, and distance along the normal from the reference to the wheel [m]."""
        gap = np.empty((2, len(self.axis), len(self.x)))
        bodies, x0 = self.bodies, float(self.x[0])
        if not bodies.changes:
            surface.fill_gap(bodies.wheel, bodies.rail, self.axis, x0, self.dx, gap[0], gap[1])
        else:
            rows, parts = bodies.sections(self.x, float(self.axis[self.main]["o"]))
            surface.fill_gap_along(bodies.wheel, rows, parts, self.incline, self.axis, x0, self.dx, gap[0], gap[1])
        return gap

    def arms(self, x: Array, height: Array) -> Array:
        """From the wheel's origin to places at x (columns,), that high above the reference along the rows' normals,
        (3, rows, columns) [m]."""
        origin, incline = self.bodies.pose.origin, self.incline
        rise = (x - self.axis["x"][:, None]) * incline.slope
        o, b = self.centre.T[:, :, None] + height * self.normal.T[:, :, None]
        o, b = o + rise * incline.no, b + rise * incline.nb
        return np.stack(np.broadcast_arrays(x - origin.x, o - origin.y, b - origin.z))

    def rigid_slip(self, least_speed: float, ahead: float) -> Array:
        """Creepages (2, rows, columns) that far ahead of the elements' centres [m].

        The velocity of the wheel's material against the rail's over the rolling speed, which is held above
        ``least_speed`` [m/s]. Both velocities, seen from the moving contact, are projected on the plane between them,
        as the material of the wheel runs along its curved surface: without that the slip would err by x^2 / (2 R^2).
        """
        pose = self.bodies.pose
        arms = self.arms(self.x + ahead, self._gap[1])
        u = np.reshape(pose.velocity, (3, 1, 1)) + np.cross(pose.omega, arms, axisb=0, axisc=0)
        # the rail's material comes at minus the wheel's speed along the rail, the wheel's at u less that
        speed, rising = pose.velocity.x, 0.0
        mean = -2.0 * speed
        if self.bodies.rail.roller > 0.0:
            of_roller = self.bodies.roller_velocity(self.arms(self.x + ahead, self._gap.sum(axis=0)))
            u = u - of_roller
            of_roller[0] -= speed
            mean, _, rising = 2.0 * np.einsum("drk,krc->drc", self.axes, of_roller)
        along, across, normal = np.einsum("drk,krc->drc", self.axes, u)
        mean = along + mean
        size = np.hypot(mean, normal + rising)
        turned = -np.copysign(1.0, speed) * (along * mean + normal * (normal + rising))
        turned /= np.where(size > 0.0, size, 1.0)
        slip = np.stack([np.where(size > 1e-3 * least_speed, turned, along), across])
        return slip / np.hypot(speed, least_speed)

    def at_row(self, row: float) -> dict[str, float]:
        whole = np.arange(len(self.axis))
        return {name: float(np.interp(row, whole, self.axis[name])) for name in surface.AXIS.names or ()}
