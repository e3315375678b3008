"""The contact as a C library: the bits of Python, from C and through ctypes, on two threads; files that are wrong."""

import ctypes
import os
import platform
import re
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import numba
import numpy as np
import pytest
from support.contacts import PAIRS, RADIUS, bench, pair_model, rail_profile, settle, wheel_profile
from support.objects import kept_objects

from wrsim import Friction, Harmonic, InputError, WrsimError, contact_model
from wrsim.contact import records as k
from wrsim.contact.arrays import Arrays
from wrsim.contact.library.build import LINKING, build_library, library_name, public_header
from wrsim.contact.library_file import MAGIC
from wrsim.contact.settings import FrictionAlong
from wrsim.contact.status import WORDS, status_words
from wrsim.jit import kernel

ROOT = Path(__file__).parents[2]
CC = os.environ.get("CC", "cc")
PAIR = "S1002/60E1 1:40"
LIBRARY = library_name("linux")
FUNCTIONS = set(re.findall(r"WRSIM_API [^;(]*?(wrsim_\w+)\(", public_header()))
NORMALS = ("kik-piotrowski", "strips")
LOAD, SPEED = 55e3, 2.0
SHIFTS = (0.0, 3e-3, 5.06e-3, 6.5e-3, 8e-3)  # tread with two patches, tread, tread and root, gauge corner, flange

pytestmark = [
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing compiled"),
    pytest.mark.skipif(sys.platform != "linux" or shutil.which(CC) is None, reason="there is no C compiler here"),
]


def row_type(name):
    """numpy's type of a struct of the header, with its names."""
    body = re.search(r"typedef struct \{([^}]*)\} " + name + ";", public_header())[1]
    plain = re.sub(r"/\*.*?\*/", "", body, flags=re.S)
    fields = []
    for kind, names in re.findall(r"(double|int32_t) ([^;]*);", plain):
        for declarator in names.split(","):
            shape = re.search(r"\[(\d)\]", declarator)
            of = "f8" if kind == "double" else "i4"
            fields.append(
                (declarator.split("[")[0].strip(), of, (int(shape[1]),)) if shape else (declarator.strip(), of)
            )
    return np.dtype(fields, align=True)


RESULT, PATCH, STRIP = (row_type(f"wrsim_contact_{name}") for name in ("result", "patch", "strip"))


def rows_of(records, kind):
    """Rows as the library has them, of records of Python."""
    rows = np.zeros(len(records), kind)
    for name in kind.names:
        rows[name] = records["n_strips" if name == "strips" else name]
    return rows


def bytes_of(contact):
    """What the program writes of a contact."""
    result = np.zeros((), RESULT)
    result["force"], result["moment"] = contact.force, contact.moment
    result["wear_number"], result["closest"] = contact.wear_number, contact.closest
    result["patches"], result["status"] = len(contact.patches), contact.status
    parts = [result]
    for patch, strips in zip(rows_of(contact.patches, PATCH), contact.strips, strict=True):
        parts += [patch, rows_of(strips, STRIP)]
    return b"".join(part.tobytes() for part in parts)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder with the library, its header and the program of this file."""
    folder = tmp_path_factory.mktemp("library")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CC", f"{CC} -Wall -Wextra -Werror")
        patch.setattr("wrsim.contact.library.build.emit_objects", kept_objects)
        build_library(folder)
    compile_program(folder, Path(__file__).with_name("library_poses.c"), "-pthread")
    return folder


def compile_program(folder, source, *options, compiler=(CC,), ending=""):
    """Compile a program beside the library, as its users do."""
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", *options, f"-I{folder}", f"-L{folder}"]
    command = [*compiler, *flags, str(source), "-o", str(folder / f"{source.stem}{ending}"), "-lwrsim_contact", "-lm"]
    subprocess.run([*command, f"-Wl,-rpath,{folder}"], check=True)


def contacts_in_c(built, model, rows, follow=False, threads=1, program=("./library_poses",)):
    """What the program writes for poses and places (n, 13); program: the command that starts it."""
    files = "model.contact", "poses", "results"
    model.save_for_library(built / files[0])
    np.ascontiguousarray(rows, dtype=float).tofile(built / files[1])
    command = [*program, *files, str(int(follow)), str(threads)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=built)
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    return (built / files[2]).read_bytes()


def contacts_in_python(model, rows, follow=False):
    """The same from Python."""
    model.arrays.follow(follow)
    return b"".join(bytes_of(model.evaluate(*row[:12].reshape(4, 3), place=row[12])) for row in rows)


def results_of(content):
    """The forces of every pose in what the program wrote."""
    rows, place = [], 0
    while place < len(content):
        rows.append(np.frombuffer(content, RESULT, 1, place)[0])
        place += RESULT.itemsize
        for _ in range(rows[-1]["patches"]):
            strips = np.frombuffer(content, PATCH, 1, place)[0]["strips"]
            place += PATCH.itemsize + int(strips) * STRIP.itemsize
    return rows


def poses_under_load(model, shifts=SHIFTS, yaw=2e-3):
    """Poses and places (n, 13) that carry the load."""
    rows, stand = [], bench(model)
    for shift in shifts:
        settle(stand, shift, yaw, LOAD)
        rows.append([*model.arrays.pose, 0.0])
    return np.array(rows)


def around(rows, number, seed):
    """Poses at random around those: up to 1 mm, 5 mrad, 0.05 m/s and 0.2 rad/s off, with and without contact."""
    random = np.random.default_rng(seed)
    chosen = rows[random.integers(len(rows), size=number)].copy()
    chosen[:, :12] += np.repeat([1e-3, 5e-3, 0.05, 0.2], 3) * random.uniform(-1.0, 1.0, (number, 12))
    chosen[:, 3:6] /= np.linalg.norm(chosen[:, 3:6], axis=1, keepdims=True)
    return chosen


@pytest.mark.parametrize("normal", NORMALS)
def test_c_has_the_bits_of_python_for_forces_patches_and_strips(built, normal):
    model = pair_model(PAIR, normal=normal)
    rows = np.concatenate([poses_under_load(model), [[0.0, 0.0, 1.0, *(0.0, 1.0, 0.0), *[0.0] * 6, 0.0]]])
    assert contacts_in_c(built, model, rows) == contacts_in_python(model, rows)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="one level of processors")
def test_an_old_processor_has_the_same_bits_but_for_fused_products(built, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", f"{CC} -Wall -Wextra -Werror -DLEVEL=1")  # as it is chosen where AVX2 is missing
    monkeypatch.setattr("wrsim.contact.library.build.emit_objects", kept_objects)
    build_library(tmp_path)
    compile_program(tmp_path, Path(__file__).with_name("library_poses.c"), "-pthread")
    for normal in NORMALS:
        model = pair_model(PAIR, normal=normal)
        rows = around(poses_under_load(model), 60, 5)
        old, new = (contacts_in_c(folder, model, rows) for folder in (tmp_path, built))
        if normal == "kik-piotrowski":
            assert old == new
        for result_old, result_new in zip(results_of(old), results_of(new), strict=True):
            # splines of the strip model fuse products and sums (jit.spline); its equations are solved to 1e-9
            assert np.allclose(
                result_old["force"], result_new["force"], rtol=0.0, atol=1e-9 * np.abs(result_new["force"]).max()
            )
            assert np.allclose(
                result_old["moment"], result_new["moment"], rtol=0.0, atol=1e-9 * np.abs(result_new["moment"]).max()
            )


def test_two_threads_that_follow_a_moving_wheel_have_the_bits_of_python(built):
    model = pair_model(PAIR, normal="strips")
    rows = np.repeat(poses_under_load(model, (5.06e-3,)), 60, axis=0)
    rows[:, 1] += 2e-6 * np.sin(0.3 * np.arange(60))
    warm, cold = (contacts_in_python(model, rows, follow) for follow in (True, False))
    assert contacts_in_c(built, model, rows, follow=True, threads=2) == warm
    assert warm != cold


def test_friction_changes_along_the_rail_in_c_as_in_python(built):
    along = FrictionAlong((0.0, 10.0), (Friction(0.1), Friction(0.4, gauge_corner=0.2)))
    model = contact_model(wheel_profile("S1002"), rail_profile("60E1", 40), RADIUS, friction=along)
    rows = np.repeat(poses_under_load(model, (6.5e-3,)), 3, axis=0)
    rows[:, 12] = 0.0, 4.0, 20.0
    results = contacts_in_c(built, model, rows)
    assert results == contacts_in_python(model, rows)
    assert len({result.tobytes() for result in np.frombuffer(results, np.uint8).reshape(3, -1)}) == 3


class Opened:
    """A contact through ctypes."""

    def __init__(self, built, path):
        self.library = ctypes.CDLL(str(built / LIBRARY))
        self.library.wrsim_contact_description.restype = ctypes.c_char_p
        self.library.wrsim_contact_free.argtypes = [ctypes.c_void_p]
        self.handle, text = ctypes.c_void_p(), ctypes.create_string_buffer(1000)
        name = os.fsencode(path)
        self.status = self.library.wrsim_contact_open(name, ctypes.byref(self.handle), text, ctypes.c_size_t(1000))
        self.message = text.value.decode()

    def evaluate(self, pose, place=0.0):
        parts = [(ctypes.c_double * 3)(*part) for part in np.reshape(pose, (4, 3))]
        return self.library.wrsim_contact_evaluate(self.handle, *parts, ctypes.c_double(place))

    def result(self):
        room = np.zeros((), RESULT)
        assert self.library.wrsim_contact_forces(self.handle, ctypes.c_void_p(room.ctypes.data)) == 0
        return room

    def status_text(self, status, size=1000):
        text = ctypes.create_string_buffer(b"x" * size)
        length = self.library.wrsim_contact_words(status, text, ctypes.c_size_t(size))
        return text.value.decode(), length

    def close(self):
        self.library.wrsim_contact_free(self.handle)


def names_in(library):
    """Names of the header in a library of whatever format."""
    return {name.decode() for name in re.findall(rb"wrsim_contact_[a-z_]+", library.read_bytes())}


def in_contact(model, rows):
    """Those poses in which the wheel touches the rail."""
    return np.array([row for row in rows if model.evaluate(*row[:12].reshape(4, 3), place=row[12]).force.any()])


@pytest.fixture
def saved(built, tmp_path):
    """A file for the library, and the model in it."""
    model = pair_model(PAIR)
    model.save_for_library(tmp_path / "one.contact")
    return tmp_path / "one.contact", model


def test_a_turned_rail_gives_the_same_forces_through_ctypes(built, saved):
    path, model = saved
    row = poses_under_load(model, (3e-3,))[0, :12]
    opened = Opened(built, path)
    assert (opened.status, opened.message) == (0, "")
    forces = []
    for turning in ((0.0, 0.0, 0.0), (2e-3, 1 / 150.0, -1e-3)):
        assert opened.library.wrsim_contact_turn_rail(opened.handle, *map(ctypes.c_double, turning)) == 0
        assert opened.evaluate(row) == 0
        contact = model.evaluate(*row.reshape(4, 3), turning=turning)
        forces.append(opened.result()["force"])
        assert np.array_equal(forces[-1], contact.force)
    assert not np.array_equal(*forces)
    assert "S1002" in opened.library.wrsim_contact_description(opened.handle).decode()
    opened.close()


@pytest.mark.parametrize("normal", NORMALS)
def test_a_load_is_met_in_c_with_the_bits_of_solve_many(built, tmp_path, normal):
    model = pair_model(PAIR, normal=normal)
    model.save_for_library(tmp_path / "one.contact")
    opened = Opened(built, tmp_path / "one.contact")
    solve = opened.library.wrsim_contact_solve
    rows = poses_under_load(model)[:, :12] + np.where(np.arange(12) == 2, 1e-3, 0.0)
    for row in rows:  # one by one: the search of solve_many begins with the pose before
        solved = model.solve_many(row[None], LOAD, threads=1)
        parts = [(ctypes.c_double * 3)(*part) for part in row.reshape(4, 3)]
        assert opened.library.wrsim_contact_follow(opened.handle, 0) == 0
        assert solve(opened.handle, ctypes.c_double(LOAD), *parts, ctypes.c_double(0.0)) == solved.status[0]
        assert list(parts[0]) == solved.poses[0, :3].tolist()
        assert np.array_equal(opened.result()["force"], solved.force[0])
    for load in (0.0, -1.0, np.nan):
        assert solve(opened.handle, ctypes.c_double(load), *parts, ctypes.c_double(0.0)) == -7
    opened.close()


@pytest.mark.parametrize("normal", NORMALS)
def test_friction_and_tractions_in_c_are_those_of_python(built, tmp_path, normal):
    model = pair_model(PAIR, normal=normal, friction=0.1)
    row = poses_under_load(model, (3e-3,))[0, :12]
    model.save_for_library(tmp_path / "one.contact", tractions=True)
    opened, shares = Opened(built, tmp_path / "one.contact"), np.zeros(4000)
    tractions = opened.library.wrsim_contact_tractions
    for friction, creepage in ((0.1, 0.0), (0.4, 0.0), (0.4, 0.2)):
        model.arrays.inputs.mu = model.arrays.inputs.mu_gauge = friction
        row[10] = SPEED / RADIUS * (1.0 - creepage)
        assert opened.library.wrsim_contact_set_friction(opened.handle, ctypes.c_double(friction)) == 0
        assert opened.evaluate(row) == 0
        contact = model.evaluate(*row.reshape(4, 3))
        assert np.array_equal(opened.result()["force"], contact.force)
        cells = model.settings.cells
        count = tractions(opened.handle, 0, ctypes.c_void_p(shares.ctypes.data), shares.size)
        assert count == cells * len(contact.strips[0])
        shown = shares[:count].reshape(-1, cells)
        assert shown.min() >= 0.0 and shown.max() < 1.0 + 1e-12
        strips = contact.strips[0]
        used = np.hypot(strips["Fx"], strips["Fy"]) / (friction * strips["N"])
        slides = shown > 1.0 - 1e-9
        assert slides.all() == (creepage > 0.0) and slides.any()
        assert (used > 0.9).all() or creepage == 0.0  # all along opposite to nearly the same slip
        if normal == "kik-piotrowski":  # FASTSIM's force is the sum over the cells, whose directions differ
            bound = model.arrays.rows.shape
            assert (used <= (shown * bound).sum(axis=1) / bound.sum() + 1e-9).all()
    for bad in (-0.1, 2.1, np.nan):
        assert opened.library.wrsim_contact_set_friction(opened.handle, ctypes.c_double(bad)) == -7
    opened.close()
    model.save_for_library(tmp_path / "one.contact")
    opened = Opened(built, tmp_path / "one.contact")
    assert opened.evaluate(row) == 0 and tractions(opened.handle, 0, None, 0) == 0
    opened.close()


def test_a_wheel_out_of_round_turns_as_in_python(built, tmp_path):
    plain = pair_model(PAIR)
    polygon = contact_model(
        plain.wheel, plain.rail, plain.radius, plain.settings, 0.3, out_of_round=[Harmonic(5, 1e-4)]
    )
    polygon.save_for_library(tmp_path / "polygon.contact")
    row = poses_under_load(plain, (3e-3,))[0, :12]
    opened = Opened(built, tmp_path / "polygon.contact")
    for angle in (0.0, 0.1):
        assert opened.library.wrsim_contact_turn_wheel(opened.handle, ctypes.c_double(angle)) == 0
        assert opened.evaluate(row) == 0
        contact = polygon.evaluate(*row.reshape(4, 3), wheel_angle=angle)
        assert np.array_equal(opened.result()["force"], contact.force)
    opened.close()


def test_every_status_has_the_text_of_python(built, saved):
    opened = Opened(built, saved[0])
    bits = sum(WORDS)
    for status in (0, *WORDS, bits):
        assert opened.status_text(status) == (status_words(status), len(status_words(status)))
    assert opened.status_text(bits, 20) == (status_words(bits)[:19], len(status_words(bits)))
    assert all(opened.status_text(error)[0] for error in map(int, re.findall(r"WRSIM_\w+ = (-\d)", public_header())))
    opened.close()


def test_a_call_with_bad_arguments_does_nothing_and_has_a_status(built, saved):
    path, model = saved
    opened = Opened(built, path)
    library, room = opened.library, (ctypes.c_char * 1000)()
    assert library.wrsim_contact_forces(opened.handle, room) == -7  # there is no evaluation yet
    row = poses_under_load(model, (3e-3,))[0, :12]
    assert opened.evaluate(row) == 0
    before = opened.result()
    for i in range(12):
        for bad in (np.nan, np.inf, -1e300):
            assert opened.evaluate(np.where(np.arange(12) == i, bad, row)) == -7
    assert opened.evaluate(row, np.nan) == -7
    for axle in ((0.0, 1.001, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)):  # no unit vectors, and one along the track
        assert opened.evaluate([*row[:3], *axle, *row[6:]]) == -7
    assert library.wrsim_contact_evaluate(None, None, None, None, None, ctypes.c_double(0.0)) == -7
    assert library.wrsim_contact_strips(opened.handle, 99, room, 1) == -7
    assert library.wrsim_contact_patches(opened.handle, None, 1) == -7
    assert library.wrsim_contact_open(None, None, None, ctypes.c_size_t(0)) == -7
    library.wrsim_contact_free(None)
    assert opened.result().tobytes() == before.tobytes()
    opened.close()


def test_a_content_in_memory_is_opened_as_its_file(built, saved):
    path, model = saved
    opened, content = Opened(built, path), path.read_bytes()
    row = poses_under_load(model, (3e-3,))[0, :12]
    assert opened.evaluate(row) == 0
    force, handle = opened.result()["force"], opened.handle
    text = ctypes.create_string_buffer(100)
    opened.handle = ctypes.c_void_p()
    arguments = ctypes.byref(opened.handle), text, ctypes.c_size_t(100)
    open_memory = opened.library.wrsim_contact_open_memory
    assert open_memory(content, ctypes.c_size_t(len(content) - 1), *arguments) == -4
    assert (text.value, opened.handle.value) == (b"(memory): the file is damaged", None)
    assert open_memory(None, ctypes.c_size_t(0), *arguments) == -7
    assert open_memory(content, ctypes.c_size_t(len(content)), *arguments) == 0
    assert opened.evaluate(row) == 0
    assert np.array_equal(opened.result()["force"], force)
    opened.close()
    opened.library.wrsim_contact_free(handle)


def test_without_zig_what_is_missing_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("wrsim.contact.library.build.find_spec", lambda name: None)
    with pytest.raises(WrsimError, match=r"^windows: needs zig: pip install 'wrsim\[cross\]'$"):
        build_library(tmp_path, "windows")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(WrsimError, match=r"there is no cc; Debian's gcc is one, zig another: pip install"):
        build_library(tmp_path)


@kernel
def raises(buffer, index):
    """A contact that refuses its arrays."""
    if buffer.size > index[0, 1]:
        raise ValueError("too many")
    return 0


def test_what_cannot_be_saved_or_built_or_raises_an_error_is_told(tmp_path, monkeypatch, saved):
    with pytest.raises(InputError, match='normal = "half-space": is not compiled'):
        pair_model(PAIR, normal="half-space", tangential="half-space").save_for_library(tmp_path / "a")
    with pytest.raises(WrsimError, match=r"none.a: cannot be written"):
        pair_model(PAIR).save_for_library(tmp_path / "none" / "a")
    with monkeypatch.context() as patch, pytest.raises(WrsimError, match="no C compiler"):
        patch.setenv("CC", "no-such-compiler")
        build_library(tmp_path)
    path, model = saved
    monkeypatch.setattr("wrsim.contact.library.build.STAGES", {k.CONTACT: raises})
    build_library(tmp_path)
    opened = Opened(tmp_path, path)
    assert opened.evaluate(poses_under_load(model, (3e-3,))[0, :12]) == -8
    assert opened.library.wrsim_contact_forces(opened.handle, (ctypes.c_char * 1000)()) == -7
    opened.close()


@pytest.mark.parametrize("target", ["linux-arm", "macos"])
def test_a_library_for_another_system_has_the_functions_of_the_header(tmp_path, monkeypatch, target):
    pytest.importorskip("ziglang", reason="the contact alone has no compiler for other systems")
    monkeypatch.setattr("wrsim.contact.library.build.STAGES", {k.CONTACT: raises})
    library = build_library(tmp_path, target)
    assert names_in(library) == FUNCTIONS
    # programs look for it beside them, not where it was linked
    assert (b"@rpath/libwrsim_contact.dylib" in library.read_bytes()) == (target == "macos")
    assert (tmp_path / "wrsim_contact.h").read_text() == public_header()


def test_forces_that_are_no_numbers_are_no_result(built, saved):
    path, model = saved
    pose = poses_under_load(model, (3e-3,))[0, :12]
    model.save_for_library(path)
    opened = Opened(built, path)
    assert opened.evaluate(pose) == 0
    assert opened.library.wrsim_contact_turn_rail(opened.handle, *map(ctypes.c_double, (1e9, 1e9, 1e9))) == 0
    assert opened.evaluate(pose) == -9
    assert opened.library.wrsim_contact_forces(opened.handle, (ctypes.c_char * 1000)()) == -7
    opened.close()


def test_wrong_and_damaged_files_have_a_status_and_a_text(built, saved):
    path, model = saved
    content, pose = path.read_bytes(), poses_under_load(model, (3e-3,))[0, :12]
    force = model.evaluate(*pose.reshape(4, 3)).force
    random = np.random.default_rng(1)
    cases = [(b"", -2), (b"[vehicle]\n" * 100, -2), (content[: len(MAGIC)], -2), (content + b"\0" * 8, -4)]
    cases += [(content[:size], -4) for size in (100, 1000, len(content) - 1, len(content) - 8, len(content) // 2)]
    for place in (8, 16, 31):  # version, digest of the kernels
        cases.append((content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :], -3))
    for place in (32, 40, 48, 55, 60, *random.integers(56, len(content), 40)):
        bit = 1 << int(random.integers(8))
        cases.append((content[:place] + bytes([content[place] ^ bit]) + content[place + 1 :], -4))
    for wrong, status in cases:
        path.write_bytes(wrong)
        opened = Opened(built, path)
        assert (opened.status, opened.handle.value) == (status, None), opened.message
        assert opened.message.startswith(f"{path}: ") and len(opened.message) > len(str(path)) + 20
    text_size = int.from_bytes(content[48:56], "little")
    for _ in range(60):  # offsets and sizes of arrays, with the right checksum
        forged = bytearray(content[:-8])
        position = 56 + text_size + 8 * int(random.integers(4 * len(Arrays._fields)))
        number = int.from_bytes(forged[position : position + 8], "little", signed=True)
        number = int(random.choice([-1, number + 1, number + 8, 1 << 20, 1 << 40, (1 << 62) + 1, -(1 << 62)]))
        forged[position : position + 8] = number.to_bytes(8, "little", signed=True)
        path.write_bytes(forged + zlib.crc32(forged).to_bytes(8, "little"))
        opened = Opened(built, path)
        assert opened.status in (0, -4), (position, number)
        if opened.status == 0:  # an empty array somewhere else
            assert opened.evaluate(pose) == 0 and opened.result()["force"].tobytes() == force.tobytes()
            opened.close()
    for place in (path.parent, path.parent / "none"):
        opened = Opened(built, place)
        assert opened.status == -1 and "cannot be read" in opened.message
    assert zlib.crc32(content[:-8]) == int.from_bytes(content[-8:], "little")


def test_the_library_needs_the_c_library_alone_and_shows_its_functions_alone(built):
    run = {"check": True, "capture_output": True, "text": True}
    needed = re.findall(r"NEEDED\s+(\S+)", subprocess.run(["objdump", "-p", str(built / LIBRARY)], **run).stdout)
    assert {name.split(".")[0] for name in needed} <= {"libc", "libm"}
    listed = subprocess.run(["nm", "-D", "--defined-only", str(built / LIBRARY)], **run).stdout
    shown = {line.split()[-1] for line in listed.splitlines()}
    assert shown == FUNCTIONS


def test_the_example_of_the_manual_runs(built, tmp_path):
    page = (ROOT / "docs/user/library.md").read_text()
    python, c = (re.search(rf"^```{language}\n(.*?)^```", page, re.M | re.S)[1] for language in ("python", "c"))
    exec(python.replace('"s1002_60e1.contact"', f'r"{tmp_path / "s1002_60e1.contact"}"'), {})
    (built / "example.c").write_text(c)
    compile_program(built, built / "example.c")
    done = subprocess.run([built / "example"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    number, shown = r"-?\d+(?:\.\d+)?", re.search(r"^```text\n(.*?)^```", page, re.M | re.S)[1]
    assert re.sub(number, "", done.stdout) == re.sub(number, "", shown)
    # the page rounds to newtons and megapascals, of a contact that is solved to a tolerance
    computed, printed = (np.array(re.findall(number, text), dtype=float) for text in (done.stdout, shown))
    assert computed == pytest.approx(printed, abs=1.0)
    failed = subprocess.run([built / "example"], cwd=built, capture_output=True, text=True)
    assert failed.returncode == 1 and "s1002_60e1.contact: the file cannot be read" in failed.stderr


@pytest.mark.campaign
@pytest.mark.parametrize("normal", NORMALS)
def test_twenty_thousand_random_poses_have_the_bits_of_python(built, normal):
    model = pair_model(PAIR, normal=normal)
    rows = around(poses_under_load(model), 20_000, 7)
    results = contacts_in_c(built, model, rows, threads=2)
    assert results == contacts_in_python(model, rows)


@pytest.mark.campaign
def test_a_library_for_common_processors_has_the_bits_of_this_machine(built, tmp_path):
    env = os.environ | {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
    subprocess.run([sys.executable, "-m", "wrsim.contact.library.build", tmp_path], env=env, check=True)
    compile_program(tmp_path, Path(__file__).with_name("library_poses.c"), "-pthread")
    for normal in NORMALS:
        model = pair_model(PAIR, normal=normal)
        rows = around(poses_under_load(model), 500, 3)
        assert contacts_in_c(tmp_path, model, rows) == contacts_in_python(model, rows)


def command_on(target, folder):
    """The command that starts the program for a target on this machine."""
    sizes = [str(kind.itemsize) for kind in (RESULT, PATCH, STRIP)]
    commands = {
        "linux": ["qemu-x86_64-static", "-cpu", "Nehalem", "./library_poses"],  # of 2008: SSE4.2
        "linux-arm": ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu", "./library_poses"],
        "windows": [os.environ.get("WRSIM_WINE", "wine"), "library_poses.exe"],
        "wasm": ["node", str(Path(__file__).with_name("library_poses.mjs")), library_name("wasm"), *sizes],
    }
    if shutil.which(commands[target][0]) is None:
        pytest.skip(f"there is no {commands[target][0]} here")
    if target in ("linux-arm", "windows"):
        zig = [sys.executable, "-m", "ziglang", "cc", "-target", LINKING[target][1]]
        ending = ".exe" if target == "windows" else ""
        compile_program(folder, Path(__file__).with_name("library_poses.c"), compiler=zig, ending=ending)
    elif target == "linux":
        compile_program(folder, Path(__file__).with_name("library_poses.c"), "-pthread")
    return commands[target]


@pytest.mark.campaign
@pytest.mark.parametrize("target", ["linux", "linux-arm", "windows", "wasm"])
def test_809_poses_have_the_numbers_of_this_machine_on_another(built, tmp_path, monkeypatch, target):
    monkeypatch.setattr("wrsim.contact.library.build.emit_objects", kept_objects)
    assert names_in(build_library(tmp_path, target)) == FUNCTIONS
    program = command_on(target, tmp_path)
    for normal, tolerance in zip(NORMALS, (1e-15, 1e-9), strict=True):
        errors = []
        for pair, count in zip(PAIRS, (162, 162, 162, 162, 161), strict=True):
            model = pair_model(pair, normal=normal)
            rows = in_contact(model, around(poses_under_load(model), 3 * count, 809))[:count]
            content = contacts_in_c(tmp_path, model, rows, threads=0, program=program)
            for result, native in zip(results_of(content), results_of(contacts_in_c(built, model, rows)), strict=True):
                assert (result["patches"], result["status"]) == (native["patches"], native["status"])
                for part in ("force", "moment"):
                    size = np.abs(native[part]).max()
                    errors.append(np.abs(result[part] - native[part]).max() / size if size else 0.0)
        equal = sum(error == 0.0 for error in errors)
        print(f"{target} {normal}: {equal} of {len(errors)} vectors to the bit, largest error {max(errors):.2g}")
        assert len(errors) == 2 * 809 and max(errors) <= tolerance
