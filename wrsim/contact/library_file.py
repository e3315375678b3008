"""Files that the C library opens: the workspace of one wheel on one rail, packed, with a checksum.

Little-endian: magic word, version of the format, digest of the kernels (16 letters), numbers of arrays, of doubles in
the buffer, of bytes of the description; description, index, buffer; CRC-32 of all of these.
"""

import struct
import zlib
from pathlib import Path

from wrsim.contact.arrays import Arrays
from wrsim.contact.workspace import pack
from wrsim.errors import WrsimError
from wrsim.jit.cache import digest_of_sources

MAGIC, VERSION = b"wrsimcon", 1


def save_library(inputs: Arrays, description: str, path: str | Path) -> None:
    """Write the workspace that a model computes in. Raises WrsimError where the file cannot be written."""
    packed = pack(inputs)
    words = description.encode()
    digest = digest_of_sources().encode()
    head = struct.pack("<8sq16sqqq", MAGIC, VERSION, digest, len(inputs), packed.buffer.size, len(words))
    content = head + words + packed.index.astype("<i8").tobytes() + packed.buffer.astype("<f8").tobytes()
    try:
        Path(path).write_bytes(content + struct.pack("<Q", zlib.crc32(content)))
    except OSError as problem:
        raise WrsimError(f"{path}: cannot be written ({problem.strerror})") from None
