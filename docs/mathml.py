"""Sphinx extension: equations as MathML, converted when the site is built. Browsers show it without script or font.

Formulas are LaTeX: ``$x$`` in a line, ``$$ x $$ (label)`` numbered, ``{eq}`label` `` refers to it.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number

BOLD = re.compile(r'<mi mathvariant="bold(-italic)?">(?:&#x0*([0-9A-F]+);|(\w))</mi>')
"""A bold letter; browsers do not take the attribute."""

RANGES = (0x41, 0x1D400, 0x1D468), (0x61, 0x1D41A, 0x1D482), (0x391, 0x1D6A8, 0x1D71C), (0x3B1, 0x1D6C2, 0x1D736)
"""First letter of an alphabet, latin and Greek: plain, bold, bold italic."""


def letter(match: re.Match[str]) -> str:
    """The bold letter by its own code point."""
    code = int(match[2], 16) if match[2] else ord(match[3])
    for first, upright, italic in RANGES:
        if first <= code < first + 26:
            return f"<mi>{chr(code - first + (italic if match[1] else upright))}</mi>"
    return match[0]


SPACES = (
    (
        r"<msup>(<mi>[^<]*</mi>)<mi>(&#x0203[234];)</mi></msup>",
        r'<mrow>\1<mo lspace="0em" rspace="0.05em">\2</mo></mrow>',
    ),
    (r"<mo[^>]*>&#x0007C;</mo>", '<mo stretchy="false" lspace="0em" rspace="0em">|</mo>'),
    (r"(&#x0003D;</mo>)<mo>&#x02212;</mo>", r'\1<mo form="prefix" lspace="0em" rspace="0em">&#x02212;</mo>'),
    (r"<mo>&#x0002F;</mo>", '<mo lspace="0.06em" rspace="0.06em">/</mo>'),
    (r"(?<!<msup>)(<mi>(?:sin|cos|tan|ln|arcsin|arctan)</mi>)", r'<mspace width="0.167em" />\1'),
    (r"(<mi>(?:sin|cos|tan|ln|arcsin|arctan)</mi>)(?!<m[on][ >])", r'\1<mspace width="0.167em" />'),
)
"""Primes, and spaces of bars, slashes and functions, as in print: patterns of MathML and what replaces them."""


def converted(text: str, display: str) -> str:
    """MathML of a formula; a fault in it names the formula."""
    try:
        formula = BOLD.sub(letter, str(convert(text.replace("{aligned}", "{align*}"), display=display)))
        for pattern, replacement in SPACES:
            formula = re.sub(pattern, replacement, formula)
        return formula
    except Exception as problem:
        raise ValueError(f"not a formula: {text!r}: {problem!r}") from problem


def visit_inline(translator: Any, node: nodes.math) -> None:
    """A formula in a line."""
    translator.body.append(converted(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_block(translator: Any, node: nodes.math_block) -> None:
    """A formula on lines of its own, with its number where it has one."""
    translator.body.append(translator.starttag(node, "div", CLASS="math"))
    if node["number"]:
        translator.body.append(f'<span class="eqno">({get_node_equation_number(translator, node)})')
        translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append("</span>")
    translator.body.append(converted(node.astext(), "block") + "</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer under the name ``mathml``."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
