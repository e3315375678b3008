"""Every contact model on every reference case: how near to CONTACT, beside CONTACT's own fast models.

    python campaigns/scoreboard.py REFERENCE [--models kik-piotrowski,kik-piotrowski/constant,half-space]
        [--tangential fastsim,fastsim/three,fastsim/three/parabolic,fastrip]
        [--tables static,benchmark,regions,angles,arcs,grooves,tangential]
        [--every N] [-o DIR] [--standing docs/data/standing]

REFERENCE: folder with own_static.csv, mbench_a22.csv, conformal.csv, tangential.csv and their kin, computed with
CONTACT 25.2; not part of this repository. A model is the value of ``normal`` in a scenario; options follow after
slashes: kik-piotrowski/constant (the paper's), strips=20 (any strip model), half-space/table (elements of the table's
size, area by counting them), half-space/level (points paired as CONTACT does), half-space/angle-corrected.

-o DIR: predictions as "TABLE MODEL.csv", one row a case: case_id, p0_MPa, area_mm2, approach_mm, N_N, Fx_N, n_patches.
--standing DIR: errors of all cases and times, as the figures of docs/validation/report.md read them; files there keep
what they hold of models that did not run.

Scoring. The truth is contact_conf_hs, or contact_planar where that is missing, on cases where it is one patch of one
connected region and met its load. Errors are |prediction / truth - 1|: median, 95 % (linear between order statistics),
largest, and the signed median.
"""

import argparse
import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

import numpy as np
from reference_contact import (
    Answer,
    Chosen,
    Row,
    arc_place,
    by_case,
    groove_answer,
    read,
    solve,
    static_answers,
)
from tangential_cases import score_tangential

from wrsim.contact.creep.laws import CREEP_LAWS, KERNEL_LAWS
from wrsim.contact.pose import Pose
from wrsim.contact.settings import Normal

QUANTITIES = {"p0_MPa": "pmax_MPa", "area_mm2": "area_mm2", "approach_mm": "pen_mm", "N_N": "Fn_N"}
PEERS = ("contact_planar", "kpec", "analyn")
DEFAULT_MODELS = ("kik-piotrowski/constant", *(n for n in get_args(Normal) if n != "half-space"), "half-space")
DEFAULT_TANGENTIAL = tuple(
    f"{name}{options}"
    for name in KERNEL_LAWS
    for options in ("", *(("/three", "/three/parabolic") if CREEP_LAWS[name].flexibility else ()))
)
TABLES = ("static", "benchmark", "regions", "angles", "arcs", "grooves", "tangential")

Values = dict[str, float]


# --- scoring ------------------------------------------------------------------------------------------


def single_region(rows: Sequence[Row]) -> bool:
    """One patch of one connected region that met its load."""
    r = rows[0]
    met_load = r["ierr"] == "0" and r.get("fz_ok", "1") in ("1", "True")
    return len(rows) == 1 and met_load and r.get("n_components", "1") in ("1", "1.0")


def truths(cases: dict[str, dict[str, list[Row]]]) -> dict[str, Row]:
    """The row of every case that has a truth."""
    rows_of_truth: dict[str, Row] = {}
    for name, methods in cases.items():
        for method in ("contact_planar", "contact_conf_hs"):  # the later wins
            if method in methods and single_region(methods[method]):
                rows_of_truth[name] = methods[method][0]
    return rows_of_truth


def peer(cases: dict[str, dict[str, list[Row]]], method: str) -> dict[str, Values]:
    """What a model inside the reference says, by case."""
    return {
        name: {q: float(rows[method][0][column]) for q, column in QUANTITIES.items()}
        for name, rows in cases.items()
        if method in rows and single_region(rows[method])
    }


def values_of(answer: Answer) -> Values:
    """An answer in the units of the tables."""
    return {
        "p0_MPa": 1e-6 * answer.p0,
        "area_mm2": 1e6 * answer.area,
        "approach_mm": 1e3 * answer.approach,
        "N_N": answer.normal_force,
        "Fx_N": -float(answer.force[0]),
        "n_patches": answer.n_patches,
    }


def ratios(truth: dict[str, Row], said: dict[str, Values], quantity: str) -> np.ndarray:
    """prediction / truth - 1 of the cases that the model has."""
    column = QUANTITIES[quantity]
    return np.array([said[c][quantity] / float(t[column]) - 1.0 for c, t in truth.items() if c in said])


def print_errors(truth: dict[str, Row], models: dict[str, dict[str, Values]]) -> None:
    """Median / 95 % / largest and signed median of every quantity and model."""
    print(f"{'':34s}" + "".join(f"{q:^30s}" for q in QUANTITIES))
    print(f"{'':28s}{'cases':>6s}" + "   median    95%    max  signed" * len(QUANTITIES))
    for name, said in models.items():
        cells = []
        for quantity in QUANTITIES:
            r = ratios(truth, said, quantity)
            if not len(r):
                cells.append(" " * 30)
                continue
            e = np.abs(r)
            middle, most = np.percentile(e, [50.0, 95.0])
            cells.append(f"   {middle:.4f} {most:.4f} {e.max():6.3f} {np.median(r):+.4f}")
        print(f"{name:28s}{sum(c in said for c in truth):6d}" + "".join(cells))
    print()


# --- tables -------------------------------------------------------------------------------------------


@dataclass
class Board:
    """What is asked for, and the answers found so far."""

    folder: Path
    models: list[Chosen]
    every: int
    answers: dict[tuple[str, str], dict[str, Answer]] = field(default_factory=dict)
    records: dict[str, list[dict[str, object]]] = field(default_factory=dict)

    def keep(self, table: str, /, **values: object) -> None:
        """Note a row of a table for the figures."""
        self.records.setdefault(table, []).append(values)

    def cases(self, file: str) -> dict[str, dict[str, list[Row]]]:
        """Cases of a reference table, every N-th of them."""
        cases = by_case(read(self.folder / f"{file}.csv"))
        return dict(list(cases.items())[:: self.every])

    def answers_to(self, file: str, chosen: Chosen) -> dict[str, Answer]:
        """Answers of a model to a static table; solved once."""
        key = (file, chosen.name)
        if key not in self.answers:
            cases = self.cases(file)
            answers = static_answers(chosen, cases, self.folder, file != "mbench_a22")
            self.answers[key] = {name: answer for name, _, answer in answers if answer is not None}
        return self.answers[key]


def score_static(board: Board, file: str, title: str) -> None:
    """Errors over a static table."""
    cases = board.cases(file)
    truth = truths(cases)
    models = {name: peer(cases, name) for name in PEERS}
    for chosen in board.models:
        answers = board.answers_to(file, chosen)
        models[chosen.name] = {name: values_of(answer) for name, answer in answers.items()}
    print(f"\n== {title}: {len(truth)} cases of one region")
    print_errors(truth, models)
    keep_errors(board, file, truth, models)
    for chosen in board.models:
        seconds = [a.seconds for a in board.answers_to(file, chosen).values()]
        unit = "with creep forces" if chosen.solver is None else "normal problem"
        board.keep("times", table=file, model=chosen.name, what=unit, median_us=f"{1e6 * np.median(seconds):.3g}",
                   most_us=f"{1e6 * np.percentile(seconds, 95.0):.3g}")  # fmt: skip
        print(f"{chosen.name:28s}one evaluation, {unit}: median {1e6 * np.median(seconds):.1f} us, "
              f"95 % {1e6 * np.percentile(seconds, 95.0):.1f} us")  # fmt: skip


def keep_errors(board: Board, file: str, truth: dict[str, Row], models: dict[str, dict[str, Values]]) -> None:
    """Note the errors [%] of every case: one row a case, a column for every model and quantity."""
    for case, row in truth.items():
        place = {"pair": row.get("pair", "S1002/UIC60"), "cant": row["cant_label"], "y_mm": row["y_ws_mm"]}
        errors = {
            f"{name} {q.rpartition('_')[0]}": f"{100.0 * (said[case][q] / float(row[c]) - 1.0):.3g}"
            if case in said
            else ""
            for name, said in models.items()
            if said
            for q, c in QUANTITIES.items()
        }
        board.keep(file, case=case, **place, **errors)


def score_regions(board: Board) -> None:
    """Cases with several regions: are the same found, and is N of each met?"""
    for file in ("own_static", "own_static_frictionless"):
        cases = board.cases(file)
        components: dict[str, list[Row]] = {}
        for row in read(board.folder / f"{file}_components.csv"):
            if row["method"] == "contact_conf_hs" and row.get("fz_ok", "1") in ("1", "True"):
                components.setdefault(row["case_id"], []).append(row)
        several = {name: rows for name, rows in components.items() if len(rows) > 1 and name in cases}
        print(f"\n== several regions, {file}: {len(several)} cases, {sum(map(len, several.values()))} regions")
        for chosen in board.models:
            answers = board.answers_to(file, chosen)
            same, errors, worst = 0, [], (0.0, "")
            for name, rows in several.items():
                regions = answers[name].regions if name in answers else ()
                same += len(regions) == len(rows)
                for row in rows:
                    force, place = float(row["N_comp_N"]), 1e-3 * float(row["y_tr_cog_mm"])
                    near = min(regions, key=lambda r, place=place: abs(r.place - place), default=None)
                    error = abs(near.normal_force / force - 1.0) if near is not None else 1.0
                    errors.append(error)
                    worst = max(worst, (error, name))
            e = np.array(errors)
            if len(e):
                board.keep(
                    "regions",
                    table=file,
                    model=chosen.name,
                    cases=len(several),
                    same_number=same,
                    regions=len(e),
                    within_5_percent=int((e < 0.05).sum()),
                    median=f"{np.median(e):.4f}",
                    most=f"{np.percentile(e, 95.0):.4f}",
                )
                print(f"{chosen.name:28s}same number of regions in {same} of {len(several)}; N of a region: median "
                      f"{np.median(e):.4f}, 95 % {np.percentile(e, 95.0):.4f}, within 5 %: {(e < 0.05).sum()} of "
                      f"{len(e)}; worst {worst[0]:.3f} ({worst[1]})")  # fmt: skip


def score_angles(board: Board) -> None:
    """Range of the contact angle over the patch, in cases of one region."""
    cases = board.cases("own_static")
    truth = {
        name: sorted(-np.degrees([float(row["ang_smin_rad"]), float(row["ang_smax_rad"])]))
        for name, row in truths(cases).items()
        if row["ang_smin_rad"]
    }
    print(f"\n== contact angle range over the patch: {len(truth)} cases; error of the range and of its ends [deg]")
    for chosen in board.models:
        answers = board.answers_to("own_static", chosen)
        spread, ends, good = [], [], 0
        for name, (low, high) in truth.items():
            if name not in answers:
                continue
            ours = sorted(np.degrees(answers[name].angles))
            error = abs((ours[1] - ours[0]) - (high - low))
            spread.append(error)
            ends.append(max(abs(ours[0] - low), abs(ours[1] - high)))
            good += error <= max(0.5, 0.05 * (high - low))
        board.keep(
            "angles",
            model=chosen.name,
            cases=len(spread),
            within=int(good),
            median_deg=f"{np.median(spread):.3f}",
            most_deg=f"{np.percentile(spread, 95.0):.3f}",
            worst_deg=f"{max(spread):.2f}",
        )
        print(f"{chosen.name:28s}range: median {np.median(spread):.3f}, 95 % {np.percentile(spread, 95.0):.3f}, "
              f"max {max(spread):.2f}; within 5 % or 0.5 deg: {good} of {len(spread)}; ends: median "
              f"{np.median(ends):.3f}, 95 % {np.percentile(ends, 95.0):.3f}")  # fmt: skip


ARC_KEYS = ("R_wheel_mm", "R_roll_mm", "alpha_nom_deg", "N_nom_N")


def arc_cases(folder: Path) -> dict[tuple[str, ...], dict[str, Row]]:
    """Frictionless arcs: pose -> method -> row with the smallest elements."""
    poses: dict[tuple[str, ...], dict[str, Row]] = {}
    for row in read(folder / "conformal.csv"):
        if row["tang"] == "0" and row["ierr"] == "0":
            methods = poses.setdefault(tuple(row[key] for key in ARC_KEYS), {})
            held = methods.get(row["method"])
            if held is None or float(row["dx_mm"]) < float(held["dx_mm"]):
                methods[row["method"]] = row
    return {pose: methods for pose, methods in poses.items() if "contact_conf_hs" in methods}


def arc_figures(row: Row) -> Values:
    """Width, p0, variation and direction in a row of the reference."""
    turned = float(row["ang_at_smax_deg"]) - float(row["ang_at_smin_deg"]) if row["ang_at_smax_deg"] else np.nan
    return {
        "width": float(row["s_max_mm"]) - float(row["s_min_mm"]),
        "p0": float(row["pmax_MPa"]),
        "angles": abs(turned),
        "direction": float(row["force_angle_deg"]),
    }


def arc_errors(board: Board) -> dict[str, dict[str, list[Values]]]:
    """Model -> wheel radius -> errors of every pose: relative, of the direction in degrees."""
    errors: dict[str, dict[str, list[Values]]] = {}
    for pose, methods in list(arc_cases(board.folder).items())[:: board.every]:
        truth = methods["contact_conf_hs"]
        exact = arc_figures(truth)
        said = {m: arc_figures(r) for m, r in methods.items() if m != "contact_conf_hs"}
        place = arc_place(*(1e-3 * float(truth[key]) for key in ("R_wheel_mm", "R_rail_mm", "R_roll_mm")))
        for chosen in board.models:
            case = Pose("_".join(pose), 1e-3 * float(truth["y_ws_mm"]), 0.0, float(truth["Fz_req_N"]))
            answer = solve(chosen, place, case, element=1e-3 * float(truth["dx_mm"]))
            if answer is not None:
                angles = np.degrees(answer.angles)
                said[chosen.name] = {
                    "width": 1e3 * sum(r.width for r in answer.regions),
                    "p0": 1e-6 * answer.p0,
                    "angles": float(abs(angles[1] - angles[0])),
                    "direction": float(np.degrees(np.arctan2(-answer.force[1], answer.force[2]))),
                }
        for name, values in said.items():
            row = {q: values[q] / exact[q] - 1.0 for q in ("width", "p0", "angles")}
            row["direction"] = values["direction"] - exact["direction"]
            errors.setdefault(name, {}).setdefault(pose[0], []).append(row)
            case = dict(zip(ARC_KEYS, pose, strict=True))
            board.keep("arcs", model=name, **case, **{q: f"{e:.4f}" for q, e in row.items()})
    return errors


def score_arcs(board: Board) -> None:
    """Rail corner R13 in hollow wheels: worst signed errors by the wheel's radius."""
    errors = arc_errors(board)
    radii = sorted({r for by_radius in errors.values() for r in by_radius}, key=float)
    print("\n== rail corner R13 in hollow wheels, frictionless: worst error over loads, angles and rolling radii")
    for quantity in ("width", "p0", "angles", "direction"):
        unit = "deg" if quantity == "direction" else "1"
        print(f"{quantity + ' [' + unit + ']':28s}" + "".join(f"{'R' + r:>9s}" for r in radii))
        for name, by_radius in errors.items():
            cells = []
            for r in radii:
                e = np.array([row[quantity] for row in by_radius.get(r, [])])
                cells.append(f"{e[np.argmax(np.abs(e))]:+9.3f}" if len(e) and np.isfinite(e).all() else " " * 9)
            print(f"  {name:26s}" + "".join(cells))


GROOVES = {
    # after Li 2002, in CONTACT's test bench: turning rate [rad/s]; approach [mm], p0 [MPa], width, length [mm]
    # (half-space influence, elements of 0.25 x 0.096 mm)
    "ball R10/R420, groove R10.25": (10.25, 1.0002301, (0.02237, 530.2, 5.75, 6.23)),
    "ball R10/R420, groove R10.10": (10.10, 1.0004411, (0.01939, 409.3, 8.75, 5.46)),
}


def score_grooves(board: Board) -> None:
    """A ball in a deep groove against published figures."""
    print("\n== ball in a deep groove, 10 kN, rolling with friction 0.3: ratio to CONTACT's figures")
    print(f"{'':28s}{'':32s}{'approach':>9s}{'p0':>8s}{'width':>8s}{'length':>8s}")
    for case, (radius, spin, published) in GROOVES.items():
        for chosen in board.models:
            answer = groove_answer(chosen, 1e-3 * radius, spin)
            if answer is None:
                continue
            region = answer.regions[0]
            ours = 1e3 * answer.approach, 1e-6 * answer.p0, 1e3 * region.width, 1e3 * region.length
            cells = "".join(f"{a / b:8.4f}" for a, b in zip(ours, published, strict=True))
            quantities = dict(zip(("approach", "p0", "width", "length"), cells.split(), strict=True))
            board.keep("grooves", case=case, model=chosen.name, **quantities)
            print(f"{chosen.name:28s}{case:32s} {cells}")


# --- the script ---------------------------------------------------------------------------------------


def write_predictions(board: Board, directory: Path) -> None:
    """The answers to the static tables, in the form of a scoring program."""
    directory.mkdir(parents=True, exist_ok=True)
    for (file, model), answers in board.answers.items():
        path = directory / f"{file} {model.replace('/', ' ')}.csv"
        rows: Iterable[Values] = [values_of(a) for a in answers.values()]
        with path.open("w", newline="") as out:
            writer = csv.writer(out)
            writer.writerow(["case_id", "p0_MPa", "area_mm2", "approach_mm", "N_N", "Fx_N", "n_patches"])
            for name, row in zip(answers, rows, strict=True):
                writer.writerow([name, *(f"{v:.9g}" for v in row.values())])


def write_standing(board: Board, directory: Path) -> None:
    """The rows that were noted, a file for every table; what the files hold of models that did not run stays."""
    directory.mkdir(parents=True, exist_ok=True)
    for table, rows in board.records.items():
        path = directory / f"{table}.csv"
        rows = beside(read(path) if path.is_file() else [], rows)
        with path.open("w", newline="") as out:
            writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


def beside(before: Sequence[Row], rows: Sequence[dict[str, object]]) -> list[dict[str, object]]:
    """New rows with those of other models: columns of the same case, or rows."""
    if "model" in rows[0]:
        ran = {row["model"] for row in rows}
        return [*(dict(row) for row in before if row["model"] not in ran), *rows]
    known = {row["case"]: row for row in before}
    return [{**known.get(str(row["case"]), {}), **row} for row in rows]


def main() -> None:
    """Print the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", type=Path)
    parser.add_argument("--models", default=",".join(DEFAULT_MODELS))
    parser.add_argument("--tangential", default=",".join(DEFAULT_TANGENTIAL))
    parser.add_argument("--tables", default=",".join(TABLES))
    parser.add_argument("--every", type=int, default=1, help="take every N-th case")
    parser.add_argument("-o", "--output", type=Path, help="folder for the predictions")
    parser.add_argument("--standing", type=Path, help="write the errors of all cases for the figures")
    choices = parser.parse_args()
    tables = choices.tables.split(",")
    if unknown := set(tables) - set(TABLES):
        raise SystemExit(f"--tables {','.join(sorted(unknown))}: allowed: {','.join(TABLES)}")
    board = Board(choices.reference, [Chosen.parse(m) for m in choices.models.split(",")], choices.every)
    if "static" in tables:
        score_static(board, "own_static", "S1002, 60E1, 54E1 and a worn pair, rolling (own_static.csv)")
        score_static(board, "own_static_frictionless", "the same, frictionless (own_static_frictionless.csv)")
    if "benchmark" in tables:
        score_static(board, "mbench_a22", "Manchester contact benchmark A-2.2 (mbench_a22.csv)")
    if "regions" in tables:
        score_regions(board)
    if "angles" in tables:
        score_angles(board)
    if "arcs" in tables:
        score_arcs(board)
    if "grooves" in tables:
        score_grooves(board)
    if "tangential" in tables:
        rows = read(board.folder / "tangential.csv")
        flat = [m for m in board.models if "/constant" not in m.name]  # no difference on an ellipse
        for record in score_tangential(rows, flat, choices.tangential.split(","), board.every):
            board.keep("creep_forces", **record)
    if choices.output:
        write_predictions(board, choices.output)
    if choices.standing:
        write_standing(board, choices.standing)


if __name__ == "__main__":
    main()
