"""Where loads and springs act along a link."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from flexmech.linkages import LEAST_DISTANCE, LinkPoint


def places_apart(
    points: Iterable[LinkPoint], link: str, length: float, taken: Sequence[float]
) -> list[float]:
    """Places of points on a link at which a mesh can have nodes.

    Those nearer than 1/500 of the link's length to another one or to an end are left out: an
    element between them would be stiffer than round-off allows.

    Parameters
    ----------
    points : iterable of LinkPoint
        Of any links.
    link : str
    length : float
        Of the link in m.
    taken : sequence of float
        Where there are nodes already, m from the start.

    Returns
    -------
    list of float
        In m from the start.
    """
    found: list[float] = []
    for x in sorted({point.x for point in points if point.link == link}):
        others = (0.0, length, *taken, *found)
        if min(abs(x - other) for other in others) >= LEAST_DISTANCE * length:
            found.append(x)
    return found
