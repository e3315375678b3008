"""Model files inside a result: its scenario is set up anywhere, from what was computed with.

Names are those by which the files were found, in folders that have numbers in place of their paths.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PureWindowsPath
from typing import Any

from wrsim.errors import InputError
from wrsim.inputs.lookup import shipped_models, user_folders
from wrsim.inputs.toml_files import LARGEST, Kept
from wrsim.scenario.loading import Scenario, load_text

ATTRIBUTE = "model_files"
"""Attribute of results and of the header of run files."""
ROOT, SHIPPED = Path("model files of the result"), "shipped"
"""Folder of the files of a result, which is nowhere on a disk, and the name of that of the models of wrsim."""


@dataclass(frozen=True)
class KeptFiles:
    """Contents of model files by their paths; names of the folders in which they are looked up, of those of them that
    WRSIM_MODELS names, and of the files in them."""

    contents: Mapping[Path, bytes] = field(default_factory=dict)
    folders: Sequence[str] = ()
    user_folders: Sequence[str] = ()
    names: Mapping[str, Path] = field(default_factory=dict)

    @classmethod
    def of(cls, folders: Sequence[Path], contents: Mapping[Path, bytes]) -> KeptFiles:
        """Files that were found in these folders; where folders lie in each other a file has a name in each."""
        prefixes = {f: SHIPPED if f == shipped_models() else str(i) for i, f in enumerate((*folders, *user_folders()))}
        names: dict[str, Path] = {}
        for path in contents:
            inside = [folder for folder in prefixes if path.is_relative_to(folder)]
            named = {f"{prefixes[folder]}/{path.relative_to(folder).as_posix()}": path for folder in inside}
            names |= named or {path.as_posix(): path}
        users = [prefixes[folder] for folder in user_folders()]
        return cls(dict(contents), [prefixes[folder] for folder in folders], users, names)

    def packed(self) -> str:
        """All of it as a text of letters."""
        order = {path: i for i, path in enumerate(self.contents)}
        names = {name: order[path] for name, path in self.names.items()}
        texts = [content.decode("latin-1") for content in self.contents.values()]
        whole = {"folders": self.folders, "user_folders": self.user_folders, "names": names, "contents": texts}
        return base64.b64encode(zlib.compress(json.dumps(whole).encode())).decode()


def scenario_of(attributes: Mapping[str, Any], folder: str | Path, models: Sequence[str | Path] = ()) -> Scenario:
    """The scenario of a result, with the model files in it; anybody may have written both.

    attributes: of the dataset, or the header of a run file; folder, models: where model files are looked up for results
    that hold none. Raises InputError for a text that is no scenario.
    """
    if "scenario_text" not in attributes:
        raise InputError("its header has no scenario_text; run the scenario again")
    scenario = load_text(str(attributes["scenario_text"]), folder, models, closed=True)
    if ATTRIBUTE not in attributes:
        return scenario

    def folder_of(name: str) -> Path:
        return shipped_models() if name == SHIPPED else ROOT / str(int(name))

    def path(name: str) -> Path:
        first, _, rest = name.partition("/")
        return Path(name) if PureWindowsPath(name).anchor else folder_of(first) / rest

    try:
        content = zlib.decompressobj().decompress(base64.b64decode(str(attributes[ATTRIBUTE])), 2 * LARGEST)
        stored = json.loads(content)
        folders, users = (tuple(map(folder_of, stored[key])) for key in ("folders", "user_folders"))
        contents = {str(path(name)): stored["contents"][i].encode("latin-1") for name, i in stored["names"].items()}
    except (ValueError, zlib.error, LookupError, TypeError, AttributeError, RecursionError):
        raise InputError(f"its {ATTRIBUTE} are damaged; run the scenario again") from None
    return replace(scenario, finder=replace(scenario.finder, folders=folders, kept=Kept(contents, users)))
