"""What is assessed, how it is evaluated and where that comes from: ``data/quantities.csv``, and its numbers here."""

from __future__ import annotations

from wrsim.results.assessment import Quantity
from wrsim.results.channels import SHOWN, table

CUT_OFF = 20.0
"""Low-pass of the wheel's forces [Hz]."""
WINDOW, STEP = 2.0, 0.5
"""Sliding mean of Sum Y and Y/Q [m]."""
LOW, HIGH = 0.15, 99.85
"""Percentiles of largest values."""
STABILITY_WINDOW, STABILITY_STEP = 100.0, 10.0
"""Sliding rms of the instability criterion [m]."""
STABILITY_HALF_BAND = 2.0
"""f0 - 2 Hz to f0 + 2 Hz."""

LEAN, LEAN_FORCE = 0.4, 50e3
"""Mean Y/Q of the inner wheel from which Yqst may be reduced, and the force by which for one of it [N]."""
Q_SHARE = 0.83
"""Part of Qqst in Bqst."""

RIDE_BAND = (0.4, 10.0)
"""Band of the accelerations of a car body [Hz]."""

QUANTITIES: dict[str, Quantity] = {
    row["key"]: Quantity(**row | {"shown": SHOWN[row["shown"]], "quasi_static": row["quasi_static"] == "yes"})
    for row in table("wrsim.analysis.assessment", "data/quantities.csv")
}
"""By their keys, in the order of the tables."""
