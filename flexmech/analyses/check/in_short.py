"""What a linkage is, in one sentence."""

from __future__ import annotations

import math

import numpy as np

from flexmech.linkages import FourBar, Linkage, PlanarLinkage, assemblable

# A range of motion with a gap of less than a degree passes as a whole turn.
_TURN = np.radians(np.arange(0.0, 360.0))


def linkage_in_short(linkage: Linkage) -> str:
    """Kind and size of a linkage, whether its crank turns fully, and its transmission angle.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    str
        A sentence.

    Examples
    --------
    >>> linkage_in_short(flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667))
    'A four-bar, crank-rocker: the crank turns fully; the transmission angle is 32.21 to 81.33 deg.'
    """
    if isinstance(linkage, FourBar):
        angles = " to ".join(f"{math.degrees(a):.4g}" for a in linkage.transmission_angle_limits())
        return (
            f"A four-bar, {linkage.grashof_class}: the crank {_turns(linkage.crank_turns_fully)}; "
            f"the transmission angle is {angles} deg."
        )
    if not isinstance(linkage, PlanarLinkage):
        (arm,) = linkage.topology.links
        return f"An arm of {1e3 * arm.length:.6g} mm on a hub: it turns fully."
    if linkage.drawing.is_stationary:
        return "A frame that stands still: nothing drives it."
    return f"{_planar_kind(linkage)}: the crank {_turns(turns_fully(linkage))}."


def turns_fully(linkage: PlanarLinkage) -> bool:
    """Whether a drawn linkage has no change point and can be assembled at all whole degrees."""
    return bool(not linkage.change_angles.size and assemblable(linkage, _TURN).all())


def _planar_kind(linkage: PlanarLinkage) -> str:
    """What a drawing shows: a slider-crank with its lengths, or how many links and sliders."""
    links, topology = linkage.links, linkage.topology
    sliders = topology.sliders
    count, many = len(links), len(sliders)
    if len(topology.links) == count == 2 and many == 1 and not sliders[0].guide:
        crank, rod = (1e3 * link.length for link in topology.links)
        return f"A slider-crank of {crank:.6g} and {rod:.6g} mm"
    moving = f"A planar linkage of {count} moving link{'s' * (count > 1)}"
    return f"{moving}, {many} slider{'s' * (many > 1)}" if many else moving


def _turns(fully: bool) -> str:
    return "turns fully" if fully else "does not turn fully"
