"""Results: one labelled dataset per analysis, its file, its tables, its summary.

The pipeline in one line: ``write_run(Result(assemble(coords, channels, attributes)), directory)``.
"""

from wrsim.results.channels import CHANNELS, Channel
from wrsim.results.dataset import assemble, versions
from wrsim.results.exports import write_run
from wrsim.results.files import write_atomically
from wrsim.results.result import Result
from wrsim.results.summary import summarise
from wrsim.results.tables import tables

__all__ = [
    "CHANNELS",
    "Channel",
    "Result",
    "assemble",
    "summarise",
    "tables",
    "versions",
    "write_atomically",
    "write_run",
]
