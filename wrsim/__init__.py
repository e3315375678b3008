"""wrsim: railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.

::

    from wrsim import load, run

    result = run(load("scenarios/curve_r300.toml"))
    print(result.summary())
    result.save("curve_r300.nc")
"""

from importlib import import_module as _import_module
from typing import Any as _Any

__version__ = "0.1.0"

_HOMES = {
    "load": "wrsim.scenario.loading",
    "run": "wrsim.analysis",
    "Scenario": "wrsim.scenario.loading",
    "Result": "wrsim.results",
    "WrsimError": "wrsim.errors",
    "InputError": "wrsim.errors",
    "SimulationError": "wrsim.errors",
}
"""Public names and their modules, imported on first use: ``import wrsim`` alone costs nothing."""

__all__ = ["InputError", "Result", "Scenario", "SimulationError", "WrsimError", "__version__", "load", "run"]


def __getattr__(name: str) -> _Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'wrsim' has no attribute '{name}'")
    value = getattr(_import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
