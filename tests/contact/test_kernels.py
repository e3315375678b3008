"""What the compiled kernels promise: the same numbers without the compiler, and no allocation."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numba import njit
from support.allocations import allocations
from support.contacts import bench, contact_of, numbers, pair_model, settle

from wrsim.contact.settings import Friction
from wrsim.core.contact.wheel_rail import wheel_rail

POSES = (
    ("fastsim", 2e-3, 0.0),
    ("fastrip", 5.5e-3, 0.0),
    ("shen-hedrick-elkins", 7.5e-3, 0.012),
    ("polach", 7.5e-3, 0.012),
)
FRICTION = Friction(0.4, gauge_corner=0.1, falling_ratio=0.5)

EVALUATE = """
import numba, numpy as np
assert numba.config.DISABLE_JIT
from support.contacts import bench, contact_of, numbers, pair_model
from wrsim.contact.settings import Friction
for tangential, lateral, height, yaw in {poses}:
    stand = bench(pair_model("S1002/60E1 1:40", strips=6, cells=4, tangential=tangential, friction={friction}))
    stand.evaluate(lateral, height, yaw, 0.0)
    contact = contact_of(stand)
    print(*numbers(contact))
"""


def test_kernels_give_the_same_numbers_without_the_compiler():
    poses, compiled = [], []
    for tangential, lateral, yaw in POSES:
        stand = bench(pair_model("S1002/60E1 1:40", strips=6, cells=4, tangential=tangential, friction=FRICTION))
        solved, _ = settle(stand, lateral, yaw, 60e3)
        poses.append((tangential, lateral, solved.height, yaw))
        contact = contact_of(stand)
        compiled.append(numbers(contact))
    run = subprocess.run(
        [sys.executable, "-c", EVALUATE.format(poses=poses, friction=FRICTION)],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
        check=True,
    )
    plain = [[float(x) for x in line.split()] for line in run.stdout.splitlines()]
    for ours, theirs in zip(compiled, plain, strict=True):
        # compilers may fuse products and sums: round-off of coordinates over an approach of 1e-4 m
        scale = np.maximum(np.abs(ours), 1e-9)
        np.testing.assert_allclose(np.array(theirs) / scale, np.array(ours) / scale, atol=1e-8)


@njit
def repeat(n, *arguments):
    """Evaluations in a loop within compiled code."""
    status = 0
    for _ in range(n):
        status |= wheel_rail(*arguments)
    return status


@njit
def allocate(n):
    """For comparison: one small array each time."""
    total = 0.0
    for i in range(n):
        total += np.full(3, float(i))[1]
    return total


def test_an_evaluation_allocates_nothing():
    for tangential, lateral, yaw in POSES:
        stand = bench(pair_model("S1002/60E1 1:40", tangential=tangential, friction=FRICTION))
        settle(stand, lateral, yaw, 60e3)
        arrays = stand.wheels[0].model.arrays
        arguments = arrays.buffer, arrays.index
        # what is left is one record for each Python array at the door, however many evaluations follow
        assert allocations(repeat, 1000, *arguments) == allocations(repeat, 1, *arguments) == len(arguments)


def test_the_count_of_allocations_counts():
    assert allocations(allocate, 1000) == 1000
