"""Builds C libraries: machine code of kernels, what C has to know of them, and the C source around them.

    python -m wrsim.contact.library.build FOLDER [TARGET ...]

puts the contact library of this machine into a folder, or those of targets (`jit.objects`) into folders of their names.
A library that came with the package is taken, others are built.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import wrsim
from wrsim.contact import records as k
from wrsim.contact.arrays import SCRATCH, Arrays
from wrsim.contact.batch import DEEPEST, LEAST_SCALE, LOAD_TOLERANCE
from wrsim.contact.library_file import MAGIC, VERSION
from wrsim.contact.prescribed_load import SEARCH, contact_at_load
from wrsim.contact.settings import MOST_FRICTION
from wrsim.contact.status import WORDS
from wrsim.contact.strips.records import MEMO
from wrsim.contact.wheel_rail import STAGES
from wrsim.errors import WrsimError
from wrsim.jit import stages
from wrsim.jit.arena import MEANINGS
from wrsim.jit.cache import CACHE, FOLDER, cache_folder, digest_of_sources
from wrsim.jit.objects import TARGETS, emit_constant, emit_objects, this_target

SOURCE = Path(__file__).parent
HEADER = "wrsim_contact.h"
SHIPPED = FOLDER / "library"
"""Where a wheel holds contact libraries, in folders of their targets."""
OPTIONS = "-std=c11 -O2 -s -ffp-contract=off -fvisibility=hidden"
_ELF = "-fPIC -shared -Wl,-z,defs -lm"
LINKING = {
    "linux": ("so", "x86_64-linux-gnu.2.17", _ELF),
    "linux-arm": ("so", "aarch64-linux-gnu.2.17", _ELF),
    "windows": ("dll", "x86_64-windows-gnu", "-shared -Wl,--out-implib,made/wrsim_contact.lib"),
    "macos": ("dylib", "aarch64-macos.11.0", "-fPIC -shared -Wl,-x,-install_name,@rpath/libwrsim_contact.dylib"),
    "wasm": ("wasm", "wasm32-wasi", "-mexec-model=reactor -Wl,--export-dynamic,--export=malloc,--export=free"),
}
"""Ending, name of the system for zig, and options, by target."""
RECORDS = {
    "search": SEARCH, "model": k.MODEL, "call": k.CALL, "state": k.STATE, "memo": MEMO, "lobe": k.LOBE,
    "strip": k.STRIP, "total": k.TOTAL,
}  # fmt: skip
LOAD_STAGE = {"wrsim_at_load": contact_at_load}
"""The stage of a prescribed load, which no other stage calls."""
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


def library_name(target: str) -> str:
    """File name of the contact library."""
    return f"libwrsim_contact.{LINKING[target][0]}"


def build_library(folder: str | Path, target: str = "") -> Path:
    """Put library and header into a folder, for this machine or another target; returns the path of the library.

    Raises WrsimError where it has to be built and there is no compiler (`shared_library`) or it fails.
    """
    target = target or this_target()
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    for name, content in _contact_files(target).items():
        (place / name).write_bytes(content)
    return place / library_name(target)


def contact_wasm() -> bytes:
    """The contact library as WebAssembly, as `build_library` has it; what was built is kept in the user's cache."""
    inputs = b"".join((SOURCE / name).read_bytes() for name in ("contact.c", "runtime.h", f"{HEADER}.in"))
    kept = Path(CACHE, f"contact-{zlib.crc32(inputs):08x}.wasm") if CACHE else None
    if kept and kept.exists() and _is_of_these_kernels(content := kept.read_bytes()):
        return content
    content = _contact_files("wasm")[library_name("wasm")]
    if kept:
        made = kept.with_suffix(f".{os.getpid()}")
        made.write_bytes(content)
        made.replace(kept)
    return content


def _contact_files(target: str) -> dict[str, bytes]:
    """The contact library of a target with its header, by file names: as it came with the package, or built."""
    library = SHIPPED / target / library_name(target)
    if library.exists() and _is_of_these_kernels(library.read_bytes()):
        return {path.name: path.read_bytes() for path in library.parent.iterdir()}
    header = public_header()
    files = {HEADER: header, "contact_kernels.h": _contact_header()}
    return {HEADER: header.encode(), **_link(SOURCE / "contact.c", STAGES, LOAD_STAGE, files, {}, target)}


def _is_of_these_kernels(library: bytes) -> bool:
    return digest_of_sources().encode() in library


def shared_library(
    source: Path, table: Mapping[int, Any], more: Mapping[str, Any], files: Mapping[str, str],
    constants: Mapping[str, bytes], target: str,
) -> bytes:  # fmt: skip
    """A C source, which may include ``runtime.h``, with the machine code of stages around it, as a shared library.

    table: stages that others call by their numbers; more: stages that C alone calls, by names; files: that the source
    includes; constants: bytes that it declares as HIDDEN arrays, by names; target: see `jit.objects`. The compiler is
    that of the variable CC or ``cc`` for this machine, else zig. Raises WrsimError where there is none or it fails.
    """
    return _link(source, table, more, files, constants, target)[library_name(target)]


def _link(
    source: Path, table: Mapping[int, Any], more: Mapping[str, Any], files: Mapping[str, str],
    constants: Mapping[str, bytes], target: str,
) -> dict[str, bytes]:  # fmt: skip
    """As `shared_library`: what the linker makes, by file names; on Windows there is an import library as well."""
    compiler = compiler_for(target)
    stages_by_name = {_name(number): kernel for number, kernel in table.items()} | dict(more)
    objects = {f"kernels_{i}.o": code for i, code in enumerate(emit_objects(stages_by_name, target))}
    objects |= {f"{name}.o": emit_constant(name, content, target) for name, content in constants.items()}
    headers = {"kernels.h": _kernels_header(table, stages_by_name, target)} | dict(files)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for name, content in (objects | {name: text.encode() for name, text in headers.items()}).items():
            (place / name).write_bytes(content)
        cache = cache_folder("zig") or scratch
        zig = {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
        (made := place / "made").mkdir()
        command = [*compiler, *OPTIONS.split(), "-I.", f"-I{SOURCE}", str(source), *objects]
        command += ["-o", f"made/{library_name(target)}", *LINKING[target][2].split()]
        done = subprocess.run(command, capture_output=True, text=True, cwd=scratch, env=os.environ | zig)
        if done.returncode != 0:
            raise WrsimError(f"{compiler[0]} failed:\n{done.stderr}")
        return {path.name: path.read_bytes() for path in made.iterdir()}


def compiler_for(target: str) -> list[str]:
    """The command of a C compiler for a target. Raises WrsimError where there is none, with what brings one."""
    compiler = shlex.split(os.environ.get("CC", "cc")) if target == this_target() else []
    if compiler and shutil.which(compiler[0]):
        return compiler
    if compiler and "CC" in os.environ:
        raise WrsimError(f"no C compiler: the variable CC names {compiler[0]}, which is not found")
    if not find_spec("ziglang"):
        reason = "no C compiler: there is no cc; Debian's gcc is one, zig another" if compiler else "needs zig"
        raise WrsimError(f"{target}: {reason}: pip install 'wrsim[cross]'")
    return [sys.executable, "-m", "ziglang", "cc", "-target", LINKING[target][1]]


def _name(stage: int) -> str:
    return f"wrsim_stage_{stage}"


def _kernels_header(table: Mapping[int, Any], by_name: Mapping[str, Any], target: str) -> str:
    """What runtime.h has to know of the kernels: kernels.h. A kernel is known by its number among them."""
    levels = TARGETS[target].levels
    lines = [
        f"typedef int32_t stage({STAGE_SIGNATURE});",
        f'#define TARGET "{", ".join(levels)}"',
        f"#define LEVELS {len(levels)}",
        f"enum {{{_listed(by_name)}, KERNELS}};",
    ]
    for i in range(len(levels)):
        entries = _listed(f"[{number}] = {{(void *){_name(number)}_{i}}}" for number in table)
        lines += [
            f"stage {_listed(f'{name}_{i}' for name in by_name)};",
            f"static const struct word stage_table_{i}[] = {{{entries}}};",
            f"HIDDEN const struct word {stages.SYMBOL}_{i} = {{stage_table_{i}}};",
        ]
    rows = (f"{{{_listed(f'{name}_{i}' for name in by_name)}}}" for i in range(len(levels)))
    lines.append(f"static stage *const kernels[LEVELS][KERNELS] = {{{_listed(rows)}}};")
    return "\n".join(lines) + "\n"


def public_header() -> str:
    """The header for users: the fields of patches and strips with unit and meaning, from the records of the kernels."""
    text = (SOURCE / f"{HEADER}.in").read_text(encoding="utf-8")
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
        "FROM_LAST": k.FROM_LAST, "LOAD_STAGE": next(iter(LOAD_STAGE)), "SCRATCH": SCRATCH,
        "MOST_FRICTION": MOST_FRICTION, "LOAD_TOLERANCE": LOAD_TOLERANCE, "FARTHEST": DEEPEST,
        "LEAST_SCALE": LEAST_SCALE,
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
    try:
        for target_name in sys.argv[2:] or [""]:
            print(build_library(Path(sys.argv[1], target_name), target_name))
    except WrsimError as error:
        sys.exit(str(error))
