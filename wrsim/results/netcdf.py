"""NetCDF files with a checksum of every byte behind the HDF5 data, where other readers do not look.

Nothing is read from a file whose checksum is missing or wrong: the library can hang on damage. Many numbers stay in
their file until they are used, so the memory that a run needs does not grow with its length.
"""

from __future__ import annotations

import errno
import gc
import math
import os
import shutil
import sys
import tempfile
import weakref
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.conventions import encode_dataset_coordinates

from wrsim.errors import InputError
from wrsim.inputs.checking import kind_of
from wrsim.inputs.toml_files import open_plain
from wrsim.results.channels import CHANNELS
from wrsim.results.files import EVOLUTION, LARGE, STUDY, plain_disk_errors, write_atomically

if TYPE_CHECKING:
    import netCDF4

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_CHECKED = b"wrsim CRC-32"  # bytes before the checksum of all that comes before
_PIECE = 1 << 20  # bytes of a file that are read at once
CHUNK = 1 << 18
"""Bytes of a variable that are packed together. The library holds as many of every variable of an open file."""
PART = 16 * CHUNK  # bytes of a variable that are in memory at once while all of it is read or written
PACKED = 250
"""Largest ratio of a dataset to its file. Runs have 2, with four wheelsets at rest 150; files made to harm 1030."""


def write_netcdf(path: str | Path, dataset: xr.Dataset) -> Path:
    """Write a dataset as NetCDF 4, whole or not at all. Raises WrsimError: full disk, place without access."""
    import netCDF4

    path = Path(path)
    with plain_disk_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = _scratch_file(path.parent, path.name)
        try:
            try:
                with _one_chunk_each(), netCDF4.Dataset(scratch, "w", format="NETCDF4") as file:
                    _fill(file, dataset)
            except (RuntimeError, OSError) as problem:  # netCDF-C reports "HDF error" or no access, whatever it was
                full = shutil.disk_usage(path.parent).free < LARGE
                raise OSError(errno.ENOSPC if full else errno.EIO, str(problem)) from problem
            with open(scratch, "rb") as stream:
                size = os.fstat(stream.fileno()).st_size
                return write_atomically(path, _with_checksum(iter(lambda: stream.read(_PIECE), b"")), size)
        finally:
            scratch.unlink(missing_ok=True)


def _scratch_file(folder: Path, name: str) -> Path:
    """An empty file beside one of that name, which its maker removes."""
    handle, scratch = tempfile.mkstemp(prefix=f".{name}.", suffix=".part", dir=folder)
    os.close(handle)
    return Path(scratch)


def _remove(file: netCDF4.Dataset, path: Path) -> None:
    """Close a scratch file and remove it, if it is there yet."""
    if file.isopen():
        file.close()
    path.unlink(missing_ok=True)


def read_netcdf(path: Path, label: str) -> xr.Dataset:
    """The dataset in a file of `write_netcdf`; label: kind. Raises InputError: missing, damaged, none of wrsim's."""
    again = f"run the {'scenario' if label == 'result' else label} again"
    try:
        with open(open_plain(path, f"{label} file"), "rb") as stream:
            begin, checked, whole = _looked_through(stream)
    except FileNotFoundError:
        kinds = {STUDY: "study", EVOLUTION: "profile evolution"}
        kind = next((kind_of_file for name, kind_of_file in kinds.items() if (path.parent / name).is_file()), "")
        hint = f"; the folder is that of a {kind} (wrsim report)" if kind else ""
        raise InputError(f"{path}: there is no such {label} file{hint}") from None
    except OSError as problem:
        why = (problem.strerror or str(problem)).lower()
        raise InputError(f"{path}: cannot be read: {why}") from problem
    if begin != _HDF5_SIGNATURE:
        kind = "" if path.suffix == ".nc" else kind_of(path)
        raise InputError(f"{path}: not a wrsim {label}{f', but {kind}' if kind else ' (not a NetCDF 4 file)'}")
    if not checked:
        why = "its checksum is missing: it is cut off, or another program has written it"
        raise InputError(f"{path}: not a wrsim {label}, or {why}; {again}")
    opened = _dataset_in(path, label) if whole else None
    if opened is None:
        raise InputError(f"{path}: the file is damaged or incomplete; {again}")
    return opened


class _Scratch(xr.backends.NetCDF4DataStore):
    """A scratch file that is read; unlike its base it can have weak references."""


class Channels:
    """Channels of up to n samples of a run, filled block by block; many are in a file of ``folder``, if any."""

    def __init__(self, n: int, folder: Path | None) -> None:
        self.n, self.folder = n, folder
        self._arrays: dict[str, Any] = {}
        self._file: netCDF4.Dataset | None = None

    def put(self, block: slice, values: Mapping[str, NDArray[Any]]) -> None:
        """Channels of the samples of a block; the first one determines which channels there are."""
        if not self._arrays:
            self._make({name: ((self.n, *array.shape[1:]), array.dtype) for name, array in values.items()})
        for name, array in values.items():
            self._arrays[name][block] = array

    def _make(self, layout: Mapping[str, tuple[tuple[int, ...], np.dtype[Any]]]) -> None:
        size = sum(kind.itemsize * int(np.prod(shape)) for shape, kind in layout.values())
        folder = self.folder
        if folder is None or size <= LARGE or not os.access(folder, os.W_OK) or shutil.disk_usage(folder).free < size:
            self._arrays = {name: np.zeros(shape, kind) for name, (shape, kind) in layout.items()}
            return
        import netCDF4

        self._scratch = _scratch_file(folder, "result.nc")
        self._file = netCDF4.Dataset(self._scratch, "w")
        self._removal = weakref.finalize(self, _remove, self._file, self._scratch)
        self._file.set_fill_off()
        for name, (shape, kind) in layout.items():
            dims = CHANNELS[name].dims_in("time")
            for dim, count in zip(dims, shape, strict=True):
                if dim not in self._file.dimensions:
                    self._file.createDimension(dim, count)
            self._arrays[name] = target = self._file.createVariable(name, kind, dims)
            target.setncatts(CHANNELS[name].attributes)
            target.set_auto_maskandscale(False)

    def filled(self, n: int) -> dict[str, Any]:
        """Channels of the first n samples: arrays, or variables of a file whose name is gone, so that it goes with this
        process; on Windows with the last variable."""
        if self._file is None:
            return {name: array[:n] for name, array in self._arrays.items()}
        import netCDF4

        self._removal.detach()
        self._file.close()
        file = netCDF4.Dataset(self._scratch)
        store = _Scratch(file)
        weakref.finalize(store, _remove, file, self._scratch)
        if sys.platform != "win32":
            self._scratch.unlink()
        opened = xr.open_dataset(store, decode_cf=False, cache=False)
        return {str(name): variable[:n] for name, variable in opened.variables.items()}


def _fill(file: netCDF4.Dataset, dataset: xr.Dataset) -> None:
    """What xarray's ``to_netcdf`` writes, in a quarter of its time for few numbers: all variables are defined before
    the first gets its values. Long ones are packed; shuffling their bytes takes longer and more room here."""
    variables, attributes = encode_dataset_coordinates(dataset)  # attributes name the coordinates
    file.setncatts(attributes)
    for name, size in dataset.sizes.items():
        file.createDimension(str(name), size)
    made = []
    for name, variable in variables.items():
        kind, of_words = variable.dtype.kind, variable.dtype.kind not in "fiu"
        packed = not of_words and variable.size > 1000
        options: dict[str, Any] = {"fill_value": float("nan")} if kind == "f" and name not in dataset.dims else {}
        if packed:
            options |= {"zlib": True, "complevel": 1, "shuffle": False, "chunksizes": _chunk(variable)}
        target = file.createVariable(name, str if of_words else variable.dtype, variable.dims, **options)
        target.setncatts(variable.attrs)
        target.set_auto_maskandscale(False)
        made.append((target, variable, of_words))
    for target, variable, of_words in made:
        if not variable.ndim:
            target[...] = variable.values
        for begin, part in parts_of(variable):
            target[begin : begin + len(part)] = part.astype(object) if of_words else part


def parts_of(variable: Any) -> Iterator[tuple[int, NDArray[Any]]]:
    """The numbers of an array or a variable of a file, whole chunks along the first dimension at a time, each part with
    where it begins."""
    row = variable.dtype.itemsize * math.prod(variable.shape[1:])
    rows = PART // CHUNK * max(CHUNK // max(row, 1), 1)
    count = variable.shape[0] if variable.ndim else 0
    for begin in range(0, count, rows):
        yield begin, np.asarray(variable if count <= rows else variable[begin : begin + rows])


def _chunk(variable: xr.Variable) -> tuple[int, ...]:
    """Shape of what is packed together: some places along the first dimension, with all along the others."""
    rows = CHUNK * variable.shape[0] // (variable.size * variable.dtype.itemsize)
    return (min(max(rows, 1), variable.shape[0]), *variable.shape[1:])


@contextmanager
def _one_chunk_each() -> Iterator[None]:
    """While this lasts, files are opened that hold one chunk of every variable in memory, where the library holds up to
    64 MB of each: a run has some hundred variables."""
    import netCDF4

    before = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(CHUNK)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*before)


def _opened(path: Path) -> xr.Dataset:
    """The dataset in a file, which stays there. Files of older versions have larger chunks: one of each has to fit."""
    lazily: dict[str, Any] = {"engine": "netcdf4", "decode_times": False, "cache": False}
    with _one_chunk_each():
        opened = xr.open_dataset(path, **lazily)
    sizes = [v.dtype.itemsize * math.prod(v.encoding.get("chunksizes") or ()) for v in opened.variables.values()]
    if max(sizes, default=0) <= CHUNK:
        return opened
    opened.close()
    return xr.open_dataset(path, **lazily)


def _with_checksum(content: Iterable[bytes]) -> Iterator[bytes]:
    """The parts of a file, and the checksum behind them."""
    checksum = 0
    for part in chain(content, (_CHECKED,)):
        checksum = zlib.crc32(part, checksum)
        yield part
    yield checksum.to_bytes(4, "little")


def _looked_through(stream: IO[bytes]) -> tuple[bytes, bool, bool]:
    """First bytes of a file, whether it has a checksum, whether that is right."""
    begin = stream.read(len(_HDF5_SIGNATURE))
    behind = stream.seek(0, os.SEEK_END) - 4
    stream.seek(max(behind - len(_CHECKED), 0))
    end = stream.read()
    stream.seek(0)
    checksum, left = 0, behind
    while left > 0 and (part := stream.read(min(left, _PIECE))):
        checksum, left = zlib.crc32(part, checksum), left - len(part)
    return begin, end[:-4] == _CHECKED, end[-4:] == checksum.to_bytes(4, "little")


def _dataset_in(path: Path, label: str) -> xr.Dataset | None:
    """The dataset in a NetCDF file; None if it cannot be read. Raises InputError where it is packed too well."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda unraisable: None  # the library complains when it lets go of a damaged file
    try:
        try:
            opened = _opened(path)
            size = path.stat().st_size
            if opened.nbytes > max(LARGE, PACKED * size):
                opened.close()
                raise InputError(
                    f"{path}: declares {opened.nbytes / 1e6:.4g} MB of numbers in a file of {size / 1e6:.4g} MB; "
                    f"a wrsim {label} has at most {PACKED} times its size"
                )
            if opened.nbytes > LARGE:
                return opened
            with opened:
                return opened.load()
        except (MemoryError, InputError):
            raise
        except Exception:  # the HDF5 stack answers damage with whatever comes to hand
            pass
        gc.collect()
        return None
    finally:
        sys.unraisablehook = hook
