"""Contacts that several threads compute side by side."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from support.commands import refusal
from support.runs import FAST
from support.vehicles import ROOT

import wrsim
from wrsim.analysis.contacts import force_law
from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.placement import design_state

SCENARIO = ROOT / "scenarios/manchester_r300.toml"


def test_threads_change_no_bit():
    # strips start from their last answer, so that every state tells what the one before has left
    setup = build(load(SCENARIO).with_values({"contact.strips": 12, "run.start_distance_m": 70.0}))
    found = []
    for threads in (1, 2):
        law = force_law(replace(setup, threads=threads))
        q, q_t = design_state(law)
        wheels = slice(6 * len(law.wheels))
        rng, out = np.random.default_rng(3), np.zeros(law.size)
        law.follow(True)
        for _ in range(6):
            q[wheels] += 2e-5 * rng.standard_normal(q[wheels].shape)
            law(0.0, q, q_t, out)
            found.append(out.tobytes() + law.get_state().tobytes())
    assert found[:6] == found[6:]
    assert len(set(found)) == 6


def test_a_run_on_two_threads_gives_the_same_numbers():
    scenario = load(SCENARIO).with_values(FAST | {"run.start_distance_m": 40.0, "run.distance_m": 0.5})
    one, two = (wrsim.run(scenario, threads=threads).dataset for threads in (1, 2))
    assert one.identical(two)


def test_more_threads_than_cores_are_refused(monkeypatch):
    with pytest.raises(InputError, match=r"threads: must be a whole number from 1 to \d+.*not 100000"):
        force_law(replace(build(load(SCENARIO).with_values(FAST)), threads=100_000))
    assert "threads: must be" in refusal("run", str(SCENARIO), "--threads", "100000")
    monkeypatch.setitem(sys.modules, "numba.np.ufunc.omppool", None)
    with pytest.raises(InputError, match="need OpenMP"):
        wrsim.run(load(SCENARIO), threads=2)
