"""The tables of a run or of poses: peaks of wheels and wheelsets, medians in full curves, energy, what happened."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from wrsim.inputs.file_kinds import resolved
from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS, PATCHES, WHEELS
from wrsim.results.dataset import ASSUMPTIONS
from wrsim.results.moments import has_patches, with_patches
from wrsim.results.summary import CURVE_CHANNELS, ENERGY, OF_SPAN, OF_WHEELSET, PATCH_CHANNELS, PEAKS, Peak, wheel_peaks
from wrsim.results.table import (
    SIGNIFICANT_CHANGE,
    Cell,
    Column,
    Table,
    ValueAt,
    formatted,
    join_names,
    percent,
    quantity,
    with_unit,
)
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets

MOST_LINES = 10  # events and remarks that are listed
MOST_NAMES = 8  # wheelsets and moments that the overview lists
ROUND_OFF = {"kN": 1e-3, "mm": 1e-4, "mrad": 1e-4}
"""What is printed as 0: 1 N, how far that moves against 10 kN/mm, a stiff primary suspension, and turns over 1 m."""
MOST_PATCHES = 24  # patches of poses that are listed; patches.csv has all of them
OF_POSES = {
    "N": "N", "p0": "p₀", "n_strips": "strips", "width": "width", "contact_angle_min": "γ min",
    "contact_angle_max": "γ max",
}  # fmt: skip
"""Channels of the patches of poses that are listed, and their headings."""
MOST_CURVES = 3  # full curves that are listed; summary.json has all of them

Summary = Mapping[str, Any]


def run_tables(dataset: xr.Dataset, summary: Summary) -> list[Table]:
    """Peaks of each wheel and wheelset, medians in full curves, energy balance, events, what integration took."""
    title = str(dataset.attrs["title"])
    sets = list(summary["wheelsets"].values())
    labels = list(numbered(tuple(summary["wheelsets"])).values())
    if len(sets) == 1:
        tables = wheelset_tables(sets, [""], title=title)
        if "pose" in dataset.dims:
            tables = [patches_table(dataset, title), *(replace(table, title="") for table in tables)]
    else:
        tables = [vehicle_table(title, labels, [each["wheels"] for each in sets])]
        cells = {key: [_placed(each.get(key), peak.unit) for each in sets] for key, peak in OF_WHEELSET.items()}
        known = {key: peak for key, peak in OF_WHEELSET.items() if any(cell.value for cell in cells[key])}
        known = {key: named(OF_WHEELSET, known)[key] for key in known}
        rows = [(label, *(cells[key][i] for key in known)) for i, label in enumerate(labels)]
        heads = (Column("wheelset"), *(Column(peak.short or peak.title, peak.unit) for peak in known.values()))
        tables += [Table("largest magnitudes", heads, rows)] if known else []
    tables += curve_tables(labels, sets)
    if spans := summary.get("spans"):
        known = {key: peak for key, peak in OF_SPAN.items() if key in next(iter(spans.values()))}
        heads = (Column(), *(Column(peak.label, peak.unit) for peak in known.values()))
        rows = [(name, *(_placed(each[key]) for key in known)) for name, each in spans.items()]
        tables.append(Table("bridge, largest in the middle of its spans", heads, rows))
    if energy := summary.get("energy"):
        parts = [(heading, energy[key]) for key, heading in ENERGY.items() if energy[key] or key == "left_over_kJ"]
        tables.append(Table("Energy balance", (Column(), Column("work", "kJ")), parts))
    notes = (*first_lines(happened(summary), "events"), *integration(summary))
    return [*tables, Table("", notes=notes)] if notes else tables


def patches_table(dataset: xr.Dataset, title: str) -> Table:
    """Patches of the poses of one wheelset: force, pressure, strips, width, range of contact angles."""
    data = of_wheelset(dataset, wheelsets(dataset)[0]).transpose("pose", "wheel", "patch", ...)
    places = np.argwhere(np.isfinite(data["N"].values))
    dims = [d for d, use in (("pose", True), ("wheel", data.sizes["wheel"] > 1), ("patch", places[:, 2].any())) if use]
    texts = [*(data[dim].values.tolist() for dim in ("pose", "wheel")), PATCHES]
    heads = {name: word for name, word in OF_POSES.items() if name in data}
    rows: list[list[Cell]] = []
    for place in places[:MOST_PATCHES].tolist():
        names = [texts[k][i] for k, i in enumerate(place) if ("pose", "wheel", "patch")[k] in dims]
        rows.append([*names, *(float(data[n].values[tuple(place)]) * CHANNELS[n].shown.factor for n in heads)])
    columns = (*map(Column, dims), *(Column.of(CHANNELS[name], word) for name, word in heads.items()))
    more = (f"and {len(places) - MOST_PATCHES} more patches: see patches.csv",) if len(places) > MOST_PATCHES else ()
    return Table(title, columns, rows, more)


def numbers_of(dataset: xr.Dataset, summary: Summary) -> list[Table]:
    """What people read first of a result of any analysis, and the remarks on its contacts."""
    tables: list[Table] = resolved(ANALYSES[str(dataset.attrs["analysis"])].numbers)(dataset, summary)
    about = [f"{word}: {summary[key]}" for key, word in ASSUMPTIONS.items() if key in summary]
    notes = (*about, *summary.get("profiles", ()), *first_lines(remarks(summary), "remarks"))
    return [*tables, Table("", notes=notes)] if notes else tables


def overview(dataset: xr.Dataset) -> list[Table]:
    """A result in a few lines: what was computed, and the peaks of every wheel."""
    attributes = dataset.attrs
    ending = f"stopped: {attributes['stop_reason']}" if attributes["status"] == "stopped" else "completed"
    names = wheelsets(dataset)
    about = [("analysis", f"{attributes['analysis']}, {ending}"), ("samples", extent_text(dataset))]
    about.append(("wheelsets", join_names(names, MOST_NAMES)))
    if has_patches(dataset) and "snapshot_distance" in dataset:
        places = [formatted(float(distance), ".1f") for distance in dataset["snapshot_distance"].values]
        about.append(("patches", f"{join_names(places, MOST_NAMES)} m"))
    elif has_patches(dataset):
        poses = [str(name) for name in dataset["pose"].values[with_patches(dataset)]]
        about.append(("patches", join_names(poses, MOST_NAMES)))
    tables = [Table("", (Column(), Column()), about)]
    if any(name in dataset for name in ("Y", "Q", "p0")):
        first = names[:MOST_NAMES]
        tables.append(vehicle_table("", first, [wheel_peaks(of_wheelset(dataset, name)) for name in first]))
    return tables


def extent_text(dataset: xr.Dataset) -> str:
    """How many samples or poses there are, and how far they go."""
    if "time" not in dataset.dims:
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        text = f"{dataset.sizes['pose']} pose{'s' * (dataset.sizes['pose'] != 1)}"
        return text + (f", {unsolved} of them without a solution" if unsolved else "")
    time = dataset["time"].values
    text = f"{time.size} sample{'s' * (time.size != 1)}"
    if time.size > 1 and "distance" in dataset.coords:
        first, last = dataset["distance"].values[[0, -1]].tolist()
        text += f" over {quantity(float(np.ptp(time)), 's')}"
        text += f", {formatted(first, '.1f')} to {quantity(last, 'm', '.1f')}"
    return text


def wheelset_tables(sets: Sequence[Summary | None], names: Sequence[str], title: str = "Peaks") -> list[Table]:
    """Peaks of one wheelset and its wheels with their places, a column for each result; names: of the results. Of two
    results of the same wheels their change too."""
    pairs, alike = list(zip(sets, names, strict=True)), {tuple(each["wheels"]) if each else () for each in sets}
    two = len(sets) == 2 and len(alike) == 1 and all(sets)
    wheels = [(each, name, wheel) for each, name in pairs for wheel in (each["wheels"] if each else WHEELS)]
    rows: list[Sequence[Cell]] = []
    known = {key for each in sets for part in ((each, *each["wheels"].values()) if each else ()) for key in part}
    for key, peak in named(PEAKS, known).items():
        cells = [_placed(each["wheels"][wheel].get(key) if each else None, peak.unit) for each, _, wheel in wheels]
        rows.append((with_unit(peak.label, peak.unit), *cells, *(_changes(cells) if two else ())))
    heads = [Column(f"{name}: {wheel}" if len(sets) > 1 else wheel) for _, name, wheel in wheels]
    if two:
        heads += [Column(f"change, {wheel}", "%", ".1f") for wheel in next(iter(alike))]
    tables = [Table(title, (Column(), *heads), _known(rows))]
    rows = []
    for key, peak in named(OF_WHEELSET, known).items():
        cells = [_placed((each or {}).get(key), peak.unit) for each in sets]
        change = _changes(cells) if two else ()
        rows.append((with_unit(peak.label, peak.unit), *cells, *change))
    if rows := _known(rows):
        last = [Column("change", "%", ".1f")] if two else []
        tables.append(Table("", (Column("wheelset"), *map(Column, names), *last), rows))
    return tables


def named(peaks: Mapping[str, Peak], known: Collection[str]) -> dict[str, Peak]:
    """Peaks, which are not called raw where nothing filtered is beside them."""
    if any(key in known for key, peak in peaks.items() if peak.filtered):
        return dict(peaks)
    plain = {key: (peak.title.removesuffix(", raw"), peak.short.removesuffix(" raw")) for key, peak in peaks.items()}
    return {key: replace(peak, title=plain[key][0], short=plain[key][1]) for key, peak in peaks.items()}


def _changes(cells: Sequence[ValueAt]) -> list[float | None]:
    """Change of the second half of some numbers over the first [%]."""
    half, zero = len(cells) // 2, SIGNIFICANT_CHANGE * max((abs(cell.value or 0.0) for cell in cells), default=0.0)
    return [percent(a.value, b.value, zero) for a, b in zip(cells[:half], cells[half:], strict=True)]


def vehicle_table(title: str, labels: Sequence[str], sets: Sequence[Summary]) -> Table:
    """Peaks of several wheelsets, a row a wheel. sets: peaks by wheel and name."""
    known = {key for wheels in sets for peaks in wheels.values() for key in peaks}
    short = {key: peak for key, peak in named(PEAKS, known).items() if peak.short and key in known}
    rows = [
        (label if j == 0 else "", wheel, *(_placed(peaks.get(key), short[key].unit).value for key in short))
        for label, wheels in zip(labels, sets, strict=True)
        for j, (wheel, peaks) in enumerate(wheels.items())
    ]
    heads = [Column("wheelset"), Column("wheel"), *(Column(peak.short, peak.unit) for peak in short.values())]
    return Table(title, tuple(heads), rows)


def curve_tables(labels: Sequence[str], sets: Sequence[Summary], most: int = MOST_CURVES) -> list[Table]:
    """Medians in the first full curves: a row a wheel, and one for each further patch of it."""
    curves = [each.get("full_curves", []) for each in sets]
    count = min(map(len, curves), default=0)
    several = len(labels) > 1
    tables = []
    for k in range(min(count, most)):
        rows: list[list[Cell]] = []
        wheels = [part for of in curves for part in of[k].values() if isinstance(part, Mapping)]
        known = {name for part in (*(of[k] for of in curves), *wheels) for name in part}
        channels = {name: heading for name, heading in CURVE_CHANNELS.items() if CHANNELS[name].column in known}
        for label, each, of in zip(labels, sets, curves, strict=True):
            for j, wheel in enumerate(each["wheels"]):
                values = (of[k] if j == 0 else {}) | of[k].get(wheel, {})
                head: list[Cell] = [*([label if j == 0 else ""] if several else []), wheel]
                head += [values.get(CHANNELS[name].column, "") for name in channels]
                for i, patch in enumerate(values.get("patches") or [{}]):
                    cells = (patch.get(CHANNELS[name].column, "") for name in PATCH_CHANNELS)
                    rows.append([*(head if i == 0 else [""] * len(head)), PATCHES[i] if patch else "", *cells])
        heads = [*([Column("wheelset")] if several else []), Column("wheel")]
        heads += [Column.of(CHANNELS[name], heading) for name, heading in channels.items()]
        heads += [Column("patch"), *(Column.of(CHANNELS[name], heading) for name, heading in PATCH_CHANNELS.items())]
        more = (f"and {count - most} more full curves: see summary.json",) if k == most - 1 and count > most else ()
        tables.append(Table(_curve_title(curves[0][k]), tuple(heads), rows, more))
    return tables


def _curve_title(curve: Summary) -> str:
    hand = "left" if curve["radius_m"] > 0.0 else "right"
    cant = f", cant {quantity(curve['cant_mm'], 'mm', '.0f')}" if "cant_mm" in curve else ""
    place = f"{formatted(curve['from_m'], '.0f')} to {quantity(curve['to_m'], 'm', '.0f')}"
    radius = quantity(abs(curve["radius_m"]), "m", ".0f")
    return f"full curve, R {radius} to the {hand}{cant}, {place}: medians of its second half"


def happened(summary: Summary) -> list[str]:
    """Events of a run with their places."""
    return [f"{quantity(e['distance_m'], 'm', '.1f')}: {e['event']}" for e in summary.get("events", [])]


def remarks(summary: Summary) -> list[str]:
    """Remarks on contacts of samples and on limit cycles."""
    return [f"{place}: {message}" for place, message in summary.get("remarks", {}).items()]


def first_lines(lines: Sequence[str], noun: str) -> tuple[str, ...]:
    """The first lines, and how many more there are."""
    more = (f"and {len(lines) - MOST_LINES} more {noun}: see summary.json",) if len(lines) > MOST_LINES else ()
    return (*lines[:MOST_LINES], *more)


def integration(summary: Summary) -> list[str]:
    """What the integration of a run took; nothing of other analyses."""
    if (took := summary.get("integration")) is None:
        return []
    text = f"{took['integrator']}: {took['steps']} steps of {quantity(took['step_ms'], 'ms')}"
    text += f", {took['evaluations']} evaluations of the forces"
    text += f", {took['jacobians']} Jacobians" if took["jacobians"] else ""
    if refined := took.get("refined_steps"):
        text += f"; {refined} of {took['steps']} steps refined"
    cut = f"; {took['cut_steps']} of {took['steps']} steps subdivided"
    return [text + (f"{cut}, {took['explicit_steps']} of them by rk44" if took["cut_steps"] else "")]


def _placed(peak: Summary | None, unit: str = "") -> ValueAt:
    if peak is None or peak["value"] is None:
        return ValueAt(None, "")
    value = peak["value"] if abs(peak["value"]) >= ROUND_OFF.get(unit, 0.0) else 0.0
    if "distance_m" in peak:
        return ValueAt(value, quantity(peak["distance_m"], "m", ".1f"))
    return ValueAt(value, peak["pose"] if "pose" in peak else quantity(peak["time_s"], "s", ".3f"))


def _known(rows: Sequence[Sequence[Cell]]) -> list[Sequence[Cell]]:
    return [row for row in rows if any(isinstance(cell, ValueAt) and cell.value for cell in row)]
