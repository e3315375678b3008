"""Wheels that turn against each other: independent ones, and axles that twist."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from support.boxes import derivatives, displaced, moment_kept, on_springs, symmetric
from support.rows import rows_of
from support.runs import FAST, LEADING, ROOT, SCENARIOS, arc, setup_of, straight, transition
from support.scenario_texts import CURVE, STATIC, faults
from support.vehicle_texts import fault
from support.vehicles import manchester, on_track, shipped

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.body_channels import energy_channels
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.analysis.stationary.statics import static_state
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.vehicle.bogies import level_of
from wrsim.vehicle.elements import Element, Spring
from wrsim.vehicle.loads import Effort, Load
from wrsim.vehicle.preload import preloads
from wrsim.vehicle.vehicle import AxleBox, Body, Vehicle
from wrsim.vehicle.wheelset import Torsion

table = rows_of(__file__)

Array = NDArray[np.float64]

RIGID, INDEPENDENT = None, Torsion()
SPIN = 5


def with_axle(vehicle: Vehicle, torsion: Torsion | None) -> Vehicle:
    """The vehicle with axles of another kind."""
    return vehicle.with_wheelsets(lambda wheelset: replace(wheelset, torsion=torsion))


def wheelset(torsion: Torsion | None, radius: float = 300.0, values: Mapping[str, Any] | None = None) -> Setup:
    """A leading wheelset on its guide frame in a full curve, or on straight track."""
    segments = [straight(30.0)] if radius == inf else [arc(30.0, radius, 60.0)]
    setup = setup_of(segments, 15.0, LEADING, start=10.0, values=FAST | dict(values or {}))
    return replace(setup, vehicle=with_axle(setup.vehicle, torsion))


@cache
def steady(torsion: Torsion | None, radius: float = 300.0, push: float = 0.0) -> tuple[VehicleOnTrack, Array, Array]:
    """Its law, and the state of steady motion; push: a force to the left [N]."""
    setup = wheelset(torsion, radius)
    load = Load.constant("push", "wheelset", (0.0, push, 0.0), (0.0, 0.0, 0.46))
    setup = replace(setup, vehicle=replace(setup.vehicle, loads=(load,)))
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    law.at(0.0, q, q_t)
    return law, q, q_t


def along(law: VehicleOnTrack) -> Array:
    """Longitudinal force on both wheels [N]."""
    return np.array([float(wheel.model.arrays.total["Ft"]) for wheel in law.wheels[0]])


def about_axle(law: VehicleOnTrack) -> Array:
    """Moment of the contact about the axle, of both wheels [N m]."""
    return np.array([np.dot(tuple(record.moment), tuple(record.body.left)) for record in law.wheel_records(0)])


@pytest.mark.parametrize("radius", [300.0, inf])
def test_independent_wheels_in_steady_motion_are_not_driven(radius):
    law, _, _ = steady(INDEPENDENT, radius)
    # the sprung mass leans about the track's direction, so that under a yaw some newton metres of it turn the axle
    assert about_axle(law) == pytest.approx(0.0, abs=20.0)
    assert np.diff(about_axle(law)) == pytest.approx(0.0, abs=1e-3)
    # what pushes aside under the angle of attack has a share lengthwise; two patches on unequal radii hold each other
    rigid = np.abs(along(steady(RIGID, radius)[0])).max()
    assert np.abs(along(law)).max() < max(0.02 * rigid, 5.0)
    assert rigid > (1e4 if radius < inf else 0.0)


def test_independent_wheels_roll_at_the_speeds_of_their_rails_and_do_not_steer():
    law, q, q_t = steady(INDEPENDENT)
    spin, apart = q_t[SPIN], q_t[law.twists[0]]
    for wheel, record, rate in zip(
        law.wheels[0], law.wheel_records(0), (spin + 0.5 * apart, spin - 0.5 * apart), strict=True
    ):
        radius = float(wheel.model.arrays.pose[6]) / rate
        lowest = 0.46 + 1e-3 * (12.0 if record.side < 0.0 else 1.0)  # the outer wheel on the root of its flange
        assert 0.459 < radius < lowest
    assert q[law.twists[0]] == 0.0
    # a rigid wheelset off centre turns towards the middle: its wheels push lengthwise against each other
    moments = {}
    for torsion in (RIGID, INDEPENDENT):
        law, q, _ = steady(torsion, inf, 2e3)
        assert q[2] > 1e-4
        moments[torsion] = abs(float(along(law) @ np.array([-0.75, 0.75]))) / q[2]
    # at this push the search leaves 33 N over, where a patch begins: some 30 N m turn the wheels still
    assert moments[INDEPENDENT] < 5e-3 * moments[RIGID]


def test_independent_wheels_drift_to_a_flange_where_rigid_ones_hunt():
    """At 70 m/s the coach hunts at some 42 rad/s; with independent wheels nothing turns wheelsets back and forth."""
    growing = {}
    setup = build(load(SCENARIOS / "stability_manchester.toml").with_values(FAST))
    for torsion in (RIGID, INDEPENDENT):
        rolling = RollingVehicle(replace(setup, vehicle=with_axle(setup.vehicle, torsion)), 70.0)
        values = np.linalg.eigvals(linearise(rolling.law, rolling.law.bodies, *rolling.state(70.0)).state_matrix)
        growing[torsion] = np.abs(values[values.real > 0.1].imag)
    assert growing[RIGID].min() > 30.0
    assert len(growing[INDEPENDENT]) == 4
    assert growing[INDEPENDENT].max() < 2.0


def test_the_frame_gives_what_creep_takes_with_independent_wheels():
    law, q, q_t = steady(INDEPENDENT)
    forces = np.zeros(law.size)
    VehicleOnTrack(law.vehicle, law.track, (), speed=15.0, start=10.0)(0.0, q, q_t, forces)
    arrays = [wheel.model.arrays for wheel in law.wheels[0]]
    dissipated = sum(float(a.total["wear"]) * float(a.pose[6]) for a in arrays)
    assert forces[:6] @ q_t[:6] == pytest.approx(dissipated, rel=5e-3)


def test_a_moment_on_one_wheel_turns_that_wheel_alone():
    vehicle = with_axle(manchester(), INDEPENDENT)
    name = vehicle.wheelsets[0].name
    for side, wheel in ((1.0, "left"), (-1.0, "right")):
        effort = Effort(name, ((0.0, 1e3),), wheel=wheel)
        law = VehicleOnTrack(
            replace(vehicle, efforts=(effort,)), on_track(vehicle).law.track, (), speed=15.0, start=60.0, drive="free"
        )
        q, q_t = design_state(law)
        plain, out = np.zeros(law.size), np.zeros(law.size)
        VehicleOnTrack(vehicle, law.track, (), speed=15.0, start=60.0, drive="free")(0.0, q, q_t, plain)
        for _ in range(2):  # no call adds to the one before
            law(0.0, q, q_t, out)
        inertia = law.bodies[0].inertia[1]
        mean = (out - plain)[SPIN] / inertia
        difference = (out - plain)[law.twists[0]]
        assert mean + 0.5 * side * difference == pytest.approx(1e3 / (0.5 * inertia))
        assert mean - 0.5 * side * difference == pytest.approx(0.0, abs=1e-9)


def test_an_axle_twists_as_discs_on_a_shaft_and_is_rigid_in_steady_motion():
    stiffness = 5e6
    vehicle = with_axle(manchester(), Torsion(stiffness, 100.0))
    twisting = [mode for mode in natural_modes(vehicle) if mode.name == "axles twist"]
    disc = 0.5 * vehicle.wheelsets[0].wheelset.inertia[1]
    assert len(twisting) == len(vehicle.wheelsets)
    for mode in twisting:
        assert mode.frequency == pytest.approx(sqrt(stiffness * (2.0 / disc)) / (2.0 * pi), rel=1e-6)
        assert mode.damping == pytest.approx(0.5 * 100.0 * sqrt(2.0 / disc / stiffness), rel=1e-4)
    # whatever its stiffness: it winds up until both wheels turn alike
    law, q, _ = steady(Torsion(5e6))
    rigid, q_other, _ = steady(RIGID)
    assert q[:5] == pytest.approx(q_other[:5], abs=1e-8)
    assert along(law) == pytest.approx(along(rigid), rel=1e-5)
    left, right = about_axle(law)
    assert abs(left - right) > 5e3
    assert 5e6 * q[law.twists[0]] == pytest.approx(0.5 * (left - right), rel=1e-6)


@cache
def into_a_curve(torsion: Torsion | None) -> xr.Dataset:
    """The leading wheelset from straight track into a curve."""
    segments = [straight(6.0), transition(10.0), arc(8.0, 300.0, 60.0)]
    setup = setup_of(segments, 15.0, LEADING, values=FAST | {"run.output_interval_ms": 10.0})
    dataset = run_in_time(replace(setup, vehicle=with_axle(setup.vehicle, torsion))).dataset
    assert dataset.attrs["status"] == "completed"
    return dataset


@pytest.mark.parametrize(("torsion", "like"), [(Torsion(1e9, 1e4), RIGID), (Torsion(1.0), INDEPENDENT)])
def test_a_stiff_axle_is_a_rigid_one_and_a_soft_one_leaves_its_wheels_alone(torsion, like):
    ours, limit_case = into_a_curve(torsion), into_a_curve(like)
    assert ours["lateral_shift"].values == pytest.approx(limit_case["lateral_shift"].values, abs=5e-6)
    for name in ("X", "Y"):
        assert ours[name].values == pytest.approx(
            limit_case[name].values, abs=0.005 * float(np.abs(limit_case["Y"]).max())
        )


def vehicle_text(tmp_path, more: str) -> str:
    """A scenario of a wheelset whose file has one line more, beside it."""
    text = (ROOT / "models" / LEADING).read_text(encoding="utf-8")
    (tmp_path / "own.toml").write_text(text.replace("radius_mm = 460", f"radius_mm = 460\n{more}\n"), encoding="utf-8")
    return "own.toml"


@pytest.mark.parametrize(("more", "said"), [
    ("independent_wheels = true\ntorsional_stiffness_kNm_per_rad = 5000", "cannot be given with independent_wheels"),
    ("torsional_damping_kNms_per_rad = 5", "goes with torsional_stiffness_kNm_per_rad"),
])  # fmt: skip
def test_bad_axles_are_refused_with_file_and_key(tmp_path, more, said):
    messages = faults(CURVE.replace("vehicles/wheelset_s1002.toml", vehicle_text(tmp_path, more)), tmp_path)
    assert len(messages) == 1
    assert "own.toml:" in messages[0]
    assert said in messages[0]


def test_where_rigid_wheelsets_are_meant_others_are_refused(tmp_path):
    vehicle_file = vehicle_text(tmp_path, "independent_wheels = true")
    (fault,) = faults(STATIC.replace("vehicles/wheelset_s1002.toml", vehicle_file), tmp_path)
    assert fault.startswith('case.toml:3: vehicle.model = "own.toml": has wheels that turn against each other')
    effort = '\n[[vehicle.efforts]]\nmoment_kNm = 1\nwheel = "left"\n'
    (fault,) = faults(CURVE + effort, tmp_path)
    assert "vehicle.efforts[0].wheel" in fault
    assert "rigid axle" in fault
    control = effort + "[vehicle.slip_control]\ncreepage = 0.1\n"
    (fault,) = faults(CURVE.replace("vehicles/wheelset_s1002.toml", vehicle_file) + control, tmp_path)
    assert "vehicle.slip_control" in fault


# Axle boxes: bodies that turn freely about their axle. Laws of one arm, and of a whole car on eight.
MASS, REACH, RADIUS, Y, INERTIA = 4000.0, 0.5, 0.46, 1.0, 3.0
BUSHING = (2e7, 9e6, 1e7)
AXLE, FRAME, END = (0.0, 0.0, RADIUS), (0.3, 0.0, 0.7), (REACH, 0.0, RADIUS + 0.1)


def spring(box: str, place: tuple[float, float, float], name: str = "", **values: object) -> Spring:
    """From the frame to an axle box; y of the left one."""
    side = 1.0 if box.endswith("left") else -1.0
    point = (place[0], side * Y, place[2])
    return replace(Spring(f"{name} {box}", "spring", "frame", box, point), **values)  # type: ignore[arg-type]


def on_arms(*more: Element) -> Vehicle:
    """A frame on one wheelset, each of whose boxes has an arm that ends in a bushing; without weight."""
    first = manchester().wheelsets[0]
    boxes = tuple(AxleBox(f"box {s}", y, 5.0, (1.0, INERTIA, 1.0)) for s, y in (("left", Y), ("right", -Y)))
    wheelset = replace(first, x=0.0, height=RADIUS, boxes=boxes)
    bushings = [spring(box.name, END, "bushing", stiffness=BUSHING) for box in boxes]
    frame = Body("frame", MASS, (1000.0, 3000.0, 3500.0), FRAME)
    return Vehicle("on arms", (wheelset,), (frame,), (*bushings, *more), gravity=0.0)


def stiffness(law: VehicleOnTrack) -> np.ndarray:
    """Of the frame against the held axle, boxes free to turn: (6, 6) in the order of the coordinates."""
    q, q_t = design_state(law)
    n, w = 6 * len(law.bodies), 6
    whole = linearise(law, law.bodies, q, q_t).stiffness
    inertia = np.array([INERTIA, INERTIA])
    boxes = inertia[:, None] * whole[n:, n:]
    across = inertia[:, None] * whole[n:, w:n]
    return whole[w:n, w:n] - whole[w:n, n:] @ np.linalg.solve(boxes, across)


def test_a_box_holds_along_and_across_or_pitches_with_its_axle_bridge() -> None:
    """At the end of a level arm: all of the stiffness along it and across, none upward, for the arm swings."""
    vehicle = on_arms()
    level = tuple(replace(e, at=(REACH, e.at[1], RADIUS)) for e in vehicle.elements if isinstance(e, Spring))
    frame = replace(vehicle.bodies[0], centre=(REACH, 0.0, RADIUS))
    law = on_springs(replace(vehicle, elements=level, bodies=(frame,)))
    diagonal = np.diag(stiffness(law))[:3]  # z, x, y at the bushings
    assert diagonal[0] == pytest.approx(0.0, abs=1e-6 * BUSHING[2])
    assert diagonal[1] == pytest.approx(2.0 * BUSHING[0], rel=1e-6)
    assert diagonal[2] == pytest.approx(2.0 * BUSHING[1], rel=1e-6)
    # a stiffness k between both adds k (a_left - a_right) to the moment on each, of opposite signs
    k = 2e5
    bridge = Spring("bridge", "spring", "box left", "box right", AXLE, turning_stiffness=(0.0, k, 0.0))
    stiffnesses = []
    for vehicle in (on_arms(), on_arms(bridge)):
        law = on_springs(vehicle)
        n = 6 * len(law.bodies)
        stiffnesses.append(linearise(law, law.bodies, *design_state(law)).stiffness[n:, n:])
    assert INERTIA * (stiffnesses[1] - stiffnesses[0]) == pytest.approx(
        k * np.array([[1.0, -1.0], [-1.0, 1.0]]), rel=1e-6
    )


def test_forces_on_arms_have_a_potential_at_any_displacement() -> None:
    """Derivatives of the generalised forces are symmetric; a box turns with its pitch and with the heading."""
    more = [spring(f"box {s}", (0.1, 0.0, 0.6), "spring", stiffness=(1e5, 2e5, 3e5)) for s in ("left", "right")]
    law = on_springs(on_arms(*more))
    q, q_t = displaced(law)
    q[12:] = 0.05, -0.03
    q_t[:] = 0.0

    def of_boxes(out: np.ndarray, moved: np.ndarray) -> None:
        out[12:] *= INERTIA
        out[3] += np.sin(moved[4]) * out[12:].sum()  # a turn of the heading turns the boxes by the sine of the roll

    assert symmetric(derivatives(law, q, q_t, law.size, of_boxes), 5)  # the spin of the axle moves no spring


def test_arms_keep_momentum_and_angular_momentum() -> None:
    law = on_springs(on_arms())
    q, q_t = displaced(law)
    out = np.zeros(law.size)
    law(0.0, q, q_t, out)
    moment_kept(law, INERTIA * out[12:].sum())


def test_the_bushing_carries_the_levers_share_of_a_spring_on_the_arm() -> None:
    """Spring and bushing stand on the arm like scales: spring force times its lever = bushing force times reach."""
    lever = -0.2
    more = [spring(f"box {s}", (lever, 0.0, 0.8), "spring", stiffness=(0.0, 0.0, 1e6)) for s in ("left", "right")]
    vehicle = on_arms(*more)
    frame = replace(vehicle.bodies[0], centre=(0.0, 0.0, 0.7))  # its weight stands over the axle, where the arm does
    vehicle = replace(vehicle, bodies=(frame,), gravity=9.81)
    up = {e.name: -preload.force[2] for e, preload in zip(vehicle.elements, preloads(vehicle), strict=True)}
    weight = 0.5 * MASS * vehicle.gravity
    assert up["spring box left"] == pytest.approx(weight * REACH / (REACH - lever), rel=1e-9)
    assert up["bushing box left"] == pytest.approx(weight * -lever / (REACH - lever), rel=1e-9)
    law = on_springs(vehicle, vehicle.gravity)
    out = np.zeros(law.size)
    law(0.0, *design_state(law), out)
    assert np.abs(out[6:]).max() < 1e-6  # the design position is one of rest, of frame and boxes


def test_loads_springs_and_modes_of_arms_are_those_of_the_source() -> None:
    """68 295.994 N a wheel, 59 290.4 N a primary spring, 74 926.3 N an air spring: ORVD 4706df9."""
    vehicle = shipped("gz18")
    assert static_state(vehicle).wheel_loads == pytest.approx(np.full((4, 2), 68295.994), rel=1e-7)
    forces = {e.name: preload.force for e, preload in zip(vehicle.elements, preloads(vehicle), strict=True)}
    for name, force in forces.items():
        expected = 59290.4 if ".primary" in name else 74926.3 if ".air" in name else 0.0
        assert abs(force[-1]) == pytest.approx(expected, rel=1e-5, abs=1e-3), name
    assert level_of(vehicle, "front.frame") == "bogie frame"
    assert level_of(vehicle, "carbody") == "car body"
    # arms of 1 kg m2 on bushings of 17 MN/m at 0.48 m: 315 Hz; eight of them
    swinging = [mode for mode in natural_modes(shipped("gz18")) if mode.name == "axle boxes pitch"]
    assert len(swinging) == 8
    alone = np.sqrt(1.7e7 * (0.48**2 + 0.0135**2)) / (2.0 * np.pi)
    assert all(mode.frequency == pytest.approx(alone, rel=0.01) for mode in swinging)


BOXES = '[axle_boxes."box"]\nwheelset = "front"\ny_mm = 900\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n'
BODY = "[bodies.body]"
PRIMARY = 'to = ["front", "rear"]\norigin = "to"'


@pytest.mark.parametrize(("changes", "message"), table("axle_boxes_that_cannot_be"))  # fmt: skip
def test_axle_boxes_that_cannot_be(tmp_path, changes, message) -> None:
    assert message in fault(tmp_path, *changes)


def test_an_arm_off_the_axle_is_a_good_file_with_the_energy_of_its_inertia(tmp_path) -> None:
    changes = (BODY, BOXES + BODY), (PRIMARY, 'to = ["box", "rear"]\norigin = "to"'), ("[0, 900, 0]", "[300, 900, 50]")
    beside = "'primary rear left' holds wheelset 'rear' beside its axle"
    assert beside in fault(tmp_path, *changes)
    law = on_springs(on_arms())
    q, q_t = design_state(law)
    turning = q_t.copy()
    turning[-2:] += (0.5, -0.2)
    still, moved = (energy_channels(law, q[None], rates[None])["kinetic_energy"][0] for rates in (q_t, turning))
    assert moved - still == pytest.approx(0.5 * INERTIA * (0.5**2 + 0.2**2))
