"""Sections of a rail that changes along the track, from one table of points."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.geometry.profile.points import Points, check_count, check_points, interpolated
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.smoothing import smoothed
from wrsim.geometry.track.rail_surface import RailSection
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.toml_files import shown
from wrsim.inputs.values import number

COLUMNS: dict[str, Any] = {
    "at_m": Annotated[float, number(-1e6, 1e6, "m along the track, from where the table is laid")],
    "outward_mm": Annotated[float, number(-1000, 1000, "mm away from the track centre")],
    "up_mm": Annotated[float, number(-1000, 1000, "mm")],
    "feature": str,
}
NEEDED = ("at_m", "outward_mm", "up_mm")


def read_sections(path: Path, measured: bool = False) -> list[RailSection]:
    """Sections in the order of the table, distances as it says them.

    Rows of one ``at_m`` stand together and are the points of one section, from one of its ends to the other. Under
    ``feature`` stand the numbers of the features that lie on a point, 1, 2, ... from the gauge side on, apart from each
    other by blanks; every section has each of them once. measured: points are smoothed, not interpolated.

    Raises InputError with file, line and what is allowed.
    """
    table, lines = read_columns(path, COLUMNS, NEEDED, "points")
    at = table["at_m"]
    starts = np.flatnonzero(np.append(True, np.diff(at) != 0.0))
    marks = table.get("feature", np.full(at.size, ""))
    found: list[RailSection] = []
    for own in np.split(np.arange(at.size), starts[1:]):
        place = float(at[own[0]])
        if found and place <= found[-1].distance:
            raise InputError(
                f"{path}:{lines[own[0]]}: at_m = {place:g}: must be more than {found[-1].distance:g} of the section "
                "before; points of one section stand together"
            )
        points = Points(str(path), 1e-3 * table["outward_mm"][own], 1e-3 * table["up_mm"][own], lines[own])
        kept = points.without_duplicates().in_order()
        check_count(kept)
        check_points(kept)
        name = f"{path.stem}, {place:g} m"
        profile = (smoothed if measured else interpolated)(kept, name, "rail", path.name)
        found.append(RailSection(place, profile, _features(points, marks[own], profile)))
    return found


def _features(points: Points, marks: NDArray[Any], profile: Profile) -> tuple[float, ...]:
    """Arclengths of the numbered features of a section [m]."""
    places: dict[int, float] = {}
    for i in np.flatnonzero(np.char.strip(marks.astype(str)) != ""):
        where = f"{points.file}:{points.line[i]}: feature = {shown(str(marks[i]))}"
        for word in str(marks[i]).split():
            if not word.isdecimal() or int(word) < 1:
                raise InputError(f"{where}: must be numbers of features, 1, 2, ..., apart from each other by blanks")
            if int(word) in places:
                raise InputError(f"{where}: feature {int(word)} stands there twice in this section")
            # every point is a node, or next to one where points are smoothed
            node = np.argmin(np.hypot(profile.u - points.u[i], profile.w - points.w[i]))
            places[int(word)] = float(profile.arclength[node])
    missing = sorted(set(range(1, len(places) + 1)) - places.keys())
    if missing:
        raise InputError(
            f"{points.file}:{points.line[0]}: feature {missing[0]} is missing in the section that begins here; a part "
            "that does not exist in a section has its features on one point"
        )
    return tuple(places[k] for k in sorted(places))
