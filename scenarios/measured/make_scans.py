"""Makes the scans in this folder: the synthetic worn pair as a device would measure it. Run it from anywhere.

Points 0.11 mm apart with 10 um of independent noise in both coordinates, written to 0.1 um.
"""

from pathlib import Path

import numpy as np

from wrsim.contact.profiles.models import load_profile

HERE = Path(__file__).parent
NOISE = 10e-6
NOTE = "SYNTHETIC scan of models/{}: 10 um of noise at points 0.11 mm apart, made by make_scans.py"


def points(model: str, seed: int) -> str:
    """Rows of u and height in mm."""
    rows, _ = load_profile(HERE.parents[1] / "models" / model).table(1.1e-4)
    scan = 1e3 * (rows[:, :2] + NOISE * np.random.default_rng(seed).normal(size=(len(rows), 2)))
    return "".join(f"{u:.4f}\t{w:.4f}\n" for u, w in scan)


def main() -> None:
    """Write both files."""
    wheel = points("wheels/S1002_worn.toml", 1)
    head = f"# {NOTE.format('wheels/S1002_worn.toml')}\nProgramName=MiniProf\n"
    head += f"XYPoints={wheel.count(chr(10))}\nColumnDef=X,Y\n\n"
    (HERE / "wheel.whl").write_text(head + wheel, encoding="utf-8")
    rail = points("rails/60E1_worn.toml", 2)
    (HERE / "rail.csv").write_text(f"# {NOTE.format('rails/60E1_worn.toml')}\n{rail}", encoding="utf-8")


if __name__ == "__main__":
    main()
