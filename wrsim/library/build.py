"""Builds the C library: machine code of the kernels, what C has to know of them, and the C source around them.

    python -m wrsim.library.build FOLDER

``bash .ci/library`` calls it for a common level of processors; without that it compiles for this machine's.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import wrsim
from wrsim.contact.library_file import MAGIC, VERSION
from wrsim.contact.status import WORDS
from wrsim.core.contact import records as k
from wrsim.core.contact.arrays import Arrays
from wrsim.core.contact.strips.records import MEMO
from wrsim.core.contact.wheel_rail import STAGES
from wrsim.core.jit import stages
from wrsim.core.jit.cache import digest_of_sources
from wrsim.core.jit.objects import emit_object, target
from wrsim.errors import WrsimError

SOURCE = Path(__file__).parent
LIBRARY, HEADER = "libwrsim_contact.so", "wrsim_contact.h"
OPTIONS = "-std=c11 -O2 -fPIC -shared -fvisibility=hidden -Wl,-z,defs -Wl,--exclude-libs,ALL"
LEVELS = {"x86-64-v3": "NEEDS_AVX2"}
"""Processors whose instructions the library looks for when it opens a contact, and the macro for that."""
RECORDS = {"settings": k.SETTINGS, "memo": MEMO, "lobe": k.LOBE, "strip": k.STRIP, "total": k.TOTAL}
OF_A_STAGE = (
    "int64_t *, void **, void *, void *, int64_t, int64_t, double *, int64_t, int64_t, void *, void *,"
    " int64_t, int64_t, int64_t *, int64_t, int64_t, int64_t, int64_t"
)
"""Arguments of a stage as numba passes them: return value, exception, and of both arrays owner, parent, number and size
of items, address, sizes and strides."""


def build_library(folder: str | Path) -> Path:
    """Build library and header into a folder; returns the path of the library.

    The compiler is that of the variable CC, or ``cc``. Raises WrsimError where there is none or it fails.
    """
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if not compiler or shutil.which(compiler[0]) is None:
        raise WrsimError("no C compiler: neither the variable CC names one nor is there cc")
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        kernels = Path(scratch) / "kernels.o"
        kernels.write_bytes(emit_object({_name(number): kernel for number, kernel in STAGES.items()}))
        (Path(scratch) / "kernels.h").write_text(_kernels_header())
        made = Path(scratch) / LIBRARY
        command = [
            *compiler,
            *OPTIONS.split(),
            f"-I{scratch}",
            str(SOURCE / "contact.c"),
            str(kernels),
            "-o",
            str(made),
        ]
        done = subprocess.run([*command, "-lm"], capture_output=True, text=True)
        if done.returncode != 0:
            raise WrsimError(f"{compiler[0]} failed:\n{done.stderr}")
        shutil.copy(made, place / LIBRARY)
    shutil.copy(SOURCE / HEADER, place / HEADER)
    return place / LIBRARY


def _name(stage: int) -> str:
    return f"wrsim_stage_{stage}"


def _kernels_header() -> str:
    """What C has to know of the kernels: kernels.h."""
    _, processor, _ = target(STAGES[k.CONTACT])
    texts = {"WRSIM_VERSION": wrsim.__version__, "KERNELS": digest_of_sources(), "TARGET": processor,
             "FILE_MAGIC": MAGIC.decode()}  # fmt: skip
    plain = {
        "FILE_VERSION": VERSION, "STAGES": stages.MOST, "STAGE_TABLE": stages.SYMBOL, "CONTACT_STAGE": _name(k.CONTACT),
        "COLD_START": k.COLD_START, "FROM_LAST": k.FROM_LAST,
        "STAGE_ADDRESSES": _listed(f"[{number}] = (void *){_name(number)}" for number in STAGES),
        "STATUS_WORDS": _listed(f'{{{bit}, "{text}"}}' for bit, text in WORDS.items()),
    }  # fmt: skip
    lines = [f'#define {name} "{text}"' for name, text in texts.items()]
    lines += [f"#define {name} {value}" for name, value in plain.items()]
    if processor in LEVELS:
        lines.append(f"#define {LEVELS[processor]}")
    lines += [f"int32_t {_name(number)}({OF_A_STAGE});" for number in STAGES]
    lines.append(f"enum {{{_listed(f'ARRAY_{name.upper()}' for name in Arrays._fields)}, ARRAYS}};")
    lines += [f"struct {name} {{{_members(kind)}}};" for name, kind in RECORDS.items()]
    return "\n".join(lines) + "\n"


def _listed(parts: Iterable[str]) -> str:
    return ", ".join(parts)


def _members(kind: Any) -> str:
    """Declarations of the fields of a record of 8-byte numbers."""
    return " ".join(f"{'double' if kind[name].kind == 'f' else 'int64_t'} {name};" for name in kind.names)


if __name__ == "__main__":
    print(build_library(sys.argv[1]))
