"""Sections of NumPy docstrings: what they say of each name, read and extended.

Commands take their help from them, JSON schemas their descriptions, and functions that ask for the
fields of a request have those entries as their own.
"""

from __future__ import annotations

import inspect
import re

_HEADING = "Parameters\n----------\n"
_NEXT_HEADING = re.compile(r"\n\n(?=\w[\w ]*\n-{3,}\n)")


def entries(doc: str, heading: str = _HEADING) -> dict[str, tuple[str, str]]:
    """Entries of a section of a NumPy docstring.

    Parameters
    ----------
    doc : str
    heading : str
        Heading of the section, with its line.

    Returns
    -------
    dict of str to tuple of str
        What stands behind the colon, and the text, by name.
    """
    section = _NEXT_HEADING.split(inspect.cleandoc(doc).partition(heading)[2])[0]
    found: dict[str, tuple[str, str]] = {}
    for entry in filter(None, re.split(r"\n+(?=\S)", section.strip("\n"))):
        head, _, text = entry.partition("\n")
        names, _, kind = head.partition(" : ")
        found |= dict.fromkeys(names.split(", "), (kind, inspect.cleandoc(text)))
    return found


def with_entries(doc: str, further: dict[str, tuple[str, str]]) -> str:
    """A docstring with further parameters behind its own, which stay where both name one.

    Parameters
    ----------
    doc : str
    further : dict of str to tuple of str
        As of :func:`entries`.

    Returns
    -------
    str
    """
    before, _, section = inspect.cleandoc(doc).partition(_HEADING)
    known = entries(doc)
    first, *rest = _NEXT_HEADING.split(section) if section else ["", ""]
    added = [
        "\n    ".join([f"{name} : {kind}" if kind else name, *text.splitlines()])
        for name, (kind, text) in further.items()
        if name not in known
    ]
    listed = "\n".join(filter(None, [first.rstrip(), *added]))
    return "\n\n".join([f"{before.rstrip()}\n\n{_HEADING}{listed}", *filter(None, rest)])
