"""What objects look like in notebooks: a heading, rows of a name and a value, and what follows them."""

from collections.abc import Iterable

from markupsafe import Markup


def card(title: str, rows: Iterable[tuple[str, object]], more: str = "") -> str:
    """HTML of a heading over rows; more: HTML beneath. Texts are escaped."""
    row = Markup("<tr><th scope='row' style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>")
    cells = Markup("").join(row.format(name, value) for name, value in rows)
    return Markup("<div><strong>{}</strong><table>{}</table>{}</div>").format(title, cells, Markup(more))


def folded(words: str, text: str) -> str:
    """HTML of a text that is shown on a click on the words."""
    return Markup("<details><summary>{}</summary><pre>{}</pre></details>").format(words, text)
