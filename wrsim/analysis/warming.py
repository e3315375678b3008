"""Compiling ahead: short runs and poses with every contact model that is made of kernels."""

from __future__ import annotations

import time

from wrsim.analysis import run
from wrsim.contact.models import NORMAL_MODELS
from wrsim.core.jit.cache import CACHE
from wrsim.errors import WrsimError
from wrsim.inputs.lookup import shipped_models
from wrsim.results.table import quantity
from wrsim.scenario.loading import load_text

SCENARIO = """
title = "what runs and poses need"
analysis = "{analysis}"
[vehicle]
model = "vehicles/wheelset_s1002.toml"
{speed}
[track]
gauge_mm = 1435
rail = "rails/60E1.toml"
inclination = "1:40"
{rest}
[contact]
normal = "{normal}"
"""
OF_RUN = """
[[track.segments]]
kind = "straight"
length_m = 3
[run]
distance_m = 0.2
"""
OF_POSES = """
[static]
target = "wheel"
side = "right"
load_kN = 60
lateral_mm = 0
"""


def warm_up() -> str:
    """Compile, or find compiled, what runs along a track and static poses call; returns where and how long, in words.

    Raises ``WrsimError`` where there is no place to keep compiled kernels in.
    """
    if CACHE is None:
        raise WrsimError("there is no place to keep compiled kernels in")
    begin = time.perf_counter()
    normals = [name for name, model in NORMAL_MODELS.items() if model.solve is None]
    for normal in normals:
        for analysis, speed, rest in (("curving", "speed_kmh = 54", OF_RUN), ("static", "", OF_POSES)):
            run(load_text(SCENARIO.format(analysis=analysis, speed=speed, rest=rest, normal=normal), shipped_models()))
    return f"kernels are compiled, in {CACHE} ({quantity(time.perf_counter() - begin, 's', '.0f')})"
