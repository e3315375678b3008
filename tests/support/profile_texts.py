"""One profile in every layout of files of points: units, sides, directions, orders and origins."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim import InputError, Profile
from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.flange import flange_dimensions

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4}
DIGITS = {"mm": 5, "cm": 6, "m": 8, "in": 7}
S1002 = (28.0, 32.5, 10.794)  # Sh, Sd, qR of EN 13715 [mm]
BACK = 70.0
RIGHT = 5e-3  # distance of the points from the profile that was written [mm], some rounding and a spline
Points = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A file: label, suffix, text; stated: whether the unit is in it."""

    label: str
    suffix: str
    text: str
    kind: str


def nodes(profile: Profile, step: float = 0.4e-3) -> Points:
    """Points of a profile [mm], (n, 2)."""
    return 1e3 * profile.table(step)[0][:, :2]


def moved(points: Points, across: float, up: float = 0.0) -> Points:
    return points + np.array([across, up])


def lines(points: Points, unit: str, between: str = ",", comma: bool = False) -> str:
    digits = DIGITS[unit]
    rows = [between.join(f"{x:.{digits}f}" for x in row) for row in (points / UNITS[unit]).tolist()]
    text = "\n".join(rows) + "\n"
    return text.replace(".", ",") if comma else text


def counted(points: Points, unit: str) -> str:
    return "".join(f"{i}\t{line}\n" for i, line in enumerate(lines(points, unit, "\t").splitlines(), 1))


def simpack(points: Points, unit: str, kind: str) -> str:
    factor = f"{1e3 / UNITS[unit]:.12g}"
    head = f"header.begin\n  type = {int(kind == 'wheel')}\n  meas.pos.e = 0.01\nheader.end\nspline.begin\n"
    body = f"  comment = 'LM'  % left by somebody\n  units.len.f = {factor}\n  point.begin\n{lines(points, unit, ' ')}"
    return f"{head}{body}  point.end\nspline.end\n"


def miniprof(points: Points, head: str = "ProgramName=own\nXYPoints={count}\nColumnDef=X,Y\n") -> str:
    return head.format(count=len(points)) + "\n" + lines(points, "mm", " ")


def vampire(points: Points, kind: str) -> str:
    """Both sides, y from the middle of the track; wheels 1360 mm apart between their backs, gauge 1500 mm."""
    y = points[:, 0] + (680.0 + BACK if kind == "wheel" else 750.0)
    rows = "".join(f"{-a:.5f} {b:.5f} {a:.5f} {b:.5f}\n" for a, b in zip(y, points[:, 1], strict=True))
    head = "TREADDATUM EUROPEAN\nFLANGEBACK 1360" if kind == "wheel" else "GAUGEPOINT EUROPEAN\nGAUGE 1435"
    return f"{kind.upper()}PROFILE\nown numbers\n{head}\n{rows}"


COLUMNS: dict[str, Callable[[Points, str], str]] = {
    "header": lambda p, unit: f"y [{unit}],z [{unit}]\n" + lines(p, unit),
    "underscored": lambda p, unit: f"y_{unit};z_{unit}\n" + lines(p, unit, ";", comma=True),
    "row of units": lambda p, unit: f"y\tz\n{unit}\t{unit}\n" + lines(p, unit, "\t"),
    "words": lambda p, unit: f"Depot 7, 3.5.2026, 12 wheels\n401\n# unit: {unit}\n" + lines(p, unit, "   "),
    "decimal comma": lambda p, unit: f"y ({unit})\tz ({unit})\n" + lines(p, unit, "\t", comma=True),
    "decimal comma, blanks": lambda p, unit: f"% unit = {unit}\n" + lines(p, unit, " ", comma=True),
    "counter": lambda p, unit: f"No\ty ({unit})\tz ({unit})\n" + counted(p, unit),
    "NaN tail": lambda p, unit: f"y ({unit}),z ({unit})\n" + lines(p, unit) + "NaN,NaN\n" * 3,
    "bare": lambda p, unit: lines(p, unit, "\t"),
}
OLD_HEAD = 'MINIPROF 101\nown.whl\nWheel ID....:\n"32.50 28.00 10.79\n(Sd/Sh/qR)\n'
INSTRUMENTS: dict[str, Callable[[Points], str]] = {
    "MiniProf": miniprof,
    "MiniProf, tape line": lambda p: miniprof(p, "WheelDiameterTaperline=70.0000\nXYPoints={count}\nColumnDef=X,Y\n"),
    "MiniProf, old": lambda p: miniprof(p, OLD_HEAD),
    "MiniProf, miscounted": lambda p: miniprof(p, "XYPoints=7\nColumnDef=X,Y\n"),
}


def cases(profile: Profile, every: int = 1) -> Iterator[Case]:
    """Files of a profile, every n-th of them."""
    all_cases = list(_cases(profile))
    yield from all_cases[::every]


def _cases(profile: Profile) -> Iterator[Case]:
    kind, plain = profile.kind, nodes(profile)
    origins = (0.0, BACK) if kind == "wheel" else (0.0,)
    for side, heights, order, origin in product((1.0, -1.0), (1.0, -1.0), (1, -1), origins):
        points = (moved(plain, origin) * (side, heights))[::order]
        label = f"{kind}, x {side:+g}, heights {heights:+g}, order {order:+d}, origin {origin:g}"
        for name, text in COLUMNS.items():
            # units and orders vary together: every unit with every layout, not with every order
            for unit in UNITS if order > 0 else ("mm",):
                suffix = f".{kind}" if name == "bare" else ".txt"
                yield Case(f"{name} in {unit}, {label}", suffix, text(points, unit), kind)
        for name, written in INSTRUMENTS.items():
            yield Case(f"{name}, {label}", ".whl" if kind == "wheel" else ".ban", written(points), kind)
        if heights < 0.0:
            yield Case(f"SIMPACK, {label}", ".prw" if kind == "wheel" else ".prr", simpack(points, "m", kind), kind)
        if side > 0.0 and not origin:
            yield Case(f"VAMPIRE, {label}", ".whe" if kind == "wheel" else ".rai", vampire(points, kind), kind)


def outcome(case: Case, profile: Profile, folder: Path) -> str:
    """What becomes of a file: "right", "wrong" or the reason of a refusal."""
    path = folder / f"profile{case.suffix}"
    path.write_text(case.text, encoding="utf-8")
    try:
        points = read_points(path, case.kind).points  # type: ignore[arg-type]
    except InputError as error:
        return str(error)
    assert points is not None
    level = float(profile.at(profile.arclength_of(0.0))[1]) if case.kind == "wheel" else 0.0
    curve = np.column_stack([profile.u, profile.w - level])
    places = points.places if case.kind == "wheel" else points.places - (np.mean(points.u[[0, -1]]), points.w.max())
    if case.kind == "rail":  # files may have any origin
        ends = profile.table(0.4e-3)[0][[0, -1], 0]
        curve = curve - (np.mean(ends), curve[:, 1].max())
    apart = 1e3 * float(scipy.spatial.cKDTree(curve).query(places)[0].max())
    return "right" if apart < 0.1 + RIGHT else "wrong"  # nodes of the curve are 0.1 mm apart


def guide(wheel: Profile, rail: Profile) -> dict[str, tuple[str, str]]:
    """Files of docs/user/files_as_they_are.md by their headings: names and texts. wheel: new; rail: worn."""
    points, back, head = nodes(wheel), moved(nodes(wheel), BACK), nodes(rail)
    tape_line = "ProgramName=MiniProf\nWheelDiameterTaperline=70.0000\nXYPoints={count}\nColumnDef=X,Y\n"
    return {
        "MiniProf wheel": ("wheel.whl", miniprof(back * (1.0, -1.0), tape_line)),
        "MiniProf wheel, old head": ("old.whl", miniprof(back * (1.0, -1.0), OLD_HEAD)),
        "MiniProf rail": ("rail.ban", miniprof(head * (-1.0, 1.0), "XYPoints=300\nColumnDef=X,Y\n")),
        "SIMPACK": ("wheel.prw", simpack(points * (1.0, -1.0), "mm", "wheel")),
        "VAMPIRE": ("wheel.whe", vampire(points, "wheel")),
        "Two columns with units": ("wheel.csv", COLUMNS["header"](points, "mm")),
        "Inches": ("inches.csv", COLUMNS["header"](points, "in")),
        "Decimal commas": ("comma.txt", COLUMNS["decimal comma"](back, "mm")),
        "Words and a counter": ("depot.txt", "Depot 7, 3.5.2026, 12 wheels\n" + COLUMNS["counter"](points, "mm")),
        "Missing values at the end": ("tail.csv", COLUMNS["NaN tail"](points, "mm")),
        "A worn rail without a word": ("rail.rail", COLUMNS["bare"](head, "mm")),
        "Heights from elsewhere": ("high.csv", COLUMNS["header"](moved(points, 0.0, 0.3), "mm")),
        "Few digits": ("digits.csv", "".join(f"{u:.3f},{w:.3f}\n" for u, w in points)),
        "No unit": ("bare.csv", lines(points, "in")),
        "Another origin": ("moved.csv", COLUMNS["header"](moved(points, 30.0), "mm")),
    }


def measures(wheel: Profile) -> list[float]:
    """Height, thickness and steepness of a flange [mm]."""
    flange = flange_dimensions(wheel)
    return [1e3 * flange.height, 1e3 * flange.thickness, 1e3 * flange.steepness]
