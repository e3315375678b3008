"""Suspension elements: one class a kind, with its keys in the vehicle file, its law and how it is drawn.

A new kind is a subclass of `ElementTable` and an entry in ``AnyElementTable``. Its ``element`` gives one of
the laws that there are (`Spring`: along and about three axes; `Strut`: in one direction), or an `Element` of its own
with a function in ``core.body.suspension``.
"""

from typing import Annotated

from pydantic import Field

from wrsim.inputs.section import kinds_in
from wrsim.vehicle.elements.bilinear_spring import BilinearSpringTable
from wrsim.vehicle.elements.damper import DamperTable
from wrsim.vehicle.elements.element import GUIDE, TRACK, ZERO, Element, Normal, Slider, Table, Tables, Triple
from wrsim.vehicle.elements.friction import FrictionTable, PlaneFriction
from wrsim.vehicle.elements.keys import ElementTable, Glyph
from wrsim.vehicle.elements.leaf_spring import LeafSpringTable
from wrsim.vehicle.elements.rubber_spring import AirSpringTable, RubberSpringTable
from wrsim.vehicle.elements.spring import AntiRollBarTable, ShearSpringTable, Spring, SpringTable
from wrsim.vehicle.elements.strut import Strut
from wrsim.vehicle.elements.tabulated_spring import BumpStopTable, TabulatedSpringTable
from wrsim.vehicle.elements.traction_rod import TractionRodTable

AnyElementTable = Annotated[
    SpringTable
    | ShearSpringTable
    | TabulatedSpringTable
    | BumpStopTable
    | DamperTable
    | TractionRodTable
    | AntiRollBarTable
    | FrictionTable
    | LeafSpringTable
    | RubberSpringTable
    | AirSpringTable
    | BilinearSpringTable,
    Field(discriminator="kind"),
]
"""The kinds that a vehicle file may name, in the order of messages."""
KINDS: dict[str, type[ElementTable]] = kinds_in(AnyElementTable)

__all__ = [
    "GUIDE", "KINDS", "TRACK", "ZERO", "AnyElementTable", "Element", "ElementTable", "Glyph", "Normal", "PlaneFriction",
    "Slider", "Spring", "Strut", "Table", "Tables", "Triple",
]  # fmt: skip
