"""A run that dies leaves what it has computed, and goes on with the same numbers to the bit."""

import os
import signal
from collections.abc import Iterator
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.commands import call, forked, ok, refusal
from support.runs import FAST, SCENARIOS, straight

import wrsim.analysis.motion.record as record_module
import wrsim.analysis.motion.run as run_module
from wrsim import InputError, Result, WrsimError, load, run
from wrsim.analysis import recorded
from wrsim.analysis.motion.monitor import Monitor
from wrsim.results.run_file import RunFile, records_of
from wrsim.simulation import recorder as recorders
from wrsim.simulation.bodies import Solid
from wrsim.simulation.force_law import ForceLaw
from wrsim.simulation.integrate import Integration, Motion, recorded_motion
from wrsim.simulation.recorder import Recorder
from wrsim.simulation.system import BodySystem

BODY = Solid(1500.0, (900.0, 100.0, 900.0))
Q0 = np.array([0.46, 0.0, 0.01, 0.0, 0.0, 0.0])
V0 = np.array([0.0, 10.0, 0.0, 0.0, 0.0, 21.0])
STEP = 1.0 / 3000.0  # no binary fraction
HEADER = {"integrator": "generalised-alpha", "step_s": STEP, "start_s": 0.0}


class Play(ForceLaw):
    """A lateral spring with 12 mm of play, pushed by a force that depends on the time: it remembers where it stands."""

    def __init__(self) -> None:
        self.place = 0.0

    def __call__(self, t: float, q: Any, q_t: Any, out: Any) -> None:
        self.place = min(max(self.place, q[2] - 6e-3), q[2] + 6e-3)
        out.fill(0.0)
        out[2] = -6e5 * self.place + 1e4 * np.sin(7.3 * t)

    def get_state(self) -> Any:
        return np.array([self.place])

    def set_state(self, memory: Any) -> None:
        self.place = float(memory[0])


def play(recorder: recorders.Recorder | None = None, seconds: float = 0.5) -> Motion:
    """A run of the body on that spring, with a checkpoint every 7 steps."""
    return Integration(BodySystem([BODY], Play()), duration=seconds, step=STEP, sample_interval=2 * STEP, segment=7,
        recorder=recorder,
    ).run(Q0, V0)  # fmt: skip


@cache
def uncut() -> Motion:
    """The whole run."""
    return play()


def same(a: Motion, b: Motion) -> bool:
    """To the bit."""
    states = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("times", "q", "q_t"))
    return states and (a.status, a.cause, a.reason, a.work) == (b.status, b.cause, b.reason, b.work)


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flush every millisecond."""
    monkeypatch.setattr(recorders, "FLUSH_INTERVAL", 1e-3)


@pytest.fixture
def kept(tmp_path: Path, often: None) -> Iterator[Path]:
    """The file of a whole run."""
    path = tmp_path / "x.part"
    with closing(Recorder.create(path, HEADER, 6)) as recorder:
        assert same(play(recorder), uncut())
    yield path


def resumed(path: Path) -> Motion:
    with closing(Recorder.continued(path)) as recorder:
        return play(recorder)


def test_a_file_cut_anywhere_is_read_as_far_as_it_is_whole_and_goes_on_to_the_same_end(kept):
    data, whole = kept.read_bytes(), uncut()
    records = list(records_of(kept))
    assert len(records) > 20
    ends = [record.end for record in records[1:]]
    known = 0.0
    for cut in np.linspace(ends[0] + 1, len(data) - 1, 5).astype(int):
        kept.write_bytes(data[:cut])
        assert list(records_of(kept))[-1].end == max(end for end in ends if end <= cut)
        part = recorded_motion(kept)
        assert (part.status, part.cause) == ("stopped", "cut-off")
        assert known <= part.end
        known = part.end
        n = len(part.times) - 1  # the last one may be a checkpoint between two samples
        assert np.array_equal(part.q[:n], whole.q[:n])
        assert same(resumed(kept), whole)
    assert known > 0.4


def test_a_whole_file_is_played_back_without_a_step_a_damaged_one_up_to_its_damage(kept, monkeypatch):
    data, whole = bytearray(kept.read_bytes()), uncut()
    for place in (len(data) // 3, len(data) // 2, len(data) - 3):
        broken = data.copy()
        broken[place] ^= 0x10
        kept.write_bytes(broken)
        assert recorded_motion(kept).end <= 0.5 * place / len(data) + 0.05
        assert same(resumed(kept), whole)
    whole = uncut()
    monkeypatch.setattr(BodySystem, "solve", None)
    assert same(resumed(kept), whole)
    assert same(recorded_motion(kept), whole)


def test_a_full_disk_ends_the_run_with_one_sentence_and_a_readable_file(kept):
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    records = list(records_of(kept))
    file = RunFile(kept)
    file.cut(records[-1].end)
    file.close()
    with open("/dev/full", "r+b", buffering=0) as file._stream, pytest.raises(WrsimError, match=r"is full \(0\.1 kB"):
        file.append({"rows": 0}, np.zeros(12))
    assert len(list(records_of(kept))) == len(records)


def test_a_file_of_something_else_is_refused(tmp_path):
    path = tmp_path / "x.part"
    for content, message in ((b"\x89HDF....", "not the file of a run"), (b"wrsim", "cut off before its start")):
        path.write_bytes(content)
        with pytest.raises(InputError, match=message):
            recorded_motion(path)
    with pytest.raises(InputError, match="there is no such file"):
        recorded_motion(tmp_path / "y.part")


class Crossings:
    """A monitor that notes when the body crosses the centre line; stops when it has done so ``most`` times."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.side = 1.0
        self.times: list[float] = []

    def __call__(self, t: float, q: Any, q_t: Any) -> str | None:
        if q[2] * self.side < 0.0:
            self.side = -self.side
            self.times.append(t)
        return f"{self.most} crossings" if len(self.times) >= self.most else None

    def get_state(self) -> Any:
        return np.array([self.side, *self.times])

    def set_state(self, memory: Any) -> None:
        self.side, self.times = float(memory[0]), list(memory[1:])


def test_what_the_monitor_has_noted_survives_a_death_in_the_run_and_behind_it(tmp_path, often):
    def watched(recorder: recorders.Recorder | None) -> tuple[Motion, list[float]]:
        watch = Crossings(4)
        system = BodySystem([BODY], Play())
        motion = Integration(
            system, duration=1.0, step=STEP, sample_interval=STEP, segment=7, monitor=watch, recorder=recorder
        ).run(Q0, V0)
        return motion, watch.times

    whole, times = watched(None)
    assert len(times) == 4
    path = tmp_path / "x.part"
    with closing(Recorder.create(path, HEADER, 6)) as recorder:
        watched(recorder)
    data = path.read_bytes()
    for part in (0.5, 1.0):
        path.write_bytes(data[: int(part * len(data))])
        with closing(Recorder.continued(path)) as recorder:
            again, noted = watched(recorder)
        assert same(again, whole)
        assert noted == times


def test_a_whole_vehicle_goes_on_to_the_bit(tmp_path, often):
    path = tmp_path / "x.part"
    keys = {"run.start_distance_m": 15.0, "run.distance_m": 2.0, "run.output_interval_ms": 2.0}
    keys |= {"output.patches_at_m": [], "contact.strips": 12, "contact.cells": 6}
    scenario = load(SCENARIOS / "manchester_r300.toml").with_values(keys)
    whole = run(scenario, record=path)
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    assert recorded(path).status == "stopped"
    assert run(scenario, record=path, resume=True).dataset.identical(whole.dataset)


KEYS: dict[str, Any] = {"track.segments": [straight(2.0)], "output.patches_at_m": [1.0]}
KEYS |= FAST | {"run.step_us": 100, "run.output_interval_ms": 0.5}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an uninterrupted run."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "short.toml").write_text(load(SCENARIOS / "curve_r300.toml").with_values(KEYS).text)
    ok("run", folder / "short.toml", "-o", folder, "-q", "--no-pictures")
    assert not (folder / "result.nc.part").exists()
    return folder


def test_kill_9_then_show_then_resume_gives_the_same_result(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(recorders, "FLUSH_INTERVAL", 0.01)
    out = tmp_path / "out"
    record = out / "result.nc.part"
    arguments = ["run", str(whole / "short.toml"), "-o", str(out), "-q", "--no-pictures"]

    def killed_on_the_way() -> None:
        look = Monitor.__call__

        def looking(self: Monitor, t: float, q: Any, q_t: Any) -> str | None:
            if record.exists() and record.stat().st_size > 20_000:  # a state beside the first one
                os.kill(os.getpid(), signal.SIGKILL)
            return look(self, t, q, q_t)

        Monitor.__call__ = looking  # type: ignore[method-assign]

    assert forked(*arguments, first=killed_on_the_way).returncode == -signal.SIGKILL
    assert not (out / "result.nc").exists()

    shown = ok("show", out)
    assert "stopped: the run was cut off when its process ended; results up to t = 0." in shown.output
    part, uninterrupted = recorded(record).dataset, Result.load(whole).dataset
    n = part.sizes["time"] - 1
    assert 10 < n < uninterrupted.sizes["time"]
    assert np.array_equal(part["Q"].values[:n], uninterrupted["Q"].values[:n])

    ok("run", whole / "short.toml", "-o", out, "-q", "--no-pictures", "--resume")
    assert Result.load(out).dataset.identical(uninterrupted)
    assert not record.exists()


def test_ctrl_c_while_the_result_is_put_together_loses_nothing(whole, tmp_path, monkeypatch):
    out = tmp_path / "out"

    def interrupted(*arguments: Any) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(run_module, "result_of", interrupted)
        done = call("run", whole / "short.toml", "-o", out, "-q", "--no-pictures")
    assert done.exit_code == 130
    assert f"interrupted; the run is safe in {out / 'result.nc.part'}: go on with --resume" in done.stderr
    monkeypatch.setattr(BodySystem, "solve", None)  # everything is there
    ok("run", whole / "short.toml", "-o", out, "-q", "--no-pictures", "--resume")
    assert Result.load(out).dataset.identical(Result.load(whole).dataset)


def test_another_scenario_or_a_changed_model_does_not_go_on(whole, tmp_path, monkeypatch):
    base = load(whole / "short.toml")
    rail = tmp_path / "rail.toml"
    shipped = SCENARIOS.parent / "models/rails/60E1.toml"
    rail.write_text(shipped.read_text())
    file = tmp_path / "own.toml"
    file.write_text(base.with_values({"track.rail": "rail.toml"}).text)
    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr(run_module, "result_of", lambda *a: (_ for _ in ()).throw(KeyboardInterrupt))
        assert call("run", file, "-o", out, "-q").exit_code == 130
    arguments = ("-o", out, "-q", "--no-pictures", "--resume")
    faster = tmp_path / "faster.toml"
    faster.write_text(load(file).with_values({"vehicle.speed_kmh": 60}).text)
    refused = refusal("run", faster, *arguments)
    assert "is the run of another scenario: vehicle.speed_kmh was 54, here it is 60; run it without" in refused
    commented = tmp_path / "commented.toml"
    commented.write_text("# the same\n" + file.read_text())
    text = rail.read_text()
    assert "[300.0, 80.0" in text
    rail.write_text(text.replace("[300.0, 80.0", "[301.0, 80.0", 1))
    assert f"{rail} has changed since the run began; run it without --resume" in refusal("run", file, *arguments)
    assert call("show", out).exit_code == 0, "what was computed is from the files that the run holds"
    rail.write_text(text)
    assert call("run", commented, *arguments).exit_code == 0


def test_other_code_does_not_go_on_but_can_be_shown(whole, tmp_path, monkeypatch):
    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr(run_module, "result_of", lambda *a: (_ for _ in ()).throw(KeyboardInterrupt))
        assert call("run", whole / "short.toml", "-o", out, "-q").exit_code == 130
    monkeypatch.setattr(record_module, "code_digest", lambda: "tomorrow's")
    monkeypatch.setattr(record_module, "numbers_digest", lambda setup: "other numbers from the same files")
    refused = refusal("run", whole / "short.toml", "-o", out, "-q", "--resume")
    assert "another state of wrsim's code: the numbers may differ; run it without --resume" in refused
    assert call("show", out).exit_code == 0


def test_a_static_analysis_has_nothing_to_resume(tmp_path):
    (tmp_path / "result.nc.part").write_bytes(b"")
    refused = refusal("run", SCENARIOS / "static_s1002.toml", "-o", tmp_path, "--resume")
    assert "cannot be resumed" in refused
