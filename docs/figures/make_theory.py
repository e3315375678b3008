"""Draw docs/figures/theory_*.svg, figures of the theory chapters: ``python docs/figures/make_theory.py [NAME ...]``.

Curves with scales are computed, most of them by wrsim's own models; sketches exaggerate angles, waves and gaps.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from cycler import cycler
from make_axes import AXIS, FORCE, MODELS, RAIL, WHEEL, arrow, body, by, into_page, panel, say, turn, turned, wheel_body
from matplotlib import patches
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

import wrsim
from wrsim import Arc, Friction, Straight, Track, Transition, load_profile
from wrsim.contact.half_space.strips import solve_into
from wrsim.contact.model import ContactModel
from wrsim.plots import new_figure, save, style
from wrsim.plots.theme import INK, MM, QUIET, RAIL_FILL, SERIES_COLOURS, WHEEL_FILL, mm_axes, pressure_map
from wrsim.track.forms import FORMS, LABEL
from wrsim.vehicle.axle import Axle, Disc, whirl
from wrsim.vehicle.flexible import BeamModes

BLUE, VERMILION = SERIES_COLOURS[:2]
WHEEL_LOOK = {"facecolor": WHEEL_FILL, "edgecolor": INK, "linewidth": 0.8, "zorder": 4}
SPAN = (QUIET, 0.7, "<|-|>")
DASH = {"colour": QUIET, "width": 0.6, "linestyle": (0, (4, 2))}


def chart(figure: Figure, left: float, width: float, title: str, x: tuple, y: tuple, top=12.0, height=43.0) -> Axes:
    """Axes with scales, sizes in mm from the upper left corner, titled as panels are; x, y: label and limits."""
    axes = mm_axes(figure, left, top, width, height)
    axes.set(xlabel=x[0], xlim=x[1:], ylabel=y[0], ylim=y[1:])
    place = (left - 11) * MM / figure.get_figwidth(), 1 - (top - 4) * MM / figure.get_figheight()
    figure.text(*place, title, fontsize=8.5, fontweight="bold", color=INK, va="bottom")
    return axes


def line(axes: Axes, *points: ArrayLike, colour: str = INK, width: float = 0.9, **options) -> None:
    """Line through points."""
    axes.plot(*np.array(points, float).T, **({"color": colour, "linewidth": width} | options))


def texts(axes: Axes, *entries: tuple, colour: str = INK) -> None:
    """Texts: x, y, text, and a colour where it is another."""
    for x, y, text, *own_colour in entries:
        say(axes, (x, y), text, *own_colour or [colour])


def spring(axes: Axes, x: float, y: float, dx: float, dy: float, colour: str = INK) -> None:
    """Zigzag from a point."""
    along = np.array([0, 0.2, 0.26, 0.38, 0.5, 0.62, 0.74, 0.8, 1.0])[:, None]
    off = np.array([0, 0, 1, -1, 1, -1, 1, 0, 0])[:, None] * [-dy, dx] / np.hypot(dx, dy)
    line(axes, *(along * [dx, dy] + off + [x, y]), colour=colour, zorder=5)


def damper(axes: Axes, x: float, y: float, dx: float, dy: float, colour: str = INK) -> None:
    """Cylinder and piston from a point."""
    d, side = by(dx, dy), np.array([-dy, dx]) / np.hypot(dx, dy)
    cup = (0.7 * d + side, 0.36 * d + side, 0.36 * d - side, 0.7 * d - side)
    for points in ((0 * d, 0.36 * d), cup, (0.54 * d + 0.7 * side, 0.54 * d - 0.7 * side), (0.54 * d, d)):
        line(axes, *np.add(points, [x, y]), colour=colour, zorder=5)


def box(axes: Axes, left: float, low: float, right: float, high: float, fill: str = WHEEL_FILL, **options) -> None:
    """Rectangle."""
    body(axes, np.array([(left, low), (right, low), (right, high), (left, high)]), fill, **options)


def solved(yaw: float = 1.5e-3, lateral: float = 2e-3, friction: float | Friction = 0.35, **options) -> ContactModel:
    """S1002 on 60E1, a left wheel under 60 kN."""
    tread, rail = load_profile(MODELS / "wheels/S1002.toml"), load_profile(MODELS / "rails/60E1.toml").inclined(1 / 40)
    model = wrsim.contact_model(tread, rail, 0.46, wrsim.ContactSettings(**options), friction=friction)
    wrsim.solve_poses(model, [wrsim.Pose("pose", lateral=lateral, yaw=yaw, load=60e3)])
    return model


def track(figure: Figure) -> None:
    """Section of the track; curvature and cant."""
    a = panel(figure, 4, 9, 84, 52, "a  Section from behind, right rail higher", (-46, 46, -29))
    n, b = turned(np.array([[-1.0, 0.0], [0.0, 1.0]]), 14.0)
    for side, end in ((1, 26 * n), (-1, -26 * n)):
        body(a, 0.25 * RAIL @ np.array([side * n, b]) + end, RAIL_FILL)
        line(a, end - 15 * b, end, (41, end[1]), **DASH)
    line(a, 36 * n, -36 * n, colour=QUIET, width=0.6)
    line(a, (-38, 0), (38, 0), **DASH)
    for end, colour in ((n, AXIS), (b, AXIS), (by(-1, 0), INK), (by(0, 1), INK)):
        arrow(a, (0, 0), 15 * end, colour)
    into_page(a, (0, 0), 1.3)
    turn(a, (0, 0), 8, 0, 14, FORCE)
    arrow(a, 26 * n - 13 * b, -26 * n - 13 * b, *SPAN)
    arrow(a, (39, 26 * n[1]), (39, -26 * n[1]), *SPAN)
    texts(a, (-9.5, -5.5, r"$\mathbf{n}$", AXIS), (-4, 17.5, r"$\mathbf{b}$", AXIS), (2, -4.2, r"$\mathbf{t}$", AXIS),
          (-17, 2.5, r"$\mathbf{h}$"), (1.5, 17.5, r"$\mathbf{v}$"), (12.5, 1.4, r"$-\phi$", FORCE),
          (4, -15.5, "$c_0$", QUIET), (41, -3, "$c$", QUIET))  # fmt: skip
    path = [Straight(30), Transition(60), Arc(60, 300, cant=0.15), Transition(60, "bloss"), Straight(30)]
    laid, s = Track.build(path), np.linspace(0, 240, 961)
    a = chart(figure, 109, 66, "b  Transitions", ("distance $s$ [m]", 0, 240), (r"curvature $\kappa$ [1/km]", 0, 4.4))
    a.plot(s, 1e3 * laid.curvature(s), color=BLUE)
    texts(a, (60, 3.9, "clothoid"), (180, 3.9, "Bloss"), colour=QUIET)
    cant_axes = a.twinx()
    cant_axes.plot(s, 1e3 * laid.cant(s), color=VERMILION, linestyle=(0, (4, 2)))
    cant_axes.set(ylim=(0, 220), ylabel="cant $c$ [mm], dashed")
    cant_axes.grid(False)


def transitions(figure: Figure) -> None:
    """Curvature of the seven forms; how far they lie from the clothoid."""
    s = np.linspace(0, 100, 401)
    a = chart(figure, 14, 78, "a  Curvature from a straight to 300 m", ("distance [m]", 0, 100), ("[1/km]", -0.3, 3.6))
    b = chart(
        figure, 112, 62, "b  Plan beside the clothoid", ("distance [m]", 0, 100), ("to the outside [m]", -0.05, 1.15)
    )
    for form, colour in zip(FORMS, (INK, *SERIES_COLOURS), strict=False):
        ramp = Transition(100, form, centre_of_gravity_height=1.8 if form == "viennese" else None)
        laid = Track.build([ramp, Arc(50, 300, cant=0.1)])
        look = "--" if form == "cubic parabola" else "-"
        a.plot(s, 1e3 * laid.curvature(s), look, color=colour, label=LABEL.get(form, form), linewidth=1.1)
        if form == "clothoid":
            base = laid.centre_line.position(s)
        b.plot(s, (base - laid.centre_line.position(s))[:, 1], look, color=colour, linewidth=1.1)
    a.legend(fontsize=6.5, loc="upper left")


def surfaces(figure: Figure) -> None:
    """A profile and the surface of revolution."""
    a = panel(figure, 4, 9, 88, 52, "a  Profile of a right wheel", (-84, 74, -46))
    body(a, wheel_body(40.0), WHEEL_FILL)
    k = int(np.argmax(np.hypot(*(WHEEL - WHEEL[-1]).T) < 100))
    tangent = (WHEEL[k + 2] - WHEEL[k - 2]) / np.hypot(*(WHEEL[k + 2] - WHEEL[k - 2]))
    for start, end, colour in (((0, 0), (58, 0), AXIS), ((0, 0), (0, 26), AXIS), (WHEEL[k], 24 * tangent, FORCE)):
        arrow(a, start, np.add(start, end), colour)
    a.plot(*WHEEL[k], "o", color=INK, markersize=3, zorder=8)
    texts(a, (63, 0, "$u$", AXIS), (5, 25, "$w$", AXIS), (36, 28, "material", QUIET), (-56, 14, "flange", QUIET),
        (WHEEL[k, 0] + 26, WHEEL[k, 1] - 8, "$(u(L), w(L))$"), (-2, -10, "$L$ rises outward", FORCE))  # fmt: skip
    a = panel(figure, 98, 9, 88, 52, "b  Wheel as surface of revolution", (-104, 104, -62))
    shape = np.column_stack((1.1 * WHEEL[:, 0], 38 - 0.75 * WHEEL[:, 1]))
    for u, rho in shape[:: len(shape) // 40]:
        a.add_patch(patches.Arc((u, 0), 0.4 * rho, 2 * rho, theta1=90, theta2=270, color="#b9ae94", linewidth=0.5))
    a.add_patch(patches.Ellipse((shape[-1, 0], 0), 0.4 * shape[-1, 1], 2 * shape[-1, 1], **WHEEL_LOOK))
    for side in (-1, 1):
        line(a, *(shape * [1, side]), zorder=3)
    line(a, (-102, 0), (102, 0), colour=QUIET, width=0.7, linestyle="-.", zorder=5)
    for i in (int(np.argmax(shape[:, 0] > -41)), int(np.argmax(shape[:, 0] > 0))):
        arrow(a, (shape[i, 0], 0), shape[i] * [1, -1], *SPAN)
    texts(a, (-96, 5, "axle", QUIET), (5, -18, "$R$"), (-33, -18, r"$\rho(L)$"), (94, -7, "$u$", AXIS))
    arrow(a, (shape[-1, 0], 0), (98, 0), AXIS)


def search(figure: Figure) -> None:
    """Contact locus; two lobes."""
    profile = load_profile(MODELS / "wheels/S1002.toml")
    u, w = profile.at(np.linspace(0.012, profile.length - 0.004, 800))
    u, w = u[u > -0.0475], w[u > -0.0475]  # from the flank of the flange outward
    a = chart(figure, 14, 82, "a  Contact locus from above", ("$u$ [mm]", -50, 60), ("ahead of the axle [mm]", -4, 40))
    for lag, look in ((0.0, "-"), (0.01, "--"), (0.03, ":")):  # e_t = -lag
        ahead = (0.46 - w) * np.gradient(w, u) * lag - u * lag
        a.plot(1e3 * u, 1e3 * ahead, look, color=BLUE, label=f"$-e_t$ = {lag:g}")
    a.legend()
    s = np.linspace(-10, 16, 521)
    d = 62 * np.exp(-(((s + 3.4) / 3.6) ** 2)) + 44 * np.exp(-(((s - 6) / 4) ** 2)) - 12
    a = chart(figure, 116, 68, "b  Two lobes", ("curved axis [mm]", -10, 16), ("penetration", -12, 62))
    a.fill_between(s, d, 0, where=d > 0, color=BLUE, alpha=0.2)
    a.plot(s, d, color=INK)
    a.set(yticks=[0])
    top, pit = d[s > 3].max(), d[np.abs(s - 2) < 2].min()
    low = s[d == pit][0]
    line(a, (low - 3, 0.45 * top), (16, 0.45 * top), **DASH)
    arrow(a, (6, 0), (6, top), *SPAN)
    arrow(a, (low, 0), (low, pit), *SPAN)
    texts(a, (13.2, 0.45 * top + 3, r"$(1-\varepsilon)\,\delta$", QUIET), (6.8, 24, r"$\delta$"),
          (low - 1, 6, r"$\sigma$"), (-3.4, 56, "deeper lobe", QUIET), (9, 36, "shallower lobe", QUIET))  # fmt: skip


def half_space(figure: Figure) -> None:
    """Rows on the curved patch, pressures of the elements."""
    patch = solve_into(solved(8e-3, 6.4e-3, normal="half-space")).patches[0]
    peak, grid = patch.p.max(axis=1), patch.grid
    rows = np.flatnonzero(peak)
    x, y = 1e3 * grid.centre[rows].mean(axis=0)
    a = chart(figure, 14, 62, "a  Rows on the curved axis", ("$o$ [mm]", x - 6, x + 6), ("$b$ [mm]", y - 3.2, y + 5.1))
    a.plot(*turned(RAIL, np.degrees(np.arctan(1 / 40))).T, color=QUIET, linewidth=0.8)
    a.plot(*(1e3 * grid.centre[rows].T), ".", color=INK, markersize=2.5)
    for i in rows[:: max(len(rows) // 24, 1)]:
        foot = 1e3 * grid.centre[i]
        line(a, foot, foot + 3.5 * peak[i] / peak.max() * grid.normal[i], colour=VERMILION)
    patch = solve_into(solved(normal="half-space")).patches[0]
    x, s, p = 1e3 * patch.grid.x, 1e3 * patch.grid.s, np.where(patch.p > 0, 1e-6 * patch.p, np.nan)
    a = chart(figure, 100, 76, "b  Elements of a patch", ("$x$ [mm]", -8, 8), ("$s$ [mm]", -4, 9))
    drawn = a.pcolormesh(x, s, p, cmap=pressure_map(), edgecolors="white", linewidth=0.04, rasterized=True)
    a.contour(x, s, patch.state == 1, levels=[0.5], colors=[BLUE], linewidths=1.2)
    figure.colorbar(drawn, ax=a, pad=0.03, fraction=0.06).set_label("pressure $p$ [MPa]")


def creep_forces(figure: Figure) -> None:
    """Strips and cells in adhesion and slip, tractions along a strip."""
    model = solved(tangential="fastsim")
    lobe, shear = model.arrays.patches[0], float(model.arrays.model.G)
    half, across = 0.5 * lobe.length, 2 * lobe.area / np.pi / lobe.length
    soft = 8 * half / (3 * shear) / np.array([4.12, 3.67])  # Kalker's coefficients of a circle
    turning = np.pi * half * np.sqrt(half / across) / (4 * 1.47 * shear)
    a, longest = chart(figure, 14, 72, "a  Strips, from above", ("$x$ [mm]", -8, 9), ("$s$ [mm]", -4.5, 10)), []
    for strip in model.arrays.strips[0, : lobe.n_strips]:
        q, cells, dx = np.zeros(2), [], strip["a"] / 10
        low, high = 1e3 * (strip["s"] + strip["ds"] * by(-0.5, 0.5))
        for place in strip["a"] * np.linspace(0.95, -0.95, 20):
            bound = strip["mu"] * strip["p"] * np.sqrt(1 - (place / strip["a"]) ** 2)
            q = q - dx * (np.array([strip["xi"], strip["eta"]]) / soft + [0, strip["phi"] * place / turning])
            fill, q = "#f6cdb4" if np.hypot(*q) > bound else "#c6dff0", q * min(1.0, bound / np.hypot(*q))
            x_mm = 1e3 * (strip["x"] + place)
            cells.append((x_mm, 1e-6 * bound, 1e-6 * np.hypot(*q)))
            box(a, x_mm - 500 * dx, low, x_mm + 500 * dx, high, fill, linewidth=0.2, edgecolor="w", zorder=1)
            if len(cells) % 5 == 3:
                arrow(a, (x_mm, 1e3 * strip["s"]), (x_mm, 1e3 * strip["s"]) + 5e-9 * q, INK, 0.6)
        longest = max(longest, cells)
    arrow(a, (2.4, 9.2), (7, 9.2), AXIS)
    texts(a, (0.4, 9.2, "rolling", AXIS), (-5, -3.8, "slip", VERMILION), (5, -3.8, "adhesion", BLUE))
    x, bound, q = np.array(longest).T
    a = chart(figure, 106, 78, "b  Along the longest strip", ("$x$ [mm]", -7, 7), ("traction [MPa]", 0, 600))
    a.plot(x, bound, "--", color=QUIET, label=r"bound $\mu p$")
    a.plot(x, q, color=INK, label=r"$|\mathbf{q}|$")
    texts(a, (-4.6, 180, "slip", VERMILION), (1, 60, "adhesion", BLUE))
    a.legend()


def friction(figure: Figure) -> None:
    """Coefficient over the slip speed, creep curves."""
    law = {"friction": Friction(0.35, falling_ratio=0.4, falling_decay=0.6)}
    a = chart(figure, 14, 76, "a  Friction that falls", ("slip speed $w$ [m/s]", 0, 6), (r"$\mu$", 0, 0.4))
    w = np.linspace(0, 6, 121)
    a.plot(w, law["friction"].coefficient(np.array([0.0, 1.0]), w), color=BLUE)
    line(a, (0, 0.35), (1 / 0.6, 0.14), (1 / 0.6, 0), **DASH)
    line(a, (0, 0.14), (6, 0.14), **DASH)
    texts(a, (5.2, 0.115, r"$A\,\mu_0$"), (0.6, 0.375, r"$\mu_0$"), (2.2, 0.03, "$1/B$"))
    a = chart(figure, 112, 72, "b  Creep force", (r"creepage $-\xi$ [%]", 0, 5.5), ("$F_x/N$", 0, 0.4))
    slow = {"slope_k0": 0.4, "slope_alpha_inf": 0.2, "slope_beta": 0.4}
    for name, look, choices in (
        ("constant", "-", {}),
        ("falling", "--", law),
        ("and slope reduction", ":", law | slow),
    ):
        model, curve = solved(0.0, **choices), []
        rolling = model.arrays.pose.copy().reshape(4, 3) * [[1], [1], [10], [10]]  # 20 m/s
        for extra in np.append(np.linspace(-1e-3, 0.01, 45), np.linspace(0.012, 0.06, 25)):
            rolling[3, 1] = 20 / 0.46 * (1 + extra)
            contact = model.evaluate(*rolling)
            curve.append((-100 * contact.patches[0]["xi"], contact.force[0] / contact.normal_force))
        a.plot(*np.array(curve).T, look, color=BLUE, label=name)
    a.legend()


def multibody(figure: Figure) -> None:
    """Bodies and elements of a vehicle."""
    a = panel(figure, 33, 5, 124, 58, "", (0, 124, 0))
    line(a, (0, 7), (124, 7), width=1.6)
    box(a, 10, 33, 106, 48)
    for x in (27, 89):
        box(a, x - 17, 22, x + 17, 26)
        for wheel in (x - 13, x + 13):
            a.add_patch(patches.Circle((wheel, 13), 6, **WHEEL_LOOK))
            spring(a, wheel - 2, 13, 0, 9, BLUE)
            damper(a, wheel + 2, 13, 0, 9, BLUE)
            spring(a, wheel, 7, 0, -7, QUIET)
        spring(a, x - 3, 26, 0, 7, BLUE)
        damper(a, x + 3, 26, 0, 7, BLUE)
        line(a, (x + 10, 26), (x + 10, 30), (x - 12, 30), (x - 12, 33), colour=BLUE)
    spring(a, 106, 40, 12, 0, FORCE)
    a.plot(118, 40, "o", color=FORCE, markersize=3)
    texts(a, (58, 40.5, "car body: $z, x, y$, heading, roll, pitch"), (58, 24, "bogie frames"), (58, 13, "wheelsets"),
          (117, 45, "prescribed\npoint, $s_0(t)$", FORCE), (58, 29.5, "secondary: field", BLUE),
          (58, 18.5, "primary: field", BLUE), (58, 3, "pieces of rail", QUIET), (9, 30, "rod", BLUE))  # fmt: skip


def integration(figure: Figure) -> None:
    """The way of a step of the implicit method."""
    a = panel(figure, 4, 5, 182, 58, "", (0, 184, 0))
    for x, y, text in (
        (2, 38, "prediction: last accelerations\nand half of their last change"), (146, 38, "end of the step"),
        (50, 38, "forces of all bodies,\nresidual $\\mathbf{r}$"), (98, 38, "residual within\nthe tolerance?"),
        (98, 20, "residual less than half\nof the last one?"), (50, 20, "retain the Jacobian,\nBroyden's update"),
        (98, 2, "new Jacobian,\nblock by block"), (2, 20, "correction of\nNewton's method"),
        (146, 2, "no convergence: 4, 16\nparts, then RK44"),
    ):  # fmt: skip
        width = 42 if x == 2 else 36
        box(a, x, y, x + width, y + 12, "white" if "?" in text else WHEEL_FILL)
        say(a, (x + width / 2, y + 6), text)
    for way in (
        ((44, 44), (50, 44)), ((86, 44), (98, 44)), ((134, 44), (146, 44)), ((116, 38), (116, 32)),
        ((98, 26), (86, 26)), ((116, 20), (116, 14)), ((50, 26), (44, 26)), ((98, 8), (22, 8), (22, 20)),
        ((134, 8), (146, 8)), ((22, 32), (22, 35), (68, 35), (68, 38)),
    ):  # fmt: skip
        line(a, *way)
        arrow(a, way[-2], way[-1])
    texts(a, (140, 46.5, "yes"), (119, 35, "no"), (92, 28.5, "yes"), (119, 17, "no"), colour=FORCE)


def elastic(figure: Figure) -> None:
    """Shapes of a free beam, Campbell's diagram of an axle."""
    x = np.linspace(-0.5, 0.5, 201)
    beam = BeamModes.of_body(1.0, (0, 0, 0), 1.0, (10.0, None), 3, 0.0)
    a = chart(figure, 14, 76, "a  Modes of a free beam", ("$x/L$", -0.5, 0.5), (r"shape $\phi_k$", -1.1, 1.9))
    for root, shape in zip(beam.roots, beam.shapes(np.column_stack([x, 0 * x, 0 * x])), strict=True):
        a.plot(x, shape[:, 2], label=f"{(root / beam.roots[0]) ** 2:.2f} $f_1$")
    a.legend(ncols=3)
    modes = Axle(((2.2, 0.17),)).modes([Disc(side * 0.75, 350.0, 35.0, 20.0) for side in (-1, 1)])
    speeds = np.linspace(0.001, 300, 61)
    whirls = [whirl(modes, speed / 3.6 / 0.46) for speed in speeds]
    a = chart(figure, 112, 72, "b  Axle with two wheels", ("speed [km/h]", 0, 300), ("natural frequency [Hz]", 0, 225))
    for forward, look, name in ((True, "-", "whirls forward"), (False, "--", "whirls backward")):
        colour, y = BLUE if forward else VERMILION, [f[way == forward][:2] for f, way in whirls]
        a.plot(speeds, y, look, color=colour, label=[name, "_"])
    a.legend(loc="lower right")


def out_of_round(figure: Figure) -> None:
    """A wheel with a flat that touches ahead of its axle."""
    a = panel(figure, 50, 5, 90, 59, "", (-52, 52, -36))
    around = np.linspace(-np.pi, np.pi, 1441)
    radius = np.minimum(1, np.cos(0.5) / np.maximum(np.cos(around + 0.25), 0.1))
    outline = 30 * radius[:, None] * np.column_stack((np.sin(around), -np.cos(around)))
    touch, flat = outline[np.argmin(outline[:, 1])], 27.5 * by(np.sin(-0.25), -np.cos(0.25))
    body(a, outline, WHEEL_FILL)
    a.add_patch(patches.Circle((0, 0), 30, facecolor="none", edgecolor=QUIET, linewidth=0.6, linestyle="--", zorder=4))
    line(a, (-46, touch[1]), (46, touch[1]), width=1.6)
    for end in ((0, touch[1]), touch, flat, (0, 24), (18.4, 15.4)):
        line(a, (0, 0), end, **DASH, zorder=5)
    turn(a, (0, 0), 19, 270, 270 + np.degrees(0.25), FORCE)
    turn(a, (0, 0), 14, 90, 40, AXIS)
    arrow(a, (34, 12), (47, 12), AXIS)
    texts(a, (3, -14, r"$\vartheta$", FORCE), (11, 14, r"$\varphi$", AXIS), (40, 15, "rolling", AXIS), (-8, -13, "$P$"),
          (22, -33, "contact", FORCE), (-13, -32.4, r"depth $\delta$"), (-24.5, 22, r"$\rho$", QUIET))  # fmt: skip
    a.plot(*touch, "o", color=FORCE, markersize=3.5, zorder=8)


def sleepers(figure: Figure) -> None:
    """The window of rails on sleepers."""
    a = panel(figure, 4, 5, 182, 59, "", (0, 182, 0))
    for end, way in ((4, 1), (178, -1)):
        body(a, np.array([(end, 33), (end + 42 * way, 33), (end, 40)]), "#f6cdb4", linewidth=0.5)
    box(a, 4, 30, 178, 33, RAIL_FILL)
    for x in range(7, 178, 12):
        box(a, x - 2.5, 18, x + 3.5, 23)
        for draw, x_of_layer in ((spring, x - 1), (damper, x + 2)):
            draw(a, x_of_layer, 30, 0, -7)
            draw(a, x_of_layer, 18, 0, -9)
    a.plot(np.arange(7.5, 176, 3), np.full(57, 31.5), ".", color=QUIET, markersize=2, zorder=8)
    line(a, (2, 9), (180, 9), width=1.6)
    for x in (66, 80, 102, 116):
        a.add_patch(patches.Circle((x, 38.5), 5.5, **WHEEL_LOOK))
        arrow(a, (x, 48.5), (x, 44.5), FORCE)
    arrow(a, (4, 53), (66, 53), *SPAN)
    arrow(a, (4, 44), (46, 44), *SPAN)
    texts(a, (35, 55, "margin", QUIET), (25, 46, "end zone, $L$", QUIET), (28, 39, "rate $r\\,(x/L)^2$", VERMILION),
          (91, 51.5, "forces $f$ of the wheels", FORCE),
          (91, 4.5, "rail of elements $B, S, m'$ with nodes; pads; half sleepers; ballast", QUIET))  # fmt: skip


def main() -> None:
    """Draw those that are named, or all."""
    every = (
        "track transitions surfaces search half_space creep_forces friction multibody integration elastic out_of_round "
        "sleepers"
    )
    for name in sys.argv[1:] or every.split():
        with style(), mpl.rc_context({"axes.prop_cycle": cycler(color=SERIES_COLOURS)}):
            figure = new_figure(190, 66, constrained=False)
            globals()[name](figure)
            print(save(figure, Path(__file__).with_name(f"theory_{name}.svg")))


if __name__ == "__main__":
    main()
