"""From the [track] of a scenario to the track that it describes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.irregularities import Disturbance
from wrsim.geometry.track.segments import Laws, Segment, Straight, laws
from wrsim.geometry.track.table import IRREGULARITIES, TrackTable
from wrsim.geometry.track.track import ROUNDING, Track
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.irregularities import TableSection

LEVEL_TRACK = 100.0
"""Length of the straight of static and equilibrium analyses without segments in the file [m]."""
TABLE_FADE = 20.0
"""Length over which the irregularities of a measured track begin and end [m]."""


def track_of(scenario: Scenario, rails: tuple[Profile, Profile], files: list[Path]) -> Track:
    """Lay the track of a scenario; adds the tables that were read to ``files``.

    Raises InputError at the key that does not fit.
    """
    section = scenario.spec.track
    gauge = section.gauge_mm / 1e3
    row: tuple[Segment, ...] = tuple(s.to_geometry() for s in section.segments)
    uneven: list[Disturbance] = []
    with scenario.faults_at(("track",)):
        if section.table is not None:
            files.append(scenario.find(("track", "table"), section.table))
            table = TrackTable.read(files[-1])
            law: Laws = table.laws(gauge)
            if any(name in table.columns for name in IRREGULARITIES):
                uneven += table.disturbances(0.0, TABLE_FADE)
        else:
            row = row or (Straight(LEVEL_TRACK),)
            law = laws(row, gauge, ROUNDING)
    for i, entry in enumerate(section.irregularities):
        key = ("track", "irregularities", i)
        if isinstance(entry, TableSection):
            files.append(scenario.find((*key, "file"), entry.file))
        with scenario.faults_at(key):
            uneven += entry.disturbances(law.curvature.end, files[-1])
    with scenario.faults_at(("track",)):
        offsets = [(0.0, 0.0)] * 2  # of the profiles' origins, from half the gauge and from the track's plane
        if section.gauge_between == "gauge points":
            offsets = [(-rail.gauge_point()[0], -rail.top[1]) for rail in rails]
        return Track.lay(
            law,
            gauge,
            segments=row,
            grades=[g.to_geometry() for g in section.grades],
            irregularities=uneven,
            left_offset=offsets[0],
            right_offset=offsets[1],
            cant_base=section.cant_base,
            step=section.row_distance_m,
            elasticity=None if section.elasticity is None else section.elasticity.to_geometry(),
        )


def gauge_extremes(track: Track) -> tuple[float, float]:
    """Least and largest gauge along a track [m], to what lies between samples half a metre apart."""
    ends = [place for feature in track.features() for place in (feature.start, feature.end)]
    places = np.concatenate([ends, np.arange(0.0, track.length, 0.5)])
    gauge = track.gauge(places)
    return float(gauge.min()), float(gauge.max())
