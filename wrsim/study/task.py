"""What a worker does with one case: it runs it in the folder of the case and leaves a marker there.

A case is done when its marker (``case.json``) is there, which is written last and moved into place. So a worker may die
at any instant, and a case may be handed out twice: who comes second waits for the lock of the folder and finds the
marker. A run that was cut off goes on from its part file.

A case that takes too long is ended by its progress function; one that does not even call that (code that hangs) by a
watchdog that ends the process. Who is handed the case next finds the watchdog's note.
"""

import faulthandler
import os
import platform
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from wrsim import __version__
from wrsim.analysis import run
from wrsim.analysis.motion.record import code_digest
from wrsim.errors import InputError, SimulationError, WrsimError
from wrsim.inputs.toml_files import read_bytes
from wrsim.register import ANALYSES
from wrsim.results import Result, write_atomically
from wrsim.results.files import Manifest, as_json
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario
from wrsim.study.outputs import case_outputs
from wrsim.study.plan import Case, Plan, changed_file, plan_in

MARKER, RESULT, PART, RECORD, HUNG = "case.json", "result.nc", "result.nc.part", "scenario.toml", "hung.txt"

COMPLETED, DERAILED, STOPPED, TIMED_OUT, FAILED = "completed", "derailed", "stopped", "out of time", "failed"
STATUSES = (COMPLETED, DERAILED, STOPPED, TIMED_OUT, FAILED)
"""What became of a case. Derailed or overturned: a result; stopped: the integration could not go on."""

GRACE = 5.0
"""Time beyond its limit after which a case that does not answer loses its process [s]; and a tenth of the limit."""


Work = Callable[[Plan, Sequence[int]], None]
"""Writes a plan into its folder and runs some of its cases to their markers."""


class StopCase(Exception):
    """Ends a run that has used up its time, or gone far enough; its argument: how much of it is done."""


@dataclass
class Marker:
    """What is known of a case that has been handled; see ``STATUSES``.

    numbers, units, faults, absent: see `Outputs`; outputs: digest of the outputs section; wall_time: of this attempt,
    simulation: of the analysis in it [s]; began, ended: by the clock [s]; resumed: went on with a run that was cut off.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    name: str
    label: str
    status: Annotated[str, Field(pattern=f"^({'|'.join(STATUSES)})$")]
    message: str
    numbers: dict[str, float | None] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    absent: list[str] = field(default_factory=list)
    outputs: str = ""
    time_limit: float = 0.0
    wall_time: float = 0.0
    simulation: float = 0.0
    began: float = 0.0
    ended: float = 0.0
    resumed: bool = False
    host: str = ""
    process: int = 0
    wrsim_version: str = __version__
    code: str = ""

    def is_done(self, plan: Plan) -> bool:
        """True if nothing is left to run; a larger limit gives a case that ran out of time another chance."""
        return self.status != TIMED_OUT or self.time_limit >= plan.time_limit

    def record_result(self, result: Result, plan: Plan) -> None:
        """Note how a run ended and its outputs, numbers as JSON knows them; the message: what could not be found.

        Derailing and overturning are results; all else that ends a run early has stopped it.
        """
        outputs = case_outputs(result, plan.outputs, Path(plan.hook) if plan.hook else None)
        self.status = COMPLETED
        if result.status != "completed":
            unknown = result.stop_reason.startswith(("no verdict", "the contact solution"))
            derailed = result.dataset.attrs.get("stop_cause") == "monitor" and not unknown
            self.status = DERAILED if derailed else STOPPED
        self.numbers = {name: value if abs(value) < float("inf") else None for name, value in outputs.numbers.items()}
        self.units, self.faults, self.absent = outputs.units, outputs.faults, outputs.absent
        self.message = "; ".join(filter(None, (result.stop_reason, *outputs.faults, *outputs.absent)))


_MARKER = TypeAdapter(Marker)


def read_marker(folder: Path) -> Marker | None:
    """The marker of a case; None where there is none."""
    with suppress(InputError, ValidationError):
        return _MARKER.validate_json(read_bytes(folder / MARKER, "marker"), strict=True)
    return None


def write_marker(folder: Path, marker: Marker) -> None:
    """The last thing that is done for a case. Raises ``WrsimError`` when it cannot be written."""
    write_atomically(folder / MARKER, as_json(vars(marker), indent=1))


def missing(plan: Plan, retry: bool = False) -> list[int]:
    """Cases without a marker, or with other outputs than those of the plan; each name once.

    retry: also those that failed, stopped or ran out of time; their markers are taken away.
    """
    todo: dict[str, int] = {}
    for i, case in enumerate(plan.cases):
        if case.name in todo:
            continue
        marker = read_marker(plan.folder_of(case))
        if marker is not None and retry and marker.status not in (COMPLETED, DERAILED):
            (plan.folder_of(case) / MARKER).unlink()
            marker = None
        if marker is None or not marker.is_done(plan) or marker.outputs != plan.outputs_digest:
            todo[case.name] = i
    return list(todo.values())


def run_case(study: str, digest: str, index: int) -> str:
    """Run a case of the plan in a folder and leave its marker; gives the folder of the case.

    Raises ``WrsimError`` only where nothing can be written.
    """
    plan = plan_in(study, digest)
    case = plan.cases[index]
    folder = plan.folder_of(case)
    # in a worker, xarray would ask the scheduler for a lock on every file
    import dask

    with dask.config.set(scheduler="synchronous"), _locked(folder, 2.0 * _watchdog_limit(plan)):
        marker = read_marker(folder)
        if _has_hung(plan, case, folder):
            pass
        elif marker is None or not marker.is_done(plan):
            _attempt(plan, case, folder)
        elif marker.outputs != plan.outputs_digest:
            _reduce_again(plan, case, folder, marker)
    return str(folder)


@contextmanager
def _locked(folder: Path, patience: float) -> Iterator[None]:
    """Lock a folder; waits for another worker in it that the scheduler takes for dead."""
    until = time.monotonic() + patience
    with ExitStack() as stack:
        while True:
            try:
                stack.enter_context(Manifest(folder).locked())
                break
            except InputError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.2)
        yield


def _marker(plan: Plan, case: Case) -> Marker:
    """The marker of a case that begins."""
    return Marker(
        case.name, case.label, FAILED, "", outputs=plan.outputs_digest, time_limit=plan.time_limit,
        began=time.time(), host=platform.node(), process=os.getpid(), code=code_digest(),
    )  # fmt: skip


def _has_hung(plan: Plan, case: Case, folder: Path) -> bool:
    """True if the watchdog ended the process that had this case: its marker reports it then."""
    hung = folder / HUNG
    if not hung.exists() or hung.stat().st_size == 0:
        return False
    marker = _marker(plan, case)
    marker.status = TIMED_OUT
    marker.message = f"did not answer after {plan.time_limit:g} s; its process was ended, last_{HUNG} shows where"
    os.replace(hung, folder / f"last_{HUNG}")
    write_marker(folder, marker)
    return True


def _attempt(plan: Plan, case: Case, folder: Path) -> None:
    """Run the case and write its marker, whatever becomes of it."""
    marker = _marker(plan, case)
    with _watched(folder, plan):
        begin = time.perf_counter()
        try:
            _simulate(plan, case, folder, marker)
        except StopCase as late:
            marker.status = TIMED_OUT
            marker.message = (
                f"not done after {plan.time_limit:g} s, at {100.0 * late.args[0]:.0f} %; with a larger "
                "[cases] time_limit_s it goes on from there"
            )
        except (InputError, SimulationError) as error:
            marker.message = str(error)
        except WrsimError:
            raise  # nothing can be written here: every case would fail
        except MemoryError:
            marker.message = "out of memory"
        except Exception as error:  # a mistake in wrsim costs this case alone
            marker.message = f"internal error: {type(error).__name__}: {error}"
        marker.wall_time, marker.ended = time.perf_counter() - begin, time.time()
        write_marker(folder, marker)
    if marker.status != TIMED_OUT:
        (folder / PART).unlink(missing_ok=True)


def _watchdog_limit(plan: Plan) -> float:
    """Time after which the watchdog ends the process of a case [s]."""
    return plan.time_limit * 1.1 + GRACE


@contextmanager
def _watched(folder: Path, plan: Plan) -> Iterator[None]:
    """End this process when the block lasts too long: works also where Python itself hangs."""
    hung = folder / HUNG
    with open(hung, "wb") as note:
        faulthandler.dump_traceback_later(_watchdog_limit(plan), exit=True, file=note)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
    hung.unlink(missing_ok=True)


def _simulate(plan: Plan, case: Case, folder: Path, marker: Marker) -> None:
    """The run itself: writes what is stored of it, notes its status and outputs in the marker."""
    if changed := changed_file(plan.files[case.files]):
        raise InputError(f"{changed}: has changed since the study was planned; start the study again")
    scenario = plan.scenario(case)
    write_atomically(folder / RECORD, scenario.text.encode())
    begin = time.perf_counter()
    result = _run(scenario, plan.files[case.files], folder / PART, plan.time_limit, marker)
    marker.simulation = time.perf_counter() - begin
    if plan.keep == "results":
        result.save(folder / RESULT)
        write_atomically(folder / "summary.json", as_json(result.summary()))
    marker.record_result(result, plan)


def _run(scenario: Scenario, files: Mapping[str, str], part: Path, limit: float, marker: Marker) -> Result:
    """The result of a scenario, from its part file where that can go on; files: with their digests."""
    until = time.monotonic() + limit

    def progress(fraction: float, seconds_left: float) -> None:
        if time.monotonic() > until:
            raise StopCase(fraction)

    setup = build(scenario, files)
    if ANALYSES[scenario.analysis].moves and part.exists():
        try:
            marker.resumed = True
            return run(scenario, progress, record=part, resume=True, setup=setup, threads=1)
        except InputError:  # cut off before its start, or by another state of the code
            marker.resumed = False
    return run(scenario, progress, record=part, setup=setup, threads=1)


def _reduce_again(plan: Plan, case: Case, folder: Path, marker: Marker) -> None:
    """Outputs of a changed section: from the stored result, else from a new run."""
    if (folder / RESULT).exists():
        with _watched(folder, plan):
            marker.record_result(Result.load(folder / RESULT), plan)
        marker.outputs = plan.outputs_digest
    elif marker.status in (TIMED_OUT, FAILED):
        marker.outputs = plan.outputs_digest
    else:
        _attempt(plan, case, folder)
        return
    write_marker(folder, marker)


def warm_cases(study: str, digest: str, indices: list[int]) -> str:
    """Compile the kernels that these cases need, by the first steps of each; gives the host's name."""
    plan = plan_in(study, digest)
    for index in indices:
        compile_for(plan.scenario(plan.cases[index]))
    return platform.node()


def compile_for(scenario: Scenario) -> None:
    """Compile what a scenario needs, by a short run; what fails in it fails again where it is reported."""

    def progress(fraction: float, seconds_left: float) -> None:
        raise StopCase(fraction)

    with suppress(StopCase, WrsimError):
        if not ANALYSES[scenario.analysis].moves:
            run(scenario, progress, setup=build(scenario), threads=1)
            return
        begun(scenario)


def begun(scenario: Scenario) -> Result:
    """The first steps of a run: they have all channels. Raises as `run`."""
    section = {key: value for key, value in scenario.merged.data.get("run", {}).items() if key != "distance_m"}
    short = scenario.with_values({"run": section | {"time_s": SHORT}, "output.patches_at_m": []})
    return run(short, setup=build(short), threads=1)


SHORT = 0.02
"""Time of the run that compiles [s]."""
