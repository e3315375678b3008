"""A Result: one labelled dataset, kept in one NetCDF file."""

from __future__ import annotations

import gc
import io
import sys
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wrsim.errors import InputError
from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS
from wrsim.results.dataset import FORMAT, FORMAT_VERSION, NAMED, REQUIRED_ATTRIBUTES, SINGLE, STATUSES
from wrsim.results.files import write_atomically

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SEALED_SINCE = 2
"""Format from which on every file ends with a checksum."""
_CHECKED = b"wrsim CRC-32"
"""Stands behind the HDF5 data, before the checksum of all that comes before; other readers do not look there."""


@dataclass(frozen=True, eq=False)
class Result:
    """What an analysis computed, with everything needed to redraw and to rerun it.

    ``dataset`` comes from ``assemble``: channels as variables with ``units`` and ``long_name``; scenario
    text, status and versions as attributes. A stopped run holds what was computed until it stopped.
    """

    dataset: xr.Dataset

    @property
    def title(self) -> str:
        """Title of the scenario."""
        return str(self.dataset.attrs["title"])

    @property
    def analysis(self) -> str:
        """Kind of the analysis: ``"static"``, ``"equilibrium"``, ``"curving"`` ..."""
        return str(self.dataset.attrs["analysis"])

    @property
    def status(self) -> str:
        """``"completed"`` or ``"stopped"``."""
        return str(self.dataset.attrs["status"])

    @property
    def stop_reason(self) -> str:
        """Why the analysis stopped early; empty when it did not."""
        return str(self.dataset.attrs.get("stop_reason", ""))

    def wheelset(self, name: str | None = None) -> xr.Dataset:
        """Channels of one wheelset, without the dimension ``wheelset``; ``distance`` is its own.

        name: not needed where there is only one. Raises ``InputError`` for a wrong name, or when one is needed.
        """
        from wrsim.results.wheelsets import of_wheelset

        return of_wheelset(self.dataset, name)

    def summary(self) -> dict[str, Any]:
        """Peak and quasi-static values as plain numbers in units for readers; what ``summary.json`` holds."""
        from wrsim.results.summary import summarise

        return summarise(self.dataset)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF 4; the file appears whole or not at all. Raises ``WrsimError``."""
        encoding = {
            str(name): {"zlib": True, "complevel": 1, "shuffle": True}
            for name, variable in self.dataset.variables.items()
            if variable.dtype.kind in "fi" and variable.size > 1000
        }
        content = self.dataset.to_netcdf(None, engine="h5netcdf", format="NETCDF4", encoding=encoding)
        checksum = zlib.crc32(_CHECKED, zlib.crc32(content))
        return write_atomically(path, b"".join((content, _CHECKED, checksum.to_bytes(4, "little"))))

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a file that ``save`` wrote. Raises ``InputError`` when it is missing, damaged or not ours."""
        path = Path(path)
        if path.is_dir():
            path = path / "result.nc"
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            raise InputError(f"{path}: there is no such result file") from None
        except OSError as problem:
            why = (problem.strerror or str(problem)).lower()
            raise InputError(f"{path}: cannot be read: {why}") from problem
        if not content.startswith(_HDF5_SIGNATURE):
            raise InputError(f"{path}: not a wrsim result (not a NetCDF 4 file)")
        damaged = f"{path}: the file is damaged or incomplete; run the scenario again"
        sealed = content[:-4].endswith(_CHECKED)
        if sealed and content[-4:] != zlib.crc32(content[:-4]).to_bytes(4, "little"):
            raise InputError(damaged)
        opened = _opened(content)
        if opened is None:
            raise InputError(damaged)
        dataset = _without_encoding(opened)
        attributes = dataset.attrs
        if attributes.get("format") != FORMAT:
            raise InputError(f"{path}: a NetCDF file, but not a wrsim result")
        version = attributes.get("format_version")
        if not isinstance(version, int):
            raise InputError(f"{path}: says that it is a wrsim result, but not in which format; run the scenario again")
        if version > FORMAT_VERSION:
            raise InputError(
                f"{path}: written by a newer wrsim ({attributes.get('wrsim_version', 'unknown version')}) "
                f"in format {version}; this one reads up to {FORMAT_VERSION}"
            )
        if version >= _SEALED_SINCE and not sealed:
            raise InputError(
                f"{path}: its checksum is missing: the file is cut off, or another program has written it; "
                "run the scenario again"
            )
        dataset = _with_wheelset(dataset)
        if lacking := _lacking(dataset):
            raise InputError(f"{path}: says that it is a wrsim result, but {lacking}; run the scenario again")
        return cls(dataset)


def _opened(content: bytes) -> xr.Dataset | None:
    """The dataset in the bytes of a NetCDF file; None if they are damaged."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda unraisable: None  # the library complains when it lets go of a damaged file
    try:
        try:
            with xr.open_dataset(io.BytesIO(content), engine="h5netcdf", decode_times=False) as opened:
                return opened.load()
        except MemoryError:
            raise
        except Exception:  # the HDF5 stack answers damage with whatever comes to hand
            pass
        gc.collect()
        return None
    finally:
        sys.unraisablehook = hook


def _lacking(dataset: xr.Dataset) -> str:
    """What a dataset lacks of what every reader relies on, in words; empty if nothing."""
    for name in REQUIRED_ATTRIBUTES:
        if not isinstance(dataset.attrs.get(name), str):
            return f"has no {name}"
    for name, allowed in (("analysis", tuple(ANALYSES)), ("status", STATUSES)):
        if dataset.attrs[name] not in allowed:
            return f"its {name} is {dataset.attrs[name]!r:.40}, none of {', '.join(allowed)}"
    sample = "time" if "time" in dataset.dims else "pose"
    labels = [name for name in ("time", "wheel", *NAMED) if name in dataset.dims]
    needed = [*labels, "wheelset", *(("wheel", "distance") if sample == "time" else ())]
    for missing in (name for name in needed if name not in dataset.variables):
        return f"has no {missing}"
    for known, variable in dataset.variables.items():
        channel = CHANNELS.get(str(known))
        if channel is not None and variable.dims != channel.dims_in(sample):
            return f"its {known} is laid out along ({', '.join(map(str, variable.dims))})"
    return ""


def _without_encoding(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset without the traces of its file, so that it saves like a fresh one."""
    clean: xr.Dataset = dataset.drop_encoding()
    clean.attrs = {name: value.item() if hasattr(value, "item") else value for name, value in clean.attrs.items()}
    return clean


def _with_wheelset(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the dimension ``wheelset``, which a single wheelset did not have in format 1."""
    if "wheelset" not in dataset.dims:
        if "distance" in dataset.coords:
            dataset = dataset.assign(
                wheelset_distance=("time", dataset["distance"].values, _about("wheelset_distance"))
            )
        dataset = dataset.map(
            lambda v: v.expand_dims("wheelset", axis=1) if "wheelset" in CHANNELS[str(v.name)].dims else v,
            keep_attrs=True,
        ).assign_coords(wheelset=("wheelset", np.array([SINGLE]), _about("wheelset")))
    dataset.attrs["format_version"] = FORMAT_VERSION
    return dataset


def _about(name: str) -> dict[str, str]:
    """Attributes of a channel's variable."""
    return {"units": CHANNELS[name].unit, "long_name": CHANNELS[name].long_name}
