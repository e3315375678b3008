"""Whether kernels that came with the package compute what they did where they were made (core.shipped)."""

import sys

import numpy as np

from wrsim.core.contact.stages import make_ready
from wrsim.core.contact.wheel_rail import wheel_rail
from wrsim.core.shipped import CONTACT, FOLDER


def main(folder=FOLDER):
    """End the process with 0 if the contacts that came with the kernels come out of them again, to the bit."""
    paths = sorted(folder.glob(CONTACT.format("*")))
    for path in paths:
        with np.load(path) as stored:
            make_ready(*stored["stages"].tolist())
            buffer, index = stored["before"].copy(), stored["index"].copy()
            status = wheel_rail(buffer, index)
            if status != stored["status"] or buffer.tobytes() != stored["after"].tobytes():
                sys.exit(1)
    sys.exit(0 if paths else 1)
