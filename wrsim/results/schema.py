"""What the readers of a file of results rely on. A file is held against it once, where it is loaded.

A right checksum says that a file is as it was written, not that wrsim wrote it.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS, WHEELS, Kind
from wrsim.results.dataset import COUNTS, NAMED, REQUIRED_ATTRIBUTES, STATUSES

_TYPES = {"number": ("f", "float64"), "count": ("i", "int64"), "text": ("UOT", "text")}

_TOGETHER = (
    "snapshot_time snapshot_distance snapshot_label",
    "event_time event_distance event_label",
    "strip_s strip_ds strip_x strip_a strip_p strip_angle strip_y strip_z strip_N strip_Fx strip_Fy",
    "element_x element_p element_qx element_qs",
    "wheel_origin wheel_axle wheel_velocity wheel_rotation",
    "rail_profile_y rail_profile_z wheel_profile_y wheel_profile_z",
    "point_ax point_ay point_az point_level",
    "body_lateral body_vertical body_yaw body_pitch body_roll",
    "suspension_fx suspension_fy suspension_fz suspension_dx suspension_dy suspension_dz",
    "suspension_stop_min suspension_stop_max",
    "external_fx external_fy external_fz",
    "N Fx Fy p0 area approach",
    "Y Q",
)
"""Channels that are written together, and read together: where one of them stands, the others do."""


def fault_of_result(dataset: xr.Dataset) -> str:
    """What is wrong with a dataset that says it is a result, in words; empty if nothing is."""
    return next(_faults(dataset), "")


def _faults(dataset: xr.Dataset) -> Iterator[str]:
    yield from faults_of_attributes(dataset.attrs, REQUIRED_ATTRIBUTES)
    for name, allowed in (("analysis", tuple(ANALYSES)), ("status", STATUSES)):
        if dataset.attrs[name] not in allowed:
            yield f"its {name} is {dataset.attrs[name]!r:.40}, none of {', '.join(allowed)}"
    sample = "time" if "time" in dataset.dims else "pose"
    labels = [name for name in ("time", "pose", "wheel", "patch", "snapshot", *NAMED) if name in dataset.dims]
    needed = [sample, *labels, "wheelset", *(("wheel", "distance") if sample == "time" else ())]
    yield from (f"has no {name}" for name in needed if name not in dataset.variables)
    for name in map(str, dataset.variables):
        channel = CHANNELS.get(name)
        if channel is None:
            yield f"has {name!r:.40}, which is no channel"
        else:
            yield from faults_of_variable(dataset, name, channel.dims_in(sample), channel.kind)
    yield from _faults_of_labels(dataset, sample, labels)
    for group in map(str.split, _TOGETHER):
        there = [name for name in group if name in dataset.variables]
        yield from (f"has {there[0]} and no {name}" for name in group if there and name not in there)


def _faults_of_labels(dataset: xr.Dataset, sample: str, labels: Sequence[str]) -> Iterator[str]:
    for name in labels:
        values = dataset[name].values
        if not values.size and name != "patch":
            yield f"its {name} is empty"
        if len(np.unique(values)) < values.size:
            yield f"its {name} has a value twice"
    wheels = tuple(map(str, dataset["wheel"].values)) if "wheel" in labels else WHEELS
    if wheels not in (WHEELS, *((wheel,) for wheel in WHEELS)):
        yield f"its wheel is {', '.join(wheels)!r:.40}, must be {', '.join(WHEELS)} or one of them"
    for name in ("time", "distance", "speed", "wheelset_distance", "snapshot_time", "snapshot_distance"):
        if name in dataset.variables and not np.isfinite(dataset[name].values).all():
            yield f"its {name} is not finite everywhere"
    if sample == "time" and (np.diff(dataset["time"].values) <= 0.0).any():
        yield "its time does not increase from sample to sample"


LISTS = ("curve_radii_m",)
"""Attributes that are numbers with blanks between."""


def faults_of_attributes(attributes: Mapping[str, Any], texts: Sequence[str]) -> Iterator[str]:
    """What is wrong with the attributes of a file of results, of which some have to be texts."""
    yield from (f"has no {name}" for name in texts if not isinstance(attributes.get(name), str))
    for name, value in attributes.items():
        whole, number = name in COUNTS, name.endswith(("_m", "_s", "_rad", "_Hz")) and name not in LISTS
        if not isinstance(value, int if whole else int | float if number else int | float | str):
            words = "a whole number" if whole else "a number" if number else "a number or a text"
            yield f"its {name!s:.40} is {value!r:.40}, must be {words}"


def faults_of_variable(dataset: xr.Dataset, name: str, dims: Sequence[Hashable], kind: Kind) -> Iterator[str]:
    """What is wrong with a variable, of which layout and type are known."""
    if name not in dataset.variables:
        yield f"has no {name}"
        return
    own = dataset.variables[name]
    letters, words = _TYPES[kind]
    if own.dims != tuple(dims):
        there, wanted = (", ".join(map(str, names)) for names in (own.dims, dims))
        yield f"its {name} is laid out along ({there}), must be along ({wanted})"
    if own.dtype.kind not in letters or (kind != "text" and own.dtype.itemsize != 8):
        yield f"its {name} holds {own.dtype}, must be {words}"
    if not isinstance(own.attrs.get("units", ""), str):
        yield f"its {name} has units that are no text"
