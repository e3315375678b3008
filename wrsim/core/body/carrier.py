"""What the track frame does to a wheelset: suspension, sprung mass, constant force; and gravity.

A kinematic frame runs along the centre line at constant speed, s_f(t) = s0 + V t. It is evaluated, not
integrated.

Suspension. One set of springs and dampers on each side joins the axle at +-half_spacing to the point of the
frame that stands at +-half_spacing n, ``height`` above the track plane. With d the vector between them and
omega_f the angular velocity of the frame, the force on the axle along each axis e of the frame is

    -k d.e - c (v_axle - v_frame - omega_f x (r_axle - r_frame)).e

In a bogie the axle sits ``ahead`` of the centre, and the bogie stands along the chord of a curve: the points of the
frame are then turned about b by -ahead kappa against the track, the angle of attack of a leading axle. How fast that
angle changes in a transition is left out of the damper's velocity.

The velocity is the one seen from the turning frame: a wheelset that follows a curve undisturbed meets no
damper force. The points lie on the axle, so the spin does not move them.

Sprung mass. It follows the frame without oscillating. Its weight and its inertia press on the wheelset with
m_s (g - a_f), a_f = V^2 dt/ds; the part along t is left to the train that keeps the frame at its speed, the
other two act at the centre of mass, with the moment of the lateral part at ``height`` above the axle. The
speed at which the cant changes adds no force.

The constant force acts at the centre of mass in the track axes at the wheelset's own place.
"""

from math import cos, sin

from numba import njit

from wrsim.core.track.path import frame, frame_rates

# places in the array of parameters
MASS, GRAVITY = 0, 1  # of the wheelset [kg]; acceleration [m/s2]
STIFFNESS, DAMPING = 2, 5  # three each: x, y, z, of one side [N/m, N s/m]
HALF_SPACING, HEIGHT = 8, 9  # [m]; of the axle above the track plane with springs at rest
SPRUNG_MASS, SPRUNG_HEIGHT = 10, 11  # [kg]; above the axle [m]
CONSTANT = 12  # three: force along t, n, b [N]
START, SPEED = 15, 16  # s0 [m], V [m/s]
AHEAD = 17  # of the bogie centre [m]
PARAMETERS = 18


@njit(cache=True)
def carrier_forces(t, body, own, path, step, parameters):
    """Force and moment on a wheelset from everything but the rails.

    t: time [s]; body: 18 numbers of ``core.body.kinematics.kinematics``; own: track frame at the projection of the
    centre of mass; path, step: centre line; parameters: (18,) as named above.
    Returns (Fx, Fy, Fz [N], Mx, My, Mz [N m]): at the centre of mass, in global axes.
    """
    speed = parameters[SPEED]
    s = parameters[START] + speed * t
    rx, ry, rz, tx, ty, tz, nx, ny, nz, bx, by, bz = frame(path, step, s)
    wx, wy, wz, _ = frame_rates(path, step, s)
    # direction of the axle of a wheelset that the frame holds: n turned by the attack
    attack = -parameters[AHEAD] * (wx * bx + wy * by + wz * bz)
    ca = cos(attack)
    sa = sin(attack)
    ex = ca * nx - sa * tx
    ey = ca * ny - sa * ty
    ez = ca * nz - sa * tz
    wx *= speed
    wy *= speed
    wz *= speed

    gravity = parameters[GRAVITY]
    f0 = parameters[CONSTANT]
    f1 = parameters[CONSTANT + 1]
    f2 = parameters[CONSTANT + 2]
    fx = f0 * own[3] + f1 * own[6] + f2 * own[9]
    fy = f0 * own[4] + f1 * own[7] + f2 * own[10]
    fz = f0 * own[5] + f1 * own[8] + f2 * own[11] - parameters[MASS] * gravity
    mx = 0.0
    my = 0.0
    mz = 0.0

    sprung = parameters[SPRUNG_MASS]
    if sprung != 0.0:
        ax = speed * (wy * tz - wz * ty)  # V^2 dt/ds
        ay = speed * (wz * tx - wx * tz)
        az = speed * (wx * ty - wy * tx)
        along_n = -sprung * (gravity * nz + ax * nx + ay * ny + az * nz)
        along_b = -sprung * (gravity * bz + ax * bx + ay * by + az * bz)
        fx += along_n * nx + along_b * bx
        fy += along_n * ny + along_b * by
        fz += along_n * nz + along_b * bz
        lever = parameters[SPRUNG_HEIGHT] * along_n  # b x n = -t
        mx -= lever * tx
        my -= lever * ty
        mz -= lever * tz

    kx = parameters[STIFFNESS]
    ky = parameters[STIFFNESS + 1]
    kz = parameters[STIFFNESS + 2]
    cx = parameters[DAMPING]
    cy = parameters[DAMPING + 1]
    cz = parameters[DAMPING + 2]
    half = parameters[HALF_SPACING]
    height = parameters[HEIGHT]
    # velocity of the centre of mass and turning of the axle as seen from the frame
    px = body[0] - rx
    py = body[1] - ry
    pz = body[2] - rz
    vx = body[3] - speed * tx - (wy * pz - wz * py)
    vy = body[4] - speed * ty - (wz * px - wx * pz)
    vz = body[5] - speed * tz - (wx * py - wy * px)
    ox = body[15] - wx
    oy = body[16] - wy
    oz = body[17] - wz
    for side in range(2):
        arm = half if side == 0 else -half
        ax = arm * body[9]
        ay = arm * body[10]
        az = arm * body[11]
        dx = px + ax - arm * ex - height * bx
        dy = py + ay - arm * ey - height * by
        dz = pz + az - arm * ez - height * bz
        ux = vx + oy * az - oz * ay
        uy = vy + oz * ax - ox * az
        uz = vz + ox * ay - oy * ax
        ft = -kx * (dx * tx + dy * ty + dz * tz) - cx * (ux * tx + uy * ty + uz * tz)
        fn = -ky * (dx * nx + dy * ny + dz * nz) - cy * (ux * nx + uy * ny + uz * nz)
        fb = -kz * (dx * bx + dy * by + dz * bz) - cz * (ux * bx + uy * by + uz * bz)
        gx = ft * tx + fn * nx + fb * bx
        gy = ft * ty + fn * ny + fb * by
        gz = ft * tz + fn * nz + fb * bz
        fx += gx
        fy += gy
        fz += gz
        mx += ay * gz - az * gy
        my += az * gx - ax * gz
        mz += ax * gy - ay * gx
    return fx, fy, fz, mx, my, mz
