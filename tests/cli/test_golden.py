"""What commands print, word by word, and which files they leave: tests/data/golden has a file for each.

Words are compared to the letter, spaces between them and the last digits of numbers are not. After a change that is
meant: WRSIM_GOLDEN=write python -m pytest tests/cli/test_golden.py, and read what ``git diff`` says."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from support.scenario_texts import CURVE, STATIC
from support.synthetic_result import curve_run, static_poses
from support.synthetic_run import Q0, curve, run, sines
from typer.testing import CliRunner

from wrsim.cli import application
from wrsim.results import Result

app = application()

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests/data/golden"
NUMBER = re.compile(r"[-−+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
COMMANDS = {
    "check": "check DIR/curve.toml",
    "check_poses": "check DIR/poses.toml",
    "show": "show DIR/run",
    "show_stopped": "show DIR/stopped",
    "show_poses": "show DIR/poses",
    "diff": "diff DIR/run DIR/stopped --tolerance 0.01",
    "assess": "assess DIR/forces --scenario DIR/assessed.toml -o OUT",
    "ride": "ride DIR/sines -o OUT",
    "vehicle": "vehicle vehicles/manchester_1.toml --cant-deficiency 150 --twist 5 --twist-test -o OUT/vehicle.png",
    "conicity": "conicity wheels/cone_1in20.toml rails/60E1.toml --gauges-mm 1434 1436 2 -o OUT",
    "conicity_curves": "conicity wheels/S1002.toml rails/60E1.toml --curve-m 300 -o OUT",
    "profile": "profile wheels/S1002.toml -o OUT/wheel.png",
    "track": "track DIR/curve.toml -o OUT/track.png",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands read: scenarios and results that are made up."""
    folder = tmp_path_factory.mktemp("golden")
    over = 'estimate_over = ["cant_deficiency", "speed"]\nestimate_cant_deficiency_mm = 150\n'
    for name, text in (("curve", CURVE), ("poses", STATIC), ("assessed", f"{CURVE}\n[assessment]\n{over}")):
        (folder / f"{name}.toml").write_text(text)
    forces = run(900.0, curvature=curve(300.0), y=lambda s: (0.2 * Q0 + 1e3 * np.sin(s), 65e3 + 20.0 * s))
    datasets = {"run": curve_run(samples=60), "stopped": curve_run(samples=60, stopped=True), "poses": static_poses()}
    for name, dataset in (datasets | {"forces": forces.dataset, "sines": sines().dataset}).items():
        Result(dataset).save(folder / name / "result.nc")
    return folder


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_prints_what_it_printed(name: str, folder: Path, tmp_path: Path) -> None:
    arguments = COMMANDS[name].replace("DIR", str(folder)).replace("OUT", str(tmp_path)).split()
    done = CliRunner().invoke(app, arguments, env={"COLUMNS": "160", "NO_COLOR": "1"})
    text = done.output.replace(str(folder), "DIR").replace(str(tmp_path), "OUT").replace(str(ROOT), "ROOT")
    left = sorted(str(file.relative_to(tmp_path)) for file in tmp_path.rglob("*") if file.is_file())
    text = "\n".join([re.sub(r" +\n", "\n", text), *left, ""])
    file = GOLDEN / f"{name}.txt"
    if os.environ.get("WRSIM_GOLDEN") == "write":
        file.write_text(text, encoding="utf-8")
    wanted = file.read_text(encoding="utf-8")
    assert NUMBER.sub("#", text).split() == NUMBER.sub("#", wanted).split(), f"{text}\nsee {__doc__}"
    numbers, kept = ([float(n.replace("−", "-")) for n in NUMBER.findall(t)] for t in (text, wanted))
    assert numbers == pytest.approx(kept, rel=5e-3, abs=1e-4)
