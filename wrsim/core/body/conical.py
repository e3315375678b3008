"""Rigid conical wheels with a prescribed creep law: the contact of the classic models of hunting.

Each wheel touches its rail at a fixed distance ``half`` from the middle of the axle. Of the cone nothing enters but the
rolling radius, r = r0 + lambda y on the left and r0 - lambda y on the right wheel (y: shift to the left against the
track): normal forces stand on the track plane, so there is no gravitational stiffness and no roll of the cone on the
rails. Creepages are those of the material point at the contact, over the speed V, along t and n of the track; small,
they are

    xi = -+ a psi_t / V - (+-) lambda y / r0,    eta = y_t / V - psi.

Creep force T = -(C_x xi, C_y eta), without spin; with friction its size is mu N (e - e^2/3 + e^3/27), e = |T|/(mu N)
< 3 (Vermeulen and Johnson). Flanges are springs with free travel. In the place of rigid rails stand stiff springs and
dampers under the wheels.
"""

from math import sqrt

from wrsim.core.body.kinematics import generalised_forces, kinematics, point_velocity
from wrsim.core.compiling import kernel
from wrsim.core.track.path import frame, locate

CONICITY, HALF, CREEP_X, CREEP_Y, FRICTION, CLEARANCE, FLANGE, SUPPORT, SUPPORT_DAMPING = range(9)
PARAMETERS = 9


@kernel
def conical_forces(q, q_t, radii, places, path, step, speed, law, force, moment, out):
    """Add the generalised forces of all wheelsets' contacts to ``out``; returns 0 or 1, off the track.

    q, q_t: see core.body.vehicle_forces, wheelsets first; radii: of the wheels at their middle position, one per
    wheelset [m]; places: distances along the centre line, guesses, updated [m]; speed [m/s]; law: (PARAMETERS,);
    force, moment: scratch, (3,).
    """
    add = out[:6].copy()
    for i in range(radii.shape[0]):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        s, bad = locate(path, step, body[0], body[1], body[2], places[i])
        if bad != 0:
            return 1
        places[i] = s
        own = frame(path, step, s)
        for k in range(3):
            force[k] = 0.0
            moment[k] = 0.0
        y = (body[0] - own[0]) * own[6] + (body[1] - own[1]) * own[7] + (body[2] - own[2]) * own[8]
        for side in (1.0, -1.0):
            _wheel(body, own, side, side * y, radii[i], speed, law, force, moment)
        generalised_forces(body, force, moment, add)
        for k in range(6):
            out[6 * i + k] += add[k]
    return 0


@kernel
def _wheel(body, own, side, outward, radius, speed, law, force, moment):
    """Add the force and the moment of one wheel; outward: shift of the wheelset towards this side [m]."""
    arm = side * law[HALF]
    ax = arm * body[9] - radius * body[12]
    ay = arm * body[10] - radius * body[13]
    az = arm * body[11] - radius * body[14]
    x, y, z = body[0] + ax, body[1] + ay, body[2] + az
    vx, vy, vz = point_velocity(body, x, y, z)
    depth = -((x - own[0]) * own[9] + (y - own[1]) * own[10] + (z - own[2]) * own[11])
    normal = law[SUPPORT] * depth - law[SUPPORT_DAMPING] * (vx * own[9] + vy * own[10] + vz * own[11])
    if not (depth > 0.0 and normal > 0.0):
        return
    # slip of the point that lies lower by the difference of the rolling radius
    lower = law[CONICITY] * outward
    vx, vy, vz = point_velocity(body, x - lower * body[12], y - lower * body[13], z - lower * body[14])
    along = -law[CREEP_X] * (vx * own[3] + vy * own[4] + vz * own[5]) / speed
    across = -law[CREEP_Y] * (vx * own[6] + vy * own[7] + vz * own[8]) / speed
    if law[FRICTION] > 0.0:
        bound = law[FRICTION] * normal
        e = sqrt(along * along + across * across) / bound
        part = 1.0 / e if e >= 3.0 else 1.0 - e / 3.0 + e * e / 27.0
        along *= part
        across *= part
    beyond = outward - law[CLEARANCE]
    if beyond > 0.0:
        across -= side * law[FLANGE] * beyond
    fx = along * own[3] + across * own[6] + normal * own[9]
    fy = along * own[4] + across * own[7] + normal * own[10]
    fz = along * own[5] + across * own[8] + normal * own[11]
    force[0] += fx
    force[1] += fy
    force[2] += fz
    moment[0] += ay * fz - az * fy
    moment[1] += az * fx - ax * fz
    moment[2] += ax * fy - ay * fx
