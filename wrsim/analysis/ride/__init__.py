"""Ride: accelerations at points of a vehicle, their spectra, third-octaves and comfort.

``evaluate_ride(result) -> Ride`` is a pure function of a result.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from wrsim.analysis.assessment.filters import on_raster, sampling_rate
from wrsim.analysis.ride.comfort import AXES as WEIGHTINGS
from wrsim.analysis.ride.comfort import comfort
from wrsim.analysis.ride.spectra import spectrum, third_octaves
from wrsim.errors import InputError
from wrsim.inputs.checking import check_section
from wrsim.results import Result
from wrsim.results.dataset import table_of_scenario
from wrsim.results.ride import AXES, Ride
from wrsim.scenario.sections.run import RideSection


def evaluate_ride(result: Result, section: RideSection | None = None) -> Ride:
    """Spectra, third-octaves and comfort at all points of a vehicle.

    section: stretch and resolution, by default [ride] of the scenario that the result carries. Raises InputError for
    a result without points, with too few or unevenly spaced samples, or none on the stretch.
    """
    dataset, section = result.dataset, section or ride_section_of(result)
    if "point_ay" not in dataset:
        raise InputError("the result has no points: accelerations are kept at the [[points]] of a vehicle file")
    dataset = on_raster(dataset)
    distance = dataset["distance"].values
    first = distance[0] if section.from_m is None else section.from_m
    last = distance[-1] if section.to_m is None else section.to_m
    inside = (distance >= first - 1e-6) & (distance <= last + 1e-6)
    if not inside.any():
        there = f"it goes from {distance[0]:.6g} to {distance[-1]:.6g} m"
        raise InputError(f"[ride] from_m = {first:g}, to_m = {last:g}: the run has no samples there; {there}")
    part = dataset.isel(time=np.flatnonzero(inside))
    rate = sampling_rate(part["time"].values)
    acceleration = np.stack([part[f"point_a{a}"].transpose("time", "point").values for a in AXES], axis=-1)
    found = spectrum(acceleration, rate, section.resolution_Hz)
    bands = third_octaves(found)
    each = [comfort(acceleration[:, i], rate) for i in range(acceleration.shape[1])]
    dims = ("point", "axis")
    data = xr.Dataset(
        {
            "density": (("frequency", *dims), found.density),
            "band_rms": (("band", *dims), bands.rms.reshape(-1, *acceleration.shape[1:])),
            "band_low": ("band", bands.low),
            "band_high": ("band", bands.high),
            "rms": (dims, acceleration.std(axis=0)),
            "peak": (dims, np.abs(acceleration).max(axis=0)),
            "weighted_rms": (dims, np.stack([c.weighted_rms for c in each])),
            "comfort_95": (dims, np.stack([c.percentiles for c in each])),
            "N_MV": ("point", [c.mean for c in each]),
        },
        coords={
            "frequency": found.frequency,
            "band": np.array(bands.nominal),
            "point": [str(p) for p in part["point"].values],
            "axis": list(AXES),
        },
        attrs={"blocks": len(each[0].continuous), "weightings": " ".join(WEIGHTINGS[a] for a in AXES)},
    )
    times, places = part["time"].values, part["distance"].values
    return Ride(result.title, float(places[0]), float(places[-1]), float(times[-1] - times[0]), found.segments, data)


def ride_section_of(result: Result) -> RideSection:
    """[ride] of the scenario that the result carries; the defaults where it has none."""
    return check_section(RideSection, table_of_scenario(result.dataset, "ride") or {}, lambda path: "[ride]")
