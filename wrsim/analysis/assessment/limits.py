"""Limits of EN 14363 and UIC 518 and of others, as functions of what they depend on. SI units.

Marks: [pub] from a published source at hand, [mem] from memory of the standard, to be confirmed against its text
before a result goes into an acceptance report.
"""

from __future__ import annotations

from wrsim.results.assessment import DERAILMENT_LIMIT, DERAILMENT_RADIUS, Limit, Quantity
from wrsim.results.channels import SHOWN, table
from wrsim.scenario.sections.assessment import Kind

EN = "EN 14363"


def track_shift(axle_load: float, kind: Kind) -> Limit:
    """Sum Y over 2 m: k1 (10 kN + 2Q0/3), k1 = 1, 0.85 for freight wagons; axle_load 2Q0 [N]."""
    k1 = 0.85 if kind == "freight" else 1.0
    return Limit(k1 * (10e3 + axle_load / 3.0), f"{EN}: k1 (10 kN + 2Q0/3), k1 = {k1:g} (Prud'homme)", "mem")


def instability(axle_load: float, kind: Kind) -> Limit:
    """Sliding rms of Sum Y over 100 m: half the limit of Sum Y."""
    return Limit(0.5 * track_shift(axle_load, kind).value, f"{EN}: half the limit of Sum Y", "mem")


def derailment(radius: float) -> Limit | None:
    """Y/Q over 2 m: 0.8; not set below 250 m radius. radius [m] of either sign."""
    if abs(radius) < DERAILMENT_RADIUS * (1.0 - 1e-6):
        return None
    return Limit(DERAILMENT_LIMIT, f"{EN}, R >= {DERAILMENT_RADIUS:g} m", "mem")


def vertical_force(wheel_load: float, speed: float) -> Limit:
    """Q: 90 kN + Q0, at most a value that falls with speed; wheel_load Q0 [N], speed [m/s]."""
    kmh = 3.6 * speed - 1e-6
    steps = ((160.0, 200e3), (200.0, 190e3), (250.0, 180e3), (300.0, 170e3))
    most = next((force for limit, force in steps if kmh <= limit), 160e3)
    return Limit(min(90e3 + wheel_load, most), f"{EN}: 90 kN + Q0, at most {most / 1e3:g} kN at this speed", "mem")


def quasi_static_guiding(radius: float) -> Limit | None:
    """Yqst: 60 kN; 30 kN + 10500 kN m/Rm in very small radius curves (250 to 400 m); not set below 250 m.

    radius: Rm, the mean radius of the sections of a class of curves [m].
    """
    if radius < 250.0 * (1.0 - 1e-6):
        return None
    if radius < 400.0:
        return Limit(30e3 + 10500e3 / radius, f"{EN}: 30 kN + 10500 kN m/Rm, Rm = {radius:.0f} m", "mem")
    return Limit(60e3, EN, "mem")


QUASI_STATIC_VERTICAL = Limit(145e3, EN, "mem")  # of Qqst
COMBINED = Limit(180e3, f"{EN}:2016", "mem")  # of Bqst, where Yqst has a limit

CLIMB_DISTANCE = Limit(1.524, "49 CFR 213.333: Nadal's limit exceeded for no more than 5 ft", "mem")


def frame_instability(bogie_mass: float) -> Limit:
    """Sliding rms of a frame's lateral acceleration: half of 12 m/s2 less 1 m/s2 per 5 t of bogie with wheelsets."""
    return Limit(0.5 * (12.0 - bogie_mass / 5e3), f"{EN}: (12 - m/5)/2, bogie of {bogie_mass / 1e3:.3g} t", "mem")


_BODY: dict[Kind, dict[str, float]] = {
    "passenger": {"ay": 2.5, "az": 2.5, "ay_rms": 0.5, "az_rms": 0.75, "ay_qst": 1.5},
    "locomotive": {"ay": 2.5, "az": 2.5, "ay_rms": 0.5, "az_rms": 1.0, "ay_qst": 1.5},
    "freight": {"ay": 3.0, "az": 5.0, "ay_rms": 1.3, "az_rms": 2.0, "ay_qst": 1.3},
}
"""Accelerations of the car body [m/s2]: largest in the ride band, rms, quasi-static; lateral (y) and vertical (z)."""


def body(kind: Kind, what: str) -> Limit:
    """Ride characteristics of a car body; what: one of ``_BODY``."""
    return Limit(_BODY[kind][what], f"{EN}: ride characteristics, {kind}", "mem")


CUT_OFF = 20.0  # low-pass of the wheel's forces [Hz]
WINDOW, STEP = 2.0, 0.5  # sliding mean of Sum Y and Y/Q [m]
LOW, HIGH = 0.15, 99.85  # percentiles of largest values
STABILITY_WINDOW, STABILITY_STEP = 100.0, 10.0  # sliding rms of the instability criterion [m]
STABILITY_HALF_BAND = 2.0  # f0 - 2 Hz to f0 + 2 Hz

LEAN, LEAN_FORCE = 0.4, 50e3
"""Mean Y/Q of the inner wheel from which Yqst may be reduced, and the force by which for one of it [N]."""
Q_SHARE = 0.83  # part of Qqst in Bqst
RIDE_BAND = (0.4, 10.0)  # band of the accelerations of a car body [Hz]

QUANTITIES: dict[str, Quantity] = {
    row["key"]: Quantity(**row | {"shown": SHOWN[row["shown"]], "quasi_static": row["quasi_static"] == "yes"})
    for row in table("wrsim.analysis.assessment", "data/quantities.csv")
}
"""By their keys, in the order of the tables."""
