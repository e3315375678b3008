"""Makes friction_loops.png: the loops of the three friction laws. Run: python docs/figures/make_friction.py"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from wrsim.plots import new_figure, save, style
from wrsim.vehicle.dynamics.friction import BERG, COULOMB, FANCHER, slider_force
from wrsim.vehicle.dynamics.suspension import ELEMENT

HERE = Path(__file__).parent
LIMIT, DISTANCE = 3e3, 2e-3
LAWS = (("friction element", COULOMB), ("leaf spring (Fancher)", FANCHER), ("rubber, air spring (Berg)", BERG))


def loop(law: int, amplitude: float, loops: int = 4, steps: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Travel [m] and force [N] of the last of some loops."""
    element = np.zeros(1, ELEMENT)[0]
    element.slider, element.stick, element.bound = law, LIMIT / DISTANCE, LIMIT
    times = np.linspace(0.0, loops, loops * steps + 1)
    travel = amplitude * np.sin(2.0 * np.pi * times)
    rate = 2.0 * np.pi * amplitude * np.cos(2.0 * np.pi * times)
    inner, inner_t, force = np.zeros(3), np.zeros(3), np.zeros(len(times))
    for i in range(len(times)):
        force[i] = slider_force(element, LIMIT, travel[i], rate[i], inner, inner_t)
        inner += inner_t / steps
    return travel[-steps - 1 :], force[-steps - 1 :]


def draw() -> Figure:
    """A panel for each law, loops of three amplitudes."""
    figure = new_figure(180, 70)
    axes = figure.subplots(1, 3, sharey=True)
    for ax, (name, law) in zip(axes, LAWS, strict=True):
        for amplitude in (1e-3, 3e-3, 10e-3):
            travel, force = loop(law, amplitude)
            ax.plot(1e3 * travel, 1e-3 * force)
        ax.set_title(name)
        ax.set_xlabel("travel, mm")
    axes[0].set_ylabel("friction, kN")
    return figure


def main() -> None:
    """Draw."""
    with style():
        print(save(draw(), HERE / "friction_loops.png"))


if __name__ == "__main__":
    main()
