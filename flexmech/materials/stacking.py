"""The notation of a stack, such as ``[C/G@45*2/C]s``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby

from flexmech.errors import InputError
from flexmech.units import NUMBER, parse_number

_STACK = re.compile(r"\s*\[(?P<inside>[^\[\]]*)\]\s*(?P<mirror>[sS]?)\s*")
_ITEM = re.compile(
    rf"\s*(?P<ply>[^@*\s]+)\s*(?:@\s*(?P<angle>{NUMBER})\s*)?(?:\*\s*(?P<count>[0-9]+)\s*)?"
)
# What separates layers and their parts.
_OWN = re.compile(r"[\s/@*\[\]]+")
# A hundred times those of real laminates; each layer is a column of a section's profile.
MOST_LAYERS = 1000
_EXAMPLE = "write plies between slashes, as in '[C/G@45/C]', '[C@0/C@90*2]s'"


def parse_stacking(text: str) -> list[tuple[str, float | None]]:
    """Plies of a stack from the lowest up, with their angles in degrees where they are given.

    Parameters
    ----------
    text : str
        Ply names between slashes in square brackets; ``@`` gives the fibre angle in
        degrees, ``*`` repeats a layer, a final ``s`` mirrors the stack.

    Returns
    -------
    list of tuple
        Name and angle, or None, of each layer.

    Raises
    ------
    InputError
        If the text is no stack.
    """
    whole = _STACK.fullmatch(text)
    if whole is None:
        raise InputError(f"got {text!r}, which is no stack; {_EXAMPLE}")
    layers: list[tuple[str, float | None]] = []
    copies = 2 if whole["mirror"] else 1
    for item in whole["inside"].split("/"):
        found = _ITEM.fullmatch(item)
        if found is None:
            raise InputError(f"got {text!r}, where {item.strip()!r} is no layer; {_EXAMPLE}")
        count = int(found["count"] or 1)
        if count < 1 or copies * (len(layers) + count) > MOST_LAYERS:
            raise InputError(
                f"got {text!r}: a layer is repeated once or more, and a stack has at most "
                f"{MOST_LAYERS} layers; write fewer"
            )
        angle = None if found["angle"] is None else float(parse_number(found["angle"]))
        layers += [(found["ply"], angle)] * count
    return layers + layers[::-1] if whole["mirror"] else layers


def stacking_text(layers: Sequence[tuple[str, float]], digits: int = 6) -> str:
    """Write a stack in the notation that :func:`parse_stacking` reads.

    Parameters
    ----------
    layers : sequence of tuple
        Name and angle in degrees of each layer, from the lowest up.
    digits : int
        Significant digits of the angles.

    Returns
    -------
    str
        As short as the notation allows; angles of zero are left out. What the notation uses
        itself, such as a slash, becomes a low line in names.
    """
    half = len(layers) // 2
    mirrored = len(layers) % 2 == 0 and list(layers[:half]) == list(layers[half:])[::-1]
    runs = [
        _OWN.sub("_", name or "ply")
        + (f"@{angle:.{digits}g}" if angle else "")
        + (f"*{count}" if count > 1 else "")
        for (name, angle), count in (
            (layer, len(list(run))) for layer, run in groupby(layers[:half] if mirrored else layers)
        )
    ]
    return f"[{'/'.join(runs)}]{'s' * mirrored}"
