"""Poses at prescribed vertical loads: static analysis of a wheel or a wheelset; tables of contacts for other codes."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from wrsim.analysis.contacts import wheels_on_rails
from wrsim.analysis.progress import Progress, Report
from wrsim.contact.batch import Contacts
from wrsim.contact.channels import StripRecorder, WheelOnRail, contact_channels, remarks_channel
from wrsim.contact.model import ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.patches import RawContacts
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import DRY, TURNED, AnyFriction, ContactSettings
from wrsim.contact.status import LEFT_TO_EXACT, UNMET
from wrsim.errors import InputError, SimulationError
from wrsim.jit import Array
from wrsim.results import CHANNELS, Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.static import StaticPlan, named
from wrsim.simulation.pose_solver import CLEARANCE, HalfSpacePoseSolver, PoseSolver, Solved
from wrsim.track.cant import STANDARD_GAUGE

STEEP = np.radians(60.0)
"""Steepest direction of a wheel's force, from the vertical, that passes without a word: to carry a vertical load on a
steeper flank takes a lateral force beyond what any rail vehicle has, and pressures to match."""

REPORT_INTERVAL = 0.1  # between two calls of the progress function [s]
STANDARD_SPACING = 1.5  # distance of the tape circles of wheelsets for standard gauge [m]
AXES = {"shift": "m", "yaw": "rad", "roll": "rad", "load": "N"}
MOST_POSES = 1_000_000  # in a table


def run_static(setup: Setup[StaticPlan], progress: Progress | None = None) -> Result:
    """Solve every pose of the plan. Poses without a solution carry a message; Ctrl-C keeps those already solved."""
    plan = setup.plan
    pair = wheels_on_rails(setup)
    wheels = pair if plan.target == "wheelset" else tuple(w for w in pair if w.name == plan.side)
    wheelset = setup.wheelset
    radius = wheelset.mean_radius if len(wheels) == 2 else getattr(wheelset, plan.side).radius
    return _solved(wheels, plan.poses, plan.rolling, radius, setup.attributes(), progress)


def solve_poses(
    model: ContactModel,
    poses: Sequence[Pose],
    *,
    side: Literal["left", "right"] = "left",
    gauge: float = STANDARD_GAUGE,
    profile_spacing: float = STANDARD_SPACING,
    rolling: bool = True,
    title: str = "",
    progress: Progress | None = None,
) -> Result:
    """Contact of one wheel on one rail at prescribed poses, each under its own vertical load.

    The same as a scenario with ``analysis = "static"`` and ``target = "wheel"``, of profiles and settings that are at
    hand in Python.

    Parameters
    ----------
    model : ContactModel
        The wheel on its rail, from `contact_model`.
    poses : sequence of Pose
        What is prescribed.
    side : {"left", "right"}
        Of the wheelset that the wheel is on.
    gauge : float
        Track gauge [m].
    profile_spacing : float
        Distance of the origins of both wheels' profiles, the tape circles [m].
    rolling : bool
        Whether the wheel rolls without slip at the tape circle. If not, the poses are frictionless.
    title : str
        For pictures and tables.
    progress : callable, optional
        Called some ten times a second with the fraction done and the seconds left.

    Returns
    -------
    Result
        Of kind ``"static"``. A pose without a solution carries a message in ``pose_message``.

    Raises
    ------
    InputError
        For a side that there is not, for poses without a load, for two poses of one name.
    SimulationError
        When none of the poses has a solution.

    Examples
    --------
    >>> from wrsim import Pose, contact_model, load_profile, solve_poses
    >>> rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    >>> model = contact_model(load_profile("wheels/S1002.toml"), rail, radius=0.46)
    >>> result = solve_poses(model, [Pose(lateral=1e-3 * y, load=60e3) for y in (0, 3, 6)])
    """
    if isinstance(poses, Pose) or not poses or not all(isinstance(pose, Pose) for pose in poses):
        raise InputError("poses: must be a list of at least one Pose")
    for pose in poses:
        if not np.isfinite([pose.lateral, pose.yaw, pose.roll, pose.wheel_angle]).all():
            raise InputError(f"pose '{pose.name}': has numbers that are not finite: {pose}")
        if not pose.load > 0.0:
            raise InputError(f"pose '{pose.name}': load = {pose.load:g}: must be a vertical force above 0 N")
    wheel = on_rail(model, side, gauge, profile_spacing, rolling)
    attributes: dict[str, str | float | int] = {
        "title": title or f"{model.wheel.name} on {model.rail.name}",
        "analysis": "static",
        "status": "completed",
        "scenario_text": "# poses that were solved from Python: there is no scenario file\n",
    }
    return _solved((wheel,), named(poses), rolling, model.radius, attributes, progress)


def on_rail(model: ContactModel, side: str, gauge: float, profile_spacing: float, rolling: bool) -> WheelOnRail:
    """The wheel of a side in its place; see `solve_poses`. One that does not roll has no friction."""
    if side not in ("left", "right"):
        raise InputError(f"side = {side!r:.40}: must be left or right")
    if not rolling:
        model = replace(model, settings=replace(model.settings, tangential="none"))
    outward, height = 0.5 * gauge - model.rail.gauge_point()[0], -model.rail.top[1]
    return WheelOnRail(model, 1 if side == "left" else -1, 0.5 * profile_spacing, (outward, height))


def _solved(
    wheels: Sequence[WheelOnRail], poses: Sequence[Pose], rolling: bool, radius: float,
    attributes: dict[str, str | float | int], progress: Progress | None,
) -> Result:  # fmt: skip
    """The result of poses; attributes: of the result, where it is not interrupted."""
    settings = wheels[0].model.settings
    exact = settings.normal == "half-space"
    solver = (HalfSpacePoseSolver if exact else PoseSolver)(wheels, rolling, radius)
    n = len(poses)
    raw = RawContacts.empty(n, len(wheels), settings.patch_count)
    strips = StripRecorder(wheels)
    solutions: list[Solved] = []
    report = Report(progress, REPORT_INTERVAL)
    try:
        for i, pose in enumerate(poses):
            solved = solver.solve(pose)
            for j, wheel in enumerate(solver.holders):
                raw.store(i, j, wheel.model.arrays)
            strips.store(solver.elements(), solver.holders)
            if not np.isfinite(solved.height):
                raw.clear(i)
                strips.clear_last()
            solutions.append(solved)
            report(len(solutions) / n)
    except KeyboardInterrupt:
        if not solutions:
            raise
    if all(np.isnan(solved.height) for solved in solutions):
        raise SimulationError(f"none of the {len(solutions)} poses has a solution; the first: {solutions[0].message}")
    poses = poses[: len(solutions)]
    of_wheels = contact_channels(raw.first(len(solutions)), wheels)
    names = [w.name for w in wheels]
    remarks, turned = [], _turned_message(wheels, poses, of_wheels, rolling, radius)
    for i, solved in enumerate(solutions):
        flanks = [_flank_message(name, {n: v[i, j] for n, v in of_wheels.items()}) for j, name in enumerate(names)]
        remarks.append("; ".join(filter(None, [solved.remark, *flanks, turned.get(i)])))
    channels: dict[str, ArrayLike] = {
        "load": [p.load for p in poses],
        "pose_message": [solved.message for solved in solutions],
        **remarks_channel(remarks),
        "lateral_shift": [p.lateral for p in poses],
        "vertical_shift": [solved.height - radius for solved in solutions],
        "yaw": [p.yaw for p in poses],
        "roll": [solved.roll for solved in solutions],
        **of_wheels,
        **strips.channels(),
    }
    if len(solutions) < n:
        reason = f"interrupted by the user after {len(solutions)} of {n} poses"
        attributes = attributes | {"status": "stopped", "stop_reason": reason}
    return Result(assemble({"pose": [p.name for p in poses], "wheel": names}, channels, attributes))


def _flank_message(wheel: str, wheel_rows: dict[str, NDArray[np.float64]]) -> str:
    """A sentence on a wheel that carries its vertical load on a flank; empty for any other."""
    y, q = float(wheel_rows["Y"]), float(wheel_rows["Q"])
    if not (q > 0.0 and np.arctan2(abs(y), q) > STEEP):
        return ""
    k = int(np.nanargmax(wheel_rows["N"]))
    angle, normal, pressure = (float(wheel_rows[name][k]) for name in ("contact_angle", "N", "p0"))
    return (
        f"the {wheel} wheel carries {q / 1e3:.4g} kN down on a flank of {np.degrees(angle):.3g} degrees: "
        f"N = {normal / 1e3:.4g} kN, p0 = {pressure / 1e6:.4g} MPa, and {abs(y) / 1e3:.4g} kN sideways to hold it there"
    )


def _turned_message(
    wheels: Sequence[WheelOnRail], poses: Sequence[Pose], channels: dict[str, Array], rolling: bool, radius: float
) -> dict[int, str]:
    """A sentence on each pose whose strips leave out that their influence turns with normals, though these turn by more
    than TURNED over a patch: what it would change."""
    settings = wheels[0].model.settings
    if settings.normal != "strips" or settings.half_space.influence != "half-space":
        return {}
    angle = np.nan_to_num(channels["contact_angle_max"] - channels["contact_angle_min"]).max(axis=2)
    settings = replace(settings, half_space=replace(settings.half_space, influence="angle-corrected"))
    solver = PoseSolver([replace(w, model=replace(w.model, settings=settings)) for w in wheels], rolling, radius)
    sentences = {}
    for i in np.flatnonzero(angle.max(axis=1) > TURNED).tolist():
        if solver.solve(poses[i]).message:
            continue
        j = int(angle[i].argmax())
        arrays, p0 = solver.holders[j].model.arrays, float(np.nanmax(channels["p0"][i, j]))
        corrected = float(arrays.patches[: arrays.total.lobes]["p0"].max())
        sentences[i] = (
            f"normals turn by {np.degrees(angle[i, j]):.3g} degrees over a patch of the {wheels[j].name} wheel, which "
            f"the influence of pressures leaves out: p0 = {p0 / 1e6:.4g} MPa, and {corrected / 1e6:.4g} MPa with "
            'contact.half_space.influence = "angle-corrected"'
        )
    return sentences


def contact_map(
    wheel: Profile,
    rail: Profile,
    radius: float,
    shifts: ArrayLike,
    yaws: ArrayLike = 0.0,
    rolls: ArrayLike = 0.0,
    loads: ArrayLike = 60e3,
    *,
    settings: ContactSettings | None = None,
    friction: AnyFriction = DRY,
    side: Literal["left", "right"] = "left",
    gauge: float = STANDARD_GAUGE,
    profile_spacing: float = STANDARD_SPACING,
    rolling: bool = True,
    threads: int | None = None,
    file: str | Path | None = None,
) -> xr.Dataset:
    """Contacts of one wheel over every combination of shift, yaw, roll and vertical load.

    Parameters
    ----------
    wheel, rail : Profile
        The rail with its inclination, ``rail.inclined(1 / 40)``.
    radius : float
        Of the wheel at the tape circle [m].
    shifts, yaws, rolls, loads : array_like
        One number or a list of each: lateral shift of the wheelset, positive to the left [m]; yaw, positive to the
        left, and roll, positive lifts the left wheel [rad]; vertical force [N].
    settings, friction, side, gauge, profile_spacing, rolling, threads
        As in `contact_model`, `solve_poses` and `ContactModel.solve_many`.
    file : str or Path, optional
        Where the table is saved, as NetCDF.

    Returns
    -------
    xarray.Dataset
        Over the axes and ``patch``, the largest normal force first: ``vertical_shift`` of the wheelset's centre, ``X``,
        ``Y``, ``Q``, ``T_gamma``, ``n_patches``, ``status``; of the patches ``N``, ``p0``, ``area``, ``contact_angle``
        ... with their ``units``, names and signs of results. Not-a-number where a load is not met; see ``status``.

    Raises
    ------
    InputError
        For empty lists, numbers that are not finite, loads not above 0, more threads than cores, a side that there is
        not, the exact half-space solver.

    Examples
    --------
    >>> from wrsim import contact_map, load_profile
    >>> rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    >>> table = contact_map(load_profile("wheels/S1002.toml"), rail, 0.46, [0.0, 3e-3], loads=[50e3, 60e3])
    """
    model = contact_model(wheel, rail, radius, settings, friction)
    axes = _map_axes(shifts, yaws, rolls, loads)
    placed = on_rail(model, side, gauge, profile_spacing, rolling)
    solver = PoseSolver([placed], rolling, radius)
    start = radius + CLEARANCE + np.abs(np.sin(axes["roll"])).max() * placed.half_spacing
    poses = _map_poses(solver, axes, float(start))
    contacts = _solve_map(solver, axes, poses, threads)
    height = contacts.poses[:, 2] - poses[:, 2] + start - radius
    table = _map_table(axes, contacts, placed, height).assign_attrs({
        "title": f"contacts of {wheel.name} on {rail.name}", "radius_m": radius, "gauge_m": gauge, "side": side,
        "profile_spacing_m": profile_spacing, "rolling": int(rolling),
        "normal": model.settings.normal, "creep_forces": placed.model.settings.creep_forces,
    })  # fmt: skip
    if file is not None:
        table.to_netcdf(file)
    return table


def _map_axes(*values: ArrayLike) -> dict[str, Array]:
    """Values of every axis of a map. Raises InputError for what is no list of finite numbers, and for too many."""
    axes = {name: np.atleast_1d(np.asarray(axis, dtype=float)) for name, axis in zip(AXES, values, strict=True)}
    for name, axis in axes.items():
        if axis.ndim != 1 or not axis.size or not np.isfinite(axis).all():
            raise InputError(f"{name}s: must be a number or a list of numbers, all finite")
    count = np.prod([axis.size for axis in axes.values()])
    if count > MOST_POSES:
        raise InputError(f"{count} combinations of shifts, yaws, rolls and loads; allowed: {MOST_POSES}")
    return axes


def _map_poses(solver: PoseSolver, axes: dict[str, Array], height: float) -> Array:
    """Poses of the wheel, a row each, over all axes; height: of the wheelset's centre [m]."""
    rows = []
    for shift, yaw, roll in product(*(axes[name].tolist() for name in ("shift", "yaw", "roll"))):
        solver.place(shift, height, yaw, roll)
        rows.append(solver.wheels[0].model.arrays.pose.copy())
    return np.repeat(rows, axes["load"].size, axis=0)


def _solve_map(solver: PoseSolver, axes: dict[str, Array], poses: Array, threads: int | None) -> Contacts:
    """Contacts of all poses in one batch; those that it leaves to the exact solver are solved as single poses."""
    keys = np.array(list(product(*(values.tolist() for values in axes.values()))))
    contacts = solver.wheels[0].model.solve_many(poses, keys[:, -1], threads=threads)
    for i in np.flatnonzero(contacts.status & LEFT_TO_EXACT).tolist():
        shift, yaw, roll, load = keys[i].tolist()
        solver.solve(Pose(lateral=shift, yaw=yaw, roll=roll, load=load))
        if solver.holders is not solver.wheels:
            arrays = solver.holders[0].model.arrays
            contacts.raw.store(i, 0, arrays)
            contacts.poses[i], contacts.status[i] = arrays.pose, arrays.status
    return contacts


def _map_table(axes: dict[str, Array], contacts: Contacts, placed: WheelOnRail, height: Array) -> xr.Dataset:
    """Channels of contacts over the axes, not-a-number where a load is not met; height: see `contact_map` [m]."""
    shape, unmet = tuple(values.size for values in axes.values()), (contacts.status & UNMET) != 0
    channels = {name: values[:, 0] for name, values in contact_channels(contacts.raw, [placed]).items()}
    table = xr.Dataset(coords={name: (name, values, {"units": AXES[name]}) for name, values in axes.items()})
    for name, values in (channels | {"vertical_shift": height}).items():
        values = np.where(unmet.reshape(-1, *(1,) * (values.ndim - 1)), np.nan, values)
        dims = (*AXES, "patch")[: 3 + values.ndim]
        table[name] = dims, values.reshape(*shape, *values.shape[1:]), {"units": CHANNELS[name].unit}
    table["status"] = tuple(AXES), contacts.status.reshape(shape), {"units": "1"}
    return table
