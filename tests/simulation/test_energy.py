"""Energy: kept where nothing takes it away, and taken away by creep forces alone, never given.

The potential energy of the contact is the integral of its own static force law, so these tests ask for nothing but
that the integrator, the wheelset and the contact agree with each other."""

from functools import cache
from itertools import product
from typing import get_args

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from support import runs

from wrsim import Arc, ContactSettings, Straight, load
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.settings import Normal
from wrsim.contact.workspace import WARM_TOLERANCE
from wrsim.scenario.build import Setup, build
from wrsim.simulation.force_law import COORDINATES, DIFFERENCE_TOLERANCE, SMALL, SMALL_RATE, force_derivative
from wrsim.simulation.integrate import CONTACT_TOLERANCE, Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import lower_on_rails
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

PLAIN = ContactSettings("kik-piotrowski", tangential="none", damping=0.0, strips=8)
"""Frictionless and undamped; few strips, for their number does not matter to the energy."""


class Bouncing:
    """The loaded axle as one rigid body of 10.2 t on cones and crowns, free of springs, dampers and friction."""

    def __init__(self) -> None:
        mass = runs.AXLE_LOAD / STANDARD_GRAVITY
        self.ride = runs.cone_ride([Straight(100.0)], 0.0, start=10.0, settings=PLAIN, mass=mass)
        steady = self.ride.steady(("z",))
        self.q, self.rest = steady.q, steady.q_t
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
        return sum(float(self.work(a)) for a, _ in self.contact(q)) + runs.AXLE_LOAD * (q[0] - self.q[0])

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


@pytest.mark.parametrize("normal", ["kik-piotrowski", pytest.param("strips", marks=pytest.mark.campaign)])
def test_a_ramp_of_cant_takes_no_energy(normal):
    # both rails turn by 67 mrad and lift and lower a wheel of 54 kN by 50 mm: 2.7 kJ to either side. What the rails'
    # slopes beside their origins have in it, 8 J, would come from nowhere if they were not counted
    segments = [runs.straight(20.0), runs.transition(20.0), runs.arc(30.0, 300.0, cant_mm=100.0)]
    values = {
        "contact.normal": normal, "contact.tangential": "none", "contact.damping_s_per_m": 0.0, "contact.strips": 12,
        "run.distance_m": 30.0, "output.patches_at_m": [],
    }  # fmt: skip
    setup = runs.setup_of(segments, 15.0, start=15.0, values=values)
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    motion = Integration(BodySystem(law.bodies, law), duration=2.0, step=1e-3, weight=law.vehicle.weight,
        sample_interval=1e-3,
    ).run(q, q_t)  # fmt: skip
    bare = VehicleOnTrack(law.vehicle, law.track, (), speed=law.speed, start=law.start, drive=law.drive)
    law.set_search_start(law.start)
    bare.set_search_start(bare.start)
    power = []
    for t, state, rates in zip(motion.times, motion.q, motion.q_t, strict=True):
        whole, rest = np.zeros(law.size), np.zeros(bare.size)
        law(t, state, rates, whole)
        bare(t, state, rates, rest)
        power.append((whole - rest) @ rates)
    # both contacts hold 2.1 J at the start and .1 J more in the arc
    assert np.abs(cumulative_trapezoid(power, motion.times)).max() < 0.3


CURVES = {
    "steering, R 300": lambda: runs.setup_of([runs.arc(30.0, 300.0, 60.0)], 20.0, runs.STEERING, start=10.0),
    "leading, R 160": lambda: runs.setup_of([runs.arc(30.0, 160.0, 60.0)], 10.0, runs.LEADING, start=10.0),
    # the back of a flange touches the guard face 60 mm behind its axle, where the rail has turned by 2.4 mrad
    "tram, R -25": lambda: build(
        load(runs.SCENARIOS / "tram_r25.toml").with_values(
            {"run.start_distance_m": 13.0, "run.distance_m": 1.0, "output.patches_at_m": []}
        )
    ),
}


@pytest.mark.parametrize("curve", CURVES)
def test_the_frame_gives_what_the_creep_forces_dissipate(curve):
    """In steady curving the power of springs and weight on the wheelset is the wear number times the rolling speed."""
    setup = CURVES[curve]()
    axle = runs.ride(setup)
    q, q_t = start_state(setup, axle.law)
    axle.law.set_search_start(axle.law.start)
    axle.law(0.0, q, q_t, np.zeros(axle.law.size))
    bare = VehicleOnTrack(axle.vehicle, axle.track, (), speed=axle.law.speed, start=axle.law.start)
    bare.set_search_start(bare.start)
    forces = np.zeros(bare.size)
    bare(0.0, q, q_t, forces)
    arrays = [wheel.model.arrays for wheel in axle.law.wheels[0]]
    dissipated = sum(a.total["wear"] * a.pose[6] for a in arrays)
    # .10 % in R 160: bisectors of the normals pass the axle of a yawed wheel by some micrometres
    assert forces @ q_t == pytest.approx(dissipated, rel=1.5e-3)


# The derivative that an implicit step uses, of every contact law, beside central differences of cold contacts.
#
# Laws are taken from ``Normal`` and ``CREEP_LAWS``. An implicit step solves with the derivative of the fast model where
# the contact is exact, so half-space contacts have none of their own.
FAST_MODELS = [name for name in get_args(Normal) if name != "half-space"]
CREEP = [name for name in CREEP_LAWS if name != "half-space"]
POSES = {"tread": (1e-3, 2e-3, 40e-6), "root": (5.5e-3, 4e-3, 40e-6), "flange": (6.8e-3, 8e-3, 50e-6)}
"""Lateral shift [m], yaw [rad] and approach [m] of a wheelset."""

IMPLICIT = 1e3  # rate over displacement in an implicit step of 2 ms [1/s]
DIRECTIONS = [(1.0, 0.0), (0.0, 1.0), (1.0, IMPLICIT)]
SCALE = np.array([1.0, 1.0, 1.0, 0.46, 0.75, 0.46])  # a moment over its arm is a force [m]
SPANS = np.array([0.5, 1.0, 2.0])  # of second differences, over the step: creep forces have kinks
ALLOWED = 0.02  # part of the matrix: an iteration of Newton's method then leaves about so much of the residual


def pressed(law: VehicleOnTrack, lateral: float, yaw: float, approach: float) -> tuple[np.ndarray, np.ndarray]:
    """A wheelset that rolls with some creep in all directions, deeper in its rails than where they touch."""
    law.set_search_start(law.start)
    q, q_t = design_state(law, lateral=np.full(1, lateral))
    q[3] += yaw
    q, q_t = lower_on_rails(law, q, q_t)
    q[0] -= approach
    q_t[2] += 0.01
    q_t[5] *= 1.001
    return q, q_t


# the laws of runs, each pose once
CASES = [("strips", "fastsim", "tread"), ("strips", "fastrip", "root"), ("strips", "polach", "flange")]
CASES += [("kik-piotrowski", "fastsim", "root")]
LONG = [case for case in product(FAST_MODELS, CREEP, POSES) if case not in CASES]


@pytest.mark.parametrize(
    ("normal", "creep", "pose"), [*CASES, *(pytest.param(*case, marks=pytest.mark.campaign) for case in LONG)]
)
def test_the_derivative_is_that_of_the_forces(normal: str, creep: str, pose: str) -> None:
    """Off by no more than theory allows, twice h/2 f'' of a forward difference and 2 e/h of forces known to e; and that
    is little."""
    setup = runs.setup_of(
        [runs.straight(100.0)], 20.0, start=50.0, values={"contact.normal": normal, "contact.tangential": creep}
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
    known = (0.0, 0.0) if normal == "kik-piotrowski" else (WARM_TOLERANCE, DIFFERENCE_TOLERANCE * CONTACT_TOLERANCE)
    cold_error, warm_error = (carried * (tolerance + 1e-12) for tolerance in known)
    for by_q, by_q_t in DIRECTIONS:
        with law.following(CONTACT_TOLERANCE):
            law(0.0, q, q_t, np.zeros(law.size))
            derivative = force_derivative(law, q, q_t, 1, 0.0, by_q, by_q_t, central=False)[:6, :6] / SCALE[:, None]
        whole = np.linalg.norm(derivative / SCALE)
        for c, name in enumerate(COORDINATES):
            h = min(SMALL[name] / max(by_q, 1e-300), SMALL_RATE / max(by_q_t, 1e-300))
            unit = np.eye(law.size)[c] * h
            up, down = (np.array([cold(m * by_q * unit, m * by_q_t * unit) for m in way * SPANS]) for way in (1, -1))
            central = (up[1] - down[1]) / (2.0 * h)
            bent = np.linalg.norm((up + down - 2.0 * middle) / (SPANS[:, None] * h) ** 2, axis=1).max()
            noise = 2.0 * warm_error / h + cold_error / h
            error = np.linalg.norm(derivative[:, c] - central)
            assert error <= h * bent + noise, (name, by_q, by_q_t)
            assert h * bent + noise <= ALLOWED * SCALE[c] * whole, (name, by_q, by_q_t)


# A free conical wheelset on crowned rails, full contact model: Klingel's wave, and the line it rolls in a curve.
#
# Cones of conicity lambda on crowns of radius Rr whose tops are 2 L apart touch at +-l, l = L - Rr lambda. A wheelset
# shifted by y and rolled by phi touches where the crowns have the slopes lambda +- phi: both contacts move by -Rr phi
# on the rails. On the axle they then are at l -+ (y + (r0 + Rr) phi), so the radii differ by
#
#     r_left - r_right = 2 lambda (y + (r0 + Rr) phi),    phi = lambda y / (l - r0 lambda),
#
# the roll from the equal heights of wheels and rails. That makes the conicity of the wheelset in y
#
#     lambda (l + Rr lambda) / (l - r0 lambda),
#
# as Wickens has it. Without slip the wheels roll across as y' + r0 phi' = psi and turn as
# psi' = -(r_left - r_right) / (2 l r0), hence
#
#     wavelength = 2 pi sqrt(r0 l / lambda) sqrt(l / (l + Rr lambda))
#
# (on knife edges, Rr = 0, the roll has no influence at all), and in a curve of radius R
#
#     y = r0 l / (lambda R) (l - r0 lambda) / (l + Rr lambda)  outward.
KLINGEL = 2.0 * np.pi * np.sqrt(runs.RADIUS * runs.HALF_CONTACTS / runs.CONICITY)
"""The textbook's wavelength, without roll [m]."""

ROLLING_LINE = runs.RADIUS * runs.HALF_CONTACTS / runs.CONICITY
"""y R of the textbook, without roll [m2]."""

ROLL_FACTOR = (runs.HALF_CONTACTS - runs.RADIUS * runs.CONICITY) / (runs.HALF_CONTACTS + runs.CROWN * runs.CONICITY)
"""What roll and crown make of the line."""

FEW = ContactSettings("kik-piotrowski", strips=12, cells=6)
"""For long runs: cones on crowns touch where they touch, however many strips there are."""


@pytest.fixture(scope="module")
def wave():
    """A wheelset released 2 mm beside the centre, two waves long; slow, so that its inertia shortens nothing."""
    speed = 7.0
    free = runs.cone_ride([Straight(200.0)], speed, settings=FEW)
    start = free.steady(("z", "roll", "spin"), lateral=2e-3)
    motion = free.run(start.q, start.q_t, 35.0 / speed)
    return motion.q[:, 1], motion.q[:, 2], motion.q[:, 4]


def test_klingels_wave_has_its_length_rolls_the_wheelset_and_neither_dies_nor_grows(wave):
    x, y, _ = wave
    crossings = np.flatnonzero(np.diff(np.sign(y)))
    zeros = [x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i]) for i in crossings]
    assert len(zeros) >= 4
    wavelength = 2.0 * (zeros[-1] - zeros[0]) / (len(zeros) - 1)
    # 1 % is asked; found is 0.11 %. The textbook's wave, without roll, is 1 % longer
    assert wavelength == pytest.approx(KLINGEL * np.sqrt(runs.HALF_CONTACTS / runs.HALF_TOPS), rel=2e-3)
    _, y, roll = wave
    slope = np.polyfit(y, roll, 1)[0]
    assert slope == pytest.approx(runs.CONICITY / (runs.HALF_CONTACTS - runs.RADIUS * runs.CONICITY), rel=5e-3)
    _, y, _ = wave
    assert y.min() == pytest.approx(-2e-3, rel=0.05)
    assert y[len(y) // 2 :].max() == pytest.approx(2e-3, rel=0.05)


@pytest.mark.parametrize("radius", [1500.0, -1500.0, 3000.0])
def test_a_free_conical_wheelset_in_a_curve_sits_on_its_rolling_line(radius):
    # the cant carries the centrifugal force: nothing pushes the wheelset off its line
    speed = 20.0
    cant = 1.565 * np.sin(np.arctan(speed**2 / (9.80665 * abs(radius))))
    free = runs.cone_ride([Arc(400.0, radius, cant=cant)], speed, start=50.0)
    steady = free.steady(("z", "y", "heading", "roll", "spin"))
    motion = free.run(steady.q, steady.q_t, 1e-3)
    outward = -np.sign(radius) * free.poses(motion).lateral[0]
    assert outward == pytest.approx(ROLLING_LINE * ROLL_FACTOR / abs(radius), rel=5e-3)
    # in terms of where the wheels run, which is what rolls: no factor but that of the true spacing
    roll = -np.sign(radius) * free.poses(motion).roll[0]
    assert outward + (runs.RADIUS + runs.CROWN) * roll == pytest.approx(ROLLING_LINE / abs(radius), rel=5e-3)


# A run knows neither where north is nor what is left: turned, shifted and mirrored tracks, more than a full circle. The
# full contact model is in the loop; S1002 on 60E1 through a transition into a sharp curve, with contact on tread and
# flange root. Where both touch, strips come and go, and where one does a step earlier or later the strip model leaves
# up to 4e-7 of the load open: the leading wheelset has Kik-Piotrowski's contact.
LATERAL = ("lateral_shift", "yaw", "roll", "curvature", "cant", "y_contact", "guide_force_y", "guide_moment", "sum_Y")
"""Channels that change their sign in a mirror; those of wheels and patches are written outward and do not."""


@cache
def setup(vehicle: str) -> Setup:
    """2 m straight, 6 m of transition, 2 m of the arc at 12 m/s. Newton's method leaves the last digits open."""
    coarse = runs.FAST if vehicle == runs.LEADING else {"contact.strips": 12, "contact.cells": 6}
    values = {"run.integrator": "rk44"} | coarse
    return runs.setup_of(
        [runs.straight(2.0), runs.transition(6.0), runs.arc(2.0, 150.0, 50.0, 5.0)], 12.0, vehicle, values=values
    )


@cache
def reference(vehicle: str) -> xr.Dataset:
    """The run on the track as it is."""
    dataset = run_in_time(setup(vehicle)).wheelset()
    assert dataset.attrs["status"] == "completed"
    return dataset


def largest_differences(first: xr.Dataset, second: xr.Dataset) -> dict[str, float]:
    """Largest difference of every channel over its largest value; places without a value must agree."""
    differences = {}
    for name, channel in first.data_vars.items():
        if channel.dtype.kind == "f":
            a, b = channel.values, second[name].values
            assert np.array_equal(np.isnan(a), np.isnan(b)), name
            scale = np.nanmax(np.abs(a), initial=0.0)
            differences[str(name)] = np.nanmax(np.abs(a - b), initial=0.0) / (scale or 1.0)
        elif channel.dtype.kind in "iu":
            assert np.array_equal(channel.values, second[name].values), name
    return differences


@pytest.mark.parametrize(
    ("vehicle", "heading", "start"),
    [
        (runs.LEADING, 15.0, (1000.0, 2000.0, 300.0)),
        pytest.param(runs.STEERING, np.pi, (30.0, -40.0, 5.0), marks=pytest.mark.campaign),
    ],
)
def test_a_run_does_not_depend_on_the_direction_and_the_place_of_the_track(vehicle, heading, start):
    laid = run_in_time(runs.relaid(setup(vehicle), heading, start)).wheelset()
    differences = largest_differences(reference(vehicle), laid)
    # 1e-6 is asked; 2 km from the origin a coordinate has a round-off of 2e-13 m, 5e-9 of the approach
    worst = max(differences, key=lambda name: differences[name])
    assert differences[worst] < 1e-6, worst


@pytest.mark.parametrize("vehicle", [runs.LEADING, pytest.param(runs.STEERING, marks=pytest.mark.campaign)])
def test_a_left_curve_mirrors_a_right_curve(vehicle):
    mirror = run_in_time(runs.mirrored(setup(vehicle))).wheelset()
    mirror = mirror.isel(wheel=[1, 0])
    for name in LATERAL:
        mirror[name] = -mirror[name]
    # labels of the snapshots name the sides, and the snapshots are those of the same places
    differences = largest_differences(reference(vehicle), mirror)
    # 63 MN/m times the round-off of 16 m, over 0.3 kN
    assert differences.pop("guide_force_x") < 1e-8
    # a difference of forces four times as large, of the wheels that change places
    differences["sum_Y"] *= float(abs(mirror["sum_Y"]).max() / abs(mirror["Y"]).max())
    worst = max(differences, key=lambda name: differences[name])
    # strips end their search at 1e-9 of what presses them; the start agrees to 1e-12
    assert differences[worst] < 1e-7, worst


@pytest.mark.parametrize(("start", "end"), [(0.96, 1.03), pytest.param(0.01, 1.03, marks=pytest.mark.campaign)])
def test_more_than_a_full_circle_is_steady_all_the_way_round(start, end):
    # 25 m of radius is tight even for a tram. The circle is long, hence few strips and cells, and a step that only the
    # saturated creep forces of such a curve allow
    radius, speed = 25.0, 10.0
    coarse = runs.FAST | {"contact.strips": 8, "run.output_interval_ms": 20, "run.step_us": 500}
    way = 2.0 * np.pi * radius
    circle = runs.setup_of(
        [runs.arc(end * way, radius, 160.0, 15.0)], speed, runs.STEERING, start=start * way, values=coarse
    )
    dataset = run_in_time(circle).wheelset()
    assert dataset.attrs["status"] == "completed"
    assert dataset["distance"].values[0] < way < dataset["distance"].values[-1]
    for name in ("lateral_shift", "yaw", "roll", "spin_rate", "Y", "Q", "X", "contact_angle", "N", "p0"):
        channel = dataset[name].values
        # the long step tracks the turning to 5e-5 (a step of 200 us to 1e-7); at the track's end it goes straight on
        assert np.nanmax(np.ptp(channel[:-2], axis=0)) < 2e-4 * np.nanmax(np.abs(channel)), name
