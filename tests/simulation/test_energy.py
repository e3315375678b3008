"""Energy: kept where nothing takes it away, and taken away by creep forces alone, never given.

The potential energy of the contact is the integral of its own static force law, so these tests ask for nothing but
that the integrator, the wheelset and the contact agree with each other.
"""

from functools import cache
from itertools import product
from typing import get_args

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from support.runs import AXLE_LOAD, LEADING, SCENARIOS, STEERING, arc, cone_ride, ride, setup_of, straight, transition

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.contact.settings import ContactSettings, Normal, Tangential
from wrsim.contact.workspace import WARM_TOLERANCE
from wrsim.geometry.track.segments import Straight
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.force_law import COORDINATES, SMALL, SMALL_RATE, force_derivative
from wrsim.simulation.integrate import OF_CONTACTS, Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

PLAIN = ContactSettings("kik-piotrowski", tangential="none", damping=0.0, strips=8)
"""Frictionless and undamped; few strips, for their number does not matter to the energy."""


# --- what is kept -----------------------------------------------------------------------------------------
class Bouncing:
    """The loaded axle as one rigid body of 10.2 t on cones and crowns, free of springs, dampers and friction."""

    def __init__(self) -> None:
        mass = AXLE_LOAD / STANDARD_GRAVITY
        self.ride = cone_ride([Straight(100.0)], 0.0, start=10.0, settings=PLAIN, mass=mass)
        found = self.ride.steady(("z",))
        self.q, self.rest = found.q, found.q_t
        deep = self.contact(self.q)[0][0]
        heights = self.q[0] + np.linspace(0.99 * deep, -deep, 1000)
        rows = [self.contact(np.array([z, *self.q[1:]]))[0] for z in heights]
        approach, lift = (np.array(column) for column in zip(*rows, strict=True))
        # work of one wheel against its vertical force, over the approach that goes with the height
        self.work = CubicSpline(approach, CubicSpline(-heights, lift).antiderivative()(-heights))

    def contact(self, q: np.ndarray) -> list[tuple[float, float]]:
        """Approach [m] and vertical force [N] of the two wheels."""
        self.ride.law(0.0, q, self.rest, np.zeros(6))
        arrays = [wheel.model.arrays for wheel in self.ride.law.wheels[0]]
        return [(float(a.patches["approach"][0]), float(a.total["Fb"])) for a in arrays]

    def potential(self, q: np.ndarray) -> float:
        """Energy of both contacts and of the weight against rest [J]."""
        return sum(float(self.work(a)) for a, _ in self.contact(q)) + AXLE_LOAD * (q[0] - self.q[0])

    def energy(self, q: np.ndarray, q_t: np.ndarray) -> float:
        """Potential and kinetic energy above rest [J]."""
        b = self.ride.body
        spin = q_t[5] + q_t[3] * np.sin(q[4])
        across = (q_t[3] * np.cos(q[4])) ** 2 + q_t[4] ** 2
        kinetic = 0.5 * (b.mass * q_t[:3] @ q_t[:3] + b.inertia[0] * across + b.inertia[1] * spin**2)
        return kinetic + self.potential(q) - self.potential(self.q)


@cache
def bouncing() -> Bouncing:
    """One for all tests."""
    return Bouncing()


def test_a_bouncing_wheelset_keeps_its_energy():
    # 20 um about a static approach of 65 um, at 480 rad/s. RK44 loses (omega h)^6 / 72 of the energy at every step:
    # 80 us make that 6e-6 in 10 s; 0.5 s are run. A wheelset without its load, at 1350 rad/s, would need 20 us.
    system = bouncing()
    q = system.q.copy()
    q[0] += 2e-5
    motion = system.ride.run(q, system.rest, 0.5, step=8e-5, every=0.005)
    energy = np.array([system.energy(a, b) for a, b in zip(motion.q, motion.q_t, strict=True)])
    assert energy[0] == pytest.approx(0.4435, rel=1e-2)  # 1/2 k a^2 with k = 2.35 GN/m, stiffer than linear below
    assert np.abs(energy / energy[0] - 1.0).max() < 5e-7
    assert energy[-1] < energy[0]
    assert np.abs(motion.q[:, 2:5]).max() < 1e-12  # straight up and down


@pytest.mark.parametrize("normal", ["strips", "kik-piotrowski"])
def test_a_ramp_of_cant_takes_no_energy(normal):
    # both rails turn by 67 mrad and lift and lower a wheel of 54 kN by 50 mm: 2.7 kJ to either side. What the rails'
    # slopes beside their origins have in it, 8 J, would come from nowhere if they were not counted
    segments = [straight(20.0), transition(20.0), arc(30.0, 300.0, cant_mm=100.0)]
    values = {
        "contact.normal": normal, "contact.tangential": "none", "contact.damping_s_per_m": 0.0, "contact.strips": 12,
        "run.distance_m": 30.0, "output.patches_at_m": [],
    }  # fmt: skip
    setup = setup_of(segments, 15.0, start=15.0, values=values)
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    motion = Integration(BodySystem(law.bodies, law), duration=2.0, step=1e-3, weight=law.vehicle.weight,
        sample_interval=1e-3,
    ).run(q, q_t)  # fmt: skip
    bare = VehicleOnTrack(law.vehicle, law.track, (), speed=law.speed, start=law.start, drive=law.drive)
    law.look_near(law.start)
    bare.look_near(bare.start)
    power = []
    for t, state, rates in zip(motion.times, motion.q, motion.q_t, strict=True):
        whole, rest = np.zeros(law.size), np.zeros(bare.size)
        law(t, state, rates, whole)
        bare(t, state, rates, rest)
        power.append((whole - rest) @ rates)
    # both contacts hold 2.1 J at the start and .1 J more in the arc
    assert np.abs(cumulative_trapezoid(power, motion.times)).max() < 0.3


# --- what creep forces take -------------------------------------------------------------------------------


CURVES = {
    "steering, R 300": lambda: setup_of([arc(30.0, 300.0, 60.0)], 20.0, STEERING, start=10.0),
    "leading, R 160": lambda: setup_of([arc(30.0, 160.0, 60.0)], 10.0, LEADING, start=10.0),
    "leading, R -400": lambda: setup_of([arc(30.0, -400.0, 60.0)], 20.0, LEADING, start=10.0),
    # the back of a flange touches the guard face 60 mm behind its axle, where the rail has turned by 2.4 mrad
    "tram, R -25": lambda: build(
        load(SCENARIOS / "tram_r25.toml").with_values(
            {"run.start_distance_m": 13.0, "run.distance_m": 1.0, "output.patches_at_m": []}
        )
    ),
}


@pytest.mark.parametrize("curve", CURVES)
def test_the_frame_gives_what_the_creep_forces_dissipate(curve):
    """In steady curving the power of springs and weight on the wheelset is the wear number times the rolling speed."""
    setup = CURVES[curve]()
    own = ride(setup)
    q, q_t = start_state(setup, own.law)
    own.law.look_near(own.law.start)
    own.law(0.0, q, q_t, np.zeros(own.law.size))
    bare = VehicleOnTrack(own.vehicle, own.track, (), speed=own.law.speed, start=own.law.start)
    bare.look_near(bare.start)
    given = np.zeros(bare.size)
    bare(0.0, q, q_t, given)
    arrays = [wheel.model.arrays for wheel in own.law.wheels[0]]
    dissipated = sum(a.total["wear"] * a.pose[6] for a in arrays)
    # .10 % in R 160: bisectors of the normals pass the axle of a yawed wheel by some micrometres
    assert given @ q_t == pytest.approx(dissipated, rel=1.5e-3)


# The derivative that an implicit step uses, of every contact law, beside central differences of cold contacts.
#
# Laws are taken from ``Normal`` and ``Tangential``. An implicit step solves with the derivative of the fast model where
# the contact is exact, so half-space contacts have none of their own.
FAST = [name for name in get_args(Normal) if name != "half-space"]
CREEP = [name for name in get_args(Tangential) if name != "half-space"]
POSES = {"tread": (1e-3, 2e-3, 40e-6), "root": (5.5e-3, 4e-3, 40e-6), "flange": (6.8e-3, 8e-3, 50e-6)}
"""Lateral shift [m], yaw [rad] and approach [m] of a wheelset."""

IMPLICIT = 1e3  # rate over displacement in an implicit step of 2 ms [1/s]
DIRECTIONS = [(1.0, 0.0), (0.0, 1.0), (1.0, IMPLICIT)]
SCALE = np.array([1.0, 1.0, 1.0, 0.46, 0.75, 0.46])  # a moment over its arm is a force [m]
SPANS = np.array([0.5, 1.0, 2.0])  # of second differences, over the step: creep forces have kinks
ALLOWED = 0.02  # part of the matrix: an iteration of Newton's method then leaves about so much of the residual


def pressed(law: VehicleOnTrack, lateral: float, yaw: float, approach: float) -> tuple[np.ndarray, np.ndarray]:
    """A wheelset that rolls with some creep in all directions, deeper in its rails than where they touch."""
    law.look_near(law.start)
    q, q_t = design_state(law, lateral=np.full(1, lateral))
    q[3] += yaw
    q, q_t = lower_on_rails(law, q, q_t)
    q[0] -= approach
    q_t[2] += 0.01
    q_t[5] *= 1.001
    return q, q_t


# every law, and every pose with the laws of a run
CASES = [(normal, creep, "root") for normal in FAST for creep in CREEP]
CASES += [("strips", "fastsim", "tread"), ("strips", "fastsim", "flange"), ("kik-piotrowski", "fastsim", "flange")]
LONG = [case for case in product(FAST, CREEP, POSES) if case not in CASES]


@pytest.mark.parametrize(
    ("normal", "creep", "pose"), [*CASES, *(pytest.param(*case, marks=pytest.mark.campaign) for case in LONG)]
)
def test_the_derivative_is_that_of_the_forces(normal: str, creep: str, pose: str) -> None:
    """Off by no more than theory allows, twice h/2 f'' of a forward difference and 2 e/h of forces known to e; and that
    is little."""
    setup = setup_of(
        [straight(100.0)], 20.0, start=50.0, values={"contact.normal": normal, "contact.tangential": creep}
    )
    law = force_law(setup)
    q, q_t = pressed(law, *POSES[pose])

    def cold(by_q: np.ndarray, by_q_t: np.ndarray) -> np.ndarray:
        out = np.zeros(law.size)
        law(0.0, q + by_q, q_t + by_q_t, out)
        return out[:6] / SCALE

    middle = cold(np.zeros(law.size), np.zeros(law.size))
    carried = sum(abs(wheel.model.arrays.total.Fb) for wheel in law.wheels[0])
    assert carried > 3e4
    known = (0.0, 0.0) if normal == "kik-piotrowski" else (WARM_TOLERANCE, OF_CONTACTS)
    cold_error, warm_error = (carried * (tolerance + 1e-12) for tolerance in known)
    for by_q, by_q_t in DIRECTIONS:
        with law.following(OF_CONTACTS):
            law(0.0, q, q_t, np.zeros(law.size))
            found = force_derivative(law, q, q_t, 1, 0.0, by_q, by_q_t, central=False)[:6, :6] / SCALE[:, None]
        whole = np.linalg.norm(found / SCALE)
        for c, name in enumerate(COORDINATES):
            h = min(SMALL[name] / max(by_q, 1e-300), SMALL_RATE / max(by_q_t, 1e-300))
            unit = np.eye(law.size)[c] * h
            up, down = (np.array([cold(m * by_q * unit, m * by_q_t * unit) for m in way * SPANS]) for way in (1, -1))
            central = (up[1] - down[1]) / (2.0 * h)
            bent = np.linalg.norm((up + down - 2.0 * middle) / (SPANS[:, None] * h) ** 2, axis=1).max()
            noise = 2.0 * warm_error / h + cold_error / h
            error = np.linalg.norm(found[:, c] - central)
            assert error <= h * bent + noise, (name, by_q, by_q_t)
            assert h * bent + noise <= ALLOWED * SCALE[c] * whole, (name, by_q, by_q_t)
