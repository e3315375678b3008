"""Results: one labelled dataset per analysis, its file, its tables, its summary.

The pipeline in one line: ``write_run(Result(assemble(coords, channels, attributes)), directory)``. What is here is
imported on first use: most commands need no dataset.
"""

from typing import TYPE_CHECKING

from wrsim.inputs.lazy import importer

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
__getattr__ = importer(__name__, {name: f"{__name__}.{module}" for name, module in _HOMES.items()})
