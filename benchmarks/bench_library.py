"""Time of a moving contact from C beside Python, in turns. Run: python benchmarks/bench_library.py [--rounds 5]

The wheel moves sideways by up to 0.6 um from call to call, as in benchmarks/bench_contact.py; each contact starts from
the last one. Microseconds of processor time a contact, medians of the rounds: from C through the library, from Python
through the bare kernel, and through ``ContactModel.evaluate``, which copies the results. Needs a C compiler.
"""

import argparse
import math
import subprocess
import tempfile
import time
from pathlib import Path

import blas_threads  # noqa: F401 (before numpy)
import numpy as np

from wrsim import ContactSettings, Pose, contact_model, load_profile
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.library.build import build_library
from wrsim.contact.model import ContactModel
from wrsim.contact.wheel_rail import wheel_rail
from wrsim.jit import Array
from wrsim.simulation.pose_solver import PoseSolver

RADIUS, CALLS = 0.46, 2000
POSES = (Pose("tread", 3e-3, 2e-3, 55e3), Pose("tread and root", 5.06e-3, 1e-3, 55e3), Pose("flange", 8e-3, 1e-2, 55e3))
PROGRAM = """
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "wrsim_contact.h"

int main(int count, char **words)
{
    wrsim_contact *contact;
    double pose[12], at;
    int calls = atoi(words[2]);
    if (count != 15 || wrsim_contact_open(words[1], &contact, NULL, 0) != 0) return 1;
    for (int i = 0; i < 12; i++) pose[i] = atof(words[3 + i]);
    at = pose[1];
    wrsim_contact_follow(contact, 1);
    wrsim_contact_evaluate(contact, pose, pose + 3, pose + 6, pose + 9, 0.0);
    clock_t began = clock();
    for (int i = 1; i <= calls; i++) {
        wrsim_contact_result result;
        pose[1] = at + 2e-6 * sin(0.3 * i);
        if (wrsim_contact_evaluate(contact, pose, pose + 3, pose + 6, pose + 9, 0.0) < 0) return 2;
        wrsim_contact_forces(contact, &result);
    }
    printf("%.6g", 1e6 * (double)(clock() - began) / CLOCKS_PER_SEC / calls);
    return 0;
}
"""


def from_c(folder: Path, pose: Array) -> float:
    """Microseconds a contact in the program."""
    command = [str(folder / "time"), str(folder / "contact"), str(CALLS), *(repr(float(x)) for x in pose)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def from_python(model: ContactModel, pose: Array, whole: bool) -> float:
    """Microseconds a contact in this process; whole: with `ContactModel.evaluate`, else the kernel alone."""
    arrays, moved = model.arrays, pose.copy()
    arrays.follow(True)
    parts = moved.reshape(4, 3)
    model.evaluate(*parts)
    began = time.process_time()
    for i in range(1, CALLS + 1):
        moved[1] = pose[1] + 2e-6 * math.sin(0.3 * i)
        if whole:
            model.evaluate(*parts)
        else:
            arrays.pose[1] = moved[1]
            wheel_rail(arrays.buffer, arrays.index)
    return 1e6 * (time.process_time() - began) / CALLS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    wheel, rail = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml").inclined(1 / 40)
    origin = (0.7175 - rail.gauge_point()[0], -rail.top[1])
    print(f"{'us a contact':32s}{'C':>8s}{'kernel':>8s}{'evaluate':>10s}{'kernel / C':>12s}{'evaluate / C':>14s}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        build_library(folder)
        (folder / "time.c").write_text(PROGRAM)
        command = ["cc", "-O2", "time.c", "-I.", "-L.", f"-Wl,-rpath,{folder}", "-lwrsim_contact", "-lm", "-o", "time"]
        subprocess.run(command, cwd=folder, check=True)
        for normal in ("kik-piotrowski", "strips"):
            model = contact_model(wheel, rail, RADIUS, ContactSettings(normal=normal))  # type: ignore[arg-type]
            model.save_for_library(folder / "contact")
            bench = PoseSolver([WheelOnRail(model, 1, 0.75, origin)], True, RADIUS)
            for place in POSES:
                model.arrays.follow(False)
                bench.solve(place)
                pose = model.arrays.pose.copy()
                times = [
                    (from_c(folder, pose), from_python(model, pose, False), from_python(model, pose, True))
                    for _ in range(rounds)
                ]
                c, kernel, evaluate = np.median(times, axis=0)
                ratios = np.median([(k / c, e / c) for c, k, e in times], axis=0)
                row = f"{c:8.1f}{kernel:8.1f}{evaluate:10.1f}{ratios[0]:12.2f}{ratios[1]:14.2f}"
                print(f"{f'{normal}, {place.name}':32s}{row}", flush=True)


if __name__ == "__main__":
    main()
