"""How fast a wheelset runs through a curve, and where the time goes. Run: python benchmarks/bench_run.py [SCENARIO]

Integrates the scenario at h = 0.5 ms and prints simulated over computing time (processor time, which a busy machine
disturbs less than wall time; minimum of three), the cost of one evaluation of the force law in the middle of the run,
and what is left for Exudyn and the samples.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from wrsim.analysis.motion.forces import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import integrate
from wrsim.simulation.system import System

STEP = 5e-4
STAGES = 4  # of RK44


def main() -> None:
    """Print the table."""
    shipped = Path(__file__).parents[1] / "scenarios" / "curve_r300.toml"
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped
    print(f"{file.name}, h = {STEP * 1e3:g} ms, one core")
    for strips, cells in ((40, 20), (25, 12)):
        scenario = load(file).with_values({"contact.strips": strips, "contact.cells": cells})
        setup = build(scenario)
        law = force_law(setup)
        q, q_t = start_state(setup, law)
        system = System(law.bodies, law, law.dampers)
        integrate(system, q, q_t, duration=0.05, step=STEP)
        best = np.inf
        for _ in range(3):
            law.look_near(setup.plan.start)
            began = time.process_time()
            motion = integrate(
                system, q, q_t, duration=setup.plan.duration, step=STEP, sample_interval=setup.plan.output_interval
            )
            best = min(best, time.process_time() - began)
        stage = 1e6 * best / (motion.end / STEP * STAGES)
        out = np.zeros(law.size)
        one = np.inf
        for i in range(0, len(motion.times), max(1, len(motion.times) // 40)):
            law.look_near(setup.plan.start + setup.plan.speed * motion.times[i])
            began = time.process_time()
            for _ in range(200):
                law(motion.times[i], motion.q[i], motion.q_t[i], out)
            one = min(one, (time.process_time() - began) / 200) if i else one
        print(
            f"  {strips} strips x {cells} cells: {motion.end / best:.2f} times real time; {stage:.1f} us a stage, "
            f"of which the cheapest force law of the run takes {1e6 * one:.1f}"
        )


if __name__ == "__main__":
    main()
