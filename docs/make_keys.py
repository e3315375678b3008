"""Writes docs/keys.md and docs/schema/*.json from the sections of the code. Run: python docs/make_keys.py"""

from __future__ import annotations

from pathlib import Path

from wrsim.inputs.reference import entries, heading, purpose
from wrsim.inputs.section import Section
from wrsim.register import FILES
from wrsim.scenario.reference import schema_text, tables_of_file

HERE = Path(__file__).parent
HEAD = """# Keys
Every key of every file, made from the code by `python docs/make_keys.py`; a test fails when this page is stale.
`wrsim keys contact` prints the keys of a table, `wrsim new curving` writes a scenario to start from.

"needed": the key has no default; "none": left out, something else decides, as the row says.

## In an editor
An editor offers the keys of a table and their allowed words while you type, shows what a key is, and underlines what
is wrong. It does so by the schemas in `docs/schema`. In VS Code install the extension "Even Better TOML"; other editors
use its language server, [Taplo](https://taplo.tamasfe.dev). On the command line `taplo lint scenarios/*.toml` checks
likewise (`pip install taplo`). In the folder of wrsim all this works at once, by the file `.taplo.toml`. Elsewhere
write the schema beside your files and begin each scenario with a line that names it:

```sh
wrsim keys --schema > scenario.schema.json
```

```text
#:schema ./scenario.schema.json
```

`wrsim keys --file vehicle --schema` gives that of vehicle files; there are also `wheelset`, `train`, `track`,
`profile` (wheels and rails), `columns` (of a recording), `study` and `service`. Keys that go together, such as one
radius or two, are beyond a schema: `wrsim check FILE` tells of them.
"""


def markdown(section: type[Section], level: str = "###") -> list[str]:
    """Heading, purpose and keys of one table."""
    lines = [f"{level} {heading(section)}", "", *purpose(section), ""]
    own = entries(section)
    if own:
        heads = ("key", "what it is", "default", "also understood as")
        lines += [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
        for e in own:
            example = f" *Example:* {_code(e.example)}" if e.example and e.example != e.default else ""
            cells = [
                f"`{e.key}`" + (f" [{e.unit}]" if e.unit else ""),
                f"{e.meaning} *Must be* {e.allowed}.{example}",
                _code(e.default),
                ", ".join(map(_code, e.aliases)),
            ]
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return lines


def _code(text: str) -> str:
    if text in ("needed", "none", ""):
        return text
    return f"`{text}`"


def pages() -> dict[Path, str]:
    """Content of every generated file, by its path."""
    lines = [HEAD]
    shown: set[type] = set()
    for name, (words, _) in FILES.items():
        lines += [f"## {words[0].upper()}{words[1:]}", ""]
        for table in tables_of_file(name):
            if table not in shown:
                own = markdown(table)
                lines += own[2:] if table.header == words else own  # the file itself has its heading
            shown.add(table)
    found = {HERE / "keys.md": "\n".join(lines).rstrip() + "\n"}
    return found | {HERE / "schema" / f"{name}.schema.json": schema_text(name) + "\n" for name in FILES}


if __name__ == "__main__":
    for path, text in pages().items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path)
