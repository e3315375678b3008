"""From the strips of a lobe to forces, moments and the figures that people read."""

from math import atan, pi, sqrt

from wrsim.contact.contact_angle import contact_angle
from wrsim.contact.records import WheelPose
from wrsim.jit import Record, Records, inlined, kernel
from wrsim.jit.frames import Frame
from wrsim.jit.linalg import Vec, add, cross, dot, mixed, shifted, sub


@inlined
def _frame(row: Record) -> Frame:
    """Centre of a strip, or main point of a lobe, with the tangents along the track and across and the normal from rail
    to wheel: that of the section, leant back by the slope along the track."""
    inverse = 1.0 if row.slope == 0.0 else 1.0 / sqrt(1.0 + row.slope * row.slope)
    return Frame(
        Vec(row.x, row.o, row.b),
        Vec(inverse, row.slope * row.no * inverse, row.slope * row.nb * inverse),
        Vec(0.0, row.nb, -row.no),
        Vec(-row.slope * inverse, row.no * inverse, row.nb * inverse),
    )


@inlined
def _on_wheel(frame: Frame, penetration: float) -> Vec:
    """The place of a strip or a lobe on the wheel's undeformed surface: half the penetration below its centre. Bodies
    of one material stretch alike where they touch, so a wheel rolls freely on its undeformed radius. CONTACT takes
    creepages there, too."""
    return shifted(frame.origin, -0.5 * penetration, frame.b)


@inlined
def _set_creepages(row: Record, penetration: float, pose: WheelPose, inverse: float, roller: float) -> float:
    """Write xi, eta, phi of a strip or a lobe; returns the velocity along its normal."""
    frame = _frame(row)
    velocity = add(pose.velocity, cross(pose.omega, sub(_on_wheel(frame, penetration), pose.origin)))
    omega, rate = pose.omega, roller * pose.velocity.x
    if rate != 0.0:
        omega = Vec(omega.x, omega.y + rate, omega.z)
        place = _on_wheel(frame, -penetration)  # on the undeformed roller
        velocity = add(velocity, Vec(rate * place.z, 0.0, -rate * place.x))
    row.xi = dot(velocity, frame.t) * inverse
    row.eta = dot(velocity, frame.n) * inverse
    row.phi = dot(omega, frame.b) * inverse
    return dot(velocity, frame.b)


@kernel
def set_creepages(pose: WheelPose, model: Record, lobe: Record, strips: Records, n: int) -> None:
    """Creepages (creep-creepages) of each strip and of the main point: velocity of the wheel over the rolling speed.

    The rail rests; a roller turns with the wheel's speed at its profile's origin (roller-creepages).
    v = v_origin + omega x r on the wheel's undeformed surface, projected on the strip's (t, t_s); spin is omega . n(s).
    Writes xi, eta, phi of the strips and the lobe, and closing (rate of approach) of the lobe. The speed is held above
    the model's least.
    """
    inverse = 1.0 / sqrt(pose.velocity.x * pose.velocity.x + model.least_speed * model.least_speed)
    lobe.closing = -_set_creepages(lobe, lobe.approach, pose, inverse, model.roller)
    for i in range(n):
        _set_creepages(strips[i], strips[i].penetration, pose, inverse, model.roller)


@kernel
def set_pressures(strips: Records, n: int, factor: float) -> tuple[float, float, float, float]:
    """Write p (peak pressure of each strip) and N (its normal force [S 30]); p comes as amplitude p / a [Pa/m]. factor:
    multiplies the pressures (damping). Returns (largest pressure, sum of the strip forces, area, longest half
    length)."""
    largest = force = area = longest = 0.0
    for i in range(n):
        strip = strips[i]
        a = strip.a
        ratio = strip.p * factor
        strip.p = ratio * a
        strip.N = 0.5 * pi * ratio * a * a * strip.ds
        largest = max(largest, strip.p)
        force += strip.N
        area += 2.0 * a * strip.ds
        longest = max(longest, a)
    return largest, force, area, longest


@kernel
def add_lobe(pose: WheelPose, lobe: Record, strips: Records, n: int, total: Record) -> None:
    """Sum the strips' forces: to the wheel's total and to the lobe's own figures [S 31]. They act on the wheel where
    the creepages are taken, so that the wheel loses by them what creep dissipates."""
    force = moment = main_moment = Vec(0.0, 0.0, 0.0)
    sum_x = sum_y = sum_no = sum_nb = wear = 0.0
    least, most = 1e9, -1e9
    main = _frame(lobe)
    for i in range(n):
        strip = strips[i]
        strip_normal = _frame(strip)
        creep = mixed(strip.Fx, strip_normal.t, strip.Fy, strip_normal.n)
        force_on_strip = shifted(creep, strip.N, strip_normal.b)
        force = add(force, force_on_strip)
        arm = sub(_on_wheel(strip_normal, strip.penetration), pose.origin)
        moment = add(moment, shifted(cross(arm, force_on_strip), strip.Mz, strip_normal.b))
        sum_x += strip.Fx
        sum_y += strip.Fy
        wear -= strip.Fx * strip.xi + strip.Fy * strip.eta + strip.Mz * strip.phi
        # tan(angle / 2) rises with the angle and needs no arcus
        half_tangent = -strip.no / (1.0 + strip.nb)
        if strip.N > 0.0:
            least = min(least, half_tangent)
            most = max(most, half_tangent)
        sum_no += strip.N * strip.no
        sum_nb += strip.N * strip.nb
        main_moment = add(
            main_moment, shifted(cross(sub(strip_normal.origin, main.origin), creep), strip.Mz, strip_normal.b)
        )
    lobe.Fx, lobe.Fy, lobe.Mz = sum_x, sum_y, dot(main_moment, main.b)
    lobe.angle = contact_angle(lobe.no, lobe.nb)
    lobe.angle_min = 2.0 * atan(least)
    lobe.angle_max = 2.0 * atan(most)
    lobe.angle_mean = contact_angle(sum_no, sum_nb)
    lobe.wear = wear
    total.Ft, total.Fo, total.Fb = total.Ft + force.x, total.Fo + force.y, total.Fb + force.z
    total.Mt, total.Mo, total.Mb = total.Mt + moment.x, total.Mo + moment.y, total.Mb + moment.z
    total.wear += wear
