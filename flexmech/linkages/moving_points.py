"""Points of a linkage that move, by the names that its user knows."""

from __future__ import annotations

from flexmech.linkages.linkage import Linkage
from flexmech.linkages.planar import PlanarLinkage
from flexmech.linkages.topology import LinkEnd, Topology


def moving_points(linkage: Linkage) -> dict[str, LinkEnd]:
    """Named points that are not of the ground, each with a link end that is there.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    dict of str to LinkEnd
        Of a drawing its points; of other linkages the pins and sliders, each place once, and free
        ends of links, called tips. None of a frame that stands still.
    """
    if isinstance(linkage, PlanarLinkage):
        drawing = linkage.drawing
        if drawing.is_stationary:
            return {}
        moving = (name for name in drawing.points if name not in drawing.ground)
        return {name: next(iter(drawing.ends_at(name).values()))[0] for name in moving}
    topology = linkage.topology
    sliders = {slider.joint: slider.link_end for slider in topology.sliders}
    return _pins(topology) | sliders | _tips(topology)


def _pins(topology: Topology) -> dict[str, LinkEnd]:
    """Leaders of pins, each place once."""
    pins = {tie.joint: topology.leader_of(tie.leader) for tie in topology.pins}
    places = {place: joint for joint, place in reversed(pins.items())}
    return {joint: place for joint, place in pins.items() if places[place] == joint}


def _tips(topology: Topology) -> dict[str, LinkEnd]:
    """Free ends of links."""
    ends = [LinkEnd(link.name, "start") for link in topology.links]
    ends += [LinkEnd(link.name, "end") for link in topology.links]
    tips = [end for end in ends if end not in topology.joined_ends]
    return {"tip" if len(tips) == 1 else f"tip of {end.link}": end for end in tips}
