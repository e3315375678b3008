"""The service file: which cases a vehicle runs, with which shares of its mileage, and how its wheels are worn."""

from __future__ import annotations

from typing import Annotated, ClassVar

from wrsim.contact.wear.laws import LawName
from wrsim.inputs.section import Section
from wrsim.inputs.values import number, positive, text
from wrsim.vehicle.vehicle_sections import WheelName


class ServiceFile(Section, header="a service"):
    """A service: the scenario its cases start from, their table, the mileage, and the steps of wear."""

    aliases: ClassVar[dict[str, str]] = {
        "base": "scenario",
        "cases": "csv table",
        "wheel": "profile wheel_profile",
        "mileage_km": "distance_km",
        "largest_depth_mm": "depth_mm step_depth_mm",
        "largest_step_km": "step_km",
        "smoothing_mm": "cutoff_mm",
    }

    title: Annotated[str, text("a title")] | None = None
    """Title of the service; that of its scenario unless given."""
    base: Annotated[str, text('a scenario file such as "curve.toml"')]
    """Scenario that all cases start from."""
    cases: Annotated[str, text('a CSV file such as "cases.csv"')]
    """Table of the cases: keys of the scenario in its header, a column share of the mileage, a column id of names."""
    wheel: WheelName
    """Profile of all wheels before the first kilometre."""
    law: LawName = "usfd"
    """Law of wear."""
    mileage_km: Annotated[float, positive(1e7)]
    """How far the vehicle runs."""
    largest_depth_mm: Annotated[float, number(0.001, 1)] = 0.1
    """Largest depth of one step; then the profile is made anew."""
    largest_step_km: Annotated[float, positive(1e7)] = 1500.0
    """Largest mileage of one step."""
    smoothing_mm: Annotated[float, number(0.5, 50)] = 5.0
    """Wavelength along the profile at which smoothing halves what was worn off."""
    conicity_amplitude_mm: Annotated[float, number(0.5, 10)] = 3.0
    """Amplitude of the equivalent conicity that is reported against the mileage."""
    flange_back_mm: Annotated[float, number(20, 150)] = 70.0
    """Distance of the flange back from the tape circle, for the flange's thickness Sd."""
    time_limit_s: Annotated[float, number(1, 1e7, "s of one case")] = 3600.0
    """How long one case may take before it is given up."""
