"""Joints of links in an Exudyn system: pins, welds and sliders.

Where it is exact, a joint is a condition whose Jacobian is constant: that on the places of two
nodes, on the difference of two angles, or on the distance of a node from a line of the ground.
Then the constraint's force adds nothing to the tangent stiffness. A weld between cables holds
directions of slopes, a guide turns with its link, and a rigid link's end is off its node: what
the forces of these add is in the maps of :mod:`flexmech.multibody.node_maps` and in
:mod:`flexmech.multibody.rigid_tangents`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, Pin, Slider, Weld
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_parts import RigidPart


@dataclass(frozen=True)
class TieJoint:
    """A pin or weld between two link ends.

    Parameters
    ----------
    tie : Pin or Weld
    leader : LinkEnd
        The end that carries the place of the joint.
    position : ItemNumber
        Constraint on the places; its multipliers are minus the force on the follower.
    rotation : ItemNumber, optional
        Constraint on the angle between the links, of a weld.
    turns_nodes : bool
        Whether that is a condition on coordinates of two nodes, the second less the first.
    """

    tie: Pin | Weld
    leader: LinkEnd
    position: ItemNumber
    rotation: ItemNumber | None = None
    turns_nodes: bool = False


@dataclass(frozen=True)
class SliderJoint:
    """A link end on a line.

    Parameters
    ----------
    slider : Slider
    constraint : ItemNumber
        Its first multiplier is the force on the held end along the line's normal, which is a
        quarter turn ahead of its direction.
    ground : ItemNumber, optional
        Of a line on the ground.
    """

    slider: Slider
    constraint: ItemNumber
    ground: ItemNumber | None = None

    @property
    def normal(self) -> FloatArray:
        """Normal of the line in the axes of its guide, shape (2,)."""
        return np.array([-np.sin(self.slider.direction), np.cos(self.slider.direction)])

    @property
    def place(self) -> FloatArray:
        """A point of the line in the axes of its guide in m, shape (2,)."""
        return self.slider.offset * self.normal


def add_ties(
    assembly: LinkAssembly, angle: FloatArray, *, sprung_alone: bool = True
) -> list[TieJoint]:
    """Join the links by pins and welds.

    Parameters
    ----------
    assembly : LinkAssembly
    angle : ndarray, shape (n_links,)
        Of the links in any one position, in rad.
    sprung_alone : bool
        Whether springs alone hold sprung pins; they are rigid otherwise.

    Returns
    -------
    list of TieJoint
        In the order of the topology's ties, without those that springs alone hold.
    """
    ties = assembly.topology.ties
    return [
        _tie(assembly, tie, angle)
        for tie in ties
        if isinstance(tie, Weld) or not (tie.sprung and sprung_alone)
    ]


def _tie(assembly: LinkAssembly, tie: Pin | Weld, angle: FloatArray) -> TieJoint:
    kind = "pin" if isinstance(tie, Pin) else "weld"
    name = f"{kind}_{tie.joint}"
    assembly.items.begin(f"{kind} {tie.joint}")
    leader = leading_end(tie.leader, assembly.topology.rigid_ties)
    markers = [
        assembly.add_end_marker(place, f"{name}_on_{place.link}")
        for place in (leader, tie.follower)
    ]
    position = assembly.items.add("RevoluteJoint2D", name, markerNumbers=markers)
    if isinstance(tie, Pin):
        return TieJoint(tie, leader, position)
    links = [assembly.topology.index(end.link) for end in (tie.leader, tie.follower)]
    between = float(angle[links[1]] - angle[links[0]])
    turning = [assembly.turning_coordinate(end) for end in (tie.leader, tie.follower)]
    rotation = f"{name}_rotation"
    if all(coordinate is not None for coordinate in turning):
        angles = [
            assembly.items.add(
                "MarkerNodeCoordinate",
                f"{name}_angle_of_{end.link}",
                nodeNumber=assembly.end_node(end),
                coordinate=coordinate,
            )
            for end, coordinate in zip((tie.leader, tie.follower), turning, strict=True)
        ]
        constraint = assembly.items.add(
            "CoordinateConstraint", rotation, markerNumbers=angles, offset=between
        )
        return TieJoint(tie, leader, position, constraint, turns_nodes=True)
    frames = [
        assembly.add_frame_marker(end, f"{name}_axis_of_{end.link}", turn)
        for end, turn in ((tie.leader, 0.0), (tie.follower, -between))
    ]
    constraint = assembly.items.add(
        "GenericJoint", rotation, markerNumbers=frames, constrainedAxes=[0, 0, 0, 0, 0, 1]
    )
    return TieJoint(tie, leader, position, constraint)


def add_sliders(assembly: LinkAssembly) -> list[SliderJoint]:
    """Add the sliders: link ends on lines of the ground or of rigid links.

    Parameters
    ----------
    assembly : LinkAssembly

    Returns
    -------
    list of SliderJoint
        In the topology's order; lines of the ground are where they are in ground axes.
    """
    joints = []
    for slider in assembly.topology.sliders:
        name, items = f"slider_{slider.joint}", assembly.items
        items.begin(f"slider {slider.joint}")
        joint = SliderJoint(slider, ItemNumber(-1, "object", name))
        x, y = map(float, joint.place)
        end = assembly.add_frame_marker(slider.link_end, f"{name}_on_{slider.link_end.link}")
        ground = None
        if slider.guide:
            guide = assembly.parts[assembly.topology.index(slider.guide)]
            assert isinstance(guide, RigidPart)
            line = assembly.add_body_frame(guide.body, f"{name}_on_{slider.guide}", x, y)
        else:
            ground, line = assembly.add_ground(name, (x, y))
        # The normal of this joint is that of the second marker: the line's.
        constraint = items.add(
            "PrismaticJoint2D",
            name,
            markerNumbers=[end, line],
            normalMarker1=[*map(float, joint.normal), 0.0],
            constrainRotation=False,
        )
        joints.append(SliderJoint(slider, constraint, ground))
    return joints
