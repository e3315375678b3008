"""Colours, dashes and marks of all pictures.

Colours are from Okabe and Ito's set: they differ with any common colour vision deficiency and in grey. The left wheel
is blue and the right one vermilion in every picture.
"""

from __future__ import annotations

from typing import Literal

WHEEL_COLOUR = {"left": "#0072B2", "right": "#D55E00"}
INK = "#222222"
QUIET = "#6b6b6b"
FAINT = "#d9d9d9"
CANT_COLOUR = "#9467A9"
STOP_COLOUR = "#B00020"
RAIL_FILL = "#e4e7eb"
WHEEL_FILL = "#f4efe4"
Dashes = tuple[float, tuple[float, ...]]

DOTS: Dashes = (0, (1, 2))
GROUP_LINE: tuple[Dashes | Literal["-"], ...] = (
    "-", (0, (4, 1.2)), (0, (1, 1)), (0, (5, 1, 1, 1)), (0, (2, 2)), (0, (7, 1, 1, 1, 1, 1)),
)  # fmt: skip
"""Line style of the first, second, ... patch, wheelset, yaw or load."""
GROUP_MARK = ("o", "s", "^", "D", "v", "x")
SERIES_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", CANT_COLOUR, QUIET)
"""Colours of the first, second, ... mode or wheelset."""
