"""What the compiled law of a vehicle promises: the same numbers without the compiler, and no allocation."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from support.allocations import allocations
from support.vehicles import manchester

from wrsim.core.body.vehicle_forces import vehicle_forces
from wrsim.geometry.track.segments import Arc
from wrsim.geometry.track.track import Track
from wrsim.simulation.design import design_state
from wrsim.simulation.law import VehicleOnTrack

PRINT = "from vehicle.test_vehicle_kernel import forces; print(*forces()[1])"


def forces():
    """Law of the coach on its springs alone in a canted curve, and the generalised forces of a state off balance."""
    track = Track.build([Arc(200.0, 300.0, cant=0.1)], 1.5)
    law = VehicleOnTrack(manchester(), track, (), speed=20.0, start=100.0, drive="wheels")
    q, q_t = design_state(law)
    rng, out = np.random.default_rng(1), np.zeros(law.size)
    q, q_t = q + 0.01 * rng.standard_normal(law.size), q_t + 0.2 * rng.standard_normal(law.size)
    law(0.0, q, q_t, out)
    return law, out, (0.0, q, q_t, out, law.arena.buffer, law.arena.index)


def test_the_law_gives_the_same_forces_without_the_compiler():
    root = str(Path(__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-c", PRINT],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join([root, *sys.path])},
        capture_output=True,
        text=True,
        check=True,
    )
    plain, compiled = np.array(run.stdout.split(), dtype=float), forces()[1]
    # compilers may fuse products and sums: round-off of positions of 100 m times 3e7 N/m
    assert np.abs(plain - compiled).max() < 1e-11 * np.abs(compiled).max()


def test_the_law_allocates_nothing():
    arguments = forces()[2]
    arrays = sum(isinstance(a, np.ndarray) for a in arguments)  # one record for each Python array at the door
    assert allocations(lambda n: vehicle_forces(*arguments), 1) == arrays
