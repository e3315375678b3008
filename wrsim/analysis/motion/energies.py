"""Where the energy of a run is and goes: kinetic, of height, taken by creep and by dampers and friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body import vehicle_forces
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import COORDINATES

Array = NDArray[np.float64]

Z, HEADING, ROLL, SPIN = (COORDINATES.index(name) for name in ("z", "heading", "roll", "spin"))


def energy_channels(law: VehicleOnTrack, q: Array, q_t: Array) -> dict[str, Array]:
    """Kinetic energy of all bodies, axle boxes and geared motors, and m g z of all bodies, (samples,) [J]."""
    vehicle, n = law.vehicle, 6 * len(law.bodies)
    own, rates = (a[:, :n].reshape(len(q), -1, 6) for a in (q, q_t))
    mass = np.array([body.mass for body in law.bodies])
    about = np.array([body.inertia for body in law.bodies])
    axles = len(vehicle.wheelsets)
    # the axes of a wheelset do not spin with it: it is the same about all across its axle
    pitch = np.where(np.arange(own.shape[1]) < axles, 0.0, own[:, :, SPIN])
    sr, cr, sp, cp = np.sin(own[:, :, ROLL]), np.cos(own[:, :, ROLL]), np.sin(pitch), np.cos(pitch)
    h, r, p = rates[:, :, HEADING], rates[:, :, ROLL], rates[:, :, SPIN]
    turning = np.stack([cp * r - cr * sp * h, sr * h + p, cr * cp * h + sp * r], axis=-1)
    kinetic = 0.5 * ((rates[:, :, :3] ** 2).sum(axis=-1) @ mass + (turning**2 * about).sum(axis=(1, 2)))
    first = law.size - law.positions
    for j, (_, box) in enumerate(vehicle.boxes.values()):
        kinetic += 0.5 * box.inertia[1] * q_t[:, first + j] ** 2
    for drive, place in zip(vehicle.drives, law.gears.values(), strict=True):
        kinetic += 0.5 * drive.inertia * q_t[:, place + 1] ** 2
    for wheelset, twist in law.twists.items():
        kinetic += 0.125 * law.bodies[wheelset].inertia[1] * q_t[:, twist] ** 2
    return {"kinetic_energy": kinetic, "potential_energy": vehicle.gravity * own[:, :, Z] @ mass}


def lost_at(law: VehicleOnTrack, q_t: Array) -> tuple[float, float, float]:
    """At the state that the law was asked for last: power that creep takes, power that dampers and friction of the
    suspension and of axles take, and power of the pull along the track [W]; q_t: of that state.
    """
    arrays = (wheel.model.arrays for pair in law.wheels for wheel in pair)
    creep = sum(float(a.total["wear"]) * float(a.pose[6]) for a in arrays)
    dampers = float(law.elements["loss"].sum())
    for drive, (wheelset, place) in zip(law.vehicle.drives, law.gears.items(), strict=True):
        dampers += drive.damping * (q_t[place + 1] - q_t[6 * wheelset + SPIN]) ** 2
    for wheelset, twist in law.twists.items():
        torsion = law.vehicle.wheelsets[wheelset].wheelset.torsion
        dampers += 0.0 if torsion is None else torsion.damping * q_t[twist] ** 2
    pull = 0.0
    if law.drive == "train":
        forces = law.arena.views[vehicle_forces.UNITS]["force"]
        for force, unit in zip(forces, law.vehicle.units, strict=True):
            pull += float(force * np.linalg.norm(q_t[6 * unit.reference : 6 * unit.reference + 3]))
    return creep, dampers, pull
