"""Forces of all suspension elements of a vehicle, in one loop over a table of elements.

Each element joins a point of a first body to a point of a second one. ``states`` holds a row of 18 numbers per body:
position, velocity, unit vectors forward, left, up, angular velocity; the last two rows are the track frame and the
guide frame (``core.body.vehicle_forces``).

- FIELD: three springs and dampers along the axes of the first body, and rotational ones about them. With d the vector
  between the two points in these axes the force on the second body is f0 - k d - c d_t. Both bodies take the force at
  the second body's point: the field turns with the first body. So the element has a potential (d.k d/2 - f0.d), and
  keeps momentum and angular momentum to round-off, at any angle. The rotational springs have the potential
  sum_i w_i (1 - e_i.e'_i) of the axes e of the first and e' of the second body, w = (kx + ky + kz)/2 - k: their moments
  are k times the angle while this is small.
- SHEAR: half of the element is a field of the first body, half one of the second. Placed at the middle of a flexible
  column (a coil spring) of height h with bending stiffness k_b = E I / h about both axes and shear stiffness 12 E I /
  h^3 this is a beam clamped at both ends; the moment of the load about the shifted ends is shared equally.
- AXIS: one spring and damper along one axis of the first body, as FIELD.
- LINE: one spring and damper along the line between the two points (rods, links).

Springs of AXIS and LINE may be tables of force against travel, dampers tables of force against velocity. A damper may
have a stiffness in series (Maxwell): the extension x of its damping part is an unknown of its own,

    force = k_s (e - x),   x_t = force / c    (or from the table, velocity against force),

which the solver integrates with everything else.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel

FIELD, SHEAR, AXIS, LINE = range(4)

# a row of the table of elements
KIND, FIRST, SECOND, POINT_1, POINT_2 = 0, 1, 2, 3, 6
STIFFNESS, DAMPING, PRELOAD, TURNING, TURNING_DAMPING = 9, 12, 15, 18, 21  # FIELD and SHEAR: three each
DIRECTION, K, C, FORCE_0, LENGTH, SERIES, STATE = range(9, 16)  # AXIS and LINE
SPRING_TABLE, SPRING_ROWS, DAMPER_TABLE, DAMPER_ROWS = range(16, 20)
COLUMNS = 24

RECORD = 6  # force on the second body (3) and travel (3) in the first body's axes; of a LINE tension and extension in x


@inlined
def _interpolate(tables, start, count, x):
    """Piecewise linear function of the rows (x, y); beyond its ends it goes on with the slope there."""
    i = start
    while i < start + count - 2 and x > tables[i + 1, 0]:
        i += 1
    slope = (tables[i + 1, 1] - tables[i, 1]) / (tables[i + 1, 0] - tables[i, 0])
    return tables[i, 1] + slope * (x - tables[i, 0])


@kernel
def _one_direction(row, tables, e, rate, inner, inner_t):
    """Restoring force of a spring and damper in one direction; e: travel [m], rate [m/s].

    inner, inner_t: extension of the damping parts and where its rates go; only those of this element are touched.
    """
    count = int(row[SPRING_ROWS])
    force = _interpolate(tables, int(row[SPRING_TABLE]), count, e) if count > 0 else row[K] * e
    state = int(row[STATE])
    count = int(row[DAMPER_ROWS])
    start = int(row[DAMPER_TABLE])
    if state < 0:
        force += _interpolate(tables, start, count, rate) if count > 0 else row[C] * rate
    else:
        damper = row[SERIES] * (e - inner[state])
        inner_t[state] = _interpolate(tables, start, count, damper) if count > 0 else damper / row[C]
        force += damper
    return force


@kernel
def _add(states, i, x, y, z, fx, fy, fz, force, moment):
    """Add a force at the global point (x, y, z) to body i."""
    force[i, 0] += fx
    force[i, 1] += fy
    force[i, 2] += fz
    x -= states[i, 0]
    y -= states[i, 1]
    z -= states[i, 2]
    moment[i, 0] += y * fz - z * fy
    moment[i, 1] += z * fx - x * fz
    moment[i, 2] += x * fy - y * fx


@inlined
def _point(states, i, row, first, k):
    """Global coordinate k of the point of body i whose body coordinates begin at row[first]."""
    return (
        states[i, k]
        + row[first] * states[i, 6 + k]
        + row[first + 1] * states[i, 9 + k]
        + row[first + 2] * states[i, 12 + k]
    )


@inlined
def _speed(states, i, k, x, y, z):
    """Component k of the velocity of body i at the global point (x, y, z)."""
    rx = x - states[i, 0]
    ry = y - states[i, 1]
    rz = z - states[i, 2]
    if k == 0:
        turning = states[i, 16] * rz - states[i, 17] * ry
    elif k == 1:
        turning = states[i, 17] * rx - states[i, 15] * rz
    else:
        turning = states[i, 15] * ry - states[i, 16] * rx
    return states[i, 3 + k] + turning


@kernel
def _field(states, a, b, first, second, row, share, sign, tables, inner, inner_t, force, moment, record):
    """A field of body a that acts on body b; share of the element, sign of its preload.

    Adds force and travel to ``record`` in a's axes.
    """
    x = _point(states, b, row, second, 0)
    y = _point(states, b, row, second, 1)
    z = _point(states, b, row, second, 2)
    dx = x - _point(states, a, row, first, 0)
    dy = y - _point(states, a, row, first, 1)
    dz = z - _point(states, a, row, first, 2)
    ux = _speed(states, b, 0, x, y, z) - _speed(states, a, 0, x, y, z)
    uy = _speed(states, b, 1, x, y, z) - _speed(states, a, 1, x, y, z)
    uz = _speed(states, b, 2, x, y, z) - _speed(states, a, 2, x, y, z)
    fx = 0.0
    fy = 0.0
    fz = 0.0
    whole = int(row[KIND]) != AXIS
    for k in range(3):
        if not whole and k != int(row[DIRECTION]):
            continue
        ex = states[a, 6 + 3 * k]
        ey = states[a, 7 + 3 * k]
        ez = states[a, 8 + 3 * k]
        d = dx * ex + dy * ey + dz * ez
        u = ux * ex + uy * ey + uz * ez
        if whole:
            f = share * (sign * row[PRELOAD + k] - row[STIFFNESS + k] * d - row[DAMPING + k] * u)
        else:
            f = row[FORCE_0] - _one_direction(row, tables, d, u, inner, inner_t)
        record[k] += sign * f
        record[3 + k] += sign * share * d
        fx += f * ex
        fy += f * ey
        fz += f * ez
    _add(states, b, x, y, z, fx, fy, fz, force, moment)
    _add(states, a, x, y, z, -fx, -fy, -fz, force, moment)


@kernel
def _turning(states, a, b, row, moment):
    """Rotational springs and dampers about the axes of body a."""
    half = 0.5 * (row[TURNING] + row[TURNING + 1] + row[TURNING + 2])
    mx = 0.0
    my = 0.0
    mz = 0.0
    for k in range(3):
        ax = states[a, 6 + 3 * k]
        ay = states[a, 7 + 3 * k]
        az = states[a, 8 + 3 * k]
        bx = states[b, 6 + 3 * k]
        by = states[b, 7 + 3 * k]
        bz = states[b, 8 + 3 * k]
        w = half - row[TURNING + k]
        # on the second body: w e' x e
        mx += w * (by * az - bz * ay)
        my += w * (bz * ax - bx * az)
        mz += w * (bx * ay - by * ax)
        c = row[TURNING_DAMPING + k]
        if c != 0.0:
            rate = (
                (states[b, 15] - states[a, 15]) * ax
                + (states[b, 16] - states[a, 16]) * ay
                + (states[b, 17] - states[a, 17]) * az
            )
            mx -= c * rate * ax
            my -= c * rate * ay
            mz -= c * rate * az
    moment[b, 0] += mx
    moment[b, 1] += my
    moment[b, 2] += mz
    moment[a, 0] -= mx
    moment[a, 1] -= my
    moment[a, 2] -= mz


@kernel
def _line(states, a, b, row, tables, inner, inner_t, force, moment, record):
    """A spring and damper along the line between its two points; record: tension and extension."""
    x1 = _point(states, a, row, POINT_1, 0)
    y1 = _point(states, a, row, POINT_1, 1)
    z1 = _point(states, a, row, POINT_1, 2)
    x2 = _point(states, b, row, POINT_2, 0)
    y2 = _point(states, b, row, POINT_2, 1)
    z2 = _point(states, b, row, POINT_2, 2)
    dx = x2 - x1
    dy = y2 - y1
    dz = z2 - z1
    length = sqrt(dx * dx + dy * dy + dz * dz)
    dx /= length
    dy /= length
    dz /= length
    rate = (
        dx * (_speed(states, b, 0, x2, y2, z2) - _speed(states, a, 0, x1, y1, z1))
        + dy * (_speed(states, b, 1, x2, y2, z2) - _speed(states, a, 1, x1, y1, z1))
        + dz * (_speed(states, b, 2, x2, y2, z2) - _speed(states, a, 2, x1, y1, z1))
    )
    extension = length - row[LENGTH]
    tension = _one_direction(row, tables, extension, rate, inner, inner_t) - row[FORCE_0]
    record[0] = tension
    record[3] = extension
    _add(states, a, x1, y1, z1, tension * dx, tension * dy, tension * dz, force, moment)
    _add(states, b, x2, y2, z2, -tension * dx, -tension * dy, -tension * dz, force, moment)


@kernel
def suspension_forces(states, elements, tables, inner, inner_t, force, moment, records):
    """Add the forces and moments (n, 3) of all elements at the centres of mass, in global axes.

    states: (n, 18), the frames last; elements: (m, COLUMNS); tables: (., 2); inner, inner_t: extensions of the
    damping parts in series with a spring [m] and their rates, to be filled; records: (m, RECORD) to be filled.
    """
    for i in range(elements.shape[0]):
        row = elements[i]
        record = records[i]
        for k in range(RECORD):
            record[k] = 0.0
        a = int(row[FIRST])
        b = int(row[SECOND])
        kind = int(row[KIND])
        if kind == LINE:
            _line(states, a, b, row, tables, inner, inner_t, force, moment, record)
            continue
        share = 0.5 if kind == SHEAR else 1.0
        _field(states, a, b, POINT_1, POINT_2, row, share, 1.0, tables, inner, inner_t, force, moment, record)
        if kind == SHEAR:
            _field(states, b, a, POINT_2, POINT_1, row, share, -1.0, tables, inner, inner_t, force, moment, record)
        if (
            kind != AXIS
            and row[TURNING]
            + row[TURNING + 1]
            + row[TURNING + 2]
            + (row[TURNING_DAMPING] + row[TURNING_DAMPING + 1] + row[TURNING_DAMPING + 2])
            != 0.0
        ):
            _turning(states, a, b, row, moment)
