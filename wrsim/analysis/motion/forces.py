"""The force law of a set-up's vehicle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wrsim.analysis.contacts import contact_models
from wrsim.simulation.law import VehicleOnTrack

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.run import RunPlan
    from wrsim.vehicle.loads import Drive


def force_law(setup: Setup[RunPlan], speed: float | None = None, drive: Drive | None = None) -> VehicleOnTrack:
    """The law of the set-up's vehicle on its track; constant speed and drive, where given, in the place of its own."""
    run = setup.plan
    kind = VehicleOnTrack
    if setup.contact.normal == "half-space":
        from wrsim.simulation.half_space_law import HalfSpaceOnTrack  # brings parts of scipy that nothing else needs

        kind = HalfSpaceOnTrack
    return kind(
        setup.vehicle,
        setup.track,
        [contact_models(setup, wheelset=mounted.wheelset) for mounted in setup.vehicle.wheelsets],
        speed=run.speed if speed is None else speed,
        start=run.start,
        drive=setup.drive if drive is None else drive,
        threads=setup.threads,
        profile=run.profile if speed is None else None,
    )


def held_by(setup: Setup[RunPlan]) -> Drive:
    """What holds the speed of a steady motion: a pull along the track, unless the frames do."""
    return "free" if setup.drive == "free" and setup.vehicle.runs_with_frame else "train"
