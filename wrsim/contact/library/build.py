"""Builds C libraries: machine code of kernels, what C has to know of them, and the C source around them.

    python -m wrsim.contact.library.build FOLDER

``bash .ci/library`` calls it for a common level of processors; without that it compiles for this machine's.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import wrsim
from wrsim.contact import records as k
from wrsim.contact.arrays import Arrays
from wrsim.contact.library_file import MAGIC, VERSION
from wrsim.contact.status import WORDS
from wrsim.contact.strips.records import MEMO
from wrsim.contact.wheel_rail import STAGES
from wrsim.errors import WrsimError
from wrsim.jit import stages
from wrsim.jit.arena import MEANINGS
from wrsim.jit.cache import digest_of_sources
from wrsim.jit.objects import emit_object, target

SOURCE = Path(__file__).parent
LIBRARY, HEADER = "libwrsim_contact.so", "wrsim_contact.h"
OPTIONS = "-std=c11 -O2 -fPIC -shared -fvisibility=hidden -Wl,-z,defs -Wl,--exclude-libs,ALL"
LEVELS = {"x86-64-v3": ["avx2", "fma", "bmi2"]}
INSTRUCTIONS = ("avx2", "fma", "bmi2", "avx512f", "avx512bw", "avx512dq", "avx512vl")
"""What a library looks for in the processor: of common levels, and else of those that it is compiled for."""
RECORDS = {"call": k.CALL, "state": k.STATE, "memo": MEMO, "lobe": k.LOBE, "strip": k.STRIP, "total": k.TOTAL}
PUBLIC = {
    "PATCH": (
        k.LOBE,
        "N Fx Fy Mz p0 area length width approach angle angle_min angle_max xi eta phi wear x o b no nb"
        " arc_wheel arc_rail group n_strips",
    ),
    "STRIP": (k.STRIP, "s ds x a p o b no nb N Fx Fy Mz xi eta phi mu penetration"),
}
"""Fields of records that users of the C library see."""
C_TYPES = {"f": "double", "i": "int32_t"}
STAGE_SIGNATURE = (
    "int64_t *, void **, void *, void *, int64_t, int64_t, double *, int64_t, int64_t, void *, void *,"
    " int64_t, int64_t, int64_t *, int64_t, int64_t, int64_t, int64_t"
)
"""Arguments of a stage as numba passes them: return value, exception, and of both arrays owner, parent, number and size
of items, address, sizes and strides."""


def build_library(folder: str | Path) -> Path:
    """Build library and header into a folder; returns the path of the library.

    The compiler is that of the variable CC, or ``cc``. Raises WrsimError where there is none or it fails.
    """
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    header = public_header()
    files = {HEADER: header, "contact_kernels.h": _contact_header()}
    (place / LIBRARY).write_bytes(shared_library(SOURCE / "contact.c", STAGES, {}, files))
    (place / HEADER).write_text(header)
    return place / LIBRARY


def shared_library(
    source: Path, table: Mapping[int, Any], more: Mapping[str, Any], files: Mapping[str, str | bytes]
) -> bytes:
    """A C source, which may include ``runtime.h``, with the machine code of stages around it, as a shared library.

    table: stages that others call by their numbers; more: stages that C alone calls, by names; files: that the source
    includes. Raises WrsimError as `build_library`.
    """
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if not compiler or shutil.which(compiler[0]) is None:
        raise WrsimError("no C compiler: neither the variable CC names one nor is there cc")
    stages_by_name = {_name(number): kernel for number, kernel in table.items()} | dict(more)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        (place / "kernels.o").write_bytes(emit_object(stages_by_name))
        for name, content in ({"kernels.h": _kernels_header(table, stages_by_name)} | dict(files)).items():
            (place / name).write_bytes(content.encode() if isinstance(content, str) else content)
        command = [*compiler, *OPTIONS.split(), "-I.", f"-I{SOURCE}", str(source), "kernels.o", "-o", LIBRARY, "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, cwd=scratch)
        if done.returncode != 0:
            raise WrsimError(f"{compiler[0]} failed:\n{done.stderr}")
        return (place / LIBRARY).read_bytes()


def _name(stage: int) -> str:
    return f"wrsim_stage_{stage}"


def _kernels_header(table: Mapping[int, Any], by_name: Mapping[str, Any]) -> str:
    """What runtime.h has to know of the kernels: kernels.h."""
    _, processor, features = target(next(iter(by_name.values())))
    needs = LEVELS.get(processor, [name for name in INSTRUCTIONS if f"+{name}" in features.split(",")])
    lines = [
        f"typedef int32_t stage({STAGE_SIGNATURE});",
        *(f"stage {name};" for name in by_name),
        f'#define TARGET "{processor}"',
        f"#define STAGE_TABLE_ADDRESS {stages.SYMBOL}",
        f"#define STAGE_ADDRESSES {_listed(f'[{number}] = (void *){_name(number)}' for number in table)}",
    ]
    if needs:
        lines.append("#define PROCESSOR_FITS " + " && ".join(f'__builtin_cpu_supports("{name}")' for name in needs))
    return "\n".join(lines) + "\n"


def public_header() -> str:
    """The header for users: the fields of patches and strips with unit and meaning, from the records of the kernels."""
    text = (SOURCE / f"{HEADER}.in").read_text()
    for part, (kind, names) in PUBLIC.items():
        texts = MEANINGS[id(kind)]
        rows = [(f"{C_TYPES[kind[name].kind]} {name.removeprefix('n_')};", *texts[name]) for name in names.split()]
        lines = [
            f"    {declared:24s} /* {meaning}{'' if unit == 'int' else f' [{unit}]'} */"
            for declared, unit, meaning in rows
        ]
        text = text.replace(f"@{part}_FIELDS@", "\n".join(lines))
    return text


def _contact_header() -> str:
    """What contact.c has to know of the kernels: contact_kernels.h."""
    texts = {"WRSIM_VERSION": wrsim.__version__, "KERNELS": digest_of_sources(), "FILE_MAGIC": MAGIC.decode()}
    plain = {
        "FILE_VERSION": VERSION, "CONTACT_STAGE": _name(k.CONTACT), "COLD_START": k.COLD_START,
        "FROM_LAST": k.FROM_LAST,
        "STATUS_WORDS": _listed(f'{{{bit}, "{text}"}}' for bit, text in WORDS.items()),
    }  # fmt: skip
    lines = [f'#define {name} "{text}"' for name, text in texts.items()]
    lines += [f"#define {name} {value}" for name, value in plain.items()]
    lines.append(f"enum {{{_listed(f'ARRAY_{name.upper()}' for name in Arrays._fields)}, ARRAYS}};")
    lines += [f"struct {name} {{{_members(kind)}}};" for name, kind in RECORDS.items()]
    for part, (kind, names) in PUBLIC.items():
        values = (f"({C_TYPES[kind[name].kind]})(of)->{name}" for name in names.split())
        lines.append(f"#define {part}_VALUES(of) {_listed(values)}")
    return "\n".join(lines) + "\n"


def _listed(parts: Iterable[str]) -> str:
    return ", ".join(parts)


def _members(kind: Any) -> str:
    """Declarations of the fields of a record of 8-byte numbers."""
    return " ".join(f"{'double' if kind[name].kind == 'f' else 'int64_t'} {name};" for name in kind.names)


if __name__ == "__main__":
    print(build_library(sys.argv[1]))
