"""Axle boxes: bodies that turn freely about their axle. Laws of one arm, and of a whole car on eight."""

from dataclasses import replace

import numpy as np
import pytest
from support.boxes import derivatives, displaced, moment_kept, on_springs, symmetric
from support.rows import rows_of
from support.vehicle_texts import fault
from support.vehicles import manchester, shipped

from wrsim.analysis.motion.body_channels import energy_channels
from wrsim.analysis.stationary.statics import static_state
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.vehicle.bogies import level_of
from wrsim.vehicle.elements import Element, Spring
from wrsim.vehicle.preload import preloads
from wrsim.vehicle.vehicle import AxleBox, Body, Vehicle

table = rows_of(__file__)

MASS, REACH, RADIUS, Y, INERTIA = 4000.0, 0.5, 0.46, 1.0, 3.0
BUSHING = (2e7, 9e6, 1e7)
AXLE, FRAME, END = (0.0, 0.0, RADIUS), (0.3, 0.0, 0.7), (REACH, 0.0, RADIUS + 0.1)


def spring(box: str, at: tuple[float, float, float], name: str = "", **values: object) -> Spring:
    """From the frame to an axle box; y of the left one."""
    side = 1.0 if box.endswith("left") else -1.0
    point = (at[0], side * Y, at[2])
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


def test_an_arm_holds_along_and_across_and_lets_the_frame_bounce() -> None:
    """At the end of a level arm: all of the stiffness along it and across, none upward, for the arm swings."""
    vehicle = on_arms()
    level = tuple(replace(e, at=(REACH, e.at[1], RADIUS)) for e in vehicle.elements if isinstance(e, Spring))
    frame = replace(vehicle.bodies[0], centre=(REACH, 0.0, RADIUS))
    law = on_springs(replace(vehicle, elements=level, bodies=(frame,)))
    found = np.diag(stiffness(law))[:3]  # z, x, y at the bushings
    assert found[0] == pytest.approx(0.0, abs=1e-6 * BUSHING[2])
    assert found[1] == pytest.approx(2.0 * BUSHING[0], rel=1e-6)
    assert found[2] == pytest.approx(2.0 * BUSHING[1], rel=1e-6)


def test_boxes_held_together_pitch_as_the_two_halves_of_an_axle_bridge() -> None:
    """A stiffness k between both adds k (a_left - a_right) to the moment on each, of opposite signs."""
    k = 2e5
    bridge = Spring("bridge", "spring", "box left", "box right", AXLE, turning_stiffness=(0.0, k, 0.0))
    found = []
    for vehicle in (on_arms(), on_arms(bridge)):
        law = on_springs(vehicle)
        n = 6 * len(law.bodies)
        found.append(linearise(law, law.bodies, *design_state(law)).stiffness[n:, n:])
    assert INERTIA * (found[1] - found[0]) == pytest.approx(k * np.array([[1.0, -1.0], [-1.0, 1.0]]), rel=1e-6)


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
    up = {e.name: -own.force[2] for e, own in zip(vehicle.elements, preloads(vehicle), strict=True)}
    weight = 0.5 * MASS * vehicle.gravity
    assert up["spring box left"] == pytest.approx(weight * REACH / (REACH - lever), rel=1e-9)
    assert up["bushing box left"] == pytest.approx(weight * -lever / (REACH - lever), rel=1e-9)
    law = on_springs(vehicle, vehicle.gravity)
    out = np.zeros(law.size)
    law(0.0, *design_state(law), out)
    assert np.abs(out[6:]).max() < 1e-6  # the design position is one of rest, of frame and boxes


def test_static_wheel_loads_and_the_primary_springs_are_those_of_the_source() -> None:
    """68 295.994 N a wheel, 59 290.4 N a primary spring, 74 926.3 N an air spring: ORVD 4706df9."""
    vehicle = shipped("gz18")
    assert static_state(vehicle).wheel_loads == pytest.approx(np.full((4, 2), 68295.994), rel=1e-7)
    found = {e.name: own.force for e, own in zip(vehicle.elements, preloads(vehicle), strict=True)}
    for name, force in found.items():
        expected = 59290.4 if ".primary" in name else 74926.3 if ".air" in name else 0.0
        assert abs(force[-1]) == pytest.approx(expected, rel=1e-5, abs=1e-3), name
    assert level_of(vehicle, "front.frame") == "bogie frame"
    assert level_of(vehicle, "carbody") == "car body"


def test_modes_of_the_arms_are_named_and_lie_where_bushing_and_inertia_put_them() -> None:
    """Arms of 1 kg m2 on bushings of 17 MN/m at 0.48 m: 315 Hz; eight of them."""
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
