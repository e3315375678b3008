"""The exact solver's contact in the strips of the fast models, so that everything downstream reads both alike.

Every connected region is a lobe and a patch of its own; every row of its elements is a strip: its force, its largest
pressure, half its length and the middle of that along the rail. Regions beyond ``max_patches`` count in the totals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.channels import ElementField
from wrsim.contact.half_space.patch import HalfSpaceContact, Patch, Region
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.model import ContactModel
from wrsim.core.contact import layout as k
from wrsim.core.contact.resultants import add_lobe, set_creepages
from wrsim.core.contact.tangential.friction import set_friction
from wrsim.core.contact.wheel_rail import carry

Array = NDArray[np.float64]


def solve_into(
    model: ContactModel, solver: HalfSpace | None = None, before: HalfSpaceContact | None = None
) -> HalfSpaceContact:
    """Solve the pose set in the model's arrays and write lobes, strips and totals there, as the kernel does.

    solver: that of the model's settings unless given; before: see `HalfSpace.solve_pose`.
    Tractions follow the model's ``tangential``: exact ones, or those of a strip model on the exact pressures.
    """
    contact = (solver or HalfSpace.of(model.settings.half_space)).solve_pose(model, before)
    write_contact(model, contact)
    return contact


def write_contact(model: ContactModel, contact: HalfSpaceContact) -> None:
    """Write a contact into the arrays of its model."""
    a = model.arrays
    tangential = model.settings.tangential
    regions = contact.largest(len(a.patches))
    a.patches[:] = 0.0
    exact = np.zeros(k.TOTAL)  # with what the strips hold of it
    for i, (patch, region) in enumerate(regions):
        lobe, strips, n = a.patches[i], a.strips[i], len(region.p)
        _write_region(patch, region, lobe, strips[:n])
        lobe[k.GROUP] = i
        set_creepages(a.pose, a.settings, lobe, strips, n)
        if tangential != "none":
            set_friction(a.pose, a.settings, strips, n)
        add_lobe(a.pose, lobe, strips, n, exact)
    force, moment, wear = contact.force, contact.moment, contact.wear
    if tangential not in ("half-space", "none"):
        by_strips = np.zeros(k.TOTAL)
        carry(a.creep, a.shape, a.settings, a.pose, a.patches, a.strips, len(regions), a.work, by_strips)
        force = force + (by_strips - exact)[k.FORCE_T : k.FORCE_B + 1]
        moment = moment + (by_strips - exact)[k.MOMENT_T : k.MOMENT_B + 1]
        wear = float(by_strips[k.WEAR])
    for i, (_, region) in enumerate(regions):
        # from edge to edge, not from the first strip's centre to the last one's
        a.patches[i, k.ANGLE_MIN] = min(a.patches[i, k.ANGLE_MIN], *region.angle)
        a.patches[i, k.ANGLE_MAX] = max(a.patches[i, k.ANGLE_MAX], *region.angle)
    a.total[k.FORCE_T : k.FORCE_B + 1] = force
    a.total[k.MOMENT_T : k.MOMENT_B + 1] = moment
    a.total[[k.COUNT, k.PATCHES]] = len(regions)
    a.total[k.WEAR] = wear
    a.total[k.CLOSEST] = contact.closest


def element_fields(contact: HalfSpaceContact, most: int) -> list[ElementField]:
    """Elements of the ``most`` largest regions, as the patches of the arrays."""
    fields = []
    for patch, region in contact.largest(most):
        inside = region.p > 0.0
        q = np.where(inside, patch.q[:, region.rows, region.columns], np.nan)
        fields.append(ElementField(patch.grid.x[region.columns], np.where(inside, region.p, np.nan), q))
    return fields


def _write_region(patch: Patch, region: Region, lobe: Array, strips: Array) -> None:
    """Lobe and strips of one region; creepages and sums are left to the kernels."""
    grid, own, rows, columns = patch.grid, region.p, region.rows, region.columns
    inside = own > 0.0
    qx, qs = np.where(inside, patch.q[:, rows, columns], 0.0)
    middle = 0.5 * (region.starts + region.ends)
    main = grid.at_row(rows.start + _main_row(grid.pen[rows, columns]))
    axis, slope = grid.axis[rows], np.hypot(main["no"], main["nb"])
    row = strips
    row[:] = 0.0
    row[:, k.S] = axis["s"] - main["s"]
    row[:, k.DS] = grid.ds
    row[:, k.X] = middle
    row[:, k.A] = 0.5 * (region.ends - region.starts)
    row[:, k.P] = own.max(axis=1)
    row[:, k.NO], row[:, k.NB] = axis["no"], axis["nb"]
    row[:, k.O], row[:, k.B] = axis["o"], axis["b"]
    row[:, k.FORCE] = own.sum(axis=1) * grid.cell
    row[:, k.FX] = qx.sum(axis=1) * grid.cell
    row[:, k.FY] = qs.sum(axis=1) * grid.cell
    row[:, k.MZ] = (qs * (grid.x[columns] - middle[:, None])).sum(axis=1) * grid.cell
    row[:, k.RADIUS_T] = axis["r_t"]
    lobe[[k.NO_MAIN, k.NB_MAIN]] = main["no"] / slope, main["nb"] / slope
    lobe[[k.O_MAIN, k.B_MAIN, k.X_MAIN]] = main["o"], main["b"], main["x"]
    lobe[[k.ARC_WHEEL, k.ARC_RAIL]] = main["arc_wheel"], main["arc_rail"]
    lobe[[k.START, k.END]] = region.s[0] - main["s"], region.s[1] - main["s"]
    lobe[k.WIDTH] = region.s[1] - region.s[0]
    lobe[k.LENGTH] = region.figures.length
    lobe[k.HALF_LENGTH] = 0.5 * region.figures.length
    lobe[[k.AREA, k.P0, k.N]] = region.area, region.p0, region.normal_force
    lobe[k.AMPLITUDE] = region.p0 / (0.5 * region.figures.length)
    lobe[k.APPROACH] = float(grid.pen[rows, columns][inside].max())
    lobe[k.N_STRIPS] = len(own)
    lobe[k.PARTNER] = -1.0


def _main_row(pen: Array) -> float:
    """Row of the largest interpenetration, between rows by a parabola."""
    crest = pen.max(axis=1)
    i = int(crest.argmax())
    if not 0 < i < len(crest) - 1:
        return float(i)
    bend = crest[i - 1] - 2.0 * crest[i] + crest[i + 1]
    return i + (0.5 * (crest[i - 1] - crest[i + 1]) / bend if bend < 0.0 else 0.0)
