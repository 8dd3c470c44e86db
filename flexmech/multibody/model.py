"""A mechanism as an Exudyn system: built once, moved through the crank angles.

The model stands in the crank's frame: the shaft's clamp is then a condition on single
coordinates with a constant constraint Jacobian, whatever the crank angle. What changes
from one position to the next are the coordinates, the ground pivots and the loads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.beams import BEAM_KINDS, BeamKind
from flexmech.multibody.library import load_exudyn

__all__ = ["LinkPart", "MultibodyModel"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LinkPart:
    """One link in the Exudyn system.

    Parameters
    ----------
    positions : ndarray, shape (e + 1,)
        Node positions along the link in m.
    nodes, elements : list of int
        Exudyn's numbers.
    coordinates : slice
        Where the link's coordinates are in the system's.
    """

    positions: FloatArray
    nodes: list[int]
    elements: list[int]
    coordinates: slice


class MultibodyModel:
    """Exudyn system of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.

    Attributes
    ----------
    mbs : exudyn.MainSystem
    parts : list of LinkPart
    base : int
        Link in whose frame the model stands: the clamped one.
    pins : list of int
        Exudyn's numbers of the pins between links, in the topology's order.
    """

    def __init__(self, mechanism: Mechanism, elements: int, kind: str) -> None:
        self.mechanism = mechanism
        self.topology = mechanism.linkage.topology
        self.kind: BeamKind = BEAM_KINDS[kind]
        self._container = load_exudyn().SystemContainer()
        self.mbs: Any = self._container.AddSystem()
        self.base = self.topology.index(self.topology.clamps[0].held.link)
        self.parts = self._add_links(elements)
        self.size = self.parts[-1].coordinates.stop
        self._loads = self._add_loads()
        self._offsets = self._add_supports()
        self.pins = self._add_pins()
        self.mbs.Assemble()

    @property
    def nodal_force_scale(self) -> float:
        """Force between neighbouring nodes if one stood still and the other at the origin."""
        extent = sum(link.length for link in self.topology.links)
        scales = []
        for name, part in zip(self.topology.link_names, self.parts, strict=True):
            section, length = self.mechanism.sections[name], float(np.diff(part.positions).min())
            bending = 12 * section.bending_stiffness / length**2
            stiffness = max(section.axial_stiffness, section.shear_stiffness, bending) / length
            scales.append(stiffness * extent)
        return max(scales)

    def move_to(self, motion: RigidMotion, number: int) -> FloatArray:
        """Put the supports where position ``number`` of a batch has them.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int

        Returns
        -------
        ndarray, shape (size,)
            Coordinates of the undeformed links, less the reference ones.
        """
        turn = motion.angle[number, self.base]
        cosine, sine = np.cos(turn), np.sin(turn)
        back = np.array([[cosine, sine], [-sine, cosine]])
        pose = np.empty(self.size)
        for link, part in enumerate(self.parts):
            origin = back @ motion.origin[number, link]
            angle = float(motion.angle[number, link] - turn)
            pose[part.coordinates] = self.kind.pose(part.positions, origin, angle)
        for constraint, coordinate in self._offsets:
            self.mbs.SetObjectParameter(constraint, "offset", float(pose[coordinate]))
        return pose

    def set_forces(self, forces: FloatArray) -> None:
        """Generalized forces on all coordinates, shape (size,), in the crank's frame."""
        self.mbs.SetObjectParameter(self._loads, "forceVector", forces)

    def point_masses(self, link: int) -> FloatArray:
        """Point mass at each node of a link in kg, shape (e + 1,)."""
        part, points = self.parts[link], self.mechanism.link_mass(self.topology.link_names[link])
        masses = np.zeros(len(part.nodes))
        for x, value in zip(points.point_positions, points.point_masses, strict=True):
            masses[np.argmin(np.abs(part.positions - x))] += value
        return masses

    def _add_links(self, elements: int) -> list[LinkPart]:
        parts, start = [], 0
        for name in self.topology.link_names:
            mass, section = self.mechanism.link_mass(name), self.mechanism.sections[name]
            positions = node_positions(mass.length, elements, mass.point_positions)
            nodes = [self.kind.add_node(self.mbs, float(x)) for x in positions]
            lengths = np.diff(positions)
            beams = [
                self.kind.add_element(self.mbs, nodes[i : i + 2], float(h), section)
                for i, h in enumerate(lengths)
            ]
            stop = start + self.kind.per_node * len(nodes)
            parts.append(LinkPart(positions, nodes, beams, slice(start, stop)))
            start = stop
        return parts

    def _add_loads(self) -> int:
        """One object that carries forces on every coordinate and the point masses."""
        items = load_exudyn().itemInterface
        mass = np.zeros((self.size, self.size))
        for link, part in enumerate(self.parts):
            at = part.coordinates.start + self.kind.per_node * np.arange(len(part.nodes))
            mass[at, at] = mass[at + 1, at + 1] = self.point_masses(link)
        every = [node for part in self.parts for node in part.nodes]
        carrier = items.ObjectGenericODE2(
            nodeNumbers=every,
            massMatrix=mass if mass.any() else None,
            forceVector=np.zeros(self.size),
        )
        return int(self.mbs.AddObject(carrier))

    def _add_supports(self) -> list[tuple[int, int]]:
        """Hold clamped and pivoted coordinates; returns constraints and what they hold."""
        fixed = self._add_fixed_coordinate()
        held: list[tuple[LinkEnd, tuple[int, ...]]] = [
            (clamp.held, (0, 1, self.kind.clamped)) for clamp in self.topology.clamps
        ]
        held += [(pivot.held, (0, 1)) for pivot in self.topology.pivots]
        offsets = []
        for place, coordinates in held:
            node, first = self._end(place)
            for coordinate in coordinates:
                constraint = self._hold(fixed, node, coordinate)
                offsets.append((constraint, first + coordinate))
        return offsets

    def _add_fixed_coordinate(self) -> int:
        """Marker of a coordinate that stays zero."""
        items = load_exudyn().itemInterface
        ground = self.mbs.AddNode(items.NodePointGround())
        return int(self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0)))

    def _hold(self, fixed: int, node: int, coordinate: int, **offset: Any) -> int:
        """Constraint that keeps a node's coordinate at an offset from the fixed one."""
        items = load_exudyn().itemInterface
        marker = self.mbs.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        )
        return int(
            self.mbs.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, marker], **offset))
        )

    def _add_pins(self) -> list[int]:
        items = load_exudyn().itemInterface
        joints = []
        for pin in self.topology.pins:
            markers = [
                self.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=self._end(place)[0]))
                for place in (self.topology.leader_of(pin.leader), pin.follower)
            ]
            joints.append(int(self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=markers))))
        return joints

    def _end(self, place: LinkEnd) -> tuple[int, int]:
        """Node number at a link end and the first of its coordinates."""
        part = self.parts[self.topology.index(place.link)]
        if place.end == "start":
            return part.nodes[0], part.coordinates.start
        return part.nodes[-1], part.coordinates.stop - self.kind.per_node
