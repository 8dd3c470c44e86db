"""How objects show themselves: one line that says what they are."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np

__all__ = ["shapes", "short_repr"]

MOST_CHARACTERS = 160


def short_repr(record: object, *words: str) -> str:
    """Write what an object is in one line: its class, and words that are not empty."""
    line = " ".join(", ".join(word for word in words if word).split())
    if len(line) > MOST_CHARACTERS:
        line = f"{line[:MOST_CHARACTERS]}..."
    return f"<{type(record).__name__}: {line}>"


def shapes(record: object) -> tuple[str, ...]:
    """Words for the arrays that a record of the fields of a dataclass holds."""
    assert is_dataclass(record)
    held = ((field.name, getattr(record, field.name)) for field in fields(record))
    return tuple(f"{name} {value.shape}" for name, value in held if isinstance(value, np.ndarray))
