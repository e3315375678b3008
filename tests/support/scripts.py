"""Scripts of the repository as modules."""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[2]


def script(path: str) -> ModuleType:
    """A script, by its path in the repository; scripts of one folder find each other."""
    file = ROOT / path
    sys.path.insert(0, str(file.parent))
    try:
        return import_module(file.stem)
    finally:
        sys.path.remove(str(file.parent))
