"""Bad study files: one clear error each, with file, key, value, what is allowed and the nearest guess."""

import importlib
import json
import os
import socket
import ssl
import stat
import struct
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
from distributed import Client, SpecCluster
from distributed.protocol import dumps
from distributed.protocol.pickle import dumps as pickled
from distributed.protocol.utils import pack_frames
from distributed.security import Security
from support import synthetic_run
from support.commands import ok, refusal
from support.rows import rows_of
from support.studies import AXES, study_file
from support.synthetic_result import curve_run

from wrsim import InputError, Result
from wrsim.plots.study import _note
from wrsim.report.study import study_page
from wrsim.study.cluster import CA, LOOPBACK, QuietScheduler, local_workers, security_of
from wrsim.study.collect import collected, faults_of, rows_of_cases, study_report
from wrsim.study.outputs import case_outputs, reduced
from wrsim.study.plan import planned
from wrsim.study.spec import ChannelOutput, OutputsSection
from wrsim.study.task import COMPLETED, DERAILED, MARKER, Marker, read_marker, write_marker

table = rows_of(__file__)


@pytest.mark.parametrize(("axes", "message"), table("every_fault_of_a_study_file_is_one_clear_error"))  # fmt: skip
def test_every_fault_of_a_study_file_is_one_clear_error(axes: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("contact.friction,vehicle.speed_kmh\n0.1,40\n0.2\n")
    (tmp_path / "head.csv").write_text("# keys\nvehicle.speed_kmh\n")
    (tmp_path / "key.csv").write_text("contact.frction\n0.2\n")
    (tmp_path / "bad.py").write_text("def f(:\n")
    (tmp_path / "h.py").write_text("def numbers(result):\n    return {}\n")
    with pytest.raises(InputError, match=message) as problem:
        planned(study_file(tmp_path, axes), tmp_path / "out")
    assert "Traceback" not in str(problem.value)


def test_too_many_cases_and_files_that_are_no_certificates_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("wrsim.study.plan.MOST_CASES", 5)
    with pytest.raises(InputError, match=r"study\.toml:4: vary: describes 6 cases; must be at most 5"):
        planned(study_file(tmp_path), tmp_path / "out")
    for _ in range(2):  # missing, then unusable
        with pytest.raises(InputError, match=r"ca\.pem, cert\.pem and key\.pem must be PEM files that go together"):
            security_of(tmp_path, "client")
        (tmp_path / CA).write_text("no certificate\n")


HOOKS = ("def numbers(result): pass", "from math import fsum as numbers", "numbers = print", "from math import *",
         "try:\n    import none\nexcept ImportError:\n    numbers = None")  # fmt: skip


def test_planning_executes_nothing_of_a_hook(tmp_path: Path) -> None:
    mine, file = tmp_path / "executed", study_file(tmp_path, AXES + "[outputs]\nhook = 'h.py:numbers'\n")
    for binding in HOOKS:
        (tmp_path / "h.py").write_text(f"open({str(mine)!r}, 'w')\n{binding}\nraise SystemExit\n")
        assert len(planned(file, tmp_path / "out")[0].cases) == 6
    answer = ok("study", file, "-o", tmp_path / "out", "--dry-run")
    assert "6 cases, 6 to run" in answer.output
    assert not mine.exists() and not (tmp_path / "out").exists()


@pytest.mark.parametrize("ending", ["raise SystemExit(3)", "raise KeyboardInterrupt", "import sys; sys.exit('enough')"])
@pytest.mark.parametrize("place", ["", "def numbers(result): "])
def test_a_hook_that_wants_to_end_the_process_is_a_fault_of_the_case(place: str, ending: str, tmp_path: Path) -> None:
    (tmp_path / "h.py").write_text(place + ending)
    outputs = case_outputs(Result(curve_run()), OutputsSection(hook="h.py:numbers"), tmp_path / "h.py")
    (fault,) = outputs.faults
    assert fault.startswith(f"outputs.hook: {tmp_path / 'h.py'}: numbers: ")
    assert "SystemExit" in fault or "KeyboardInterrupt" in fault


@pytest.mark.parametrize("odd", [
    b"", b"[]", b"\xff", b"[" * 100_000, b"{}", {"status": "x"}, {"status": 3}, {"numbers": []}, {"more": 1},
    {"numbers": {"Y_max": "x"}}, {"units": {"Y_max": 3}}, {"faults": [3]}, {"time_limit": "x"}, {"process": 1.5},
    {"message": None},
], ids=lambda odd: str(odd)[:20])  # fmt: skip
def test_a_case_whose_marker_has_odd_content_runs_again(odd: bytes | dict[str, object], tmp_path: Path) -> None:
    """There is no marker then."""
    marker = Marker("a", "a", COMPLETED, "", {"Y_max": 1.0}, {"Y_max": "kN"})
    write_marker(tmp_path, marker)
    assert read_marker(tmp_path) == marker
    content = odd if isinstance(odd, bytes) else json.dumps(vars(marker) | odd).encode()
    (tmp_path / MARKER).write_bytes(content)
    assert read_marker(tmp_path) is None


def test_of_several_wheels_the_worst_counts() -> None:
    """Either way for a peak, the smallest for the least value."""
    values = np.array([[1.0, -5.0], [2.0, 3.0]])
    assert [reduced(values, how) for how in ("peak", "max", "min")] == [-5.0, 3.0, -5.0]
    assert reduced(values, "percentile", 50.0) == 1.5


def test_a_low_pass_of_a_channel_keeps_slow_waves_and_takes_fast_ones() -> None:
    """Waves of 2 and 50 Hz at 20 m/s; at its cut-off of 10 Hz the filter has 1/sqrt 2, at 2 Hz all but 0.04 %."""
    waves = {"y": lambda s: (1e3 * np.sin(0.2 * np.pi * s), 2e3 * np.sin(5.0 * np.pi * s))}
    wanted = {"channel": "Y", "reduce": "rms", "from_m": 100.0, "to_m": 500.0, "low_pass_Hz": 10.0}
    sides = tuple(ChannelOutput(wheel=side, **wanted) for side in ("left", "right"))
    outputs = case_outputs(synthetic_run.run(**waves), OutputsSection(channels=sides), None)
    assert list(outputs.numbers.values()) == [pytest.approx(0.5**0.5, rel=1e-3), pytest.approx(0.0, abs=5e-3)]
    assert "more than 2.22e+05 samples" in case_outputs(
        synthetic_run.run(), OutputsSection(channels=(sides[0].model_copy(update={"low_pass_Hz": 1e5}),)), None
    ).faults[0]  # fmt: skip


def test_a_window_beyond_the_end_of_a_case_is_told_and_a_derailed_case_stays_derailed(tmp_path: Path) -> None:
    """Another case may have the value: the study goes on."""
    window = (ChannelOutput(channel="Q", reduce="max", from_m=60, to_m=80),)
    axes = AXES + "[[outputs.channels]]\nchannel = 'Q'\nreduce = 'max'\nfrom_m = 60\nto_m = 80\n"
    plan, _ = planned(study_file(tmp_path, axes), tmp_path / "out")
    markers = [Marker(case.name, case.label, COMPLETED, "") for case in plan.cases]
    whole, derailed = curve_run(radius=300.0), curve_run(stopped=True).assign_attrs(stop_cause="monitor")
    end = whole["distance"].values[-1]
    assert end > 80.0 > 60.0 > 0.0
    short = whole.isel(time=whole["distance"].values < 50.0)
    for marker, dataset in zip(markers, (short, derailed.isel(time=derailed["distance"].values < 50.0)), strict=False):
        marker.record_result(Result(dataset), plan)
    assert case_outputs(Result(whole), OutputsSection(channels=window), None).absent == []
    missing = 'outputs.channels: channel = "Q", from_m = 60, to_m = 80: the case has no value there, it lasts from'
    assert [m.status for m in markers[:2]] == [COMPLETED, DERAILED]
    assert [m.faults for m in markers[:2]] == [[], []] and all(missing in m.message for m in markers[:2])
    rows = rows_of_cases(plan, markers)
    assert [row[3] for row in rows[1:3]] == [COMPLETED, DERAILED] and missing in rows[2][4]
    for marker in markers[2:]:
        marker.record_result(Result(whole), plan)
    markers[5].status, markers[5].numbers = DERAILED, {"Q_max_kN": 1e6}
    dataset = collected(plan, markers)
    report = study_report(plan, markers, dataset)
    assert report["outputs"]["Q_max_kN"]["max"] < 1e6 and report["status"][DERAILED] == 2
    assert "of 6 cases 2 derailed (red), 1 completed lack a value" in _note(dataset, ["Q_max_kN"], ["Q_max_kN"])
    page = study_page(dataset, "study.nc")
    assert page.count("the case has no value there") == 2
    assert "2 cases lack outputs" in faults_of(report, markers, True)[0]


# A study answers nobody but its own processes: whoever can talk to a scheduler lets it execute what they like.
def listening() -> set[tuple[str, int]]:
    """Host and port of every socket on which this process and those that it started wait for others."""
    addresses_in_use = set()
    for process in (process_here := psutil.Process(), *process_here.children(recursive=True)):
        addresses_in_use |= {
            tuple(connection.laddr)
            for connection in process.net_connections("inet")
            if connection.status == psutil.CONN_LISTEN
        }
    return addresses_in_use


@pytest.fixture(scope="module")
def listening_before() -> set[tuple[str, int]]:
    """What this process listens on by itself."""
    return listening()


@pytest.fixture(scope="module")
def study(listening_before: set[tuple[str, int]]) -> Iterator[Client]:
    """One worker, as a study has it."""
    with local_workers(1) as client:
        yield client


def addresses(study: Client) -> list[str]:
    """The scheduler, the worker and its nanny."""
    (worker,) = study.scheduler_info()["workers"].values()
    return [study.scheduler.address, worker["nanny"], *study.scheduler_info()["workers"]]


def port_of(address: str) -> int:
    """The port of an address of dask."""
    return int(address.rpartition(":")[2])


def test_everything_that_listens_listens_on_loopback_and_serves_no_pages(
    study: Client, listening_before: set[tuple[str, int]]
):
    assert listening() - listening_before == {(LOOPBACK, port_of(address)) for address in addresses(study)}
    assert all(address.startswith(f"tls://{LOOPBACK}:") for address in addresses(study))


class Touch:
    """An object that makes a file when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (self.path,)


def sent(port: int, path: Path, tls: bool = False) -> bytes:
    """The answer to the frames that let a scheduler of dask execute something; empty when it hangs up."""
    hello = {"compression": None, "python": sys.version_info[:3], "pickle-protocol": 4}
    order = {"op": "run_function", "function": pickled(Touch(path)), "args": pickled(()), "kwargs": pickled({})}
    framed = [pack_frames(dumps(message)) for message in (hello, order | {"reply": True})]
    stream = socket.create_connection((LOOPBACK, port), timeout=60.0)
    try:
        if tls:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            stream = context.wrap_socket(stream)
        stream.sendall(b"".join(struct.pack("Q", len(body)) + body for body in framed))
        answer = b""
        while piece := stream.recv(4096):
            answer += piece
            if path.exists():
                break
        return answer
    except (ConnectionError, ssl.SSLError):
        return b""
    finally:
        stream.close()


def test_pickles_of_an_outsider_are_not_read(study: Client, tmp_path: Path) -> None:
    spec = {"cls": QuietScheduler, "options": {"host": LOOPBACK, "dashboard": False}}
    with SpecCluster(scheduler=spec) as everybodys:  # these frames do what they are meant to
        sent(port_of(everybodys.scheduler_address), tmp_path / "control")
    assert (tmp_path / "control").exists()
    for address in addresses(study):
        for tls in (False, True):
            assert sent(port_of(address), tmp_path / "owned", tls) == b""
    assert not (tmp_path / "owned").exists()


@pytest.mark.parametrize("how", ["without TLS", "without a certificate of the study"])
def test_a_client_of_an_outsider_is_refused(how: str, study: Client) -> None:
    strange = None if how == "without TLS" else Security.temporary()
    protocol = "tcp" if strange is None else "tls"
    with pytest.raises(OSError):
        Client(f"{protocol}://{LOOPBACK}:{port_of(addresses(study)[0])}", security=strange, timeout=1)


def test_modules_are_looked_up_in_no_folder_that_others_can_write(study: Client) -> None:
    def open_folders(places: list[str]) -> list[str]:
        """Those in which others than the owner can put a file, or another folder in their place."""
        parts = {part for place in places if os.path.isdir(place) for part in (Path(place), *Path(place).parents)}
        modes = {part: part.stat().st_mode for part in parts}
        return [str(p) for p, mode in modes.items() if mode & stat.S_IWOTH and not mode & stat.S_ISVTX]

    def scratch() -> list[str]:
        return [place for place in sys.path if "dask-scratch-space" in place]

    places = [*scratch(), *(place for places in study.run(scratch).values() for place in places)]
    assert len(places) >= 3 and not open_folders(places)
    private = {parent for place in places for parent in Path(place).parents if parent.name.startswith("wrsim-")}
    assert private and all(parent.stat().st_mode & 0o077 == 0 for parent in private)
    assert all(any(parent in Path(place).parents for parent in private) for place in places)


@pytest.mark.parametrize(("options", "message"), table("options_of_a_scheduler"))
def test_options_of_a_scheduler_that_do_not_go_together_are_refused(options: list[str], message: str, tmp_path: Path):
    (tmp_path / "study.toml").touch()
    assert message in refusal("study", tmp_path / "study.toml", *options)


def test_without_the_extra_a_study_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "wrsim.study.cluster")
    with pytest.raises(InputError, match=r"need distributed: install it with pip install 'wrsim\[study\]'"):
        importlib.import_module("wrsim.study.cluster")
