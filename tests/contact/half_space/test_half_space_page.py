"""docs/half_space.md: the examples of the page run as they stand and say what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def names():
    """What the page's examples leave, run one after the other from the root of the repository."""
    page = (ROOT / "docs/half_space.md").read_text()
    examples = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        for example in examples:
            exec(compile(example, "docs/half_space.md", "exec"), found)
    return found


def test_a_pose_is_solved_by_the_model_and_by_other_elements(names):
    contact, patch = names["contact"], names["exact"].patches[0]
    assert contact.status == 0
    # default elements against 0.2 mm
    assert names["exact"].force == pytest.approx(contact.force, rel=0.01, abs=0.002 * contact.force[2])
    assert patch.grid.dx == patch.grid.ds == 2e-4
    assert (np.hypot(*patch.q) <= 0.35 * patch.p * (1.0 + 1e-9)).all()


def test_a_load_is_carried(names):
    pose = names["solved"].wheelset().isel(pose=0, wheel=0)
    assert pose["pose_message"].item() == ""
    assert pose["Q"].item() == pytest.approx(60e3, rel=1e-4)
    assert pose["p0"].values[0] == pytest.approx(names["patch"].p.max().item(), rel=1e-6)
    assert pose["p0"].values[0] > 5e8
