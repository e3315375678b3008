"""Compiled kernels are loaded from no folder that somebody else could have written to."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from wrsim.core.jit.cache import cache_folder, is_private

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes are of another kind here")


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


def own(shared: Path) -> Path:
    return shared / f"wrsim-{os.getuid()}"


def test_the_users_cache_comes_first_and_is_shut_to_others(places: tuple[Path, Path]) -> None:
    home, _ = places
    folder = cache_folder("kernels-1")
    assert folder == str(home / "wrsim/kernels-1")
    assert os.stat(folder).st_mode & 0o777 == 0o700


def test_the_folder_in_the_shared_directory_is_the_users_own(places: tuple[Path, Path]) -> None:
    home, shared = places
    (home / "wrsim").write_text("no folder can be made there")
    folder = cache_folder("kernels-1")
    assert folder == str(own(shared) / "kernels-1")
    assert own(shared).stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("planted", ["open", "link", "somebody else's"])
def test_what_another_user_could_have_planted_is_not_used(
    places: tuple[Path, Path], planted: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    home, shared = places
    (home / "wrsim").write_text("no folder can be made there")
    evil = shared / "evil"
    (evil / "kernels-1").mkdir(parents=True)
    if planted == "open":  # the folder of the kernels itself can be written to by all
        cache_folder("kernels-1")
        (own(shared) / "kernels-1").chmod(0o777)
    elif planted == "link":
        own(shared).symlink_to(evil)
    else:
        monkeypatch.setattr(os, "getuid", lambda: os.stat(evil).st_uid + 1)
        own(shared).mkdir(mode=0o700)
    assert cache_folder("kernels-1") is None
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert "compiled anew in every process" in message


def test_a_directory_where_others_can_swap_folders_is_not_used(places: tuple[Path, Path]) -> None:
    home, shared = places
    home.chmod(0o777)
    assert cache_folder("kernels-1") == str(own(shared) / "kernels-1")
    home.chmod(0o1777)
    assert cache_folder("kernels-1") == str(home / "wrsim/kernels-1")


def test_a_folder_that_an_older_version_left_open_is_shut(places: tuple[Path, Path]) -> None:
    home, _ = places
    (home / "wrsim").mkdir()
    (home / "wrsim").chmod(0o775)
    assert cache_folder("kernels-1") == str(home / "wrsim/kernels-1")
    assert is_private(str(home / "wrsim"))


def test_without_a_safe_place_kernels_work_and_leave_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "home").write_text("a file")
    shared = tmp_path / "shared"
    shared.mkdir()
    (shared / f"wrsim-{os.getuid()}").write_text("a file")
    code = "import numpy as np; from wrsim.core.dense import factorise; factorise(np.eye(2), 2, np.ones(2))"
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "home"), "TMPDIR": str(shared)}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr.count("wrsim: neither") == 1
    assert [p.name for p in shared.iterdir()] == [f"wrsim-{os.getuid()}"]
