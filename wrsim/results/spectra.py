"""Spectra of a channel: names of its parts, table and files. Made by ``wrsim.analysis.spectra``."""

from itertools import product

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS, SHOWN, Shown
from wrsim.results.ride import csv_files
from wrsim.results.table import Column, Table, quantity

ORDERS = ("", "rate of change of the ", "second derivative of the ")


def spectra_title(data: xr.Dataset) -> tuple[str, Shown]:
    """What the spectra are of, and its unit for readers."""
    channel, order = CHANNELS[data.attrs["channel"]], int(data.attrs["derivative"])
    title, unit = f"{ORDERS[order]}{channel.long_name}", str(data.attrs["unit"])
    derived = SHOWN.get(unit) or Shown(unit, unit.replace("/", "_").replace(" ", ""), 1.0)
    return title[:1].upper() + title[1:], derived if order else channel.shown


def parts_of_channel(data: xr.Dataset) -> dict[str, dict[str, int]]:
    """The wheels, points, ... that have spectra: their places in the dataset by their names."""
    sizes = {str(dim): size for dim, size in data["rms"].sizes.items()}
    cells = [dict(zip(sizes, cell, strict=True)) for cell in product(*map(range, sizes.values()))]
    dims = [dim for dim, size in sizes.items() if size > 1]
    return {
        " ".join(str(data[dim].values[cell[dim]]) for dim in dims) or str(data.attrs["channel"]): cell for cell in cells
    }


def spectra_table(data: xr.Dataset, run: str = "") -> Table:
    """A row for each wheel, point, ...: rms, the strongest line and third-octave. run: its name, where there are
    several."""
    title, shown = spectra_title(data)
    rows: list[tuple[object, ...]] = []
    for name, cell in parts_of_channel(data).items():
        spectra = data.isel(cell)
        line, band = (int(np.argmax(spectra[of].values)) for of in ("density", "band_rms"))
        of_band = (float(spectra["band"][band]), shown.factor * float(spectra["band_rms"][band]))
        rows.append((name, shown.factor * float(spectra["rms"]), float(spectra["frequency"][line]), *of_band))
    columns = (
        Column("of", key="of"), Column("rms", shown.unit, key=f"rms_{shown.suffix}"),
        Column("strongest line", "Hz", key="line_Hz"), Column("strongest third octave", "Hz", key="band_Hz"),
        Column("its rms", shown.unit, key=f"band_rms_{shown.suffix}"),
    )  # fmt: skip
    a = data.attrs
    stretch = f"{quantity(a['from_m'], 'm', '.1f')} to {quantity(a['to_m'], 'm', '.1f')}"
    lines = f"{a['segments']} segments, lines every {quantity(float(data['frequency'][1]), 'Hz', '.3g')}"
    note = f"{stretch}; {quantity(a['rate_Hz'], 'samples a second')}; {lines}"
    return Table(f"{run}: {title}" if run else title, columns, rows, (note,))


def spectra_files(data: xr.Dataset) -> dict[str, bytes]:
    """Contents of files by names, in SI units."""
    unit = str(data.attrs["unit"])
    name = f"_{data.attrs['channel']}" + ("", "_rate", "_second")[int(data.attrs["derivative"])]
    return csv_files(data, parts_of_channel(data), unit.replace("/", "_"), f"({unit})2_per_Hz", name)
