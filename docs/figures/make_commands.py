"""Makes the pictures that commands of wrsim draw. Run: python docs/figures/make_commands.py [PICTURE ...]

Without names all of them, some minutes: those of stability and of a wheel profile evolution take most.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
PROFILES = "wheels/S1002.toml rails/60E1.toml"
PAIR = "half-space,file,strips+approach=+strip_width_mm=,hertz"
COMMANDS = {
    "manchester_1.svg": "vehicle vehicles/manchester_1.toml -o manchester_1.svg",
    "freight_y25.svg": "vehicle vehicles/freight_y25.toml -o freight_y25.svg",
    "three_piece.svg": "vehicle vehicles/three_piece_100t.toml -o three_piece.svg",
    "stationary.png": "vehicle vehicles/freight_y25.toml --twist-test --rotation-test --loops stationary.png",
    "conicity_map.png": f"conicity {PROFILES} --gauges-mm 1430 1440 1 -o map",
    "crh380a_bifurcation.png": "run scenarios/stability_crh380a.toml -o crh380a",
    "project_metro.png": "run scenarios/metro_depot.toml -o metro",
    "project_freight.png": "run scenarios/freight_long_curve.toml -o freight",
    "project_worn.png": "conicity scenarios/measured/wheel.whl scenarios/measured/rail.toml -o scan",
    "project_pair.png": f"compare scenarios/static_paper.toml --contact {PAIR} -o pair",
    "service_mileage.png": "wear scenarios/wear/service.toml -o service",
    "service_profiles.png": "wear scenarios/wear/service.toml -o service",
}
WRITTEN = {
    "project_metro.png": "metro/vehicle_guiding.png",
    "project_freight.png": "freight/vehicle_shifting.png",
    "project_worn.png": "scan/conicity.png",
    "project_pair.png": "pair/compare_patches.png",
    "conicity_map.png": "map/conicity_map.png",
    "crh380a_bifurcation.png": "crh380a/bifurcation.png",
    "service_mileage.png": "service/wear_mileage.png",
    "service_profiles.png": "service/wear_profiles.png",
}
"""Where a command puts a picture that has another name there."""


def main(names: list[str]) -> None:
    """Call the commands and copy their pictures."""
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "scenarios").symlink_to(ROOT / "scenarios")
        for name in names or COMMANDS:
            written = Path(scratch) / WRITTEN.get(name, name)
            if not written.exists():
                command = [sys.executable, "-m", "wrsim", *COMMANDS[name].split()]
                subprocess.run(command, cwd=scratch, check=True, stdout=subprocess.DEVNULL)
            print(shutil.copy(written, HERE / name))


if __name__ == "__main__":
    main(sys.argv[1:])
