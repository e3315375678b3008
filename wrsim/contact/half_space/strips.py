"""The exact solver's contact in the strips of the fast models, so that everything downstream reads both alike.

Every connected region is a lobe and a patch of its own; every row of its elements is a strip: its force, its largest
pressure, half its length and the middle of that along the rail. Regions beyond ``max_patches`` count in the totals.
"""

from typing import Any

import numpy as np

from wrsim.contact import records as k
from wrsim.contact.channels import ElementField
from wrsim.contact.creep.friction import set_friction
from wrsim.contact.half_space.patch import HalfSpaceContact, Patch, Region
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.model import ContactModel
from wrsim.contact.resultants import add_lobe, set_creepages
from wrsim.contact.wheel_rail import apply_creep_forces, in_track_axes, pose_in_rail_axes
from wrsim.jit import Array, Records

FORCE, MOMENT = ("Ft", "Fo", "Fb"), ("Mt", "Mo", "Mb")


def solve_into(
    model: ContactModel, solver: HalfSpace | None = None, before: HalfSpaceContact | None = None
) -> HalfSpaceContact:
    """Solve the pose set in the model's arrays and write lobes, strips and totals there, as the kernel does. solver:
    that of the model's settings unless given; before: see `HalfSpace.solve_pose`. Tractions follow the model's
    ``tangential``: exact ones, or those of a strip model on the exact pressures."""
    contact = (solver or HalfSpace.of(model.settings.half_space)).solve_pose(model, before)
    write_contact(model, contact)
    return contact


def write_contact(model: ContactModel, contact: HalfSpaceContact) -> None:
    a = model.arrays
    pose, total = pose_in_rail_axes(a.rows), a.total
    tangential = model.settings.creep_forces
    regions = contact.largest(len(a.patches))
    a.patches[:] = np.zeros((), k.LOBE)
    a.rows.total[:] = np.zeros((), k.TOTAL)
    for i, (patch, region) in enumerate(regions):
        lobe, strips, n = a.patches[i], a.strips[i], len(region.p)
        _write_region(patch, region, lobe, strips[:n])
        lobe.group = i
        set_creepages(pose, a.model, lobe, strips, n)
        if tangential != "none":
            set_friction(pose.velocity.x, a.inputs, a.model.least_speed, strips, n)
        if patch.temperature is not None and model.settings.temperature is not None:
            hot = np.where(region.p > 0.0, patch.temperature[region.rows, region.columns], -np.inf)
            strips["temperature"][:n], lobe.temperature = hot.max(axis=1), hot.max()
            change = model.settings.temperature.change(hot) * region.p
            strips["mu"][:n] = np.maximum(strips["mu"][:n] + change.sum(axis=1) / region.p.sum(axis=1), 0.0)
        add_lobe(pose, lobe, strips, n, total)
    force, moment, wear = contact.force, contact.moment, contact.wear
    if tangential not in ("half-space", "none"):
        # what the strips hold without the creep forces that are added now
        exact = total.copy()
        a.rows.total[:] = np.zeros((), k.TOTAL)
        apply_creep_forces(a.buffer, a.index, len(regions))
        wear = float(total.wear)
        for name in (*FORCE, *MOMENT):
            total[name] -= exact[name]
    total.lobes = total.patches = len(regions)
    in_track_axes(a.rows)
    if tangential not in ("half-space", "none"):
        force = force + [total[name] for name in FORCE]
        moment = moment + [total[name] for name in MOMENT]
    for i, (_, region) in enumerate(regions):
        # from edge to edge, not from the first strip's centre to the last one's
        lobe = a.patches[i]
        lobe.angle_min = min(lobe.angle_min, *region.angle)
        lobe.angle_max = max(lobe.angle_max, *region.angle)
    for name, value in zip((*FORCE, *MOMENT), (*force, *moment), strict=True):
        total[name] = value
    total.wear, total.closest, total.status = wear, contact.closest, contact.status


def element_fields(contact: HalfSpaceContact, most: int) -> list[ElementField]:
    """Elements of the ``most`` largest regions, as the patches of the arrays."""
    fields = []
    for patch, region in contact.largest(most):
        inside = region.p > 0.0
        q = np.where(inside, patch.q[:, region.rows, region.columns], np.nan)
        fields.append(ElementField(patch.grid.x[region.columns], np.where(inside, region.p, np.nan), q))
    return fields


def _write_region(patch: Patch, region: Region, lobe: Any, strips: Records) -> None:
    """Lobe and strips of one region; creepages and sums are left to the kernels."""
    grid, pressures, rows, columns = patch.grid, region.p, region.rows, region.columns
    inside = pressures > 0.0
    qx, qs = np.where(inside, patch.q[:, rows, columns], 0.0)
    middle = 0.5 * (region.starts + region.ends)
    main = grid.at_row(rows.start + _main_row(grid.pen[rows, columns]))
    axis, size = grid.axis[rows], np.hypot(main["no"], main["nb"])
    strips[:] = np.zeros((), k.STRIP)
    strips["s"] = axis["s"] - main["s"]
    strips["ds"] = grid.ds
    strips["x"] = middle
    strips["a"] = 0.5 * (region.ends - region.starts)
    strips["p"] = pressures.max(axis=1)
    for name in ("no", "nb", "o", "b", "r_t", "slope"):
        strips[name] = axis[name]
    strips["penetration"] = -axis["gap"]
    strips["N"] = pressures.sum(axis=1) * grid.cell
    strips["Fx"] = qx.sum(axis=1) * grid.cell
    strips["Fy"] = qs.sum(axis=1) * grid.cell
    strips["Mz"] = (qs * (grid.x[columns] - middle[:, None])).sum(axis=1) * grid.cell
    for name in ("x", "o", "b", "arc_wheel", "arc_rail", "slope"):
        lobe[name] = main[name]
    lobe.no, lobe.nb = main["no"] / size, main["nb"] / size
    lobe.start, lobe.end = region.s[0] - main["s"], region.s[1] - main["s"]
    lobe.width = region.s[1] - region.s[0]
    lobe.length = region.length
    lobe.half_length = 0.5 * region.length
    lobe.area, lobe.p0, lobe.N = region.area, region.p0, region.normal_force
    lobe.amplitude = region.p0 / (0.5 * region.length)
    lobe.approach = float(grid.pen[rows, columns][inside].max())
    lobe.n_strips = len(pressures)
    lobe.partner = -1


def _main_row(pen: Array) -> float:
    """Row of the largest interpenetration, between rows by a parabola."""
    crest = pen.max(axis=1)
    i = int(crest.argmax())
    if not 0 < i < len(crest) - 1:
        return float(i)
    bend = crest[i - 1] - 2.0 * crest[i] + crest[i + 1]
    return i + (0.5 * (crest[i - 1] - crest[i + 1]) / bend if bend < 0.0 else 0.0)
