"""What the user reads of stability and steady analyses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.cli.showing import print_table, print_title, say

if TYPE_CHECKING:
    from wrsim.results import Result


def print_stability(result: Result) -> None:
    """Critical speeds, the least damped mode at every speed, limit cycles."""
    dataset, summary = result.dataset, result.summary()
    print_title(result.title)
    speed = summary["linear_critical_speed_kmh"]
    if speed is not None:
        mode = f"{summary['critical_frequency_Hz']:.3f} Hz: {summary['critical_mode']}"
        say(f"linear critical speed {speed:.2f} km/h ({speed / 3.6:.2f} m/s), {mode}")
    if "critical_note" in summary:
        say(summary["critical_note"])
    speed = summary["nonlinear_critical_speed_kmh"]
    if speed is not None:
        say(f"nonlinear critical speed {speed:.2f} km/h ({speed / 3.6:.2f} m/s)")
    if "nonlinear_note" in summary:
        say(summary["nonlinear_note"])
    rows = []
    for one in np.flatnonzero(np.isfinite(dataset["mode_growth"].values).any(axis=1)):
        at = dataset.isel(pose=int(one), mode=int(np.nanargmax(dataset["mode_growth"].values[one])))
        cells = [f"{at[f'mode_{name}'].item():z.3f}" for name in ("frequency", "damping", "growth")]
        rows.append([f"{3.6 * at['pose_speed'].item():.4g}", *cells, at["mode_name"].item()])
    print_table(("km/h", "Hz", "damping", "growth 1/s", "mode"), rows, title="least damped mode", left=("mode",))
    if "cycle" not in dataset.dims:
        return
    rows = []
    for i in range(dataset.sizes["cycle"]):
        at = dataset.isel(cycle=i)
        frequency = at["cycle_frequency"].item()
        cells = [
            at["cycle_branch"].item(),
            at["cycle_ending"].item(),
            f"{1e3 * at['cycle_amplitude'].values.max():.3f}",
        ]
        cells += [f"{frequency:.3f}" if np.isfinite(frequency) else "-", f"{at['cycle_time'].item():.1f}"]
        rows.append([f"{3.6 * at['cycle_speed'].item():.5g}", *cells])
    heads = ("km/h", "branch", "came to", "amplitude mm", "Hz", "held s")
    print_table(heads, rows, title="held speeds", left=("branch", "came to"))


STEADY = {
    "pose_radius": ("R m", ".5g"),
    "pose_cant": ("cant mm", ".4g"),
    "pose_speed": ("km/h", ".4g"),
    "lateral_shift": ("shift mm", "z.2f"),
    "yaw": ("attack mrad", "z.2f"),
    "Y": ("Y kN", "z.2f"),
    "Q": ("Q kN", "z.2f"),
    "Y_over_Q": ("Y/Q", "z.3f"),
    "T_gamma": ("Tγ N", "z.0f"),
}
"""Channels in the table of steady motions, with headings and forms."""


def print_steady(result: Result) -> None:
    """One line a curve: the wheel with the largest Y/Q; curves without a steady motion with the reason."""
    from wrsim.results import CHANNELS

    dataset = result.dataset
    print_title(result.title)
    rows = []
    for i in np.flatnonzero(dataset["pose_message"].values == ""):
        quotient = dataset["Y_over_Q"].isel(pose=int(i))
        at = dataset.isel(pose=int(i)).isel(quotient.argmax(dim=quotient.dims))  # type: ignore[arg-type]
        cells = [f"{at[n].item() * CHANNELS[n].shown.factor:{form}}" for n, (_, form) in STEADY.items()]
        rows.append([f"{at['wheelset'].item()} {at['wheel'].item()}", *cells])
    heads = ["largest Y/Q on", *(head for head, _ in STEADY.values())]
    print_table(heads, rows, left=heads[:1])
    for name, message in result.summary()["without_steady_motion"].items():
        say(f"{name}: {message}")
