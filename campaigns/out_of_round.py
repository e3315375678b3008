"""A wheel with a rounded flat beside CONTACT: height, place, approach and pressure of every pose, by every model.

    python campaigns/out_of_round.py [--models strips,kik-piotrowski,half-space]
    python campaigns/out_of_round.py --random 8

In tests/data: rounded_flat_d09.csv, 15 poses by CONTACT 25.2 (rolling radius 450 mm, rail crown 300 mm, 10 kN), and
flat_d09_depth.csv, the depth of the wheel at slices of its angle.

The wheel is taken three times: as the table, which has every fourth place across of CONTACT's slices; at all of these
places, by the closed form that the table follows within 6 nm: a rounded flat of 0.9 mm depth and 100.18 mm length cut
by a crown of 300 mm; and as CONTACT resamples the slices, by cubic splines over at most 0.5 mm. The spline of CONTACT
over the angle has its slices as coefficients: its values there are (1, 4, 1)/6 of theirs, which all are given.

Height: of the wheelset where it carries the load [um]; place: of the normal force along the rail [mm]; approach: the
penetration across from CONTACT's reference point [%]; p0 [%], where CONTACT has fewer than 1200 elements in contact.

--random N: polygons and flats of S1002 on 60E1 1:40 at N random lateral shifts, yaws and angles of the wheel each, 70
kN by strips; fast models beside the half-space solver at the same height: N, p0 [%], place along the rail [mm].
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from support.rows import data_rows

from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.sections import circle, cone
from wrsim.contact.settings import ContactSettings, HalfSpaceSettings, Material
from wrsim.contact.surfaces.out_of_round import Flat, Harmonic, Part, RadiusTable

RADIUS, CROWN, LOAD = 0.45, 0.3, 1e4
DEPTH, LENGTH = 0.9e-3, 0.10018
STEEL = Material(2.0 * 82e9 * 1.28, 0.28)
SURE = 1200  # elements up to which CONTACT's largest pressure does not show the joints of slices
PLACES = ("all places", "resampled", "table")
RESAMPLED, ELEMENT = 0.5e-3, 0.2e-3  # by CONTACT [m]
BRACKET = 12e-6  # about CONTACT's height [m]


def slices() -> NDArray[np.float64]:
    """Angle [rad], place across [mm] and depth [mm] of CONTACT's slices of the wheel, shape (n, 3)."""
    return np.array([[float(value) for value in row.values()] for row in data_rows("flat_d09_depth.csv")])


def table(places: str) -> RadiusTable:
    """The wheel at CONTACT's slices, at one of PLACES across."""
    angle, across, depth = slices().T
    angle, across = np.unique(angle), 1e-3 * np.unique(across)
    depth = 1e-3 * depth.reshape(angle.size, across.size)
    if places != "table":
        across = np.linspace(across[0], across[-1], 4 * (across.size - 1) - 1)
        flat = Flat.rounded(RADIUS, LENGTH, DEPTH, width=2.0 * np.sqrt(2.0 * CROWN * DEPTH))
        depth = flat.depth(angle, across, RADIUS)
    if places == "resampled":
        count = 1 + int(np.ptp(across) / RESAMPLED)
        for parts in (count, 5 * count):  # the finer places show its spline
            known, across = across, np.linspace(across[0], across[-1], parts + 1)
            depth = CubicSpline(known, depth, axis=1, bc_type="natural")(across)
    depth[1:-1] = (depth[:-2] + 4.0 * depth[1:-1] + depth[2:]) / 6.0
    return RadiusTable(angle, across, -depth)


def carrying(model: ContactModel, height: float, angle: float) -> tuple[float, Contact]:
    """How far the wheelset is below its nominal height under the load [m], and the contact; height: about where."""

    def contact_at(z: float) -> Contact:
        return model.evaluate((0.0, 0.0, RADIUS - z), wheel_angle=angle)

    z = brentq(lambda z: float(contact_at(z).force[2]) / LOAD - 1.0, height - BRACKET, height + BRACKET, xtol=1e-10)
    return z, contact_at(z)


WHEELS: dict[str, Part] = {
    "polygon, order 18, 0.05 mm": Harmonic(18, 5e-5),
    "rounded flat, 90 mm, 0.5 mm": Flat.rounded(0.46, 0.09, 5e-4),
    "the same, 60 mm wide": Flat.rounded(0.46, 0.09, 5e-4, width=0.06, centre=-0.01),
    "fresh flat, 40 mm, edges 12 mm": Flat.fresh(0.46, 0.04, None, 0.012),
    "fresh flat, 40 mm, edges 4 mm": Flat.fresh(0.46, 0.04, None, 0.004),
}


def random_poses(count: int) -> None:
    """Median and largest difference of the fast models from the exact one."""
    wheel, rail = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml").inclined(1.0 / 40.0)
    rng = np.random.default_rng(3)
    for name, part in WHEELS.items():
        models = {
            normal: contact_model(
                wheel, rail, 0.46, ContactSettings(normal=normal, tangential="none", damping=0.0), out_of_round=[part]
            )
            for normal in ("half-space", "strips", "kik-piotrowski")
        }
        figures = np.zeros((len(models), count, 3))
        for k in range(count):
            lateral, yaw = rng.uniform(-4e-3, 1e-3), rng.uniform(-8e-3, 8e-3)
            angle = rng.uniform(0.0, 6.0) if isinstance(part, Harmonic) else rng.uniform(-0.06, 0.06)
            axle = (-np.sin(yaw), np.cos(yaw), 0.0)
            start = [[0.0, lateral, 0.461, *axle, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
            pose = models["strips"].solve_many(start, 7e4, threads=1, wheel_angle=angle).poses[0]
            for rows_of_model, model in zip(figures, models.values(), strict=True):
                contact = model.evaluate(pose[:3], axle, wheel_angle=angle)
                strips = np.concatenate(contact.strips)
                middle = strips["N"] @ strips["x"] / strips["N"].sum()
                rows_of_model[k] = contact.normal_force, contact.patches["p0"].max(), 1e3 * middle
        for normal, rows_of_model in list(zip(models, figures, strict=True))[1:]:
            off = np.abs(
                np.column_stack(
                    [100.0 * (rows_of_model[:, :2] / figures[0, :, :2] - 1.0), rows_of_model[:, 2] - figures[0, :, 2]]
                )
            )
            cells = (f"{m:.2g} / {w:.2g}" for m, w in zip(np.median(off, axis=0), off.max(axis=0), strict=True))
            print(f"{name:32} {normal:15} {', '.join(cells)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=0, metavar="N")
    parser.add_argument("--models", default="strips,kik-piotrowski,half-space")
    arguments = parser.parse_args()
    if arguments.random:
        random_poses(arguments.random)
    else:
        beside_contact(arguments.models.split(","))


def beside_contact(normals: list[str]) -> None:
    """Every pose of CONTACT's table."""
    rows = data_rows("rounded_flat_d09.csv")
    wheel, rail = cone("cylinder", "wheel", 0.0, -0.0302, 0.0302), circle("crown", "rail", CROWN, 0.05)
    for normal in normals:
        for name in PLACES:
            part = table(name)
            settings = ContactSettings(
                normal=normal, tangential="none", wheel=STEEL, rail=STEEL, damping=0.0,
                half_space=HalfSpaceSettings(element=(ELEMENT, ELEMENT)),
            )  # fmt: skip
            model = contact_model(wheel, rail, RADIUS, settings, out_of_round=[part])
            errors = []
            print(f"\n{normal}, {name}\n  row  pitch  height um  place mm  approach %    p0 %")
            for row in rows:
                z, contact = carrying(model, 1e-3 * float(row["z_ws"]), -float(row["pitch"]))
                strips = np.concatenate(contact.strips)
                across = strips[np.argmin(np.abs(strips["o"]))]
                error = [
                    1e6 * z - 1e3 * float(row["z_ws"]),
                    1e3 * float(strips["N"] @ strips["x"] / strips["N"].sum()) - float(row["xcp"]),
                    100.0 * (1e3 * float(across["penetration"]) / float(row["approach"]) - 1.0),
                    100.0 * (1e-6 * float(contact.patches["p0"].max()) / float(row["pmax"]) - 1.0),
                ]
                if int(row["ncon"]) >= SURE:
                    error[3] = np.nan
                errors.append(error)
                print(f"  {row['case']:>3} {float(row['pitch']):6.3f} " + "".join(f"{e:10.3f}" for e in error))
            largest = np.nanmax(np.abs(errors), axis=0)
            print("  largest    " + "".join(f"{e:10.3f}" for e in largest))


if __name__ == "__main__":
    main()
