"""Files of results with odd content and a right checksum, as whoever sends a result may make them.

`numbers` changes the content of a ``result.nc``: attributes, labels, shapes, types, values. `part` changes the header
or a record of a ``result.nc.part``. `sealed_again` puts a right checksum under any bytes of either.
"""

import json
import random
import struct
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from wrsim.results.netcdf import _fill, write_netcdf
from wrsim.results.run_file import FRAME, SIGNATURE

SEAL = b"wrsim CRC-32"
ODD: tuple[Any, ...] = (
    None, True, -1,
    0, 3.5, 2**40, 2**70, 1e308, float("nan"), float("inf"), "", "x", "\0", "\x1b[31m\u202e", "9" * 5000,
    [], ["x"], [[]], {}, {"x": 1}, [None], "/dev/zero", "../..",
)  # fmt: skip
"""Values for whatever stands in a header."""
NUMBERS = (np.nan, np.inf, -np.inf, 1e300, -1e300, 5e-324, 0.0, -1.0)


def sealed_again(content: bytes) -> bytes:
    """The bytes of a file with a right checksum behind them."""
    body = content.removesuffix(content[-4:]).removesuffix(SEAL) + SEAL
    return body + zlib.crc32(body).to_bytes(4, "little")


# --- result.nc


def numbers(content: bytes, rng: random.Random) -> bytes:
    """A result with one change of its content, and a right checksum."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "crafted.nc"
        path.write_bytes(content)
        with xr.open_dataset(path, engine="netcdf4", decode_times=False) as opened:
            dataset = opened.load().drop_encoding()
        if rng.random() < 0.15:
            return _by_hand(dataset, Path(name) / "by_hand.nc", rng)
        while True:
            try:
                return write_netcdf(path, rng.choice(CHANGES)(dataset, rng)).read_bytes()
            except (
                IndexError,
                ValueError,
                TypeError,
                AttributeError,
            ):  # there is nothing of that kind, or no file takes it
                path.unlink(missing_ok=True)


def _variable(dataset: xr.Dataset, rng: random.Random, kinds: str = "fiuUO") -> str:
    """One that every reader uses, as often as not."""
    known = [
        n for n in ("time", "pose", "wheel", "wheelset", "distance", "Y", "Q", "N", "snapshot_time") if n in dataset
    ]
    names = known if rng.random() < 0.5 else [str(n) for n in dataset.variables]
    fit = [n for n in names if dataset[n].dtype.kind in kinds and dataset[n].size]
    return rng.choice(fit or [str(n) for n in dataset.variables if dataset[n].dtype.kind in kinds])


def _with(dataset: xr.Dataset, name: str, values: Any, dims: Any = None) -> xr.Dataset:
    """The dataset with other values of a variable, of whatever shape."""
    variable = dataset.variables[name]
    kept = dataset.drop_indexes([n for n in (name,) if n in dataset.indexes])
    return kept.assign({name: xr.Variable(variable.dims if dims is None else dims, values, variable.attrs)})


def _values(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng, "f")
    values = dataset[name].values.copy()
    if rng.random() < 0.5:
        values[...] = rng.choice(NUMBERS)
    else:
        values.reshape(-1)[rng.randrange(max(values.size, 1)) :] = rng.choice(NUMBERS)
    return _with(dataset, name, values)


def _counts(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng, "iu")
    return _with(dataset, name, np.full(dataset[name].shape, rng.choice((-1, -(2**40), 2**40, 7))))


def _type(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng)
    shape = dataset[name].shape
    made: Any = rng.choice(
        (np.zeros(shape, "i4"), np.zeros(shape, "f4"), np.full(shape, "x"), np.full(shape, "nan"), np.ones(shape, "u1"))
    )
    return _with(dataset, name, made)


def _texts(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng, "UO")
    text = rng.choice(("", "left", "x" * 100000, "\x1b[31m\u202e", "../../x", "=1+1", "</script><script>", "\n"))
    values = np.array(dataset[name].values, dtype=object)
    values[...] = text
    return _with(dataset, name, values)


def _order(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    dim = rng.choice([str(d) for d in dataset.sizes])
    return dataset.isel({dim: slice(None, None, -1)})


def _size(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    dim = rng.choice(
        [d for d in ("time", "pose", "wheel", "wheelset", "snapshot", "strip", "patch", "point") if d in dataset.sizes]
    )
    size = rng.choice((0, 1, 1, 2))
    return dataset.isel({dim: slice(0, size)})


def _without(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    return dataset.drop_vars(_variable(dataset, rng))


def _layout(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng)
    variable = dataset[name]
    if variable.ndim > 1 and rng.random() < 0.5:
        return _with(dataset, name, variable.values.T, variable.dims[::-1])
    dims = tuple(f"odd_{i}" for i in range(variable.ndim))
    return _with(dataset.drop_vars(name).assign({name: variable.variable}), name, variable.values, dims)


def _scalar(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    name = _variable(dataset, rng)
    return _with(dataset, name, rng.choice((np.float64(1.0), np.int64(3), np.array("x", dtype=object))), ())


def _another(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    """A variable that no channel knows, or a channel that belongs to other analyses."""
    name = rng.choice(
        ("odd", "odd name/with-\u00e4", "load", "mode_name", "growth_max", "cycle_speed", "pose", "amplitude")
    )
    name = name.replace("/", "|")
    return dataset.assign(
        {name: xr.Variable(("odd_dim",), rng.choice((np.arange(3.0), np.array(["a", "b", "c"], object))))}
    )


def _attribute(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    """Texts and numbers that say what the result is."""
    name = rng.choice(
        [*map(str, dataset.attrs), "stop_reason", "stop_cause", "stop_distance_m", "inputs", "curve_radii_m"]
    )
    if rng.random() < 0.2:
        return dataset.drop_attrs(deep=False).assign_attrs({k: v for k, v in dataset.attrs.items() if k != name})
    odd = [
        v for v in ODD if isinstance(v, str) or (isinstance(v, float | int) and not isinstance(v, bool) and v != 2**70)
    ]
    value = rng.choice(
        [v.replace("\0", "") if isinstance(v, str) else v for v in odd] + [np.arange(3.0), np.zeros(0), "[" * 5000]
    )
    return dataset.assign_attrs({name: value})


def _unit(dataset: xr.Dataset, rng: random.Random) -> xr.Dataset:
    """What stands on a variable besides its numbers, the conventions that libraries obey included."""
    name = _variable(dataset, rng)
    key = rng.choice(
        ("units", "long_name", "scale_factor", "add_offset", "_FillValue", "missing_value", "coordinates", "dtype")
    )
    value = rng.choice(("days since 2000-01-01", "", "x" * 10000, 3.5, float("nan"), 1e300, np.arange(2.0)))
    if key == "_FillValue":
        value = float("nan")
    changed = dataset.copy()
    changed[name].attrs = dict(changed[name].attrs) | {key: value}
    return changed


CHANGES: tuple[Callable[[xr.Dataset, random.Random], xr.Dataset], ...] = (
    _values, _values, _counts, _type, _type, _texts, _order, _size, _size, _without, _without, _layout, _scalar,
    _another, _attribute, _attribute, _unit,
)  # fmt: skip


def _by_hand(dataset: xr.Dataset, path: Path, rng: random.Random) -> bytes:
    """What no dataset of xarray holds: much room that is declared and never written, groups, further types."""
    with netCDF4.Dataset(path, "w") as file:
        _fill(file, dataset)
        action = rng.randrange(5)
        if action == 0:  # holes
            file.createDimension("hole", rng.choice((10**8, 4 * 10**8, 2**40)))
            file.createVariable("odd", "f8", ("hole",), zlib=True, chunksizes=(10**6,), fill_value=0.0)
        elif action == 1:
            file.createDimension("endless", None)
            file.createVariable("odd", "f8", ("endless",))[1000] = 1.0
        elif action == 2:
            file.createGroup("odd").createDimension("x", 3)
        elif action == 3:
            kind = file.createCompoundType(np.dtype([("a", "f8"), ("b", "i4")]), "pair")
            file.createVariable("odd", kind, (next(iter(dataset.sizes)),))
        else:
            kind = file.createEnumType(np.int8, "side", {"left": 0, "right": 1})
            file.createVariable("odd", kind, (next(iter(dataset.sizes)),))
    return sealed_again(path.read_bytes() + SEAL + bytes(4))


def declared(path: Path, samples: int) -> Path:
    """A small file of a run whose channels are declared for so many samples and mostly never written."""
    with netCDF4.Dataset(path, "w") as file:
        names = {
            "format": "wrsim result",
            "format_version": 3,
            "title": "x",
            "analysis": "curving",
            "status": "completed",
        }
        file.setncatts(names | {"scenario_text": ""})
        for dim, size in (("time", samples), ("wheelset", 1), ("wheel", 2), ("patch", 3)):
            file.createDimension(dim, size)
        for name, texts in (("wheelset", ["wheelset"]), ("wheel", ["left", "right"])):
            file.createVariable(name, str, (name,))[:] = np.array(texts, dtype=object)
        for name in ("time", "distance"):
            file.createVariable(name, "f8", ("time",), zlib=True, fill_value=0.0)
        for name in ("N", "p0", "area"):
            file.createVariable(name, "f8", ("time", "wheelset", "wheel", "patch"), zlib=True, fill_value=0.0)
    path.write_bytes(sealed_again(path.read_bytes() + SEAL + bytes(4)))
    return path


# --- result.nc.part


def records(content: bytes) -> list[tuple[bytes, bytes]]:
    """What all records of a run file say (JSON) and hold."""
    place, pairs = len(SIGNATURE), []
    while place + FRAME.size <= len(content):
        size, _ = FRAME.unpack_from(content, place)
        place += FRAME.size + size
        about, _, numbers = content[place - size : place].partition(b"\n")
        pairs.append((about, numbers))
    return pairs


def run_file(parts: list[tuple[bytes, bytes]]) -> bytes:
    """The file of these records, each with a right checksum."""
    contents = (about + b"\n" + numbers for about, numbers in parts)
    return SIGNATURE + b"".join(FRAME.pack(len(record), zlib.crc32(record)) + record for record in contents)


def part(content: bytes, rng: random.Random) -> bytes:
    """A run file with an odd header, or with an odd record; the checksums are right."""
    parts = records(content)
    if rng.random() < 0.5:
        parts[0] = _header(parts[0][0], rng), parts[0][1]
    else:
        index = rng.randrange(1, len(parts))
        parts[index] = _record(*parts[index], rng)
    return run_file(parts)


def _header(content: bytes, rng: random.Random) -> bytes:
    header = json.loads(content)
    action = rng.randrange(8)
    name = rng.choice(list(header))
    if action == 0:
        return rng.choice((b"", b"[]", b"3", b"null", b"\xff\xfe", b"[" * 100000, b'{"size": 1e999}', b"{", b'"x"'))
    if action == 1:
        del header[name]
    elif action == 2:
        inner = rng.choice(("files", "inputs"))
        header[inner] = {rng.choice(("x", "\0", "")): rng.choice(ODD)}
    elif action == 3:
        header["scenario_text"] = rng.choice(
            ("", "\0", "a = ", "x = 1", header["scenario_text"].replace("curving", "static"))
        )
    elif action == 4:
        header["size"] = rng.choice((0, -1, 1, 5, 2**31, 2**40, 2**62, 2**63, 2**70, 1e300, header["size"] + 6))
    else:
        header[name] = rng.choice(ODD)
    return json.dumps(header).encode()


def _record(about: bytes, numbers: bytes, rng: random.Random) -> tuple[bytes, bytes]:
    action = rng.randrange(7)
    known = json.loads(about)
    if action == 0:
        return about, numbers[: rng.randrange(len(numbers) + 1)]
    if action == 1:
        return rng.choice((b"", b"\0", b"\xff\0\xfe", b"x" * 24, b"null", b"[]", b"[" * 100000, b"{}")), numbers
    if action == 2:
        return about, rng.choice((b"", bytes(8), bytes(1000), bytes(1003)))
    if action in (3, 4):
        name = rng.choice(list(known))
        known[name] = rng.choice((-(2**63), -5, -1, 0, 1, 2**31, 2**40, 2**62, 2**63 - 1, *ODD))
        return json.dumps(known).encode(), numbers
    if "cause" in known:
        ends = (("magic", "why"), ("monitor", "\x1b[31m"), ("interrupt", ""), ("forces", "x" * 100000))
        return json.dumps(dict(zip(("cause", "reason"), rng.choice(ends), strict=True))).encode(), numbers
    data = bytearray(numbers)
    for _ in range(rng.choice((1, 3, 30))):
        if data:
            struct.pack_into("<d", data, 8 * rng.randrange(len(data) // 8), rng.choice((*NUMBERS, 2.0**40, 3.0)))
    return about, bytes(data)
