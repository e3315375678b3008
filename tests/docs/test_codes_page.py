"""The page of what codes take differently: its tables are those of its data and of the code."""

import csv

import numpy as np
import pytest
from support.scripts import script

codes = script("docs/figures/make_codes.py")


def test_the_tables_are_those_of_the_data() -> None:
    """Make them anew with: python docs/figures/make_codes.py"""
    assert codes.page() == codes.PAGE.read_text(encoding="utf-8")


def test_the_cases_of_the_data_are_those_of_the_script() -> None:
    with codes.DATA.open(encoding="utf-8", newline="") as file:
        variants = {(row["topic"], row["variant"]) for row in csv.DictReader(file)}
    assert {(topic, label) for topic, cases in codes.CASES.items() for label in cases} <= variants


@pytest.mark.parametrize("end", [0.1, 10.0])
def test_creep_coefficients_join_the_table_without_a_jump_and_tend_to_the_asymptote(end: float) -> None:
    """Within 0.3 % over 0.1 % of a/b at the end; the asymptote alone jumps by 0.8 to 5.6 % there."""
    inside, outside = (codes.coefficients(end * (1.0 + s * 5e-4))["wrsim"] for s in (-1.0, 1.0))
    assert outside == pytest.approx(inside, rel=3e-3)
    jump = codes.coefficients(end)["asymptote"] / codes.coefficients(end)["wrsim"] - 1.0
    assert 5e-3 < np.abs(jump).max() < 6e-2
    far = codes.coefficients(end**3)
    assert np.abs(far["asymptote"] / far["wrsim"] - 1.0).max() < np.abs(jump).max()
