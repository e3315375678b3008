"""Files that the C library opens: the workspace of one wheel on one rail, packed, with a checksum.

Little-endian: magic word, version of the format, digest of the kernels (16 letters), numbers of arrays, of doubles in
the buffer, of bytes of the description; description, index, buffer; CRC-32 of all of these.
"""

import struct
import zlib
from itertools import pairwise
from pathlib import Path

import numpy as np

from wrsim.contact.arrays import Arrays
from wrsim.contact.workspace import pack
from wrsim.errors import WrsimError
from wrsim.jit.cache import digest_of_sources

MAGIC, VERSION = b"wrsimcon", 1
HEAD = "<8sq16sqqq"


def library_bytes(inputs: Arrays, description: str) -> bytes:
    """The file of the workspace that a model computes in."""
    packed = pack(inputs)
    description_bytes = description.encode()
    digest = digest_of_sources().encode()
    head = struct.pack(HEAD, MAGIC, VERSION, digest, len(inputs), packed.buffer.size, len(description_bytes))
    content = head + description_bytes + packed.index.astype("<i8").tobytes() + packed.buffer.astype("<f8").tobytes()
    return content + struct.pack("<Q", zlib.crc32(content))


def pieces_of(content: bytes) -> list[bytes]:
    """Such a file cut into head, arrays and checksum: files share arrays."""
    *_, count, _doubles, letters = struct.unpack_from(HEAD, content)
    begin = struct.calcsize(HEAD) + letters
    index = np.frombuffer(content, "<i8", 4 * count, begin).reshape(count, 4)
    cuts = [0, *(begin + index.nbytes + 8 * np.unique(index[:, 0])).tolist(), len(content) - 8, len(content)]
    return [content[a:b] for a, b in pairwise(cuts)]


def save_library(content: bytes, path: str | Path) -> None:
    """Write such a file. Raises WrsimError where it cannot be written."""
    try:
        Path(path).write_bytes(content)
    except OSError as problem:
        raise WrsimError(f"{path}: cannot be written ({problem.strerror})") from None
