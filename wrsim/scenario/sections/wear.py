"""[wear]: by which laws the wear of a run is computed, and over which stretch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Annotated, ClassVar

from pydantic import Field

from wrsim.contact.wear.laws import LawName, WearSettings
from wrsim.errors import InputError
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import Fault
from wrsim.inputs.values import List, number, positive
from wrsim.scenario.sections.ride import StretchTable

Coefficient = Annotated[float, positive(1.0)]
Coefficients = Annotated[
    tuple[Coefficient, Coefficient, Coefficient, Coefficient],
    Field(strict=False, description="four numbers above 0: slow, faster and fast sliding, seizure"),
]


class WearSection(StretchTable):
    """By which laws wear and rolling contact fatigue of a run are computed, and over which stretch."""

    header: ClassVar[str] = "[wear]"
    aliases: ClassVar[dict[str, str]] = {
        "laws": "law model", "from_m": "start_m", "to_m": "end_m", "hardness_GPa": "hardness H_GPa",
        "archard_coefficients": "wear_coefficients k", "shear_yield_MPa": "k_MPa yield_in_shear_MPa",
        "place_step_mm": "step_mm resolution_mm",
    }  # fmt: skip

    laws: List[LawName] = ()
    """Laws of wear, one or several; without any there is neither wear nor fatigue in the result."""
    hardness_GPa: Annotated[float, number(0.5, 20, "of the softer body")] = 2.8
    """Hardness of the softer body, in Archard's law."""
    archard_coefficients: Coefficients = (5e-4, 35e-4, 5e-4, 350e-4)
    """Coefficients k of Archard's law: sliding below 0.2 m/s, up to 0.7 m/s, above, and seizure."""
    shear_yield_MPa: Annotated[float, number(50, 2000, "of the rail's steel")] = 300.0
    """Yield stress of the rail in shear, of the surface fatigue index and the shakedown map."""
    place_step_mm: Annotated[float, number(0.05, 5)] = 0.25
    """Distance of the places on the profiles at which depths are told."""

    def consistency(self) -> Iterator[Fault]:
        """A stretch has a length, each law is named once."""
        yield from super().consistency()
        if len(set(self.laws)) < len(self.laws):
            yield Fault("laws", "must hold each law once")

    def settings(self, start: float, end: float, fault: Callable[[KeyPath, str], InputError]) -> WearSettings | None:
        """The same in SI units; None without a law. start, end: of the run [m]."""
        if not self.laws:
            return None
        for key, place in (("from_m", self.from_m), ("to_m", self.to_m)):
            if place is not None and not start <= place <= end:
                raise fault(("wear", key), f"must lie on the run, from {start:.6g} to {end:.6g} m")
        return WearSettings(
            laws=self.laws,
            stretch=(self.from_m, self.to_m),
            hardness=1e9 * self.hardness_GPa,
            coefficients=self.archard_coefficients,
            shear_yield=1e6 * self.shear_yield_MPa,
            step=1e-3 * self.place_step_mm,
        )
