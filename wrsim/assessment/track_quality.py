"""How uneven the track of a run is, section by section: classes of UIC 518 and EN 14363:2016 by their tables.

Both take waves of 3 to 25 m, of each rail for itself. UIC 518, appendix D, has steps QN1 to QN3 by the standard
deviation and by the largest value; EN 14363, annex M, a band TL90 of the standard deviation in which the track of an
acceptance run should lie. The numbers come from a program that cites them [mem].
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from wrsim.assessment.outcome import AssessedSection, TrackQuality
from wrsim.results.filters import band_pass

WAVES = 3.0, 25.0  # wavelengths that count [m]
RASTER = 0.25  # distance of the places at which the track is looked at [m]
COARSEST = 1.0  # distance of samples [m] from which the shortest waves are lost
SHORTEST = 25.0  # length of a section [m] below which its deviation means nothing

QN_SPEEDS = 80.0, 120.0, 160.0, 200.0, 300.0
QN: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    "lateral": ((1.5, 1.8, 12, 14), (1.2, 1.5, 8, 10), (1.0, 1.3, 6, 8), (0.8, 1.1, 5, 7), (0.7, 1.0, 4, 6)),
    "vertical": ((2.3, 2.6, 12, 16), (1.8, 2.1, 8, 12), (1.4, 1.7, 6, 10), (1.2, 1.5, 5, 9), (1.0, 1.3, 4, 8)),
}
"""By steps of speed [km/h]: deviation of QN1 and QN2, largest value of QN1 and QN2 [mm]."""
QN3 = 1.3  # largest value of QN3 over that of QN2

TL90_SPEEDS = 120.0, 160.0, 200.0, 230.0, 300.0
TL90: dict[str, tuple[tuple[float, float], ...]] = {
    "lateral": ((1.05, 1.45), (0.75, 1.00), (0.70, 0.90), (0.65, 0.80), (0.50, 0.65)),
    "vertical": ((1.80, 2.50), (1.40, 1.85), (1.15, 1.60), (1.05, 1.45), (0.85, 1.10)),
}
"""By steps of speed [km/h]: lower and upper end of the band of the deviation [mm]."""


def track_quality(
    dataset: xr.Dataset, sections: Sequence[AssessedSection], notes: list[str]
) -> tuple[TrackQuality, ...]:
    """Unevenness of the sections of a run, where it has any: under its first wheelset, of the worse rail.

    Adds to ``notes`` why an uneven track is not assessed.
    """
    if "rail_lateral" not in dataset:
        return ()
    place = dataset["wheelset_distance"].transpose("time", ...).values.reshape(dataset.sizes["time"], -1)[:, 0]
    if (apart := float(np.diff(place).max())) > COARSEST:
        notes.append(f"track quality: the samples are {apart:.2f} m apart; waves of {WAVES[0]:g} m need {COARSEST:g} m")
        return ()
    raster = np.arange(place[0], place[-1], RASTER)
    waves = {}
    for direction in ("lateral", "vertical"):
        channel = dataset[f"rail_{direction}"].transpose("time", ..., "wheel").values
        rails = channel.reshape(len(place), -1, channel.shape[-1])[:, 0]
        signal = np.column_stack([np.interp(raster, place, rail) for rail in rails.T])
        waves[direction] = band_pass(signal, 1.0 / RASTER, 1.0 / WAVES[1], 1.0 / WAVES[0])
    qualities = []
    for section in sections:
        inside = (raster >= section.start) & (raster <= section.end)
        if inside.sum() * RASTER < SHORTEST:
            continue
        kmh = 3.6 * section.speed - 1e-6
        for direction, signal in waves.items():
            *usual, first, second = _row(QN[direction], QN_SPEEDS, kmh)
            low, high = _row(TL90[direction], TL90_SPEEDS, kmh)
            deviation, largest = float(signal[inside].std(axis=0).max()), float(np.abs(signal[inside]).max())
            mm = 1e3 * deviation
            steps = _step(mm, usual), _step(1e3 * largest, (first, second, QN3 * second))
            band = "below" if mm < low else "within" if mm <= high else "above"
            qualities.append(TrackQuality(section, direction, deviation, largest, *steps, band))
    return tuple(qualities)


def _row(table: Sequence[Sequence[float]], speeds: Sequence[float], kmh: float) -> tuple[float, ...]:
    """The row of a speed; above all steps the last one."""
    return tuple(table[min(int(np.searchsorted(speeds, kmh)), len(table) - 1)])


def _step(value: float, most: Sequence[float]) -> str:
    """The first step that holds a value."""
    return next((f"QN{i + 1}" for i, limit in enumerate(most) if value <= limit), f"above QN{len(most)}")
