"""Summary and tables of a conicity analysis: equivalent conicity, nonlinearity, radial steering index, maps of gauges.

The index shows whether rolling alone, without a flange, leads a wheelset radially through a curve.

In a curve of radius R a wheelset with wheels 2e apart rolls without slip where its rolling radii differ by
Delta r_E = 2e r0 / R. The index q_E = Delta r_E / Delta r_max compares that with the largest difference that the outer
wheel reaches before its flange does (EN 14363:2016 [mem]; where the flange begins is our choice): up to 1 the wheelset
can be radial, beyond that it cannot.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.moments import Array
from wrsim.results.summary import summarise_contacts
from wrsim.results.table import Column, Table, finite, formatted, quantity
from wrsim.results.tables import Row, csv_of_contacts, wide
from wrsim.results.wheelsets import of_wheelset, wheelsets

CONTACT_DISTANCE = 1.5  # 2 e, between the contact points of both wheels by EN 15302 [m]


def summarise_conicity(dataset: xr.Dataset) -> dict[str, Any]:
    """That of the poses, and the equivalent conicity of the wheelset."""
    summary = summarise_contacts(dataset)
    for name, wheelset in summary["wheelsets"].items():
        wheelset |= conicity_summary(of_wheelset(dataset, name))
    return summary


def csv_of_conicity(dataset: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """Those of the poses, and one row per amplitude."""
    yield from csv_of_contacts(dataset)
    for name in wheelsets(dataset):
        yield "conicity", wide(of_wheelset(dataset, name), "amplitude")


def conicity_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """Equivalent conicity at 3 mm (at 5 and 1 mm as well) and where the wheelset swings about. nonlinearity_per_mm:
    (tan gamma_e at 4 mm - tan gamma_e at 2 mm) / 2 mm, Polach's parameter: negative where conicity falls with the
    amplitude. ``None`` where one of the amplitudes is missing."""
    amplitude = 1e3 * dataset["amplitude"].values
    values = dataset["equivalent_conicity"].values
    near = (np.flatnonzero(np.abs(amplitude - mm) < 1e-6) for mm in range(1, 6))
    tan_1, tan_2, tan_3, tan_4, tan_5 = (finite(values[indices[0]]) if indices.size else None for indices in near)
    return {
        "equivalent_conicity": {"1_mm": tan_1, "3_mm": tan_3, "5_mm": tan_5},
        "nonlinearity_per_mm": None if tan_2 is None or tan_4 is None else 0.5 * (tan_4 - tan_2),
        "equilibrium_shift_mm": 1e3 * float(dataset.attrs["equilibrium_shift_m"]),
        **steering_summary(dataset),
    }


def conicity_tables(dataset: xr.Dataset, summary: dict[str, Any]) -> list[Table]:
    """Every half millimetre: conicity and wavelength over amplitude, and what lies at that shift; radial steering."""
    dataset = of_wheelset(dataset)
    facts = conicity_summary(dataset)
    shift, amplitudes = 1e3 * dataset["lateral_shift"].values, 1e3 * dataset["amplitude"].values
    order, angles = np.argsort(shift), np.degrees(dataset["contact_angle"].values[..., 0]).T
    at_shift = (1e3 * dataset["rolling_radius_difference"].values, *angles)
    over_amplitude = (dataset[name].values for name in ("equivalent_conicity", "conicity_wavelength"))
    columns = (amplitudes, *over_amplitude, *(np.interp(amplitudes, shift[order], row[order]) for row in at_shift))
    half = np.abs(2.0 * amplitudes - np.round(2.0 * amplitudes)) < 1e-6
    rows = np.column_stack(columns)[half].tolist()
    heads = (
        Column("y", "mm", ".1f"), Column("tan γe", "", ".3f"), Column("wavelength", "m", ".2f"),
        Column("Δr", "mm", ".3f"), Column("angle left", "°", ".2f"), Column("angle right", "°", ".2f"),
    )  # fmt: skip
    place = quantity(facts["equilibrium_shift_mm"], "mm", ".3f")
    notes = [f"amplitudes are counted from the equilibrium at y = {place}; Δr and angles at y itself"]
    if facts["nonlinearity_per_mm"] is not None:
        notes.append(f"nonlinearity parameter {quantity(facts['nonlinearity_per_mm'], 'per mm', '.4f')}")
    tables = [Table(str(dataset.attrs["title"]), heads, rows, tuple(notes))]
    if "radial_steering" not in facts:
        return tables
    keys = {
        "curve_radius_m": Column("R", "m"), "needed_mm": Column("needed Δr", "mm"),
        "available_mm": Column("available", "mm"), "q_E": Column("q_E"), "shift_mm": Column("at y", "mm"),
    }  # fmt: skip
    rows = [tuple(curve[key] for key in keys) for curve in facts["radial_steering"]]
    smallest, angle = facts["smallest_radial_curve_m"], formatted(facts["flange_from_deg"], "g")
    steering = "nothing steers" if smallest is None else f"up to 1 from R {quantity(smallest, 'm', '.0f')}"
    note = f"q_E {steering}; available: before the outer wheel's contact angle is {angle}°"
    return [*tables, Table("radial steering index [mem]", tuple(keys.values()), rows, (note,))]


def conicity_numbers(dataset: xr.Dataset) -> dict[str, Any]:
    """Plain numbers of one pair: the summary, and the conicity over the amplitude."""
    values = dataset["equivalent_conicity"].values.tolist()
    amplitudes = [round(1e3 * a, 9) for a in dataset["amplitude"].values.tolist()]
    return conicity_summary(dataset) | {"amplitude_mm": amplitudes, "tan_gamma_e": list(map(finite, values))}


def _towards(dataset: xr.Dataset, sign: float, needed: float) -> tuple[float, float]:
    """Largest difference towards the left (+1) or right (-1) wheel as the outer one; shift where it is as needed."""
    place = sign * (dataset["lateral_shift"].values - float(dataset.attrs["equilibrium_shift_m"]))
    order = np.argsort(place)
    place = place[order]
    larger = sign * dataset["rolling_radius_difference"].values[order]
    angle = dataset["contact_angle"].sel(wheel="left" if sign > 0.0 else "right").values[order, 0]
    begin = int(np.searchsorted(place, 0.0))
    on_tread = np.isfinite(larger) & (angle < float(dataset.attrs["flange_from_rad"]))
    end = begin + int(np.argmin(np.append(on_tread[begin:], False)))
    if end == begin:
        return 0.0, np.nan
    most = np.maximum.accumulate(larger[begin:end])
    reached = np.interp(needed, most, place[begin:end]) if most[0] < needed <= most[-1] else np.nan
    return float(most[-1]), float(place[begin]) if needed <= most[0] else float(reached)


def steering_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """The radial steering index of a wheelset (channels of a conicity analysis) in the curves of the analysis, to
    either hand; nothing where none were.

    Needed and available difference of the rolling radii, shift at which the needed one is there; ``None`` where it is
    not, and for q_E where there is no difference at all. The less able side of the two counts.
    """
    if not (radii := [float(r) for r in str(dataset.attrs.get("curve_radii_m", "")).split()]):
        return {}
    mean = 0.5 * (float(dataset.attrs["radius_left_m"]) + float(dataset.attrs["radius_right_m"]))
    rows: list[dict[str, float | None]] = []
    smallest = None
    for radius in radii:
        needed = CONTACT_DISTANCE * mean / radius
        hands = [_towards(dataset, sign, needed) for sign in (1.0, -1.0)]
        available, shift = min(hands, key=lambda hand: hand[0])
        index = needed / available if available > 0.0 else None
        rows.append({"curve_radius_m": radius, "needed_mm": 1e3 * needed, "available_mm": 1e3 * available})
        rows[-1] |= {"q_E": index, "shift_mm": finite(shift, 1e3)}
        if smallest is None and index is not None:
            smallest = needed * radius / available
    angle = degrees(float(dataset.attrs["flange_from_rad"]))
    return {"flange_from_deg": angle, "smallest_radial_curve_m": smallest, "radial_steering": rows}


@dataclass(frozen=True)
class ConicityMap:
    """Over pairs of profiles, wheels before rails, and gauges [m]: equivalent conicity at 3 mm, Polach's nonlinearity
    parameter [1/mm], both (pairs, gauges), not-a-number where there is none, and reasons for that; notes: what was
    assumed of the profiles."""

    pairs: tuple[tuple[str, str], ...]
    gauges: tuple[float, ...]
    conicity: Array
    nonlinearity: Array
    reasons: tuple[str, ...]
    title: str = ""
    notes: tuple[str, ...] = ()

    def table(self) -> Table:
        """One row per pair and gauge; why a pair has no conicity is beneath."""
        rows = [
            (*pair, 1e3 * gauge, float(self.conicity[i, j]), float(self.nonlinearity[i, j]))
            for i, pair in enumerate(self.pairs)
            for j, gauge in enumerate(self.gauges)
        ]
        heads = (
            Column("wheel", key="wheel"),
            Column("rail", key="rail"),
            Column("gauge", "mm", ".6g", "gauge_mm"),
            Column("tan γe, 3 mm", "", ".3f", "equivalent_conicity_3_mm"),
            Column("nonlinearity", "1/mm", ".3f", "nonlinearity_per_mm"),
        )
        return Table(self.title, heads, rows, (*self.notes, *self.reasons))
