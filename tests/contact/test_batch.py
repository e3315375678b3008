"""Many poses in one call: the same contacts as one by one, each under its load."""

import numpy as np
import pytest
from support.contacts import RADIUS, bench, pair_model

from wrsim import InputError
from wrsim.contact.batch import LOAD_TOLERANCE, search_for
from wrsim.contact.patches import RawContacts, patch_channels
from wrsim.contact.prescribed_load import REACHED, SEARCHING, begin_search, next_height
from wrsim.contact.records import LOBE, STATUS_DISCONTINUOUS, STATUS_NO_CONTACT, STATUS_OUT_OF_REACH, TOTAL
from wrsim.jit.compiling import cores

PAIR = "S1002/60E1 1:40"
LOAD = 55e3
SHIFTS = (0.0, 3e-3, 5.06e-3, 6.5e-3, 8e-3)  # tread with two patches, tread, tread and root, gauge corner, flange
MODELS = ("kik-piotrowski", "strips")


def model_of(normal):
    return pair_model(PAIR, normal=normal, strips=12) if normal == "strips" else pair_model(PAIR, normal=normal)


def poses_of(model, shifts=SHIFTS, side=1, yaw=2e-3, height=RADIUS + 0.02):
    stand = bench(model, sides=(side,))
    rows = []
    for shift in shifts:
        stand.place(shift, height, yaw, 0.0)
        rows.append(model.arrays.pose.copy())
    return np.array(rows)


@pytest.mark.parametrize("normal", MODELS)
def test_many_contacts_are_those_of_one_by_one_to_the_bit(normal):
    model = model_of(normal)
    heights = model.solve_many(poses_of(model), LOAD, threads=1).poses
    many = model.evaluate_many(heights, threads=1)
    for i, row in enumerate(heights):
        contact = model.evaluate(*row.reshape(4, 3))
        assert np.array_equal(many.force[i], contact.force)
        assert np.array_equal(many.moment[i], contact.moment)
        assert np.array_equal(many.raw.patches[i, 0, : len(contact.patches)], contact.patches)
        assert np.nansum(many.N[i]) == pytest.approx(contact.normal_force, rel=1e-14)


@pytest.mark.parametrize("lobes", [1, 2])
def test_patches_are_the_sums_of_their_lobes_whatever_stands_in_the_rooms_of_others(lobes):
    """By one lobe after the other: forces add up, extremes are those of all, the main lobe is the deepest."""
    generator = np.random.default_rng(lobes)
    raw = RawContacts(np.zeros((40, 2, 4), LOBE), np.zeros((40, 2), TOTAL))
    for name in LOBE.names:
        raw.patches[name] = generator.uniform(0.1, 1.0, raw.patches.shape)
    raw.patches["group"][:, :, 1:] = np.cumsum(generator.integers(0, 2, (40, 2, 3)), axis=-1)  # as kernels count
    raw.patches["group"][:, :, 0] = 0
    raw.totals["lobes"] = generator.integers(0, lobes + 1, raw.totals.shape)
    channels = patch_channels(raw)
    assert {values.shape for values in channels.values()} == {raw.patches.shape}
    counts = raw.totals["lobes"]
    for place in np.ndindex(counts.shape):
        rows = raw.patches[place][: counts[place]]
        patches = sorted((rows[rows["group"] == g] for g in set(rows["group"])), key=lambda p: -p["N"].sum())
        for j in range(4):
            values = {name: channels[name][place][j] for name in channels}
            if j >= len(patches):
                assert np.isnan(list(values.values())).all()
                continue
            patch, main = patches[j], patches[j][patches[j]["approach"].argmax()]
            assert values["N"] == patch["N"].sum()
            assert (values["p0"], values["contact_angle_min"]) == (patch["p0"].max(), patch["angle_min"].min())
            place_of = patch["arc_rail"]
            assert values["width"] == (place_of + patch["end"]).max() - (place_of + patch["start"]).min()
            assert (values["xi"], values["x_contact"]) == (main["xi"], main["x"])
            levers = patch["x"] - main["x"], place_of - main["arc_rail"]
            moment = (patch["Mz"] + levers[0] * patch["Fy"] - levers[1] * patch["Fx"]).sum()
            assert values["spin_moment"] == pytest.approx(moment, rel=1e-14)


@pytest.mark.parametrize("normal", MODELS)
def test_many_contacts_carry_their_loads_and_are_those_at_their_heights(normal):
    model = model_of(normal)
    loads = np.linspace(0.2, 1.8, len(SHIFTS)) * LOAD
    solved = model.solve_many(poses_of(model), loads, threads=1)
    assert not solved.status.any()
    assert solved.force[:, 2] == pytest.approx(loads, rel=LOAD_TOLERANCE)
    cold = model.evaluate_many(solved.poses, threads=1)
    assert cold.force == pytest.approx(solved.force, abs=LOAD_TOLERANCE * LOAD)
    # p0 goes with the cube root of the force
    assert cold.p0 == pytest.approx(solved.p0, rel=10.0 * LOAD_TOLERANCE, nan_ok=True)


@pytest.mark.parametrize("normal", MODELS)
def test_neither_order_nor_threads_change_a_bit(normal):
    model = model_of(normal)
    poses = poses_of(model, np.linspace(-6e-3, 8e-3, 41))
    one_thread, two_threads = (model.solve_many(poses, LOAD, threads=count) for count in (1, min(2, cores())))
    back = model.solve_many(poses[::-1], LOAD, threads=1)
    for many in (two_threads, back):
        order = slice(None, None, -1) if many is back else slice(None)
        for name in ("poses", "force", "moment", "p0"):
            assert np.array_equal(getattr(many, name)[order], getattr(one_thread, name), equal_nan=True)


def test_both_sides_give_mirrored_contacts_to_the_bit():
    model = model_of("kik-piotrowski")
    left, right = (
        model.solve_many(poses_of(model, s * np.array(SHIFTS), s, s * 2e-3), LOAD, threads=1) for s in (1, -1)
    )
    for name in ("poses", "force", "N", "p0", "area", "approach", "contact_angle"):
        assert np.array_equal(getattr(left, name), getattr(right, name), equal_nan=True)


def test_a_wheel_off_its_rail_or_a_load_in_a_jump_or_beyond_reach_has_a_status():
    model = model_of("kik-piotrowski")
    poses = poses_of(model, (0.0, 0.3, 0.0))
    contacts_at_load = model.solve_many(poses, [LOAD, LOAD, 1e9], threads=1)
    assert contacts_at_load.status[0] == 0
    assert contacts_at_load.status[1] & STATUS_NO_CONTACT
    assert contacts_at_load.status[2] & STATUS_OUT_OF_REACH
    s = search_for([LOAD], 1e-4, RADIUS, 115e9)[0]
    begin_search(s)
    outcome = SEARCHING
    while outcome == SEARCHING:
        force = 1.1e9 * max(-s.height, 0.0) + (0.5 * LOAD if s.height < -30e-6 else 0.0)
        outcome = next_height(s, force, -float(s.height), LOAD_TOLERANCE)
    assert outcome == STATUS_DISCONTINUOUS
    # enclosed where the force is a hundred times as steep as Hertz's
    assert s.low <= -30e-6 <= s.high and s.high - s.low < 0.01 * 30e-6


@pytest.mark.parametrize("approach", [1e-13, 7e-12, 1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("felt", [0.1, 1.0])
def test_the_load_is_met_in_few_steps_wherever_the_wheel_touches_first(approach, felt):
    """Hertz's force over the height; felt: approach that the contact reports, over the one along the height."""
    s = search_for([LOAD], -approach, RADIUS, 115e9)[0]
    begin_search(s)
    outcome, asked = SEARCHING, 0
    while outcome == SEARCHING and asked < 60:
        depth = max(-float(s.height), 0.0)
        outcome = next_height(s, 1.1e11 * depth**1.5, felt * depth or -1e-6, LOAD_TOLERANCE)
        asked += 1
    assert outcome == REACHED


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poses": np.zeros((2, 3))}, r"poses: must be of shape \(n, 12\)"),
        ({"poses": np.full((1, 12), np.nan)}, "row 0 has numbers that are not finite"),
        ({"load": [1e3, 2e3]}, "load: must be one number or 1 of them"),
        ({"load": -1.0}, "load = -1 of pose 0: must be a vertical force above 0 N"),
        ({"threads": 10_000}, "threads: must be a whole number from 1 to"),
    ],
)
def test_bad_input_has_one_clear_error(change, message):
    model = model_of("kik-piotrowski")
    arguments = {"poses": np.zeros((1, 12)), "load": LOAD, "threads": 1} | change
    with pytest.raises(InputError, match=message):
        model.solve_many(arguments.pop("poses"), **arguments)
