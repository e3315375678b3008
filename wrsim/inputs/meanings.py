"""What keys mean: the sentence beneath a field of a section, read from the source when somebody asks for it.

One sentence serves ``wrsim keys``, ``docs/keys.md``, the schemas of editors and ``wrsim new``::

    speed_kmh: Annotated[float, number(1, 500, "km/h")]
    \"\"\"Speed of the run.\"\"\"
"""

from __future__ import annotations

import ast
import inspect
from functools import cache
from itertools import pairwise
from textwrap import dedent

from wrsim.inputs.section import Section
from wrsim.inputs.values import fields, unpacked


@cache
def meanings(section: type[Section]) -> dict[str, str]:
    """A sentence for every key of a table that has one; a table within it speaks for itself where there is none."""
    found = {key: said for key, kind in fields(section).items() if (said := _of_table(unpacked(kind).base))}
    for kind in reversed(section.__mro__):
        if issubclass(kind, Section) and kind is not Section:
            found |= _beneath_fields(kind)
    return {key: found[key] for key in section.model_fields if key in found}


def _of_table(kind: object) -> str:
    """The first paragraph on the class of a table; empty for what is none."""
    if not (isinstance(kind, type) and issubclass(kind, Section)):
        return ""
    return " ".join((kind.__doc__ or "").partition("\n\n")[0].split())


def _beneath_fields(kind: type[Section]) -> dict[str, str]:
    """Texts beneath the fields that a class itself has; none for a class that was made without a source."""
    try:
        source = inspect.getsource(kind)
    except OSError:
        return {}
    (tree,) = ast.parse(dedent(source)).body
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    found = {}
    for field, beneath in pairwise(body):
        match field, beneath:
            case ast.AnnAssign(target=ast.Name(id=key)), ast.Expr(value=ast.Constant(value=str(text))):
                found[key] = " ".join(text.split())
    return found
