"""Compiling ahead: short runs and poses with every contact model that is made of kernels."""

import time

import numpy as np

from wrsim.analysis import run
from wrsim.contact.models import NORMAL_MODELS
from wrsim.contact.wheel_rail import free_strips
from wrsim.errors import WrsimError
from wrsim.inputs.lookup import shipped_models
from wrsim.jit.cache import CACHE
from wrsim.jit.stages import compile_in_background
from wrsim.results.filters import LEAST_SAMPLES, low_pass
from wrsim.results.table import quantity
from wrsim.scenario.loading import load_text
from wrsim.scenario.templates import scenario_template


def warm() -> str:
    """Compile ahead, or find compiled, what runs along a track and static poses call.

    Parameters
    ----------
    None

    Returns
    -------
    str
        Where the compiled kernels are, and how long it took.

    Raises
    ------
    WrsimError
        Where there is no place for compiled kernels.
    """
    if CACHE is None:
        raise WrsimError("there is no place for compiled kernels")
    begin = time.perf_counter()
    with compile_in_background(free_strips):
        _try("kik-piotrowski")
    for normal in (name for name, model in NORMAL_MODELS.items() if model.solve is None):
        _try(normal)
    low_pass(np.zeros(LEAST_SAMPLES), 10.0, 1.0)
    return f"kernels are compiled, in {CACHE} ({quantity(time.perf_counter() - begin, 's', '.0f')})"


def _try(normal: str) -> None:
    """A short run and a static pose with a normal model."""
    for analysis, values in (("curving", {"run.distance_m": 0.2}), ("static", {"static.lateral_mm": 0})):
        scenario = load_text(scenario_template(analysis), shipped_models())
        run(scenario.with_values({"contact.normal": normal, **values}))
