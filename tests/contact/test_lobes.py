"""Lobes that share a patch: coupling between 0 and 1, the deepest kept, amplitudes from all displacements together."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import contacts

from wrsim.contact.kik_piotrowski import own_influence, solve_amplitudes
from wrsim.contact.model import EPSILON
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.profiles.sections import ProfileArc, cone, profile_from_sections
from wrsim.contact.profiles.wear import Removal, worn
from wrsim.contact.records import LOBE, MAIN_POINT
from wrsim.contact.search.lobes import couple, select_deepest
from wrsim.contact.tables import combined_modulus

depths = st.floats(1e-6, 1e-3)
shares = st.floats(0.0, 1.0)


def found_rows(depth, saddle):
    """Rows of the search from depths and the saddles between them (below zero: separated)."""
    rows = np.zeros(8, MAIN_POINT)
    rows["depth"][: len(depth)] = depth
    rows["saddle"] = -1.0
    rows["saddle"][: len(saddle)] = saddle
    rows["saddle_arc"][: len(saddle)] = np.arange(len(saddle))
    return rows


def coupled(depth, saddle):
    """Couplings and partners."""
    lobes = np.zeros(len(depth), LOBE)
    couple(found_rows(depth, saddle), len(depth), EPSILON, lobes)
    return lobes["coupling"], lobes["partner"]


@given(first=depths, second=depths, share=shares)
def test_coupling_of_two_lobes(first, second, share):
    saddle = share * min(first, second)
    coupling, partner = coupled([first, second], [saddle])
    assert ((coupling >= 0.0) & (coupling <= 1.0)).all()
    shallow = int(second < first) if first != second else 1
    expected = max(1.0 - (min(first, second) - saddle) / (EPSILON * min(first, second)), 0.0)
    assert coupling[shallow] == pytest.approx(expected, abs=1e-12)
    assert coupling[1 - shallow] <= coupling[shallow] + 1e-12  # the deeper one is bound less
    if coupling[shallow] > 0.0:
        assert partner[shallow] == 1 - shallow


def test_the_deepest_lobes_are_kept_in_order_with_their_saddles_gaps_part_them():
    for rows in (coupled([2e-5, 1e-5], [-1.0]), coupled([1e-5], [])):
        assert (rows[0] == 0.0).all() and (rows[1] == -1).all()
    rows = found_rows([4e-5, 1e-5, 3e-5, 2e-5], [0.8e-5, 0.5e-5, 1.5e-5])
    assert select_deepest(rows, 4, 3) == 3
    assert list(rows["depth"][:3]) == [4e-5, 3e-5, 2e-5]
    assert list(rows["saddle"][:2]) == [0.5e-5, 1.5e-5]  # the deepest valley on the way
    assert rows[0].saddle_arc == 1.0
    rows = found_rows([4e-5, 1e-5, 3e-5], [-1.0, 0.5e-5])
    select_deepest(rows, 3, 2)
    assert rows[0].saddle < 0.0  # still apart


def test_amplitudes_are_those_of_the_linear_system_or_zero():
    matrix = np.array([[2.0, 0.5, 3.0], [0.5, 1.0, 2.0]])
    amplitude = np.ones(2)
    solve_amplitudes(matrix, 2, np.zeros((2, 3)), amplitude, np.zeros(2))
    np.testing.assert_allclose(matrix[:, :2] @ amplitude, matrix[:, 2])
    # the second would have to pull: the first carries alone
    matrix = np.array([[2.0, 0.5, 3.0], [1.5, 1.0, 0.1]])
    amplitude = np.ones(2)
    solve_amplitudes(matrix, 2, np.zeros((2, 3)), amplitude, np.zeros(2))
    assert amplitude == pytest.approx([1.5, 0.0])


def two_heads(spacing: float, radius: float = 0.3) -> Profile:
    """A rail of two round heads, crowns at +-spacing/2, joined by a hollow of the same radius [m]."""
    lean = float(np.arcsin(0.25 * spacing / radius))
    left, right = (ProfileArc(side * 0.5 * spacing, -radius, radius, *angles) for side, angles in
                   ((-1.0, (2.0 * lean, -lean)), (1.0, (lean, -2.0 * lean))))  # fmt: skip
    hollow = ProfileArc(0.0, radius * (2.0 * np.cos(lean) - 1.0), radius, -lean, lean)
    return profile_from_sections("two heads", "rail", [left, hollow, right])


CYLINDER = cone("cylinder", "wheel", 0.0, -0.06, 0.06)


def test_lobes_that_grow_together_become_one_patch_without_a_step():
    # deeper and deeper: apart, one patch of two lobes when the virtual penetrations meet, coupled ever more
    model = contacts.contact_model(CYLINDER, two_heads(0.02), **contacts.PLAIN)
    valley = 0.6 * (1.0 - np.cos(np.arcsin(0.005 / 0.3)))
    depths = valley * np.linspace(0.5, 20.0, 400)
    forces, couplings = [], []
    for depth in depths:
        lobes = model.evaluate((0.0, 0.0, contacts.RADIUS - depth)).patches
        assert len(lobes) == 2
        expected = max(1.0 - valley / (EPSILON * depth), 0.0) if depth > valley else 0.0
        assert lobes["coupling"] == pytest.approx([expected, expected], abs=1e-6)
        assert (lobes["group"][0] == lobes["group"][1]) == (expected > 0.0)
        forces.append(lobes["N"].sum())
        couplings.append(expected)
    assert couplings[0] == 0.0
    assert couplings[-1] > 0.9
    assert lobes["n_strips"].tolist() == [model.settings.strip_count / 2] * 2  # shared by their widths
    power = np.diff(np.log(forces)) / np.diff(np.log(depths))
    assert (power > 1.0).all()
    assert np.abs(np.diff(power)).max() < 0.05  # the coupling sets in with a bend, not with a step


def test_one_lobe_is_equation_29():
    stand = contacts.bench(contacts.pair_model("S1002/60E1 1:40", **contacts.PLAIN), rolling=False)
    _, contact = contacts.settle(stand, 2e-3, 0.0, 60e3)
    (lobe,), (strips,) = contact.patches, contact.strips
    integral = own_influence(strips, len(strips), lobe["half_length"])
    modulus = combined_modulus(stand.wheels[0].model.settings)
    p0 = np.pi * modulus * lobe["approach"] * lobe["half_length"] / integral
    assert lobe["p0"] == pytest.approx(p0, rel=1e-9)
    np.testing.assert_allclose(strips["p"], p0 * strips["a"] / lobe["half_length"], rtol=1e-12)


def test_every_lobe_that_is_looked_at_carries_its_share():
    """A furrowed wheel touches at six places and more; shallower ones carry less and take little from the others."""
    random = np.random.default_rng(8)
    furrows = [Removal("vertical", random.uniform(2e-5, 6e-5), c, 0.8e-3) for c in np.arange(-42e-3, 20e-3, 1.2e-3)]
    profiles = worn(contacts.wheel_profile("S1002"), furrows, "furrowed"), contacts.rail_profile("60E1", 40)
    usual = contacts.bench(contacts.contact_model(*profiles, normal="kik-piotrowski", **contacts.PLAIN), rolling=False)
    height = contacts.settle(usual, -2.4e-3, 0.0, 60e3)[0].height
    borne = []
    for most in range(3, 7):
        stand = contacts.bench(
            contacts.contact_model(*profiles, normal="kik-piotrowski", max_patches=most, **contacts.PLAIN),
            rolling=False,
        )
        stand.evaluate(-2.4e-3, height, 0.0, 0.0)
        forces = contacts.contact_of(stand).patches["N"]
        assert len(forces) == most and (forces > 0.0).all()
        borne.append(forces.sum())
    more = np.diff(borne)
    assert (more > 0.0).all() and (np.diff(more) < 0.0).all()
