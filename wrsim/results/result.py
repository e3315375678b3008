"""A Result: one labelled dataset, kept in one NetCDF file."""

from __future__ import annotations

import gc
import io
import os
import sys
import tempfile
import zlib
from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wrsim.errors import InputError
from wrsim.register import ANALYSES, resolved
from wrsim.results.channels import CHANNELS
from wrsim.results.dataset import FORMAT, FORMAT_VERSION, NAMED, REQUIRED_ATTRIBUTES, SINGLE, STATUSES
from wrsim.results.files import plain_disk_errors, write_atomically
from wrsim.results.room import LARGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SEALED_SINCE = 2
"""Format from which on every file ends with a checksum."""
_CHECKED = b"wrsim CRC-32"
"""Stands behind the HDF5 data, before the checksum of all that comes before; other readers do not look there."""
_NETCDF: dict[str, Any] = {"engine": "h5netcdf", "format": "NETCDF4"}
_PIECE = 1 << 20
"""Bytes of a file that are read at once."""


@dataclass(frozen=True, eq=False)
class Result:
    """What an analysis computed, with everything needed to redraw and to rerun it.

    A stopped run holds what was computed until it stopped. The numbers of a long run stay on disk
    (`wrsim.results.room`) and are read as they are asked for; ``dataset.load()`` brings them all into memory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Channels as variables with ``units`` (SI) and ``long_name``; scenario text, status and versions as attributes.

    Examples
    --------
    >>> from wrsim import Result
    >>> result = Result.load("results/curve_r300")
    >>> result.plot("Y", "Q").savefig("forces.png")
    >>> patch = result.patch(120.0, "right")
    >>> patch.s, patch.x, patch.p
    """

    dataset: xr.Dataset

    def __repr__(self) -> str:
        from wrsim.results.portrait import as_text

        return as_text(self.dataset)

    def _repr_html_(self) -> str:
        from wrsim.results.portrait import as_html

        return as_html(self.dataset)

    @property
    def title(self) -> str:
        """Title of the scenario."""
        return str(self.dataset.attrs["title"])

    @property
    def analysis(self) -> str:
        """Its kind, such as ``"static"``, ``"equilibrium"`` or ``"curving"``."""
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

        Parameters
        ----------
        name : str, optional
            Not needed where there is only one.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InputError
            For a wrong name, or when one is needed; says which there are.
        """
        from wrsim.results.wheelsets import of_wheelset

        return of_wheelset(self.dataset, name)

    def patch(
        self,
        at: str | float,
        wheel: str | None = None,
        *,
        wheelset: str | None = None,
        number: int = 0,
        columns: int = 101,
    ) -> xr.Dataset:
        """One contact patch as arrays.

        Parameters
        ----------
        at : float or str
            Distance along the track [m] of a moment whose patches are kept (the nearest within 1 m), or name of a pose.
        wheel : {"left", "right"}, optional
            Not needed where there is only one.
        wheelset : str, optional
            Not needed where there is only one.
        number : int
            Of the patch, 0 for the one with the largest normal force.
        columns : int
            Number of points along x; the exact solver's elements have columns of their own.

        Returns
        -------
        xarray.Dataset
            ``p`` (s, x): pressures [Pa], zero outside of contact; coordinates ``s`` (s,), curved axis from the main
            point to the field side [m], and ``x`` (x,), along the track [m]; with the exact solver ``qx`` and ``qs``,
            tractions [Pa]. The strips' own channels along ``s`` (``strip_ds``, ``strip_a``, ``strip_N`` ...), and the
            numbers of the patch (``N``, ``p0``, ``area``, ``contact_angle`` ...), all in SI units.

        Raises
        ------
        InputError
            For a wheelset, a wheel, a place, a pose or a patch that is not there; says which there are.
        """
        from wrsim.results.patch_field import patch_of

        return patch_of(self.wheelset(wheelset), at, wheel, number, columns)

    def to_dataframe(self, wheelset: str | None = None) -> DataFrame:
        """All channels over time or poses as one wide table, as ``wrsim export`` writes it.

        Parameters
        ----------
        wheelset : str, optional
            This one alone, its columns without its name. Default: all.

        Returns
        -------
        pandas.DataFrame
            A row an instant or pose, a column for every wheelset, wheel and patch, in units for readers, which stand
            at the end of the name (``Y_wheelset_left_kN``) and in ``attrs["units"]``.

        Raises
        ------
        InputError
            For a wheelset that is not there; says which there are.
        """
        from wrsim.results.columns import frame

        return frame(self.dataset if wheelset is None else self.wheelset(wheelset))

    def plot(self, *names: str, wheelset: str | None = None) -> Figure:
        """One of the standard pictures, or histories of channels.

        Parameters
        ----------
        *names : str
            One of ``pictures``; or channels (``"Y"``, ``"lateral_shift"``), drawn above each other over the distance,
            of poses over the lateral shift. Default: the first picture.
        wheelset : str, optional
            Needed for channels where there are several wheelsets.

        Returns
        -------
        matplotlib.figure.Figure
            Made without pyplot: ``savefig`` writes it, notebooks show it.

        Raises
        ------
        InputError
            For a name that is neither a picture nor a channel of this result, and for a wheelset that is not there.
        """
        figure: Figure = resolved("wrsim.plots.pictures:picture")(self, names, wheelset)
        return figure

    @property
    def pictures(self) -> tuple[str, ...]:
        """Names of the standard pictures, for `plot`."""
        return tuple(resolved("wrsim.plots.pictures:standard_figures")(self.dataset))

    def summary(self) -> dict[str, Any]:
        """Peak and quasi-static values as plain numbers in units for readers; what ``summary.json`` holds.

        Returns
        -------
        dict
            Units stand in the keys: ``summary["wheelsets"]["wheelset"]["wheels"]["left"]["Y_max_kN"]``.
        """
        from wrsim.results.summary import summarise

        return summarise(self.dataset)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF 4; the file appears whole or not at all.

        Parameters
        ----------
        path : str or Path
            An older file of that name is replaced.

        Returns
        -------
        Path

        Raises
        ------
        WrsimError
            When the disk is full or the place cannot be written to.
        """
        ordered = _labels_first(self.dataset)
        if self.dataset.nbytes <= LARGE:
            return write_atomically(path, b"".join(_sealed((_as_file(ordered),))))
        path = Path(path)
        with plain_disk_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(prefix=f".{path.name}.", suffix=".part", dir=path.parent) as stream:
                _write_in_groups(ordered, stream.name)
                return write_atomically(path, _sealed(iter(lambda: stream.read(_PIECE), b"")))

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a file that `save` wrote, or the result in the folder of a run.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Result

        Raises
        ------
        InputError
            When it is missing, damaged or not ours.
        """
        path = Path(path)
        if path.is_dir():
            path = path / "result.nc"
        try:
            with open(path, "rb") as stream:
                begin, sealed, whole = _looked_through(stream)
        except FileNotFoundError:
            raise InputError(f"{path}: there is no such result file") from None
        except OSError as problem:
            why = (problem.strerror or str(problem)).lower()
            raise InputError(f"{path}: cannot be read: {why}") from problem
        if begin != _HDF5_SIGNATURE:
            raise InputError(f"{path}: not a wrsim result (not a NetCDF 4 file)")
        opened = dataset_in(path, sealed) if whole or not sealed else None
        if opened is None:
            raise InputError(f"{path}: the file is damaged or incomplete; run the scenario again")
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
        dataset = _with_rails_of_moments(_with_wheelset(dataset))
        if lacking := _lacking(dataset):
            raise InputError(f"{path}: says that it is a wrsim result, but {lacking}; run the scenario again")
        return cls(dataset)


def _packed(dataset: xr.Dataset, among: Iterable[Hashable] | None = None) -> dict[Hashable, dict[str, Any]]:
    """How variables stand in a file: long ones packed. among: these alone."""
    return {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name in (dataset.variables if among is None else among)
        if dataset[name].dtype.kind in "fi" and dataset[name].size > 1000
    }


def _as_file(dataset: xr.Dataset) -> bytes:
    """The bytes that xarray's ``to_netcdf`` gives, without its look for a cluster, which loads dask.distributed."""
    content = io.BytesIO()
    store = xr.backends.H5NetCDFStore.open(content, mode="w", format="NETCDF4", lock=False)
    dataset.dump_to_store(store, encoding=_packed(dataset))
    store.close()
    return content.getvalue()


def _write_in_groups(dataset: xr.Dataset, path: str) -> None:
    """Write a file channel by channel, or some small ones at once: xarray takes into memory what it writes."""
    labels = dataset.drop_vars(dataset.data_vars)
    labels.to_netcdf(path, encoding=_packed(labels), **_NETCDF)
    group: list[Hashable] = []
    size = 0
    for name, variable in dataset.data_vars.items():
        if group and size + variable.nbytes > LARGE:
            dataset[group].to_netcdf(path, mode="a", encoding=_packed(dataset, group), **_NETCDF)
            group, size = [], 0
        group.append(name)
        size += variable.nbytes
    dataset[group].to_netcdf(path, mode="a", encoding=_packed(dataset, group), **_NETCDF)


def _sealed(content: Iterable[bytes]) -> Iterator[bytes]:
    """The parts of a file, and the seal behind them."""
    checksum = 0
    for part in chain(content, (_CHECKED,)):
        checksum = zlib.crc32(part, checksum)
        yield part
    yield checksum.to_bytes(4, "little")


def _looked_through(stream: IO[bytes]) -> tuple[bytes, bool, bool]:
    """First bytes of a file, whether it carries our seal, whether its checksum is right."""
    begin = stream.read(len(_HDF5_SIGNATURE))
    behind = stream.seek(0, os.SEEK_END) - 4
    stream.seek(max(behind - len(_CHECKED), 0))
    end = stream.read()
    stream.seek(0)
    checksum, left = 0, behind
    while left > 0 and (part := stream.read(min(left, _PIECE))):
        checksum, left = zlib.crc32(part, checksum), left - len(part)
    return begin, end[:-4] == _CHECKED, end[-4:] == checksum.to_bytes(4, "little")


def dataset_in(path: Path, sealed: bool = False) -> xr.Dataset | None:
    """The dataset in a NetCDF file; None if it is damaged. sealed: its checksum is right: many numbers stay in the file
    until they are asked for."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda unraisable: None  # the library complains when it lets go of a damaged file
    try:
        try:
            opened = xr.open_dataset(path, engine="h5netcdf", decode_times=False, cache=False)
            if sealed and opened.nbytes > LARGE:
                return opened
            with opened:
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


def _labels_first(dataset: xr.Dataset) -> xr.Dataset:
    """The same dataset, coordinates first: with every label that h5netcdf meets it ties all variables before it anew,
    a third of the time that the file of a short run takes."""
    coords = {name: dataset[name].variable for name in sorted(map(str, dataset.coords))}
    bare = xr.Dataset(coords=coords, attrs=dataset.attrs)
    return bare.assign({name: dataset[name].variable for name in dataset.data_vars})


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


def _with_rails_of_moments(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the rails' sections of every moment, of which formats 1 and 2 kept one for all."""
    moments = dataset["wheel_profile_y"].sizes if "wheel_profile_y" in dataset else {}
    for name in ("rail_profile_y", "rail_profile_z"):
        if name in dataset and dataset[name].dims == ("wheel", "rail_point"):
            if not moments:
                dataset = dataset.drop_vars(name)
                continue
            own = dataset[name]
            own = own.expand_dims({dim: size for dim, size in moments.items() if dim not in ("wheel", "wheel_point")})
            dataset[name] = own.copy()
    return dataset


def _about(name: str) -> dict[str, str]:
    """Attributes of a channel's variable."""
    return {"units": CHANNELS[name].unit, "long_name": CHANNELS[name].long_name}
