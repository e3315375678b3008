"""`--reference FOLDER`: tables that the repository does not contain; what needs them is left out without it."""

from pathlib import Path

import pytest


def add_option(parser: pytest.Parser) -> None:
    """The option that names the folder."""
    parser.addoption("--reference", type=Path, help="folder of reference tables, for the tests marked reference")


def leave_out(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselects tests marked ``reference`` where no folder is named."""
    if config.option.reference is None and (without := [i for i in items if i.get_closest_marker("reference")]):
        config.hook.pytest_deselected(items=without)
        items[:] = [item for item in items if item not in set(without)]


@pytest.fixture(scope="session")
def reference(pytestconfig: pytest.Config) -> Path:
    """The folder that --reference names."""
    folder = pytestconfig.option.reference.resolve()
    if not (folder / "contact").is_dir():
        raise pytest.UsageError(
            f"--reference {folder}: must be the folder of reference tables; it has no folder contact"
        )
    return folder


@pytest.fixture(scope="session")
def crossing_tables(reference: Path) -> Path:
    """Tables of the crossing 56E1-R245-1:9.25."""
    return reference / "crossing_56e1"
