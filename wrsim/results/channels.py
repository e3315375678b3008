"""The register of channels (``data/channels.csv``): names, dimensions, units and meanings of what a Result may carry.

``docs/make_keys.py`` makes ``docs/reference/channels.md`` from it. Values are in SI units; the register also gives
the unit for readers (mm, kN, degrees, MPa). Two dimensions depend on the analysis:

- ``sample``: ``time`` in runs, ``pose`` in static analyses;
- ``moment``: ``snapshot`` in runs (chosen instants), ``pose`` in static analyses (every pose).

Chosen channels of a run are stored more often as well, as ``fast_Q`` over ``fast_time``.

What belongs to a wheelset or its wheels has the dimension ``wheelset``, of size 1 for a single wheelset;
``wrsim.results.wheelsets`` takes one wheelset out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from importlib.resources import files
from math import pi
from typing import Any, Literal

from wrsim.inputs.terms import Names

Kind = Literal["number", "count", "text"]


@dataclass(frozen=True)
class Shown:
    """A unit for readers: ``value_in_si * factor`` is shown; ``symbol``: on axes, ``suffix``: of columns, JSON keys."""

    symbol: str
    suffix: str
    factor: float

    @property
    def unit(self) -> str:
        """The symbol behind a number; none of a plain one."""
        return "" if self.symbol == "1" else self.symbol


PLAIN = Shown("1", "", 1.0)
SHOWN = {
    "s": Shown("s", "s", 1.0), "1/s": Shown("1/s", "per_s", 1.0), "Hz": Shown("Hz", "Hz", 1.0),
    "nm": Shown("nm", "nm", 1e9), "um": Shown("µm", "um", 1e6), "mm": Shown("mm", "mm", 1e3), "m": Shown("m", "m", 1.0),
    "mm2": Shown("mm²", "mm2", 1e6), "1/m": Shown("1/m", "per_m", 1.0), "1/km": Shown("1/km", "per_km", 1e3),
    "m/s": Shown("m/s", "m_s", 1.0), "km/h": Shown("km/h", "kmh", 3.6), "m/s2": Shown("m/s²", "m_s2", 1.0),
    "g": Shown("g", "g", 1.0 / 9.80665),
    "rad/s": Shown("rad/s", "rad_s", 1.0), "mrad": Shown("mrad", "mrad", 1e3), "deg": Shown("°", "deg", 180.0 / pi),
    "N": Shown("N", "N", 1.0), "kN": Shown("kN", "kN", 1e-3), "N m": Shown("N m", "Nm", 1.0),
    "kN m": Shown("kN m", "kNm", 1e-3),
    "N/mm": Shown("N/mm", "N_per_mm", 1e-3), "MPa": Shown("MPa", "MPa", 1e-6), "t": Shown("t", "t", 1e-3),
    "degC": Shown("°C", "C", 1.0),
    "kW": Shown("kW", "kW", 1e-3), "kJ": Shown("kJ", "kJ", 1e-3), "permille": Shown("‰", "permille", 1e3),
    "um/km": Shown("µm/km", "um_per_km", 1e9), "g/km": Shown("g/km", "g_per_km", 1e6), "1": PLAIN,
}  # fmt: skip


@dataclass(frozen=True)
class Channel:
    """One channel: name, dimensions (see the module), SI unit, meaning, unit for readers, symbol for axes.

    ``kind`` is ``"number"`` (float64, not-a-number where nothing is defined), ``"count"`` (int64, zero where
    nothing is) or ``"text"``. ``coordinate`` is true for values that label a dimension. Channels of one name in
    ``together`` are written together, and read together: where one of them is, the others are. ``note`` completes the
    meaning, ``terms`` are other words for it; both are for the reference.
    """

    name: str
    dims: tuple[str, ...]
    unit: str
    long_name: str
    shown: Shown
    symbol: str
    kind: Kind
    coordinate: bool
    together: str = ""
    note: str = ""
    terms: str = ""

    @property
    def column(self) -> str:
        """Name with the unit for readers at the end, for column headers and JSON keys: ``p0_MPa``."""
        return f"{self.name}_{self.shown.suffix}" if self.shown.suffix else self.name

    @property
    def label(self) -> str:
        """Text for an axis: long name, symbol and unit for readers."""
        text = self.long_name[0].upper() + self.long_name[1:]
        if self.symbol:
            text += f" ${self.symbol}$"
        return text if self.shown is PLAIN else f"{text} [{self.shown.symbol}]"

    @property
    def short_label(self) -> str:
        """Text for a narrow axis: symbol and unit; the label where there is no symbol."""
        return self.label[self.label.index("$") :] if self.symbol else self.label

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the variable of a dataset."""
        return {"units": self.unit, "long_name": self.long_name}

    def fast(self) -> Channel:
        """The channel over ``fast_time``."""
        return replace(self, name=f"fast_{self.name}", dims=("fast_time", *self.dims[1:]), together="")

    def dims_in(self, sample: str) -> tuple[str, ...]:
        """Dimensions in a dataset whose sample dimension is ``"time"`` or ``"pose"``."""
        moment = "snapshot" if sample == "time" else "pose"
        return tuple({"sample": sample, "moment": moment}.get(d, d) for d in self.dims)


def table(room: str, path: str) -> Iterator[dict[str, Any]]:
    """Rows of a table (CSV) in a package, by the names in its first line; lines that begin with # are notes."""
    lines = files(room).joinpath(path).read_text(encoding="utf-8").splitlines()
    return csv.DictReader(line for line in lines if not line.startswith("#"))


def _channel(row: dict[str, Any]) -> Channel:
    shape = {"dims": tuple(row["dims"].split()), "shown": SHOWN[row["shown"]], "kind": row["kind"] or "number"}
    texts = {name: row[name] or "" for name in ("together", "note", "terms")}
    return Channel(**row | shape | texts | {"coordinate": row["coordinate"] == "yes"})


WHEELSET, BOGIE_FRAME, CAR_BODY = "wheelset", "bogie frame", "car body"
"""Values of the channel ``point_level``."""

CHANNELS: dict[str, Channel] = {row["name"]: _channel(row) for row in table("wrsim.results", "data/channels.csv")}
"""Every channel by its name, in the order in which tables print them; fast ones (``fast_name``) last."""

NAMES = Names(
    {name: (c.long_name, c.symbol, *re.split("[,;]", c.terms)) for name, c in CHANNELS.items() if c.kind != "text"},
    lambda name: (CHANNELS[name].dims[0] == "pose", bool({"strip", "column"} & {*CHANNELS[name].dims})),
)
"""Channels with other terms for them. One of a channel of runs and of a channel of poses or strips means the first."""

_FAST = (
    "X", "Y", "Q", "sum_Y", "rail_displacement_?", "axle_box_acceleration", "lateral_shift", "vertical_shift", "yaw",
    "roll", "spin_rate", "body_*", "point_a?", "suspension_[fd]?", "coupling_*", "deck_[ad]*",
)  # fmt: skip
FAST = tuple(name for name in CHANNELS if any(fnmatchcase(name, pattern) for pattern in _FAST))
"""Channels of a run that may be stored more often than the others."""
CHANNELS |= {f"fast_{name}": CHANNELS[name].fast() for name in ("time", "distance", *FAST)}

PATCHES = ("main", "second", "third", "fourth", "fifth", "sixth")
"""Names of the patches of a wheel, the largest normal force first."""

WHEELS = ("left", "right")
"""Values of the ``wheel`` coordinate; a static analysis of one wheel carries one of them."""
