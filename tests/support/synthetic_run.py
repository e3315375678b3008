"""Runs with invented forces of known mean, spread and frequency, to test assessments against closed forms."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.results import Result, assemble

Array = NDArray[np.float64]
Q0 = 50e3


def run(
    length: float = 600.0,
    speed: float = 20.0,
    step: float = 2e-3,
    *,
    y: Callable[[Array], tuple[Any, Any]] = lambda s: (0.0 * s, 0.0 * s),
    q: Callable[[Array], tuple[Any, Any]] = lambda s: (Q0 + 0.0 * s, Q0 + 0.0 * s),
    curvature: Callable[[Array], Array] = np.zeros_like,
    attributes: Mapping[str, Any] | None = None,
    **channels: Callable[[Array], Any],
) -> Result:
    """A run whose channels are functions of distance [m]; y, q: of both wheels [N]."""
    time = np.arange(int(length / speed / step) + 1) * step
    s = speed * time
    values = {"distance": s, "speed": np.full(s.size, speed), "curvature": curvature(s), "cant": np.zeros(s.size)}
    values |= {"Y": np.column_stack(y(s)), "Q": np.column_stack(q(s))} | {n: of(s) for n, of in channels.items()}
    known = {"title": "synthetic", "analysis": "curving", "status": "completed", "scenario_text": ""}
    return Result(assemble({"time": time}, values, known | dict(attributes or {})))


def curve(radius: float, lead: float = 200.0, ramp: float = 50.0, length: float = 300.0) -> Callable[[Array], Array]:
    """Curvature of straight track, a clothoid, a full curve, a clothoid, straight track."""
    places = np.cumsum([0.0, lead, ramp, length, ramp])
    return lambda s: np.interp(s, places, np.array([0.0, 0.0, 1.0, 1.0, 0.0]) / radius)


def with_wheelsets(results: list[Result], apart: float = 0.0) -> Result:
    """One run of several wheelsets, each ``apart`` [m] behind the one before, from runs of one each."""
    names = ["Y", "Q", "curvature", "cant", "wheelset_distance"]
    parts = [r.dataset[names].assign_coords(wheelset=[str(i + 1)]) for i, r in enumerate(results)]
    for i, part in enumerate(parts):
        part["wheelset_distance"] = part["wheelset_distance"] - i * apart
    return Result(xr.concat(parts, dim="wheelset", data_vars="minimal").assign_attrs(results[0].dataset.attrs))


def with_points(result: Result, points: Mapping[str, tuple[str, float, Array, Array]]) -> Result:
    """The run with accelerations: by point its level, mass of the bogie [kg], lateral and vertical ones [m/s2]."""
    ay, az = (np.column_stack([p[k] for p in points.values()]) for k in (2, 3))
    added = {
        "point_ay": (("time", "point"), ay),
        "point_az": (("time", "point"), az),
        "point_level": ("point", [p[0] for p in points.values()]),
        "point_bogie_mass": ("point", [p[1] for p in points.values()]),
    }
    return Result(result.dataset.assign(added).assign_coords(point=list(points)))


def sines(seconds: float = 60.0, **attributes: str) -> Result:
    """A run at 20 m/s with sines of known amplitude at two points: 2 Hz lateral, 5 Hz vertical."""
    base = run(20.0 * seconds, speed=20.0, step=0.005, attributes=attributes)
    t = base.dataset["time"].values
    lateral, vertical = np.sin(2.0 * np.pi * 2.0 * t), np.sin(2.0 * np.pi * 5.0 * t)
    level = ("car body", np.nan)
    result = with_points(base, {"front": (*level, 0.3 * lateral, 0.2 * vertical), "rear": (*level, lateral, vertical)})
    zero = xr.zeros_like(result.dataset["point_ay"])
    return Result(result.dataset.assign(point_ax=zero))
