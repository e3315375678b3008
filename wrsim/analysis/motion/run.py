"""A run along the track: time integration at speed, from steady motion at the start."""

import logging
from contextlib import closing, nullcontext, suppress
from dataclasses import replace
from math import ceil
from pathlib import Path

import numpy as np

from wrsim.analysis.contacts import contact_at, force_law
from wrsim.analysis.motion.messages import NoSteadyMotion, start_words
from wrsim.analysis.motion.monitor import PEAK_ERROR, STRIKE, Monitor
from wrsim.analysis.motion.record import RunRecord
from wrsim.analysis.motion.result import result_of
from wrsim.analysis.motion.samples import Samples, worked_through
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.progress import Progress
from wrsim.contact import wheel_rail
from wrsim.contact.models import NORMAL_MODELS
from wrsim.contact.search import locus
from wrsim.contact.strips import equations
from wrsim.contact.surfaces.out_of_round import Flat
from wrsim.errors import InputError, SimulationError
from wrsim.jit.compiling import COUNT, Kernel, cores
from wrsim.jit.stages import compile_in_background
from wrsim.register import ANALYSES
from wrsim.results import Result
from wrsim.results.run_file import run_header
from wrsim.results.table import quantity
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario, loaded
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation import step_size as steps
from wrsim.simulation.integrate import SEGMENT, Integration, recorded_motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.precompile import compile_others
from wrsim.simulation.recorder import Recorder
from wrsim.simulation.stepper import Stepper, with_torques
from wrsim.simulation.system import Array, BodySystem
from wrsim.timing import timed
from wrsim.track import path_kernel as path_kernels
from wrsim.track.segments import Straight
from wrsim.track.sleepers import SleeperTrack
from wrsim.vehicle.dynamics import (
    derivative,
    implicit_step,
    kinematics,
    rigid_body,
    sampling,
    vehicle_forces,
    watch,
    wheel_forces,
)

log = logging.getLogger(__name__)

STEPS_OF_A_SECTION = 3
"""Least number of implicit steps between two neighbouring sections of a rail that changes along the track."""
STEPS_OF_A_FLAT = 30
"""Least number of implicit steps over the length of a flat, so that they follow its shape."""
BLOW = 10.0
"""Blow of a flat over the load at rest, of which the step allows ``PEAK_ERROR``: pi (w h)^2 / 12, see ``STRIKE``. The
fastest mode w of the vehicle on its rails is that of a rail's mass under its wheel; Hertz's stiffness, and so w^2,
grows with the cube root of the load."""
SHRUNK = 10.0  # by how much shorter than usual a chosen step of RK44 is reported
BENCH_STEP, BENCH_ITERATIONS, BENCH_LONGEST = 1e-3, 2, 5e-3  # of vehicles that others move on step by step [s]
LEAST_BUDGET = 3.0
"""Residuals of the strip model a wheel and evaluation: half of the strips of one grid step to a contact near by."""
HELD, HELD_SHARE, HALVINGS = 0.01, 0.95, 4
"""A step of a `stepper` holds where in so large a share of the steps of a run at most so much of the weight is left
without balance. One that is too long leaves as much as the weight in a tenth of them and more."""
SEGMENT_EXACT = 5  # steps between two checkpoints with the exact contact solver; each takes a second or more


CALLED = (
    vehicle_forces.vehicle_forces, derivative.add_differences, implicit_step.predict, implicit_step.estimate,
    implicit_step.update, implicit_step.set_jacobian, implicit_step.end_step, watch.watch_step, watch.look,
    watch.add_phase_error, kinematics.is_near, kinematics.first_not_finite, kinematics.place_on_track,
    kinematics.poses_along, rigid_body.follow_together, rigid_body.together_inertia, path_kernels.frame_at,
    path_kernels.frame_rates, sampling.forces_in_turn, equations.block_of, locus.outline, wheel_forces.one_wheel,
    wheel_forces.in_turn, wheel_rail.wheel_rail, wheel_rail.all_creep_forces,
)  # fmt: skip
"""Kernels that Python calls in an implicit run along the track, and stages, without the normal model."""


def run_in_time(setup: Setup[RunPlan], progress: Progress | None = None, record: RunRecord | None = None) -> Result:
    """Integrate from the start to the end of the run; a run that has to stop returns what it has.

    record: the file that keeps the run while it lasts, to go on from. Raises SimulationError without a steady start.
    """
    normal = wheel_rail.STAGES[NORMAL_MODELS[setup.contact.normal].kernel]
    for function in (*CALLED, normal):
        if isinstance(function, Kernel):
            COUNT.begin(function.py_func)  # so that the total does not grow while they are compiled
    if normal is wheel_rail.free_strips:
        with compile_in_background(normal) as in_background:
            if in_background:
                compile_others()
    law = force_law(setup)
    system = BodySystem(law.bodies, law)
    if record is not None and record.resume:
        step = float(run_header(record.path)["step_s"])
        q = q_t = np.zeros(system.size)  # the file knows better
    else:
        try:
            with timed("steady motion at the start"):
                q, q_t = start_state(setup, law)
            with timed("time step chosen"):
                step = chosen_step(setup, law, q, q_t)
        except NoSteadyMotion as problem:
            raise SimulationError(start_words(problem, setup)) from None

    def took() -> str:
        evaluations, jacobians, wheels = system.work.evaluations, system.work.jacobians, len(monitor.wheels)
        return (
            f"integration, steps of {quantity(1e3 * step, 'ms')}: {evaluations} evaluations of the forces, {jacobians} "
            f"Jacobians, {evaluations * wheels} contacts of a wheel"
        )

    plan = setup.plan
    refined = plan.step is None and plan.integrator == "generalised-alpha"
    monitor = Monitor(law, plan.speeds[1], system.work, step if refined else 0.0)
    folder = None if record is None else record.path.parent
    with closing(
        Recorder(system.size) if record is None else record.recorder(plan.integrator, step, system.size)
    ) as recorder:
        # whole steps, so that the run does not pass the end of the track
        duration = step * max(1, int(plan.duration / step + 1e-6))
        integration = Integration(
            system, duration=duration, step=step, integrator=plan.integrator, weight=law.vehicle.weight,
            sample_interval=plan.output_interval, record_interval=plan.fast_interval, monitor=monitor,
            monitor_interval=monitor.interval,
            segment=SEGMENT if setup.contact.fast() == setup.contact else SEGMENT_EXACT, progress=progress,
            recorder=recorder,
        )  # fmt: skip
        samples = None
        if _samples_beside(setup, law) and recorder.last is None:
            samples = Samples(setup, law, integration.sample_count, folder)
        with nullcontext() if samples is None else worked_through(samples) as recorder.listener, timed(took):
            motion = integration.run(q, q_t)
    return result_of(setup, law, motion, monitor.events(), folder, samples)


def _samples_beside(setup: Setup[RunPlan], law: VehicleOnTrack) -> bool:
    """Whether channels of samples may be computed while the run goes on: a core is free, the kernel gives all forces,
    and a sample needs neither those behind it nor what the rails of the run remember."""
    needs_all = setup.plan.wear is not None or bool(setup.plan.fast_channels)
    return setup.threads == 1 < cores() and law.compiled and law.on_sleepers is None and not needs_all


def stepper(
    scenario: Scenario | str | Path,
    step: float = BENCH_STEP,
    iterations: int = BENCH_ITERATIONS,
    budget: float = np.inf,
) -> Stepper:
    """A vehicle for a test bench or for co-simulation, in the steady motion that a run of the scenario starts from.

    Parameters
    ----------
    scenario : Scenario, str or Path
        Of a run along the track, or its file. Its length does not matter, the track must be long enough for all steps.
    step : float
        Of the integration [s].
    iterations : int
        Evaluations of the forces in a step.
    budget : float
        Residuals of the strip model a wheel and evaluation [1], which all of a step share; inf: any number. Contacts
        that it is too small for are coarser, see `Stepper.coarse`.

    Returns
    -------
    Stepper
        It is moved on by `Stepper.step`; its ``inputs`` are moments of wheelsets, forces of struts and constant loads.

    Raises
    ------
    InputError
        For another analysis, for the exact contact solver, for a step or a number of iterations that cannot be.
    SimulationError
        Where there is no steady motion at the start.
    """
    if not 0.0 < step <= BENCH_LONGEST:
        raise InputError(f"step = {step:g}: must be above 0 and at most {BENCH_LONGEST:g} s")
    if not iterations >= 1:
        raise InputError(f"iterations = {iterations}: must be a whole number from 1 on")
    if not budget >= LEAST_BUDGET:
        raise InputError(f"budget = {budget:g}: must be {LEAST_BUDGET:g} residuals a wheel and evaluation or more")
    scenario = loaded(scenario)
    setup = build(scenario)
    if not isinstance(setup.plan, RunPlan) or not ANALYSES[setup.analysis].moves:
        raise scenario.fault(("analysis",), "only runs along the track can be taken step by step")
    if setup.contact.fast() != setup.contact:
        raise scenario.fault(("contact", "normal"), "takes seconds a step; step by step only with the fast models")
    if isinstance(setup.track.structure, SleeperTrack):
        raise scenario.fault(("track", "structure", "kind"), 'cannot be "sleepers" step by step')
    setup = replace(setup, track=replace(setup.track, reach=np.inf))
    law = force_law(replace(setup, vehicle=with_torques(setup.vehicle), threads=1), stepped=True)
    try:
        return Stepper(law, *start_state(setup, law), step, iterations, budget)
    except NoSteadyMotion as problem:
        raise SimulationError(start_words(problem, setup)) from None


def holding_stepper(scenario: Scenario, step: float | None = None, budget: float | None = None) -> Stepper:
    """A `stepper` with a step [s], or with BENCH_STEP, halved until it holds over the run: ``tried``. Raises
    SimulationError where none does."""
    budget = np.inf if budget is None else budget
    if step is not None:
        return stepper(scenario, step, budget=budget)
    duration = None
    for halvings in range(HALVINGS + 1):
        step = BENCH_STEP / 2**halvings
        bench = stepper(scenario, step, budget=budget)  # refuses what has no duration
        duration = duration or build(scenario).plan.duration
        if _holds(bench, round(duration / step)):
            chosen = stepper(scenario, step, budget=budget)
            chosen.tried = bench.coarse
            return chosen
    raise SimulationError(
        f"{scenario.title}: no step down to {1e3 * BENCH_STEP / 2**HALVINGS:g} ms holds with {BENCH_ITERATIONS}"
        f" iterations: more than {HELD:.0%} of the weight is left without balance"
        f" in more than {1.0 - HELD_SHARE:.0%} of the steps"
    )


def _holds(bench: Stepper, steps: int) -> bool:
    """Whether so many steps hold."""
    left = round((1.0 - HELD_SHARE) * steps)
    with suppress(SimulationError):
        for _ in range(steps):
            bench.step()
            left -= bench.residual[0] > HELD
            if left < 0:
                return False
        return True
    return False


def recorded_run(setup: Setup[RunPlan], path: Path) -> Result:
    """The result of what a file holds of a run; the process that ran it may be dead or still at work.

    Events are those that the run had noted when it was last stored.
    """
    law = force_law(setup)
    monitor = Monitor(law, setup.plan.speeds[1])
    motion = recorded_motion(path, monitor)
    if motion.q.shape[1] != law.size:
        raise InputError(f"{path}: holds {motion.q.shape[1]} coordinates, its scenario has {law.size}; run it again")
    return result_of(setup, law, motion, monitor.events(), path.parent)


def refuse_step(setup: Setup[RunPlan]) -> None:
    """Raise StepTooLong where a run would. That there is no steady motion to start from is for the run to report."""
    law = force_law(setup)
    with suppress(SimulationError):
        chosen_step(setup, law, *start_state(setup, law))


def chosen_step(setup: Setup[RunPlan], law: VehicleOnTrack, q: Array, q_t: Array) -> float:
    """Step [s] that the plan asks for, or a good one for its integrator; it divides the time between two samples."""
    plan = setup.plan
    if plan.integrator == "rk44":
        step, each = _stable_step(setup, law, q, q_t), plan.fast_interval
        return step if each is None else each / ceil(each / step - 1e-9)
    if plan.step:
        return plan.step
    fastest = plan.speeds[1]
    rails = setup.track.structure
    spacing = rails.spacing if isinstance(rails, SleeperTrack) else None
    step = steps.implicit_step(fastest, plan.recorded_interval, spacing, vibrates=len(law.modes) > 0)
    places = [[item.distance for item in surface.sections] for surface in setup.surfaces if surface is not None]
    # sections that follow each other closely show how fast the rail changes
    ways = [gap / STEPS_OF_A_SECTION for row in places for gap in np.diff(row).tolist()]
    wheels = [wheel for item in setup.vehicle.wheelsets for wheel in (item.wheelset.left, item.wheelset.right)]
    flats = [part for wheel in wheels for part in wheel.out_of_round if isinstance(part, Flat)]
    if flats:
        fastest_mode = float(np.abs(steps.eigenvalues(law, law.bodies, q, q_t).imag).max())
        ways.append(fastest * (PEAK_ERROR / STRIKE / BLOW ** (1.0 / 3.0)) ** 0.5 / fastest_mode)
    ways += [flat.length / STEPS_OF_A_FLAT for flat in flats]
    return step / max(1, ceil(step * fastest / min(ways))) if ways else step


def _stable_step(setup: Setup[RunPlan], law: VehicleOnTrack, q: Array, q_t: Array) -> float:
    """Step of RK44 [s] that the plan asks for, or one stable at the start (q, q_t) of the run and on straight track.

    It is never longer than the time between two samples. In a curve the creep forces are near saturation and allow a
    longer step than they do on straight track, so a run that starts in a curve must not rely on its start. The exact
    contact solver takes the step that is stable with a fast model.
    Raises StepTooLong for a given step that is not even stable at the start: its results would look like results.
    """
    plan = setup.plan
    near = replace(setup, contact=setup.contact.fast(), vehicle=setup.vehicle.loaded_as_at(plan.start))
    if near.contact != setup.contact:
        law = force_law(near)
    limit = steps.stable_step(BodySystem(law.bodies, law), q, q_t)
    if plan.step is not None:
        if plan.step > limit:
            raise steps.StepTooLong(plan.step, limit, plan.speed)
        return plan.step
    slowest = replace(plan, speed=plan.speeds[0], profile=None)
    if setup.track.curvature(plan.start) != 0.0 or slowest.speed < plan.speed:
        straight, contact = setup.track.relaid([Straight(100.0)]), contact_at(near, plan.start)
        level = replace(near, track=straight, contact=contact, plan=replace(slowest, start=30.0))
        law = force_law(level)
        limit = min(limit, steps.stable_step(BodySystem(law.bodies, law), *start_state(level, law)))
    largest = steps.LARGEST_STEP_UNEVEN if setup.track.is_uneven else steps.LARGEST_STEP
    step = steps.round_step(min(steps.SAFETY * limit, plan.recorded_interval), largest)
    usual = min(steps.step_for_speed(slowest.speed), plan.recorded_interval)
    if step < usual / SHRUNK:
        log.warning(
            "rk44 is stable here with steps of %.3g us only, %.0f times shorter than usual at %.4g km/h: %.3g steps. A "
            "mass or a stiffness out of proportion does this (wrsim check warns of some)",
            1e6 * step, usual / step, 3.6 * slowest.speed, plan.duration / step,
        )  # fmt: skip
    return step
