"""Makes wear.png and fatigue.png from scenarios/curve_r150_sharp.toml. Run: python docs/figures/make_wear.py"""

from __future__ import annotations

from pathlib import Path

from wrsim import load, run
from wrsim.plots import save
from wrsim.plots.pictures import standard_figures

HERE = Path(__file__).parent


def main() -> None:
    """Run the scenario and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "curve_r150_sharp.toml")
    dataset = run(scenario.with_values({"wear.laws": ["usfd", "archard", "brr"]})).dataset
    for name in ("wear", "fatigue"):
        print(save(standard_figures(dataset)[name](), HERE / f"{name}.png"))


if __name__ == "__main__":
    main()
