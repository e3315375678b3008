"""Kernels that come with the package are taken where all that they depend on is the same, and only there; whatever the
user's cache holds that is damaged is compiled again."""

import errno
import json
import os
import runpy
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from llvmlite import binding

from wrsim.jit import kernel
from wrsim.jit.cache import (
    ABOUT,
    CACHE,
    CALL,
    CONFIG,
    CheckedFile,
    KernelCache,
    Shipped,
    cache_folder,
    is_private,
    shipped,
)

ROOT = Path(__file__).parents[2]

pytestmark = [
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing to compile"),
    pytest.mark.skipif(CACHE is None, reason="nothing is kept here"),
]
OF_OWNERS = pytest.mark.skipif(sys.platform == "win32", reason="folders have no modes on Windows")

FIRST_CONTACT = """
from numba.core import event
with event.install_recorder("numba:compile") as recorder:
    from wrsim import contact_model, load_profile
    rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    model = contact_model(load_profile("wheels/S1002.toml"), rail, 0.46)
    contact = model.evaluate((0.0, 0.0, 0.46 - 50e-6), velocity=(10.0, 0.0, 0.0), omega=(0.0, 10.0 / 0.46, 0.0))
print(len(recorder.buffer), contact.normal_force.hex())
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with wrsim in it, as installed from a wheel that holds kernels for this machine."""
    place = tmp_path_factory.mktemp("installed")
    shutil.copytree(ROOT / "wrsim", place / "wrsim", ignore=shutil.ignore_patterns("kernels"))
    shutil.copytree(ROOT / "models", place / "wrsim" / "models")
    gather = runpy.run_path(str(ROOT / ".ci/ship_kernels.py"))["gather"]
    gather(Path(str(CACHE)), place / "wrsim" / "kernels", ())
    return place


def first_contact(package: Path, home: Path) -> tuple[int, str]:
    """How many kernels a new user's first contact compiles, and its normal force."""
    unwanted = ("NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
    env = {name: value for name, value in os.environ.items() if name not in unwanted}
    env |= {"PYTHONPATH": str(package), "XDG_CACHE_HOME": str(home)}
    done = subprocess.run([sys.executable, "-P", "-c", FIRST_CONTACT], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    count, force = done.stdout.split()
    return int(count), force


def kept(home: Path) -> bool:
    """What was found out about the kernels."""
    (record_file,) = home.glob("wrsim/*/shipped.json")
    return bool(json.loads(record_file.read_text())["usable"])


def test_a_new_users_first_contact_compiles_nothing_and_is_the_same_to_the_bit(package: Path, tmp_path: Path) -> None:
    count, force = first_contact(package, tmp_path)
    assert count == 0 and kept(tmp_path)
    names: dict[str, Any] = {}
    exec(FIRST_CONTACT.replace("print", "result = "), names)
    assert force == names["contact"].normal_force.hex()


def test_kernels_that_compute_a_wrong_bit_are_not_taken(package: Path, tmp_path: Path) -> None:
    folder = with_about(package, tmp_path, dict)
    path = folder / CALL.format("kik-piotrowski")
    stored = dict(np.load(path))
    changed = np.flatnonzero(stored["after"] != stored["before"])[0]
    stored["after"][changed] = np.nextafter(stored["after"][changed], np.inf)
    np.savez(path, **stored)
    tried = shipped(str(tmp_path), folder)
    assert tried is not None and not tried.usable
    assert json.loads((tmp_path / "shipped.json").read_text()) == {"usable": False}


@pytest.mark.parametrize("entry", ["numba", "llvmlite", "python", "platform", "sources"])
def test_kernels_made_with_anything_else_are_not_taken(package: Path, tmp_path: Path, entry: str) -> None:
    folder = with_about(package, tmp_path, lambda about: about | {entry: "another"})
    assert shipped(str(tmp_path), folder) is None


def test_kernels_made_for_another_processor_are_not_taken(package: Path, tmp_path: Path) -> None:
    missing = next(name for name, present in binding.get_host_cpu_features().items() if not present)
    folder = with_about(package, tmp_path, lambda about: about | {"needs": [missing]})
    assert shipped(str(tmp_path), folder) is None


@OF_OWNERS
def test_kernels_that_others_can_write_to_are_not_taken(package: Path, tmp_path: Path) -> None:
    folder = with_about(package, tmp_path, dict)
    (folder / "contact").chmod(0o777)
    assert shipped(str(tmp_path), folder) is None


def test_the_folder_itself_is_taken(package: Path, tmp_path: Path) -> None:
    assert isinstance(shipped(str(tmp_path), with_about(package, tmp_path, dict)), Shipped)
    assert shipped(None, tmp_path / "kernels") is None, "nothing can be kept"
    assert shipped(str(tmp_path), tmp_path / "none") is None


@pytest.mark.parametrize("text", ["", "{}", "[]", "no json"])
def test_a_damaged_description_is_no_error(package: Path, tmp_path: Path, text: str) -> None:
    folder = with_about(package, tmp_path, dict)
    (folder / ABOUT).write_text(text)
    assert shipped(str(tmp_path), folder) is None


def test_a_damaged_kernel_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    class Damaged:
        usable = True

        def data(self, *_: object) -> object:
            raise EOFError("cut off")

    monkeypatch.setattr(KernelCache, "shipped", Damaged())

    @kernel
    def twice(x):
        return 2.0 * x

    assert twice(4.0) == 8.0


def halved(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    """One bit of the machine code: without a digest it is executed."""
    place = content.rindex(b"\x7fELF") + 0x400 if b"\x7fELF" in content else len(content) // 2
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


@pytest.mark.parametrize("files", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("damage", [lambda content: b"", halved, flipped], ids=["empty", "halved", "one bit"])
def test_a_damaged_file_of_the_cache_is_compiled_again_and_said_once(tmp_path, monkeypatch, caplog, files, damage):
    def twice(x):
        return 2.0 * x

    def compilations(first: float) -> int:
        """Of a new process: its kernel is another object."""
        again = kernel(twice)
        assert again(first) == 2.0 * first
        return sum(again.stats.cache_misses.values())

    caplog.set_level("WARNING", "wrsim")  # a command with --quiet before this test has set it higher
    monkeypatch.setattr(KernelCache, "shipped", None)
    monkeypatch.setattr(KernelCache, "faults", set())
    monkeypatch.setattr(CONFIG, "CACHE_DIR", str(tmp_path))
    assert (compilations(1.0), compilations(2.0)) == (1, 0)
    (file,) = tmp_path.rglob(files)
    file.write_bytes(damage(file.read_bytes()))
    assert not caplog.messages
    assert (compilations(3.0), compilations(4.0)) == (1, 0)
    (message,) = caplog.messages
    assert "removed and compiled again" in message and str(tmp_path) in message


def test_a_cache_that_takes_no_files_is_said_once_and_kernels_work(tmp_path, monkeypatch, caplog):
    caplog.set_level("WARNING", "wrsim")
    monkeypatch.setattr(KernelCache, "faults", set())
    monkeypatch.setattr(CONFIG, "CACHE_DIR", str(tmp_path))

    def refused(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(CheckedFile, "save", refused)

    def twice(x):
        return 2.0 * x

    def thrice(x):
        return 3.0 * x

    assert (kernel(twice)(4.0), kernel(thrice)(4.0)) == (8.0, 12.0)
    (message,) = caplog.messages
    assert message.startswith("compiled kernels cannot be stored (No space left on device)")


def with_about(package: Path, place: Path, change: Callable[[dict[str, Any]], dict[str, Any]]) -> Path:
    """A copy of the kernels with a changed description."""
    folder = place / "kernels"
    shutil.copytree(package / "wrsim" / "kernels", folder, dirs_exist_ok=True)
    about = json.loads((folder / ABOUT).read_text())
    (folder / ABOUT).write_text(json.dumps(change(about)))
    return folder


# Compiled kernels are loaded from no folder that somebody else could have written to.
@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """The user's cache and the temporary directory, which is shared."""
    home, shared = tmp_path / "home", tmp_path / "shared"
    home.mkdir()
    shared.mkdir()
    shared.chmod(0o1777)
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    monkeypatch.setattr(tempfile, "tempdir", str(shared))
    return home, shared


def user_folder(shared: Path) -> Path:
    return shared / f"wrsim-{os.getuid()}"


@OF_OWNERS
def test_the_cache_is_the_users_own_and_shut_to_others(places: tuple[Path, Path]) -> None:
    home, _ = places
    folder = cache_folder("kernels-1")
    assert folder == str(home / "wrsim/kernels-1")
    assert os.stat(folder).st_mode & 0o777 == 0o700
    (home / "wrsim").chmod(0o775)  # as an older version left it
    assert cache_folder("kernels-1") == str(home / "wrsim/kernels-1")
    assert is_private(str(home / "wrsim"))


@OF_OWNERS
def test_a_shared_directory_holds_a_folder_of_the_users_own_or_none(places: tuple[Path, Path]) -> None:
    home, shared = places
    (home / "wrsim").write_text("no folder can be made there")
    folder = cache_folder("kernels-1")
    assert folder == str(user_folder(shared) / "kernels-1")
    assert user_folder(shared).stat().st_mode & 0o777 == 0o700


@OF_OWNERS
@pytest.mark.parametrize("planted", ["open", "link", "somebody else's"])
def test_what_another_user_could_have_planted_is_not_used(places, planted, monkeypatch, capsys):
    home, shared = places
    (home / "wrsim").write_text("no folder can be made there")
    evil = shared / "evil"
    (evil / "kernels-1").mkdir(parents=True)
    if planted == "open":  # the folder of the kernels itself can be written to by all
        cache_folder("kernels-1")
        (user_folder(shared) / "kernels-1").chmod(0o777)
    elif planted == "link":
        user_folder(shared).symlink_to(evil)
    else:
        monkeypatch.setattr(os, "getuid", lambda: os.stat(evil).st_uid + 1)
        user_folder(shared).mkdir(mode=0o700)
    assert cache_folder("kernels-1") is None
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert "compiled anew in every process" in message


@OF_OWNERS
def test_a_directory_where_others_can_swap_folders_is_not_used(places: tuple[Path, Path]) -> None:
    home, shared = places
    home.chmod(0o777)
    assert cache_folder("kernels-1") == str(user_folder(shared) / "kernels-1")
    home.chmod(0o1777)
    assert cache_folder("kernels-1") == str(home / "wrsim/kernels-1")


@OF_OWNERS
def test_without_a_safe_place_kernels_work_and_leave_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "home").write_text("a file")
    shared = tmp_path / "shared"
    shared.mkdir()
    (shared / f"wrsim-{os.getuid()}").write_text("a file")
    code = "import numpy as np; from wrsim.jit.dense import factorise; factorise(np.eye(2), 2, np.ones(2))"
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "home"), "TMPDIR": str(shared)}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr.count("wrsim: neither") == 1
    assert [p.name for p in shared.iterdir()] == [f"wrsim-{os.getuid()}"]
