"""wrsim: railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.

::

    from wrsim import load, run

    result = run(load("scenarios/curve_r300.toml"))
    result.plot("Y", "Q").savefig("forces.png")
    result.save("curve_r300.nc")

docs/user/python.md lists what is here; ``__init__.pyi`` is the same for type checkers and editors.
"""

from importlib import import_module as _import_module
from typing import Any as _Any

__version__ = "0.1.0"

_HOMES = {
    "load": "wrsim.scenario.loading",
    "load_text": "wrsim.scenario.loading",
    "Scenario": "wrsim.scenario.loading",
    "run": "wrsim.analysis",
    "stepper": "wrsim.analysis.motion.run",
    "run_scenario": "wrsim.api.runs",
    "show": "wrsim.api.runs",
    "compare": "wrsim.api.runs",
    "resolve": "wrsim.api.runs",
    "check": "wrsim.api.runs",
    "assess": "wrsim.api.analyses",
    "ride": "wrsim.api.analyses",
    "spectra": "wrsim.api.analyses",
    "conicity": "wrsim.api.analyses",
    "profiles": "wrsim.api.analyses",
    "stationary": "wrsim.api.analyses",
    "diff": "wrsim.api.analyses",
    "export": "wrsim.api.data",
    "write_report": "wrsim.api.pages",
    "write_view": "wrsim.api.pages",
    "write_pictures": "wrsim.api.pages",
    "draw_track": "wrsim.api.pages",
    "look": "wrsim.api.pages",
    "write_unit": "wrsim.api.data",
    "new_file": "wrsim.api.data",
    "keys": "wrsim.api.data",
    "warm": "wrsim.analysis.warming",
    "read_recording": "wrsim.api.data",
    "run_study": "wrsim.api.studies",
    "run_type_test": "wrsim.api.studies",
    "run_wear": "wrsim.api.studies",
    "Outcome": "wrsim.api.outcome",
    "Result": "wrsim.results",
    "free_modes": "wrsim.vehicle.finite_elements",
    "load_profile": "wrsim.geometry.profile.models",
    "Profile": "wrsim.geometry.profile.profile",
    "Pose": "wrsim.contact.pose",
    "contact_model": "wrsim.contact.models",
    "solve_poses": "wrsim.analysis.poses.static",
    "contact_map": "wrsim.analysis.poses.static",
    "ContactModel": "wrsim.contact.model",
    "ContactSettings": "wrsim.contact.settings",
    "Friction": "wrsim.contact.settings",
    "Harmonic": "wrsim.geometry.profile.out_of_round",
    "Flat": "wrsim.geometry.profile.out_of_round",
    "RadiusTable": "wrsim.geometry.profile.out_of_round",
    "Track": "wrsim.geometry.track.track",
    "Straight": "wrsim.geometry.track.segments",
    "Arc": "wrsim.geometry.track.segments",
    "Transition": "wrsim.geometry.track.segments",
    "load_vehicle": "wrsim.vehicle.vehicle_files",
    "Vehicle": "wrsim.vehicle.vehicle",
    "WrsimError": "wrsim.errors",
    "InputError": "wrsim.errors",
    "SimulationError": "wrsim.errors",
}
"""Public names and their modules, imported on first use: ``import wrsim`` alone costs nothing."""

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> _Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'wrsim' has no attribute '{name}'")
    value = getattr(_import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
