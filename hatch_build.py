"""Takes compiled kernels into a wheel: those of the folder that WRSIM_KERNELS names (made by ``.ci/wheel``).

Such a wheel is for one minor version of Python and one platform, of this process or as the tag in WRSIM_TAG says.
Without kernels it is for all of them, and kernels are compiled where it is installed.
"""

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Kernels(BuildHookInterface):
    """Adds the folder and tells the wheel's tag."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """See hatchling."""
        if folder := os.environ.get("WRSIM_KERNELS"):
            build_data["force_include"][folder] = "wrsim/kernels"
            build_data["pure_python"] = False
            if tag := os.environ.get("WRSIM_TAG"):
                build_data["tag"] = tag
            else:
                build_data["infer_tag"] = True
