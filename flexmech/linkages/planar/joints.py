"""Topology of a drawing: leading and following link ends at each joint."""

from __future__ import annotations

import cmath

from flexmech.errors import InputError
from flexmech.linkages.planar.drawing import Drawing, PlanarJoint
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Slider, Topology, Weld


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
        for link, own in ends.items():
            groups.setdefault("" if link in together else link, []).extend(own)
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
