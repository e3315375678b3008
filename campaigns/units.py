"""Co-simulation units on all systems that can be run here, beside the stepper on this one: a coach into a curve, 3 s.

    python campaigns/units.py                                  FMI 2.0 and 3.0 by fmpy, arm64 under qemu-user
    python campaigns/units.py --windows "FOLDER/run FOLDER/python/python.exe"    and on Windows (.ci/windows)

Prints, for every unit of measurement, the largest difference of all outputs over the largest value in that unit.
"""

import argparse
import json
import shlex
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
import zipfile
from pathlib import Path

STEPS, EVERY, STEP = 3000, 100, 1e-3
LARGEST = 8.0  # MB, of a unit for all systems
COACH = Path(__file__).parents[1] / "scenarios/manchester_r300.toml"
SYSROOT = "/usr/aarch64-linux-gnu"  # Debian's libc6-arm64-cross
ALLOWED = 1e-6


def played(unit: Path) -> list[list[float]]:
    """All outputs of a unit after every EVERY steps, by fmpy."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    about, folder = fmpy.read_model_description(str(unit)), fmpy.extract(str(unit))
    kind = FMU2Slave if about.fmiVersion == "2.0" else FMU3Slave
    identifier = about.coSimulation.modelIdentifier
    instance = kind(guid=about.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="coach")
    instance.instantiate()
    if kind is FMU2Slave:
        instance.setupExperiment()
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    names = [variable.valueReference for variable in about.modelVariables if variable.causality == "output"]
    rows = []
    for k in range(STEPS):
        instance.doStep(k * STEP, STEP)
        if (k + 1) % EVERY == 0:
            rows.append(list(instance.getReal(names) if kind is FMU2Slave else instance.getFloat64(names)))
    instance.terminate()
    instance.freeInstance()
    return rows


def on_arm(unit: Path, scratch: Path) -> list[list[float]]:
    """The same by a C program on arm64 under qemu."""
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(scratch)
    root = xml.parse(scratch / "modelDescription.xml").getroot()
    outputs = [v.get("valueReference", "") for v in root.iter("Float64") if v.get("causality") == "output"]
    library = next((scratch / "binaries/aarch64-linux").iterdir())
    source = Path(__file__).with_name("units_arm.c")
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "aarch64-linux-gnu.2.28", "-ldl", "-o", "player"]
    subprocess.run([*command, str(source)], cwd=scratch, check=True)
    emulator = shutil.which("qemu-aarch64-static") or "qemu-aarch64"
    command_arguments = [library, root.get("instantiationToken"), outputs[0], len(outputs), STEPS, EVERY]
    done = subprocess.run(
        [emulator, "-L", SYSROOT, "./player", *map(str, command_arguments)],
        cwd=scratch,
        check=True,
        capture_output=True,
        text=True,
    )
    return [[float(number) for number in line.split()] for line in done.stdout.splitlines()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--windows", help="command that runs Python for Windows")
    parser.add_argument("--play", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.play:
        Path(arguments.play[1]).write_text(json.dumps(played(Path(arguments.play[0]))), encoding="utf-8")
        return

    import fmpy
    import numpy as np
    from fmpy.validation import validate_fmu

    from wrsim import stepper, write_unit

    bench = stepper(COACH, STEP)
    reference = []
    for _ in range(STEPS // EVERY):
        bench.step(EVERY)
        reference.append([float(view[0]) for view in bench.outputs.values()])
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        units = {
            version: Path(write_unit(COACH, place / f"coach{version}.fmu", fmi=version).files[0]) for version in "23"
        }
        outputs_of_player = {f"FMI {version}, this system": played(unit) for version, unit in units.items()}
        if arguments.windows:
            for version, unit in units.items():
                script, out = Path(__file__), place / f"{version}.json"
                subprocess.run([*shlex.split(arguments.windows), script, "--play", unit, out], check=True)
                outputs_of_player[f"FMI {version}, Windows"] = json.loads(out.read_text(encoding="utf-8"))
        if shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64"):
            outputs_of_player["FMI 3, arm64"] = on_arm(units["3"], place)
        else:
            print("no qemu-user here (Debian's qemu-user-static, libc6-arm64-cross): arm64 is not run")
        sizes: list[float] = []
        for version, unit in units.items():
            sizes.append(unit.stat().st_size / 1e6)
            print(f"FMI {version}: {sizes[-1]:.2f} MB; fmpy's validation: {validate_fmu(str(unit)) or 'no remark'}")
        about = fmpy.read_model_description(str(units["3"]))
    kinds = np.array([v.unit for v in about.modelVariables if v.causality == "output"])
    worst = 0.0
    for name, rows in outputs_of_player.items():
        off, largest = np.abs(np.array(rows) - reference).max(axis=0), np.abs(reference).max(axis=0)
        by_unit = {kind: off[kinds == kind].max() / largest[kinds == kind].max() for kind in sorted(set(kinds))}
        worst = max(worst, *by_unit.values())
        print(f"{name}: {len(kinds)} outputs, " + ", ".join(f"{kind} {value:.1e}" for kind, value in by_unit.items()))
    sys.exit(worst > ALLOWED or max(sizes) > LARGEST)


if __name__ == "__main__":
    main()
