"""Makes flat.png, a flat at three speeds, and flat_spectra.png, on sleepers. Run: python docs/figures/make_flat.py"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from wrsim import load, run, spectra
from wrsim.plots import new_figure, save, style
from wrsim.plots.spectra import spectra_figure

HERE = Path(__file__).parent
FROM, TO = 0.4, 0.7  # along the track [m]


def draw() -> Figure:
    """The example at three speeds."""
    scenario = load(HERE.parents[1] / "scenarios/flat.toml")
    figure = new_figure(180, 75)
    axes = figure.subplots()
    for speed in (20, 60, 100):
        values = {"vehicle.speed_kmh": speed, "run.time_s": TO / (speed / 3.6)}
        data = run(scenario.with_values(values)).dataset
        axes.plot(data["time"] * speed / 3.6, 1e-3 * data["Q"].sel(wheel="left").values.ravel(), label=f"{speed} km/h")
    axes.set(xlabel="distance along the track, m", ylabel="Q of the left wheel, kN", xlim=(FROM, TO))
    axes.legend()
    return figure


def spectra_on_sleepers() -> Figure:
    """Five strikes of the flat on sleepers."""
    keys = {"run.distance_m": 14.0, "run.step_us": 100, "run.output_interval_ms": 5.0}
    fast = {"run.fast_channels": ["axle_box_acceleration"]}
    result = run(load(HERE.parents[1] / "scenarios/flat_on_sleepers.toml").with_values(keys | fast))
    return spectra_figure(spectra(result, "axle_box_acceleration").value)


def main() -> None:
    """Draw."""
    print(save(spectra_on_sleepers(), HERE / "flat_spectra.png"))
    with style():
        print(save(draw(), HERE / "flat.png"))


if __name__ == "__main__":
    main()
