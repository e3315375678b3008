"""A scan laid on the unworn profile by the parts that do not wear: of a wheel the back of its flange and its outer
face, of a rail the field side and what overhangs below its head. Robust least squares of the distances along the
normal of the unworn curve: a part that wears after all counts little.
"""

from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.contact.profiles.placing import SIDE_SLOPE
from wrsim.contact.profiles.points import ProfilePoints
from wrsim.contact.profiles.profile import Array, Kind, Profile
from wrsim.errors import InputError

OUTER = (
    45e-3  # u from which a wheel's tread does not meet the rail [m]: half of a head, 36 mm, and the play of a wheelset
)
OVERHANG = np.radians(95.0)  # slope of the curve below a head, beyond its upright sides
ERROR = 20e-6  # distance from which a point counts less [m]: some scatter of an instrument
FAR, LARGEST_TILT = 15e-3, 0.1  # distance of a scan laid on its mark [m] and its tilt [rad], at most
FEWEST = 20  # points on the parts that do not wear
SHORTEST_BASE = 10e-3  # extent of these parts, without which they do not hold the turn [m]


def aligned(points: ProfilePoints, unworn: Profile) -> tuple[ProfilePoints, str]:
    """The upright points of a scan moved and turned onto an unworn profile, and a note of it. Raises InputError where
    too little of what does not wear was scanned."""
    curve = np.column_stack([unworn.u, unworn.w])
    normal = np.column_stack([-np.sin(unworn.angle), np.cos(unworn.angle)])
    keeps = _unworn_parts(unworn)
    tree = scipy.spatial.cKDTree(curve)
    x = np.array([*(_mark(curve, unworn.kind) - _mark(points.places, unworn.kind)), 0.0])
    reach = np.array([FAR, FAR, LARGEST_TILT])
    for _ in range(4):  # which points lie on these parts follows from where the scan lies
        near, node = tree.query(_moved(points, x).places)
        # beyond an end of the unworn curve there is nothing to be on
        chosen = np.flatnonzero(keeps[node] & (near < FAR) & (node > 0) & (node < len(curve) - 1))
        part = points[chosen]
        if len(part) < FEWEST or float(np.hypot(*np.ptp(part.places, axis=0))) < SHORTEST_BASE:
            message = f"{len(part)} points on the parts of {unworn.name} that do not wear; needed are {FEWEST}"
            raise InputError(f"{points.file}: cannot be aligned: {message}, over {1e3 * SHORTEST_BASE:g} mm")

        def distances(x: Array, part: ProfilePoints = part) -> Array:
            p = _moved(part, x).places
            i = tree.query(p)[1]
            return np.asarray(((p - curve[i]) * normal[i]).sum(axis=1))

        fit = scipy.optimize.least_squares(
            distances, x, loss="soft_l1", f_scale=ERROR, x_scale=(1e-3, 1e-3, 1e-2),
            bounds=(x - reach, x + reach),
        )  # fmt: skip
        x = fit.x
    u, w, turn = x
    residual = 1e3 * float(np.median(np.abs(distances(x))))
    moved = f"moved by {1e3 * u:.3f}, {1e3 * w:.3f} mm, turned by {1e3 * turn:.2f} mrad"
    return _moved(points, x), f"aligned on {unworn.name}: {moved}, residual {residual:.3f} mm of {len(part)} points"


def _mark(places: Array, kind: Kind) -> Array:
    """A point of a curve (n, 2) by which it is laid roughly: a flange's tip; the top and the field end of a rail."""
    if kind == "wheel":
        return places[int(np.argmin(places[:, 1]))]
    return places.max(axis=0)


def _moved(points: ProfilePoints, x: Array) -> ProfilePoints:
    turned = points.turned(float(x[2]))
    return replace(turned, u=turned.u + x[0], w=turned.w + x[1])


def _unworn_parts(unworn: Profile) -> NDArray[np.bool_]:
    """Nodes of a profile where it does not wear, (n,)."""
    u, slope = unworn.u, np.abs(unworn.angle)
    if unworn.kind == "wheel":
        return (u >= OUTER) | (u <= u[int(np.argmin(unworn.w))])
    return np.asarray((slope >= OVERHANG) | ((u > unworn.top[0]) & (slope >= SIDE_SLOPE)))
