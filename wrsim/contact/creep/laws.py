"""The laws of creep forces as one family. A new law is a kernel with a branch in `contact.creep.creep_forces`, and its
name, number and entry here.
"""

from dataclasses import dataclass
from typing import Literal

Tangential = Literal["fastsim", "fastrip", "polach", "linear", "shen-hedrick-elkins", "half-space", "none"]
NO_CREEP_FORCES, FASTSIM, FASTRIP, POLACH, LINEAR, SHEN_HEDRICK_ELKINS = range(6)
"""MODEL.tangential."""


@dataclass(frozen=True)
class CreepLaw:
    """What sets one law of creep forces apart.

    kernel: its number; text: its name in documents, "" where there is nothing to say; cells, bound, flexibility, slope:
    whether it takes cells along the strips, a shape of the bound on tractions, a kind of flexibility, a reduction of
    the initial slope; saturates: whether friction bounds its forces; layer, yields: whether it takes an elastic layer
    between the bodies, one that yields; heats: whether friction by temperature.
    """

    kernel: int
    text: str
    cells: bool = False
    bound: bool = False
    flexibility: bool = False
    slope: bool = False
    saturates: bool = True
    layer: bool = False
    yields: bool = False
    heats: bool = False


CREEP_LAWS: dict[Tangential, CreepLaw] = {
    "fastsim": CreepLaw(
        FASTSIM, "FASTSIM", cells=True, bound=True, flexibility=True, slope=True, layer=True, yields=True, heats=True
    ),
    "fastrip": CreepLaw(FASTRIP, "FaStrip", cells=True, slope=True, layer=True, heats=True),
    "polach": CreepLaw(POLACH, "Polach's formulas"),
    "linear": CreepLaw(LINEAR, "Kalker's linear theory", saturates=False),
    "shen-hedrick-elkins": CreepLaw(SHEN_HEDRICK_ELKINS, "the formulas of Shen, Hedrick and Elkins"),
    # not of a kernel: contact.half_space
    "half-space": CreepLaw(NO_CREEP_FORCES, "the exact solver", layer=True, yields=True, heats=True),
    "none": CreepLaw(NO_CREEP_FORCES, ""),
}

KERNEL_LAWS = tuple(name for name, law in CREEP_LAWS.items() if law.kernel != NO_CREEP_FORCES)
"""Laws of `contact.creep.creep_forces`."""
