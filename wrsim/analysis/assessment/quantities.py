"""What is assessed, how it is evaluated and where that comes from."""

from __future__ import annotations

from wrsim.results.assessment import INFORMATION, LOADING, RIDE, SAFETY, Quantity
from wrsim.results.channels import PLAIN, SHOWN

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

RIDE_BAND = (0.4, 10.0)
"""Band of the accelerations of a car body [Hz]."""

_EN = "EN 14363, UIC 518 [pub]"
_MEAN = "low-pass 20 Hz, mean over 2 m every 0.5 m"
_KN = SHOWN["kN"]

SUM_Y = Quantity(
    "sum_Y", "ΣY", "track-shifting force of a wheelset", SAFETY, _KN,
    f"left minus right Y, {_MEAN}, percentiles 0.15 and 99.85 %, the larger one", _EN,
)  # fmt: skip
Y_OVER_Q = Quantity(
    "Y_over_Q", "Y/Q", "derailment quotient", SAFETY, PLAIN,
    "Y and Q low-pass 20 Hz, their quotient's mean over 2 m every 0.5 m, percentile 99.85 %", _EN,
)  # fmt: skip
NADAL = Quantity(
    "Y_over_Q_nadal", "Y/Q Nadal", "derailment quotient against Nadal's limit", SAFETY, PLAIN,
    "as Y/Q; the limit follows from the angle of the flange and the friction of the run", "Nadal 1896 [pub]",
)  # fmt: skip
CLIMB = Quantity(
    "climb_distance", "s_N", "longest way with Y/Q beyond Nadal's limit", SAFETY, SHOWN["m"],
    "Y and Q low-pass 20 Hz, their quotient above the limit without interruption", "49 CFR 213.333 [mem]",
)  # fmt: skip
INSTABILITY = Quantity(
    "instability", "sΣY", "instability criterion", SAFETY, _KN,
    "ΣY band-pass f0 - 2 Hz to f0 + 2 Hz, rms over 100 m every 10 m, largest", _EN,
)  # fmt: skip
Q_MAX = Quantity("Q", "Q", "vertical force of a wheel", LOADING, _KN, "low-pass 20 Hz, percentile 99.85 %", _EN)
Y_QST = Quantity(
    "Y_qst", "Y_qst", "quasi-static guiding force of the outer wheel", LOADING, _KN,
    "full curves, low-pass 20 Hz, median", _EN, quasi_static=True,
)  # fmt: skip
Q_QST = Quantity(
    "Q_qst", "Q_qst", "quasi-static vertical force of the outer wheel", LOADING, _KN,
    "full curves, low-pass 20 Hz, median", _EN, quasi_static=True,
)  # fmt: skip
UNLOADING = Quantity(
    "unloading", "ΔQ/Q0", "unloading of a wheel", INFORMATION, PLAIN,
    "1 - Q/Q0, Q low-pass 20 Hz, percentile 0.15 %", "",
)  # fmt: skip
WEAR = Quantity(
    "T_gamma", "Tγ", "wear number, mean", INFORMATION, SHOWN["N"], "unfiltered, mean over the section", "",
    quasi_static=True,
)  # fmt: skip
WEAR_MAX = Quantity(
    "T_gamma_max", "Tγ max", "wear number, largest", INFORMATION, SHOWN["N"], "mean over 2 m every 0.5 m, 99.85 %", ""
)
ATTACK = Quantity(
    "angle_of_attack", "|ψ|", "angle of attack", INFORMATION, SHOWN["mrad"],
    "median of the section, magnitude", "", quasi_static=True,
)  # fmt: skip
SHIFT = Quantity(
    "lateral_shift", "|Δy|", "lateral shift of a wheelset, largest", INFORMATION, SHOWN["mm"],
    "unfiltered, percentiles 0.15 and 99.85 %, the larger magnitude", "",
)  # fmt: skip

STOP = Quantity(
    "bump_stop",
    "d_s",
    "travel of a bump stop, towards the nearer end of its table",
    INFORMATION,
    SHOWN["mm"],
    "unfiltered, largest",
    "",
)
_A = SHOWN["m/s2"]
_BAND = "band-pass 0.4 to 10 Hz"
_EXTREMES = "percentiles 0.15 and 99.85 %, the larger magnitude"
FRAME = Quantity(
    "frame_instability",
    "sÿ+",
    "instability criterion of a bogie frame",
    SAFETY,
    _A,
    "lateral acceleration band-pass f0 - 2 Hz to f0 + 2 Hz, rms over 100 m every 10 m, largest",
    "EN 14363, UIC 518 [mem]",
)
BODY_Y = Quantity("body_ay", "ÿ*", "lateral acceleration of a car body", RIDE, _A, f"{_BAND}, {_EXTREMES}", _EN)
BODY_Z = Quantity("body_az", "z̈*", "vertical acceleration of a car body", RIDE, _A, f"{_BAND}, {_EXTREMES}", _EN)
BODY_Y_RMS = Quantity("body_ay_rms", "sÿ*", "lateral acceleration of a car body, rms", RIDE, _A, f"{_BAND}, rms", _EN)
BODY_Z_RMS = Quantity("body_az_rms", "sz̈*", "vertical acceleration of a car body, rms", RIDE, _A, f"{_BAND}, rms", _EN)
BODY_QST = Quantity(
    "body_ay_qst",
    "ÿ*_qst",
    "quasi-static lateral acceleration of a car body",
    RIDE,
    _A,
    "full curves, low-pass 20 Hz, median, magnitude",
    _EN,
    quasi_static=True,
)
