"""A result in files: numbers and tables of a run, and what other programs read: MATLAB, CSV, Parquet, MDF.

MATLAB gets every channel with its dimensions, in SI units. The others get one wide table: a row a sample (instant or
pose), a column for every channel of every wheelset, wheel, patch, body, point, ..., in units for readers.
"""

import io
import logging
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest
from wrsim.results.files import as_json, csv_parts, plain_disk_errors, safe_cell, write_atomically
from wrsim.results.result import Result
from wrsim.results.tables import columns, each_table, frame

FORMATS = ("mat", "csv", "parquet", "mdf", "tables")
ENDINGS = {"mdf": "mf4"}
EXTRA = "install it with pip install 'wrsim[export]'"
LONGEST_NAME = 63  # letters of a MATLAB name
LARGEST = 20_000_000  # bytes of a dataset, and about those of its tables, beyond which these are written on request
LOGGER = logging.getLogger(__name__)


def write_run(result: Result, directory: str | Path, summary: dict[str, Any] | None = None) -> list[Path]:
    """Write ``result.nc``, ``summary.json`` and the tables into ``directory``; returns what was written.

    summary: that of the result, where it is known.

    Runs get ``history.csv`` (a row an instant), ``patches.csv`` (a row an instant, wheel and patch in contact) and
    ``strips.csv`` (of the snapshots); poses the last two, where a wheel without contact keeps a row. Each of several
    wheelsets has a folder, such as ``wheelset_1``; bodies, points and suspension elements are in ``vehicle.csv``. The
    dataset goes first, so that a full disk costs the tables before the numbers. Tables of more than ``LARGEST`` bytes
    are not written, which is logged. Raises ``WrsimError``.
    """
    directory = Path(directory)
    written = [result.save(directory / "result.nc")]
    written.append(write_atomically(directory / "summary.json", as_json(summary or result.summary())))
    if result.dataset.nbytes > LARGEST:
        size = f"{1e-6 * result.dataset.nbytes:.0f} MB"
        LOGGER.warning("CSV tables (%s) not written; to write them: wrsim export %s --to tables", size, written[0])
        return written
    return written + _tables(result, directory)


def _tables(result: Result, directory: Path) -> list[Path]:
    return [write_atomically(directory / f"{name}.csv", csv_parts(rows)) for name, rows in each_table(result.dataset)]


def formats(text: str) -> list[str]:
    """Formats of a list with commas between. Raises ``InputError``."""
    names = list(dict.fromkeys(name.strip().lower() for name in text.split(",") if name.strip()))
    for name in names:
        if name not in FORMATS:
            raise InputError(f"--to {text}: '{name}' is none of {', '.join(FORMATS)}{suggest(name, FORMATS)}")
    if not names:
        raise InputError(f"--to {text}: must be one or more of {', '.join(FORMATS)}, with commas between")
    return names


def export_result(result: Result, format: str, directory: Path) -> list[Path]:
    """Write a result in one of ``FORMATS`` as ``result.mat`` and so on; "tables": those of `write_run`.

    Raises ``InputError`` where a library is missing, or MDF has no time.
    """
    if format == "tables":
        return _tables(result, directory)
    content = {"mat": _mat, "csv": _csv, "parquet": _parquet, "mdf": _mdf}[format](result)
    return [write_atomically(directory / f"result.{ENDINGS.get(format, format)}", content)]


def _csv(result: Result) -> bytes:
    table = frame(result.dataset)
    for name, channel, values in columns(result.dataset):
        if channel.kind == "text":
            table[name] = [safe_cell(str(value)) for value in values]
    return table.to_csv(index=False, float_format="%.10g", lineterminator="\n").encode()


def _parquet(result: Result) -> bytes:
    named = columns(result.dataset)
    table = ((n, values, {"unit": c.shown.symbol, "long_name": c.long_name}) for n, c, values in named)
    return parquet_table("--to parquet", table, {key: str(value) for key, value in result.dataset.attrs.items()})


def parquet_table(
    command: str, table: Iterable[tuple[str, NDArray[Any], dict[str, str]]], about: Mapping[str, str | bytes]
) -> bytes:
    """A table as Parquet: names, values and metadata of its columns, metadata of all. Raises ``InputError`` that names
    the command where the library is missing."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as parquet
    except ImportError:
        raise InputError(f"{command} needs pyarrow: {EXTRA}") from None
    arrays, fields = [], []
    for name, values, metadata in table:
        arrays.append(pa.array(values))
        fields.append(pa.field(name, arrays[-1].type, metadata=metadata))
    schema = pa.schema(fields, metadata=about)
    stream = io.BytesIO()
    parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), stream)
    return stream.getvalue()


def _mat(result: Result) -> bytes:
    from scipy.io import savemat

    dataset = result.dataset
    variables = {str(name)[:LONGEST_NAME]: variable for name, variable in dataset.variables.items()}
    content = {
        "channels": {n: v.values.astype(object) if v.dtype.kind in "UO" else v.values for n, v in variables.items()},
        "units": {n: str(v.attrs.get("units", "")) for n, v in variables.items()},
        "dimensions": {n: np.array(v.dims, dtype=object) for n, v in variables.items()},
        "about": {str(key)[:LONGEST_NAME]: value for key, value in dataset.attrs.items()},
    }
    stream = io.BytesIO()
    savemat(stream, content, long_field_names=True, do_compression=True, oned_as="column")
    return stream.getvalue()


def _mdf(result: Result) -> bytes:
    if "time" not in result.dataset.dims:
        raise InputError(
            f'--to mdf: MDF keeps signals over time; analysis = "{result.analysis}" has none: take mat or csv'
        )
    try:
        from asammdf import MDF, Signal
    except ImportError:
        raise InputError(f"--to mdf needs asammdf: {EXTRA}") from None
    time = result.dataset["time"].values
    signals = [
        Signal(np.ascontiguousarray(values), time, unit=channel.shown.symbol, name=name, comment=channel.long_name)
        for name, channel, values in columns(result.dataset)
        if channel.kind != "text" and name != "time_s"
    ]
    with tempfile.TemporaryDirectory() as folder, MDF(version="4.10") as file:
        file.append(signals, comment=result.title, common_timebase=True)
        path = Path(file.save(Path(folder) / "result.mf4", overwrite=True, compression=2))
        with plain_disk_errors(path):
            return path.read_bytes()
