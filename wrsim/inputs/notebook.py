"""What objects look like in notebooks: a heading, rows of a name and a value, and what follows them."""

from collections.abc import Iterable
from html import escape


def card(title: str, rows: Iterable[tuple[str, object]], more: str = "") -> str:
    """HTML of a heading over rows; more: HTML beneath. Texts are escaped."""
    row = "<tr><th scope='row' style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>"
    cells = "".join(row.format(escape(name), escape(str(value))) for name, value in rows)
    return f"<div><strong>{escape(title)}</strong><table>{cells}</table>{more}</div>"


def folded(label: str, text: str) -> str:
    """HTML of a text that is shown on a click on the words."""
    return f"<details><summary>{escape(label)}</summary><pre>{escape(text)}</pre></details>"
