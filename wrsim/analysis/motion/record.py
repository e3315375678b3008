"""Record a run in a file while it lasts, and going on with one that was cut off.

The file lies beside the result that it becomes (``result.nc.part``) and holds, next to samples and checkpoints
(``wrsim.simulation.recorder``), what the run was: the scenario as text, a digest of every number that the scenario's
files came to, and the versions that shape the numbers. A run goes on only where all of that is the same.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

import wrsim
from wrsim.errors import InputError, in_one_line
from wrsim.inputs.changes import leaves
from wrsim.inputs.toml_files import parse_toml
from wrsim.results import versions
from wrsim.results.run_file import run_header
from wrsim.scenario.build import Setup, build
from wrsim.scenario.kept import ATTRIBUTE, scenario_of
from wrsim.scenario.loading import Scenario
from wrsim.simulation.recorder import Recorder


@dataclass(frozen=True)
class RunRecord:
    """Where a run is stored while it lasts, whether it goes on with what is there, and the header of the file."""

    path: Path
    resume: bool
    header: dict[str, Any]

    @classmethod
    def of(cls, scenario: Scenario, setup: Setup, path: Path, resume: bool = False) -> RunRecord:
        """For a scenario. With ``resume``, raises ``InputError`` when the file is that of another run."""
        header = {
            "title": scenario.title,
            "analysis": scenario.analysis,
            "scenario_text": scenario.text,
            "inputs": dict(setup.inputs),
            ATTRIBUTE: setup.kept.packed(),
            **_digests(setup),
            **versions(),
        }
        if resume:
            _same_run(path, header)
        return cls(path, resume, header)

    def recorder(self, integrator: str, step: float, size: int) -> Recorder:
        """The file, to be written on: from its last checkpoint, or anew. step [s]; size: number of coordinates."""
        if self.resume:
            return Recorder.continued(self.path)
        of_run = {"integrator": integrator, "step_s": step, "start_s": 0.0}
        return Recorder.create(self.path, self.header | of_run, size)


def _same_run(path: Path, header: dict[str, Any]) -> None:
    """Raise ``InputError`` when a file holds a run that would not go on with the same numbers."""
    stored = run_header(path)
    again = "run it without --resume to start from the beginning"
    texts = (parse_toml(of["scenario_text"], f"{path}: its scenario") for of in (stored, header))
    before, after = (dict(leaves(text)) for text in texts)
    for key in [*before, *after]:
        if before.get(key) != after.get(key):
            old, new = ("missing" if v is None else repr(v) for v in (before.get(key), after.get(key)))
            raise InputError(f"{path}: is the run of another scenario: {key} was {old}, here it is {new}; {again}")
    for name in ("wrsim", "python", "numpy", "numba", "exudyn", "scipy"):
        a, b = stored.get(f"{name}_version"), header[f"{name}_version"]
        if a != b:
            raise InputError(f"{path}: was computed with {name} {a}, this is {b}: the numbers would differ; {again}")
    if stored["code"] != header["code"]:
        raise InputError(f"{path}: was computed by another state of wrsim's code: the numbers may differ; {again}")
    _same_models(path, stored, header, again)


def _same_models(path: Path, stored: dict[str, Any], header: dict[str, Any], again: str) -> None:
    """Raise ``InputError`` when a file that shapes the run is not what it was.

    Other code may read the same files into other numbers: then the files themselves have to do.
    """
    changed = [file for file, digest in header["files"].items() if stored["files"].get(file, digest) != digest]
    if not changed and (stored["numbers"] == header["numbers"] or stored["code"] != header["code"]):
        return
    subject = f"{changed[0]} has" if len(changed) == 1 else "files that the scenario names have"
    raise InputError(f"{path}: {subject} changed since the run began; {again}")


def recorded_setup(path: Path) -> Setup:
    """The set-up of the run that a file holds, from the scenario and the model files in it. Raises ``InputError``."""
    header = run_header(path)
    try:
        setup = build(scenario_of(header, path.parent))
    except InputError as error:
        raise InputError(f"{path}: {in_one_line(error)}") from None
    again = "what is in the file can no longer be read: run the scenario again"
    _same_models(path, header, _digests(setup), again)
    return replace(setup, inputs=header["inputs"])  # of the scenario's own file, too


def _digests(setup: Setup) -> dict[str, Any]:
    """Hash of every file that the scenario names, of all numbers of the set-up, of the code."""
    files = {str(f): hashlib.sha256(setup.kept.contents[f]).hexdigest()[:16] for f in setup.files}
    return {"files": files, "numbers": numbers_digest(setup), "code": code_digest()}


@lru_cache(maxsize=1)
def code_digest() -> str:
    """Digest of all sources of wrsim and of their tables."""
    digest = hashlib.sha256()
    root = os.path.dirname(wrsim.__file__)
    for folder, folders, names in os.walk(root):
        skipped = {"__pycache__", "models"} if folder == root else {"__pycache__"}
        folders[:] = sorted({*folders} - skipped)
        for name in sorted(name for name in names if name.endswith((".py", ".toml", ".csv"))):
            digest.update(os.path.join(folder, name).removeprefix(root).encode())
            digest.update(Path(folder, name).read_bytes())
    return digest.hexdigest()[:32]


def numbers_digest(setup: Setup) -> str:
    """Digest of all numbers and words of a set-up, however deep they lie; not of its text, nor of its files as such."""
    digest = hashlib.sha256()
    _feed(digest, setup)
    return digest.hexdigest()[:32]


def _feed(digest: Any, value: object) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value):
        for field in fields(value):
            if not field.name.startswith("_") and field.name not in ("text", "title", "inputs", "kept"):
                digest.update(field.name.encode())
                _feed(digest, getattr(value, field.name))
    elif isinstance(value, dict):
        for key in value:
            digest.update(repr(key).encode())
            _feed(digest, value[key])
    elif isinstance(value, tuple | list):
        digest.update(f"[{len(value)}]".encode())
        for item in value:
            _feed(digest, item)
    elif value is None or isinstance(value, str | int | float | complex | np.generic):
        digest.update(repr(value).encode())
    # functions, splines, names of files: made from what has been fed, or of no weight
