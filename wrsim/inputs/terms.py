"""Names that are understood by other terms for them: those of reports, of the reference and of the field."""

import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Annotated, Any, Literal

MOST_NEAR = 5


def normalised(term: str) -> str:
    """Letters and digits of a term, small, without accents and indices, with one stroke between words."""
    letters = unicodedata.normalize("NFKD", term).lower().replace("/", " over ")
    return "_".join("".join(c if c.isalnum() else " " for c in letters if not unicodedata.combining(c)).split())


@dataclass(frozen=True)
class Names:
    """Names with other terms for each; rank: of names that share a term the one of the lowest rank has it."""

    terms: Mapping[str, Sequence[str]]
    rank: Callable[[str], Any] = lambda name: 0

    def among(self, known: Iterable[str]) -> "Names":
        """Those of these names alone."""
        return Names({name: self.terms.get(name, ()) for name in known}, self.rank)

    def understood(self, word: str) -> str | None:
        """The name that a word means: itself, or the only one of its rank that has this term."""
        wanted = normalised(word)
        means = [name for name in self.terms if wanted in map(normalised, (name, *self.terms[name]))]
        best = [name for name in means if self.rank(name) == min(map(self.rank, means))]
        return word if word in self.terms else best[0] if len(best) == 1 else None

    def unknown(self, word: str) -> str:
        """What follows a word that means none of these names: the nearest ones."""
        wanted = normalised(word)

        def likeness(name: str) -> float:
            return max(SequenceMatcher(None, wanted, normalised(term)).ratio() for term in (name, *self.terms[name]))

        near = [f'"{name}"' for name in sorted(self.terms, key=likeness, reverse=True)[:MOST_NEAR]]
        return f"is none of {len(self.terms)} names; the nearest are {', '.join(near) or 'none'}"

    def key(self) -> Any:
        """Type of a key that holds one of the names, or a term for it."""
        from pydantic import BeforeValidator  # commands that read no file start without it

        from wrsim.inputs.values import refuse

        def check(value: Any) -> Any:
            if not isinstance(value, str):
                return value
            if (name := self.understood(value)) is None:
                raise refuse(self.unknown(value))
            return name

        return Annotated[Literal[*self.terms], BeforeValidator(check)]
