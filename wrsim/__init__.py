"""wrsim: railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.

::

    from wrsim import load, run

    result = run(load("scenarios/curve_r300.toml"))
    result.plot("Y", "Q").savefig("forces.png")
    result.save("curve_r300.nc")

docs/user/python.md lists what is here; ``__init__.pyi`` has the public names, for type checkers and editors as well.
"""

from importlib import import_module as _import_module
from pathlib import Path as _Path
from re import MULTILINE as _MULTILINE
from re import findall as _findall
from typing import Any as _Any

__version__ = "0.1.0"

_STUB = _Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOMES = {name: home for home, name in _findall(r"^from (\S+) import (\w+) as", _STUB, _MULTILINE)}
"""Public names and their modules, from the stub; imported on first use: ``import wrsim`` alone costs nothing."""

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> _Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'wrsim' has no attribute '{name}'")
    value = getattr(_import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
