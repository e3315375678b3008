"""Dynamics of the wheelset in the integrator against what can be known: free bodies, Klingel, published growth rates.

The contact is a law on knife edges (support.knife_edge), so that only wheelset, carrier and integrator are tested.
"""

import numpy as np
import pytest
from scipy.optimize import curve_fit
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset

from wrsim.core.body.kinematics import kinematics
from wrsim.geometry.track.segments import Arc, Straight, Transition
from wrsim.geometry.track.track import Track
from wrsim.simulation.integrate import integrate
from wrsim.simulation.placement import place_on_track, poses_on_track
from wrsim.simulation.system import RigidBody, System
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

BODY = RigidBody(mass=1500.0, spin_inertia=100.0, cross_inertia=900.0)


def free(t, q, q_t, out):
    """No forces."""
    out.fill(0.0)


def momentum_and_energy(motion, body):
    """Angular momentum about the centre of mass (n, 3) and kinetic energy (n,)."""
    momentum, energy = [], []
    for q, q_t in zip(motion.q, motion.q_t, strict=True):
        state = kinematics(q, q_t)
        axle, omega, velocity = np.array(state.left), np.array(state.omega), np.array(state.velocity)
        along = omega @ axle
        momentum.append(body.cross_inertia * omega + (body.spin_inertia - body.cross_inertia) * along * axle)
        energy.append(0.5 * body.mass * velocity @ velocity + 0.5 * omega @ momentum[-1])
    return np.array(momentum), np.array(energy)


def test_a_free_spinning_wheelset_keeps_energy_and_angular_momentum():
    q = np.array([1.0, 2.0, 3.0, 0.5, 0.1, 0.0])
    q_t = np.array([0.3, 20.0, -1.0, 0.7, -0.4, 100.0])
    motion = integrate(System([BODY], free), q, q_t, duration=5.0, step=5e-4, integrator="rk44", sample_interval=0.05)
    momentum, energy = momentum_and_energy(motion, BODY)
    # drift of RK44 at 100 rad/s and h = 5e-4
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-7
    assert np.abs(momentum - momentum[0]).max() < 1e-6 * np.linalg.norm(momentum[0])
    assert motion.q[:, :3] == pytest.approx(q[:3] + motion.times[:, None] * q_t[:3], abs=1e-9)


def test_a_free_axle_precesses_about_its_angular_momentum():
    q = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0])
    q_t = np.array([0.0, 0.0, 0.0, 0.5, 0.2, 60.0])
    motion = integrate(System([BODY], free), q, q_t, duration=2.0, step=5e-4, integrator="rk44", sample_interval=0.05)
    momentum, _ = momentum_and_energy(motion, BODY)
    size = np.linalg.norm(momentum[0])
    axis = momentum[0] / size
    axle = np.array([kinematics(a, b).left for a, b in zip(motion.q, motion.q_t, strict=True)])
    # symmetric top: the axle turns about L at |L| / I_cross
    turn = size / BODY.cross_inertia * motion.times
    parallel = (axle[0] @ axis) * axis
    expected = (
        parallel
        + np.cos(turn)[:, None] * (axle[0] - parallel)
        + np.sin(turn)[:, None] * np.cross(axis, axle[0] - parallel)
    )
    assert axle == pytest.approx(expected, abs=1e-7)


def wheelset_on_edges(vehicle, speed, track=None, law=None, start=0.0):
    """System of a wheelset on knife edges, along a track's centre line or straight ahead."""
    return KnifeEdgeForces(vehicle, speed, track, law, start).system


def rest_height(law, axle_load=100e3):
    """Height of the axle of a wheelset at rest [m]."""
    return law.radius - law.approach(0.5 * axle_load)


def rolling(speed, law=None, lateral=0.0):
    """State of a wheelset that rolls along x."""
    law = law or KnifeEdge()
    q = np.array([rest_height(law), 0.0, lateral, 0.0, 0.0, 0.0])
    return q, np.array([0.0, speed, 0.0, 0.0, 0.0, speed / law.radius])


def growth_and_frequency(times, values):
    """Growth rate and angular frequency of a single growing or decaying oscillation."""
    values = values / np.abs(values).max()
    spectrum = np.abs(np.fft.rfft(values * np.hanning(len(values))))
    guess = 2 * np.pi * np.fft.rfftfreq(len(values), times[1] - times[0])[np.argmax(spectrum)]

    def model(t, growth, frequency, a, b, offset):
        t = t - t.mean()
        return np.exp(growth * t) * (a * np.cos(frequency * t) + b * np.sin(frequency * t)) + offset

    found, _ = curve_fit(model, times, values, [0.0, guess, 0.5, 0.5, 0.0])
    assert np.std(model(times, *found) - values) < 1e-3
    return found[0], found[1]


@pytest.mark.parametrize(
    ("speed", "growth", "frequency"),
    [(29.9, -0.927, 11.268), (44.8, -0.555, 16.874), (54.7, 0.177, 20.433), (64.7, 1.302, 23.743)],
)
def test_growth_rates_of_the_three_dimensional_example(speed, growth, frequency):
    system = wheelset_on_edges(example_wheelset(), speed)
    motion = integrate(
        system, *rolling(speed, lateral=1e-6), duration=4.5, step=5e-4, integrator="rk44", sample_interval=2e-3
    )
    late = motion.times > 1.0  # the other modes have died
    found = growth_and_frequency(motion.times[late], motion.q[late, 2])
    # the reference has three digits; 2 % is what the project asks
    assert found[0] == pytest.approx(growth, rel=0.007)
    assert found[1] == pytest.approx(frequency, rel=1e-3)


def test_critical_speed_of_the_three_dimensional_example():
    rates = []
    speeds = (52.0, 53.5)
    for speed in speeds:
        system = wheelset_on_edges(example_wheelset(), speed)
        motion = integrate(
            system, *rolling(speed, lateral=1e-6), duration=4.0, step=5e-4, integrator="rk44", sample_interval=2e-3
        )
        late = motion.times > 1.0
        rates.append(growth_and_frequency(motion.times[late], motion.q[late, 2])[0])
    assert np.interp(0.0, rates, speeds) == pytest.approx(52.74, rel=2e-3)


@pytest.mark.parametrize("exact", [False, True])
def test_klingel_wavelength_with_roll_coupling(exact):
    law = KnifeEdge(exact=exact)
    speed = 2.0  # slow: inertia shortens nothing
    system = wheelset_on_edges(example_wheelset(spring=0.0), speed, law=law)
    motion = integrate(
        system, *rolling(speed, law, lateral=1e-3), duration=12.0, step=2e-4, integrator="rk44", sample_interval=0.02
    )
    crossings = np.flatnonzero(np.diff(np.sign(motion.q[:, 2])))
    y, x = motion.q[:, 2], motion.q[:, 1]
    zeros = [x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i]) for i in crossings]
    assert len(zeros) >= 3
    wavelength = 2 * (zeros[-1] - zeros[0]) / (len(zeros) - 1)
    assert wavelength == pytest.approx(law.wavelength, rel=2e-3)


@pytest.mark.parametrize(("exact", "radius"), [(False, 2000.0), (False, -2000.0), (True, 2000.0)])
def test_a_free_conical_wheelset_in_a_curve_sits_at_the_rolling_line(exact, radius):
    law = KnifeEdge(exact=exact)
    # lateral springs damp Klingel's wave and leave the rolling line as it is: only yaw moments could move it
    vehicle = example_wheelset(spring=(0.0, 5e5, 0.0))
    track = Track.build([Straight(10.0), Transition(60.0), Arc(330.0, radius)])
    speed = 20.0
    q, q_t = place_on_track(track.centre, 5.0, speed=speed, height=rest_height(law), spin_rate=speed / law.radius)
    system = wheelset_on_edges(vehicle, speed, track, law, start=5.0)
    motion = integrate(system, q, q_t, duration=19.0, step=5e-4, integrator="rk44", sample_interval=0.01)
    poses = poses_on_track(track.centre, motion.q, motion.q_t, start=5.0)
    outward = -np.sign(radius) * poses.lateral[-100:]
    line = law.radius * law.half_spacing / (law.conicity * abs(radius))
    if exact:  # the contact runs along the axle by y + r0 roll = y (1 + r0 lambda / l)
        line /= 1.0 + law.radius * law.conicity / law.half_spacing
    assert np.ptp(outward) < 0.02 * line
    assert outward.mean() == pytest.approx(line, rel=0.01)


def test_the_spin_of_a_rolling_wheelset_is_the_way_over_the_radius():
    law = KnifeEdge()
    system = wheelset_on_edges(example_wheelset(), 20.0)
    q, q_t = rolling(20.0)
    q_t[5] *= 1.01  # one per cent too fast: friction brings it into step
    motion = integrate(system, q, q_t, duration=2.0, step=5e-4, integrator="rk44", sample_interval=0.1)
    assert motion.q_t[-1, 5] == pytest.approx(motion.q_t[-1, 1] / law.radius, rel=1e-5)
    assert motion.q[-1, 5] - motion.q[1, 5] == pytest.approx((motion.q[-1, 1] - motion.q[1, 1]) / law.radius, rel=1e-5)


def s_curve(heading=0.0, hand=1.0):
    """A short S of 300 and 250 m with cant."""
    return Track.build(
        [
            Straight(10.0),
            Transition(20.0),
            Arc(20.0, hand * 300.0, cant=0.06),
            Transition(20.0),
            Arc(20.0, -hand * 250.0, cant=0.05),
            Transition(20.0),
            Straight(10.0),
        ],
        heading=heading,
    )


def through(track, *, lateral=1e-3, speed=20.0, duration=4.0, law=None):
    """Poses of the damped example wheelset through a track."""
    law = law or KnifeEdge()
    load = 1500.0 * STANDARD_GRAVITY + 85e3
    vehicle = example_wheelset(1e6, (1e4, 2e4, 0.0), axle_load=load, push=np.sign(lateral) * 50.0)
    q, q_t = place_on_track(
        track.centre, 2.0, speed=speed, height=rest_height(law), spin_rate=speed / law.radius, lateral=lateral
    )
    system = wheelset_on_edges(vehicle, speed, track, law, start=2.0)
    motion = integrate(system, q, q_t, duration=duration, step=5e-4, integrator="rk44", sample_interval=5e-3)
    assert motion.status == "completed"
    poses = poses_on_track(track.centre, motion.q, motion.q_t, start=2.0)
    return np.array([poses.distance, poses.lateral, poses.height, poses.yaw, poses.roll, poses.spin_rate])


@pytest.mark.parametrize("exact", [False, True])
def test_the_motion_does_not_depend_on_the_direction_of_the_track(exact):
    law = KnifeEdge(exact=exact)
    reference = through(s_curve(), law=law)
    assert np.ptp(reference[1]) > 2e-3  # it does move
    for heading in (0.7, 2.5, -40.0):
        turned = through(s_curve(heading), law=law)
        difference = np.abs(turned - reference).max(axis=1) / np.ptp(reference, axis=1)
        assert np.all(difference < 1e-6), difference


@pytest.mark.parametrize("exact", [False, True])
def test_a_left_curve_mirrors_a_right_curve(exact):
    law = KnifeEdge(exact=exact)
    left = through(s_curve(), law=law)
    right = through(s_curve(hand=-1.0), lateral=-1e-3, law=law)
    mirror = np.array([1.0, -1.0, 1.0, -1.0, -1.0, 1.0])[:, None]
    assert np.abs(left - mirror * right).max() < 1e-9 * np.abs(left[1]).max()


def test_a_wheelset_rolls_through_more_than_a_full_circle():
    track = Track.build([Straight(10.0), Transition(30.0), Arc(700.0, 100.0)])
    law = KnifeEdge(conicity=0.3)  # the rolling line within 15 mm
    vehicle = example_wheelset(spring=1e6)
    q, q_t = place_on_track(track.centre, 5.0, speed=20.0, height=rest_height(law), spin_rate=20.0 / 0.46)
    system = wheelset_on_edges(vehicle, 20.0, track, law, start=5.0)
    motion = integrate(system, q, q_t, duration=36.0, step=5e-4, integrator="rk44", sample_interval=0.05)
    assert motion.status == "completed"
    assert motion.q[-1, 3] > 2 * np.pi
    poses = poses_on_track(track.centre, motion.q, motion.q_t, start=5.0)
    steady = poses.distance > 300.0
    assert np.ptp(poses.lateral[steady]) < 1e-4
    assert np.ptp(poses.yaw[steady]) < 1e-4


def test_a_bouncing_wheelset_keeps_its_energy():
    # Hertz springs alone: no damping, no creep; the vertical frequency is some 220 Hz and h = 2e-5 s resolves it.
    # RK44 loses energy at a steady rate: 1e-5 in 10 s is asked, 1 s is run
    law = KnifeEdge(damping=0.0, creep=0.0)
    system = wheelset_on_edges(example_wheelset(spring=0.0), 10.0, law=law)
    q, q_t = rolling(10.0)
    q[0] += 2e-5
    q_t[1] = q_t[5] = 0.0  # nothing but the bounce: the energy below is that of the vibration
    motion = integrate(system, q, q_t, duration=1.0, step=2e-5, integrator="rk44", sample_interval=1e-2)
    gamma = np.arctan(law.conicity)
    depth = np.maximum((law.radius - motion.q[:, 0]) * np.cos(gamma), 0.0)
    spring = 2 * 0.4 * law.hertz * depth**2.5
    energy = spring + 100e3 * motion.q[:, 0] + 0.5 * 1500.0 * motion.q_t[:, 0] ** 2
    rest = 2 * 0.4 * law.hertz * law.approach(50e3) ** 2.5 + 100e3 * rest_height(law)
    assert np.abs(energy - energy[0]).max() < 0.1e-5 * (energy[0] - rest)
