"""Rigid conical wheels with a prescribed creep law: the contact of the classic models of hunting.

Each wheel touches its rail at a fixed distance ``half`` from the middle of the axle. Of the cone nothing enters but the
rolling radius, r = r0 + lambda y on the left and r0 - lambda y on the right wheel (y: shift to the left against the
track): normal forces are perpendicular to the track plane, so there is no gravitational stiffness and no roll of the
cone on the rails. Creepages are those of the material point at the contact, over the speed V, along t and n of the
track; small, they are

    xi = -+ a psi_t / V - (+-) lambda y / r0,    eta = y_t / V - psi.

Creep force T = -(C_x xi, C_y eta), without spin; with friction its size is mu N (e - e^2/3 + e^3/27), e = |T|/(mu N)
< 3 (Vermeulen and Johnson). Flanges are springs with free travel. Stiff springs replace rigid rails, and
dampers under the wheels.
"""

from math import sqrt

from wrsim.jit import Array, Record, Records, kernel, record
from wrsim.jit.frames import BodyMotion, CurveNodes, Frame, point_velocity
from wrsim.jit.linalg import Vec, add, cross, dot, from_components, mixed, shifted, sub
from wrsim.track.path_kernel import frame_at, locate
from wrsim.vehicle.dynamics.kinematics import add_generalised_forces, kinematics

CONICAL = record("""
    conicity        [1]     slope of the cone
    half            [m]     distance of the contact from the middle of the axle
    creep_x         [N]     creep coefficient along the track
    creep_y         [N]     creep coefficient across it
    friction        [1]     coefficient of friction; 0: none
    clearance       [m]     free travel of the flange
    flange          [N/m]   stiffness of the flange
    support         [N/m]   stiffness under the wheel
    support_damping [N s/m] damping under the wheel
""")


@kernel
def conical_forces(
    q: Array, q_t: Array, radii: Array, places: Array, curve: CurveNodes, speed: float, law: Records, out: Array
) -> int:
    """Add the generalised forces of all wheelsets' contacts to ``out``; returns 0 or 1, off the track. q, q_t: see
    dynamics.vehicle_forces, wheelsets first; radii: of the wheels at their middle position, one per wheelset [m];
    places: distances along the centre line, guesses, updated [m]; speed [m/s]; law: one record CONICAL."""
    for i in range(radii.shape[0]):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        s, bad = locate(curve, body.position, places[i])
        if bad != 0:
            return 1
        places[i] = s
        track = frame_at(curve, s)
        force = moment = Vec(0.0, 0.0, 0.0)
        for wheel in range(2):
            side = 1.0 - 2.0 * wheel
            arm = mixed(side * law[0].half, body.left, -radii[i], body.up)
            pull = _wheel_force(body, track, side, arm, speed, law[0])
            force = add(force, pull)
            moment = add(moment, cross(arm, pull))
        add_generalised_forces(body, force, moment, out[6 * i : 6 * i + 6])
    return 0


@kernel
def _wheel_force(body: BodyMotion, track: Frame, side: float, arm: Vec, speed: float, law: Record) -> Vec:
    """Force on one wheel; side: +1 left, -1 right; arm: its contact from the centre of the axle [m]."""
    contact = add(body.position, arm)
    depth = -dot(sub(contact, track.origin), track.b)
    normal = law.support * depth - law.support_damping * dot(point_velocity(body, contact), track.b)
    if not (depth > 0.0 and normal > 0.0):
        return Vec(0.0, 0.0, 0.0)
    outward = side * dot(sub(body.position, track.origin), track.n)
    # slip of the point that lies lower by the difference of the rolling radius
    slip = point_velocity(body, shifted(contact, -law.conicity * outward, body.up))
    along = -law.creep_x * dot(slip, track.t) / speed
    across = -law.creep_y * dot(slip, track.n) / speed
    if law.friction > 0.0:
        e = sqrt(along * along + across * across) / (law.friction * normal)
        part = 1.0 / e if e >= 3.0 else 1.0 - e / 3.0 + e * e / 27.0
        along *= part
        across *= part
    across -= side * law.flange * max(outward - law.clearance, 0.0)
    return from_components(Vec(along, across, normal), track.t, track.n, track.b)
