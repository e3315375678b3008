"""Where the energy of a run is and goes: kinetic, of height, taken by creep and by dampers and friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body import vehicle_forces
from wrsim.core.body.rigid_body import kinetic_energies
from wrsim.simulation.bodies import inertia_table
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import COORDINATES

Array = NDArray[np.float64]

Z = COORDINATES.index("z")


def energy_channels(law: VehicleOnTrack, q: Array, q_t: Array) -> dict[str, Array]:
    """Kinetic energy of all bodies, axle boxes and geared motors, and m g z of all bodies, (samples,) [J]."""
    vehicle, n = law.vehicle, 6 * len(law.bodies)
    mass = np.array([body.mass for body in law.bodies])
    kinetic = np.zeros(len(q))
    kinetic_energies(q, q_t, inertia_table(law.bodies), len(vehicle.wheelsets), kinetic)
    first = law.size - law.positions
    for j, (_, box) in enumerate(vehicle.boxes.values()):
        kinetic += 0.5 * box.inertia[1] * q_t[:, first + j] ** 2
    for drive, place in zip(vehicle.drives, law.gears.values(), strict=True):
        kinetic += 0.5 * drive.inertia * q_t[:, place + 1] ** 2
    for wheelset, twist in law.twists.items():
        kinetic += 0.125 * law.bodies[wheelset].inertia[1] * q_t[:, twist] ** 2
    return {"kinetic_energy": kinetic, "potential_energy": vehicle.gravity * q[:, Z:n:6] @ mass}


def lost_at(law: VehicleOnTrack, q_t: Array) -> tuple[float, float, float]:
    """At the state that the law was asked for last: power that creep takes, power that dampers and friction of the
    suspension and of axles take, and power of the pull along the track [W]; q_t: of that state.
    """
    arrays = (wheel.model.arrays for pair in law.wheels for wheel in pair)
    creep = sum(float(a.total["wear"]) * float(a.pose[6]) for a in arrays)
    dampers = float(law.elements["loss"].sum() + law.axles["loss"].sum())
    for wheelset, twist in law.twists.items():
        torsion = law.vehicle.wheelsets[wheelset].wheelset.torsion
        dampers += 0.0 if torsion is None else torsion.damping * q_t[twist] ** 2
    pull = 0.0
    if law.drive == "train":
        forces = law.arena.views[vehicle_forces.UNITS]["force"]
        for force, unit in zip(forces, law.vehicle.units, strict=True):
            pull += float(force * np.linalg.norm(q_t[6 * unit.reference : 6 * unit.reference + 3]))
    return creep, dampers, pull
