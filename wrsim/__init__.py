"""wrsim: railway vehicles and wheelsets on curved track, with conformal wheel-rail contact.

::

    from wrsim import load, run

    result = run(load("scenarios/curve_r300.toml"))
    result.plot("Y", "Q").savefig("forces.png")
    result.save("curve_r300.nc")

docs/user/python.md lists what is here; ``__init__.pyi`` has the public names, for type checkers and editors as well.
"""

from wrsim.inputs.lazy import homes_in as _homes_in
from wrsim.inputs.lazy import importer as _importer

__version__ = "0.2.0"

_HOMES = _homes_in(__file__)
__all__ = ["__version__", *_HOMES]
__getattr__ = _importer(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
