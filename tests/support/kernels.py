"""Work for every kernel: small cases whose numbers are the same compiled and not.

Run as a program without the compiler (`support.workers.uncompiled`) it writes what the cases gave and which kernels
worked; with it and no form it compiles ahead (`.ci/test`)."""

import copy
import importlib
import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType
from typing import Any

import numpy as np
import pytest
from numba.core.registry import CPUDispatcher

from support.contacts import bench, contact_of, numbers, pair_model, settle, strip_system
from support.crossings import branches_that_cross
from support.ellipse import roll
from support.knife_edge import KnifeEdgeForces, example_wheelset
from support.objects import begin_wasm_library, kept_objects
from support.paths import curvature, locate
from support.vehicles import manchester, on_track, shipped
from wrsim import Arc, ContactModel, ContactSettings, Flat, Friction, contact_model
from wrsim.analysis.motion.monitor import Monitor
from wrsim.contact.arrays import Arrays
from wrsim.contact.channels import WheelOnRail, wheel_outline
from wrsim.contact.creep.laws import KERNEL_LAWS
from wrsim.contact.prescribed_load import SEARCH, contact_at_load
from wrsim.contact.profiles.sections import circle
from wrsim.contact.search.locus import locus_point
from wrsim.contact.settings import ConicalWheels, FrictionAlong, HalfSpaceSettings, Heating, Material
from wrsim.contact.settings import Layer as ThirdBody
from wrsim.contact.strips.changes import deactivate_grid
from wrsim.contact.strips.derivatives import jacobian
from wrsim.contact.strips.equations import residuals
from wrsim.contact.strips.records import UNKNOWNS_PER_STRIP, V
from wrsim.contact.subsurface.loads import surface_loads
from wrsim.contact.surfaces.envelope_rows import unfold
from wrsim.contact.surfaces.rail_surface import RailSection, RailSurface
from wrsim.contact.wheel_rail import STAGES, compile_stages, place_bodies
from wrsim.contact.workspace import pack
from wrsim.jit.butterworth import butterworth, zero_phase
from wrsim.jit.cache import PACKAGE, sources
from wrsim.jit.objects import this_target
from wrsim.simulation.bodies import accelerations, inertia_table, mass_matrix, velocity_forces
from wrsim.simulation.force_law import Array, force_derivative
from wrsim.simulation.implicit_step import ImplicitStep
from wrsim.simulation.law import ConicalVehicleOnTrack, VehicleOnTrack
from wrsim.simulation.placement import design_state, poses_on_track
from wrsim.simulation.sampled_forces import SampledForces
from wrsim.simulation.steady_state import SteadyMotion
from wrsim.simulation.stepper import Stepper
from wrsim.track.bridge import Bridge
from wrsim.track.segments import Segment
from wrsim.track.sleepers import Layer, RailBeam, SleeperTrack
from wrsim.track.track import RailElasticity
from wrsim.vehicle.axle import Axle
from wrsim.vehicle.dynamics.kinematics import first_not_finite, is_near
from wrsim.vehicle.dynamics.rigid_body import kinetic_energies
from wrsim.vehicle.elements import Element, Normal, PlaneFriction, Slider, Strut
from wrsim.vehicle.loads import Effort, Load, SlipControl
from wrsim.vehicle.vehicle import BrakePipe, Member, Wagon
from wrsim.vehicle.wheelset import Torsion, Wheelset

PAIR = "S1002/60E1 1:40"
FRICTION = Friction(0.4, gauge_corner=0.1, falling_ratio=0.5)
SMALL = {"strips": 6, "cells": 4, "friction": FRICTION}
PLACES = ((2e-3, 0.0), (5.5e-3, 0.0), (7.5e-3, 0.012), (0.0, 0.002))
SOURCES = {str(path) for path in sources()}
FULL_ALONE = {
    "_activate_grid", "_add_to_middles", "_couple", "_largest_overlap", "_overlap", "_set_active_set",
    "_set_plain_pairs", "_shallower", "_smooth_step", "_solve_alone", "_solve_one_by_one", "_solve_within",
    "_stair_variance", "carry_over", "deactivate_grid", "four_in_contact", "move_edges", "set_middles", "weight_of",
}  # fmt: skip
"""What the strip model does where Newton's method fails, where grids come and go, and in runs: slow uncompiled."""


def kernels() -> dict[tuple[str, str], Any]:
    """All kernels by the file and the name of their Python function."""
    dispatchers = {}
    for path in sources():
        module = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
        for thing in vars(importlib.import_module(module)).values():
            function = getattr(thing, "py_func", None)
            if function is not None:
                dispatchers[function.__code__.co_filename, function.__name__] = thing
    return dispatchers


def lowered(model: ContactModel, lateral: float, yaw: float, depth: float = 1e-4) -> list[float]:
    """Contact of a rolling wheel that is pressed into its rail by about ``depth``."""
    axle = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    height = 0.46
    origin = np.array([0.0, 0.75 + lateral - 0.7175 + model.rail.gauge_point()[0], height + 0.03])
    for _ in range(8):
        model.arrays.pose[:6] = *origin, *axle
        model.arrays.search()
        origin[2] -= model.arrays.total.closest
    origin[2] -= depth
    velocity = (20.0, 0.05, -0.002)
    contact = model.evaluate(origin, axle, velocity, 1.002 * 20.0 / height * axle + [0.1, 0.0, 0.02])
    return numbers(contact)


def contact_cases(full: bool) -> dict[str, list[float]]:
    """One wheel on one rail; not in full: each kernel but FULL_ALONE at work, and no place more."""
    cases = {}
    for tangential in KERNEL_LAWS:
        for lateral, yaw in PLACES if full else PLACES[1:2]:
            model = pair_model(PAIR, tangential=tangential, **SMALL)
            cases[f"{tangential} {lateral:g}"] = lowered(model, lateral, yaw)
    slope = {"slope_k0": 0.5, "slope_alpha_inf": 0.1, "slope_beta": 0.5}
    plain = pair_model(PAIR, tangential="fastsim", flexibility="three", max_patches=1, **slope, **SMALL)
    cases["three flexibilities, one lobe"] = lowered(plain, *PLACES[1])
    cases["outline"] = list(wheel_outline(WheelOnRail(plain, 1, 0.75, (0.0, 0.0))).ravel())
    for lateral, yaw in PLACES if full else ():
        model = pair_model(PAIR, normal="strips", **SMALL)
        model.arrays.follow(True)
        for depth in (1e-4, 1.1e-4, 4e-5):
            cases[f"strips {lateral:g} {depth:g}"] = lowered(model, lateral, yaw, depth)
    # a lobe leaves the contact, another one widens
    model = pair_model("S1002/60E1 1:20", normal="strips", **SMALL)
    model.arrays.follow(True)
    for lateral, depth in ((6e-3, 3e-5), (6.15e-3, 2e-5)) if full else ():
        cases[f"lobes change {lateral:g}"] = lowered(model, lateral, 0.002, depth)
    if full:
        cases["a grid leaves"] = _leaving(model)
    model = pair_model("S1002/60E1 1:20", normal="strips", **SMALL)
    model.arrays.follow(True)
    for lateral, depth, budget in ((6e-3, 3e-5, 1e3), (6.15e-3, 2e-5, 5.0), (6.15e-3, 3e-5, 5.0)) if full else ():
        model.arrays.rows.memo["budget"], model.arrays.rows.memo["work"] = budget, 0.0
        cases[f"a budget {lateral:g} {depth:g}"] = lowered(model, lateral, 0.002, depth)
    # a tail beside a maximum comes and goes: the last resort
    model = pair_model(PAIR, normal="strips", **SMALL | {"strips": 8})
    model.arrays.follow(True)
    stand = bench(model, rolling=False)
    for height in (0.460652, 0.460651, 0.460692, 0.4608) if full else ():
        stand.evaluate(6.53e-3, height, 0.0176, 0.0)
        cases[f"a tail {height:g}"] = numbers(contact_of(stand))
    coarse = HalfSpaceSettings(resolution=6 if full else 4, tolerance=1e-9)
    level = replace(coarse, pairing="level", influence="angle-corrected")
    for name, settings, tangential, rail in (
        ("exact", coarse, "half-space", Material()),
        ("level", level, "half-space", Material(70e9, 0.33)),
        ("fastsim on exact", coarse, "fastsim", Material()),
    ):
        model = pair_model(PAIR, normal="half-space", tangential=tangential, half_space=settings, **SMALL)
        choices = replace(model.settings, rail=rail)
        model = contact_model(model.wheel, model.rail, model.radius, choices, FRICTION)
        cases[name] = lowered(model, *PLACES[0])
    crown = circle("crown", "rail", 0.3, 0.001)
    dip = RailSurface("dip", tuple(RailSection(s, crown.shifted(0.0, -0.002 * s)) for s in (0.0, 0.05)))
    for normal in ("kik-piotrowski", *["strips"] * full):
        settings = ContactSettings(normal=normal, strips=6, cells=4)
        model = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, settings, FRICTION, dip)
        yawed = model.evaluate((0.0, 1e-4, 0.45991), (-0.01, sqrt(1.0 - 1e-4), 0.0), place=0.021)
        cases[f"rail of sections, {normal}, yawed"] = numbers(yawed)
        dent = (Flat.rounded(0.46, 0.04, 1e-4, width=0.05),)
        model = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, settings, FRICTION, out_of_round=dent)
        yawed = model.evaluate((0.0, 1e-4, 0.45993), (-0.01, sqrt(1.0 - 1e-4), 0.0), wheel_angle=0.03)
        cases[f"wheel out of round, {normal}"] = numbers(yawed)
    few = ContactSettings(normal="kik-piotrowski", strips=6, cells=4)
    rig = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, few, FRICTION, roller=0.8)
    cases["roller"] = numbers(rig.evaluate((0.0, 1e-4, 0.45991), (-0.01, sqrt(1.0 - 1e-4), 0.0), (20.0, 0.0, 0.0)))
    hot = replace(few, layer=ThirdBody(1e-5, yield_stress=1e8, hardening=1e12), temperature=Heating(-0.1))
    warmed = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, hot, FRICTION)
    sliding = warmed.evaluate((0.0, 1e-4, 0.45991), velocity=(20.0, 0.0, 0.0), omega=(0.0, 43.0, 0.0))
    cases["layer that yields, heat"] = numbers(sliding)
    many = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, few, FRICTION)
    poses = np.array([[0.0, o, 0.45995, 0.0, 1.0, 0.0, 20.0, 0.0, 0.0, 0.0, 43.7, 0.0] for o in (0.0, 1e-4)])
    for threads in (1, 2):
        cases[f"many poses, {threads} threads"] = many.evaluate_many(poses, threads=threads).force.ravel().tolist()
    loaded = many.solve_many(poses, 3e4, threads=1)
    cases["many poses under a load"] = [*map(float, loaded.status), *map(float, abs(loaded.force[:, 2] - 3e4) < 0.1)]
    rolling = contact_model(many.wheel, many.rail, 0.46, replace(few, tangential="fastrip"), FRICTION)
    rolling.evaluate(poses[0, :3], poses[0, 3:6], poses[0, 6:9], poses[0, 9:])
    (loads,) = surface_loads(rolling)
    cases["stress below"] = (loads.stress([0.0, 1e-3], 1e-4, [0.0, 2e-3]).components / loads.p0).ravel().tolist()
    search = np.zeros(1, SEARCH)
    search["load"], search["tolerance"], search["farthest"], search["scale"] = 3e4, 1e-8, 5e-3, 1e-4
    held = pack([search, *many.inputs])
    held.views[1 + Arrays._fields.index("pose")][:] = poses[0]
    held.views[0]["start"] = poses[0, 2]
    met = contact_at_load(held.buffer, held.index)
    cases["a load in C"] = [float(met), float(abs(held.views[-1]["Fb"][0] - 3e4) < 0.1)]
    exact = ContactSettings(normal="half-space", cells=4, half_space=HalfSpaceSettings(resolution=3, tolerance=1e-9))
    exact = replace(exact, temperature=Heating(-0.1))
    model = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, exact, FRICTION, dip)
    rolling = model.evaluate((0.0, 0.0, 0.45991), velocity=(20.0, 0.1, 0.0), omega=(0.0, 43.7, 0.0), place=0.02)
    cases["rail of sections, exact"] = numbers(rolling)
    keep = np.zeros(61, dtype=bool)
    unfold(branches_that_cross(61), 0, -1.0, keep)
    cases["branches that cross"] = keep.astype(float).tolist()
    along = FrictionAlong((0.0, 1.0, 2.0), (Friction(0.4), FRICTION, Friction(0.1)))
    curved = ContactSettings(strips=6, cells=4, half_space=HalfSpaceSettings(influence="angle-corrected"))
    model = contact_model(circle("round", "wheel", -0.5, 0.003), crown, 0.46, curved, along)
    model.arrays.follow(not full)
    for place in (-1.0, 0.3, 1.0, 1.7, 3.0) if full else (0.3, 0.3001):
        height = 0.4593 if full else 0.4597 if place == 0.3 else 0.45965
        rolling = model.evaluate((0.0, 1e-3, height), velocity=(20.0, 0.1, 0.0), omega=(0.0, 43.7, 0.0), place=place)
        cases[f"friction along the rail, {place:g}"] = numbers(rolling)
    return cases


def _leaving(model: ContactModel) -> list[float]:
    """A grid of the strip model leaves the contact, in the state of its last call."""
    system, n = strip_system(model)
    deactivate_grid(system, n, 0)
    return list(system.vectors[V.X, : UNKNOWNS_PER_STRIP * n])


def twistable(wheelset: Wheelset) -> Wheelset:
    """The wheelset with an axle that twists."""
    return replace(wheelset, torsion=Torsion(1e6, 1e3))


def vehicle_cases() -> dict[str, list[float]]:
    """A vehicle with two bogies in a curve, on elastic rails, driven by its wheels; another on conical wheels."""
    cases = {}
    vehicle = manchester()
    rows = ((0.0, 1e3, 2e3, -3e3), (40.0, 0.0, 1e3, 0.0), (70.0, -1e3, 5e3, 0.0), (300.0, 0.0, 0.0, 0.0))
    push = Load("push", vehicle.parts[0].name, (1.0, 0.2, 0.5), rows, "distance")
    pull = Load.constant("pull", "carbody", (1e3, 2e3, -3e3), (1.0, 0.2, 2.5), "body")
    brake = Effort(vehicle.wheelsets[1].name, ((40.0, 0.0), (60.0, -9e3)), "distance")
    vehicle = replace(vehicle, loads=(push, pull), efforts=(brake,), slip_control=SlipControl(0.1, 0.01))
    elastic = RailElasticity((2e7, 8e7), (1e4, 1e5), (100.0, 150.0))
    curve: list[Segment] = [Arc(400.0, 600.0, 0.1)]
    for drive, rails, threads in (("wheels", elastic, 1), ("train", None, 2)):
        law = on_track(vehicle, 20.0, curve, drive=drive, structure=rails, threads=threads).law
        q, q_t = design_state(law, lateral=2e-3)
        q[2 : 6 * len(vehicle.wheelsets) : 6] -= 1e-4
        out = np.zeros(law.size)
        law(0.01, q, q_t, out)
        cases[f"vehicle, {drive}"] = list(out)
        cases[f"records, {drive}"] = list(law.records.ravel())
    arms = shipped("gz18")
    hinged = VehicleOnTrack(arms, law.track, (), speed=20.0, start=60.0)
    boxes, boxes_t = design_state(hinged)
    boxes[-8:], boxes_t[-8:] = 0.01, 0.2
    hinged(0.0, boxes, boxes_t, swing := np.zeros(hinged.size))
    cases["axle boxes"] = list(swing)
    twisting = vehicle.with_wheelsets(twistable)
    brake = Effort(vehicle.wheelsets[1].name, ((0.0, -9e3),), wheel="left")
    apart = on_track(replace(twisting, efforts=(brake,), slip_control=None), 20.0, curve).law
    angles, rates = design_state(apart, lateral=2e-3)
    angles[2 : 6 * len(vehicle.wheelsets) : 6] -= 1e-4
    angles[-4:], rates[-4:] = 1e-3, 0.2
    apart(0.0, angles, rates, twist := np.zeros(apart.size))
    cases["twist"] = list(twist)
    wheelset = shipped("wheelset_s1002_steering").with_wheelsets(twistable)
    alone = on_track(wheelset, 20.0, curve, stepped=True).law
    pose, moving = design_state(alone, lateral=2e-3)
    pose[2] -= 1e-4
    pose[-1], moving[-1] = 1e-3, 0.2
    cases["implicit step"] = implicit_step(alone, pose, moving)
    cases["rails on sleepers"] = step_on_sleepers(curve)
    cases["elastic axle on a bridge"] = bent(curve)
    wagon = Wagon("wagon", 8e4, -30.0, 9.0, (1e3, 10.0, 1.0), 0.7)
    members = Member("coach", 4, 3), Member("wagon", 0, 0, True, 5e4, 0.1, wagon)
    train = replace(vehicle, loads=(), efforts=(), members=members, brakes=BrakePipe(250.0, 4.0, ((0.0, 1.0),)))
    drawn = VehicleOnTrack(train, law.track, (), speed=20.0, start=60.0)
    drawn(1.0, *design_state(drawn), behind := np.zeros(drawn.size))
    cases["wagon along the track"] = list(behind)
    motors = shipped("manchester_motor")
    moment = Effort(motors.drives[0].wheelset, ((0.0, 5e3),))
    geared = VehicleOnTrack(replace(motors, efforts=(moment,)), law.track, (), speed=20.0, start=60.0)
    still, turning = design_state(geared)
    turning[list(geared.gears.values())] = 1e-3
    geared(0.0, still, turning, shafts := np.zeros(geared.size))
    cases["geared motors"] = [*shafts, *geared.relaxed_rates(still, turning)]
    frame, sides = vehicle.index("front.frame"), {"coulomb": 1e5, "fancher": 5e4, "berg": 3e4}
    ends = vehicle.parts[frame].name, "carbody", vehicle.parts[frame].centre
    sliders: list[Element] = [
        Strut(law, "friction", *ends[:2], (ends[2],) * 2, 1, slider=Slider(law, 1e7, bound))  # type: ignore[arg-type]
        for law, bound in sides.items()
    ]
    pressed = Slider("coulomb", 1e7, friction=0.1, damping=1e3, normal=Normal(vehicle.elements[0].name))
    sliders.append(PlaneFriction("plane", "friction", *ends, 2, slider=pressed))
    rubbing = VehicleOnTrack(replace(vehicle, elements=(*vehicle.elements, *sliders)), law.track, (), speed=20.0)
    rubs, rubs_t = design_state(rubbing)
    rubs_t[:] += np.sin(np.arange(rubbing.size)) * 1e-2
    rubs[:] += np.cos(np.arange(rubbing.size)) * 1e-2
    rubbing(0.0, rubs, rubs_t, rubbed := np.zeros(rubbing.size))
    cases["friction"] = list(rubbed)
    cases["friction settled"] = list(rubbing.relaxed_rates(rubs, rubs_t))
    cases["inertia"] = [*mass_matrix(law.bodies, q).ravel(), *velocity_forces(law.bodies, q, q_t)]
    cases["accelerations"] = list(accelerations(law.bodies, q[None], q_t[None], out[None]).ravel())
    sampled = SampledForces(law, 1, False)
    sampled.evaluate(
        0, np.array([0.01]), q[None], q_t[None], law.places(np.array([[50.0 + m.x for m in vehicle.wheelsets]]))
    )
    cases["sampled forces"] = [*sampled.forces[0], *sampled.of("total 0", 1)["Fb"][0]]
    kinetic_energies(q[None], q_t[None], inertia_table(law.bodies), len(vehicle.wheelsets), energy := np.zeros(1))
    cases["kinetic energy"] = list(energy)
    cases["a filter"] = list(zero_phase(butterworth(4, 5.0, True, 100.0), np.arange(40.0) ** 2, 30))
    cases["finite"] = [float(first_not_finite(q, q_t))]
    poses = poses_on_track(law.track.centre, q[None, :6], q_t[None, :6], 50.0)
    cases["poses"] = [float(np.ravel(value)[0]) for value in poses]
    steady = SteadyMotion(law)
    cases["steady"] = list(steady.residual(steady.unknowns(q, q_t)))
    path = law.track.centre
    places = np.array([10.0, 60.0])
    cases["path"] = [*path.frame(places).ravel(), *np.ravel(curvature(path, places))]
    cases["path"] += list(locate(path, path.position(places) + np.array([0.1, 0.2, 0.3]), places + 1.0))
    wheels = ConicalWheels(0.1, 0.75, 1e7, 1e7, friction=0.3, flange_clearance=1e-3, flange_stiffness=1e7)
    conical = ConicalVehicleOnTrack(vehicle, law.track, wheels, speed=20.0, start=50.0)
    conical(0.01, q, q_t, out)
    cases["conical"] = list(out)
    bench = Stepper(alone, pose, moving, 1e-3, 1)
    bench.step()
    cases["step with a deadline"] = [*bench.q, *(float(value[0]) for value in bench.outputs.values())]
    return cases


def bent(segments: list[Segment]) -> list[float]:
    """An elastic axle that spins, bent, on a bridge: forces."""
    axle = Axle(((2.2, 0.16),), count=2)
    wheelset = shipped("wheelset_s1002_steering").with_wheelsets(lambda plain: replace(plain, axle=axle))
    deck = Bridge.of_spans(40.0, (30.0,), 2e10, 2e4, 0.02, 2)
    law = on_track(wheelset, 20.0, segments, structure=deck).law
    q, q_t = design_state(law, lateral=2e-3)
    q[0] -= 1e-4
    q[law.modes.start : law.modes.stop], q_t[law.modes.start : law.modes.stop] = 1e-5, 1e-2
    law(0.0, q, q_t, out := np.zeros(law.size))
    return list(out)


def step_on_sleepers(segments: list[Segment]) -> list[float]:
    """A wheelset on rails of coarse elements: forces, and the rails at the end of a step."""
    pads, ballast = Layer((5e7, 2e8), (2e4, 3e4)), Layer((2e7, 5e7), (4e4, 6e4))
    laid = SleeperTrack(RailBeam(), pads, ballast, sleeper_mass=300.0, elements=1, margin=10.0)
    law = on_track(shipped("wheelset_s1002_steering"), 20.0, segments, structure=laid).law
    q, q_t = design_state(law, lateral=2e-3)
    q[0] -= 1e-4  # into the rails
    forces, q_tt = np.zeros((2, law.size))
    law(0.0, q, q_t, forces)
    law.begin_step(1e-3, q, q_t, q_tt, False)
    law(1e-3, q, q_t, forces)
    law.hold(True, 0.0, q - 1e-6, q, q_t, q_tt)
    law.end_step(q, q_t)
    return [*forces, *q[-4:], *q_t[-4:]]


def implicit_step(law: VehicleOnTrack, q: Array, q_t: Array) -> list[float]:
    """A step of generalised alpha: Jacobian, first guess, estimated and computed iterations, and what watches it."""
    size, count = law.size, len(law.bodies)
    newton = ImplicitStep(q.copy(), q_t.copy(), np.linspace(-1.0, 1.0, size), count, law.rails, 1e-3, 1e3, 1e4)
    derivative = force_derivative(law, q, q_t, count, 0.0, 1.0, 0.5, central=False)
    forces, monitor = np.zeros(size), Monitor(law, law.speed, step=1e-3)
    newton.begin_iteration(0)
    newton.update(np.ones(size))
    newton.set_jacobian(derivative, 1.0)
    for iteration in (1, 2):
        newton.begin_iteration(iteration)
        newton.q += 1e-9
        if not newton.estimate(forces):
            law(0.0, newton.q, newton.q_t, forces)
            newton.update(forces)
    for _ in range(5):  # so many as are combined
        newton.end_step()
    monitor.step(0.0, True)
    for k in (1, 2, 3):  # a second difference
        monitor.phase_error.add(1e-3 * k, k * k * np.arange(2.0 * len(law.wheels)))
    ended = monitor.look(0.0, q, q_t)
    near = is_near(np.array([q, q_t]), newton.q, newton.q_t, 6 * count, 1e-3)
    errors = monitor.phase_error.arrays[0].ravel()
    return [*newton.q, *forces, *derivative.ravel(), *newton.rows.ravel(), *errors, float(near), float(ended is None)]


def cases(full: bool = False) -> dict[str, list[float]]:
    """All of them, or as few as set every kernel to work."""
    return contact_cases(full) | vehicle_cases()


def cases_and_first_calls(full: bool) -> tuple[dict[str, list[float]], dict[tuple[str, str], tuple[Any, ...]]]:
    """All cases, compiled, and what each kernel that Python calls was called with first."""
    calls: dict[tuple[str, str], tuple[Any, ...]] = {}
    plain = CPUDispatcher.__call__

    def call(kernel: Any, *arguments: Any) -> Any:
        code = kernel.py_func.__code__
        if (key := (code.co_filename, code.co_name)) not in calls:
            calls[key] = copy.deepcopy(arguments)
        return plain(kernel, *arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CPUDispatcher, "__call__", call)
        return cases(full), calls


def note_first_calls() -> set[tuple[str, str]]:
    """Uncompiled kernels that work from now on: each notes its first call, and is itself again in all modules."""
    worked: set[tuple[str, str]] = set()

    def watched(kernel: Callable[..., Any], places: list[tuple[dict[Any, Any], Any]]) -> Callable[..., Any]:
        @wraps(kernel)
        def first(*arguments: Any) -> Any:
            worked.add((kernel.__code__.co_filename, kernel.__code__.co_name))
            for namespace, name in places:
                namespace[name] = kernel
            return kernel(*arguments)

        return first

    namespaces_of: dict[Any, list[tuple[dict[Any, Any], Any]]] = {}
    for module in list(sys.modules.values()):
        for namespace in (
            vars(module),
            *(thing for thing in vars(module).values() if type(thing) is dict),
        ):  # stages, too
            for name, thing in namespace.items():
                if isinstance(thing, FunctionType) and thing.__code__.co_filename in SOURCES:
                    namespaces_of.setdefault(thing, []).append((namespace, name))
    for kernel, places in namespaces_of.items():
        for namespace, name in places:
            namespace[name] = watched(kernel, places)
    return worked


def compile_ahead() -> None:
    """Kernels that only tests call, their machine code in libraries, and what zig builds for pages."""
    with TemporaryDirectory() as scratch, begin_wasm_library(Path(scratch) / "empty.wasm"):
        cases(True)
        roll(1.0)
        wheelset = KnifeEdgeForces(example_wheelset(), 30.0)
        wheelset(0.0, *design_state(wheelset), np.zeros(wheelset.size))
        for kernel in (residuals, jacobian):
            kernel(*strip_system(pair_model(PAIR, normal="strips", **SMALL)))
        settle(bench(pair_model(PAIR, normal="strips", **SMALL), rolling=False), 0.0, 0.0, 1e4)
        locus_point(place_bodies(pair_model(PAIR, **SMALL).arrays.rows)[0], 0.03)
        compile_stages(*STAGES)
        for target in (this_target(), "wasm"):
            kept_objects({f"wrsim_stage_{number}": stage for number, stage in STAGES.items()}, target)


def main(form: str = "") -> None:
    """Do the cases without the compiler, and note which functions of the kernels' files work; without a form: compile
    for the tests to come."""
    if not form:
        compile_ahead()
        return
    kernels()  # all are imported
    worked = note_first_calls()
    sys.stdout.buffer.write(pickle.dumps((cases(form == "full"), worked)))


if __name__ == "__main__":
    main(*sys.argv[1:])
