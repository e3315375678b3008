"""Writes docs/keys.md and docs/schema/*.json from the sections of the code. Run: python docs/make_keys.py"""

from __future__ import annotations

from pathlib import Path

from wrsim.cli.keys import FILES, schema_text, tables_of
from wrsim.inputs.reference import markdown

HERE = Path(__file__).parent
HEAD = """# Keys
Every key of every file, made from the code by `python docs/make_keys.py`; a test fails when this page is stale.
`wrsim keys contact` prints a table of it, `wrsim new curving` writes a scenario to start from.

Editors complete and check keys by the schemas in `docs/schema`. With Taplo or "Even Better TOML" (VS Code) that works
in this repository at once (`.taplo.toml`). Elsewhere write the schema beside your files (`wrsim keys --schema >
scenario.schema.json`) and begin a scenario with the line `#:schema ./scenario.schema.json`.

"needed": the key has no default; "none": left out, something else decides, as the row says.
"""


def pages() -> dict[Path, str]:
    """Content of every generated file, by its path."""
    lines = [HEAD]
    shown: set[type] = set()
    for name, (words, _) in FILES.items():
        lines += [f"## {words[0].upper()}{words[1:]}", ""]
        for table in tables_of(name):
            if table not in shown:
                lines += markdown(table)
            shown.add(table)
    found = {HERE / "keys.md": "\n".join(lines).rstrip() + "\n"}
    return found | {HERE / "schema" / f"{name}.schema.json": schema_text(name) + "\n" for name in FILES}


if __name__ == "__main__":
    for path, text in pages().items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path)
