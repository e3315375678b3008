"""What the user reads of stability and steady analyses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wrsim.results import Result


def print_stability(result: Result) -> None:
    """Critical speeds, the least damped mode at every speed, limit cycles."""
    from rich.console import Console
    from rich.table import Table

    dataset, summary = result.dataset, result.summary()
    console = Console(highlight=False)
    console.print(f"[bold]{result.title}[/bold]")
    speed = summary["linear_critical_speed_kmh"]
    if speed is not None:
        mode = f"{summary['critical_frequency_Hz']:.3f} Hz: {summary['critical_mode']}"
        console.print(f"linear critical speed {speed:.2f} km/h ({speed / 3.6:.2f} m/s), {mode}", soft_wrap=True)
    if "critical_note" in summary:
        console.print(summary["critical_note"], soft_wrap=True)
    speed = summary["nonlinear_critical_speed_kmh"]
    if speed is not None:
        console.print(f"nonlinear critical speed {speed:.2f} km/h ({speed / 3.6:.2f} m/s)")
    if "nonlinear_note" in summary:
        console.print(summary["nonlinear_note"], soft_wrap=True)
    table = Table(title="least damped mode", title_justify="left", box=None, pad_edge=False)
    for head in ("km/h", "Hz", "damping", "growth 1/s", "mode"):
        table.add_column(head, justify="left" if head == "mode" else "right")
    for i, v in enumerate(dataset["pose_speed"].values):
        growth = dataset["mode_growth"].values[i]
        if np.isfinite(growth).any():
            j = int(np.nanargmax(growth))
            cells = [dataset[f"mode_{name}"].values[i, j] for name in ("frequency", "damping", "growth")]
            table.add_row(f"{3.6 * v:.4g}", *(f"{c:z.3f}" for c in cells), str(dataset["mode_name"].values[i, j]))
    console.print(table)
    if "cycle" not in dataset.dims:
        return
    table = Table(title="held speeds", title_justify="left", box=None, pad_edge=False)
    for head in ("km/h", "branch", "came to", "amplitude mm", "Hz", "held s"):
        table.add_column(head, justify="left" if head in ("branch", "came to") else "right")
    for i in range(dataset.sizes["cycle"]):
        one = dataset.isel(cycle=i)
        frequency = one["cycle_frequency"].item()
        table.add_row(
            f"{3.6 * one['cycle_speed'].item():.5g}", one["cycle_branch"].item(), one["cycle_ending"].item(),
            f"{1e3 * one['cycle_amplitude'].values.max():.3f}",
            f"{frequency:.3f}" if np.isfinite(frequency) else "-", f"{one['cycle_time'].item():.1f}",
        )  # fmt: skip
    console.print(table)


def print_steady(result: Result) -> None:
    """One line a curve: the wheel with the largest Y/Q; curves without a steady motion with the reason."""
    from rich.console import Console
    from rich.table import Table

    dataset = result.dataset
    console = Console(highlight=False)
    console.print(f"[bold]{result.title}[/bold]")
    words = "the wheel with the largest Y/Q in every curve: R m, cant mm, shift mm, angle of attack mrad, forces kN, N"
    console.print(words, soft_wrap=True)
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    heads = ("R", "cant", "km/h", "wheel", "shift", "attack", "Y", "Q", "Y/Q", "Tγ")
    for head in heads:
        table.add_column(head, justify="left" if head == "wheel" else "right", no_wrap=True)
    quotient = dataset["Y_over_Q"].values
    for i in np.flatnonzero(dataset["pose_message"].values == ""):
        w, j = np.unravel_index(int(np.nanargmax(quotient[i])), quotient[i].shape)
        one = dataset.isel(pose=int(i), wheelset=int(w), wheel=int(j))
        table.add_row(
            f"{one['pose_radius'].item():.5g}", f"{1e3 * one['pose_cant'].item():.4g}",
            f"{3.6 * one['pose_speed'].item():.4g}", f"{one['wheelset'].item()} {one['wheel'].item()}",
            f"{1e3 * one['lateral_shift'].item():z.2f}", f"{1e3 * one['yaw'].item():z.2f}",
            f"{1e-3 * one['Y'].item():z.2f}", f"{1e-3 * one['Q'].item():z.2f}", f"{one['Y_over_Q'].item():z.3f}",
            f"{one['T_gamma'].item():z.0f}",
        )  # fmt: skip
    console.print(table)
    for name, message in zip(dataset["pose"].values, dataset["pose_message"].values, strict=True):
        if message:
            console.print(f"{name}: {message}", soft_wrap=True)
