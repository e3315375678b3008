"""Results: one labelled dataset per analysis, its file, its tables, its summary.

The pipeline in one line: ``write_run(Result(assemble(coords, channels, attributes)), directory)``. What is here is
imported on first use: most commands need no dataset.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wrsim.results.channels import CHANNELS, Channel
    from wrsim.results.dataset import assemble, versions
    from wrsim.results.exports import write_run
    from wrsim.results.files import write_atomically
    from wrsim.results.result import Result
    from wrsim.results.summary import summarise

__all__ = ["CHANNELS", "Channel", "Result", "assemble", "summarise", "versions", "write_atomically", "write_run"]
_HOMES = {
    "CHANNELS": "channels", "Channel": "channels", "Result": "result", "assemble": "dataset", "summarise": "summary",
    "versions": "dataset", "write_atomically": "files", "write_run": "exports",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'wrsim.results' has no attribute '{name}'")
    return getattr(import_module(f"wrsim.results.{_HOMES[name]}"), name)
