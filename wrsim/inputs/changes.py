"""Single values of a tree of tables changed by dotted keys: ``track.segments[2].radius_m``, ``bogie.primary.at_mm.1``.

Entries of lists are counted from 0, or named by their ``name``. In model files a table may be named by its own name
alone, wherever it lies, as long as there is one of that name.
"""

from collections.abc import Iterator
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.checking import dotted
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.toml_files import DEEPEST, shortened, shown_value
from wrsim.inputs.us_units import metric_key


def key_path(dotted_key: str) -> KeyPath:
    """``track.segments[2].radius_m`` -> ("track", "segments", 2, "radius_m"). Raises InputError."""
    if not isinstance(dotted_key, str) or dotted_key.count(".") + dotted_key.count("[") > DEEPEST:
        raise InputError(f"key {dotted_key!r:.60}: must be a text like track.segments[2].radius_m")
    path: list[str | int] = []
    for part in dotted_key.split("."):
        name, *places = part.replace("]", "").replace('"', "").split("[")
        path.append(name)
        if not all(place.isdecimal() for place in places) or not name:
            raise InputError(f"key {shown_value(dotted_key)}: must be written like track.segments[2].radius_m")
        path += [int(place) for place in places]
    return tuple(path)


def leaves(tree: Any, key: str = "", *, lists: bool = True) -> Iterator[tuple[str, Any]]:
    """All values in a tree of tables by their dotted keys. lists: of lists without tables each entry, else the list."""
    for name, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        inner = f"{key}[{name}]" if isinstance(tree, list) else f"{key}.{name}".removeprefix(".")
        tables = isinstance(value, dict) or (isinstance(value, list) and any(isinstance(each, dict) for each in value))
        if isinstance(value, dict | list) and value and (lists or tables):
            yield from leaves(value, inner, lists=lists)
        else:
            yield inner, value


def changed(data: Any, path: KeyPath, value: Any) -> Any:
    """A copy of a tree of tables with the value at a path from `full_path` replaced, or for None removed; missing
    tables are made."""
    if not path:
        return value
    first, rest = path[0], path[1:]
    if isinstance(data, list):
        return [changed(v, rest, value) if k == first else v for k, v in enumerate(data)]
    kept = {k: v for k, v in data.items() if k == first or metric_key(k) != metric_key(str(first))}
    if value is None and not rest:
        return {k: v for k, v in kept.items() if k != first}
    return {**kept, first: changed(data.get(first, {} if rest else None), rest, value)}


def full_path(data: dict[str, Any], path: KeyPath, *, by_name: bool) -> KeyPath:
    """The full path of a key: entries of lists by their numbers or names.

    by_name: tables may be named by their own names alone, and have to exist; else a missing one is a new one. Raises
    InputError where there is no such entry or table, or more than one.
    """
    full: KeyPath = ()
    tree: Any = data
    for k, part in enumerate(path):
        last = k == len(path) - 1
        if isinstance(tree, list):
            steps: KeyPath = (_entry(tree, part, full),)
        elif not isinstance(tree, dict) or isinstance(part, int):
            kind = "list" if isinstance(part, int) else "table"
            raise InputError(f"{dotted((*full, part))}: '{dotted(full)}' = {shown_value(tree, 30)} is no {kind}")
        elif part in tree or last:
            steps = (part,)
        elif by_name:
            steps = _named(tree, part, full, path[k + 1 :])
        else:
            if any(isinstance(inner, int) for inner in path[k:]):
                raise InputError(
                    f"{dotted((*full, *path[k:]))}: there is no such entry: {dotted((*full, part))} is not given"
                )
            return (*full, *path[k:])
        for step in () if last else steps:
            tree = tree[step]
        full = (*full, *steps)
    return full


def _entry(data: list[Any], part: str | int, done: KeyPath) -> int:
    """The number of an entry of a list, from 0, by itself or by its name."""
    if isinstance(part, str) and not part.isdecimal():
        names = [each.get("name", "") if isinstance(each, dict) else "" for each in data]
        if names.count(part) == 1:
            return names.index(part)
        known = [name for name in names if name]
        allowed = f"the names are {', '.join(known)}{suggest(part, known)}" if known else "entries are numbered from 0"
        raise InputError(f"{dotted((*done, part))}: {dotted(done)} has no one entry '{part}'; {allowed}")
    if int(part) >= len(data):
        several = f"there are {len(data)}, [0] to [{len(data) - 1}]"
        hint = ("it is empty", "there is [0]", several)[min(len(data), 2)]
        raise InputError(f"{dotted((*done, part))}: there is no such entry; {hint}")
    return int(part)


def _named(tree: dict[str, Any], name: str, done: KeyPath, rest: KeyPath) -> KeyPath:
    """The way from a table to the one table of a name that lies in it, however deep; rest: of the key, behind it."""
    known = list(_tables(tree, ()))
    ways = [way for table_name, way in known if table_name == name]
    if ways and all(way[: len(ways[0])] == ways[0] for way in ways):
        return ways[0]  # the others lie in it
    inside = f" in {dotted(done)}" if done else ""
    if ways:
        full = " and ".join(dotted((*done, *way)) for way in ways)
        raise InputError(f"there are {len(ways)} of the name '{name}'{inside}: {full}; write more of it")
    names = list(dict.fromkeys(table_name for table_name, _ in known))
    listed = shortened(", ".join(names or tree), 300)
    near, known_words = suggest(name, [*names, *tree]), f"there is {listed or 'no table'}"
    whole = f"; a new table is given as a whole, such as {dotted((*done, name))}={{{dotted(rest)} = ...}}"
    whole = f"; it is a place of '{tree['part']}', whose tables all its places share" if "part" in tree else whole
    raise InputError(f"there is no '{name}'{inside}{near}; {known_words}{whole if done and not near else ''}")


def _tables(tree: dict[str, Any], path: KeyPath) -> Iterator[tuple[str, KeyPath]]:
    """Names of all tables in a tree, each with the way to it."""
    for key, value in tree.items():
        branch = (*path, key)
        if isinstance(value, dict):
            yield key, branch
            yield from _tables(value, branch)
        for i, each in enumerate(value if isinstance(value, list) else ()):
            if isinstance(each, dict):
                if isinstance(name := each.get("name"), str):
                    yield name, (*branch, i)
                yield from _tables(each, (*branch, i))
