"""Rolling contact of a Hertzian ellipse with prescribed creepages, by every normal and tangential model.

A cylindrical wheel on a round crown; the radii give the half axes of the reference (sqrt(a b) = 5 mm) at a small peak
pressure, so that the curvature of the bodies does not change the creepages over the patch. Everything is scaled with
that pressure, as Hertz' and Coulomb's laws allow.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from reference_contact import FRICTION, STEEL, Chosen, Row
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from wrsim.contact.half_space.influence import Compliance
from wrsim.contact.half_space.strips import solve_into
from wrsim.contact.model import ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.profiles.sections import circle, cone
from wrsim.contact.settings import ContactSettings

Array = NDArray[np.float64]

MEAN_RADIUS = 5e-3  # sqrt(a b) [m]
TABLE_PEAK, PEAK = 1e9, 3e7  # of the table, and ours [Pa]
SPEED = 50.0  # [m/s]
OURS = ("contact_ellbound", "fastsim_ell", "fastsim_par", "fastrip")
"""Models inside the reference that are scored beside ours."""


def curvatures(a: float, b: float) -> tuple[float, float, float]:
    """Relative curvatures 2A along x and 2B across [1/m], and the approach [m], of the ellipse at the peak pressure.

    Johnson, Contact Mechanics, 1985, sections 3.2 and 3.3, in Carlson's integrals.
    """
    scale = PEAK * a * b / Compliance.of(STEEL, STEEL).modulus
    along, across = (2.0 / 3.0 * scale * elliprd(0.0, *pair) for pair in ((b * b, a * a), (a * a, b * b)))
    return float(along), float(across), float(scale * elliprf(0.0, a * a, b * b))


@cache
def ellipse_model(settings: ContactSettings, ratio: float) -> tuple[ContactModel, float]:
    """A contact model with Hertz' ellipse of this a/b, and the approach."""
    a, b = MEAN_RADIUS * np.sqrt(ratio), MEAN_RADIUS / np.sqrt(ratio)
    along, across, approach = curvatures(a, b)
    rail = circle("crown", "rail", 1.0 / across, 0.04)
    wheel = cone("cylinder", "wheel", 0.0, -0.05, 0.05)
    return contact_model(wheel, rail, 1.0 / along, settings, FRICTION), approach


def forces(chosen: Chosen, settings: ContactSettings, row: Row) -> Array:
    """Fx, Fy and the spin moment of a row over mu N and mu N sqrt(a b)."""
    model, approach = ellipse_model(settings, float(row["a_over_b"]))
    share = PEAK / TABLE_PEAK
    xi, eta, phi = (share * float(row[name]) for name in ("cksi", "ceta", "cphi_radpmm"))
    target = 2.0 / 3.0 * np.pi * MEAN_RADIUS**2 * PEAK
    velocity = (SPEED, eta * SPEED, 0.0)
    omega = (0.0, SPEED * (1.0 - xi) / model.radius, 1e3 * phi * SPEED)

    def press(depth: float) -> float:
        pose = (0.0, 0.0, model.radius - depth, 0.0, 1.0, 0.0, *velocity, *omega)
        model.arrays.pose[:] = pose
        if chosen.solver is not None:
            solve_into(model, chosen.solver, None)
        else:
            model.arrays.evaluate()
        return float(model.arrays.patches["N"][: int(model.arrays.total["lobes"])].sum()) - target

    if chosen.solver is None:
        press(float(brentq(press, 0.3 * approach, 3.0 * approach, xtol=1e-16, rtol=1e-12)))
    else:
        press(approach)  # Hertz' own
    total = model.arrays.total
    force, moment = model.arrays.force, model.arrays.moment
    normal = float(model.arrays.patches["N"][: int(total["lobes"])].sum())
    bound = FRICTION * normal
    return np.array([force[0] / bound, force[1] / bound, moment[2] / (bound * MEAN_RADIUS)])


def score_tangential(
    rows: list[Row], models: list[Chosen], tangential: list[str], every: int = 1
) -> list[dict[str, object]]:
    """Print the errors of the creep forces against CONTACT, over mu N; returns a row for every case and model."""
    records: list[dict[str, object]] = []
    truth = {row["case_id"]: row for row in rows if row["method"] == "contact"}
    truth = dict(list(truth.items())[::every])

    def figures(row: Row) -> Array:
        return np.array([float(row[name]) for name in ("fx", "fy", "mz_norm")])

    said: dict[str, dict[str, Array]] = {}
    for method in OURS:
        said["CONTACT's " + method] = {
            r["case_id"]: figures(r) for r in rows if r["method"] == method and r["case_id"] in truth
        }
    for chosen in models:
        for name in tangential if chosen.solver is None else ["half-space"]:
            settings = chosen.with_tangential(name)
            said[f"{chosen.name}, {name}"] = {case: forces(chosen, settings, row) for case, row in truth.items()}
    print(f"\n== creep forces on Hertz' ellipses (tangential.csv): {len(truth)} cases; errors over mu N")
    print(f"{'':40s}{'force: median':>14s}{'95 %':>8s}{'max':>8s}{'moment: median':>16s}{'95 %':>8s}{'max':>8s}"
          f"{'max |F|/mu N':>14s}")  # fmt: skip
    for model, values in said.items():
        e = np.abs([values[c] - figures(row) for c, row in truth.items() if c in values])
        force, moment = e[:, :2].max(axis=1), e[:, 2]
        records += [
            {
                "model": model,
                "kind": row["kind"],
                "a_over_b": row["a_over_b"],
                "force": f"{f:.4f}",
                "moment": f"{m:.4f}",
            }
            for (c, row), f, m in zip([i for i in truth.items() if i[0] in values], force, moment, strict=True)
        ]
        most = max(np.hypot(*v[:2]) for v in values.values())
        f, m = np.percentile(force, [50.0, 95.0]), np.percentile(moment, [50.0, 95.0])
        print(f"{model:40s}{f[0]:14.4f}{f[1]:8.4f}{force.max():8.4f}{m[0]:16.4f}{m[1]:8.4f}{moment.max():8.4f}"
              f"{most:14.4f}")  # fmt: skip
    return records
