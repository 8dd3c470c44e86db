"""A planar linkage as it is drawn once: points, chains of points, joints, and its topology.

Plain data and what can be said of it without moving it. Coordinates are those of the drawing,
in ground axes.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from flexmech import si
from flexmech.arrays import SAME_PLACE
from flexmech.errors import InputError, suggestion
from flexmech.linkages.applied_forces import GROUND
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Slider, Topology, Weld
from flexmech.model_text import TomlTable
from flexmech.validation import (
    check_angle,
    check_choice,
    check_flag,
    check_instance,
    check_pair,
    checked_tuple,
)

JointKind = Literal["pin", "clamp", "weld", "slider"]
JOINT_KINDS: tuple[JointKind, ...] = ("pin", "clamp", "weld", "slider")


@dataclass(frozen=True)
class PlanarLink:
    """A link of a drawing: a chain of straight beams from point to point.

    Parameters
    ----------
    name : str
    points : tuple of str
        Two points, or a chain of more: beams that are welded to each other at the points
        between.
    rigid : bool
        Whether it has mass and inertia but does not bend.

    Examples
    --------
    >>> [beam.name for beam in flexmech.PlanarLink("coupler", ("A", "B", "C")).beams]
    ['coupler-1', 'coupler-2']
    """

    name: str
    points: tuple[str, ...]
    rigid: bool = False

    def __post_init__(self) -> None:
        names = checked_tuple(self.points, str, f"points of link {self.name}", "give their names")
        object.__setattr__(self, "points", names)
        check_flag(self.rigid, f"rigid of link {self.name}")

    @property
    def beams(self) -> tuple[Beam, ...]:
        """Its beams in order, named as the link or, in a chain, ``<link>-1``, ``<link>-2``."""
        pairs = list(zip(self.points, self.points[1:], strict=False))
        if len(pairs) == 1:
            return (Beam(self.name, *pairs[0]),)
        return tuple(Beam(f"{self.name}-{n}", *pair) for n, pair in enumerate(pairs, start=1))


@dataclass(frozen=True)
class Beam:
    """A straight piece of a link, from one point to the next."""

    name: str
    start: str
    end: str


@dataclass(frozen=True)
class PlanarJoint:
    """Joint at a point of a drawing; points without one are pins.

    Parameters
    ----------
    point : str
    kind : {"pin", "clamp", "weld", "slider"}
        ``clamp``: links are fixed to the driven shaft. ``weld``: links keep the angle between
        them. ``slider``: the point stays on a straight line, on which the links that meet there
        may turn.
    links : tuple of str
        Links that are clamped or welded; all that meet at the point if empty.
    direction : float, optional
        Direction of a slider: angle in rad of its line, which passes through the point in the
        drawing, to the ground's x axis or to that of the guide's first beam.
    guide : str
        Guide of a slider: rigid link that carries the line; the ground if empty.

    Raises
    ------
    InputError
        If the kind is unknown, a slider has no direction, or another joint has one.

    Examples
    --------
    >>> flexmech.PlanarJoint("B", "slider", direction=0.0).guide  # empty: on the ground
    ''
    """

    point: str
    kind: JointKind = "pin"
    links: tuple[str, ...] = ()
    direction: si.AngleOfTurn | None = None
    guide: str = ""

    def __post_init__(self) -> None:
        what = f"joint {self.point}"
        names = checked_tuple(self.links, str, f"{what}: links", "give their names")
        object.__setattr__(self, "links", names)
        check_instance(self.guide, str, f"{what}: guide", "give the name of a link")
        check_choice(self.kind, JOINT_KINDS, f"{what}: kind")
        if self.kind == "slider":
            if self.direction is None:
                raise InputError(
                    f"{what} is a slider without direction; give the angle of its line, such as "
                    '"0 deg"'
                )
            check_angle(self.direction, f"{what}: direction")
        elif self.direction is not None or self.guide:
            raise InputError(f"{what} is a {self.kind}; direction and guide belong to a slider")
        if self.links and self.kind not in ("clamp", "weld"):
            raise InputError(f"{what} is a {self.kind}; links belong to a clamp or a weld")

    def to_table(self) -> TomlTable:
        """Keys of the joint in a model file."""
        links = {"links": list(self.links)} if self.links else {}
        guide = {"guide": self.guide} if self.guide else {}
        return {"kind": self.kind, **links, **si.table(self), **guide}


@dataclass(frozen=True)
class Drawing:
    """Drawing of a linkage: consistent points, links and joints.

    Parameters
    ----------
    points : mapping of str to tuple of float
        Coordinates in m.
    links : tuple of PlanarLink
    joints : tuple of PlanarJoint
    ground : tuple of str
        Points that do not move.

    Raises
    ------
    InputError
        One message for what does not fit.
    """

    points: Mapping[str, tuple[float, float]]
    links: tuple[PlanarLink, ...]
    joints: tuple[PlanarJoint, ...]
    ground: tuple[str, ...]

    def __post_init__(self) -> None:
        self._check_points()
        self._check_links()
        self._check_ground()
        for joint in self.joints:
            self._check_joint(joint)
        self._check_drive()

    @property
    def size(self) -> float:
        """Largest extent of the points along an axis in m."""
        extents = (max(along) - min(along) for along in zip(*self.points.values(), strict=True))
        return float(max(extents))

    def joint(self, point: str) -> PlanarJoint:
        """Joint at a point."""
        return next((joint for joint in self.joints if joint.point == point), PlanarJoint(point))

    def links_at(self, point: str) -> tuple[str, ...]:
        """Names of the links that pass through a point."""
        return tuple(link.name for link in self.links if point in link.points)

    def link(self, name: str) -> PlanarLink:
        """Link with a name."""
        return next(link for link in self.links if link.name == name)

    def fixed_together(self, point: str) -> tuple[str, ...]:
        """Links that are clamped or welded to each other at a point."""
        joint = self.joint(point)
        if joint.kind not in ("clamp", "weld"):
            return ()
        return joint.links or self.links_at(point)

    def ends_at(self, point: str) -> dict[str, list[LinkEnd]]:
        """Ends of beams at a point, by the link that they belong to."""
        ends: dict[str, list[LinkEnd]] = {}
        for link in self.links:
            for beam in link.beams:
                if beam.start == point:
                    ends.setdefault(link.name, []).append(LinkEnd(beam.name, "start"))
                if beam.end == point:
                    ends.setdefault(link.name, []).append(LinkEnd(beam.name, "end"))
        return ends

    @property
    def is_stationary(self) -> bool:
        """Whether several clamps fix a frame to the ground, so that nothing drives it."""
        return sum(joint.kind == "clamp" for joint in self.joints) > 1

    @property
    def drive(self) -> PlanarJoint:
        """The clamp on the driven shaft; the first one of a frame that stands still."""
        return next(joint for joint in self.joints if joint.kind == "clamp")

    @property
    def crank(self) -> str:
        """First of the links on the driven shaft."""
        return self.fixed_together(self.drive.point)[0]

    def complex_point(self, point: str) -> complex:
        """Coordinates of a point as a complex number."""
        return complex(*self.points[point])

    def _check_points(self) -> None:
        for name, place in self.points.items():
            check_pair(place, f"point {name}", "m")
        names = list(self.points)
        for number, first in enumerate(names):
            for second in names[number + 1 :]:
                apart = abs(self.complex_point(first) - self.complex_point(second))
                if apart <= SAME_PLACE * self.size:
                    raise InputError(
                        f"points {first} and {second} coincide; give one point one name, and let "
                        "links meet there"
                    )

    def _check_links(self) -> None:
        names = [link.name for link in self.links]
        if not names:
            raise InputError("the linkage has no links; give at least a crank")
        for link in self.links:
            if link.name == GROUND or names.count(link.name) > 1:
                raise InputError(f"a link cannot be called {link.name!r} here; rename it")
            if len(link.points) < 2:
                raise InputError(f"link {link.name}: give the points at its two ends, or more")
            for point in link.points:
                self._check_known(f"link {link.name}", point)
                if link.points.count(point) > 1:
                    raise InputError(
                        f"link {link.name} returns to point {point}; a link is a chain that "
                        "does not, make another link of the rest and weld it on"
                    )
        for point in self.points:
            if not self.links_at(point):
                raise InputError(f"point {point} is used by no link; leave it out or join it")

    def _check_known(self, what: str, point: str) -> None:
        if point not in self.points:
            raise InputError(
                f"{what}: there is no point {point!r}; {suggestion(point, list(self.points))}"
            )

    def _check_ground(self) -> None:
        for point in self.ground:
            self._check_known("ground", point)
            if self.ground.count(point) > 1:
                raise InputError(f"ground: point {point!r} is given twice; keep one")

    def _check_joint(self, joint: PlanarJoint) -> None:
        what = f"joint {joint.point}"
        self._check_known("joints", joint.point)
        if [other.point for other in self.joints].count(joint.point) > 1:
            raise InputError(f"{what} is given twice; keep one")
        here = self.links_at(joint.point)
        for link in joint.links:
            if link not in here:
                raise InputError(
                    f"{what}: link {link!r} does not pass through it; {suggestion(link, here)}"
                )
        if joint.kind == "weld" and len(joint.links or here) < 2:
            raise InputError(f"{what} welds one link; two or more are welded to each other")
        if joint.kind == "slider":
            self._check_slider(joint, here)

    def _check_slider(self, joint: PlanarJoint, here: tuple[str, ...]) -> None:
        what = f"slider {joint.point}"
        if joint.point in self.ground:
            raise InputError(f"{what} is a point of the ground, which does not slide; remove one")
        if not joint.guide:
            return
        names = [link.name for link in self.links]
        if joint.guide not in names:
            raise InputError(
                f"{what}: no link {joint.guide!r} can guide it; {suggestion(joint.guide, names)}"
            )
        if joint.guide in here:
            raise InputError(
                f"{what}: its guide {joint.guide} passes through the point itself; a link does "
                "not slide along itself, guide it on another one"
            )
        if not self.link(joint.guide).rigid:
            raise InputError(
                f"{what}: its guide {joint.guide} is flexible; a line stays straight on a rigid "
                "link alone, write rigid = true there, or guide it on the ground"
            )

    def _check_drive(self) -> None:
        clamps = [joint for joint in self.joints if joint.kind == "clamp"]
        if not clamps:
            raise InputError(
                "no joint is a clamp, so that nothing drives the linkage; give the ground point "
                'of the crank kind = "clamp"'
            )
        for clamp in clamps:
            point, here = clamp.point, self.links_at(clamp.point)
            if point not in self.ground:
                raise InputError(f"the clamp {point} is no point of the ground; name it in ground")
            if len(here) > 1 and not clamp.links:
                raise InputError(
                    f"links {', '.join(here)} meet at the clamp {point}; say which are on the "
                    f'shaft, as links = ["{here[0]}"]'
                )


def derived_topology(drawing: Drawing, sprung: tuple[str, ...]) -> Topology:
    """Links and connections of a drawing.

    At each point one end is the leader: one of a rigid link where there is one, since flexible ends
    depend on rigid links, otherwise that of the first link. The first connection at a point has the
    point's name, further ones ``<point>-<beam>``, after the follower or the end on the ground.

    Parameters
    ----------
    drawing : Drawing
    sprung : tuple of str
        Joints with springs in place of a rigid bearing.

    Returns
    -------
    Topology

    Raises
    ------
    InputError
        If two joints would have one name.
    """
    made = _Connections(drawing, sprung)
    for point in drawing.points:
        made.at(point)
    known = {pin.joint for pin in made.pins} | {pivot.joint for pivot in made.pivots}
    unknown = set(sprung) - known
    if unknown:
        raise InputError(f"sprung joints {sorted(unknown)} are no pins or pivots of the linkage")
    return Topology(
        links=tuple(
            Link(
                beam.name,
                abs(drawing.complex_point(beam.end) - drawing.complex_point(beam.start)),
                link.rigid,
            )
            for link in drawing.links
            for beam in link.beams
        ),
        clamps=tuple(made.clamps),
        pivots=tuple(made.pivots),
        pins=tuple(made.pins),
        welds=tuple(made.welds),
        sliders=tuple(made.sliders),
    )


class _Connections:
    """Connections of the points processed so far."""

    def __init__(self, drawing: Drawing, sprung: tuple[str, ...]) -> None:
        self.drawing = drawing
        self.sprung = sprung
        self.rigid = {beam.name: link.rigid for link in drawing.links for beam in link.beams}
        self.clamps: list[Clamp] = []
        self.pivots: list[Pivot] = []
        self.pins: list[Pin] = []
        self.welds: list[Weld] = []
        self.sliders: list[Slider] = []
        self._names: set[str] = set()

    def at(self, point: str) -> None:
        """Connect the ends of beams at a point."""
        joint, groups = self.drawing.joint(point), self._welded_ends(point)
        heads = [group[0] for group in groups]
        if point in self.drawing.ground:
            self._join_to_ground(joint, heads)
        else:
            if joint.kind == "slider":
                name = self._name(point, heads[0])
                self.sliders.append(self._slider(name, joint, heads[0]))
            for head in heads[1:]:
                name = self._name(point, head)
                self.pins.append(Pin(name, heads[0], head, name in self.sprung))
        for head, *others in groups:
            for other in others:
                self.welds.append(Weld(self._name(point, other), head, other))

    def _welded_ends(self, point: str) -> list[list[LinkEnd]]:
        """Ends in groups welded together; rigid ones first, in the order of the links."""
        ends, together = self.drawing.ends_at(point), self.drawing.fixed_together(point)
        groups: dict[str, list[LinkEnd]] = {}
        for link, link_ends in ends.items():
            groups.setdefault("" if link in together else link, []).extend(link_ends)
        clamped = self.drawing.joint(point).kind == "clamp"
        keys = sorted(
            groups,
            # A clamp holds its own group, whatever else turns about the shaft.
            key=lambda key: (clamped and key != "", min(map(self._is_flexible, groups[key]))),
        )
        return [sorted(groups[key], key=self._is_flexible) for key in keys]

    def _is_flexible(self, end: LinkEnd) -> bool:
        return not self.rigid[end.link]

    def _join_to_ground(self, joint: PlanarJoint, heads: list[LinkEnd]) -> None:
        for number, head in enumerate(heads):
            name = self._name(joint.point, head)
            if joint.kind == "clamp" and number == 0:
                self.clamps.append(Clamp(name, head))
            else:
                self.pivots.append(Pivot(name, head, name in self.sprung))

    def _slider(self, name: str, joint: PlanarJoint, end: LinkEnd) -> Slider:
        """Slider on the line through a point of the drawing, in the axes of its guide."""
        assert joint.direction is not None
        drawing, place = self.drawing, self.drawing.complex_point(joint.point)
        guide = ""
        if joint.guide:
            beam = drawing.link(joint.guide).beams[0]
            start = drawing.complex_point(beam.start)
            along = drawing.complex_point(beam.end) - start
            guide, place = beam.name, (place - start) * abs(along) / along
        offset = (place / cmath.rect(1.0, joint.direction)).imag
        return Slider(name, end, joint.direction, offset, guide)

    def _name(self, point: str, end: LinkEnd) -> str:
        name = f"{point}-{end.link}" if point in self._names else point
        if name in self._names or (name != point and name in self.drawing.points):
            raise InputError(f"two joints would be called {name}; rename point {name}")
        self._names.add(name)
        return name
