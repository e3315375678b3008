"""Contact laws that can be solved by hand: conical wheels on knife-edge rails.

The rails are sharp edges along the track at y = +-half_spacing of the centre line, at the height of the
track plane. Each wheel is a cone, radius r0 where the undisplaced wheelset stands on the edge, conicity
tan(gamma) = lambda.

Normal force N = K delta^1.5 + c sqrt(delta) d(delta)/dt, never negative; creep force -C (N/N0)^(2/3) v/V,
saturated after Vermeulen and Johnson: T = mu N (e - e^2/3 + e^3/27), e = T_linear/(mu N) < 3. V is the speed
of the track-following frame; no spin. Two geometries:

"textbook", the law behind the growth rates of the three-dimensional example (found by comparing variants
with the
published figures: all four speeds agree to 3 digits, no other variant does): the wheel is touched at
half_spacing -+ y along its axle, y the lateral shift of the centre of mass, straight below the axle; the
contact frame is the wheelset's own, tilted by the cone angle; the approach is how deep that point lies below
the edge.

"exact": the edge touches the generator whose normal n has no component along the track. With n the unit
normal out of the wheel (downwards), n.axle = sin(gamma), n.t = 0 and approach delta = (apex - edge).n, at
any yaw and roll.

The two differ to first order. The contact moves along the axle by y + r0 roll, not by y; with roll = lambda
y/l the exact wheelset has Klingel's wavelength itself (the lateral velocity at the contact has the same
factor), the textbook one is longer by sqrt(1 + r0 lambda/l).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import atan, cos, pi, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from support.held import held_state
from wrsim.core.body.kinematics import generalised_forces, kinematics, point_velocity
from wrsim.core.track.path import frame, locate
from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Straight
from wrsim.geometry.track.track import Track
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.state import Equilibrium, design_state
from wrsim.simulation.system import COORDINATES, System
from wrsim.vehicle.vehicle import Load, Vehicle, single_wheelset
from wrsim.vehicle.wheelset import Wheel, Wheelset

HERTZ, DAMPING, CREEP, NORMAL0, FRICTION, R0, HALF, GAMMA, EXACT = range(9)


@njit(cache=True)
def textbook_contact(body, own, side, law):
    """Approach, contact point (global), unit vectors t, s (tangent across) and n (out of the wheel)."""
    half = law[HALF]
    gamma = law[GAMMA]
    px = body[0] - own[0]
    py = body[1] - own[1]
    pz = body[2] - own[2]
    shift = side * (px * own[6] + py * own[7] + pz * own[8])
    arm = side * (half - shift)
    radius = law[R0] + (sin(gamma) / cos(gamma)) * shift
    x = body[0] + arm * body[9] - radius * body[12]
    y = body[1] + arm * body[10] - radius * body[13]
    z = body[2] + arm * body[11] - radius * body[14]
    depth = -((x - own[0]) * own[9] + (y - own[1]) * own[10] + (z - own[2]) * own[11])
    c = cos(gamma)
    d = side * sin(gamma)
    e = side * c
    f = sin(gamma)
    return (
        depth * c,
        x,
        y,
        z,
        body[6],
        body[7],
        body[8],
        e * body[9] + f * body[12],
        e * body[10] + f * body[13],
        e * body[11] + f * body[14],
        d * body[9] - c * body[12],
        d * body[10] - c * body[13],
        d * body[11] - c * body[14],
    )


@njit(cache=True)
def exact_contact(body, own, side, law):
    """The same for the exact geometry. The axle and the apex are taken in (t, o, b), o outward."""
    rx, ry, rz, tx, ty, tz, nx, ny, nz, bx, by, bz = own
    half = law[HALF]
    c = cos(law[GAMMA])
    sine = sin(law[GAMMA])
    at = side * (body[9] * tx + body[10] * ty + body[11] * tz)
    ao = body[9] * nx + body[10] * ny + body[11] * nz
    ab = side * (body[9] * bx + body[10] * by + body[11] * bz)
    px = body[0] - rx
    py = body[1] - ry
    pz = body[2] - rz
    apex = half + law[R0] * c / sine  # along the axle
    apex_t = px * tx + py * ty + pz * tz + apex * at
    apex_o = side * (px * nx + py * ny + pz * nz) + apex * ao
    apex_b = px * bx + py * by + pz * bz + apex * ab
    q2 = ao * ao + ab * ab
    root = sqrt(q2 - sine * sine)
    no = (ao * sine + ab * root) / q2
    nb = (ab * sine - ao * root) / q2
    # generator from the apex to the rim, up to a factor: sin(gamma) n - axle
    gt = -at
    go = no * sine - ao
    gb = nb * sine - ab
    along = ((half - apex_o) * go - apex_b * gb) / (go * go + gb * gb)
    ct = apex_t + along * gt
    co = side * (apex_o + along * go)
    cb = apex_b + along * gb
    so = -side * nb
    sb = no
    no *= side
    return (
        (apex_o - half) * side * no + apex_b * nb,
        rx + ct * tx + co * nx + cb * bx,
        ry + ct * ty + co * ny + cb * by,
        rz + ct * tz + co * nz + cb * bz,
        tx,
        ty,
        tz,
        so * nx + sb * bx,
        so * ny + sb * by,
        so * nz + sb * bz,
        no * nx + nb * bx,
        no * ny + nb * by,
        no * nz + nb * bz,
    )


@njit(cache=True)
def edge_forces(body, own, side, speed, law):
    """Force and moment (about the centre of mass) of one edge on the wheelset, and N. side: +1 left, -1
    right.
    """
    if law[EXACT] != 0.0:
        contact = exact_contact(body, own, side, law)
    else:
        contact = textbook_contact(body, own, side, law)
    delta, x, y, z, tx, ty, tz, sx, sy, sz, nx, ny, nz = contact
    if not delta > 0.0:
        zero = 0.0 * delta
        return zero, zero, zero, zero, zero, zero, zero
    vx, vy, vz = point_velocity(body, x, y, z)
    vt = vx * tx + vy * ty + vz * tz
    vs = vx * sx + vy * sy + vz * sz
    rate = vx * nx + vy * ny + vz * nz
    normal = max(0.0, law[HERTZ] * delta * sqrt(delta) + law[DAMPING] * sqrt(delta) * rate)
    stiffness = law[CREEP] * (normal / law[NORMAL0]) ** (2.0 / 3.0) / speed
    linear = stiffness * sqrt(vt * vt + vs * vs)
    bound = law[FRICTION] * normal
    if linear >= 3.0 * bound:
        factor = bound / linear if linear > 0.0 else 0.0
    else:
        e = linear / bound
        factor = 1.0 - e / 3.0 + e * e / 27.0
    ft = -stiffness * factor * vt
    fs = -stiffness * factor * vs
    fx = ft * tx + fs * sx - normal * nx
    fy = ft * ty + fs * sy - normal * ny
    fz = ft * tz + fs * sz - normal * nz
    x -= body[0]
    y -= body[1]
    z -= body[2]
    return fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx, normal


@njit(cache=True)
def knife_edge_forces(q, q_t, path, step, speed, law, memory, out):
    """Add the generalised forces of both edges on the wheelset; memory: last place s, N left, N right.

    Returns the status of ``locate``.
    """
    body = kinematics(q, q_t)
    s, status = locate(path, step, body[0], body[1], body[2], memory[0])
    memory[0] = s
    own = frame(path, step, s)
    left = edge_forces(body, own, 1.0, speed, law)
    right = edge_forces(body, own, -1.0, speed, law)
    memory[1] = left[6]
    memory[2] = right[6]
    both = np.zeros(6)
    generalised_forces(
        body,
        (left[0] + right[0], left[1] + right[1], left[2] + right[2]),
        (left[3] + right[3], left[4] + right[4], left[5] + right[5]),
        both,
    )
    out[:6] += both
    return status


@dataclass(frozen=True)
class KnifeEdge:
    """Numbers of the law; the defaults are the three-dimensional example of the stability reference."""

    hertz: float = 1.4e11  # [N/m^1.5]
    damping: float = 2e7  # [N s/m^1.5]
    creep: float = 6e6  # [N] at
    normal0: float = 50e3  # [N] a wheel
    friction: float = 0.35
    radius: float = 0.46  # [m]
    half_spacing: float = 0.75  # [m]
    conicity: float = 0.05
    exact: bool = False

    def numbers(self) -> NDArray[np.float64]:
        """As the kernels read them."""
        return np.array(
            [
                self.hertz,
                self.damping,
                self.creep,
                self.normal0,
                self.friction,
                self.radius,
                self.half_spacing,
                atan(self.conicity),
                float(self.exact),
            ]
        )

    @property
    def wavelength(self) -> float:
        """Klingel's wavelength [m]: 2 pi sqrt(r0 l/lambda), textbook law times sqrt(1 + r0 lambda/l)."""
        half, r0 = self.half_spacing, self.radius
        coupling = 1.0 if self.exact else sqrt(1 + r0 * self.conicity / half)
        return 2 * pi * sqrt(r0 * half / self.conicity) * coupling

    def approach(self, wheel_load: float) -> float:
        """Static approach [m] under a vertical load on each wheel [N]."""
        return (wheel_load / cos(atan(self.conicity)) / self.hertz) ** (2 / 3)


class KnifeEdgeForces(VehicleOnTrack):
    """The force law of a single wheelset on knife edges along a track, straight ahead by default."""

    def __init__(
        self,
        vehicle: Vehicle,
        speed: float,
        track: Track | None = None,
        law: KnifeEdge | None = None,
        start: float = 0.0,
    ) -> None:
        self.law = (law or KnifeEdge()).numbers()
        self.edge_memory = np.array([start, 0.0, 0.0])
        super().__init__(vehicle, track or straight(), (), speed=speed, start=start)

    def __call__(self, t, q, q_t, out):
        status = super().__call__(t, q, q_t, out)
        path = self.track.centre
        if knife_edge_forces(q, q_t, path.table, path.step, self.speed, self.law, self.edge_memory, out):
            raise SimulationError(f"the wheelset cannot be placed on the track at t = {t:.6g} s")
        return status

    @property
    def system(self) -> System:
        """A new Exudyn system of the wheelset on its edges."""
        return System(self.bodies, self)

    def rolling(self, places: Mapping[str, float], unknowns: Sequence[str]) -> Equilibrium:
        """Steady rolling near the places given, with a height and a roll at which both edges carry."""
        q, q_t = design_state(self)
        for name, value in places.items():
            q[COORDINATES.index(name)] = value
        return held_state(self, q, q_t, unknowns)


def straight(length: float = 1000.0, heading: float = 0.0) -> Track:
    """A level straight track through the origin."""
    return Track.build([Straight(length)], heading=heading)


def bare_wheelset(mass: float = 1500.0, inertia: tuple[float, float, float] = (900.0, 100.0, 900.0)) -> Wheelset:
    """The wheelset of the three-dimensional example."""
    wheel = Wheel(profile=None, radius=0.46)  # type: ignore[arg-type]
    return Wheelset("example", mass, inertia, 1.5, wheel, replace(wheel))


def example_wheelset(
    spring: float | tuple[float, float, float] = 2e5,
    damping: tuple[float, float, float] = (0.0, 0.0, 0.0),
    axle_load: float = 100e3,
    wheelset: Wheelset | None = None,
    push: float = 0.0,
    **options: float,
) -> Vehicle:
    """The vehicle of the three-dimensional example: springs kx = ky [N/m] a side at +-1 m.

    push: lateral force at the centre of mass [N]; options: of ``single_wheelset``.
    """
    wheelset = wheelset or bare_wheelset()
    stiffness = spring if isinstance(spring, tuple) else (spring, spring, 0.0)
    vehicle = single_wheelset(wheelset, stiffness=stiffness, damping=damping, **options)
    force = (0.0, push, vehicle.weight - axle_load)
    return replace(vehicle, loads=(Load("load", "wheelset", force, (0.0, 0.0, wheelset.mean_radius)),))
