"""The force law of a vehicle on conical wheels with a prescribed creep law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body import conical as kernel
from wrsim.errors import SimulationError
from wrsim.simulation.force_law import Block
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import Array

if TYPE_CHECKING:
    from wrsim.contact.settings import ConicalWheels
    from wrsim.geometry.track.track import Track
    from wrsim.vehicle.loads import Drive
    from wrsim.vehicle.vehicle import Vehicle

SUPPORT = 1e9
"""Stiffness in the place of rigid rails under each wheel [N/m]."""
SUPPORT_DAMPING = 1e5
"""Damping of the same [N s/m]."""


class ConicalVehicleOnTrack(VehicleOnTrack):
    """Generalised forces on a vehicle on conical wheels; a ``ForceLaw``. There are no profiles: ``wheels`` is empty."""

    def __init__(
        self,
        vehicle: Vehicle,
        track: Track,
        cones: ConicalWheels,
        *,
        speed: float,
        start: float = 0.0,
        drive: Drive | None = None,
    ) -> None:
        """As ``VehicleOnTrack``; speed [m/s] must not be 0, for creepages are over the speed."""
        self.radii = np.array([mounted.wheelset.mean_radius for mounted in vehicle.wheelsets])
        self.own_places = np.zeros(len(self.radii))
        self.law = np.zeros(1, kernel.CONICAL)
        law = self.law[0]
        law.conicity, law.half = cones.conicity, cones.half_spacing
        law.creep_x, law.creep_y = cones.creep_longitudinal, cones.creep_lateral
        law.friction = cones.friction or 0.0
        law.clearance = np.inf if cones.flange_clearance is None else cones.flange_clearance
        law.flange = 0.0 if cones.flange_clearance is None else cones.flange_stiffness
        law.support, law.support_damping = SUPPORT, SUPPORT_DAMPING
        super().__init__(vehicle, track, (), speed=speed, start=start, drive=drive)

    def forces(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """See `VehicleOnTrack`. Raises SimulationError off the track."""
        super().forces(t, q, q_t, out)
        curve = self.track.centre.curve
        if kernel.conical_forces(q, q_t, self.radii, self.own_places, curve, self.speed, self.law, out):
            raise SimulationError(f"the vehicle has left the track's neighbourhood at t = {t:.6g} s")

    def blocks(self) -> list[Block]:
        """See ``ForceLaw``."""
        curve, count = self.track.centre.curve, len(self.radii)

        def on_cones(t: float, q: Array, q_t: Array, out: Array) -> None:
            out[:] = 0.0
            kernel.conical_forces(q, q_t, self.radii, self.own_places.copy(), curve, self.speed, self.law, out)

        return [*super().blocks(), Block.apart(on_cones, np.arange(6 * count).reshape(count, 6))]

    def look_near(self, origin: float | Array) -> None:
        super().look_near(origin)
        if np.ndim(origin) == 0:
            self.own_places[:] = [float(origin) + m.x for m in self.vehicle.wheelsets]  # type: ignore[arg-type]
        else:
            self.own_places[:] = np.asarray(origin)[:, 0]

    def kept(self) -> list[NDArray[Any]]:
        return [self.own_places, *super().kept()]
