"""Draw docs/figures/axes.svg, the figure that defines axes and signs: ``python docs/figures/make_axes.py [out.png]``.

S1002 on 60E1 from the shipped profile files; the inclination of the rails, cant, yaw and roll are exaggerated.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Polygon

from wrsim.contact.profiles.models import load_profile
from wrsim.plots.theme import INK, MM, QUIET, RAIL_FILL, STYLE, WHEEL_COLOUR, WHEEL_FILL, new_figure

HERE = Path(__file__).parent
MODELS = HERE.parents[1] / "models"
FORCE = "#B00020"
AXIS = "#00785A"
SIZE = 7.5


def by(x: float, y: float) -> np.ndarray:
    """Displacement on the page."""
    return np.array([x, y])


def arrow(axes: Axes, start, end, colour=INK, width=1.0, style="-|>", **options) -> None:
    """Arrow between two points in data units."""
    patch = FancyArrowPatch(
        start, end, arrowstyle=f"{style},head_length=3.2,head_width=1.5" if "|>" in style else style,
        color=colour, linewidth=width, shrinkA=0, shrinkB=0, zorder=6, **options,
    )  # fmt: skip
    axes.add_patch(patch)


def say(axes: Axes, position, text: str, colour=INK, **options) -> None:
    """Text in data units."""
    axes.text(
        *position, text, **({"color": colour, "fontsize": SIZE, "ha": "center", "va": "center", "zorder": 7} | options)
    )


def measure(axes: Axes, start, end, text: str, side=(0.0, 0.0), **options) -> None:
    """Dimension line with words at its middle, moved by ``side``."""
    arrow(axes, start, end, QUIET, 0.7, "<|-|>")
    middle = 0.5 * (np.asarray(start) + np.asarray(end)) + np.asarray(side)
    say(axes, middle, text, QUIET, **options)


def turn(axes: Axes, centre, radius: float, first: float, last: float, colour=AXIS) -> None:
    """Arc with an arrow head at its last angle, degrees counter-clockwise from the page's right."""
    angles = np.radians(np.linspace(first, last, 60))
    x, y = centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)
    axes.plot(x, y, color=colour, linewidth=0.9, zorder=6)
    arrow(axes, (x[-3], y[-3]), (x[-1], y[-1]), colour, 0.9)


def into_page(axes: Axes, centre, radius: float, colour=AXIS) -> None:
    """A cross in a circle: an axis that points away from the reader."""
    axes.add_patch(Circle(centre, radius, facecolor="white", edgecolor=colour, linewidth=0.9, zorder=6))
    d = radius * np.sqrt(0.5)
    for s in (-1, 1):
        axes.plot(
            [centre[0] - d, centre[0] + d],
            [centre[1] - s * d, centre[1] + s * d],
            color=colour,
            linewidth=0.9,
            zorder=7,
        )


def panel(figure, left: float, top: float, width: float, height: float, title: str, reach) -> Axes:
    """Axes in mm from the upper left corner, equal scales, data limits (x0, x1) and y0; titled."""
    across, down = figure.get_size_inches() / MM
    axes = figure.add_axes((left / across, 1 - (top + height) / down, width / across, height / down))
    x0, x1, y0 = reach
    axes.set(xlim=(x0, x1), ylim=(y0, y0 + (x1 - x0) * height / width))
    axes.set_axis_off()
    figure.text(left / across, 1 - (top - 1.0) / down, title, fontsize=8.5, fontweight="bold", va="bottom", color=INK)
    return axes


def outline(name: str) -> np.ndarray:
    """(n, 2) points of a profile in mm."""
    profile = load_profile(MODELS / name)
    arc = np.linspace(0.0, profile.length, 300)
    return 1e3 * np.column_stack(profile.at(arc))


WHEEL, RAIL = outline("wheels/S1002.toml"), outline("rails/60E1.toml")
RAIL = np.vstack((RAIL[0] + by(-0.8, -24.0), RAIL, RAIL[-1] + by(0.8, -24.0)))


def turned(points: np.ndarray, degrees: float) -> np.ndarray:
    """Points turned counter-clockwise about the origin."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s], [-s, c]])


def body(axes: Axes, points: np.ndarray, fill: str, **options) -> None:
    """Closed solid."""
    axes.add_patch(Polygon(points, **({"facecolor": fill, "edgecolor": INK, "linewidth": 0.8, "zorder": 3} | options)))


def wheel_body(rim: float = 62.0) -> np.ndarray:
    """Section of a wheel in (u, w): the profile closed above by a rim."""
    return np.vstack((WHEEL, [WHEEL[-1, 0], rim], [WHEEL[0, 0], rim]))


def behind(figure, left, top, width, height) -> None:
    """Wheelset on the track, seen from behind."""
    a = panel(
        figure, left, top, width, height,
        "a  Track and wheelset, seen from behind (the middle is cut out; x and t point away)", (-225, 225, -62),
    )  # fmt: skip
    centre = 128.0  # of the rails on the page; the middle of the track is cut out
    lean = 4.0
    for side, wheel in ((-1, "left"), (1, "right")):
        rail = turned(RAIL, lean) * [side, 1] + [side * centre, 0]
        body(a, rail, RAIL_FILL)
        tread = turned(wheel_body(70.0) - [8.0, 0.0], 0.0) * [side, 1] + [side * centre, 1.2]
        body(a, tread, WHEEL_FILL)
        say(a, (side * 203, 52), f"{wheel} wheel", WHEEL_COLOUR[wheel], fontweight="bold")
        hub = [
            [side * (centre - 30), 70],
            [side * (centre + 14), 70],
            [side * (centre + 14), 108],
            [side * (centre - 30), 108],
        ]
        body(a, np.array(hub), WHEEL_FILL)
        tape = side * (centre - 8.0)
        a.plot([tape, tape], [1.2, 122], color=QUIET, linewidth=0.6, linestyle=(0, (6, 2, 1, 2)), zorder=5)
        top = turned(RAIL, lean)
        crown = top[np.argmax(top[:, 1])]
        gauge = top[: len(top) // 2]
        gauge_point = np.interp(crown[1] - 14.0, gauge[:, 1], gauge[:, 0])
        a.plot([side * (centre + gauge_point)] * 2, [crown[1] - 14, -52], color=QUIET, linewidth=0.5, zorder=2)
        a.plot(side * (centre + gauge_point), crown[1] - 14, "o", color=INK, markersize=2.2, zorder=8)
        gauge_x = centre + gauge_point
    for x in (-1, 1):  # axle with a cut
        body(a, np.array([[x * 98, 82], [x * 30, 82], [x * 26, 89], [x * 32, 96], [x * 98, 96]]), WHEEL_FILL)
    measure(a, (-gauge_x, -47), (gauge_x, -47), "gauge, 14 mm below the rail tops", (0, -6.5))
    measure(a, (-(centre - 8), 120), (centre - 8, 120), "$H$: distance of the two wheel profile origins", (0, 6))
    measure(a, (centre + 6, 2.4), (centre + 6, 89), "$R$", (6, 0))
    a.plot([centre - 12, centre + 10], [89, 89], color=QUIET, linewidth=0.5, zorder=5)
    # track frame
    into_page(a, (0, 0), 3.2)
    arrow(a, (-3.2, 0), (-44, 0), AXIS)
    arrow(a, (0, 3.2), (0, 38), AXIS)
    say(a, (-31, 6), "$n$ (left)", AXIS)
    say(a, (13, 32), "$b$ (up)", AXIS)
    say(a, (7, -4), "$t$", AXIS)
    say(
        a,
        (0, -24),
        "track frame: midway\nbetween the gauge points,\nat the height of\nthe rail tops",
        AXIS,
        fontsize=6.5,
    )
    # wheelset
    into_page(a, (0, 89), 3.2, INK)
    arrow(a, (-3.2, 89), (-24, 89), INK)
    arrow(a, (0, 92.2), (0, 112), INK)
    say(a, (-22, 84), "$y$")
    say(a, (-6, 110), "$z$")
    say(a, (7, 82), "$x$")
    turn(a, (0, 89), 16, 150, 30, FORCE)
    say(a, (46, 106), "roll: left wheel up", FORCE)
    say(a, (0, 66), "lateral shift:\nto the left", FORCE)
    arrow(a, (22, 56), (-22, 56), FORCE, 0.9)
    # outward axes of the rails
    for side in (-1, 1):
        start = side * (centre + 42)
        arrow(a, (start, -14), (start + side * 30, -14), AXIS)
        say(a, (start + side * 34, -20), "$o$, $u$ (outward)", AXIS)


def above(figure, left, top, width, height) -> None:
    """Track and wheelset from above."""
    a = panel(figure, left, top, width, height, "b  From above", (-1.42, 1.58, -1.25))
    radius = 5.0
    angle = np.linspace(-0.32, 0.46, 80)
    # left curve: the centre of the curve lies to the left of the page
    for offset, line, width_ in ((0.0, (0, (6, 2, 1, 2)), 0.6), (0.5, "-", 1.8), (-0.5, "-", 1.8)):
        r = radius - offset
        x, y = r * np.cos(angle) - radius, r * np.sin(angle)
        a.plot(x, y, color=QUIET if offset == 0 else "#9aa3ad", linestyle=line, linewidth=width_, zorder=1)
    yaw = 9.0
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))

    def on_page(u, v):
        """Wheelset axes (forward u, left v) to the page, shifted to the left by the lateral shift."""
        return np.array([-v * c - u * s, u * c - v * s]) + by(-0.09, 0.0)

    for v in (0.5, -0.5):
        corners = [on_page(d, v + e) for d, e in ((-0.24, -0.05), (0.24, -0.05), (0.24, 0.05), (-0.24, 0.05))]
        body(a, np.array(corners), WHEEL_FILL)
    body(
        a,
        np.array([on_page(-0.035, 0.62), on_page(0.035, 0.62), on_page(0.035, -0.62), on_page(-0.035, -0.62)]),
        WHEEL_FILL,
        zorder=2,
    )
    arrow(a, (0, 0), (0, 1.05), AXIS)
    say(a, (0.0, 1.16), "$t$", AXIS)
    arrow(a, (0, 0), (-0.95, 0), AXIS)
    say(a, (-1.05, 0.0), "$n$", AXIS)
    arrow(a, on_page(0, 0), on_page(0.92, 0), INK)
    say(a, on_page(1.0, 0.02), "$x$")
    arrow(a, on_page(0, 0), on_page(0, 0.95), INK)
    say(a, on_page(0, 1.04), "$y$")
    a.plot([-0.09, -0.09], [0, 0.8], color=FORCE, linewidth=0.5, linestyle=(0, (4, 2)), zorder=5)
    turn(a, on_page(0, 0), 0.72, 90, 98.3, FORCE)
    say(a, (-0.16, 0.84), r"$\psi$", FORCE)
    a.annotate(
        "yaw = angle of attack:\nturned to the left\nagainst the tangent $t$", (-0.17, 0.70), (1.06, 0.72), color=FORCE,
        fontsize=SIZE, ha="center", va="center", arrowprops={"arrowstyle": "-", "color": FORCE, "lw": 0.5},
    )  # fmt: skip
    arrow(a, (0, -0.14), (-0.09, -0.14), FORCE, 0.9, "-|>")
    a.plot([0, 0], [0, -0.2], color=FORCE, linewidth=0.5)
    a.plot([-0.09, -0.09], [0, -0.2], color=FORCE, linewidth=0.5)
    a.annotate(
        "lateral shift:\nto the left", (-0.045, -0.15), (1.0, -0.42), color=FORCE, fontsize=SIZE, ha="center",
        va="center", arrowprops={"arrowstyle": "-", "color": FORCE, "lw": 0.5},
    )  # fmt: skip
    say(
        a, (1.02, -0.98), "curvature: to the left\ncant: right rail higher", FORCE,
    )  # fmt: skip
    arrow(a, (-1.22, -1.1), (-1.22, -0.7), INK)
    say(a, (-1.22, -0.62), "rolling", INK, fontsize=6.8)


def rail_frame(figure, left, top, width, height) -> None:
    """Rail profile and rail axes."""
    a = panel(figure, left, top, width, height, "c  Rail profile (right; the left is its mirror image)", (-84, 84, -68))
    lean = 8.0
    body(a, turned(RAIL, lean), RAIL_FILL)
    a.plot(0, 0, "o", color=INK, markersize=2.6, zorder=8)
    arrow(a, (0, 0), (66, 0), AXIS)
    arrow(a, (0, 0), (0, 40), AXIS)
    say(a, (73, 0), "$o$", AXIS)
    say(a, (-1, 46), "$b$", AXIS)
    for direction, name, off in (((58.0, 0.0), "$u$", (5, 2)), ((0.0, 36.0), "$f$", (-4, 4))):
        end = turned(np.array([direction]), lean)[0]
        arrow(a, (0, 0), end, INK)
        say(a, end + off, name)
    turn(a, (0, 0), 29, 90, 90 + lean, FORCE)
    say(a, (-46, 34), "inclination 1:20, 1:40:\ntop towards the\ntrack centre", FORCE)
    top = turned(RAIL, lean)
    crown = top[np.argmax(top[:, 1])]
    gauge = top[: len(top) // 2]
    gauge_point = np.interp(crown[1] - 14.0, gauge[:, 1], gauge[:, 0])
    a.plot(gauge_point, crown[1] - 14, "o", color=INK, markersize=2.6, zorder=8)
    a.plot([gauge_point - 16, crown[0]], [crown[1]] * 2, color=QUIET, linewidth=0.5, zorder=5)
    a.plot([gauge_point - 16, gauge_point], [crown[1] - 14] * 2, color=QUIET, linewidth=0.5, zorder=5)
    measure(a, (gauge_point - 12, crown[1]), (gauge_point - 12, crown[1] - 14), "14 mm", (-15, 0))
    say(a, (gauge_point - 22, crown[1] - 20), "gauge point", QUIET)
    say(a, (-11, -30), "gauge side\n$u<0$", QUIET)
    say(a, (25, -30), "field side\n$u>0$", QUIET)
    say(a, (50, 34), "$o$ is $n$ on the left\nand $-n$ on the right", AXIS, fontsize=7)


def wheel_frame(figure, left, top, width, height) -> None:
    """Wheel profile."""
    a = panel(figure, left, top, width, height, "d  Wheel profile (right wheel)", (-112, 92, -50))
    body(a, wheel_body(34.0), WHEEL_FILL)
    axle = 55.0
    a.plot([-90, 76], [axle, axle], color=QUIET, linewidth=0.7, linestyle=(0, (6, 2, 1, 2)))
    say(a, (-86, axle + 5), "axle", QUIET)
    a.plot([0, 0], [-14, axle], color=QUIET, linewidth=0.7, linestyle=(0, (6, 2, 1, 2)), zorder=5)
    a.plot(0, 0, "o", color=INK, markersize=2.6, zorder=8)
    say(a, (6, -12), "tape circle:\n$u=0$, $f=-R$", ha="left")
    a.plot(0, axle, "o", color=INK, markersize=2.6, zorder=8)
    arrow(a, (0, axle), (52, axle), AXIS)
    say(a, (62, axle + 6), "$u$ (outward)", AXIS)
    arrow(a, (0, axle), (0, axle + 22), AXIS)
    say(a, (6, axle + 19), "$f$", AXIS)
    say(a, (-42, axle + 11), "wheel profile\norigin", INK)
    arrow(a, (-22, axle + 9), (-3, axle + 1.5), QUIET, 0.5, "-")
    measure(a, (18, axle), (18, 0.6), "$R$", (6, 20))
    measure(a, (-70, -36), (0, -36), "70 mm (S1002)", (0, -6))
    a.plot([-70, -70], [-16, -40], color=QUIET, linewidth=0.5)
    a.plot([0, 0], [-26, -40], color=QUIET, linewidth=0.5)
    say(a, (-92, 14), "flange\nback", QUIET)
    say(a, (-56, -6), "flange\n$u<0$", QUIET)
    say(a, (40, 22), "field side\n$u>0$", QUIET)


def contact(figure, left, top, width, height) -> None:
    """Contact of the right wheel in the flange root, with forces."""
    a = panel(figure, left, top, width, height, "e  Contact in the flange root (right wheel)", (-58, 46, -34))
    rail = turned(RAIL, np.degrees(np.arctan(1 / 40)))
    body(a, rail, RAIL_FILL)
    wheel = wheel_body(34.0) + by(2.6, 0.0)
    # lower the wheel on the rail: smallest vertical distance over the crown
    head = rail[(rail[:, 0] > -35.3) & (rail[:, 0] < 35)]
    near = WHEEL + by(2.6, 0.0)
    near = near[(near[:, 0] > head[0, 0]) & (near[:, 0] < head[-1, 0])]
    gap = near[:, 1] - np.interp(near[:, 0], head[:, 0], head[:, 1])
    body(a, wheel - [0, gap.min()], WHEEL_FILL, alpha=0.85)
    k = int(np.argmin(gap))
    point = near[k] - [0, gap.min()]
    tangent = near[k + 6] - near[k - 6]
    tangent = tangent / np.hypot(*tangent)
    normal = np.array([-tangent[1], tangent[0]])
    a.plot(*point, "o", color=INK, markersize=3, zorder=9)
    a.plot(*np.array([point - 26 * tangent, point + 40 * tangent]).T, color=AXIS, linewidth=0.7, zorder=5)
    arrow(a, point + 30 * tangent, point + 40 * tangent, AXIS)
    say(a, point + 43.5 * tangent + by(0, -1), "$s$", AXIS)
    arrow(a, point, point + 21 * normal, AXIS)
    say(a, point + 24.5 * normal, "normal, rail to wheel", AXIS, ha="left")
    flat = point + 32 * tangent
    a.plot([point[0], point[0] + 30], [point[1]] * 2, color=QUIET, linewidth=0.6, zorder=5)
    slope = np.degrees(np.arctan2(tangent[1], tangent[0]))
    a.add_patch(Arc(point, 42, 42, theta1=0, theta2=slope, color=FORCE, linewidth=0.9, zorder=6))
    say(
        a,
        point + 24.5 * np.array([np.cos(np.radians(0.5 * slope)), np.sin(np.radians(0.5 * slope))]),
        r"$\gamma$",
        FORCE,
    )
    say(a, (flat[0] + 2, point[1] - 9.5), "contact angle: positive\nwhen it climbs the flange", FORCE, fontsize=6.8)
    arrow(a, point, point + by(17, 0), FORCE, 1.4)
    arrow(a, point, point + by(0, -17), FORCE, 1.4)
    say(a, point + by(14.5, -3.4), "$Y$", FORCE, fontsize=9)
    say(a, point + by(-3.5, -14.5), "$Q$", FORCE, fontsize=9)
    say(
        a, (6, -27.5), "$Y$, $Q$: forces of the wheel on the rail.\n$F_y$ (along $s$), $F_x$ (along $t$, away\n"
        "from the reader): creep forces on the wheel.", FORCE, fontsize=6.8,
    )  # fmt: skip
    say(a, (18, 22), "wheel", QUIET)
    say(a, (28, -16), "rail", QUIET)


def main(target: Path) -> None:
    """Draw all panels."""
    with mpl.rc_context(STYLE | {"svg.hashsalt": "wrsim", "svg.fonttype": "path"}):
        figure = new_figure(190, 238, constrained=False)
        behind(figure, 4, 9, 182, 78)
        above(figure, 4, 97, 82, 68)
        rail_frame(figure, 94, 97, 92, 68)
        wheel_frame(figure, 4, 175, 90, 58)
        contact(figure, 98, 175, 88, 58)
        figure.text(0.98, 0.012, "Red: quantities and their positive direction", ha="right", color=FORCE, fontsize=7)
        options = {"metadata": {"Date": None}} if target.suffix == ".svg" else {"dpi": 200}
        figure.savefig(target, **options)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "axes.svg")
