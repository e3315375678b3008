"""Contact laws that can be solved by hand: conical wheels on knife-edge rails.

The rails are sharp edges along the track at y = +-half_spacing of the centre line, at the height of the
track plane. Each wheel is a cone, radius r0 where the undisplaced wheelset stands on the edge, conicity
tan(gamma) = lambda.

Normal force N = K delta^1.5 + c sqrt(delta) d(delta)/dt, never negative; creep force -C (N/N0)^(2/3) v/V,
saturated after Vermeulen and Johnson: T = mu N (e - e^2/3 + e^3/27), e = T_linear/(mu N) < 3. V is the speed
of the track-following frame; no spin. The law behind the growth rates of the three-dimensional example
(found by comparing variants with the published figures: all four speeds agree to 3 digits, no other variant
does): the wheel is touched at half_spacing -+ y along its axle, y the lateral shift of the centre of mass,
straight below the axle; the contact frame is the wheelset's own, tilted by the cone angle; the approach is
how deep that point lies below the edge."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from math import atan, cos, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from support.held import held_state
from wrsim import SimulationError, Straight, Track, Vehicle
from wrsim.jit import kernel
from wrsim.jit.frames import point_velocity
from wrsim.jit.linalg import Vec, add, components, cross, dot, from_components, mixed, sub
from wrsim.simulation.force_law import Block
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import Equilibrium
from wrsim.simulation.system import COORDINATES, BodySystem
from wrsim.track.path_kernel import frame_at, locate
from wrsim.vehicle.dynamics.kinematics import add_generalised_forces, kinematics
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import single_wheelset
from wrsim.vehicle.wheelset import Wheel, Wheelset

HERTZ, DAMPING, CREEP, NORMAL0, FRICTION, R0, HALF, GAMMA = range(8)


@kernel
def edge_contact(body, track_frame, side, law):
    """Approach, contact point (global), unit vectors t, s (tangent across) and n (out of the wheel)."""
    c, sine = cos(law[GAMMA]), sin(law[GAMMA])
    shift = side * dot(sub(body.position, track_frame.origin), track_frame.n)
    radius = law[R0] + sine / c * shift
    point = add(body.position, mixed(side * (law[HALF] - shift), body.left, -radius, body.up))
    depth = -dot(sub(point, track_frame.origin), track_frame.b)
    across = mixed(side * c, body.left, sine, body.up)
    return depth * c, point, body.forward, across, mixed(side * sine, body.left, -c, body.up)


@kernel
def edge_forces(body, track_frame, side, speed, law):
    """Force and moment (about the centre of mass) of one edge on the wheelset, and N. side: +1 left, -1
    right."""
    delta, point, t, s, n = edge_contact(body, track_frame, side, law)
    if not delta > 0.0:
        zero = 0.0 * delta
        return Vec(zero, zero, zero), Vec(zero, zero, zero), zero
    v = components(point_velocity(body, point), t, s, n)
    normal = max(0.0, law[HERTZ] * delta * sqrt(delta) + law[DAMPING] * sqrt(delta) * v.z)
    stiffness = law[CREEP] * (normal / law[NORMAL0]) ** (2.0 / 3.0) / speed
    linear = stiffness * sqrt(v.x * v.x + v.y * v.y)
    bound = law[FRICTION] * normal
    if linear >= 3.0 * bound:
        factor = bound / linear if linear > 0.0 else 0.0
    else:
        e = linear / bound
        factor = 1.0 - e / 3.0 + e * e / 27.0
    force = from_components(Vec(-stiffness * factor * v.x, -stiffness * factor * v.y, -normal), t, s, n)
    return force, cross(sub(point, body.position), force), normal


@kernel
def knife_edge_forces(q, q_t, curve, speed, law, memory, out):
    """Add the generalised forces of both edges on the wheelset; memory: last place s, N left, N right.

    Returns the status of ``locate``."""
    body = kinematics(q, q_t)
    memory[0], status = locate(curve, body.position, memory[0])
    track_frame = frame_at(curve, memory[0])
    for i in range(2):
        force, moment, memory[1 + i] = edge_forces(body, track_frame, 1.0 - 2.0 * i, speed, law)
        add_generalised_forces(body, force, moment, out[:6])
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

    def numbers(self) -> NDArray[np.float64]:
        """As the kernels read them."""
        return np.array([*astuple(self)[:-1], atan(self.conicity)])

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
        if knife_edge_forces(q, q_t, self.track.centre.curve, self.speed, self.law, self.edge_memory, out):
            raise SimulationError(f"the wheelset cannot be placed on the track at t = {t:.6g} s")
        return status

    def blocks(self):
        def on_edges(t, q, q_t, out):
            out.fill(0.0)
            knife_edge_forces(q, q_t, self.track.centre.curve, self.speed, self.law, self.edge_memory.copy(), out)

        return [*super().blocks(), Block(on_edges, [(column, np.arange(6)[None]) for column in np.arange(6)[:, None]])]

    @property
    def system(self) -> BodySystem:
        """A new Exudyn system of the wheelset on its edges."""
        return BodySystem(self.bodies, self)

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

    push: lateral force at the centre of mass [N]; options: of ``single_wheelset``."""
    wheelset = wheelset or bare_wheelset()
    stiffness = spring if isinstance(spring, tuple) else (spring, spring, 0.0)
    vehicle = single_wheelset(wheelset, stiffness=stiffness, damping=damping, **options)
    force = (0.0, push, vehicle.weight - axle_load)
    return replace(vehicle, loads=(Load.constant("load", "wheelset", force, (0.0, 0.0, wheelset.mean_radius)),))
