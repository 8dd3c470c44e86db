"""Topology of a linkage: links and the joints between them and to the ground."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.model_text import short_repr

End = Literal["start", "end"]


@dataclass(frozen=True)
class Link:
    """A straight link; its frame has the origin at its start and x towards its end.

    Parameters
    ----------
    name : str
        Name used in model files and results, for example ``"coupler"``.
    length : float
        Distance between the two ends in m.
    rigid : bool
        Whether it has mass and inertia but no elastic coordinates.
    """

    name: str
    length: float
    rigid: bool = False


@dataclass(frozen=True)
class LinkEnd:
    """One end of a link, by the link's name."""

    link: str
    end: End


@dataclass(frozen=True)
class Clamp:
    """A link end welded to the driven shaft: it turns with it, and moves with its hub.

    Parameters
    ----------
    joint : str
    link_end : LinkEnd
    hub : float
        Distance in m by which the end lies beyond the shaft's axis, along the link's frame.
    free : bool
        Whether the shaft's rotation against its prescribed angle is a coordinate of the linkage; it
        is held at zero where not, and the end neither moves nor turns in the link frame.
    """

    joint: str
    link_end: LinkEnd
    hub: float = 0.0
    free: bool = False


@dataclass(frozen=True)
class Pivot:
    """A link end pinned to the ground: no displacement, free rotation.

    Parameters
    ----------
    joint : str
    link_end : LinkEnd
    sprung : bool
        Whether it has springs in place of a rigid bearing: the rigid linkage
        turns about the ground pivot, the elastic link's end moves against it.
    """

    joint: str
    link_end: LinkEnd
    sprung: bool = False


@dataclass(frozen=True)
class Pin:
    """Two coincident link ends; the displacement is a coordinate of the leader.

    Parameters
    ----------
    joint : str
    leader, follower : LinkEnd
    sprung : bool
        Whether it has springs in place of a rigid bearing: they
        share their position in the rigid linkage, and move against each other elastically.
    """

    joint: str
    leader: LinkEnd
    follower: LinkEnd
    sprung: bool = False


@dataclass(frozen=True)
class Weld:
    """Two coincident link ends with a constant angle between their links."""

    joint: str
    leader: LinkEnd
    follower: LinkEnd


@dataclass(frozen=True)
class Slider:
    """A link end that stays on a straight line of the ground or of a rigid link.

    Parameters
    ----------
    joint : str
    link_end : LinkEnd
        The end that slides; it may turn against the line.
    direction : float
        Angle of the line to the ground's x axis, or to that of the guiding link's frame, in rad.
    offset : float
        Distance of the line from the origin of those axes in m, to the left of its direction.
    guide : str
        Rigid link that carries the line; empty for the ground.
    """

    joint: str
    link_end: LinkEnd
    direction: float
    offset: float = 0.0
    guide: str = ""


@dataclass(frozen=True)
class Topology:
    """Links and the connections between them.

    Parameters
    ----------
    links : tuple of Link
    clamps, pivots, pins, welds, sliders : tuple
        Connections. A link end is fixed, slides or is a follower at most once.

    Raises
    ------
    InputError
        If a connection names an unknown link, an end is constrained twice, or a line is on a link
        that is not rigid.
    """

    links: tuple[Link, ...]
    clamps: tuple[Clamp, ...] = ()
    pivots: tuple[Pivot, ...] = ()
    pins: tuple[Pin, ...] = ()
    welds: tuple[Weld, ...] = ()
    sliders: tuple[Slider, ...] = ()

    def __post_init__(self) -> None:
        names = self.link_names
        if len(set(names)) != len(names):
            raise InputError(f"link names must differ, got {names}")
        bound = [*self._grounded_ends, *(tie.follower for tie in self.ties)]
        for place in [*bound, *(tie.leader for tie in self.ties)]:
            if place.link not in names:
                raise InputError(f"a connection names link {place.link!r}; links are {names}")
        if len(set(bound)) != len(bound):
            raise InputError("a link end depends on two joints; make it the leader in one")
        rigid = [link.name for link in self.links if link.rigid]
        for slider in self.sliders:
            if slider.guide and slider.guide not in rigid:
                raise InputError(
                    f"slider {slider.joint}: the link {slider.guide!r} that guides it is not one "
                    f"of the rigid links {tuple(rigid)}; make it rigid, or guide it on the ground"
                )

    def __repr__(self) -> str:
        links, joints = ", ".join(self.link_names), ", ".join(self.joint_names)
        return short_repr(self, f"links {links}", f"joints {joints}")

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links in order."""
        return tuple(link.name for link in self.links)

    @property
    def joints(self) -> dict[str, LinkEnd]:
        """Name of each joint and its link end: the one on the ground, or the leader."""
        places = {clamp.joint: clamp.link_end for clamp in self.clamps}
        places |= {tie.joint: tie.leader for tie in self.ties}
        places |= {slider.joint: slider.link_end for slider in self.sliders}
        return places | {pivot.joint: pivot.link_end for pivot in self.pivots}

    @property
    def ties(self) -> tuple[Pin | Weld, ...]:
        """Connections of two links: pins, then welds."""
        return (*self.pins, *self.welds)

    @property
    def _grounded_ends(self) -> list[LinkEnd]:
        """Link ends that are fixed to the ground, or slide on a line."""
        joints: tuple[Clamp | Pivot | Slider, ...] = (*self.clamps, *self.pivots, *self.sliders)
        return [joint.link_end for joint in joints]

    @cached_property
    def joined_ends(self) -> frozenset[LinkEnd]:
        """Link ends at a joint: all but free tips."""
        tied = [place for tie in self.ties for place in (tie.leader, tie.follower)]
        return frozenset(self._grounded_ends + tied)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints: clamps, pins, welds, sliders, pivots."""
        return tuple(self.joints)

    @property
    def joint_kinds(self) -> tuple[str, ...]:
        """Kind of each joint: ``clamp``, ``pin``, ``weld``, ``slider`` or ``pivot``."""
        kinds = {clamp.joint: "clamp" for clamp in self.clamps}
        kinds |= {pin.joint: "pin" for pin in self.pins}
        kinds |= {weld.joint: "weld" for weld in self.welds}
        kinds |= {slider.joint: "slider" for slider in self.sliders}
        kinds |= {pivot.joint: "pivot" for pivot in self.pivots}
        return tuple(kinds[name] for name in self.joint_names)

    @property
    def joint_sides(self) -> tuple[tuple[str, str], ...]:
        """For each joint the link on which its force acts, and what exerts it.

        That is the shaft at a clamp, the ground at a pivot or a slider, the guiding link of a
        slider, and the leading link of a pin or a weld.
        """
        sides = {clamp.joint: (clamp.link_end.link, "shaft") for clamp in self.clamps}
        sides |= {tie.joint: (tie.follower.link, tie.leader.link) for tie in self.ties}
        sides |= {
            slider.joint: (slider.link_end.link, slider.guide or "ground")
            for slider in self.sliders
        }
        sides |= {pivot.joint: (pivot.link_end.link, "ground") for pivot in self.pivots}
        return tuple(sides[name] for name in self.joint_names)

    @property
    def sprung_joints(self) -> set[str]:
        """Pins and pivots that have springs in place of a rigid bearing."""
        pins = {pin.joint for pin in self.pins if pin.sprung}
        return pins | {pivot.joint for pivot in self.pivots if pivot.sprung}

    def index(self, link: str) -> int:
        """Position of a link in ``links``."""
        return self.link_names.index(link)

    def end_place(self, end: LinkEnd) -> tuple[int, float]:
        """Number of the link of an end, and the end's distance from the link's start in m."""
        link = self.index(end.link)
        return link, 0.0 if end.end == "start" else self.links[link].length

    @property
    def has_moving_guides(self) -> bool:
        """Whether lines of sliders are on links, and so rotate."""
        return any(slider.guide for slider in self.sliders)

    def leader_of(self, place: LinkEnd) -> LinkEnd:
        """Leader of a link end through pins and welds."""
        return leading_end(place, self.ties)

    def with_rigid_joints(self) -> Topology:
        """The topology with rigid pins and pivots in place of springs."""
        pins = tuple(replace(pin, sprung=False) for pin in self.pins)
        pivots = tuple(replace(pivot, sprung=False) for pivot in self.pivots)
        return replace(self, pins=pins, pivots=pivots)

    def with_free_shaft(self) -> Topology:
        """The same, with the shaft's rotation as a coordinate of the linkage."""
        return replace(self, clamps=tuple(replace(clamp, free=True) for clamp in self.clamps))

    def with_elastic(self, names: Collection[str]) -> Topology:
        """The topology with some rigid links as elastic ones."""
        links = (replace(k, rigid=k.rigid and k.name not in names) for k in self.links)
        return replace(self, links=tuple(links))

    @property
    def rigid_ties(self) -> tuple[Pin | Weld, ...]:
        """Pins and welds without sprung pins."""
        return tuple(tie for tie in self.ties if not (isinstance(tie, Pin) and tie.sprung))

    @property
    def pinned_ends(self) -> dict[str, tuple[LinkEnd, LinkEnd | None]]:
        """Follower and leader of each pin, by joint; of each pivot its end, and None."""
        ends: dict[str, tuple[LinkEnd, LinkEnd | None]] = {
            pin.joint: (pin.follower, pin.leader) for pin in self.pins
        }
        return ends | {pivot.joint: (pivot.link_end, None) for pivot in self.pivots}

    @property
    def turning_ends(self) -> dict[str, tuple[LinkEnd, LinkEnd | None]]:
        """:attr:`pinned_ends`, and of each slider the end that turns in its block, and None."""
        return self.pinned_ends | {slider.joint: (slider.link_end, None) for slider in self.sliders}

    def joint_angle(self, joint: str, angles: FloatArray) -> FloatArray:
        """Angle of a pin or pivot, or its rate from angular velocities.

        Parameters
        ----------
        joint : str
        angles : ndarray, shape (..., n_links)
            Angles of the links in rad, or their rates in rad/s.

        Returns
        -------
        ndarray, shape (...)
            That of the following link less that of the leading one, or that of a pivoted link.
        """
        follower, leader = self.pinned_ends[joint]
        angle: FloatArray = angles[..., self.index(follower.link)]
        return angle if leader is None else angle - angles[..., self.index(leader.link)]


def leading_end(place: LinkEnd, ties: Iterable[Pin | Weld]) -> LinkEnd:
    """Leader of a link end through a sequence of ties.

    Parameters
    ----------
    place : LinkEnd
    ties : iterable of Pin or Weld

    Returns
    -------
    LinkEnd
        The place itself where it is no follower.

    Raises
    ------
    InputError
        If the ties lead in a circle.
    """
    leaders = {tie.follower: tie.leader for tie in ties}
    seen = {place}
    while place in leaders:
        place = leaders[place]
        if place in seen:
            raise InputError(f"pins and welds lead in a circle at {place}")
        seen.add(place)
    return place
