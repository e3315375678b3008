"""From the [track] of a scenario to its rails and the track that it describes, and whether wheels are on the rails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wrsim.contact.profiles.check_rail import ends_before_its_back, floor_of, with_check_rail
from wrsim.contact.profiles.flange import LEVEL
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Array, Profile
from wrsim.contact.surfaces.rail_surface import RailSection, RailSurface, read_sections
from wrsim.errors import InputError
from wrsim.inputs.checking import dotted, kind_of, opened
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import SIDES, on_side
from wrsim.inputs.toml_files import write_toml
from wrsim.inputs.values import plain_number
from wrsim.register import ANALYSES
from wrsim.scenario.loading import Scenario, load, load_text
from wrsim.scenario.merging import BASE, FILE
from wrsim.scenario.sections.irregularities import TableSection
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.structure import MovingMassStructure
from wrsim.scenario.sections.track import CheckRailSection, RollersSection
from wrsim.track.cant import RAIL_HEAD_WIDTH, STANDARD_GAUGE
from wrsim.track.civil import ENDINGS
from wrsim.track.crossing import read_crossing
from wrsim.track.irregularities import Disturbance
from wrsim.track.segments import Grade, Laws, Segment, Straight, laws
from wrsim.track.sleepers import SleeperTrack
from wrsim.track.table import IRREGULARITIES, TrackTable
from wrsim.track.track import MAX_OFFSET, ROUNDING, RailElasticity, Track
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.wheelset import Wheelset

if TYPE_CHECKING:
    from wrsim.track.civil.line import CivilLine

SAME_GAUGE = 0.01
"""Largest difference between the gauge of a civil file and that of the scenario [m]: 1432 and 1435 mm are both called
standard gauge, 1520 and 1524 mm broad gauge."""
LEVEL_TRACK = 100.0
"""Length of the straight of static and equilibrium analyses without segments in the file [m]."""
TABLE_FADE = 20.0
"""Length over which the irregularities of a measured track begin and end [m]."""
BEYOND = 100.0
"""How far beyond the end of a run the tables of its track go at least [m]: more than a step and the rails under a
wheel. They end at multiples of it: runs of a study that end near each other have the same."""


def track_model(path: Path, models: Sequence[str | Path] = (), alignment: str | None = None) -> Track:
    """The track of a scenario, of a track file or of a civil file, there of that alignment. Raises InputError."""
    if path.suffix.lower() in ENDINGS:
        line, gauge, base, law, row = _laid_line(path, alignment, None, None)
        return Track.from_laws(law, gauge, segments=row, cant_base=base, alignment=line)
    data, _ = opened(path, noun := "scenario or track file")
    kind, of_scenario = kind_of(path), {"analysis", "vehicle", BASE} & {*data}
    foreign = kind and not kind.startswith(("a scenario", "a track"))
    if foreign or not (of_scenario or "track" in data):
        fault = f"is {kind}" if foreign else f"has neither [track] nor analysis, vehicle or {BASE}"
        raise InputError(f"{path}: {fault}; a {noun} is needed here")
    if "track" in data and not of_scenario:
        runs = {"analysis": "curving", "vehicle": {"model": "any", "speed_kmh": 60}}
        scenario = load_text(write_toml(runs | {"track": {FILE: str(path.absolute())}}), path.parent, models)
    else:
        scenario = load(path, models)
    return track_of(scenario, rails_of(scenario))


def exported(track: Track, path: Path, date: str) -> tuple[str, list[str]]:
    """The text of an IFC or LandXML file of a track, and what it leaves out. Raises InputError."""
    from wrsim.track.civil.files import alignment_of, civil_text

    if not track.segments:
        raise InputError(
            f"{path}: a measured track has no elements to export; allowed: tracks of segments, civil files"
        )
    line, notes = track.alignment, list[str]()
    if line is None:
        line = alignment_of(path.stem, track.plan, track.profile, track.pivot)
        again = Track.from_laws(line.laws(track.cant_base)[0], track.nominal_gauge, cant_base=track.cant_base)
        s = np.linspace(0.0, min(track.length, again.length), max(2, math.ceil(track.length)))
        away = np.abs(again.centre_line.position(s) - track.centre_line.position(s)).max()
        notes.append(f"lengths and radii in plan; at most {1e3 * away:.2g} mm from the track")
    if track.widening(np.linspace(0.0, track.length, 999)).any():
        notes.append("gauge widening is left out")
    if track.is_uneven:
        notes.append("irregularities are left out")
    return civil_text(line, path, track.cant_base, track.nominal_gauge, date), notes


@lru_cache(maxsize=16)
def _laid(rail: Profile, inclination: float, gauge_depth: float, check_rail: CheckRailSection | None) -> Profile:
    """A rail as laid; cached, for its tables are made once."""
    laid = replace(rail.inclined(inclination), gauge_depth=gauge_depth)
    return laid if check_rail is None else check_rail.to_si(with_check_rail, rail=laid)


def rails_of(scenario: Scenario) -> tuple[Profile, Profile]:
    section = scenario.spec.track
    rails = []
    for side in SIDES:
        key, name = section.of_side("rail", side)
        profile = scenario.read(("track", key), name, partial(load_profile, kind="rail"))
        check_rail = section.check_rail or getattr(section, f"check_rail_{side}")
        with scenario.faults_at(("track", "check_rail" if section.check_rail else f"check_rail_{side}")):
            rail = _laid(profile, section.inclination, section.gauge_depth_mm / 1e3, check_rail)
        if section.gauge_between == "gauge points":
            try:
                u, w = rail.gauge_point()[0], rail.top[1]
            except InputError as error:
                hint = '; bare pairs of curves are placed by gauge_between = "origins" (static poses)'
                raise scenario.fault(("track", key), str(error) + hint) from None
            if (far := max(abs(u), abs(w))) > MAX_OFFSET:
                place = f"{far:.4g} m from the origin of {scenario.find(('track', key), name)}"
                message = f"its gauge point or its top lies {place}; at most {MAX_OFFSET:g} m"
                raise scenario.fault(("track", key), message)
        rails.append(rail)
    return rails[0], rails[1]


def track_of(scenario: Scenario, rails: tuple[Profile, Profile]) -> Track:
    """Lay the track of a scenario. Raises InputError at the key that does not fit."""
    section = scenario.spec.track
    gauge = section.gauge_mm / 1e3
    row: tuple[Segment, ...] = tuple(s.to_geometry() for s in section.segments)
    uneven: list[Disturbance] = []
    line, base = None, section.cant_base
    with scenario.faults_at(("track", "segments") if row else ("track",)):
        if section.table is not None:
            table = TrackTable.read(scenario.find(("track", "table"), section.table))
            law: Laws = table.laws(gauge)
            if any(name in table.columns for name in IRREGULARITIES):
                uneven += table.disturbances(0.0, TABLE_FADE)
        elif section.alignment is not None:
            told = section.cant_base if section.cant_base_mm is not None else None
            read = partial(_laid_line, name=section.alignment_name, gauge=gauge, base=told)
            line, _, base, law, row = scenario.read(("track", "alignment"), section.alignment, read)
        else:
            row = row or (Straight(LEVEL_TRACK),)
            law = laws(row, gauge, ROUNDING, section.cant_base)
    for i, entry in enumerate(section.irregularities):
        key = ("track", "irregularities", i)
        file = scenario.find((*key, "file"), entry.file) if isinstance(entry, TableSection) else Path()
        with scenario.faults_at(key):
            uneven += entry.disturbances(law.curvature.end, file)
    structure, rests_on = None, section.structure
    if rests_on is None and section.rollers is None and ANALYSES[scenario.analysis].moves:
        rests_on = MovingMassStructure(kind="moving mass")
    if rests_on is not None:
        with scenario.faults_at(("track", "structure")):
            above = ("bridge",) if rests_on.kind == "sleepers" else ()
            find = partial(scenario.find, ("track", "structure", *above, "modes"))
            structure = rests_on.to_geometry(find)
    with scenario.faults_at(("track",)):
        offsets = [(0.0, 0.0)] * 2  # of the profiles' origins, from half the gauge and from the track's plane
        if section.gauge_between == "gauge points":
            offsets = [(-rail.gauge_point()[0], -rail.top[1]) for rail in rails]
        return Track.from_laws(
            law,
            gauge,
            segments=row,
            grades=[Grade(g.from_m, g.grade_permille / 1e3, g.vertical_radius_m) for g in section.grades],
            irregularities=uneven,
            left_offset=offsets[0],
            right_offset=offsets[1],
            cant_base=base,
            step=section.row_distance_m,
            structure=structure,
            pivot=section.pivot,
            alignment=line,
        )


def _laid_line(
    file: Path, name: str | None, gauge: float | None, base: float | None
) -> tuple[CivilLine, float, float, Laws, tuple[Segment, ...]]:
    """An alignment, its gauge and the base of its cant [m], unless these are given, its laws and segments."""
    from wrsim.track.civil.files import read_alignment  # readers, for civil files alone

    line = read_alignment(file, name)
    if gauge is None:
        gauge = line.gauge or (STANDARD_GAUGE if line.cant_base is None else line.cant_base - RAIL_HEAD_WIDTH)
    elif line.gauge is not None and abs(line.gauge - gauge) > SAME_GAUGE:
        told = f"its gauge is {1e3 * line.gauge:g} mm, track.gauge_mm is {plain_number(1e3 * gauge)}"
        raise InputError(f"{file}: {told}; allowed: at most {1e3 * SAME_GAUGE:g} mm apart")
    base = base or line.cant_base or gauge + RAIL_HEAD_WIDTH
    return line, gauge, base, *line.laws(base)


def track_of_run(track: Track, vehicle: Vehicle, plan: RunPlan) -> tuple[Track, str]:
    """The track as a run along it needs it: tables as far as it comes, and no irregularities under the vehicle at its
    start, which is a steady motion on even track; words for these."""
    places = np.array([plan.start + mounted.x for mounted in vehicle.wheelsets])
    front, back = max(part.centre[0] for part in vehicle.parts), min(part.centre[0] for part in vehicle.parts)
    reach = BEYOND * math.ceil(1.0 + (plan.end + max(front, vehicle.foremost)) / BEYOND)
    track = _up_to(track, min(reach, track.length))
    unevens = [curve.irregularity for curve in (track.left_curve, track.right_curve)]
    slopes = [np.abs(jet[1]).max() for uneven in unevens for jet in (uneven.lateral(places), uneven.vertical(places))]
    if plan.end <= plan.start or max(slopes) == 0.0:
        return track, ""
    length = max(TABLE_FADE, front - back)
    message = f"fade in over {length:g} m from {places.max():.6g} m on: the run starts within them, from steady motion"
    return track.faded(float(places.max()), length), message


@lru_cache(maxsize=8)
def _up_to(track: Track, reach: float) -> Track:
    """The track as far as a distance [m]; runs of a study that go as far share its tables."""
    return replace(track, reach=reach)


def support_text(track: Track, default: bool, rollers: RollersSection | None) -> str:
    """What the rails of a run rest on; default: nobody has said it."""
    if rollers is not None:
        below = "" if track.structure is None else f"; {support_text(track, False, None)}"
        return f"rollers of radius {plain_number(rollers.radius_mm)} mm, every wheelset over their tops{below}"
    if not isinstance(track.structure, RailElasticity):
        beam, on_bridge = isinstance(track.structure, SleeperTrack), track.bridge is not None
        return ("beams on sleepers" if beam else "rigid") + (" on a bridge" if on_bridge else "")
    support = track.structure
    mass, stiffness, damping = (
        "/".join(plain_number(factor * value) for value in values)
        for factor, values in ((1.0, support.mass), (1e-6, support.stiffness), (1e-3, support.damping))
    )
    figures = f"moving mass of {mass} kg on {stiffness} MN/m and {damping} kN s/m (lateral/vertical) under each wheel"
    of_default = f' (default, {MovingMassStructure.source}); kind = "rigid" for rigid rails'
    return f"elastic, {figures}" + (of_default if default else "")


def surfaces_of(scenario: Scenario, track: Track) -> tuple[RailSurface | None, RailSurface | None]:
    """Rails that change along the track; distances of their sections are along the rail itself."""
    surfaces: list[RailSurface | None] = []
    read = [_rail_sections(scenario, i) for i in range(len(scenario.spec.track.rail_sections))]
    for side, curve in zip(SIDES, (track.left_curve, track.right_curve), strict=True):
        sections = []
        for i, each in on_side(scenario.spec.track.rail_sections, side):
            for section in read[i]:
                place = each.at_m + section.distance
                if not 0.0 <= place <= track.length:
                    offender = (
                        f"its section at {section.distance:g} m lies at {place:g} m: it " if each.rail is None else ""
                    )
                    message = f"{offender}must be on the track, which is {track.length:g} m long"
                    raise scenario.fault(("track", "rail_sections", i, "at_m"), message)
                sections.append(replace(section, distance=float(curve.arclength(place))))
        with scenario.faults_at(("track", "rail_sections")):
            surfaces.append(RailSurface(f"{side} rail", tuple(sections)) if sections else None)
    return surfaces[0], surfaces[1]


def _rail_sections(scenario: Scenario, i: int) -> list[RailSection]:
    """The sections of an entry of [[track.rail_sections]], as laid; distances are from its at_m."""
    entry, spec = scenario.spec.track.rail_sections[i], scenario.spec.track
    kind = next(name for name in ("rail", "table", "crossing") if getattr(entry, name) is not None)
    key = ("track", "rail_sections", i, kind)
    features, shift = tuple(f / 1e3 for f in entry.features_mm), (entry.outward_mm / 1e3, -entry.down_mm / 1e3)

    def read(file: Path) -> list[RailSection]:
        if entry.crossing is not None:
            return read_crossing(file, spec.inclination, bool(entry.trailing))
        if entry.table is not None:
            sections = read_sections(file, bool(entry.measured))
        else:
            sections = [RailSection(0.0, load_profile(file, "rail"), features)]
        laid = [_laid(s.profile, spec.inclination, spec.gauge_depth_mm / 1e3, entry.check_rail) for s in sections]
        if entry.check_rail is not None:
            return [RailSection(0.0, rail, (floor_of(rail), rail.head)) for rail in laid]
        return [replace(s, profile=rail) for s, rail in zip(sections, laid, strict=True)]

    sections = scenario.read(key, getattr(entry, kind), read)
    return [replace(s, profile=s.profile.shifted(*shift)) for s in sections]


def check_placement(scenario: Scenario, wheelset: Wheelset, rails: tuple[Profile, Profile], track: Track) -> None:
    """Refuse a wheelset that, centred, does not rest with both treads on the rails."""
    spec, nominal = scenario.spec.track, track.nominal_gauge
    # what lies between samples half a metre apart is left out
    ends = [place for feature in track.features() for place in (feature.start, feature.end)]
    gauges = track.gauge(np.concatenate([ends, np.arange(0.0, track.length, 0.5)]))
    for gauge in sorted({nominal, float(gauges.min()), float(gauges.max())}, key=lambda g: abs(g - nominal)):
        for side, wheel, rail in zip(SIDES, (wheelset.left, wheelset.right), rails, strict=True):
            reason = misplaced(wheel.profile, rail, wheelset.profile_spacing, gauge)
            if not reason:
                continue
            message = (
                f"the wheelset is placed off the rails: at a gauge of {1e3 * gauge:g} mm, its wheel profiles "
                f"{1e3 * wheelset.profile_spacing:g} mm apart (vehicle.model), the {side} {reason}"
            )
            if gauge == nominal:
                key, name = scenario.spec.vehicle.of_side("wheel", side)
                keys: list[KeyPath] = [("track", "gauge_mm"), ("vehicle", "model" if name is None else key)]
                named = " and ".join(f"{dotted(key_path)} in {scenario.locate(key_path)}" for key_path in keys)
                raise scenario.fault(("track", spec.of_side("rail", side)[0]), f"{message}; see {named}")
            designed = track.widening(np.array([f.start for f in track.features()] + [track.length]))
            beyond = not designed.min() - 1e-9 <= gauge - nominal <= designed.max() + 1e-9
            widened_by = "segments" if track.segments else "table"
            raise scenario.fault(("track", "irregularities" if spec.irregularities and beyond else widened_by), message)


def check_flange_backs(
    scenario: Scenario, wheelset: Wheelset, rails: tuple[Profile, Profile], surfaces: Sequence[RailSurface | None]
) -> None:
    """Refuse a wheel whose profile ends where the back of its flange may touch a guard face."""
    for side, wheel, rail, surface in zip(SIDES, (wheelset.left, wheelset.right), rails, surfaces, strict=True):
        half = 0.5 * (scenario.spec.track.gauge_mm / 1e3 - wheelset.profile_spacing) - rail.gauge_point()[0]
        for each in [rail] if surface is None else [rail, *(section.profile for section in surface.sections)]:
            if fault := ends_before_its_back(wheel.profile, each, half):
                key, name = scenario.spec.vehicle.of_side("wheel", side)
                remedy = "record the wheel to its back, or let an arc lead there: flange_back_mm = 70 in a profile file"
                more = f'{remedy} with kind = "points" (docs/user/profiles.md)'
                raise scenario.fault(("vehicle", "model" if name is None else key), f"{fault}: {more}")


SAMPLES = 0.1e-3
"""Distance of the samples along both profiles of a wheel on its rail [m]."""
FLANGE_SLOPE = 0.6
"""A wheel profile steeper than this (31 degrees), inside of the tape circle, belongs to the flange."""


def misplaced(wheel: Profile, rail: Profile, spacing: float, gauge: float) -> str:
    """What is wrong with the wheel of a centred wheelset that is lowered vertically on its rail; empty if nothing is.

    wheel, rail: profiles, the rail inclined; spacing: distance H of the wheel profile origins [m]; gauge [m],
    at the gauge point of the inclined rail.
    """
    offset = 0.5 * (gauge - spacing) - rail.gauge_point()[0]  # rail origin on the wheel profile
    tread = wheel.table(SAMPLES)[0]
    head = rail.table(SAMPLES)[0]
    low = _envelope(tread[:, 0], -tread[:, 1])
    high = _envelope(head[:, 0] + offset, head[:, 1])
    left, right = max(low[0][0], high[0][0]), min(low[0][-1], high[0][-1])
    if right - left < SAMPLES:
        return "wheel misses its rail"
    u = np.arange(left, right, SAMPLES)
    u_wheel = float(u[np.argmin(-np.interp(u, *low) - np.interp(u, *high))])  # where it rests
    if u_wheel < flange_root(tread):
        return "wheel rests with its flange on the rail"
    if (clearance := flange_clearance(tread, spacing, gauge)) < 0.0:
        return f"flange overlaps the gauge face by {-1e3 * clearance:.3g} mm"
    rail_top, reach = rail.top[0] + offset, float(tread[:, 0].max())
    if rail_top > reach or u_wheel > reach - 2e-3:
        return f"wheel ends {1e3 * (rail_top - reach):.3g} mm inside of the top of its rail"
    return ""


def flange_clearance(tread: Array, spacing: float, gauge: float) -> float:
    """From the flange, 10 mm below the tape circle, to the gauge point of the rail [m]; infinite without flange."""
    return 0.5 * (gauge - spacing) - flange_face(tread) if np.isfinite(flange_root(tread)) else np.inf


def flange_root(tread: Array) -> float:
    """Return u where the flange begins [m]: inside of the tape circle and steep; -inf without flange."""
    inside = (tread[:, 0] < 0.0) & (tread[:, 3] > FLANGE_SLOPE * np.abs(tread[:, 2]))
    return float(tread[inside, 0].max()) if inside.any() else -np.inf


def flange_face(tread: Array) -> float:
    """Return the outermost u of the flange 10 mm below the tape circle [m], or its root."""
    deep = (tread[:, 0] < 0.0) & (tread[:, 1] <= -LEVEL)
    return float(tread[deep, 0].max()) if deep.any() else flange_root(tread)


def _envelope(u: Array, height: Array) -> tuple[Array, Array]:
    """Greatest height over each u of a curve that may pass a u more than once, on samples SAMPLES apart."""
    index = np.round((u - u.min()) / SAMPLES).astype(int)
    top = np.full(index.max() + 1, -np.inf)
    np.maximum.at(top, index, height)
    filled = np.isfinite(top)
    return u.min() + SAMPLES * np.flatnonzero(filled), top[filled]
