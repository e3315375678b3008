"""A vehicle on its track as a co-simulation unit of FMI 3.0 or 2.0: one file with machine code for several systems,
description and resources.

What a `Stepper` computes in is packed into the unit's library with the kernels that move it (``fmu.c``): it needs no
Python when it runs, and gives the bits of the `Stepper`.
"""

import hashlib
import io
import json
import logging
import re
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree as xml

import numpy as np

import wrsim
from wrsim.contact import records, wheel_rail
from wrsim.contact.library.build import LINKING, shared_library
from wrsim.jit.cache import digest_of_sources
from wrsim.simulation.stepper import Stepper
from wrsim.vehicle.dynamics import outputs, wheel_forces
from wrsim.vehicle.dynamics import stepper as kernel

SOURCE = Path(__file__).with_name("fmu.c")
LOGGER = logging.getLogger("wrsim.kernels")
"""Says at level INFO which library is being made; nothing at the end."""

FOLDERS: dict[str, dict[str, str]] = {
    "2": {"linux": "linux64", "linux-arm": "aarch64-linux", "windows": "win64", "macos": "darwin64"},
    "3": {
        "linux": "x86_64-linux", "linux-arm": "aarch64-linux", "windows": "x86_64-windows", "macos": "aarch64-darwin",
    },
}  # fmt: skip
"""Folders of the libraries in a unit, by version of FMI and target. FMI 2.0 has no name for arm64 on Linux."""

UNITS: dict[str, tuple[str, dict[str, int]]] = {
    "m": ("m", {"m": 1}), "m_s": ("m/s", {"m": 1, "s": -1}), "m_s2": ("m/s2", {"m": 1, "s": -2}),
    "rad": ("rad", {"rad": 1}), "rad_s": ("rad/s", {"rad": 1, "s": -1}), "s": ("s", {"s": 1}),
    "": ("1", {}), "N": ("N", {"kg": 1, "m": 1, "s": -2}), "Nm": ("N.m", {"kg": 1, "m": 2, "s": -2}),
}  # fmt: skip
"""Name and base units, by how the name of a variable ends."""

MEANINGS = {
    "time": "time since the start of the scenario's run, plus the start time",
    "torque": "moment of motor and brake about the axle, positive forward, with its reaction on what holds it; "
    "a negative one brakes: it is against the rotation and fades at rest",
    "control": "force added to the element: tension, or on the second body along the element's axis",
    "force_x": "first component of the load, along its axes",
    "force_y": "second component of the load, along its axes",
    "force_z": "third component of the load, along its axes",
    "coarse": "contacts of the step with half as many strips or a larger residual, as the budget was spent",
    "unsolved": "of these: forces of Kik and Piotrowski's model",
    "distance": "distance of the centre of mass along the centre line",
    "speed": "speed of the centre of mass along the track",
    "lateral": "shift of the centre of mass to the left of the centre line",
    "height": "height of the centre of mass above the centre line",
    "yaw": "yaw against the track, positive to the left",
    "roll": "roll against the track, positive with the left side up",
    "yaw_rate": "angular velocity about the body's vertical axis",
    "rotation": "angular velocity about the axle or the body's lateral axis",
    "acceleration_x": "acceleration of the centre of mass, forward",
    "acceleration_y": "acceleration of the centre of mass, to the left",
    "acceleration_z": "acceleration of the centre of mass, up",
    "slip": "slip speed of the wheels at the mean radius, forward",
    "X": "force of the wheel on the rail, forward",
    "Y": "force of the wheel on the rail, outward",
    "Q": "force of the wheel on the rail, down",
    "force": "force of the element: tension, or on the second body along the element's axis",
    "travel": "extension of the element, or way of the second body along the element's axis",
}


def pack_fmu(
    bench: Stepper, normal: int, name: str, title: str, duration: float, resources: Mapping[str, bytes],
    targets: Sequence[str], version: str,
) -> bytes:  # fmt: skip
    """The bytes of the file; normal: the stage of the normal model; name: of the file, without its ending; duration: of
    the run [s]; resources: files to go along; targets: systems (`jit.objects`); version: of FMI, "2" or "3". Raises
    WrsimError without a C compiler."""
    identifier = re.sub(r"\W|^(?=\d)", "_", name, flags=re.ASCII)
    digest = hashlib.sha256(_content(bench)).hexdigest()
    token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{digest_of_sources()} {list(bench.inputs | bench.outputs)} {digest}"))
    describe = _description_2 if version == "2" else _description_3
    files = {"modelDescription.xml": describe(bench, title, identifier, token, duration)}
    for i, target in enumerate(targets, 1):
        LOGGER.info("machine code for %s, %d of %d", target, i, len(targets))
        path = f"binaries/{FOLDERS[version][target]}/{identifier}.{LINKING[target][0]}"
        files[path] = unit_program(bench, normal, token, target)
    LOGGER.info("")
    files |= {f"resources/{path}": content for path, content in resources.items()}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path), content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def unit_program(bench: Stepper, normal: int, token: str, target: str) -> bytes:
    """The library of a unit for one target; token: that who makes an instance has to name. Raises WrsimError without a
    C compiler."""
    table = {number: wheel_rail.STAGES[number] for number in (normal, records.CREEP_FORCES, records.CONTACT)}
    table |= {number: wheel_forces.STAGES[number] for number in (wheel_forces.ONE_WHEEL, wheel_forces.IN_TURN)}
    more = {"wrsim_advance": kernel.advance, "wrsim_observe": outputs.observe}
    header = {"fmu.h": _header(bench, token, bench.inputs | bench.outputs)}
    return shared_library(SOURCE, table, more, header, {"wrsim_fmu": _content(bench)}, target)


def _content(bench: Stepper) -> bytes:
    """The workspace: index, then buffer."""
    return bench.memory.index.astype("<i8").tobytes() + bench.memory.buffer.astype("<f8").tobytes()


def _header(bench: Stepper, token: str, variables: Mapping[str, np.ndarray]) -> str:
    """What fmu.c has to know: fmu.h. Variable 0 is the time."""
    buffer = bench.memory.buffer
    begin = buffer.ctypes.data
    places = [0, *((view.ctypes.data - begin) // buffer.itemsize for view in variables.values())]
    done = bench.memory.views[kernel.STEP_RECORD]["steps"]
    numbers = {
        "STEP": repr(_step(bench)), "ROWS": len(bench.memory.index),
        "DOUBLES": buffer.size, "VARIABLES": len(places), "INPUTS": len(bench.inputs),
        "STEPS_DONE": (done.ctypes.data - begin) // buffer.itemsize, "NOT_FINITE": kernel.NOT_FINITE,
        "OFF_TRACK": wheel_forces.OFF_TRACK, "ADVANCE": "wrsim_advance", "OBSERVE": "wrsim_observe",
    }  # fmt: skip
    names = ", ".join(json.dumps(name, ensure_ascii=False) for name in ("time", *variables))
    lines = [f'#define TOKEN "{token}"', *(f"#define {name} {value}" for name, value in numbers.items())]
    lines += [f"static const int64_t places[] = {{{', '.join(map(str, places))}}};"]
    return "\n".join([*lines, f"static const char *const names[] = {{{names}}};", ""])


def _variables(bench: Stepper) -> list[dict[str, str]]:
    """What both versions of FMI say of the variables; the time is the first."""
    rows = [{
        "name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous", "unit": "s",
        "description": MEANINGS["time"],
    }]  # fmt: skip
    for number, (name, view) in enumerate((bench.inputs | bench.outputs).items(), 1):
        ending = max((each for each in UNITS if each == "" or name.endswith(f"_{each}")), key=len)
        word = name.rpartition(".")[2].removesuffix(f"_{ending}")
        row = {"name": name, "valueReference": str(number), "variability": "continuous", "unit": UNITS[ending][0]}
        meaning = re.sub("_(left|right)$", "", word)
        side = word.removeprefix(meaning).strip("_")
        row["description"] = MEANINGS[meaning] + (f" ({side} wheel)" if side else "")
        is_in = number <= len(bench.inputs)
        rows.append(row | ({"causality": "input", "start": repr(float(view[0]))} if is_in else {"causality": "output"}))
    return rows


def _root(version: str, title: str, about: Mapping[str, str], can: Mapping[str, str]) -> xml.Element:
    """modelDescription.xml with its units. about: attributes of the whole, can: of the co-simulation."""
    root = xml.Element(
        "fmiModelDescription", dict(about), fmiVersion=version, modelName=title,
        description="A railway vehicle on its track; units are SI", generationTool=f"wrsim {wrsim.__version__}",
        variableNamingConvention="flat",
    )  # fmt: skip
    xml.SubElement(root, "CoSimulation", {**can, "canHandleVariableCommunicationStepSize": "true"})
    units = xml.SubElement(root, "UnitDefinitions")
    for name, base in UNITS.values():
        exponents = {symbol: str(exponent) for symbol, exponent in base.items()}
        xml.SubElement(xml.SubElement(units, "Unit", name=name), "BaseUnit", exponents)
    return root


def _text(root: xml.Element) -> bytes:
    xml.indent(root)
    return bytes(xml.tostring(root, encoding="UTF-8", xml_declaration=True))


def _experiment(bench: Stepper, duration: float) -> dict[str, str]:
    return {"startTime": "0", "stopTime": repr(duration), "stepSize": repr(_step(bench))}


def _step(bench: Stepper) -> float:
    return float(bench.memory.views[kernel.STEP_RECORD]["h"][0])


def _description_3(bench: Stepper, title: str, identifier: str, token: str, duration: float) -> bytes:
    """modelDescription.xml of FMI 3.0."""
    can = {"modelIdentifier": identifier, "canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
    can["fixedInternalStepSize"] = repr(_step(bench))
    root = _root("3.0", title, {"instantiationToken": token}, can)
    xml.SubElement(root, "DefaultExperiment", _experiment(bench, duration))
    variables, structure = xml.SubElement(root, "ModelVariables"), xml.SubElement(root, "ModelStructure")
    rows = _variables(bench)
    for row in rows:
        xml.SubElement(variables, "Float64", row)
    for kind in ("Output", "InitialUnknown"):
        for row in rows:
            if row["causality"] == "output":
                xml.SubElement(structure, kind, valueReference=row["valueReference"], dependencies="")
    return _text(root)


def _description_2(bench: Stepper, title: str, identifier: str, token: str, duration: float) -> bytes:
    """modelDescription.xml of FMI 2.0."""
    can = {"modelIdentifier": identifier, "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
    can["canNotUseMemoryManagementFunctions"] = "true"
    root = _root("2.0", title, {"guid": token}, can)
    xml.SubElement(root, "DefaultExperiment", _experiment(bench, duration))
    variables, structure = xml.SubElement(root, "ModelVariables"), xml.SubElement(root, "ModelStructure")
    rows = _variables(bench)
    for row in rows:
        real: dict[str, str] = {key: row.pop(key) for key in ("unit", "start") if key in row}
        xml.SubElement(xml.SubElement(variables, "ScalarVariable", row), "Real", real)
    for kind in ("Outputs", "InitialUnknowns"):
        unknowns = xml.SubElement(structure, kind)
        for index, row in enumerate(rows, 1):
            if row["causality"] == "output":
                xml.SubElement(unknowns, "Unknown", index=str(index), dependencies="")
    return _text(root)
