"""Motors with gears and hollow axles: moments that close, energy, torsion, reactions on bogie and wheels, bad files."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import eigh
from support.rows import rows_of
from support.runs import straight
from support.vehicles import COARSE, ROOT, on_track, read_vehicle, shipped

from wrsim import InputError, Scenario, Straight, Track, load, run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import build
from wrsim.simulation.bodies import mass_matrix
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import steady_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.dynamics.kinematics import kinematics
from wrsim.vehicle.dynamics.rigid_body import pitched
from wrsim.vehicle.loads import Effort, Load

table = rows_of(__file__)

FILE = ROOT / "models/vehicles/manchester_motor.toml"
STIFFNESS, TURNING = 1.5e6, 12.0 + 4.5**2 * 1.2
"""Of the file: torsion of the hollow axle [N m/rad], inertia of all that turns there [kg m2]."""
Array = NDArray[np.float64]
Further = Callable[[VehicleOnTrack, Array, Array], float]


def balance(scenario: Scenario, further: Further | None = None) -> tuple[Array, Array, Array, Array]:
    """Times of a run on level track [s], and from its start on the change of kinetic energy, the work of the drive, and
    what creep has dissipated [J]. What weight and springs hold and dampers take is left out: when it is quiet they are
    as at the start.

    further: energy in a state (law, q, q_t) besides that of the bodies [J]."""
    setup = build(scenario)
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    system = BodySystem(law.bodies, law)
    motion = Integration(
        system, duration=setup.plan.duration, step=1.25e-3, weight=law.vehicle.weight, sample_interval=5e-3
    ).run(q, q_t)
    assert motion.status == "completed"
    n = 6 * len(law.bodies)
    powers, losses, energies = [], [], []
    for t, state, rates in zip(motion.times, motion.q, motion.q_t, strict=True):
        law.at(t, state, rates)
        powers.append(float(np.sum(law.axles["power"])))
        arrays = [wheel.model.arrays for pair in law.wheels for wheel in pair]
        losses.append(sum(float(a.total["wear"]) * float(a.pose[6]) for a in arrays))
        more = 0.0 if further is None else further(law, state, rates)
        energies.append(0.5 * rates[:n] @ mass_matrix(law.bodies, state)[:n, :n] @ rates[:n] + more)
    work, loss = (cumulative_trapezoid(p, motion.times, initial=0.0) for p in (powers, losses))
    return motion.times, np.array(energies) - energies[0], work, loss


def scenario(**keys: object) -> Scenario:
    """The motor coach on 130 m of straight track."""
    base = {"vehicle.model": "vehicles/manchester_motor.toml", "track.segments": [straight(130.0)]}
    base |= {"run.start_distance_m": 14.0, "run.output_interval_ms": 10.0}
    changes = {key.replace("__", "."): value for key, value in keys.items()}
    return load(ROOT / "scenarios/manchester_r300.toml").with_values(COARSE | base | changes)


def test_what_motor_gear_and_axle_take_from_each_other_is_the_rate_of_what_turns():
    vehicle = shipped("manchester_motor")
    (drive, _), moment = vehicle.drives, 8e3
    driven = replace(vehicle, efforts=(Effort(drive.wheelset, ((0.0, moment),)),))
    out = {}
    for name, variant in (("driven", driven), ("free", vehicle)):
        law = on_track(variant, 20.0).law
        q, q_t = design_state(law)
        q_t[law.gears[0]] = 2e-3  # twist of the hollow axle
        out[name] = np.zeros(law.size)
        law(0.0, q, q_t, out[name])
    on = out["driven"] - out["free"]
    pitch = 5 + 6 * np.arange(len(vehicle.parts))
    about = on[pitch]
    n, rotor = -4.5, 1.2
    rate = on[law.gears[0] + 1]
    assert rate == pytest.approx(moment / TURNING, rel=1e-9)
    # all moments, and the rate of the momentum of hollow axle and rotor
    assert about.sum() + (12.0 + n * rotor) * rate == pytest.approx(0.0, abs=1e-6 * moment)
    assert about[vehicle.index(drive.motor)] == pytest.approx(-moment / n, rel=1e-9)
    # the twist gives its moment to the wheelset, at once
    assert law.axles["shaft"][0] == pytest.approx(STIFFNESS * 2e-3, rel=1e-9)


def test_a_hollow_axle_loses_its_damping_times_the_square_of_its_rate():
    vehicle = shipped("manchester_motor")
    law = on_track(vehicle, 20.0).law
    q, q_t = design_state(law)
    q_t[law.gears[1] + 1] += 0.3  # of the second motor alone
    law(0.0, q, q_t, np.zeros(law.size))
    assert law.axles["loss"] == pytest.approx([0.0, vehicle.drives[1].damping * 0.3**2, 0.0, 0.0], rel=1e-6, abs=1e-9)


def in_space(name: str, **drive: float) -> VehicleOnTrack:
    """The bodies of a vehicle with their geared motors, which nothing else holds or carries."""
    vehicle = shipped(name)
    drives = tuple(replace(each, damping=0.0, **drive) for each in vehicle.drives)
    floating = replace(vehicle, elements=(), drives=drives, gravity=0.0)
    track = Track.build([Straight(200.0)], 1.5)
    return VehicleOnTrack(floating, track, (), speed=0.0, start=100.0, drive="free", gravity=0.0)


def kept(law: VehicleOnTrack, q: np.ndarray, q_t: np.ndarray) -> tuple[float, np.ndarray]:
    """Energy [J] and angular momentum (3,) of everything, from the rates of what turns and nothing else."""
    vehicle, energy, momentum = law.vehicle, 0.0, np.zeros(3)
    left, about = {}, {}
    for i, part in enumerate(vehicle.parts):
        coordinates = slice(6 * i, 6 * i + 6)
        body = kinematics(q[coordinates], q_t[coordinates])
        if i >= len(vehicle.wheelsets):
            body = pitched(body, q[coordinates][5])
        axes, omega, velocity = (
            np.array(x) for x in ((body.forward, body.left, body.up), body.omega, body.velocity)
        )  # fmt: skip
        turning = np.array(part.inertia) * (axes @ omega)
        energy += 0.5 * part.mass * velocity @ velocity + 0.5 * turning @ axes @ omega
        momentum += turning @ axes + part.mass * np.cross(body.position, velocity)
        left[part.name], about[part.name] = axes[1], omega
    for drive in vehicle.drives:
        twist = law.gears[vehicle.index(drive.wheelset)]
        n, hollow, rotor = drive.ratio, drive.hollow_inertia, drive.rotor_inertia
        e = left[drive.case]
        p = e @ about[drive.case]
        u = q_t[twist + 1] - (hollow + n * rotor) / (hollow + n**2 * rotor) * p
        energy += 0.5 * hollow * (u + p) ** 2 + 0.5 * rotor * (n * u + p) ** 2 + 0.5 * drive.stiffness * q_t[twist] ** 2
        momentum += hollow * (u + p) * e + rotor * (n * u + p) * left[drive.motor]
    return float(energy), momentum


@pytest.mark.parametrize(("name", "astray"), [("manchester_nose", 1e-10), ("manchester_motor", 1e-6)])
def test_motors_in_space_keep_energy_and_angular_momentum(name, astray):
    """They swing, and turn a tenth of a turn about all axes. Where the motor is a body of its own its axis and that of
    the case part, here by 100 mrad, and what the rotor takes to speed up is along the one or the other."""
    law = in_space(name)
    q, q_t = design_state(law)
    rates = q_t[: 6 * len(law.bodies)].reshape(-1, 6)
    rates[:, 3:] += np.random.default_rng(3).normal(size=(len(rates), 3)) * (0.3, 0.3, 0.5)
    for wheelset, twist in law.gears.items():
        rates[wheelset, 5], q_t[twist], q_t[twist + 1] = 40.0, 3e-3, 40.0
    energy, momentum = kept(law, q, q_t)
    system = BodySystem(law.bodies, law)
    system.solve(q, q_t, 0.0, 2e-4, 1000, lambda _t: True)
    after, turned = kept(law, system.q, system.q_t)
    assert after == pytest.approx(energy, rel=1e-7)
    assert np.abs(turned - momentum).max() < astray * np.linalg.norm(momentum)


@pytest.mark.parametrize("ratio", [-4.5, 3.0])
def test_the_hollow_axle_swings_between_wheelset_rotor_and_case(ratio):
    law = in_space("manchester_motor", ratio=ratio)
    q, q_t = design_state(law)
    values = np.linalg.eigvals(linearise(law, law.bodies, q, q_t).state_matrix)
    # rates of wheelset, case, and hollow axle against the case
    hollow, rotor, case = 12.0, 1.2, 20.0
    joint = hollow + ratio * rotor
    mass = np.diag([law.vehicle.wheelsets[0].inertia[1], case + hollow + rotor, hollow + ratio**2 * rotor])
    mass[1, 2] = mass[2, 1] = joint
    apart = np.array([-1.0, 1.0, 1.0])
    by_hand = sqrt(eigh(STIFFNESS * np.outer(apart, apart), mass, eigvals_only=True)[-1])
    assert np.abs(values).max() == pytest.approx(by_hand, rel=1e-9)


@cache
def pulling(moment: float) -> tuple[np.ndarray, dict[str, float]]:
    """Q of all wheels (4,) by wheelset and tension of the torque arms, at constant speed against a load at the
    height of the traction rods."""
    vehicle = shipped("manchester_motor")
    force = 2.0 * moment / 0.46
    drawbar = Load.constant("drawbar", "carbody", (-force, 0.0, 0.0), (0.0, 0.0, 0.6))
    names = [drive.wheelset for drive in vehicle.drives]
    efforts = tuple(Effort(name, ((0.0, moment),)) for name in names)
    law = on_track(replace(vehicle, loads=(drawbar,), efforts=efforts), 20.0).law
    steady = steady_state(law)
    law.at(0.0, steady.q, steady.q_t)
    q = np.array([sum(wheel.model.arrays.total["Fb"] for wheel in pair) for pair in law.wheels])
    arms = {
        element.name: float(record[0])
        for element, record in zip(vehicle.elements, law.records, strict=True)
        if "torque arm" in element.name
    }
    return q, arms


def test_the_torque_arm_holds_what_gear_and_rotor_turn_against():
    moment = 4e3
    arms, rest = pulling(moment)[1], pulling(0.0)[1]
    for name, tension in arms.items():
        # motor and case: M / n on the one, M - M / n on the other, 0.6 m from the axle; a strut ahead is pushed up
        by_hand = moment * (1.0 + 1.0 / 4.5) / 0.6 * (1.0 if "leading" in name else -1.0)
        assert tension - rest[name] == pytest.approx(by_hand, rel=0.02)


def test_pulling_unloads_the_leading_axle_of_the_bogie_by_the_height_of_its_rod():
    moment = 4e3
    change = pulling(moment)[0] - pulling(0.0)[0]
    force, rod, columns = 2.0 * moment / 0.46, 5e6, 2.0 * 160e3
    # rod and columns carry it side by side, 0.6 and 0.8275 m high; the body stays behind, and half of the moment of its
    # 16 t about the shifted ends of the columns is the bogie's
    height = (0.6 * rod + 0.8275 * columns) / (rod + columns)
    behind = force / (rod + columns)
    by_hand = (force * height + 0.5 * 16e3 * 9.80665 * behind) / 2.56
    assert change[0] == pytest.approx(-by_hand, rel=0.01)
    assert change[1] == pytest.approx(by_hand, rel=0.01)
    assert np.abs(change[2:]).max() < 0.01 * by_hand


def test_work_of_the_motors_is_kinetic_energy_or_lost_in_creep():
    efforts = [
        {"on": [drive.wheelset for drive in shipped("manchester_motor").drives],
         "time_s_moment_kNm": [[0.1, 0], [0.4, 6], [1.4, 6], [1.7, 0]]}
    ]  # fmt: skip

    def of_gears(law: VehicleOnTrack, _q: np.ndarray, q_t: np.ndarray) -> float:
        places = np.array(list(law.gears.values()))
        return float(0.5 * TURNING * np.sum(q_t[places + 1] ** 2) + 0.5 * STIFFNESS * np.sum(q_t[places] ** 2))

    driven = scenario(vehicle__drive="free", vehicle__efforts=efforts, run__time_s=2.6)
    _times, energy, spent, lost = balance(driven, of_gears)
    work, loss, gained = spent[-1], lost[-1], energy[-1]
    assert gained > 3e5
    assert work - loss == pytest.approx(gained, abs=1e-3 * gained)


def test_a_run_tells_what_the_hollow_axles_carry():
    efforts = [{"on": ["front.bogie.outer"], "time_s_moment_kNm": [[0, 0], [0.2, 5]]}]
    result = run(scenario(vehicle__drive="free", vehicle__efforts=efforts, run__time_s=1.2))
    data = result.dataset
    shaft, moment = (data[name].sel(wheelset="front.bogie.outer").values for name in ("shaft_moment", "drive_moment"))
    # what speeds up rotor, gear and hollow axle does not come to the wheelset
    speeding = np.gradient(data["spin_rate"].sel(wheelset="front.bogie.outer").values, data["time"].values)
    late = data["time"].values > 0.7
    assert np.mean(moment[late]) == pytest.approx(5e3)
    assert np.mean(shaft[late]) == pytest.approx(np.mean(moment[late] - TURNING * speeding[late]), rel=2e-3)
    # undriven axles have neither; the other motor only turns along
    assert float(np.abs(data["shaft_moment"].sel(wheelset="rear.outer")).max()) == 0.0


@pytest.mark.parametrize(("line", "said"), table("bad_drives_are_refused_with_file_and_key"))
def test_bad_drives_are_refused_with_file_and_key(tmp_path, line, said):
    text = FILE.read_text()
    assert line[0] in text
    (tmp_path / "bad.toml").write_text(text.replace(*line, 1))
    with pytest.raises(InputError) as told:
        read_vehicle(tmp_path / "bad.toml")
    assert said in str(told.value) and "bad.toml" in str(told.value)


NOSE_MASS, BEHIND, ARM = 2200.0, 0.45, 1.0
"""Of a motor [kg], of its centre and of its nose from the axle [m]."""


@cache
def pulling_away() -> xr.Dataset:
    """The shipped scenario, as far as its motors pull."""
    return run(load(ROOT / "scenarios/nose_suspended.toml").with_values(COARSE | {"run.time_s": 1.36})).dataset


def of_motor(name: str, time: float) -> tuple[float, float]:
    """Tension of the link of a nose and force of both bearings down on the axle at a time [s], in N."""
    sample = pulling_away().sel(time=time, method="nearest")
    link = sample["suspension_fx"].sel(suspension=f"front.{name} nose").item()
    sides = [f"front.{name} bearing {side}" for side in ("left", "right")]
    return link, -sample["suspension_fz"].sel(suspension=sides).sum().item()


def test_a_nose_suspended_motor_rests_on_its_axle_and_its_nose_by_the_lever():
    for name in ("leading", "trailing"):
        link, axle = of_motor(name, 0.0)
        weight = NOSE_MASS * 9.80665
        assert link == pytest.approx(weight * BEHIND / ARM, rel=2e-3)
        assert axle == pytest.approx(weight * (1.0 - BEHIND / ARM), rel=2e-3)


def test_its_moment_is_a_pair_of_forces_on_nose_and_axle():
    """M/l, less what the rotor takes to speed up: 7 kN m over 1 m. Behind the leading axle the nose pulls the frame
    down and relieves the axle; before the trailing one it is the other way round."""
    d = pulling_away()
    rate = (d["spin_rate"].sel(time=1.35, method="nearest") - d["spin_rate"].sel(time=1.0, method="nearest")) / 0.35
    n, rotor = -4.5, 1.2
    for i, (name, sign) in enumerate((("leading", 1.0), ("trailing", -1.0))):
        moment = 7e3 + n * (1.0 - n) * rotor * rate.values[i]
        link, axle = np.mean([of_motor(name, t) for t in np.arange(1.0, 1.35, 0.004)], axis=0) - of_motor(name, 0.0)
        assert link == pytest.approx(sign * moment / ARM, rel=0.01)
        assert axle == pytest.approx(-sign * moment / ARM, rel=0.01)
