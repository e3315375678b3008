"""Runs a scenario as a new user does, and ends with 1 if anything was compiled for it. Called by ``.ci/wheel``."""

import sys
import time

from numba.core import event

begin = time.perf_counter()
with event.install_recorder("numba:compile") as recorder:
    import wrsim

    scenario = wrsim.load(sys.argv[1]).with_values({"run.distance_m": 5, "output.patches_at_m": [2]})
    result = wrsim.run(scenario)
compiled = [e.data["dispatcher"].py_func.__name__ for _, e in recorder.buffer if e.is_start]
print(f"{wrsim.__file__}: {result.status} after {time.perf_counter() - begin:.1f} s, {len(compiled)} kernels compiled")
print(*compiled)
sys.exit(bool(compiled) or result.status != "completed")
