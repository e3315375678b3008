"""Does the contact law of the other codes explain where the results of our GZ18 differ from theirs?

Run: python campaigns/gz18_contact_law.py REFERENCE [LINE ...], with the folder that gz18.py takes. It prints the steady
motion with their law, the largest differences of ours from it over all wheelsets, and the least damped modes.

Their law, as the source of the car states it: where undeformed profiles, moved by the pose, overlap, the overlap of
depth p, half width w and area centroid y is taken for a Hertzian contact at y of the approach p / 0.55, with the
lateral radius w^2 / (2 p) and the rolling radius of the wheel, in the plane of the rail's slope at y. So read, the
static load and the rolling radius come out that the source prints for its offset of the rail at rest. Creep forces:
FASTSIM 21 x 21 with a parabolic bound, friction falling with the slip, no spin moment. Everything else is ours: the
car, the track, Newton's method for the steady motion. In numpy and slow; nothing in wrsim uses it.
"""

import sys
import tempfile
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from gz18 import CANT_MM, reference_folder, steady
from scipy.interpolate import CubicSpline
from scipy.special import elliprd, elliprf

from wrsim.analysis import run
from wrsim.analysis import steady as solver
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.creep.flexibility import kalker_coefficients
from wrsim.contact.tables import creep_coefficients
from wrsim.jit.linalg import Vec
from wrsim.scenario.build import build
from wrsim.simulation.force_law import Block, all_on_all
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise
from wrsim.simulation.placement import TrackPoses, poses_on_track
from wrsim.simulation.steady_state import Equilibrium, steady_state
from wrsim.simulation.system import Array
from wrsim.track.path_kernel import frame_at
from wrsim.vehicle.dynamics.kinematics import add_generalised_forces, kinematics
from wrsim.vehicle.dynamics.wheel_forces import wheel_wrench

VARIANTS: dict[str, dict[str, Any]] = {
    "Kik-Piotrowski, FASTSIM": {"contact.normal": "kik-piotrowski"},
    "the same, friction 0.3 that does not fall": {"contact.normal": "kik-piotrowski", "contact.friction": 0.3},
    "Kik-Piotrowski, FaStrip": {"contact.normal": "kik-piotrowski", "contact.tangential": "fastrip"},
    "strips, FaStrip": {"contact.normal": "strips"},
}
"""What the modes are told of, beside the contact of the other codes."""

VIRTUAL = 0.55
CELLS = 21
E, NU = 210e9, 0.28
SHEAR, PLANE = 0.5 * E / (1.0 + NU), 0.5 * E / (1.0 - NU**2)
STEP, SPACING = 2e-5, 5e-5  # of the points on the wheel, of those that the rail's spline goes through [m]
LIFTED = 4.5e-5  # their wheels overlap the rails by so much less than ours do [m]
ENOUGH = 1e-6  # force left over, as a part of the weight
FRICTION = 0.3  # static


class Contact(NamedTuple):
    """Normal force [N], creep forces along x and the slope [N], angle [rad], creepages, place across [m]."""

    normal: float
    fx: float
    fy: float
    angle: float
    xi: float
    eta: float
    across: float


@cache
def sections(wheel: Any, rail: Any) -> tuple[Array, Array, Array, CubicSpline]:
    """Wheel: u, height, slope; rail: height over u."""
    u, w = wheel.at(np.linspace(0.0, wheel.length, int(wheel.length / STEP)))
    ur, wr = rail.at(np.linspace(0.0, rail.length, int(rail.length / STEP)))
    top = np.flatnonzero(np.diff(ur) > 1e-9)  # the part that is a graph over u
    first, last = top[0], top[-1]
    graph = slice(first, last + 1)
    keep = np.concatenate([[True], np.diff(np.round(ur[graph] / SPACING)) > 0])
    return u, w, np.gradient(w) / np.gradient(u), CubicSpline(ur[graph][keep], wr[graph][keep])


@lru_cache(maxsize=1)
def _ellipses() -> tuple[Array, Array]:
    """Logarithms of the ratio of the relative curvatures, along over across, and of that of the half axes b/a."""
    k = np.exp(np.linspace(np.log(40.0), -np.log(40.0), 2001))
    ratio = elliprd(0.0, k**2, 1.0) / elliprd(0.0, 1.0, k**2)
    return np.log(ratio[np.argsort(ratio)]), np.log(k[np.argsort(ratio)])


def hertz(approach: float, rx: float, ry: float) -> tuple[float, float, float]:
    """Normal force [N], half axes a along and b across [m] for an approach [m] and relative radii of curvature [m].

    With Carlson's integrals (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.3): 1/(2 rx) = p0 b R_D(0, k^2, 1) /
    (3 E* a^2), approach = p0 b R_F(0, 1, k^2) / E*, k = b/a.
    """
    k = float(np.exp(np.interp(np.log(ry / rx), *_ellipses())))
    flat = float(elliprf(0.0, 1.0, k**2))
    a = np.sqrt(2.0 * rx * approach * elliprd(0.0, k**2, 1.0) / (3.0 * flat))
    b = k * a
    return float(2.0 / 3.0 * np.pi * a * approach * PLANE / flat), float(a), float(b)


def fastsim(a: float, b: float, normal: float, creep: tuple[float, float, float], limit: float) -> tuple[float, float]:
    """Creep forces on the wheel [N] along x and across; creepages xi, eta, spin phi [1/m]; limit: friction."""
    xi, eta, phi = creep
    c11, c22, c23 = kalker_coefficients(creep_coefficients(NU), a / b)
    l1, l2 = 8.0 * a / (3.0 * c11 * SHEAR), 8.0 * a / (3.0 * c22 * SHEAR)
    l3 = np.pi * a * np.sqrt(a / b) / (4.0 * c23 * SHEAR)
    y = b * (2.0 * (np.arange(CELLS) + 0.5) / CELLS - 1.0)
    edge = a * np.sqrt(1.0 - (y / b) ** 2)
    dx = 2.0 * edge / CELLS
    most = limit * 2.0 * normal / (np.pi * a * b)
    px = py = np.zeros(CELLS)
    fx = fy = 0.0
    for i in range(CELLS):
        x = edge - (i + 0.5) * dx
        px = px - (xi / l1 - y * phi / l3) * dx
        py = py - (eta / l2 + x * phi / l3) * dx
        bound = most * (1.0 - (x / a) ** 2 - (y / b) ** 2)
        size = np.hypot(px, py)
        part = bound / np.maximum(size, bound)
        px, py = part * px, part * py
        fx += float(np.sum(px * dx)) * 2.0 * b / CELLS
        fy += float(np.sum(py * dx)) * 2.0 * b / CELLS
    return fx, fy


def contact(pose: Array, wheel: Any, rail: Any, radius: float, speed: float) -> tuple[Contact, Array] | None:
    """The contact at a pose (origin, axle, velocity, angular velocity) and (force, moment) at the wheel's origin."""
    origin, axle, velocity, omega = pose[:3], pose[3:6], pose[6:9], pose[9:12]
    u, w, slope, head = sections(wheel, rail)
    level = np.sqrt(1.0 - axle[0] ** 2)
    forward = (np.array([1.0, 0.0, 0.0]) - axle[0] * axle) / level
    down = np.cross(axle, forward)
    down = down if down[2] < 0.0 else -down
    rho = radius - w
    sine = -slope * axle[0] / level  # the lowest line of the turned wheel
    steep = np.abs(sine) < 0.5
    sine = np.where(steep, sine, 0.0)
    cosine = np.sqrt(1.0 - sine**2)
    points = origin + u[:, None] * axle + (rho * cosine)[:, None] * down + (rho * sine)[:, None] * forward
    o, height = points[:, 1], points[:, 2]
    inside = steep & (np.abs(slope) < 2.5) & (o > head.x[0]) & (o < head.x[-1])
    over = np.where(inside, head(np.where(inside, o, 0.0)) - height, -1.0)
    deepest = int(np.argmax(over))
    depth = float(over[deepest])
    if depth <= 0.0:
        return None
    first = last = deepest
    while first > 0 and over[first - 1] > 0.0:
        first -= 1
    while last < len(over) - 1 and over[last + 1] > 0.0:
        last += 1
    begin = np.interp(0.0, [over[first - 1], over[first]], [o[first - 1], o[first]])
    end = np.interp(0.0, [over[last + 1], over[last]], [o[last + 1], o[last]])
    ys = np.concatenate([[begin], o[first : last + 1], [end]])
    hs = np.concatenate([[0.0], over[first : last + 1], [0.0]])
    order = np.argsort(ys)
    ys, hs = ys[order], hs[order]
    if 0 < deepest < len(over) - 1:
        bend = over[deepest + 1] - 2.0 * depth + over[deepest - 1]
        if bend < 0.0:
            depth -= (over[deepest + 1] - over[deepest - 1]) ** 2 / (8.0 * bend)
    place = float(np.trapezoid(ys * hs, ys) / np.trapezoid(hs, ys))
    angle = float(np.arctan(head(place, 1)))
    c, s = np.cos(angle), np.sin(angle)
    half = 0.5 * (end - begin) / c
    p = depth * c
    pressed = slice(first, last + 1)
    order = np.argsort(o[pressed])
    at_wheel = float(np.interp(place, o[pressed][order], rho[pressed][order]))
    normal, a, b = hertz(p / VIRTUAL, at_wheel / c, half**2 / (2.0 * p))
    shift = float(np.interp(place, o[pressed][order], points[pressed, 0][order]))
    point = np.array([shift, place, float(head(place))])
    slip = velocity + np.cross(omega, point - origin)
    across = np.array([0.0, c, s])
    up = np.array([0.0, -s, c])
    xi, eta, phi = slip[0] / speed, slip @ across / speed, omega @ up / speed
    limit = 0.3 * (0.6 * np.exp(-0.55 * speed * np.hypot(xi, eta)) + 0.4)
    fx, fy = fastsim(a, b, normal, (xi, eta, phi), limit)
    force = normal * up + fy * across + np.array([fx, 0.0, 0.0])
    return Contact(normal, fx, fy, angle, xi, eta, place), np.concatenate([force, np.cross(point - origin, force)])


class EquivalentElasticOnTrack(VehicleOnTrack):
    """The law of the vehicle with their contact in the place of ours; ``contacts``: those of the last state."""

    contacts: list[list[Contact | None]]

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> int:
        """See ``ForceLaw``."""
        status = super().__call__(t, q, q_t, out)
        self.contacts = []
        for w in range(len(self.wheels)):
            self._exchange(w, q, q_t, out)
        return status

    def blocks(self) -> list[Block]:
        """Forces without contacts, and those of their contacts."""
        without = np.zeros(self.size)

        def contacts(t: float, q: Array, q_t: Array, out: Array) -> None:
            self(t, q, q_t, out)
            self.on_bodies(t, q, q_t, without)
            out -= without

        return [Block(self.on_bodies, all_on_all(self.size)), Block(contacts, all_on_all(6 * len(self.wheels)))]

    def _exchange(self, w: int, q: Array, q_t: Array, out: Array) -> None:
        coordinates = slice(6 * w, 6 * w + 6)
        body = kinematics(q[coordinates], q_t[coordinates])
        change = np.zeros((2, 3))
        rails = self.track.left.curve, self.track.right.curve
        contacts_of_wheelset: list[Contact | None] = []
        for wheel, rail, place in zip(self.wheels[w], rails, self.wheel_records(w), strict=True):
            contact_and_force = self._contact(wheel)
            more = wheel.model.arrays.total.copy()
            values = np.zeros(6) if contact_and_force is None else contact_and_force[1]
            for name, value in zip(("Ft", "Fo", "Fb", "Mt", "Mo", "Mb"), values, strict=True):
                more[name] = value - more[name]
            change += wheel_wrench(body, frame_at(rail, place.s), place.side, wheel.half_spacing, more)
            contacts_of_wheelset.append(None if contact_and_force is None else contact_and_force[0])
        add_generalised_forces(body, Vec(*change[0]), Vec(*change[1]), out[coordinates])
        self.contacts.append(contacts_of_wheelset)

    def _contact(self, wheel: WheelOnRail) -> tuple[Contact, Array] | None:
        model = wheel.model
        return contact(np.array(model.arrays.pose), model.wheel, model.rail, model.radius, self.speed)


def their_steady_motion(ours: solver.CurveMotion) -> tuple[EquivalentElasticOnTrack, Equilibrium]:
    """The steady motion with their contact, from that with ours, whose law it changes and leaves the contacts in."""
    law: Any = ours.law
    law.__class__ = EquivalentElasticOnTrack
    lifted = ours.q.copy()
    lifted[: 6 * len(law.bodies) : 6] += LIFTED
    equilibrium = steady_state(law, (lifted, ours.q_t), tolerance=ENOUGH, max_iterations=20, near=law)
    law(0.0, equilibrium.q, equilibrium.q_t, np.zeros(law.size))
    return law, equilibrium


def pose_of(law: VehicleOnTrack, equilibrium: Equilibrium, wheelset: int) -> TrackPoses:
    """Pose of a wheelset against the track."""
    coordinates = slice(6 * wheelset, 6 * wheelset + 6)
    place = law.start + law.vehicle.wheelsets[wheelset].x
    return poses_on_track(law.track.centre, equilibrium.q[None, coordinates], equilibrium.q_t[None, coordinates], place)


def differences(ours: xr.Dataset, law: EquivalentElasticOnTrack, equilibrium: Equilibrium) -> Array:
    """Ours from theirs, of every wheelset (w, 7): lateral shift [mm], yaw [mrad], N as a part of it, Tx and Ty as parts
    of mu N, Y and Q as parts of N, of the worse wheel."""
    rows = []
    for w in range(len(law.vehicle.wheelsets)):
        pose, sample = pose_of(law, equilibrium, w), ours.isel(wheelset=w)
        forces = []
        for side, c in enumerate(law.contacts[w]):
            wheel_sample = sample.isel(wheel=side)
            normal = np.nan_to_num(wheel_sample["N"].values)  # of the patches
            angle = np.nan_to_num(wheel_sample["contact_angle"].values) @ normal / normal.sum()
            cosine, sine = np.cos(angle), np.sin(angle)
            x, y, q = (float(wheel_sample[name]) for name in "XYQ")
            assert c is not None
            more = [(q * cosine + y * sine) - c.normal, -x - c.fx, (y * cosine - q * sine) + c.fy]
            cosine, sine = np.cos(c.angle), np.sin(c.angle)
            more += [y - (c.normal * sine - c.fy * cosine), q - (c.normal * cosine + c.fy * sine)]
            forces.append(np.array(more) / (c.normal * np.array([1.0, FRICTION, FRICTION, 1.0, 1.0])))
        worst = np.max(np.abs(forces), axis=0)
        lateral, yaw = float(sample["lateral_shift"]), float(sample["yaw"])
        shift = abs(abs(lateral) - abs(pose.lateral[0])), abs(abs(yaw) - abs(pose.yaw[0]))
        rows.append([1e3 * shift[0], 1e3 * shift[1], *worst])
    return np.array(rows)


def liveliest(law: VehicleOnTrack, q: Array, q_t: Array) -> str:
    """The least damped mode above 20 Hz about a steady motion, in words. The turning of the axes, 0.06 rad/s in a curve
    of 300 m, is left out."""
    values, vectors = np.linalg.eig(linearise(law, law.bodies, q, q_t).state_matrix)
    fast = np.flatnonzero((values.imag > 40.0 * np.pi) & (values.imag < 400.0 * np.pi))
    i = fast[np.argmax(values[fast].real)]
    wheelsets = np.abs(vectors[: 6 * len(law.vehicle.wheelsets), i]).reshape(-1, 6)
    name = law.vehicle.wheelsets[int(np.argmax(wheelsets[:, 2]))].name
    return f"{values[i].imag / (2.0 * np.pi):.1f} Hz, grows by {values[i].real:+.2f} 1/s, mostly {name}"


def main() -> int:
    """Both curves with their contact, and what is about to swing with either."""
    if not sys.argv[1:]:
        raise SystemExit("python campaigns/gz18_contact_law.py REFERENCE [LINE ...]")
    reference = reference_folder(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.argv[2:] or CANT_MM:
            print(f"{line}; least damped mode above 20 Hz:")
            for name, values in VARIANTS.items():
                setup = build(steady(reference, Path(folder), line, values))
                ours = solver.steady_in_curve(setup, setup.plan.points[0])
                print(f"  {name}: {liveliest(ours.law, ours.q, ours.q_t)}")
            setup = build(steady(reference, Path(folder), line))
            law, equilibrium = their_steady_motion(solver.steady_in_curve(setup, setup.plan.points[0]))
            print(f"  their contact: {liveliest(law, equilibrium.q, equilibrium.q_t)}")
            print(f"with their contact; largest force left over {equilibrium.residual:.1e} of the weight")
            for w, mounted in enumerate(law.vehicle.wheelsets):
                pose = pose_of(law, equilibrium, w)
                print(
                    f"  {mounted.name}: lateral {1e3 * pose.lateral[0]:.3f} mm, yaw {1e3 * pose.yaw[0]:.3f} mrad, "
                    f"roll {1e3 * pose.roll[0]:.3f} mrad"
                )
                for side, c in zip(("left", "right"), law.contacts[w], strict=True):
                    if c is not None:
                        print(
                            f"    {side:5s} N {c.normal / 1e3:.2f} Tx {c.fx / 1e3:.2f} Ty {c.fy / 1e3:.2f} kN, angle "
                            f"{np.degrees(c.angle):.2f} deg, creepages {1e3 * c.xi:.2f}, {1e3 * c.eta:.2f} per mille"
                        )
            for name in ("strips", "kik-piotrowski"):
                sample = run(steady(reference, Path(folder), line, {"contact.normal": name})).dataset.isel(pose=0)
                print(f"largest differences of {name} from it, wheelset by wheelset:")
                for row in differences(sample, law, equilibrium):
                    form = "  {:.3f} mm, {:.3f} mrad, N {:.2%}, Tx {:.2%}, Ty {:.2%} of mu N, Y {:.2%}, Q {:.2%} of N"
                    print(form.format(*row))
    return 0


if __name__ == "__main__":
    sys.exit(main())
