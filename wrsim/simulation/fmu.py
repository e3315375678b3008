"""A vehicle on its track as a co-simulation unit of FMI 3.0: one file with machine code, description and resources.

What a `Stepper` computes in is packed into the unit's library with the kernels that move it (``fmu.c``): it needs no
Python when it runs, and gives the bits of the `Stepper`.
"""

import hashlib
import io
import json
import platform
import re
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as xml

import numpy as np

import wrsim
from wrsim.contact import records, wheel_rail
from wrsim.contact.library.build import shared_library
from wrsim.jit.cache import digest_of_sources
from wrsim.jit.objects import this_target
from wrsim.simulation.stepper import Stepper
from wrsim.vehicle.dynamics import outputs, wheel_forces
from wrsim.vehicle.dynamics import stepper as kernel

SOURCE = Path(__file__).with_name("fmu.c")

UNITS: dict[str, tuple[str, dict[str, int]]] = {
    "m": ("m", {"m": 1}), "m_s": ("m/s", {"m": 1, "s": -1}), "m_s2": ("m/s2", {"m": 1, "s": -2}),
    "rad": ("rad", {"rad": 1}), "rad_s": ("rad/s", {"rad": 1, "s": -1}), "s": ("s", {"s": 1}),
    "N": ("N", {"kg": 1, "m": 1, "s": -2}), "Nm": ("N.m", {"kg": 1, "m": 2, "s": -2}),
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
    bench: Stepper, normal: int, name: str, title: str, duration: float, resources: Mapping[str, bytes]
) -> bytes:
    """The bytes of the file; normal: the stage of the normal model; name: of the file, without its ending; duration: of
    the run [s]; resources: files to go along. Raises WrsimError without a C compiler."""
    identifier = re.sub(r"\W|^(?=\d)", "_", name, flags=re.ASCII)
    variables = bench.inputs | bench.outputs
    content = bench.memory.index.astype("<i8").tobytes() + bench.memory.buffer.astype("<f8").tobytes()
    digest = hashlib.sha256(content).hexdigest()
    token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{digest_of_sources()} {list(variables)} {digest}"))
    table = {number: wheel_rail.STAGES[number] for number in (normal, records.CREEP_FORCES, records.CONTACT)}
    table |= {number: wheel_forces.STAGES[number] for number in (wheel_forces.ONE_WHEEL, wheel_forces.IN_TURN)}
    more = {"wrsim_advance": kernel.advance, "wrsim_observe": outputs.observe}
    header = {"fmu.h": _header(bench, token, variables)}
    library = shared_library(SOURCE, table, more, header, {"wrsim_fmu": content}, this_target())
    files = {
        "modelDescription.xml": _description(bench, title, identifier, token, duration),
        f"binaries/{platform.machine()}-linux/{identifier}.so": library,
        **{f"resources/{path}": content for path, content in resources.items()},
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path), content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def _header(bench: Stepper, token: str, variables: Mapping[str, np.ndarray]) -> str:
    """What fmu.c has to know: fmu.h. Variable 0 is the time."""
    buffer = bench.memory.buffer
    begin = buffer.ctypes.data
    places = [0, *((view.ctypes.data - begin) // buffer.itemsize for view in variables.values())]
    done = bench.memory.views[kernel.STEP_RECORD]["steps"]
    numbers = {
        "STEP": repr(float(bench.memory.views[kernel.STEP_RECORD]["h"][0])), "ROWS": len(bench.memory.index),
        "DOUBLES": buffer.size, "VARIABLES": len(places), "INPUTS": len(bench.inputs),
        "STEPS_DONE": (done.ctypes.data - begin) // buffer.itemsize, "NOT_FINITE": kernel.NOT_FINITE,
        "OFF_TRACK": wheel_forces.OFF_TRACK, "ADVANCE": "wrsim_advance", "OBSERVE": "wrsim_observe",
    }  # fmt: skip
    names = ", ".join(json.dumps(name, ensure_ascii=False) for name in ("time", *variables))
    lines = [f'#define TOKEN "{token}"', *(f"#define {name} {value}" for name, value in numbers.items())]
    lines += [f"static const int64_t places[] = {{{', '.join(map(str, places))}}};"]
    return "\n".join([*lines, f"static const char *const names[] = {{{names}}};", ""])


def _description(bench: Stepper, title: str, identifier: str, token: str, duration: float) -> bytes:
    """modelDescription.xml."""
    step = float(bench.memory.views[kernel.STEP_RECORD]["h"][0])
    root = xml.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=title, instantiationToken=token,
        description="A railway vehicle on its track; units are SI", generationTool=f"wrsim {wrsim.__version__}",
        variableNamingConvention="flat",
    )  # fmt: skip
    xml.SubElement(
        root, "CoSimulation", modelIdentifier=identifier, canGetAndSetFMUState="true", canSerializeFMUState="true",
        canHandleVariableCommunicationStepSize="true", fixedInternalStepSize=repr(step),
    )  # fmt: skip
    units = xml.SubElement(root, "UnitDefinitions")
    for name, base in UNITS.values():
        exponents = {symbol: str(exponent) for symbol, exponent in base.items()}
        xml.SubElement(xml.SubElement(units, "Unit", name=name), "BaseUnit", exponents)
    xml.SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(duration), stepSize=repr(step))
    variables, structure = xml.SubElement(root, "ModelVariables"), xml.Element("ModelStructure")
    more = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
    xml.SubElement(variables, "Float64", more | {"unit": "s", "description": MEANINGS["time"]})
    initial: list[str] = []
    for number, (name, view) in enumerate((bench.inputs | bench.outputs).items(), 1):
        ending = max((each for each in UNITS if name.endswith(f"_{each}")), key=len)
        word = name.rpartition(".")[2].removesuffix(f"_{ending}")
        more = {"name": name, "valueReference": str(number), "variability": "continuous", "unit": UNITS[ending][0]}
        meaning = re.sub("_(left|right)$", "", word)
        side = word.removeprefix(meaning).strip("_")
        more["description"] = MEANINGS[meaning] + (f" ({side} wheel)" if side else "")
        if number <= len(bench.inputs):
            more |= {"causality": "input", "start": repr(float(view[0]))}
        else:
            more |= {"causality": "output"}
            xml.SubElement(structure, "Output", valueReference=str(number), dependencies="")
            initial.append(str(number))
        xml.SubElement(variables, "Float64", more)
    for reference in initial:
        xml.SubElement(structure, "InitialUnknown", valueReference=reference, dependencies="")
    root.append(structure)
    xml.indent(root)
    return bytes(xml.tostring(root, encoding="UTF-8", xml_declaration=True))
