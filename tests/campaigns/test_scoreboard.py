"""The scoreboard's own arithmetic, and the page that is made from it."""

import sys

import numpy as np
import pytest
from support.contacts import bench, contact_of, pair_model, settle
from support.scripts import script


@pytest.fixture(scope="module")
def scoreboard():
    return script("campaigns/scoreboard.py")


def row(case, method, pmax, **changes):
    return {
        "case_id": case, "method": method, "ierr": "0", "fz_ok": "1", "n_components": "1", "pmax_MPa": str(pmax),
        "area_mm2": "50", "pen_mm": "0.04", "Fn_N": "24000", "cant_label": "1:40", "y_ws_mm": "0",
    } | changes  # fmt: skip


def test_the_truth_is_one_region_that_met_its_load(scoreboard):
    rows = [
        row("a", "contact_planar", 990.0), row("a", "contact_conf_hs", 1000.0), row("a", "kpec", 950.0),
        row("b", "contact_planar", 500.0), row("b", "contact_conf_hs", 510.0, n_components="2"),
        row("c", "contact_conf_hs", 700.0, ierr="-29"), row("d", "contact_conf_hs", 700.0, fz_ok="0"),
        row("e", "contact_conf_hs", 700.0), row("e", "contact_conf_hs", 100.0),
    ]  # fmt: skip
    cases = scoreboard.by_case(rows)
    truth = scoreboard.truths(cases)
    # the curved solution before the planar one, the planar one where the other has two regions, none of the rest
    assert {case: r["pmax_MPa"] for case, r in truth.items()} == {"a": "1000.0", "b": "500.0"}
    said = scoreboard.peer(cases, "kpec")
    assert scoreboard.ratios(truth, said, "p0_MPa") == pytest.approx([-0.05])


@pytest.mark.parametrize("lateral", [0.0, 3e-3, 6e-3])
def test_regions_hold_all_strips_once(scoreboard, lateral):
    stand = bench(pair_model("S1002/60E1 1:40"))
    settle(stand, lateral, 0.0, 60e3)
    contact = contact_of(stand)
    regions = sys.modules["reference_contact"].strip_regions(np.concatenate(contact.strips), 0.0)
    assert sum(r.normal_force for r in regions) == pytest.approx(contact.normal_force, rel=1e-9)
    assert [r.normal_force for r in regions] == sorted((r.normal_force for r in regions), reverse=True)
    assert 1 <= len(regions) <= len(contact.patches)


def test_the_validation_report_is_that_of_its_data():
    """Make it anew with: python docs/figures/make_standing.py"""
    for path, text in script("docs/figures/make_standing.py").pages().items():
        assert path.read_text(encoding="utf-8") == text, path
