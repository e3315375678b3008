"""Pictures and pages of docs/validation, and the figures of README.md. Run: python docs/figures/make_standing.py

They come from docs/data/validation.toml and docs/data/standing; the latter is written by:
python campaigns/scoreboard.py REFERENCE --standing docs/data/standing
python campaigns/oracle.py --write
python -m campaigns.benchmark REFERENCE --report
"""

from __future__ import annotations

import csv
import re
import tomllib
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from wrsim.plots import new_figure, save, style

Array = NDArray[np.float64]
Rows = list[dict[str, str]]

HERE = Path(__file__).parent
DATA = HERE.parent / "data" / "standing"
REPORT = tomllib.loads((HERE.parent / "data" / "validation.toml").read_text(encoding="utf-8"))
PAGES = HERE.parent / "validation"
COMPARISONS = HERE.parents[1] / "campaigns" / "benchmark" / "comparisons"
README = HERE.parents[1] / "README.md"
MARKS = "<!-- made by docs/figures/make_standing.py -->\n", "<!-- end -->"
"""The figures of README.md stand between them."""

NAMES = {
    "contact_planar": "CONTACT, tangent plane",
    "kpec": "CONTACT's KPEC",
    "analyn": "CONTACT's ANALYN",
    "kpec_conf": "KPEC, curved",
    "analyn_conf": "ANALYN, curved",
    "contact_conf_ac": "CONTACT, angle-corrected",
    "kik-piotrowski/constant": "Kik-Piotrowski, constant (the paper)",
    "kik-piotrowski": "Kik-Piotrowski, projected",
    "strips": "strips",
    "half-space": "half-space",
    "half-space/table": "half-space, elements of the table",
}
COLOURS = {
    "kpec": "#8c8c8c",
    "analyn": "#3d3d3d",
    "kpec_conf": "#8c8c8c",
    "analyn_conf": "#3d3d3d",
    "kik-piotrowski/constant": "#E69F00",
    "kik-piotrowski": "#D55E00",
    "strips": "#0072B2",
    "half-space": "#009E73",
}
ALIKE = ("kik-piotrowski/constant",)
"""Not drawn where patches are nearly flat: the approach makes no difference there."""
THEIR_TIMES = {"kpec": 692.0}
"""CONTACT's own, with its FASTSIM at 117 elements, on this class of machine [us]."""
DASHED = ("kpec", "analyn", "kpec_conf", "analyn_conf")
QUANTITIES = {"p0": "largest pressure $p_0$", "area": "contact area", "approach": "approach", "N": "normal force $N$"}
TABLES = {
    "own_static": "six pairs, rolling",
    "own_static_frictionless": "the same, frictionless",
    "mbench_a22": "Manchester A-2.2",
}


def read(name: str) -> Rows:
    """Rows of a data file; none where it is not there."""
    path = DATA / f"{name}.csv"
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def models(rows: Rows) -> list[str]:
    """Models of a table of cases, peers first."""
    named = [c.removesuffix(" p0") for c in rows[0] if c.endswith(" p0")] if rows else []
    return [m for m in NAMES if m in named] + [m for m in named if m not in NAMES]


def name_of(model: str) -> str:
    """How a model is called here."""
    return NAMES.get(model, model)


def errors(rows: Rows, model: str, quantity: str) -> Array:
    """Relative errors of the cases that a model has."""
    return np.array([0.01 * float(r[f"{model} {quantity}"]) for r in rows if r.get(f"{model} {quantity}")])


# --- figures ------------------------------------------------------------------------------------------


def drawn(rows: Rows) -> list[str]:
    """Models that have a colour, in order."""
    return [m for m in models(rows) if m in COLOURS and m not in ALIKE]


def share_below(panel: Axes, rows: Rows, quantity: str, chosen: Iterable[str]) -> None:
    """Share of the cases with an error below x by each model."""
    for model in chosen:
        e = np.sort(np.abs(errors(rows, model, quantity)))
        share = (np.arange(len(e)) + 1.0) / len(rows)  # what a model did not solve counts as missed
        panel.plot(np.maximum(e, 1e-4), 100.0 * share, color=COLOURS[model], linewidth=1.4,
                   linestyle="--" if model in DASHED else "-", label=name_of(model))  # fmt: skip
    panel.set_xscale("log")
    panel.set_xlim(1e-4, 1.0)
    panel.set_xticks([1e-4, 1e-3, 1e-2, 1e-1, 1.0], ["0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
    panel.set_ylim(0.0, 100.0)
    panel.set_title(f"Error of the {QUANTITIES[quantity]}", loc="left", fontsize="medium")
    panel.grid(True, which="major")


def pressures() -> Figure:
    """Share of the poses with an error of p0 below x, by four models."""
    figure = new_figure(140, 75)
    panel = figure.subplots()
    share_below(panel, read("own_static"), "p0", ("strips", "kik-piotrowski", "kpec", "analyn"))
    panel.set_ylabel("poses below [%]")
    panel.set_xlabel("difference from CONTACT on 809 poses")
    panel.legend(loc="upper left", frameon=False)
    return figure


def cumulative() -> Figure:
    """Share of the cases with an error below x, for four quantities."""
    rows = read("own_static")
    figure = new_figure(190, 150)
    axes = figure.subplots(2, 2, sharey=True)
    for panel, quantity in zip(axes.flat, QUANTITIES, strict=True):
        share_below(panel, rows, quantity, drawn(rows))
    for panel in axes[:, 0]:
        panel.set_ylabel("cases below [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def by_pair() -> Figure:
    """Signed error of p0 and of the area for every pair of profiles: boxes from 25 to 75 %, whiskers 5 to 95 %."""
    rows = read("own_static")
    pairs = list(dict.fromkeys(f"{r['pair']} {r['cant']}" for r in rows))
    chosen = drawn(rows)
    figure = new_figure(190, 150)
    axes = figure.subplots(2, 1, sharex=True)
    width = 0.8 / len(chosen)
    for panel, quantity in zip(axes, ("p0", "area"), strict=True):
        for i, model in enumerate(chosen):
            boxes = [
                100.0 * errors([r for r in rows if f"{r['pair']} {r['cant']}" == pair], model, quantity)
                for pair in pairs
            ]
            places = np.arange(len(pairs)) + (i - 0.5 * (len(chosen) - 1)) * width
            panel.boxplot(
                boxes, positions=places, widths=0.85 * width, whis=(5, 95), showfliers=False, patch_artist=True,
                boxprops={"facecolor": COLOURS[model], "edgecolor": "none", "alpha": 0.85},
                medianprops={"color": "black", "linewidth": 1.0},
                whiskerprops={"color": COLOURS[model]}, capprops={"visible": False},
            )  # fmt: skip
            panel.plot([], [], "s", color=COLOURS[model], label=name_of(model))
        panel.axhline(0.0, color="black", linewidth=0.6)
        panel.set_ylabel(f"error of {'$p_0$' if quantity == 'p0' else 'the area'} [%]")
        panel.set_xticks(range(len(pairs)), [p.replace(" ", "\n") for p in pairs])
        panel.set_xlim(-0.5, len(pairs) - 0.5)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def arcs() -> Figure:
    """Worst and best errors over loads, angles and rolling radii against the wheel's radius."""
    rows = read("arcs")
    figure = new_figure(190, 115)
    axes = figure.subplots(1, 2, sharex=True)
    radii = sorted({float(r["R_wheel_mm"]) for r in rows})
    chosen = [m for m in NAMES if m in COLOURS and any(r["model"] == m for r in rows)]
    for panel, quantity in zip(axes, ("p0", "width"), strict=True):
        for i, model in enumerate(chosen):
            rows_of_model = [r for r in rows if r["model"] == model]
            for j, radius in enumerate(radii):
                e = [100.0 * float(r[quantity]) for r in rows_of_model if float(r["R_wheel_mm"]) == radius]
                x = j + (i - 0.5 * (len(chosen) - 1)) * 0.8 / len(chosen)
                marks = "s" if model in DASHED else "o"
                inside = "white" if model.endswith("_conf") else COLOURS[model]
                panel.plot([x, x], [min(e), max(e)], color=COLOURS[model], linewidth=2.5, solid_capstyle="butt")
                panel.plot(x, np.median(e), marks, color=COLOURS[model], markersize=3.8, markerfacecolor=inside,
                           label=name_of(model) if j == 0 else None)  # fmt: skip
        panel.axhline(0.0, color="black", linewidth=0.6)
        panel.set_xticks(range(len(radii)), [f"R{r:g}" for r in radii])
        panel.set_xlabel("hollow of the wheel on a rail corner R13 [mm]")
        panel.set_ylabel(f"error of {'$p_0$' if quantity == 'p0' else 'the width'} [%]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def creep_forces() -> Figure:
    """Share of the cases with an error of force and moment below x."""
    rows = read("creep_forces")
    figure = new_figure(190, 95)
    axes = figure.subplots(1, 2, sharey=True)
    models_in_table = list(dict.fromkeys(r["model"] for r in rows))
    # of the normal models the one that is nearest to the ellipse
    best = [m for m in ("strips", "kik-piotrowski") if any(f.startswith(f"{m}, ") for f in models_in_table)][:1]
    chosen = [
        m
        for m in models_in_table
        if m.startswith("CONTACT") or m.startswith(("half-space, ", *(f"{b}, " for b in best)))
    ]
    colours = iter(["#0072B2", "#56B4E9", "#D55E00", "#CC79A7", "#E69F00", "#F0E442", "#009E73", "#000000"])
    for model in chosen:
        if model == "CONTACT's contact_ellbound":
            continue
        rows_of_model = [r for r in rows if r["model"] == model]
        theirs = model.startswith("CONTACT")
        grey = {"fastsim_ell": "#8c8c8c", "fastsim_par": "#b5b5b5", "fastrip": "#3d3d3d"}
        colour = grey[model.split()[-1]] if theirs else next(colours)
        for panel, quantity in zip(axes, ("force", "moment"), strict=True):
            e = np.sort([float(r[quantity]) for r in rows_of_model])
            panel.plot(np.maximum(e, 1e-4), 100.0 * (np.arange(len(e)) + 1.0) / len(e), color=colour, linewidth=1.4,
                       linestyle="--" if theirs else "-", label=model.removeprefix("kik-piotrowski, "))  # fmt: skip
            panel.set_xscale("log")
            panel.set_xlim(1e-4, 2.0)
            panel.set_xticks([1e-4, 1e-3, 1e-2, 1e-1, 1.0], ["0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
            panel.set_xlabel(f"error of the {quantity} over "
                             + (r"$\mu N$" if quantity == "force" else r"$\mu N \sqrt{ab}$"))  # fmt: skip
            panel.grid(True, which="major")
    axes[0].set_ylabel("cases below [%]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def cost() -> Figure:
    """Median and 95 % of the error of p0 against the time of one evaluation."""
    rows, times = read("own_static"), [r for r in read("times") if r["table"] == "own_static"]
    figure = new_figure(130, 95)
    panel: Axes = figure.subplots()
    places = {r["model"]: float(r["median_us"]) for r in times if r["model"] not in ALIKE} | THEIR_TIMES
    for model, x in places.items():
        if model not in COLOURS:
            continue
        middle, most = np.percentile(100.0 * np.abs(errors(rows, model, "p0")), [50.0, 95.0])
        panel.plot([x, x], [middle, most], color=COLOURS[model], linewidth=2.0)
        panel.plot([x], [middle], "s" if model in DASHED else "o", color=COLOURS[model])
        panel.plot([x], [most], "_", color=COLOURS[model], markersize=9)
        label = name_of(model).removesuffix(", projected")
        panel.annotate(label, (x, middle), xytext=(6, -3), textcoords="offset points", fontsize=7)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    panel.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    panel.set_xlabel("one evaluation [µs]")
    panel.set_ylabel("error of $p_0$ [%]: median, 95 %")
    low, high = panel.get_xlim()
    panel.set_xlim(0.7 * low, 4.0 * high)
    panel.grid(True, which="major")
    return figure


# --- tables -------------------------------------------------------------------------------------------


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    head = list(head)
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def static_tables() -> str:
    """Median / 95 % of every quantity, a table for every reference table with friction."""
    parts = []
    for file, title in TABLES.items():
        if file.endswith("frictionless"):
            continue
        rows = read(file)
        body = []
        for model in models(rows):
            cells = []
            for quantity in QUANTITIES:
                e = np.abs(errors(rows, model, quantity))
                cells.append("{:.4f} / {:.4f}".format(*np.percentile(e, [50.0, 95.0])) if len(e) else "")
            body.append([name_of(model), str(len(errors(rows, model, "p0"))), *cells])
        parts.append(table([f"{title}: {len(rows)} cases", "solved", "p0", "area", "approach", "N"], body))
    return "\n\n".join(parts)


def arc_table() -> str:
    """Worst errors of p0 and of the variation of the contact angle by the wheel's radius."""
    rows = read("arcs")
    radii = sorted({r["R_wheel_mm"] for r in rows}, key=float)
    models_in_table = [m for m in NAMES if any(r["model"] == m for r in rows)]
    parts = []
    for quantity, title in (("p0", "p0"), ("angles", "variation of the contact angle")):
        body = []
        for model in models_in_table:
            cells = []
            for radius in radii:
                e = [float(r[quantity]) for r in rows if r["model"] == model and r["R_wheel_mm"] == radius]
                worst = max(e, key=abs) if e else np.nan
                cells.append(f"{100.0 * worst:+.1f} %" if np.isfinite(worst) else "")
            body.append([name_of(model), *cells])
        parts.append(table([title, *(f"R13/R{float(r):g}" for r in radii)], body))
    return "\n\n".join(parts)


def other_tables() -> str:
    """Regions, angles, grooves, times."""
    regions = table(
        ["several regions", "cases", "same number found", "N within 5 %", "N: median / 95 %"],
        [
            [f"{name_of(r['model'])}, {TABLES[r['table']]}", r["cases"], r["same_number"],
             f"{r['within_5_percent']} of {r['regions']}", f"{r['median']} / {r['most']}"]
            for r in read("regions")
        ],
    )  # fmt: skip
    angles = table(
        ["range of the contact angle over the patch", "within 5 % or 0.5 deg", "median / 95 % / worst [deg]"],
        [
            [name_of(r["model"]), f"{r['within']} of {r['cases']}",
             f"{r['median_deg']} / {r['most_deg']} / {r['worst_deg']}"]
            for r in read("angles")
        ],
    )  # fmt: skip
    grooves = table(
        ["deep grooves, ratio to the published figures", "", "approach", "p0", "width", "length"],
        [[r["case"], name_of(r["model"]), r["approach"], r["p0"], r["width"], r["length"]] for r in read("grooves")],
    )
    return "\n\n".join([regions, angles, grooves])


def oracle_table() -> str:
    """Differences from ContactMechanics, on rails and on rollers."""
    rows, body = read("oracle"), []
    for below in dict.fromkeys(r["below"] for r in rows):
        chosen = [r for r in rows if r["below"] == below]
        for model in ("half-space", "strips"):
            cells = []
            for quantity in ("N", "p0"):
                e = np.abs([100.0 * float(r[f"{model} {quantity}"]) for r in chosen])
                cells.append("{:.3f} / {:.3f} / {:.3f} %".format(*np.percentile(e, [50.0, 95.0]), e.max()))
            body.append([f"{name_of(model)}, {len(chosen)} poses on {below}", *cells])
    return table(["median / 95 % / worst", "N", "p0"], body)


def creep_table() -> str:
    """Errors of the creep forces."""
    rows = read("creep_forces")
    body = []
    for model in dict.fromkeys(r["model"] for r in rows):
        rows_of_model = [r for r in rows if r["model"] == model]
        cells = []
        for quantity in ("force", "moment"):
            e = np.array([float(r[quantity]) for r in rows_of_model])
            cells.append("{:.4f} / {:.4f} / {:.4f}".format(*np.percentile(e, [50.0, 95.0]), e.max()))
        body.append([model, *cells])
    return table(["creep forces on ellipses, 177 cases: median / 95 % / worst", "force", "moment"], body)


def time_table() -> str:
    """Time of one evaluation at a pose."""
    rows = [r for r in read("times") if r["table"] == "own_static"]
    body = [[name_of(r["model"]), r["what"], f"{float(r['median_us']):g}", f"{float(r['most_us']):g}"] for r in rows]
    return table(["one evaluation", "what", "median [us]", "95 % [us]"], body)


STEP_QUANTITIES = {"lateral": "µm", "yaw": "µrad", "N": "N", "Q": "N", "Y": "N"}
STEP_CASES = {
    "coach": "Manchester coach into R 300 m, 60 km/h",
    "coach-erri-low": "Manchester coach on ERRI low, 160 km/h",
    "freight": "laden freight wagon into R 300 m, 60 km/h",
    "tram": "tram car into R 25 m, 15 km/h",
    "gz18": "GZ18, R 300 m, AAR5, 60 km/h, 16 s",
}


def step_table() -> str:
    """Errors of the time step against a tight run: rms of the wheelset or wheel with the least and the largest, max."""
    rows, body = read("step_error"), []
    for case, title in STEP_CASES.items():
        for method, step in dict.fromkeys((r["method"], r["step_us"]) for r in rows if r["case"] == case):
            cells = {r["quantity"]: r for r in rows if (r["case"], r["method"], r["step_us"]) == (case, method, step)}
            label = {"default": " (default)", "rk44": " (RK44)"}.get(method, "")
            head = [title, f"{float(step) / 1e3:g}{label}", next(iter(cells.values()))["evaluations"]]
            for q in STEP_QUANTITIES:
                head.append(
                    "{} to {} / {}".format(*(plain(cells[q][name]) for name in ("rms_least", "rms_most", "max")))
                )
            body.append(head)
            title = ""
    heads = (f"{name} [{unit}]" for name, unit in STEP_QUANTITIES.items())
    return table(["case", "step [ms]", "evaluations", *heads], body)


def plain(number: str) -> str:
    """Three digits without a power of ten."""
    return f"{float(number):.3g}" if float(number) < 1e3 else f"{float(number):.0f}"


def yardstick() -> str:
    """Errors of every quantity of every comparison, and what is allowed."""
    files = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in COMPARISONS.glob("*.toml")}
    body, last = [], ""
    for row in read("yardstick"):
        file = files[row["comparison"]]
        first = [file["title"], REPORT["references"][file["beside"]]["name"], row["cases"]]
        errors = [float(row[name]) for name in ("median", "most", "worst")]
        limits = [row[f"{name}_limit"] for name in ("median", "most", "worst")]
        cells = " / ".join(f"{error:.2g}" for error in errors), " / ".join(limit or "-" for limit in limits)
        start = first if row["comparison"] != last else ["", "", row["cases"] if row["cases"] != first[2] else ""]
        how = next(q for q in file["quantities"] if q["name"] == row["quantity"])
        over = f", over {how['over']}" if "over" in how else ", relative" if how.get("error") != "absolute" else ""
        body.append([*start, (row["quantity"] + over).replace("_", " "), *cells, row["verdict"]])
        last = row["comparison"]
    return table(["comparison", "beside", "cases", "quantity", "median / 95 % / worst", "allowed", ""], body)


FIGURES: dict[str, Callable[[], Figure]] = {
    "standing_p0": pressures,
    "standing_cumulative": cumulative,
    "standing_pairs": by_pair,
    "standing_arcs": arcs,
    "standing_creep": creep_forces,
    "standing_cost": cost,
}
# --- pages --------------------------------------------------------------------------------------------


def values() -> dict[str, str]:
    """Figures that texts take by name: rows of the summary, and errors of every model on every table."""
    figures = REPORT["values"] | {row["id"]: row["value"] for row in REPORT["summary"] if "id" in row}
    for short, file in (("static", "own_static"), ("bench", "mbench_a22")):
        rows = read(file)
        for model in models(rows):
            for quantity in QUANTITIES:
                e = np.abs(errors(rows, model, quantity))
                figures[f"{short} {model} {quantity}"] = "{:.4f} / {:.4f}".format(*np.percentile(e, [50.0, 95.0]))
    for row in rows_of(creep_table()):
        figures[f"creep {row[0]} force"], figures[f"creep {row[0]} moment"] = row[1:]
    for model in NAMES:
        arc = [abs(float(r["p0"])) for r in read("arcs") if r["model"] == model]
        groove = [r for r in read("grooves") if r["model"] == model]
        if arc:
            figures[f"arcs {model} p0"] = f"{100.0 * max(arc):.1f} %"
        for quantity in ("approach", "p0") if groove else ():
            figures[f"grooves {model} {quantity}"] = (
                f"{100.0 * max(abs(float(r[quantity]) - 1.0) for r in groove):.1f} %"
            )
    for row in read("step_error"):
        name = "step {case} {method} {step_us} {quantity}".format(**row)
        figures[name] = f"{plain(row['rms_most'])} / {plain(row['max'])}"
    return figures


def rows_of(markdown: str) -> list[list[str]]:
    """Cells of a table without its head."""
    return [line.strip("| ").split(" | ") for line in markdown.splitlines()[2:]]


def summary(short: bool = False) -> str:
    """One row per quantity: the reference, the largest difference, the command; short: ten of them."""
    rows = [
        (row["quantity"], REPORT["references"][row["beside"]]["name"], row["value"], _code(row["command"]))
        for row in REPORT["summary"]
        if not short or row.get("short")
    ]
    return table(["quantity", "beside", "largest difference", "command"], rows)


def references() -> str:
    """Sources and licences of everything that figures are beside."""
    return table(
        ["name", "source", "licence"], [(r["name"], r["source"], r["licence"]) for r in REPORT["references"].values()]
    )


def _code(command: str) -> str:
    return command if command == "the same" else f"`{command}`"


PARTS: dict[str, Callable[[], str]] = {
    "short": partial(summary, short=True),
    "summary": summary,
    "steps": step_table,
    "references": references,
    "static": static_tables,
    "arcs": arc_table,
    "others": other_tables,
    "oracle": oracle_table,
    "creep": creep_table,
    "times": time_table,
    "yardstick": yardstick,
}


def section(content: dict[str, Any]) -> list[str]:
    """Paragraphs of one section of a page."""
    paragraphs = [f"## {content['title']}"]
    origin = []
    if "beside" in content:
        origin.append(f"Beside: {REPORT['references'][content['beside']]['name']}.")
    if "command" in content:
        origin.append(f"Command: `{content['command']}`.")
    paragraphs += [" ".join(origin), content.get("text", "").strip()]
    if "picture" in content:
        paragraphs.append("![{1}](../figures/{0})".format(*content["picture"]))
    if "made" in content:
        paragraphs.append(PARTS[content["made"]]())
    if "rows" in content:
        paragraphs.append(table(content["head"], content["rows"]))
    return [*paragraphs, content.get("after", "").strip()]


def pages() -> dict[Path, str]:
    """Text of every page of the report and of README.md, by its path."""
    known = values()
    made = {}
    for name, page in REPORT["pages"].items():
        paragraphs = [f"# {page['title']}", page.get("text", "").strip()]
        for content in page["sections"]:
            paragraphs += section(content)
        paragraphs.append("<!-- made by docs/figures/make_standing.py from docs/data: not to be edited -->")
        made[PAGES / f"{name}.md"] = "\n\n".join(filter(None, paragraphs)) + "\n"
    start, end = MARKS
    before, rest = README.read_text(encoding="utf-8").split(start)
    made[README] = before + start + REPORT["readme"]["text"].lstrip() + end + rest.split(end)[1]
    return {path: re.sub(r"\{\{(.+?)\}\}", lambda m: known[m[1]], text) for path, text in made.items()}


def main() -> None:
    """Draw all figures and write all pages."""
    with style():
        for name, draw in FIGURES.items():
            print(save(draw(), HERE / f"{name}.png"))
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
