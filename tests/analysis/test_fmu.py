"""A vehicle as a co-simulation unit of FMI 3.0 and 2.0: valid, the bits of the stepper, laws of its inputs, what it
refuses, the systems it runs on."""

import os
import shutil
import sys
import zipfile
from pathlib import Path
from typing import Any, ClassVar

import numba
import numpy as np
import pytest
from support.commands import refusal
from support.objects import kept_objects
from support.runs import FAST, arc, straight, transition
from support.vehicles import ROOT

from wrsim import InputError, WrsimError, load, stepper, write_unit
from wrsim.jit.objects import this_target
from wrsim.simulation.stepper import Stepper

fmpy = pytest.importorskip("fmpy")
from fmpy import fmi2  # noqa: E402
from fmpy.fmi1 import FMICallException  # noqa: E402
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

CC = os.environ.get("CC", "cc").split()[0]
pytestmark = [
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing compiled"),
    pytest.mark.skipif(sys.platform != "linux" or shutil.which(CC) is None, reason="there is no C compiler here"),
]

STEP = 1e-3
PUSH = {"name": "push", "on": "carbody", "at_mm": [0.0, 0.0, 1800.0], "axes": "track", "force_kN": [0.0, 0.0, 0.0]}
COACH = load(ROOT / "scenarios/manchester_r300.toml").with_values(
    FAST
    | {
        "track.segments": [straight(20.0), transition(15.0), arc(60.0, 300.0, 100.0)],
        "run.start_distance_m": 5.0,
        "vehicle.drive": "free",
        "vehicle.loads": [PUSH],
    }
)


class Unit:
    """An instance of a unit, in step mode at the time 0 after `start`."""

    messages: list[str]

    def __init__(self, description: Any, folder: str) -> None:
        self.messages = []
        identifier = description.coSimulation.modelIdentifier
        super().__init__(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="coach")
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}

    def start(self: Any) -> Any:
        self.instantiate(logMessage=lambda environment, status, category, text: self.messages.append(text.decode()))
        return self.begin()

    def begin(self: Any) -> Any:
        self.enterInitializationMode()
        self.exitInitializationMode()
        return self

    def __getitem__(self: Any, name: str) -> float:
        return float(self.getFloat64([self.references[name]])[0])

    def __setitem__(self: Any, name: str, value: float) -> None:
        self.setFloat64([self.references[name]], [value])

    def step(self: Any, count: int = 1) -> None:
        self.doStep(self["time"], count * STEP)

    def refusal(self, call: Any, *arguments: Any) -> str:
        """The message with which the unit refuses a call."""
        with pytest.raises(FMICallException):
            call(*arguments)
        return self.messages[-1]


class FMU3Unit(Unit, FMU3Slave):
    """Of FMI 3.0."""

    names: ClassVar = {"get": "fmi3GetFloat64", "step": "fmi3DoStep", "whole": "fmi3GetInt32"}


class FMU2Unit(Unit, FMU2Slave):
    """Of FMI 2.0, whose calls have other names. fmpy takes the version from the name of a class."""

    names: ClassVar = {"get": "fmi2GetReal", "step": "fmi2DoStep", "whole": "fmi2GetInteger"}
    getFMUState, setFMUState = FMU2Slave.getFMUstate, FMU2Slave.setFMUstate
    serializeFMUState, deserializeFMUState = FMU2Slave.serializeFMUstate, FMU2Slave.deSerializeFMUstate
    getFloat64, setFloat64, getInt32 = FMU2Slave.getReal, FMU2Slave.setReal, FMU2Slave.getInteger

    def start(self) -> "FMU2Unit":
        def told(environment: Any, name: bytes, status: int, category: bytes, text: bytes) -> None:
            assert name == b"coach"
            self.messages.append(text.decode())

        functions = fmi2.fmi2CallbackFunctions()
        functions.logger = fmi2.fmi2CallbackLoggerTYPE(told)
        self.instantiate(callbacks=functions)
        self.setupExperiment()
        return self.begin()


@pytest.fixture(scope="module", params=["3", "2"])
def file(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.contact.library.build.emit_objects", kept_objects)
        path = tmp_path_factory.mktemp("unit") / "coach.fmu"
        step = None if request.param == "3" else STEP  # tried over the run, where none is given
        written = write_unit(COACH, path, fmi=request.param, systems=this_target(), step=step)
    assert written.lines == [f"FMI {request.param}.0, for {this_target()}; steps of 1 ms"]
    return Path(written.files[0])


@pytest.fixture(scope="module")
def made(file: Path) -> Any:
    """Instances of the unit, as many as a test asks for."""
    folder, description = fmpy.extract(str(file)), fmpy.read_model_description(str(file))
    kind = FMU2Unit if description.fmiVersion == "2.0" else FMU3Unit
    yield lambda: kind(description, folder).start()
    shutil.rmtree(folder)


def outputs(of: Any) -> bytes:
    """All outputs, in the order of a stepper's."""
    if isinstance(of, Stepper):
        return np.array([float(view[0]) for view in of.outputs.values()]).tobytes()
    names = [name for name in of.references if name != "time"][-COUNT:]
    return np.array(of.getFloat64([of.references[name] for name in names])).tobytes()


COUNT = 2 + 11 * 7 + 7 * 4 + 2 * 20  # of contacts, bodies, wheelsets and struts of the coach


def test_the_description_is_valid_and_the_scenario_in_the_unit_is_whole(file: Path, tmp_path: Path) -> None:
    assert validate_fmu(str(file)) == []
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path)
    for part in (path for path in tmp_path.rglob("*") if path.is_file()):
        assert not any(str(folder).encode() in part.read_bytes() for folder in (ROOT, tmp_path, Path.home()))
    again = load(tmp_path / "resources/scenario.toml")
    assert again.text == COACH.text
    assert (tmp_path / "resources/vehicles/manchester_1.toml").is_file()


def test_a_unit_has_the_bits_of_the_stepper(made: Any) -> None:
    """From straight track into the curve, beside a second instance on which other forces act."""
    unit, disturbed, bench = made(), made(), stepper(COACH)
    disturbed["front.outer.torque_Nm"] = 2e3
    assert len(bench.outputs) == COUNT
    assert outputs(unit) == outputs(bench)
    for _ in range(10):
        unit.step(50)
        disturbed.step(50)
        bench.step(50)
        assert outputs(unit) == outputs(bench)
    assert unit["time"] == bench.time == pytest.approx(0.5)
    assert disturbed["carbody.speed_m_s"] > unit["carbody.speed_m_s"] + 1e-3
    assert 5.0 < unit["carbody.distance_m"] < 20.0 and unit["carbody.yaw_rate_rad_s"] > 0.0


def test_a_torque_changes_the_angular_momentum_of_its_wheelset(made: Any) -> None:
    """J (omega - omega_0) is the integral of M + r (X_left + X_right), X forward on the rail; against a run without."""
    driven, free = made(), made()
    name, moment, radius = "front.outer", 3e3, 0.46
    before, sums = [unit[f"{name}.rotation_rad_s"] for unit in (driven, free)], np.zeros(2)
    driven[f"{name}.torque_Nm"] = moment
    for _ in range(40):
        for i, unit in enumerate((driven, free)):
            unit.step()
            sums[i] += STEP * radius * (unit[f"{name}.X_left_N"] + unit[f"{name}.X_right_N"])
    after = [unit[f"{name}.rotation_rad_s"] for unit in (driven, free)]
    inertia = stepper(COACH).law.vehicle.wheelsets[0].wheelset.inertia[1]
    gained = inertia * ((after[0] - before[0]) - (after[1] - before[1]))
    resisting = sums[0] - sums[1]
    assert gained == pytest.approx(40 * STEP * moment + resisting, rel=0.02, abs=0.01 * 40 * STEP * moment)
    assert -resisting > 0.5 * 40 * STEP * moment  # the wheels hold on to their rails


def test_the_force_of_a_control_acts_on_both_ends(made: Any) -> None:
    """Bodies change their momentum by its impulse, one as the other: none for the vehicle."""
    unit, plain = made(), made()
    name = "front.secondary_lateral_damper_left"
    unit[f"{name}.control_N"] = 2e3
    bodies, masses = ("carbody", "front.frame"), (32000.0, 2615.0)
    unit.step()
    plain.step()
    change = [mass * (unit[f"{b}.acceleration_y_m_s2"] - plain[f"{b}.acceleration_y_m_s2"])
              for b, mass in zip(bodies, masses, strict=True)]  # fmt: skip
    # the frame is the second body; in the first millisecond springs and dampers give in by little
    assert change[1] == pytest.approx(2e3, rel=0.1)
    assert change[0] == pytest.approx(-2e3, rel=0.1)
    assert unit[f"{name}.force_N"] - plain[f"{name}.force_N"] == pytest.approx(2e3, rel=0.1)


def test_a_unit_begins_again_and_goes_back_to_a_state(made: Any) -> None:
    unit, second_unit = made(), made()
    unit.step(20)
    first = outputs(unit)
    state = unit.getFMUState()
    content = unit.serializeFMUState(state)
    unit["front.outer.torque_Nm"] = -1e3
    unit.step(20)
    braked = outputs(unit)
    unit.setFMUState(state)
    assert outputs(unit) == first and unit["front.outer.torque_Nm"] == 0.0
    taken = second_unit.deserializeFMUState(content)
    second_unit.setFMUState(taken)
    for each in (unit, second_unit):
        each["front.outer.torque_Nm"] = -1e3
        each.step(20)
        assert outputs(each) == braked
    assert "no state of this unit" in second_unit.refusal(second_unit.deserializeFMUState, content[:-8])
    for place, forged in ((48, 5), (48, -1), (48, 1 << 40), (40, 0x7FF8 << 48)):  # the mode, a start that is no number
        state = content[:place] + int(forged).to_bytes(8, "little", signed=True) + content[place + 8 :]
        assert "no state of this unit" in second_unit.refusal(second_unit.deserializeFMUState, state)
    unit.reset()
    unit.begin().step(20)
    assert outputs(unit) == first


def test_what_a_unit_cannot_do_or_be_is_refused(made: Any, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    unit = made()
    torque, force = (unit.references[f"rear.inner.{name}"] for name in ("torque_Nm", "Y_left_N"))
    assert unit.refusal(unit.setFloat64, [torque], [np.nan]) == "rear.inner.torque_Nm: must be a finite number, not nan"
    assert unit.refusal(unit.setFloat64, [force], [0.0]) == "rear.inner.Y_left_N: is no input"
    assert unit.refusal(unit.getFloat64, [9999]) == f"{unit.names['get']}: there is no variable 9999"
    assert "whole number of steps of 0.001 s" in unit.refusal(unit.doStep, 0.0, 0.0015)
    assert "the unit is at the time 0 s" in unit.refusal(unit.doStep, 0.5, STEP)
    assert f"{unit.names['whole']}: is not offered" in unit.refusal(unit.getInt32, [1])
    unit.step()  # none of it did any harm
    unit["push.force_y_N"] = 1e9
    assert "no longer near its track" in unit.refusal(unit.step, 2000) or "not a number" in unit.messages[-1]
    assert unit.refusal(unit.step) == f"{unit.names['step']}: the unit is failed"
    unit.reset()
    assert unit.refusal(unit.step) == f"{unit.names['step']}: the unit is instantiated"
    unit.begin().step()
    description = fmpy.read_model_description(str(file))
    description.guid = "another"
    stranger = type(unit)(description, unit.unzipDirectory)
    with pytest.raises(Exception, match="Failed to instantiate"):
        stranger.start()
    assert "the instantiation token is not that of this unit" in stranger.messages[-1]
    users_file = tmp_path / "mine.fmu"
    users_file.write_text("mine")
    scenario = ROOT / "scenarios/static_s1002.toml"
    assert "wrsim did not write it" in refusal("fmu", scenario, "-o", users_file)
    assert users_file.read_text() == "mine"
    assert "only runs along the track" in refusal("fmu", scenario, "-o", tmp_path / "static.fmu")
    assert "must end in .fmu" in refusal("fmu", scenario, "-o", tmp_path / "static.zip")
    assert "'--step-ms'" in refusal("fmu", scenario, "--step-ms", "7")
    with pytest.raises(InputError, match=r"^step = 0\.1: must be above 0"):
        write_unit(COACH, tmp_path / "coach.fmu", step=0.1)
    with pytest.raises(InputError, match=r'--for "win": must be .* did you mean "windows"'):
        write_unit(COACH, tmp_path / "coach.fmu", systems="linux, win")
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(WrsimError, match="no C compiler"):
        write_unit(COACH, tmp_path / "coach.fmu", systems=this_target())
    assert not (tmp_path / "coach.fmu").exists()


@pytest.mark.parametrize(
    ("version", "folders"),
    [
        ("2", ["aarch64-linux/x.so", "darwin64/x.dylib", "linux64/x.so", "win64/x.dll"]),
        ("3", ["aarch64-darwin/x.dylib", "aarch64-linux/x.so", "x86_64-linux/x.so", "x86_64-windows/x.dll"]),
    ],
)
def test_a_unit_has_a_library_for_every_system_that_there_is_a_compiler_for(version, folders, tmp_path, monkeypatch):
    def linked(*arguments: Any) -> bytes:
        return str(arguments[-1]).encode()

    monkeypatch.setattr("wrsim.simulation.fmu.shared_library", linked)
    path = tmp_path / "x.fmu"
    for zig, told in ((True, 1), (False, 4)):
        if not zig:
            monkeypatch.setattr("wrsim.contact.library.build.find_spec", lambda name: None)
        written = write_unit(COACH, path, fmi=version)
        with zipfile.ZipFile(path) as archive:
            libraries = sorted(
                name.removeprefix("binaries/") for name in archive.namelist() if name.startswith("binaries")
            )
        assert libraries == (
            folders if zig else [name for name in folders if "aarch64" not in name and "linux" in name]
        )
        assert len(written.lines) == told
    assert written.lines[1] == "not for linux-arm: needs zig: pip install 'wrsim[cross]'"
    with pytest.raises(WrsimError, match=r"^windows: needs zig"):
        write_unit(COACH, path, fmi=version, systems="windows")


def test_a_unit_of_fmi_2_is_told_its_start_and_knows_its_last_time(tmp_path: Path, made: Any) -> None:
    unit = made()
    if not isinstance(unit, FMU2Unit):
        return
    unit.reset()
    unit.setupExperiment(startTime=2.5)
    unit.begin().doStep(2.5, STEP)
    assert unit["time"] == unit.getRealStatus(2) == 2.5 + STEP
    assert not unit.getBooleanStatus(3)
