"""Workers without a scheduler: plain processes, as on Windows."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import xarray as xr
from support.studies import study_file
from support.waiting import wait_until
from test_study import plan_of, results

from wrsim.study import cluster
from wrsim.study.engine import execute
from wrsim.study.pool import ONE_THREAD, Pool, WorkerDied
from wrsim.study.task import missing


def test_a_killed_process_is_started_again_and_the_study_has_the_numbers_of_one_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PLAIN_PROCESSES", True)
    folders = [tmp_path / name for name in ("pool", "alone")]
    for folder in folders:
        folder.mkdir()
    plan, alone = (plan_of(study_file(folder), folder / "out") for folder in folders)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    with cluster.local_workers(2) as pool, ThreadPoolExecutor(1) as thread:
        execute(pool, alone, missing(alone))
        running = thread.submit(execute, pool, plan, missing(plan), None, 2)
        wait_until(lambda: len(missing(plan)) <= 4 or running.done())
        pool._processes[0].kill()
        running.result(timeout=1200.0)
        processes = pool._processes
    assert missing(plan) == [] and len(processes) == 3
    assert not any(process.is_alive() for process in processes)
    assert before == {name: os.environ.get(name) for name in ONE_THREAD}
    (ours, our_rows), (theirs, their_rows) = results(plan), results(alone)
    assert our_rows == their_rows
    xr.testing.assert_identical(ours, theirs)


def test_a_call_that_no_process_survives_and_one_that_raises_end_and_others_go_on(tmp_path: Path) -> None:
    with cluster._without_script(), Pool(1) as pool:
        for number, (function, argument) in enumerate([(os._exit, 1), (int, "x"), (os.mkdir, str(tmp_path / "made"))]):
            pool.submit(function, argument, key=str(number))
        ended = [pool.next_ended() for _ in range(3)]
    assert [call.key for call in ended] == ["0", "1", "2"]
    assert [type(call.exception()) for call in ended] == [WorkerDied, ValueError, type(None)]
    assert (tmp_path / "made").is_dir()


def test_calls_that_wait_end_with_their_pool() -> None:
    with cluster._without_script(), Pool(1) as pool:
        pool.submit(__import__("time").sleep, 1e4, key="long")
        pool.submit(int, "1", key="next")
        wait_until(lambda: pool._processes)
        with pytest.raises(KeyboardInterrupt):
            raise KeyboardInterrupt
    assert not pool._processes[0].is_alive()
