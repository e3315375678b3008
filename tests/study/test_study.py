"""A study survives the death of its workers and of itself, and comes to the same numbers whoever computes them."""

import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import dask
import numpy as np
import pytest
import xarray as xr
from distributed import Client
from distributed.security import Security
from distributed.utils import get_mp_context
from support.commands import call, ok, refusal
from support.runs import SCENARIOS
from support.studies import AXES, study_file
from support.waiting import wait_until

from wrsim.errors import InputError
from wrsim.results import Result, write_atomically
from wrsim.results.files import Keeper, digest_of, keeping
from wrsim.study import task
from wrsim.study.cluster import (
    CA,
    CERT,
    KEY,
    LOOPBACK,
    ONE_THREAD,
    TRIM,
    local_workers,
    slurm_cluster,
    slurm_security,
    workers_at,
)
from wrsim.study.collect import collected, markers_of, rows_of_cases
from wrsim.study.engine import _note_killed, execute
from wrsim.study.plan import PLAN, Plan, planned
from wrsim.study.spec import GridAxis
from wrsim.study.task import Marker, compile_for, missing, run_case


def plan_of(file: Path, folder: Path) -> Plan:
    """The plan of a study file, written where workers find it."""
    plan, reads = planned(file, folder)
    with keeping(Keeper(reads)):
        write_atomically(folder / PLAN, plan.dumped())
    return plan


def in_this_process(plan: Plan) -> None:
    """All cases one after the other, without any cluster."""
    for i in missing(plan):
        run_case(plan.folder, digest_of(plan.dumped()), i)


def results(plan: Plan) -> tuple[xr.Dataset, list[list[str]]]:
    """What a study comes to."""
    markers = markers_of(plan)
    return collected(plan, markers), rows_of_cases(plan, markers)


def markers(plan: Plan) -> list[Marker]:
    """All markers; every case has one."""
    complete = markers_of(plan)
    assert all(m.status != "missing" for m in complete)
    return complete


@pytest.fixture(scope="module")
def cluster() -> Iterator[Client]:
    """One worker in a process of its own; more on demand.

    They are forked from a process that has imported everything; those that commands start begin with nothing."""
    with dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"}):
        get_mp_context().set_forkserver_preload([task.__name__])
        with local_workers(1) as client:
            yield client


@pytest.fixture(scope="module")
def serial(cluster: Client, tmp_path_factory: pytest.TempPathFactory) -> Plan:
    """The study, computed by one worker: what all others have to come to. Kernels are compiled by then."""
    folder = tmp_path_factory.mktemp("serial")
    plan = plan_of(study_file(folder), folder / "out")
    compile_for(plan.scenario(plan.cases[0]))
    execute(cluster, plan, missing(plan))
    return plan


@pytest.fixture(scope="module")
def workers(serial: Plan, cluster: Client) -> Client:
    """Two workers."""
    cluster.cluster.scale(2)
    cluster.wait_for_workers(2)
    return cluster


def test_workers_have_one_thread_each(workers: Client) -> None:
    def threads() -> dict[str, str | None]:
        return {name: os.environ.get(name) for name in (*ONE_THREAD, TRIM)}

    assert set(workers.nthreads().values()) == {1}
    assert all(limits == ONE_THREAD | {TRIM: None} for limits in workers.run(threads).values()), "memory stays, too"


def test_two_workers_one_of_which_is_killed_come_to_the_numbers_of_one_worker(serial, workers, tmp_path):
    plan = plan_of(study_file(tmp_path), tmp_path / "out")
    before = workers.run(os.getpid)
    with ThreadPoolExecutor(1) as thread:
        running = thread.submit(execute, workers, plan, missing(plan))
        wait_until(lambda: len(missing(plan)) <= 4 or running.done())  # in the midst of it
        os.kill(random.Random(7).choice(sorted(before.values())), signal.SIGKILL)
        running.result(timeout=1200.0)
    assert missing(plan) == []
    (ours, our_rows), (theirs, their_rows) = results(plan), results(serial)
    assert our_rows == their_rows
    xr.testing.assert_identical(ours, theirs)
    assert set(ours["status"].values.ravel()) == {"completed"}
    workers.wait_for_workers(2)
    assert set(workers.run(os.getpid).values()) != set(before.values())  # one of them is a new one


def test_the_same_study_twice_runs_nothing(serial: Plan, unpainted: None) -> None:
    times = [m.began for m in markers(serial)]
    file = Path(serial.folder).parent / "study.toml"
    answer = ok("study", file, "-o", serial.folder)
    assert "6 cases, 6 of them known already" in answer.output
    assert [m.began for m in markers(serial)] == times
    names = {p.name for p in Path(serial.folder).iterdir()}
    assert {"study.nc", "study.csv", "times.csv", "study.json", "curves.png", "maps.png"} <= names
    stored = xr.open_dataset(Path(serial.folder) / "study.nc").load()
    assert stored.sizes == {"friction": 2, "speed_kmh": 3}
    assert stored["Y_over_Q_max"].dims == ("friction", "speed_kmh")
    assert stored["speed_kmh"].values.tolist() == [40.0, 45.0, 50.0]


@pytest.mark.usefixtures("unpainted")
def test_the_report_takes_one_study_and_nothing_beside_it(serial: Plan, tmp_path: Path) -> None:
    study, file = str(Path(serial.folder).parent / "study.toml"), str(tmp_path / "page.html")
    assert call("study", study, "-o", serial.folder, "--no-pictures").exit_code == 0
    assert call("report", serial.folder, "-o", file).exit_code == 0
    page = Path(file).read_text(encoding="utf-8")
    assert "6 cases: 6 completed." in page
    summary = page[page.index('id="h-summary"') : page.index('id="identity"')]
    assert all(text in summary for text in ("contact.friction (", "vehicle.speed_kmh (40, 45, 50)", "lies between"))
    for more in ([serial.folder], ["--view"]):
        assert "study" in refusal("report", serial.folder, *more, "-o", file)
    (tmp_path / "study.nc").write_bytes(b"no dataset")
    assert "not a wrsim study" in call("report", tmp_path).output


def test_outputs_are_those_of_results_and_more_values_run_only_what_is_new(serial: Plan, tmp_path: Path) -> None:
    dataset, _ = results(serial)
    case = serial.cases[4]
    cell = dataset.isel(friction=case.place[0], speed_kmh=case.place[1])
    kept = Result.load(serial.folder_of(case))
    assert cell["Q_min_kN"].item() == pytest.approx(kept.dataset["Q"].min().item() / 1e3, rel=1e-12)
    assert cell["Y_over_Q_max"].item() == pytest.approx(kept.dataset["Y_over_Q"].max().item(), rel=1e-12)
    assert kept.dataset.attrs["title"] == "Friction and speed: friction 0.3, speed_kmh 45"
    more = AXES.replace("[0.1, 0.3]", "[0.1, 0.3, 0.2]")
    plan, _ = planned(study_file(tmp_path, more), Path(serial.folder))
    assert [plan.cases[i].place[0] for i in missing(plan)] == [2, 2, 2]


def test_other_outputs_are_taken_from_kept_results(serial: Plan, tmp_path: Path) -> None:
    shutil.copytree(serial.folder, tmp_path / "out")
    few = AXES.replace("[0.1, 0.3]", "[0.1]").replace("to = 50", "to = 45")
    asked = """
[outputs]
summary = ["wheelsets.wheelset.wheels.left.Q_max_kN"]
hook = "outputs.py:numbers"
[[outputs.channels]]
channel = "Y"
reduce = "percentile"
percentile = 95
wheel = "right"
from_m = 41
"""
    (tmp_path / "outputs.py").write_text("def numbers(result):\n    return {'samples': result.dataset.sizes['time']}\n")
    plan = plan_of(study_file(tmp_path, few, asked), tmp_path / "out")
    began = {m.name: m.began for m in markers(serial)}
    in_this_process(plan)
    dataset, _ = results(plan)
    assert [m.began for m in markers(plan)] == [began[case.name] for case in plan.cases]  # nothing ran
    kept = Result.load(plan.folder_of(plan.cases[0])).dataset
    forces = kept["Y"].sel(wheel="right").values[kept["distance"].values >= 41.0]
    assert dataset["Y_right_p95_kN"].values[0, 0] == pytest.approx(np.percentile(forces, 95) / 1e3, rel=1e-12)
    assert dataset["samples"].values[0, 0] == kept.sizes["time"]
    assert dataset["wheelsets_wheelset_wheels_left_Q_max_kN"].values[0, 0] == pytest.approx(
        kept["Q"].sel(wheel="left").max().item() / 1e3
    )


def test_a_file_that_changes_gives_its_cases_other_names(tmp_path: Path) -> None:
    shipped = (SCENARIOS.parent / "models/vehicles/wheelset_s1002_steering.toml").read_text()
    (tmp_path / "own.toml").write_text(shipped)
    axes = AXES + '[[vary]]\nkind = "grid"\nkey = "vehicle.model"\nvalues = ["own.toml"]\n'
    first, _ = planned(study_file(tmp_path, axes), tmp_path / "out")
    second, _ = planned(study_file(tmp_path, axes.replace("[0.1, 0.3]", "[0.3, 0.1]")), tmp_path / "out")
    (tmp_path / "own.toml").write_text(shipped + "# edited\n")
    third, _ = planned(study_file(tmp_path, axes), tmp_path / "out")
    names = [{case.name for case in plan.cases} for plan in (first, second, third)]
    assert names[0] == names[1]  # in another order
    assert not names[0] & names[2]


def test_a_wheelset_that_derails_is_a_result_and_what_cannot_start_is_an_entry(tmp_path: Path) -> None:
    axes = '[[vary]]\nkind = "csv"\nfile = "rows.csv"\n'
    rows = "id,vehicle.speed_kmh,run.start_distance_m\nfast,150,30\ntoo fast,250,60\n"
    (tmp_path / "rows.csv").write_text(rows)
    plan = plan_of(study_file(tmp_path, axes, seconds=1.6), tmp_path / "out")
    in_this_process(plan)
    dataset, _ = results(plan)
    assert dataset["vehicle.speed_kmh"].values.tolist() == [150.0, 250.0]
    fast, start = (dataset.sel(case=name) for name in ("fast", "too fast"))
    assert fast["status"].item() == "derailed", fast["message"].item()
    assert np.isfinite(fast["Y_over_Q_max"].item())
    assert start["status"].item() == "failed" and "no steady motion to start from" in start["message"].item()
    assert np.isnan(start["Y_over_Q_max"].item())
    answer = call("study", tmp_path / "study.toml", "-o", plan.folder, "--no-pictures")
    assert answer.exit_code == 3 and "1 derailed, 1 failed" in answer.output


def test_a_case_that_takes_too_long_is_ended_and_goes_on_with_more_time(tmp_path, monkeypatch):
    single_axis = AXES.replace("[0.1, 0.3]", "[0.3]").replace("to = 50", "to = 40")
    monkeypatch.setattr("wrsim.simulation.integrate.PROGRESS_INTERVAL", 0.0)
    monkeypatch.setattr("wrsim.simulation.recorder.FLUSH_INTERVAL", 0.0)
    # a clock that goes faster, so that no machine is fast enough
    clock = SimpleNamespace(monotonic=lambda: 50.0 * time.monotonic(), perf_counter=time.perf_counter, time=time.time)
    with monkeypatch.context() as patch:
        patch.setattr(task, "time", clock)
        short = plan_of(study_file(tmp_path, single_axis, "[cases]\ntime_limit_s = 1\n", seconds=2.0), tmp_path / "out")
        in_this_process(short)
    (late,) = markers(short)
    assert late.status == "out of time" and "time_limit_s" in late.message
    assert missing(short) == []
    longer = plan_of(study_file(tmp_path, single_axis, "[cases]\ntime_limit_s = 5000\n", seconds=2.0), tmp_path / "out")
    in_this_process(longer)
    (done,) = markers(longer)
    assert done.status == "completed" and done.resumed


@pytest.mark.campaign  # in the suite: a killed worker, and what is noted of such a case
def test_a_case_that_kills_its_workers_is_an_entry_and_spares_the_others(workers: Client, tmp_path: Path) -> None:
    die = "import os\n\ndef numbers(result):\n    if 'friction 0.1' in result.title:\n        os._exit(7)\n"
    (tmp_path / "die.py").write_text(die + "    return {}\n")
    axes = AXES.replace("to = 50", "to = 40")
    plan = plan_of(study_file(tmp_path, axes, '[outputs]\nhook = "die.py:numbers"\n', seconds=0.1), tmp_path / "out")
    execute(workers, plan, missing(plan))
    assert [m.status for m in markers(plan)] == ["failed", "completed"]
    assert "4 workers died at it" in markers(plan)[0].message
    assert "die.py ends the process" in markers(plan)[0].message


def test_a_hook_that_is_mended_takes_its_numbers_from_kept_results(serial: Plan, tmp_path: Path) -> None:
    shutil.copytree(serial.folder, tmp_path / "out")
    few = AXES.replace("[0.1, 0.3]", "[0.1]").replace("to = 50", "to = 40")
    (tmp_path / "h.py").write_text("import os\nos._exit(7)\ndef numbers(result): pass\n")
    file = study_file(tmp_path, few, '[outputs]\nhook = "h.py:numbers"\n')
    spoiled = plan_of(file, tmp_path / "out")
    _note_killed(spoiled, 0)
    assert [m.status for m in markers(spoiled)] == ["failed"] and not missing(spoiled)
    (tmp_path / "h.py").write_text("import time\ntime.sleep(1e6)\ndef numbers(result): pass\n")
    hanging = plan_of(file, tmp_path / "out")
    (hanging.folder_of(hanging.cases[0]) / task.HUNG).write_text("where it hung")
    in_this_process(hanging)
    assert [m.status for m in markers(hanging)] == ["out of time"] and not missing(hanging)
    (tmp_path / "h.py").write_text("def numbers(result):\n    return {'samples': result.dataset.sizes['time']}\n")
    mended = plan_of(file, tmp_path / "out")
    in_this_process(mended)
    ((marker,), (before, *_)) = markers(mended), markers(serial)
    assert marker.status == "completed" and marker.numbers["samples"] > 0
    assert not marker.resumed and marker.simulation == 0.0 and before.simulation > 0.0  # nothing ran


def test_faults_of_hooks_and_outputs_that_cannot_be_had_are_told(serial, tmp_path, unpainted, workers):
    shutil.copytree(serial.folder, tmp_path / "out")
    (tmp_path / "h.py").write_text(
        "def numbers(result):\n    return {'one': 1 / ('friction 0.3' not in result.title)}\n"
    )
    plan = plan_of(study_file(tmp_path, AXES, '[outputs]\nhook = "h.py:numbers"\n'), tmp_path / "out")
    in_this_process(plan)
    answer = call("study", tmp_path / "study.toml", "-o", tmp_path / "out")
    assert "3 cases lack outputs, listed in study.csv: outputs.hook: " in answer.output
    table = (tmp_path / "out" / "study.csv").read_text()
    assert table.count("ZeroDivisionError") == 3
    more = '[outputs]\nsummary = ["wheelsets.wheelset.wheels.left.Q_maxx_kN"]\n'
    plan = plan_of(study_file(tmp_path, more=more), tmp_path / "out")
    with pytest.raises(InputError, match=r"\"Q_maxx_kN\" is not in the summary; there is .*did you mean 'Q_max_kN'"):
        execute(workers, plan, missing(plan))


def test_a_range_varies_keys_of_whole_numbers_too_and_has_the_values_of_a_list() -> None:
    for ends, values in (((1, 3, 1), [1, 2, 3]), ((0.1, 0.3, 0.1), [0.1, 0.2, 0.3])):
        ends_and_step = dict(zip(("from", "to", "step"), ends, strict=True))
        axis = GridAxis.model_validate({"kind": "grid", "key": "a.b", "values": ends_and_step})
        assert list(map(repr, axis.values)) == list(map(repr, values))


def test_samples_are_the_same_for_the_same_seed_and_fill_their_ranges(tmp_path: Path) -> None:
    axes = """
[[vary]]
kind = "KIND"
samples = 16
seed = 3
[[vary.over]]
key = "contact.friction"
low = 0.1
high = 0.5
[[vary.over]]
key = ["vehicle.radius_left_mm", "vehicle.radius_right_mm"]
mean = 460
deviation = 0.5
"""
    for kind in ("sobol", "latin-hypercube"):
        file = study_file(tmp_path, axes.replace("KIND", kind))
        first, _ = planned(file, tmp_path / "out")
        again, _ = planned(file, tmp_path / "out")
        assert [c.name for c in first.cases] == [c.name for c in again.cases]
        friction = np.array([c.values["contact.friction"] for c in first.cases])
        assert sorted((friction - 0.1) // 0.025) == list(range(16))  # one in every sixteenth
        radius = np.array([c.values["vehicle.radius_left_mm"] for c in first.cases])
        assert all(c.values["vehicle.radius_right_mm"] == r for c, r in zip(first.cases, radius, strict=True))
        assert abs(np.mean(radius) - 460.0) < 0.1 and 0.3 < np.std(radius) < 0.7
        other_seed, _ = planned(
            study_file(tmp_path, axes.replace("KIND", kind).replace("seed = 3", "seed = 4")), tmp_path
        )
        assert {c.name for c in other_seed.cases}.isdisjoint(c.name for c in first.cases)


def test_workers_on_this_machine_leave_ctrl_c_of_the_terminal_to_the_command(workers: Client) -> None:
    assert signal.SIGINT in workers.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_jobs_of_slurm_have_one_thread_and_leave_ctrl_c_as_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    if find_spec("dask_jobqueue") is None:
        pytest.skip("no dask-jobqueue here")
    for name in ("dask_jobqueue", "dask_jobqueue.runner"):  # imported anew
        monkeypatch.delitem(sys.modules, name, raising=False)
    before = signal.getsignal(signal.SIGINT)
    with slurm_security(None, tmp_path) as security, slurm_cluster(security) as cluster:
        script = cluster.job_script()
        assert cluster.scheduler_address.startswith("tls://") and not cluster.scheduler.services
        (private,) = tmp_path.iterdir()
        assert private.stat().st_mode & 0o077 == 0
        assert all(f"{private}/{name}.pem" in script for name in ("ca", "cert", "key"))
    assert not list(tmp_path.iterdir())
    assert signal.getsignal(signal.SIGINT) is before
    assert "#SBATCH --cpus-per-task=1" in script and "--nthreads 1" in script
    assert "--no-dashboard --worker-class wrsim.study.cluster.QuietWorker --protocol tls://" in script
    assert all(f"export {name}=1" in script for name in ONE_THREAD)
    key, unset = "DASK_DISTRIBUTED__NANNY__PRE_SPAWN_ENVIRON", f"{{'{TRIM}': None}}"
    assert f'export {key}="{unset}"' in script
    merged = dask.config.merge(dask.config.config, dask.config.collect_env({key: unset}))
    assert merged["distributed"]["nanny"]["pre-spawn-environ"][TRIM] is None


def test_nobody_or_something_else_at_the_address_of_the_scheduler_is_one_sentence(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("wrsim.study.cluster.WAIT", 2)
    with (
        pytest.raises(InputError, match=r"--scheduler tcp://127\.0\.0\.1:9: no dask scheduler answers there"),
        workers_at("tcp://127.0.0.1:9", None),
    ):
        pass
    with socket.create_server((LOOPBACK, 0)) as server:
        port = server.getsockname()[1]

        def answer() -> None:
            with server.accept()[0] as client:
                client.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

        threading.Thread(target=answer, daemon=True).start()
        begin = time.monotonic()
        with (
            pytest.raises(InputError, match=f"--scheduler tcp://127.0.0.1:{port}: no dask scheduler answers there"),
            workers_at(f"tcp://{LOOPBACK}:{port}", None),
        ):
            pass
        assert time.monotonic() - begin < 20.0  # dask's own client takes 40 s to end


@pytest.fixture
def certificates(tmp_path: Path) -> Path:
    """A folder of certificates."""
    security = Security.temporary()
    texts = {CA: security.tls_ca_file, CERT: security.tls_client_cert, KEY: security.tls_client_key}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def standing_scheduler(serial: Plan, certificates: Path, tmp_path: Path) -> Iterator[str]:
    """Address of a dask scheduler that somebody has started, with one worker, as the page on studies says."""
    file, quiet = tmp_path / "scheduler.json", {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    program = [sys.executable, "-m", "dask"]
    named = {"scheduler-file": file, "tls-ca-file": certificates / CA}
    named |= {"tls-cert": certificates / CERT, "tls-key": certificates / KEY}
    options = [f"--{option}={path}" for option, path in named.items()]
    commands = (
        [*program, "scheduler", "--host", "tls://127.0.0.1:0", "--no-dashboard", *options],
        [
            *program,
            *["worker", "--nthreads=1", "--no-nanny", "--no-dashboard"],
            f"--local-directory={tmp_path}",
            *options,
        ],
    )
    processes = [subprocess.Popen(command, env=os.environ | ONE_THREAD, **quiet) for command in commands]  # type: ignore[call-overload]
    try:
        wait_until(lambda: file.exists() and file.read_text().endswith("\n}"), processes[0])  # written to its end
        yield json.loads(file.read_text())["address"]
    finally:
        for process in reversed(processes):  # a worker without its scheduler does not end at once
            process.terminate()
            process.wait(1200)


@pytest.mark.campaign
def test_workers_of_a_scheduler_that_stands_already_come_to_the_same_numbers(
    serial: Plan, standing_scheduler: str, certificates: Path, tmp_path: Path
) -> None:
    few = AXES.replace("[0.1, 0.3]", "[0.1]").replace("to = 50", "to = 45")
    out = tmp_path / "out"
    command = ["study", str(study_file(tmp_path, few)), "-o", str(out), "--scheduler", standing_scheduler]
    assert "needs certificates: give --tls DIR" in refusal(*command)
    told = ok(*command, "--tls", certificates, "--no-pictures", "--json")
    assert json.loads(told.stdout)["status"] == {"completed": 2}
    kept = {path.parent.name: Result.load(path).dataset for path in Path(serial.folder).rglob("result.nc")}
    assert len(list(out.rglob("result.nc"))) == 2
    assert all(Result.load(path).dataset.identical(kept[path.parent.name]) for path in out.rglob("result.nc"))
