"""The exact solver's contact in the rows of the strip models, so that everything downstream reads both alike.

Every connected region is a lobe and a patch of its own; every row of its elements is a strip: its force, its largest
pressure, half its length and the middle of that along the rail. Regions beyond ``max_patches`` count in the totals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.channels import ElementField
from wrsim.contact.half_space.patch import HalfSpaceContact, HalfSpacePatch, Region
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.model import ContactModel
from wrsim.core.contact import layout as k
from wrsim.core.contact.half_space import surface
from wrsim.core.contact.half_space.normal import summarise
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
    regions = _largest(contact, len(a.patches))
    a.patches[:] = 0.0
    a.total[:] = 0.0
    for i, (patch, region) in enumerate(regions):
        _write_region(patch, region, a.patches[i], a.strips[i])
        a.patches[i, k.GROUP] = i
        set_creepages(a.pose, a.settings, a.patches[i], a.strips[i], int(a.patches[i, k.N_STRIPS]))
        if model.settings.tangential != "none":
            set_friction(a.pose, a.settings, a.strips[i], int(a.patches[i, k.N_STRIPS]))
    force, moment = contact.force, contact.moment
    bare, whole = np.zeros(k.TOTAL), np.zeros(k.TOTAL)
    by_strips = model.settings.tangential not in ("half-space", "none")
    for i in range(len(regions)):
        add_lobe(a.pose, a.patches[i], a.strips[i], int(a.patches[i, k.N_STRIPS]), bare)
    wear = sum(p.wear for p in contact.patches)
    if by_strips:
        carry(a.creep, a.shape, a.settings, a.pose, a.patches, a.strips, len(regions), a.work, whole)
        force = force + (whole - bare)[k.FORCE_T : k.FORCE_B + 1]
        moment = moment + (whole - bare)[k.MOMENT_T : k.MOMENT_B + 1]
        wear = float(whole[k.WEAR])
    for i, (_, region) in enumerate(regions):
        # from edge to edge, not from the first strip's centre to the last one's
        a.patches[i, k.ANGLE_MIN] = min(a.patches[i, k.ANGLE_MIN], *region.angle)
        a.patches[i, k.ANGLE_MAX] = max(a.patches[i, k.ANGLE_MAX], *region.angle)
    a.total[k.FORCE_T : k.FORCE_B + 1] = force
    a.total[k.MOMENT_T : k.MOMENT_B + 1] = moment
    a.total[k.COUNT] = len(regions)
    a.total[k.PATCHES] = len(regions)
    a.total[k.WEAR] = wear
    a.total[k.CLOSEST] = contact.closest


def element_fields(contact: HalfSpaceContact, most: int) -> list[ElementField]:
    """Elements of the ``most`` largest regions, as the patches of the arrays."""
    fields = []
    for patch, region in _largest(contact, most):
        inside = region.p > 0.0
        q = np.where(inside, patch.q[:, region.rows, region.columns], np.nan)
        fields.append(ElementField(patch.grid.x[region.columns], np.where(inside, region.p, np.nan), q))
    return fields


def _largest(contact: HalfSpaceContact, most: int) -> list[tuple[HalfSpacePatch, Region]]:
    """The largest regions of all grids, each with its grid."""
    found = [(patch, region) for patch in contact.patches for region in patch.regions]
    found.sort(key=lambda pair: -pair[1].normal_force)
    return found[:most]


def _write_region(patch: HalfSpacePatch, region: Region, lobe: Array, strips: Array) -> None:
    """Lobe and strips of one region; creepages and sums are left to the kernels."""
    grid, own, rows, columns = patch.grid, region.p, region.rows, region.columns
    n, cell = len(own), grid.dx * grid.ds
    starts, ends, figures = np.zeros(n), np.zeros(n), np.zeros(5)
    summarise(own, grid.dx, grid.ds, starts, ends, figures)
    first = grid.x[columns.start] - 0.5 * grid.dx
    main = _main_row(grid.pen[rows, columns])
    at = rows.start + main

    def there(column: int) -> float:
        return float(np.interp(at, np.arange(len(grid.axis)), grid.axis[:, column]))

    s_main = there(surface.AT_S)
    strips[:n] = 0.0
    row = strips[:n]
    row[:, k.S] = grid.s[rows] - s_main
    row[:, k.DS] = grid.ds
    row[:, k.X] = first + 0.5 * grid.dx * (starts + ends)
    row[:, k.A] = 0.5 * grid.dx * (ends - starts)
    row[:, k.P] = own.max(axis=1)
    row[:, k.NO], row[:, k.NB] = grid.normal[rows].T
    row[:, k.O], row[:, k.B] = grid.centre[rows].T
    row[:, k.FORCE] = own.sum(axis=1) * cell
    inside = own > 0.0
    qx, qs = np.where(inside, patch.q[:, rows, columns], 0.0)
    row[:, k.FX] = qx.sum(axis=1) * cell
    row[:, k.FY] = qs.sum(axis=1) * cell
    row[:, k.MZ] = (qs * (grid.x[columns] - row[:, k.X, None])).sum(axis=1) * cell
    row[:, k.RADIUS_T] = grid.axis[rows, surface.AT_RADIUS]
    normal = np.array([there(surface.AT_NO), there(surface.AT_NB)])
    lobe[[k.NO_MAIN, k.NB_MAIN]] = normal / np.hypot(*normal)
    lobe[[k.O_MAIN, k.B_MAIN, k.X_MAIN]] = there(surface.AT_O), there(surface.AT_B), there(surface.AT_X)
    lobe[[k.ARC_WHEEL, k.ARC_RAIL]] = there(surface.AT_WHEEL), there(surface.AT_RAIL)
    lobe[[k.START, k.END]] = region.s[0] - s_main, region.s[1] - s_main
    lobe[k.WIDTH] = region.s[1] - region.s[0]
    lobe[k.LENGTH] = figures[4]
    lobe[k.HALF_LENGTH] = 0.5 * figures[4]
    lobe[[k.AREA, k.P0, k.N]] = figures[:3]
    lobe[k.AMPLITUDE] = figures[1] / (0.5 * figures[4])
    lobe[k.APPROACH] = float(grid.pen[rows, columns][inside].max())
    lobe[k.N_STRIPS] = n
    lobe[k.PARTNER] = -1.0


def _main_row(pen: Array) -> float:
    """Row of the largest interpenetration, between rows by a parabola."""
    crest = pen.max(axis=1)
    i = int(crest.argmax())
    if not 0 < i < len(crest) - 1:
        return float(i)
    bend = crest[i - 1] - 2.0 * crest[i] + crest[i + 1]
    return i + (0.5 * (crest[i - 1] - crest[i + 1]) / bend if bend < 0.0 else 0.0)
