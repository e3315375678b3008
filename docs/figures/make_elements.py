"""Draws element_*.svg and writes the tables of docs/user/elements.md. Run: python docs/figures/make_elements.py

The examples of the page are its own TOML blocks. Their loops come from the kernel of the suspension, their linear
stiffness from the equivalent elements, and the figures in use from the vehicle files that are shipped.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch, Rectangle
from numpy.typing import NDArray

from wrsim.jit.frames import BODY
from wrsim.plots import new_figure, save, style
from wrsim.plots.theme import INK, MM, QUIET, WHEEL_FILL
from wrsim.vehicle.dynamics.suspension import AXIS, ELEMENT, LINE, PLANE, READING, WRENCH, Suspension, suspension_forces
from wrsim.vehicle.element_tables import KINDS, Joint
from wrsim.vehicle.element_tables import Axes as PartAxes
from wrsim.vehicle.elements import Element, Tables
from wrsim.vehicle.equivalent import Stroke, equivalent_elements

Array = NDArray[np.float64]

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
PAGE = HERE.parent / "user" / "elements.md"
FORCE, TRAVEL, PART = "#B00020", "#00785A", "#0072B2"

SMALL = 1e-6
"""Travel for the slope at rest [m]."""
AT_REST = {"bilinear-spring": 40e3}
"""Force on ``to`` in the design position of the examples that carry a load [N]."""
STROKES = {
    "spring": (1e-3, 5e-3), "shear-spring": (5e-3, 20e-3), "tabulated-spring": (5e-3, 15e-3),
    "bump-stop": (10e-3, 40e-3), "damper": (1e-3, 5e-3), "traction-rod": (0.5e-3, 3e-3), "friction": (1e-3, 5e-3),
    "leaf-spring": (1e-3, 10e-3), "rubber-spring": (1e-3, 10e-3), "air-spring": (1e-3, 10e-3),
    "bilinear-spring": (5e-3, 20e-3),
}  # fmt: skip
"""Amplitudes of the loops that are drawn, at 1 Hz [m]."""
TABLED = (Stroke(1e-3, 1.0), Stroke(10e-3, 1.0), Stroke(1e-3, 10.0))
"""Strokes of the table of linear stiffness."""
VEHICLES = {
    "vehicles/manchester_1": "coach, Manchester 1", "vehicles/gz18": "metro car GZ18",
    "vehicles/crh380a": "high-speed coach CRH380A", "vehicles/irw": "light rail IRW", "vehicles/tram": "tram car",
    "vehicles/freight_y25": "wagon, Y25 type", "vehicles/cooperrider_bogie": "Cooperrider's bogie",
    "templates/metro": "template: metro car", "templates/locomotive": "template: locomotive",
}  # fmt: skip
"""Vehicle files whose figures the page has."""
MARKS = {"vehicles/gz18": "pub", "vehicles/irw": "pub", "vehicles/tram": "assumed", "templates/metro": "pub"}
"""Mark of the figures of a file that has the same for all of them."""
FIGURES = re.compile(r"(\w*(?:stiffness|damping|_force_kN|travel_mm|friction|second_from|share|exponent|factor)\w*) = ")
"""Keys that are figures of an element."""


def examples() -> dict[str, dict[str, Any]]:
    """Example of every kind on the page: its keys."""
    blocks = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    elements = [row for block in blocks for row in tomllib.loads(block).get("elements", ())]
    return {row["kind"]: row for row in elements}


def element_of(keys: dict[str, Any]) -> Element:
    """The element of an example, between two bodies in the axes of the vehicle."""
    table = KINDS[keys["kind"]].model_validate(keys)
    return table.element(Joint(keys["name"], keys["kind"], "body", "to"), PartAxes())


def record_of(element: Element) -> tuple[Any, Tables]:
    """The kernel's record of an element (an array of one) and its tables."""
    rows, tables = np.zeros(1, ELEMENT), Tables()
    row = rows[0]
    row.state = row.normal = -1
    row.first, row.second = 0, 1
    row.point_1, row.point_2 = (tuple(point) for point in element.points)
    preload = np.zeros(len(element.directions))
    preload[-1] = AT_REST.get(element.kind, 0.0)
    element.write(row, preload, tables)
    return rows, tables


def loop(element: Element, stroke: Stroke, steps: int = 10000, loops: int = 2) -> tuple[Array, Array]:
    """Travel [m] and force along the element's direction [N] in the last of some harmonic loops, by the kernel."""
    rows, tables = record_of(element)
    way = main_direction(element)
    bodies, readings = np.zeros(2, BODY), np.zeros(1, READING)
    for name, axis in (("forward", (1, 0, 0)), ("left", (0, 1, 0)), ("up", (0, 0, 1))):
        bodies[name] = [axis, axis]
    inner, inner_t = np.zeros(max(tables.unknowns, 1)), np.zeros(max(tables.unknowns, 1))
    values = np.array(tables.rows or [(0.0, 0.0)])
    on = Suspension(bodies, values, inner, inner_t, np.zeros(2, WRENCH), readings)
    times = np.arange(loops * steps + 1) / (steps * stroke.frequency)
    travel = stroke.amplitude * np.sin(stroke.rate * times)
    rate = stroke.amplitude * stroke.rate * np.cos(stroke.rate * times)
    force = np.zeros(len(times))
    for i in range(len(times)):
        bodies[1].position, bodies[1].velocity = tuple(travel[i] * way), tuple(rate[i] * way)
        suspension_forces(on, rows)
        vector = np.array(readings[0].force.tolist())
        force[i] = vector[0] if rows[0].kind == LINE else vector @ way
        inner += inner_t * (times[1] - times[0])
    return travel[-steps - 1 :], force[-steps - 1 :]


def main_direction(element: Element) -> Array:
    """Direction of its loop: the last of its directions that has a stiffness or a slider."""
    if element.kind == "shear-spring":
        return np.array([0.0, 1.0, 0.0])
    return np.asarray(element.directions[-1])


def linear(element: Element, stroke: Stroke | None) -> complex:
    """Dynamic stiffness k + i w c along the loop's direction [N/m]; stroke None: stiffness at rest."""
    way = main_direction(element)
    rows, tables = record_of(element)
    values = np.array(tables.rows or [(0.0, 0.0)])
    row = rows[0] if stroke is None else equivalent_elements(rows, np.zeros((1, 6)), values, stroke)[0]
    if row.kind not in (AXIS, LINE, PLANE):
        damping = 0.0 if stroke is None else stroke.rate * float(row.damping.tolist() @ way**2)
        return complex(float(row.stiffness.tolist() @ way**2), damping)
    k = float(row.k)
    if row.spring_rows:  # slope at rest
        travel, force = values[row.spring_start : row.spring_start + row.spring_rows].T
        k = float(np.diff(np.interp((-SMALL, SMALL), travel, force))[0]) / (2.0 * SMALL)
    if stroke is None:
        return k
    viscous = 1j * stroke.rate * float(row.c)
    if row.state >= 0:
        viscous = viscous * float(row.series) / (viscous + float(row.series))
    stick = float(row.stick) + 1j * stroke.rate * float(row.stick_damping)
    return k + viscous + stick


def stiffness_table(example_keys: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Linear stiffness and damping of the examples."""
    yield "| example | along | at rest | 1 mm, 1 Hz | 10 mm, 1 Hz | 1 mm, 10 Hz |\n|---|---|---|---|---|---|\n"
    for kind, keys in example_keys.items():
        element = element_of(keys)
        if kind == "anti-roll-bar":
            k = element.turning_stiffness[0]
            yield f"| `{kind}` | about x | {1e-3 * k:.0f} kN m/rad | the same | the same | the same |\n"
            continue
        way = main_direction(element)
        along = "its line" if getattr(element, "axis", 0) is None else "xyz"[int(np.argmax(np.abs(way)))]
        cells = [f"{1e-6 * linear(element, None).real:.3g}"]
        for stroke in TABLED:
            value = linear(element, stroke)
            c = value.imag / stroke.rate
            cells.append(
                f"{1e-6 * value.real:.3g}" + (f"; {1e-3 * c:.3g}" if c > 1e-3 * abs(value) / stroke.rate else "")
            )
        yield f"| `{kind}` | {along} | {' | '.join(cells)} |\n"


def figures_in_use(kind: str) -> list[str]:
    """Rows: element, vehicle, figures with their marks."""
    rows, seen = [], set[tuple[str, str]]()
    for stem, label in VEHICLES.items():
        text = (ROOT / "models" / f"{stem}.toml").read_text(encoding="utf-8")
        for block in re.split(r"^\[\[(?:parts\.\w+\.)?elements\]\]", text, flags=re.M)[1:]:
            block = re.split(r"^\[", block, flags=re.M)[0]
            if f'kind = "{kind}"' not in block:
                continue
            name = re.search(r'^name = "(.+?)"', block, re.M)
            cells = []
            for line in re.sub(r"\[\s*#([^\n]*)\n(.*?)\n\]", r"[\2]  #\1", block, flags=re.S).splitlines():
                if not (key := FIGURES.match(line)):
                    continue
                value, _, comment = line[key.end() :].partition("#")
                mark = re.search(r"\[(pub|read|mem|assumed|derived)\]", comment)
                word = mark[1] if mark else before(cells) if cells else MARKS.get(stem, "assumed")
                figures = re.sub(r"\s+", " ", value.strip()).replace("[ [", "[[").replace(",]", "]")
                cells.append(f"`{key[1]}` {figures} [{word}]")
            values = (label, re.sub(r" \[\w+\]", "", "; ".join(cells)))
            if cells and values not in seen:  # a twin of the element has the same
                seen.add(values)
                rows.append(f"| {name[1] if name else ''} | {label} | {'; '.join(cells)} |\n")
    return rows


def before(cells: list[str]) -> str:
    """The mark of the figure before."""
    return cells[-1].rpartition("[")[2].removesuffix("]")


def page() -> str:
    """The text of the page with its tables."""
    text = PAGE.read_text(encoding="utf-8")
    example_keys = examples()
    assert set(example_keys) == set(KINDS), set(example_keys) ^ set(KINDS)
    made = {"linear": "".join(stiffness_table(example_keys))}
    for kind in KINDS:
        rows = figures_in_use(kind)
        head = "| element | vehicle | figures |\n|---|---|---|\n"
        made[kind] = head + "".join(rows) if rows else "No shipped vehicle has one.\n"
    for name, table in made.items():
        mark = re.compile(rf"(<!-- made by docs/figures/make_elements.py: {name} -->\n).*?(<!-- end -->)", re.S)
        text, count = mark.subn(lambda m, table=table: f"{m[1]}{table}{m[2]}", text)
        assert count == 1, name
    return text


# Sketches: millimetres from the lower left corner; the first body to the left, the second one to the right.
LEFT, RIGHT = 16.0, 56.0


def line(ax: Axes, points: Any, colour: str = PART, width: float = 1.0, **more: Any) -> None:
    """A line through points."""
    x, y = np.transpose(points)
    ax.plot(x, y, color=colour, linewidth=width, solid_joinstyle="round", zorder=3, **more)


def say(ax: Axes, x: float, y: float, text: str, colour: str = INK, **more: Any) -> None:
    """Text, centred."""
    ax.text(x, y, text, **({"color": colour, "fontsize": 7, "ha": "center", "va": "center", "zorder": 6} | more))


def arrow(ax: Axes, start: Any, end: Any, colour: str) -> None:
    """An arrow."""
    ax.add_patch(
        FancyArrowPatch(
            start, end, arrowstyle="-|>,head_length=3,head_width=1.4", color=colour, shrinkA=0, shrinkB=0, zorder=6
        )
    )


def block(ax: Axes, x: float, y: float, width: float, height: float, label: str = "") -> None:
    """A body."""
    ax.add_patch(Rectangle((x, y), width, height, facecolor=WHEEL_FILL, edgecolor=INK, linewidth=0.8, zorder=4))
    say(ax, x + width / 2, y + height / 2, label)


def coil(ax: Axes, x0: float, x1: float, y: float, high: float = 2.6, label: str = "", turns: int = 5) -> None:
    """A spring along x."""
    lead = 0.12 * (x1 - x0)
    x = np.linspace(x0 + lead, x1 - lead, 2 * turns + 2)
    wave = y + high * np.array([0, *([1, -1] * turns), 0])
    line(ax, np.column_stack([[x0, *x, x1], [y, *wave, y]]))
    say(ax, (x0 + x1) / 2, y + high + 2.0, label)


def pot(ax: Axes, x0: float, x1: float, y: float, label: str = "", narrow: bool = False) -> None:
    """A dashpot along x; narrow: an orifice."""
    a, b, m = x0 + 0.3 * (x1 - x0), x0 + 0.72 * (x1 - x0), x0 + 0.52 * (x1 - x0)
    h = 2.2
    line(ax, [(x0, y), (a, y)])
    line(ax, [(b, y + h), (a, y + h), (a, y - h), (b, y - h)])
    if narrow:
        for s in (-1, 1):
            line(ax, [(m, y + s * h), (m, y + s * 0.6)], width=1.6)
        line(ax, [(m, y), (x1, y)], linestyle=(0, (2, 1.5)))
    else:
        line(ax, [(m, y + 0.75 * h), (m, y - 0.75 * h)], width=1.6)
        line(ax, [(m, y), (x1, y)])
    say(ax, (x0 + x1) / 2, y + h + 2.0, label)


def slide(ax: Axes, x0: float, x1: float, y: float, label: str = "") -> None:
    """A sliding surface along x: a shoe on a rail."""
    m = (x0 + x1) / 2
    half = 0.32 * (x1 - x0)
    line(ax, [(x0, y + 1.3), (m - half * 0.7, y + 1.3)])
    ax.add_patch(
        Rectangle((m - 0.7 * half, y), 1.4 * half, 2.6, facecolor="white", edgecolor=PART, linewidth=1.0, zorder=4)
    )
    line(ax, [(m - half, y), (x1, y)])
    for k in range(5):
        x = m - half + 0.4 * half * k
        line(ax, [(x + 0.4 * half, y), (x + 0.1 * half, y - 1.3)], QUIET, 0.6)
    say(ax, m, y + 4.6, label)


def tie(ax: Axes, x: float, ys: list[float]) -> None:
    """A bar that joins branches."""
    line(ax, [(x, min(ys)), (x, max(ys))])


def two_bodies(
    ax: Axes, middle: float = 23.0, high: float = 15.0, axis: str = "axis", line_element: bool = False
) -> None:
    """The bodies, the axis, travel and force."""
    block(ax, 5, middle - high / 2, 11, high, "body")
    block(ax, RIGHT, middle - high / 2, 11, high, "to")
    top = middle + high / 2
    arrow(ax, (RIGHT + 2, top + 3.2), (RIGHT + 14, top + 3.2), TRAVEL)
    say(ax, RIGHT + 8, top + 5.6, "extension $e$" if line_element else "travel $d$", TRAVEL)
    if line_element:  # tension pulls both ends together
        arrow(ax, (RIGHT, middle - high / 2 - 3.2), (RIGHT - 12, middle - high / 2 - 3.2), FORCE)
        arrow(ax, (LEFT, middle - high / 2 - 3.2), (LEFT + 12, middle - high / 2 - 3.2), FORCE)
        say(ax, 36, middle - high / 2 - 6.4, "tension $f$ on both ends", FORCE)
    else:
        arrow(ax, (RIGHT + 2, middle - high / 2 - 3.2), (RIGHT + 14, middle - high / 2 - 3.2), FORCE)
        say(ax, RIGHT + 7, middle - high / 2 - 6.4, "force $f$ on “to”", FORCE)
        arrow(ax, (5, middle - high / 2 - 3.2), (15, middle - high / 2 - 3.2), INK)
        say(ax, 10, middle - high / 2 - 6.4, axis, INK)


def branches(ax: Axes, rows: list[list[tuple[str, str]]], middle: float = 23.0) -> None:
    """Branches beside each other, each a row of parts (kind, label) in series."""
    gap = 10.5
    ys = [middle + gap * (0.5 * (len(rows) - 1) - i) for i in range(len(rows))]
    x0, x1 = LEFT + 3, RIGHT - 3
    for y, row in zip(ys, rows, strict=True):
        width = (x1 - x0) / len(row)
        for k, (part, label) in enumerate(row):
            a, b = x0 + k * width, x0 + (k + 1) * width
            if part == "coil":
                coil(ax, a, b, y, label=label)
            elif part == "slide":
                slide(ax, a, b, y - 1.3 * (len(row) > 1), label)
            else:
                pot(ax, a, b, y, label, narrow=part == "orifice")
    for x, end in ((x0, LEFT), (x1, RIGHT)):
        tie(ax, x, ys)
        line(ax, [(x, middle), (end, middle)])


def spring(ax: Axes) -> None:
    two_bodies(ax, high=18)
    branches(ax, [[("coil", "$k_x, k_y, k_z$")], [("pot", "$c_x, c_y, c_z$")]])
    say(ax, 36, 42.5, "along and about each axis of “body”", QUIET)


def shear_spring(ax: Axes) -> None:
    block(ax, 14, 4, 40, 6, "body")
    block(ax, 26, 34, 40, 6, "to")
    y = np.linspace(10, 34, 13)
    s = (y - 10) / 24
    middle = 34 + 12 * s**2 * (3 - 2 * s)
    line(ax, np.column_stack([middle, y]), QUIET, 0.6, linestyle=(0, (6, 2, 1, 2)))
    wave = middle + 5 * np.array([0, *([1, -1] * 5), 1, 0])
    line(ax, np.column_stack([wave, y]), width=1.3)
    arrow(ax, (66, 37), (77, 37), TRAVEL)
    say(ax, 72, 40, "travel $d_y$", TRAVEL)
    arrow(ax, (66, 35), (77, 35), FORCE)
    say(ax, 72, 31.5, "force $f_y$", FORCE)
    say(ax, 61, 21, "clamped at\nboth ends", QUIET)
    arrow(ax, (4, 14), (4, 24), INK)
    arrow(ax, (4, 14), (14, 14), INK)
    say(ax, 4, 26.5, "$z$")
    say(ax, 12, 16.5, "$y$")
    say(ax, 14, 43, "seen from the front", QUIET)


def tabulated_spring(ax: Axes) -> None:
    two_bodies(ax)
    coil(ax, LEFT, RIGHT, 23, high=4)
    arrow(ax, (28, 15.5), (44, 30.5), PART)
    say(ax, 36, 33, "table: travel, force")


def bump_stop(ax: Axes) -> None:
    two_bodies(ax)
    line(ax, [(LEFT, 29), (46, 29)], INK, 0.8)
    line(ax, [(LEFT, 17), (46, 17)], INK, 0.8)
    line(ax, [(46, 29), (46, 25)], INK, 0.8)
    line(ax, [(46, 17), (46, 21)], INK, 0.8)
    line(ax, [(RIGHT, 23), (33, 23)], INK, 0.8)
    line(ax, [(33, 19), (33, 27)], INK, 1.6)
    for x, w in ((LEFT, 5), (41, 5)):
        ax.add_patch(
            Rectangle(
                (x, 19.5 if x < 30 else 24.2), w, 7 if x < 30 else 3.5, facecolor="#cfd6dc", edgecolor=PART, zorder=3
            )
        )
    ax.add_patch(Rectangle((41, 18.3), 5, 3.5, facecolor="#cfd6dc", edgecolor=PART, zorder=3))
    for x0, x1 in ((21, 33), (33, 41)):
        ax.annotate(
            "",
            (x0, 32),
            (x1, 32),
            arrowprops={"arrowstyle": "<|-|>", "color": QUIET, "lw": 0.7, "shrinkA": 0, "shrinkB": 0},
        )
    say(ax, 31, 35, "free travel, both ways", QUIET)


def damper(ax: Axes) -> None:
    two_bodies(ax)
    pot(ax, LEFT, 38, 23, "$c$, or a table")
    coil(ax, 38, RIGHT, 23, label="$k_s$ (mounting)", turns=3)


def traction_rod(ax: Axes) -> None:
    two_bodies(ax, line_element=True)
    for x, s in ((20, 1), (52, -1)):
        ax.add_patch(Arc((x, 23), 6, 6, color=PART, linewidth=1.2, zorder=4))
        ax.add_patch(Arc((x, 23), 3.2, 3.2, color=INK, linewidth=1.2, zorder=4))
        line(ax, [(x - 4 * s, 23), (x - 0.5 * s, 23)], INK, 0.8)
    line(ax, [(23, 24.2), (49, 24.2)])
    line(ax, [(23, 21.8), (49, 21.8)])
    say(ax, 36, 27.5, "$k$, $c$ along its line")
    say(ax, 36, 18, "play in the eyes", QUIET)


def anti_roll_bar(ax: Axes) -> None:
    block(ax, 14, 6, 44, 6, "body")
    angle = np.radians(-7)
    corners = np.array([(-22, 0), (22, 0), (22, 6), (-22, 6), (-22, 0)])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    line(ax, corners @ turn + (36, 30), INK, 0.8)
    say(ax, 36, 33, "to", rotation=-7)
    for s in (-1, 1):
        top = np.array([s * 16, 0]) @ turn + (36, 30)
        line(ax, [(36 + s * 16, 18 - s * 2), top], width=1.2)
        line(ax, [(36 + s * 5, 18), (36 + s * 16, 18 - s * 2)], width=1.2)
    line(ax, [(31, 18), (41, 18)], width=2.4)
    line(ax, [(36, 18), (36, 12)], INK, 0.8)
    t = np.radians(np.linspace(150, 20, 30))
    line(ax, [(59, 33), (72, 33)], QUIET, 0.5)
    line(ax, [(59, 31.8), (71, 30.3)], TRAVEL)
    say(ax, 70, 36, r"roll $\varphi$", TRAVEL)
    say(ax, 36, 43.5, "seen from behind; $x$ points away", QUIET)
    line(ax, np.column_stack([65 + 5 * np.cos(t), 20 + 5 * np.sin(t)]), FORCE)
    arrow(ax, (65 + 5 * np.cos(t[-2]), 20 + 5 * np.sin(t[-2])), (65 + 5 * np.cos(t[-1]), 20 + 5 * np.sin(t[-1])), FORCE)
    say(ax, 68, 15.5, r"moment $M$ on “to”", FORCE)


def friction(ax: Axes) -> None:
    two_bodies(ax)
    coil(ax, LEFT, 36, 23, label="stick stiffness $k$", turns=4)
    slide(ax, 36, RIGHT, 21.7)
    arrow(ax, (46, 34), (46, 25.5), FORCE)
    say(ax, 46, 36.5, r"$N$;  $F = \mu N$", FORCE)


def leaf_spring(ax: Axes) -> None:
    two_bodies(ax, high=18)
    branches(ax, [[("coil", "$k$ (middle line)")], [("coil", ""), ("slide", "$F$ (leaves)")]])


def rubber_spring(ax: Axes) -> None:
    two_bodies(ax, high=24)
    branches(ax, [[("coil", "$k$")], [("coil", "$k_s$"), ("pot", "$c$")], [("coil", ""), ("slide", "$F$, $x_2$")]])


def air_spring(ax: Axes) -> None:
    two_bodies(ax, high=24)
    branches(
        ax, [[("coil", "$k$")], [("coil", "$k_s$"), ("orifice", "$C$, $n$")], [("coil", ""), ("slide", "$F$, $x_2$")]]
    )


def bilinear_spring(ax: Axes) -> None:
    two_bodies(ax, high=18)
    coil(ax, LEFT, RIGHT, 28, label="outer: $k_1$")
    coil(ax, LEFT, 46, 18, label="inner: $k_2$", turns=4)
    line(ax, [(46, 15.5), (46, 20.5)], width=1.6)
    ax.annotate(
        "",
        (46, 13.8),
        (RIGHT, 13.8),
        arrowprops={"arrowstyle": "<|-|>", "color": QUIET, "lw": 0.7, "shrinkA": 0, "shrinkB": 0},
    )
    say(ax, 44, 11.2, "shut from $F_2$ on", QUIET)


def figure_of(keys: dict[str, Any]) -> Figure:
    """Sketch and loops of an example."""
    kind = keys["kind"]
    figure = new_figure(160, 50)
    figure.set_layout_engine("none")
    wide, high = 160 * MM, 50 * MM
    ax = figure.add_axes((0.0, 0.0, 80 * MM / wide, 46 * MM / high))
    ax.set(xlim=(0, 80), ylim=(0, 46))
    ax.set_axis_off()
    globals()[kind.replace("-", "_")](ax)
    right = figure.add_axes((98 * MM / wide, 11 * MM / high, 58 * MM / wide, 31 * MM / high))
    element = element_of(keys)
    if kind == "anti-roll-bar":
        roll = np.array([-20.0, 20.0])
        right.plot(roll, -1e-6 * element.turning_stiffness[0] * roll)
        right.set(xlabel="roll of “to” against “body”, mrad", ylabel="moment on “to”, kN m")
        return figure
    on_line = getattr(element, "axis", 0) is None
    for amplitude in reversed(STROKES[kind]):
        travel, force = loop(element, Stroke(amplitude, 1.0))
        right.plot(1e3 * travel, 1e-3 * force, label=f"±{1e3 * amplitude:g} mm, 1 Hz")
    right.set(
        xlabel=f"{'extension' if on_line else 'travel of “to”'}, mm",
        ylabel="tension, kN" if on_line else "force on “to”, kN",
    )
    right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def main() -> None:
    """Draw, and write the tables."""
    with style():
        for kind, keys in examples().items():
            print(save(figure_of(keys), HERE / f"element_{kind.replace('-', '_')}.svg"))
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
