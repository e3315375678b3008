"""Runs of mutants that the checks accept. Run: python campaigns/accepted.py [N] [--json] [--seed S]

Numbers of shipped scenarios and of their vehicles are changed, by factors from 0.1 to 10 for the most part. What the
checks accept runs for three metres from a random place. At every sample all numbers of the contacts must be finite,
normal forces must not pull, no strip may pull more than mu N, creep must dissipate on every patch, and the work of all
contacts on the vehicle since the start must not exceed what their springs held then. Runs without a steady start, runs
that stop (a derailment), and those that take more than 30 s of processor time are counted beside. Ctrl-C ends the
count and tells what there is.
"""

import argparse
import json
import random
import re
import shutil
import signal
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from hostile import TooSlow, until_ctrl_c

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.result import result_of
from wrsim.analysis.motion.run import chosen_step
from wrsim.analysis.motion.start import start_state
from wrsim.errors import InputError, SimulationError
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import BodySystem

ROOT = Path(__file__).parents[1]
PAIRS = {
    "curve_r300.toml": "wheelset_s1002_steering.toml",
    "curve_r150_sharp.toml": "wheelset_s1002_leading.toml",
    "s_curve.toml": "wheelset_s1002_steering.toml",
    "lrv_curve.toml": "wheelset_lrv.toml",
    "manchester_r300.toml": "manchester_1.toml",
}
NUMBER = re.compile(r"(?<![\w\"./:-])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w\"/:])")
WAY = 3.0  # of a run [m]
LONGEST = 30.0  # processor time of a run [s]
COARSE = {"contact.strips": 12, "contact.cells": 4, "output.patches_at_m": [], "run.distance_m": WAY}
ELASTIC = 0.4
"""Energy in a contact over its normal force times its approach (Hertz)."""
WAVER = 0.02
"""Part of the work that goes to and fro which the sum over samples may miss."""


def mutated(text: str, rng: random.Random) -> str:
    """The text with one to three of its numbers changed, those in comments left alone."""
    lines = text.split("\n")
    places = [(i, m) for i, line in enumerate(lines) for m in NUMBER.finditer(line.partition("#")[0])]
    chosen = rng.sample(places, min(rng.randint(1, 3), len(places)))
    for i, m in sorted(chosen, key=lambda place: (place[0], -place[1].start())):
        value = float(m.group()) * 10.0 ** rng.uniform(-1.0, 1.0) * rng.choice((1, 1, 1, -1))
        whole = re.fullmatch(r"-?\d+", m.group()) is not None
        new = str(round(value)) if whole and abs(value) >= 1.0 else f"{value:.6g}"
        lines[i] = lines[i][: m.start()] + new + lines[i][m.end() :]
    return "\n".join(lines)


def accepted(folder: Path, rng: random.Random) -> Setup | None:
    """The set-up of a mutant that runs for some metres; None where the checks refuse it."""
    scenario, vehicle = rng.choice(list(PAIRS.items()))
    for place in (f"scenarios/{scenario}", f"models/vehicles/{vehicle}"):
        text = (ROOT / place).read_text()
        (folder / place).write_text(mutated(text, rng) if rng.random() < 0.6 else text)
    try:
        scenario_of_mutant = load(folder / "scenarios" / scenario, [folder / "models"])
        length = build(scenario_of_mutant).track.length
        start = {"run.start_distance_m": round(rng.uniform(0.0, max(length - WAY - 15.0, 0.0)), 2)}
        return build(scenario_of_mutant.with_values(COARSE | start))
    except InputError:
        return None


def went(setup: Setup) -> tuple[str, list[str]]:
    """How a run ended, and the laws that it broke."""
    law = force_law(setup)
    system = BodySystem(law.bodies, law)
    try:
        q, q_t = start_state(setup, law)
    except SimulationError:
        return "no steady start", []
    step, monitor = chosen_step(setup, law, q, q_t), Monitor(law, setup.plan.speed, system.work)
    duration = step * max(1, int(setup.plan.duration / step + 1e-6))
    motion = Integration(
        system, duration=duration, step=step, integrator=setup.plan.integrator, weight=law.vehicle.weight,
        monitor=monitor, monitor_interval=monitor.interval,
    ).run(q, q_t)  # fmt: skip
    problems = broken_laws(setup, law, motion)
    dataset = result_of(setup, law, motion, monitor.events()).dataset
    for name in ("Y", "Q", "X", "lateral_shift", "yaw", "roll", "speed"):
        if not np.isfinite(dataset[name].values).all():
            problems.append(f"{name} is not a number")
    return motion.status, problems


def broken_laws(setup: Setup, law: VehicleOnTrack, motion: Motion) -> list[str]:
    """What the contacts at the samples of a motion do that they must not."""
    bare = VehicleOnTrack(law.vehicle, law.track, (), speed=law.speed, start=law.start, drive=law.drive)
    whole, rest = np.zeros(law.size), np.zeros(bare.size)
    n = 6 * len(law.bodies)
    power, held = [], 0.0
    problems: set[str] = set()
    law.set_search_start(law.start)
    law.follow(True)
    bare.set_search_start(bare.start)
    samples = slice(0, -1 if motion.status == "stopped" else None)
    for t, q, q_t in zip(motion.times[samples], motion.q[samples], motion.q_t[samples], strict=True):
        law(t, q, q_t, whole)
        bare(t, q[: bare.size], q_t[: bare.size], rest)
        power.append(float((whole[:n] - rest[:n]) @ q_t[:n]))
        for pair in law.wheels:
            for wheel in pair:
                arrays = wheel.model.arrays
                lobes = arrays.patches[: int(arrays.total["lobes"])]
                if not all(np.isfinite(lobes[name]).all() for name in lobes.dtype.names):
                    problems.add("a number of a patch is not finite")
                if (lobes["N"] < 0.0).any():
                    problems.add("a normal force pulls")
                if (lobes["wear"] < 0.0).any():
                    problems.add("creep forces give energy")
                if len(power) == 1:
                    held += ELASTIC * float(lobes["N"] @ lobes["approach"])
                for row, lobe in zip(arrays.strips, lobes, strict=False):
                    strips = row[: int(lobe["n_strips"])]
                    bound = strips["mu"] * strips["N"]
                    if (np.hypot(strips["Fx"], strips["Fy"]) > bound * (1.0 + 1e-9) + 1e-9).any():
                        problems.add("a strip pulls more than mu N")
    law.follow(False)
    powers = np.array(power)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (powers[1:] + powers[:-1]) * np.diff(motion.times[samples]))])
    waver = WAVER * float(np.abs(powers).sum() * motion.step)
    if not law.rails and (work > held + waver).any():
        problems.add(f"contacts give {work.max():.3g} J where their springs held {held:.3g} J")
    return sorted(problems)


def counted(number: int, rng: random.Random) -> tuple[dict[str, int], int]:
    """Ends of runs and broken laws, and how many mutants were refused on the way."""
    ends: Counter[str] = Counter()
    broken = refused = 0

    def stop(signal_number: int, stack: object) -> None:
        raise TooSlow

    signal.signal(signal.SIGVTALRM, stop)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("models", "scenarios"):
            shutil.copytree(ROOT / part, folder / part)
        plain = load(ROOT / "scenarios/curve_r300.toml")
        went(build(plain.with_values(COARSE)))  # kernels that are compiled now take their time outside of the limit
        for _ in until_ctrl_c(number):
            while (setup := accepted(folder, rng)) is None:
                refused += 1
            signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
            try:
                end, problems = went(setup)
            except TooSlow:
                end, problems = "too slow", []
            except Exception as fault:
                end, problems = "fault", [f"{type(fault).__name__}: {fault}"]
            finally:
                signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
            if problems:
                broken += 1
                keep = Path(tempfile.gettempdir()) / f"accepted_{sum(ends.values())}"
                shutil.copytree(folder, keep, dirs_exist_ok=True)
                print(f"{setup.title}: {'; '.join(problems)}; kept in {keep}", flush=True)
            ends[end] += 1
    return {**ends, "broken": broken}, refused


def main() -> None:
    """Count the runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", nargs="?", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ends, refused = counted(options.number, random.Random(options.seed))
    print(", ".join(f"{word} {number}" for word, number in ends.items()) + f"; refused on the way: {refused}")
    if options.json:
        print(json.dumps({"accepted": {"runs": sum(ends.values()) - ends["broken"], **ends, "refused": refused}}))
    raise SystemExit(int(ends["broken"] > 0))


if __name__ == "__main__":
    main()
