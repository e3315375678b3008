"""A wheel with a rounded flat beside CONTACT: height, place, approach and pressure of every pose, by every model.

    python campaigns/out_of_round.py REFERENCE [--models strips,kik-piotrowski,half-space]

REFERENCE: folder with rounded_flat_d09.csv, 15 poses by CONTACT 25.2 (rolling radius 450 mm, rail crown 300 mm, 10 kN),
and flat_d09_depth.csv, the depth of the wheel at slices of its angle; not part of this repository.

The wheel is taken twice: as the table, which has every fourth place across of CONTACT's slices; and at all of these
places, by the closed form that the table follows within 6 nm: a rounded flat of 0.9 mm depth and 100.18 mm length cut
by a crown of 300 mm. The spline of CONTACT over the angle has its slices as coefficients: its values there are
(1, 4, 1)/6 of theirs, which both are given.

Height: of the wheelset where it carries the load [um]; place: of the normal force along the rail [mm]; approach: the
penetration across from CONTACT's reference point [%]; p0 [%], where CONTACT has fewer than 1200 elements in contact.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.settings import ContactSettings, Material
from wrsim.geometry.profile.out_of_round import Flat, RadiusTable
from wrsim.geometry.profile.sections import circle, cone

RADIUS, CROWN, LOAD = 0.45, 0.3, 1e4
DEPTH, LENGTH = 0.9e-3, 0.10018
STEEL = Material(2.0 * 82e9 * 1.28, 0.28)
SURE = 1200  # elements up to which CONTACT's largest pressure does not show the joints of slices
BRACKET = 12e-6  # about CONTACT's height [m]


def table(folder: Path, full: bool) -> RadiusTable:
    """The wheel at CONTACT's slices, at all places across or at those of the file."""
    angle, across, depth = np.loadtxt(folder / "flat_d09_depth.csv", delimiter=",", skiprows=1).T
    angle, across = np.unique(angle), 1e-3 * np.unique(across)
    depth = 1e-3 * depth.reshape(angle.size, across.size)
    if full:
        across = np.linspace(across[0], across[-1], 4 * (across.size - 1) - 1)
        flat = Flat.rounded(RADIUS, LENGTH, DEPTH, width=2.0 * np.sqrt(2.0 * CROWN * DEPTH))
        depth = flat.depth(angle, across, RADIUS)
    depth[1:-1] = (depth[:-2] + 4.0 * depth[1:-1] + depth[2:]) / 6.0
    return RadiusTable(angle, across, -depth)


def carrying(model: ContactModel, height: float, angle: float) -> tuple[float, Contact]:
    """How far the wheelset is below its nominal height under the load [m], and the contact; height: about where."""

    def at(z: float) -> Contact:
        return model.evaluate((0.0, 0.0, RADIUS - z), wheel_angle=angle)

    z = brentq(lambda z: float(at(z).force[2]) / LOAD - 1.0, height - BRACKET, height + BRACKET, xtol=1e-10)
    return z, at(z)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", type=Path)
    parser.add_argument("--models", default="strips,kik-piotrowski,half-space")
    given = parser.parse_args()
    with (given.reference / "rounded_flat_d09.csv").open() as file:
        rows = list(csv.DictReader(file))
    wheel, rail = cone("cylinder", "wheel", 0.0, -0.0302, 0.0302), circle("crown", "rail", CROWN, 0.05)
    for normal in given.models.split(","):
        for name, full in (("all places", True), ("table", False)):
            part = table(given.reference, full)
            settings = ContactSettings(normal=normal, tangential="none", wheel=STEEL, rail=STEEL, damping=0.0)
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
