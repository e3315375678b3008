"""The arrays of elastic bodies and axles for their kernel (``dynamics.flexible``), and their attachments."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.simulation.force_law import Array
from wrsim.track.bridge import Bridge
from wrsim.vehicle.dynamics import flexible, vehicle_forces
from wrsim.vehicle.elements import Triple
from wrsim.vehicle.flexible import Modes
from wrsim.vehicle.preload import Preload
from wrsim.vehicle.vehicle import Vehicle


def mode_records(modes: Modes | Bridge, coordinate: int) -> NDArray[Any]:
    """Records MODE (n,) of modes whose coordinates follow each other; of a bridge they are whole."""
    rows, omega = np.zeros(len(modes.frequencies), flexible.MODE), 2.0 * np.pi * modes.frequencies
    rows["stiffness"], rows["damping"], rows["mass"] = omega**2, 2.0 * modes.damping * omega, modes.masses
    rows["coordinate"] = coordinate + np.arange(len(rows))
    return rows


class Attachments:
    """Points of elastic parts that suspension elements, axle boxes and wheels hold on to; one number for each point.

    ``modes``: of the elastic parts, by their numbers; ``count``: of all modes; ``wheels``: number of the attachment of
    the left wheel of every elastic axle, behind which the right one follows.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        parts = enumerate(vehicle.parts)
        self.vehicle = vehicle
        self.modes: dict[int, Modes] = {i: part.modes for i, part in parts if part.modes is not None}
        counts = [len(modes.frequencies) for modes in self.modes.values()]
        self.first = dict(zip(self.modes, np.cumsum([0, *counts]).tolist(), strict=False))
        self.count = sum(counts)
        self._points: list[tuple[int, Triple]] = []
        self._behind = len(vehicle.parts) + vehicle_forces.FRAMES + len(vehicle.boxes) + len(vehicle.wagons)
        self.wheels: dict[int, int] = {}
        for i in self.modes:
            if i < len(vehicle.wheelsets):
                half = 0.5 * vehicle.wheelsets[i].wheelset.profile_spacing
                self.wheels[i] = self._number(i, (0.0, half, 0.0))
                self._number(i, (0.0, -half, 0.0))

    def _number(self, part: int, point: Triple) -> int:
        if (part, point) not in self._points:
            self._points.append((part, point))
        return self._points.index((part, point))

    def hold(self, part: int, point: Triple) -> tuple[int, Triple]:
        """The body that an element holds on to at a point in a part's axes [m], and the point in the body's axes."""
        if part not in self.modes:
            return part, point
        return self._behind + self._number(part, point), (0.0, 0.0, 0.0)

    @property
    def owners(self) -> list[int]:
        """Number of the part of every attachment."""
        return [part for part, _ in self._points]

    def arrays(self, coordinate: int, preloads: Sequence[Preload]) -> list[NDArray[Any]]:
        """MODES, ATTACHMENTS, SHAPES and GYROSCOPIC of ``dynamics.vehicle_forces``. coordinate: of the first mode."""
        vehicle, most = self.vehicle, max([len(modes.frequencies) for modes in self.modes.values()], default=1)
        rows = [np.zeros(0, flexible.MODE)]
        points = np.zeros(len(self._points), flexible.ATTACHMENT)
        shapes, gyroscopic = np.zeros((len(points), most, 6)), np.zeros((self.count, most))
        for i, modes in self.modes.items():
            first, n = self.first[i], len(modes.frequencies)
            gyroscopic[first : first + n, :n], turning = modes.gyroscopic()
            records = mode_records(modes, coordinate + first)
            records["rest"], records["body"] = self._at_rest(i, preloads), i
            records["first"], records["count"] = first, n
            for axis, component in zip("xyz", turning.T, strict=True):
                records["turning"][axis] = component
            rows.append(records)
        for j, (i, point) in enumerate(self._points):
            n = len(self.modes[i].frequencies)
            points[j].body, points[j].first, points[j].count, points[j].point = i, self.first[i], n, point
            points[j].spins = i < len(vehicle.wheelsets)
            shapes[j, :n] = self.modes[i].shapes(np.array([point]) + vehicle.parts[i].centre)[:, 0]
        return [np.concatenate(rows), points, shapes, gyroscopic]

    def _at_rest(self, part: int, preloads: Sequence[Preload]) -> Array:
        """What the preload does to the modes of a body (n,) [N]; an axle is straight without load."""
        forces = np.zeros(len(self.modes[part].frequencies))
        if part < len(self.vehicle.wheelsets):
            return forces
        for element, preload in zip(self.vehicle.elements, preloads[: len(self.vehicle.elements)], strict=True):
            force = element.directions.T @ preload.force
            arm = np.subtract(element.points[1], element.points[0])
            for name, end, sign in ((element.first, element.points[0], -1.0), (element.second, element.points[1], 1.0)):
                if self.vehicle.index(name) == part:
                    turning = preload.moment + (np.cross(arm, force) if sign < 0.0 else 0.0)
                    shape = self.modes[part].shapes(np.array([end]))[:, 0]
                    forces += sign * (shape @ np.concatenate([force, turning]))
        return forces
