"""The picture of a channel's spectra: power spectral density, third-octaves, and a spectrogram over the distance."""

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels, remark
from wrsim.plots.ride import frequency_ticks, over_frequency
from wrsim.plots.theme import pressure_map
from wrsim.results.spectra import parts_of_channel, spectra_title

SPAN = 60.0  # dB below the largest value that colours of a spectrogram tell apart


def spectra_figure(data: xr.Dataset) -> Figure:
    """All parts over the frequency, and the one with the largest rms over frequency and distance."""
    title = f"{data.attrs['title']}\n{spectra_title(data)[0]}"
    across = {"density": ("frequency", 2, 6.0, 0.0), "band_rms": ("band", 1, 4.0, 2.4)}
    draws = [partial(_over_frequency, data=data, name=name, look=look) for name, look in across.items()]
    return panels(title, [*draws, partial(_over_distance, data=data)], 190.0, share=False, legend=None, across=4)


def _over_frequency(axes: Axes, data: xr.Dataset, name: str, look: tuple[str, int, float, float]) -> None:
    across, power, decades, markersize = look
    shown = spectra_title(data)[1]
    values = {
        part: (data[across].values, shown.factor**power * data[name].isel(index).values)
        for part, index in parts_of_channel(data).items()
    }
    over_frequency(axes, values, float(data["frequency"][1]), decades, markersize)
    unit = shown.symbol
    axes.set_ylabel(f"Density\n[({unit})²/Hz]" if power == 2 else f"rms [{unit}]\nin 1/3 octave")
    frequency_ticks(axes)


def _over_distance(axes: Axes, data: xr.Dataset) -> None:
    parts, (_, shown) = parts_of_channel(data), spectra_title(data)
    part = max(parts, key=lambda name: float(data["rms"].isel(parts[name])))
    values = shown.factor**2 * data["spectrogram"].isel(parts[part]).transpose("line", "place").values
    level = 10.0 * np.log10(np.maximum(values, 1e-300))
    place, top = data["place"].values, float(level[1:].max(initial=-300.0))
    mesh = axes.pcolormesh(
        place, data["line"].values[1:], level[1:], cmap=pressure_map(), vmin=top - SPAN, vmax=top, shading="nearest",
        rasterized=True,
    )  # fmt: skip
    axes.set(xlabel="Distance along the track [m]", yscale="log")
    axes.grid(False)
    frequency_ticks(axes, upright=True)
    axes.figure.colorbar(mesh, ax=axes, label=f"dB of 1 ({shown.symbol})²/Hz", pad=0.01)
    remark(axes, f"{part}: density over the distance")
