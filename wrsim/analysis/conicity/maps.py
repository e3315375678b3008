"""Equivalent conicity over the gauge, of any number of wheel profiles on any number of rail profiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.conicity.conicity import conicity
from wrsim.errors import InputError
from wrsim.geometry.profile.files import PROFILE_FILES
from wrsim.geometry.profile.models import load_profile
from wrsim.results.conicity import ConicityMap, conicity_summary
from wrsim.scenario.sections.conicity import ConicityPlan, Roll
from wrsim.vehicle.wheelset import Wheel, Wheelset

if TYPE_CHECKING:
    from wrsim.geometry.profile.profile import Kind, Profile

AMPLITUDES = (2e-3, 3e-3, 4e-3)
"""At which the map and its nonlinearity parameter are taken [m]."""


def conicity_map(
    wheels: Mapping[str, Profile],
    rails: Mapping[str, Profile],
    gauges: Sequence[float],
    spacing: float,
    radius: float,
    roll: Roll = "none",
    title: str = "",
) -> ConicityMap:
    """The map of all pairs, both wheels and both rails alike.

    wheels, rails: profiles by the names they go by, rails inclined; gauges, spacing of the profiles' origins, rolling
    radius [m]. A pair that has no conicity at a gauge (wheels off the rails, no place to swing about) leaves a gap.
    """
    plan = ConicityPlan(AMPLITUDES, roll)
    pairs = tuple((wheel, rail) for wheel in wheels for rail in rails)
    values = np.full((2, len(pairs), len(gauges)), np.nan)
    reasons: dict[str, None] = {}
    for i, (wheel, rail) in enumerate(pairs):
        side = Wheel(wheels[wheel], radius)
        wheelset = Wheelset("wheelset", 0.0, (0.0, 0.0, 0.0), spacing, side, side)
        for j, gauge in enumerate(gauges):
            pair = f"{wheel} on {rail}, gauge {1e3 * gauge:.6g} mm"
            try:
                found = conicity_summary(conicity(wheelset, (rails[rail],) * 2, gauge, plan, pair).wheelset())
            except InputError as error:
                text = str(error)
                reasons[text if text.startswith(pair) else f"{pair}: {text}"] = None
                continue
            for k, value in enumerate((found["equivalent_conicity"]["3_mm"], found["nonlinearity_per_mm"])):
                values[k, i, j] = np.nan if value is None else value
    return ConicityMap(pairs, tuple(gauges), values[0], values[1], tuple(reasons), title)


def profiles_of(folder: Path, kind: Kind) -> dict[str, Profile]:
    """Profiles of a kind in a folder, by the names of their files without ending.

    Profile files (TOML) and files of points; of files that share a name without ending the TOML file, which describes
    the points. Raises InputError where there are none, and for a file that cannot be read.
    """
    endings = {ending: of for form in PROFILE_FILES.values() for ending, of in form.suffixes.items()}
    files = {f.stem: f for f in sorted(folder.iterdir()) if endings.get(f.suffix.lower(), kind) in (None, kind)}
    files = {stem: file for stem, file in files.items() if file.suffix.lower() in endings}
    files |= {f.stem: f for f in sorted(folder.glob("*.toml"))}
    found = {}
    for stem, file in sorted(files.items()):
        profile = load_profile(file, None if file.suffix == ".toml" else kind)
        if profile.kind == kind:
            found[stem] = profile
    if not found:
        raise InputError(f"{folder}: has no {kind} profiles (files that end in .toml or {' '.join(sorted(endings))})")
    return found
