"""How many random examples a law is tried on: a quarter in the suite, all in the campaign (profile ``long``)."""

from hypothesis import settings

ALL = 100
"""Of a law that names no number."""

settings.register_profile("wrsim", deadline=None, derandomize=True, max_examples=ALL // 4)
settings.register_profile("long", deadline=None, derandomize=True, max_examples=ALL)


def examples(most: int) -> int:
    """Of ``most`` that the campaign tries."""
    return most if settings().max_examples >= ALL else max(most // 4, 6)
