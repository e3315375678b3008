"""The page of suspension elements: its tables are those of the code and of the vehicle files."""

import numpy as np
import pytest
from support.scripts import script

from wrsim.vehicle.element_tables import KINDS
from wrsim.vehicle.equivalent import Stroke

elements = script("docs/figures/make_elements.py")


def test_every_kind_of_element_has_its_example_and_the_tables_are_those_of_the_code() -> None:
    """Make it anew with: python docs/figures/make_elements.py"""
    assert set(elements.examples()) == set(KINDS)
    assert elements.page() == elements.PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", ["rubber-spring", "leaf-spring", "friction"])
def test_the_linear_stiffness_of_an_example_is_the_first_harmonic_of_its_loop(kind: str) -> None:
    """k + i w c of the force on ``to`` in the travel A sin(w t), over a period of the kernel's loop in 2000 steps."""
    element, stroke = elements.element_of(elements.examples()[kind]), Stroke(5e-3, 1.0)
    travel, force = elements.loop(element, stroke, steps=2000)
    phase = 2.0 * np.pi * np.arange(2000) / 2000
    harmonic = 2.0 * np.mean(-force[:-1] * (np.sin(phase) + 1j * np.cos(phase))) / travel.max()
    assert harmonic == pytest.approx(elements.linear(element, stroke), rel=0.02)
