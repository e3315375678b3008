"""Candidates evaluated by a function in the place of simulations: markers as a worker leaves them."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, Marker, Work, write_marker

POSE = """
title = "Pose"
analysis = "static"
[vehicle]
model = "vehicles/wheelset_s1002.toml"
[track]
gauge_mm = 1435
rail = "rails/60E1.toml"
inclination = "1:40"
[static]
target = "wheel"
side = "right"
lateral_mm = 0.5
yaw_mrad = 0.5
load_kN = 60
roll_mrad = 0
"""


def work_of(function: Callable[..., Mapping[str, float | None]], statuses: Callable[..., str] | None = None) -> Work:
    """Workers that write what a function gives of the values of a case, by the last parts of their keys."""

    def work(plan: Plan, todo: Sequence[int]) -> None:
        for case in (plan.cases[i] for i in todo):
            values: dict[str, Any] = {key.rpartition(".")[2]: value for key, value in case.values.items()}
            status = COMPLETED if statuses is None else statuses(**values)
            numbers = dict(function(**values)) if status == COMPLETED else {}
            folder = plan.folder_of(case)
            marker = Marker(case.name, case.label, status, "", numbers, dict.fromkeys(numbers, ""))
            marker.outputs, marker.time_limit = plan.outputs_digest, plan.time_limit
            write_marker(folder, marker)

    return work


def search_file(folder: Path, text: str) -> Path:
    """A file of a search over poses, with a hook whose numbers nobody computes."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pose.toml").write_text(POSE)
    (folder / "hook.py").write_text("def numbers(result):\n    return {'f': 0.0, 'g': 0.0, 'h': 0.0}\n")
    file = folder / "search.toml"
    file.write_text(f'base = "pose.toml"\n{text}')
    return file
