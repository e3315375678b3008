"""Suspension elements: ``kinds`` has the keys of each kind in vehicle files and how it is drawn, ``element`` its law.

A new kind is a subclass of `ElementTable` and an entry in ``AnyElementTable``. Its ``element`` gives one of the laws
that there are (`Spring`: along and about three axes; `Strut`: in one direction), or an `Element` of its own with a
function in ``core.body.suspension``.
"""

from wrsim.vehicle.elements.element import (
    GUIDE,
    TRACK,
    ZERO,
    BilinearSpring,
    Element,
    Normal,
    PlaneFriction,
    Slider,
    Spring,
    Strut,
    Table,
    Tables,
    Triple,
)
from wrsim.vehicle.elements.keys import ElementTable, Glyph
from wrsim.vehicle.elements.kinds import KINDS, AnyElementTable

__all__ = [
    "GUIDE", "KINDS", "TRACK", "ZERO", "AnyElementTable", "BilinearSpring", "Element", "ElementTable", "Glyph",
    "Normal", "PlaneFriction", "Slider", "Spring", "Strut", "Table", "Tables", "Triple",
]  # fmt: skip
