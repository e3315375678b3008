"""Static analysis: many poses of one wheel or a wheelset, each at its prescribed vertical load."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models, wheels_on_rails
from wrsim.analysis.poses.half_space_solver import HalfSpacePoseSolver
from wrsim.analysis.poses.solver import PoseSolver
from wrsim.contact.channels import RawContacts, StripRecorder, patch_channels, remarks_channel, wheel_channels
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.static import StaticPlan

REPORT_INTERVAL = 0.1  # between two calls of the progress function [s]


def run_static(setup: Setup[StaticPlan], progress: Callable[[float, float], None] | None = None) -> Result:
    """Solve every pose of the plan. Poses without a solution carry a message; Ctrl-C keeps those already solved."""
    plan = setup.plan
    both = wheels_on_rails(setup, contact_models(setup, frictionless=not plan.rolling))
    wheels = both if plan.target == "wheelset" else tuple(w for w in both if w.name == plan.side)
    wheelset = setup.wheelset
    radius = wheelset.mean_radius if len(wheels) == 2 else getattr(wheelset, plan.side).radius
    exact = setup.contact.normal == "half-space"
    solver = (HalfSpacePoseSolver if exact else PoseSolver)(wheels, plan.rolling, radius)
    n = len(plan.poses)
    raw = RawContacts.empty(n, len(wheels), setup.contact.max_patches)
    strips = StripRecorder(wheels)
    heights, rolls, messages, remarks = np.full(n, np.nan), np.full(n, np.nan), [""] * n, [""] * n
    began = reported = time.perf_counter()
    done = 0
    try:
        for i, pose in enumerate(plan.poses):
            solved = solver.solve(pose)
            heights[i], rolls[i], messages[i], remarks[i] = solved.height, solved.roll, solved.message, solved.remark
            for j, wheel in enumerate(wheels):
                raw.store(i, j, wheel.model)
            strips.store(solver.elements())
            if not np.isfinite(solved.height):
                raw.clear(i)
                strips.clear_last()
            done = i + 1
            now = time.perf_counter()
            if progress is not None and now - reported > REPORT_INTERVAL:
                reported = now
                progress(done / n, (now - began) * (n - done) / done)
    except KeyboardInterrupt:
        if done == 0:
            raise
    if progress is not None and done == n:
        progress(1.0, 0.0)
    if not np.isfinite(heights[:done]).any():
        raise SimulationError(f"none of the {done} poses has a solution; the first: {messages[0]}")
    poses = plan.poses[:done]
    raw = raw.first(done)
    channels = {
        "load": np.array([p.load for p in poses]),
        "pose_message": np.array(messages[:done]),
        **remarks_channel(remarks[:done]),
        "lateral_shift": np.array([p.lateral for p in poses]),
        "vertical_shift": heights[:done] - radius,
        "yaw": np.array([p.yaw for p in poses]),
        "roll": rolls[:done],
        **wheel_channels(raw),
        **patch_channels(raw, wheels),
        **strips.channels(),
    }
    reason = f"interrupted by the user after {done} of {n} poses" if done < n else ""
    coords = {"pose": [p.name for p in poses], "wheel": [w.name for w in wheels]}
    return Result(assemble(coords, channels, setup.attributes(reason)))
