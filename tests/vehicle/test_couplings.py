"""Couplings: impacts in closed form, slack, loops of friction, forces along a train, momentum; no rails needed."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.boxes import displaced, moment_kept, on_springs
from support.vehicles import coaches, manchester

from wrsim.analysis.motion.messages import Event, event_words
from wrsim.simulation.force_law import Block, all_on_all, force_derivative
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.couplings import CentreCouplerTable, CouplingTable, Gap, ScrewCouplingTable
from wrsim.vehicle.elements import TRACK, Spring
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Body, Coupling, Member, Vehicle

MASS, HEIGHT, LENGTH = 40e3, 1.06, 10.0
INERTIA = (5e4, 5e5, 5e5)
GEAR: dict[str, Any] = {"stiffness_kN_per_m": 2000.0, "stroke_mm": 150.0}
BUFFERS = GEAR | {"height_mm": 1e3 * HEIGHT, "half_spacing_mm": 875.0, "head_radius_mm": 1500.0}
STIFF = BUFFERS["stiffness_kN_per_m"] * 1e3
"""Of both pairs of buffers: two side by side, each of two in series."""


def screw(draw: dict[str, Any] = GEAR, buffers: dict[str, Any] = BUFFERS, **more: Any) -> CouplingTable:
    """A screw coupling with side buffers."""
    values = {"kind": "screw", "height_mm": 1e3 * HEIGHT, "hinge_mm": 400.0, "draw": draw, "buffers": buffers}
    return ScrewCouplingTable.model_validate(values | more)


def wagons(coupling: CouplingTable, masses: tuple[float, ...] = (MASS, MASS), lateral: float = 4e6) -> Vehicle:
    """Blocks in a row, free along the track, held up and straight; lateral: how they are held sideways [N/m]."""
    pitch = LENGTH + coupling.gap
    bodies = [Body(f"wagon{k}", m, INERTIA, (-pitch * k, 0.0, HEIGHT)) for k, m in enumerate(masses)]
    rails = [
        Spring(
            f"rails{k}", "spring", TRACK, body.name, body.centre, (0.0, lateral, 4e6), turning_stiffness=(1e8, 1e8, 1e8)
        )
        for k, body in enumerate(bodies)
    ]
    joints = [
        element
        for k in range(len(masses) - 1)
        for element in coupling.elements(Gap(f"{k}-{k + 1}", f"wagon{k}", f"wagon{k + 1}", -pitch * (k + 0.5)))
    ]
    return replace(
        manchester(), wheelsets=manchester().wheelsets[:1], bodies=tuple(bodies), elements=(*rails, *joints), points=(),
        gravity=0.0, members=tuple(Member(body.name, int(k == 0), 1) for k, body in enumerate(bodies)),
    )  # fmt: skip


def motion(law: VehicleOnTrack, speeds: tuple[float, ...], duration: float, step: float = 2e-4) -> Motion:
    """From the design position on with these speeds of the wagons [m/s]."""
    q, q_t = design_state(law)
    for k, v in enumerate(speeds):
        q_t[6 * (1 + k) + 1] = v
    system = BodySystem(law.bodies, law)
    return Integration(system, duration=duration, step=step, integrator="rk44", weight=MASS * 9.81).run(q, q_t)


def speeds_of(moved: Motion, wagons: int = 2) -> np.ndarray:
    """Longitudinal velocities (samples, wagons) [m/s]."""
    return np.stack([moved.q_t[:, 6 * (1 + k) + 1] for k in range(wagons)], axis=1)


def forces_of(moved: Motion, law: VehicleOnTrack) -> np.ndarray:
    """Tension of every element at every sample (samples, elements) [N]."""
    out, forces = np.zeros(law.size), []
    for t, q, q_t in zip(moved.times, moved.q, moved.q_t, strict=True):
        law(t, q, q_t, out)
        forces.append(law.records[:, 0].copy())
    return np.array(forces)


@pytest.mark.parametrize("second", [MASS, 2.5 * MASS])
def test_the_impact_of_two_wagons_is_that_of_two_masses_and_a_spring(second: float) -> None:
    """From the end of the gap: v sqrt(k m) for pi sqrt(m/k), m the reduced mass; momentum and energy are kept."""
    gap, v = 0.05, 1.0
    law = on_springs(wagons(screw(gap_mm=1e3 * gap, slack_mm=300.0), (MASS, second)))
    reduced = MASS * second / (MASS + second)
    lasts = np.pi * np.sqrt(reduced / STIFF)
    moved = motion(law, (0.0, v), gap / v + lasts + 0.05)
    force = -forces_of(moved, law).sum(axis=1)
    touching = force > 0.0
    assert not touching[moved.times < gap / v - 1e-9].any()
    assert force.max() == pytest.approx(v * np.sqrt(STIFF * reduced), rel=1e-4)
    assert touching.sum() * moved.step == pytest.approx(lasts, abs=2.0 * moved.step)
    speeds = speeds_of(moved)
    momentum = speeds @ (MASS, second)
    assert np.abs(momentum - momentum[0]).max() < 1e-9 * momentum[0]
    together = second * v / (MASS + second)
    np.testing.assert_allclose(speeds[-1], [2.0 * together, 2.0 * together - v], atol=1e-4)


def test_friction_in_the_buffers_takes_the_area_of_their_loop() -> None:
    """(1 + s) F on the way in, (1 - s) F on the way out: of the speed sqrt((1 - s)/(1 + s)) is left, the other energy
    is what the loop of force over stroke encloses."""
    share, v = 0.3, 1.0
    buffers = BUFFERS | {"friction_share": share, "friction_travel_mm": 0.2}
    law = on_springs(wagons(screw(buffers=buffers, slack_mm=300.0)))
    moved = motion(law, (0.0, v), 0.6, 1e-4)
    speeds = speeds_of(moved)
    assert speeds[-1, 0] - speeds[-1, 1] == pytest.approx(v * np.sqrt((1.0 - share) / (1.0 + share)), rel=5e-3)
    forces, stroke = forces_of(moved, law), moved.q[:, 6 * 2 + 1] - moved.q[:, 6 + 1] + LENGTH
    loop = np.trapezoid(-forces.sum(axis=1), stroke)
    lost = 0.5 * MASS * (v**2 - (speeds[-1] ** 2).sum())
    assert loop == pytest.approx(lost, rel=1e-4)
    assert -forces.sum(axis=1).max() == pytest.approx(0.0, abs=1.0)  # nothing pulls
    inward = np.argmax(stroke)
    compressed = stroke[: inward - 5 : 20] > 0.02
    np.testing.assert_allclose(
        -forces.sum(axis=1)[: inward - 5 : 20][compressed],
        (1.0 + share) * STIFF * stroke[: inward - 5 : 20][compressed],
        rtol=1e-3,
    )


@pytest.mark.parametrize("kind", ["screw", "centre"])
def test_slack_gives_no_force_until_it_is_used(kind: str) -> None:
    """Two wagons that drift apart at 0.1 m/s: nothing, then the gear with its preload."""
    slack, drift = 0.03, 0.1
    gear = GEAR | {"preload_kN": 20.0, "friction_share": 0.2}
    coupling = screw(gear, slack_mm=1e3 * slack, gap_mm=20.0)
    free = slack
    if kind == "centre":
        values = {"kind": "centre", "height_mm": 1e3 * HEIGHT, "hinge_mm": 800.0, "slack_mm": 1e3 * slack}
        coupling = CentreCouplerTable.model_validate(values | {"draw": gear, "buff": gear})
        free = 0.5 * slack  # it stands in the middle
    law = on_springs(wagons(coupling))
    moved = motion(law, (drift, 0.0), free / drift + 0.2)
    force = forces_of(moved, law)[:, 2]
    apart = moved.q[:, 6 + 1] - moved.q[:, 6 * 2 + 1] - LENGTH - coupling.gap
    inside = apart < free - 1e-9
    assert inside.sum() > 100
    assert np.abs(force[inside]).max() == 0.0
    beyond = (apart > free + 2.5e-3) & (np.gradient(apart) > 0.0)
    assert beyond.sum() > 10
    expected = 1.2 * (20e3 + 0.5 * STIFF * (apart[beyond] - free))
    np.testing.assert_allclose(force[beyond], expected, rtol=5e-3)


def test_every_coupling_carries_the_masses_behind_it_times_the_acceleration() -> None:
    """Four wagons, the first one pulled ever harder, slowly; no slack, and friction that lets no swing last."""
    masses = (60e3, 40e3, 20e3, 30e3)
    gear = GEAR | {"friction_share": 0.3, "friction_travel_mm": 5.0}
    train = wagons(screw(gear, BUFFERS | {"preload_kN": 1.0}, pretension_kN=2.0), masses)
    pull = 60e3
    rising = Load("pull", "wagon0", (0.0, 0.0, HEIGHT), ((0.0, 0.0, 0.0, 0.0), (4.0, pull, 0.0, 0.0)))
    law = on_springs(replace(train, loads=(rising,)))
    moved = motion(law, (), 7.0, 1e-3)
    late = moved.times > 6.0
    tension = forces_of(moved, law)[late]
    names = [element.name for element in law.vehicle.elements]
    for k in range(3):
        coupled = [i for i, name in enumerate(names) if name.startswith(f"{k}-{k + 1} ")]
        expected = pull * sum(masses[k + 1 :]) / sum(masses)
        assert tension[:, coupled].sum(axis=1).mean() == pytest.approx(expected, rel=2e-3)


def test_couplings_keep_momentum_and_angular_momentum() -> None:
    """At any displacement, and what one vehicle feels the other feels the other way round."""
    law = on_springs(coaches(2))
    q, q_t = displaced(law)
    for i in law.vehicle.units[1].parts:  # nearer to the one ahead, at the heading of that state
        q[6 * i + 1 : 6 * i + 3] += 0.2 * np.array([np.cos(2.0), np.sin(2.0)])
    law(0.0, q, q_t, np.zeros(law.size))
    pushed = [r[0] for e, r in zip(law.vehicle.elements, law.records, strict=True) if e.kind == "buffer"]
    assert min(pushed) < -1e4  # they are in touch
    moment_kept(law)


@pytest.mark.parametrize("model", [pytest.param("manchester_1", marks=pytest.mark.campaign), "manchester_motor"])
def test_derivatives_of_a_train_are_taken_vehicle_by_vehicle(model: str) -> None:
    """Vehicles act on their neighbours alone: those that lie three apart are changed at once."""
    law = on_springs(coaches(5, model))
    q, q_t = displaced(law)
    size = max(len(coordinates) for coordinates in law.coordinates_of_units())
    assert len(law.blocks()[0].groups) == 3 * size < law.size
    for by in ((1.0, 0.0), (0.3, 1.0)):
        grouped = force_derivative(law, q, q_t, len(law.bodies), 0.0, *by)
        law.blocks = lambda: [Block(law.on_bodies, all_on_all(law.size))]  # type: ignore[method-assign]
        plain = force_derivative(law, q, q_t, len(law.bodies), 0.0, *by)
        del law.blocks
        np.testing.assert_array_equal(grouped, plain)


def test_at_rest_a_tight_coupling_pulls_as_its_buffers_push() -> None:
    law = on_springs(coaches(2))
    law(0.0, *design_state(law), np.zeros(law.size))
    forces = {e.name: r[0] for e, r in zip(law.vehicle.elements, law.records, strict=True)}
    assert forces["coach1-coach2 draw gear"] == pytest.approx(20e3, rel=1e-9)
    for side in ("left", "right"):
        assert forces[f"coach1-coach2 buffer {side}"] == pytest.approx(-10e3, rel=1e-9)


def test_a_stroke_that_is_used_up_is_an_event() -> None:
    """At 3 m/s the buffers of two wagons go solid, and what stands behind them takes the rest."""
    train = wagons(screw(buffers=BUFFERS | {"stroke_mm": 60.0}, slack_mm=300.0))
    gear = next(element for element in train.elements if element.name == "0-1 buffer left")
    assert gear.limits is not None
    assert gear.limits[0] == pytest.approx(-0.12)
    law = on_springs(train)
    forces = -forces_of(motion(law, (0.0, 3.0), 0.3), law).sum(axis=1)
    energy = 0.5 * 0.5 * MASS * 9.0 - 0.5 * STIFF * 0.12**2
    beyond = (-STIFF * 0.12 + np.sqrt((STIFF * 0.12) ** 2 + 2.0 * 1e8 * energy)) / 1e8
    assert forces.max() == pytest.approx(STIFF * 0.12 + 1e8 * beyond, rel=1e-3)
    coupled = replace(train, couplings=(Coupling("0-1", "wagon0", "wagon1", gear.points[0], (gear.name,)),))
    event = Event("stop", gear.name, (1.0, 2.0), (1.1, 2.5))
    assert event_words(event, coupled) == "the stroke of 0-1 buffer left is used up for 0.50 m, 100 ms"


def turned(law: VehicleOnTrack, moved: float, lateral: float, yaw: float) -> dict[str, np.ndarray]:
    """Readings of the elements with the second wagon moved forward and to the left [m] and turned to the left [rad],
    and ``on``: force and moment about the vertical on that wagon (x, y, about z)."""
    q, q_t = design_state(law)
    second = q[12:18]
    second[1] += moved
    second[2] += lateral
    second[3] += yaw
    out = np.zeros(law.size)
    with law.relaxed_dampers():
        law(0.0, q, q_t, out)
    readings = {e.name: r.copy() for e, r in zip(law.vehicle.elements, law.records, strict=True)}
    return readings | {"on": out[[13, 14, 15]]}


def test_a_centre_coupler_pushes_along_its_bar() -> None:
    """By hand: the bar between the hinges, its length and direction, the gear's force along it."""
    hinge, moved, lateral, yaw = 0.8, 0.08, 0.15, 0.02
    values = {"kind": "centre", "height_mm": 1e3 * HEIGHT, "hinge_mm": 1e3 * hinge, "draw": GEAR, "buff": GEAR}
    law = on_springs(wagons(CentreCouplerTable.model_validate(values), lateral=0.0))
    readings = turned(law, moved, lateral, yaw)
    arm = 0.5 * LENGTH - hinge  # from the wagon's middle to its hinge
    end = np.array([-LENGTH + moved + arm * np.cos(yaw), lateral + arm * np.sin(yaw)])
    bar = np.array([-arm, 0.0]) - end
    length = np.linalg.norm(bar)
    push = 0.5 * GEAR["stiffness_kN_per_m"] * 1e3 * (2.0 * hinge - length)  # of two gears in series
    assert push > 2e4
    assert readings["0-1 buff gear"][0] == pytest.approx(-push, rel=1e-9)
    assert readings["0-1 draw gear"][0] == 0.0
    force = -push * bar / length
    np.testing.assert_allclose(readings["on"][:2], force, rtol=1e-9)
    moment = arm * (np.cos(yaw) * force[1] - np.sin(yaw) * force[0])
    rails = 1e8 * np.sin(yaw)
    assert readings["on"][2] == pytest.approx(moment - rails, rel=1e-9)


@pytest.mark.parametrize("yaw", [0.08, -0.08])
def test_in_a_curve_the_inner_buffers_are_pressed_and_the_outer_ones_open(yaw: float) -> None:
    """Two spheres a side: their distance by hand. Turned to the left, the vehicle behind comes nearer on its right."""
    law = on_springs(wagons(screw(slack_mm=300.0), lateral=0.0))
    readings = turned(law, 0.0, -0.5 * LENGTH * np.sin(yaw), yaw)  # its end stays in the middle
    radius, half = 1.5, 0.875
    strokes = {}
    for side, y in (("left", half), ("right", -half)):
        x = 0.5 * LENGTH - radius
        middle = np.array([-LENGTH, -0.5 * LENGTH * np.sin(yaw)])
        behind = middle + np.array([x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)])
        ahead = np.array([-0.5 * LENGTH + radius, y])
        strokes[side] = 2.0 * radius - np.linalg.norm(ahead - behind)
        force = 0.5 * STIFF * max(strokes[side], 0.0)
        assert readings[f"0-1 buffer {side}"][0] == pytest.approx(-force, rel=1e-9)
        assert readings[f"0-1 buffer {side}"][3] == pytest.approx(-strokes[side], rel=1e-9)
    inner = "right" if yaw > 0.0 else "left"
    assert strokes[inner] > 0.0 > strokes["left" if inner == "right" else "right"]
    assert strokes[inner] == pytest.approx(half * abs(yaw), rel=0.25)
