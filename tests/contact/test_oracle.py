"""S1002 on 60E1 against CONTACT: where the wheel touches, how steeply, with what forces; and how far plain KP is off.

Frames: the reference is a right wheel with y to the right and z down; ours is the left wheel, its mirror image. Forces
on the rail are compared along x, outward and down. CONTACT's contact point is the force-weighted centre of the patch:
the force-weighted mean over our strips is set beside it, and the main point (the deepest) as well.

"Away from jumps": the reference's contact point moves by less than 2 mm to both neighbouring lateral shifts of the same
load and yaw. "Tread": contact angle below 0.2 rad."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from support.contacts import bench, contact_of, pair_model, settle, strips_of
from support.rows import data_rows, rows_of

table = rows_of(__file__)

FRICTION = 0.3
JUMP = 2e-3


@dataclass(frozen=True)
class Figures:
    """One wheel at one pose: places [m], angles [rad], forces [N]; p0 and area of the patch with the largest force."""

    centre: float
    main: float
    angle: float
    main_angle: float
    spread: float
    normal: float
    force: np.ndarray
    p0: float
    area: float
    patches: int


@dataclass(frozen=True)
class Case:
    """A row of the reference and what the model says."""

    name: str
    load: float
    lateral: float
    yaw: float
    rolling: bool
    reference: Figures
    ours: Figures
    calm: bool

    @property
    def on_tread(self):
        return self.reference.angle < 0.2


def reference_figures(patches):
    """Figures of the reference from the rows of one case."""
    first = max(patches, key=lambda r: float(r["Fn_N"]))
    ends = -float(first["ang_smin_rad"]), -float(first["ang_smax_rad"])
    centre, angle = 1e-3 * float(first["ycp_tr_mm"]), -float(first["deltcp_tr_rad"])
    return Figures(
        centre, centre, angle, angle, max(ends) - min(ends), sum(float(r["Fn_N"]) for r in patches),
        np.array([float(first["FX_tr_N"]), float(first["FY_tr_N"])]), 1e6 * float(first["pmax_MPa"]),
        1e-6 * float(first["area_mm2"]), len(patches) + int(float(first["n_components"])) - 1,
    )  # fmt: skip


def our_figures(stand, contact):
    """Figures of the model: patches are groups of lobes."""
    offset = stand.wheels[0].rail_origin[0]
    loaded = contact.patches[contact.patches["N"] > 0.0]
    groups = sorted(set(loaded["group"]), key=lambda g: -loaded["N"][loaded["group"] == g].sum())
    lobes, strips = loaded[loaded["group"] == groups[0]], strips_of(contact, groups[0])
    deepest, weight = lobes[np.argmax(lobes["approach"])], strips["N"]
    return Figures(
        (weight @ strips["o"]) / weight.sum() + offset, deepest["o"] + offset,
        np.arctan2(-weight @ strips["no"], weight @ strips["nb"]), deepest["angle"],
        lobes["angle_max"].max() - lobes["angle_min"].min(), loaded["N"].sum(), -contact.force[:2],
        lobes["p0"].max(), lobes["area"].sum(), len(groups),
    )  # fmt: skip


@cache
def cases(normal="kik-piotrowski", tangential="fastsim"):
    """All cases of the table, solved."""
    rows: dict[str, list[dict[str, str]]] = {}
    for row in data_rows("contact_own_static.csv"):
        rows.setdefault(row["case_id"], []).append(row)
    stands, neighbours = {}, {}
    for patches in rows.values():
        r = patches[0]
        key = r["cant_label"], r["tang"], r["Fz_req_N"], r["yaw_rad"]
        place = 1e-3 * float(max(patches, key=lambda p: float(p["Fn_N"]))["ycp_tr_mm"])
        neighbours.setdefault(key, []).append((float(r["y_ws_mm"]), place))
    result = []
    for name, patches in rows.items():
        r = patches[0]
        rolling, place = r["tang"] == "3", (r["cant_label"], r["tang"])
        if place not in stands:
            model = pair_model(
                f"S1002/60E1 {r['cant_label']}", normal=normal, tangential=tangential if rolling else "none"
            )
            stands[place] = bench(model, rolling=rolling)
        stand = stands[place]
        lateral, yaw, load = 1e-3 * float(r["y_ws_mm"]), float(r["yaw_rad"]), float(r["Fz_req_N"])
        solved, contact = settle(stand, lateral, yaw, load)
        assert not solved.message, (name, solved.message)
        row = sorted(neighbours[r["cant_label"], r["tang"], r["Fz_req_N"], r["yaw_rad"]])
        i = [y for y, _ in row].index(float(r["y_ws_mm"]))
        steps = [abs(row[j][1] - row[i][1]) for j in (i - 1, i + 1) if 0 <= j < len(row)]
        assert contact_of(stand).force[2] == pytest.approx(load, rel=1e-6)
        result.append(
            Case(name, load, lateral, yaw, rolling, reference_figures(patches), our_figures(stand, contact),
                 max(steps) < JUMP)
        )  # fmt: skip
    return tuple(result)


ERRORS = {
    "place": lambda c: abs(c.ours.centre - c.reference.centre),
    "main point": lambda c: abs(c.ours.main - c.reference.centre),
    "angle": lambda c: abs(c.ours.angle - c.reference.angle),
    "main angle": lambda c: abs(c.ours.main_angle - c.reference.angle),
    "normal force": lambda c: abs(c.ours.normal / c.reference.normal - 1.0),
    "spread": lambda c: abs(c.ours.spread - c.reference.spread),
    "creep forces": lambda c: np.abs(c.ours.force - c.reference.force).max() / (FRICTION * c.load),  # x and outward
}


def calm(on_tread, **values):
    chosen = [c for c in cases() if c.calm and c.on_tread == on_tread]
    chosen = [c for c in chosen if all(getattr(c, name) == value for name, value in values.items())]
    assert len(chosen) >= 4
    return chosen


TREAD, FLANGE = True, False
LIMITS = table("limits")  # fmt: skip
"""What, where, of which cases, how near; figures in comments are measured."""


@pytest.mark.parametrize(("name", "where", "of", "limit"), LIMITS)
def test_away_from_jumps_contacts_are_those_of_contact(name, where, of, limit):
    error = ERRORS[name]
    worst = max((c for c in calm(where, **of) if not np.isnan(error(c))), key=error)
    assert error(worst) < limit, f"{worst.name} at {1e3 * worst.lateral:g} mm: {error(worst):.5g}"


def test_creep_forces_err_to_neither_side_and_patches_are_as_many_as_contacts():
    # creepages between wheel and rail, half the approach nearer to the axle, would make -0.026 of mu Q in the median
    # of the strips' forces, whose median is -0.0024 with creepages on the wheel's undeformed surface
    chosen = [c for c in cases("strips", "fastrip") if c.calm and c.on_tread and c.rolling and c.yaw == 0.0]
    errors = [(c.ours.force[0] - c.reference.force[0]) / (FRICTION * c.load) for c in chosen]
    assert abs(np.median(errors)) < 0.003
    # regions are counted where CONTACT reports several as one patch
    chosen = [c for c in cases() if c.calm]
    agree = [c for c in chosen if c.ours.patches == c.reference.patches]
    assert len(agree) == len(chosen)
