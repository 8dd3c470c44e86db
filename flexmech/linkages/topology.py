"""How links are held and joined: plain data that every engine reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from flexmech.errors import InputError
from flexmech.short_repr import short_repr

__all__ = ["Clamp", "End", "Link", "LinkEnd", "Pin", "Pivot", "Topology"]

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
    """

    name: str
    length: float


@dataclass(frozen=True)
class LinkEnd:
    """One end of a link, by the link's name."""

    link: str
    end: End


@dataclass(frozen=True)
class Clamp:
    """A link end welded to the driven shaft: neither moves nor turns in the link frame."""

    joint: str
    held: LinkEnd


@dataclass(frozen=True)
class Pivot:
    """A link end pinned to the ground: does not move, may turn."""

    joint: str
    held: LinkEnd


@dataclass(frozen=True)
class Pin:
    """Two link ends that share their position; the leader's frame carries the displacement."""

    joint: str
    leader: LinkEnd
    follower: LinkEnd


@dataclass(frozen=True)
class Topology:
    """Links and the connections between them.

    Parameters
    ----------
    links : tuple of Link
    clamps, pivots, pins : tuple
        Connections. A link end is held or follows at most once.

    Raises
    ------
    InputError
        If a connection names an unknown link or an end is held twice.
    """

    links: tuple[Link, ...]
    clamps: tuple[Clamp, ...] = ()
    pivots: tuple[Pivot, ...] = ()
    pins: tuple[Pin, ...] = ()

    def __post_init__(self) -> None:
        names = self.link_names
        if len(set(names)) != len(names):
            raise InputError(f"link names must differ, got {names}")
        held = [clamp.held for clamp in self.clamps] + [pivot.held for pivot in self.pivots]
        bound = held + [pin.follower for pin in self.pins]
        for place in bound + [pin.leader for pin in self.pins]:
            if place.link not in names:
                raise InputError(f"a connection names link {place.link!r}; links are {names}")
        if len(set(bound)) != len(bound):
            raise InputError("a link end is held or led twice; make one connection the leader")

    def __repr__(self) -> str:
        links, joints = ", ".join(self.link_names), ", ".join(self.joint_names)
        return short_repr(self, f"links {links}", f"joints {joints}")

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links in order."""
        return tuple(link.name for link in self.links)

    @property
    def joints(self) -> dict[str, LinkEnd]:
        """Name of each joint and the link end that carries it: held or leading."""
        places = {clamp.joint: clamp.held for clamp in self.clamps}
        places |= {pin.joint: pin.leader for pin in self.pins}
        return places | {pivot.joint: pivot.held for pivot in self.pivots}

    @property
    def joined_ends(self) -> frozenset[LinkEnd]:
        """Link ends at a joint: all but free tips."""
        held = [clamp.held for clamp in self.clamps] + [pivot.held for pivot in self.pivots]
        pinned = [place for pin in self.pins for place in (pin.leader, pin.follower)]
        return frozenset(held + pinned)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints: clamps, pins, pivots."""
        return tuple(self.joints)

    @property
    def joint_kinds(self) -> tuple[str, ...]:
        """What each joint is: ``clamp``, ``pin`` or ``pivot``."""
        kinds = {clamp.joint: "clamp" for clamp in self.clamps}
        kinds |= {pin.joint: "pin" for pin in self.pins}
        kinds |= {pivot.joint: "pivot" for pivot in self.pivots}
        return tuple(kinds[name] for name in self.joint_names)

    def index(self, link: str) -> int:
        """Position of a link in ``links``."""
        return self.link_names.index(link)

    def leader_of(self, place: LinkEnd) -> LinkEnd:
        """Follow the pins from a link end to the end that carries its displacement."""
        leaders = {pin.follower: pin.leader for pin in self.pins}
        seen = {place}
        while place in leaders:
            place = leaders[place]
            if place in seen:
                raise InputError(f"the pins lead in a circle at {place}")
            seen.add(place)
        return place
