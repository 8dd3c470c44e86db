"""A mechanism as an Exudyn system at standstill: built once, moved through the crank angles.

The model stands in the crank's frame: the shaft's clamp is then a condition on single
coordinates with a constant constraint Jacobian, whatever the crank angle. What changes
from one position to the next are the coordinates, the ground pivots and the loads.
"""

from __future__ import annotations

import numpy as np

from flexmech.linear_system import free_load
from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.types import FloatArray

__all__ = ["StaticModel"]


class StaticModel:
    """Exudyn system of a mechanism whose crank is held.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.

    Attributes
    ----------
    assembly : LinkAssembly
        The links in the frame of the clamped one.
    """

    def __init__(self, mechanism: Mechanism, elements: int, kind: str) -> None:
        self.assembly = LinkAssembly(mechanism, elements, kind)
        self._arm_loads: list[tuple[ItemNumber, int]] = []
        self._grounds: list[tuple[ItemNumber, int, float]] = []
        self._loads = self._add_loads()
        self._offsets = self._add_supports()
        self.assembly.add_pins()
        self.assembly.mbs.Assemble()

    @property
    def free_load(self) -> float:
        """Force by which swelling that is held back pulls and bends an element, at most."""
        links = zip(self.assembly.sections, self.assembly.parts, strict=True)
        return max(free_load(section, np.diff(part.positions).min()) for section, part in links)

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
        assembly = self.assembly
        turn = motion.angle[number, assembly.base]
        cosine, sine = np.cos(turn), np.sin(turn)
        back = np.array([[cosine, sine], [-sine, cosine]])
        pose = np.empty(assembly.size)
        for link, part in enumerate(assembly.parts):
            origin = back @ motion.origin[number, link]
            angle = float(motion.angle[number, link] - turn)
            pose[part.coordinates] = assembly.kind.pose(part.positions, origin, angle)
        nodes = assembly.arms.to_nodes(pose)
        for constraint, coordinate in self._offsets:
            assembly.mbs.SetObjectParameter(constraint, "offset", float(nodes[coordinate]))
        for ground, first, x in self._grounds:
            place = [float(pose[first]) + x, float(pose[first + 1]), 0.0]
            assembly.mbs.SetObjectParameter(ground, "referencePosition", place)
        return pose

    def set_forces(self, forces: FloatArray) -> None:
        """Generalized forces on all coordinates, shape (size,), in the crank's frame."""
        mbs, at_nodes = self.assembly.mbs, forces.copy()
        for load, first in self._arm_loads:
            x, y = at_nodes[first : first + 2]
            mbs.SetLoadParameter(load, "loadVector", [float(x), float(y), 0.0])
            at_nodes[first : first + 2] = 0.0
        mbs.SetObjectParameter(self._loads, "forceVector", at_nodes)

    def swell(self, part: float) -> None:
        """Give all elements a part of the free strains of their sections; 1 for all of it."""
        assembly = self.assembly
        for section, link in zip(assembly.sections, assembly.parts, strict=True):
            for element in link.elements if section.is_free_strained else ():
                assembly.kind.swell(assembly.mbs, element, section, part)

    def _add_loads(self) -> ItemNumber:
        """One object that carries forces on every coordinate and the point masses."""
        assembly = self.assembly
        mass = np.zeros((assembly.size, assembly.size))
        for link, part in enumerate(assembly.parts):
            at = part.coordinates.start + assembly.kind.per_node * np.arange(len(part.nodes))
            if part.bodies is None:
                mass[at, at] = mass[at + 1, at + 1] = assembly.point_masses(link)
            if part.arms is None:
                continue
            for number, first in enumerate(at):
                name = f"load_{link}_{number}"
                marker = assembly.add_axis_point(part, number, f"{name}_point")
                load = assembly.items.add(
                    "LoadForceVector", name, markerNumber=marker, loadVector=[0.0, 0.0, 0.0]
                )
                self._arm_loads.append((load, int(first)))
        every = [node for part in assembly.parts for node in part.nodes]
        return assembly.items.add(
            "ObjectGenericODE2",
            "loads",
            nodeNumbers=every,
            massMatrix=mass if mass.any() else None,
            forceVector=np.zeros(assembly.size),
        )

    def _add_supports(self) -> list[tuple[ItemNumber, int]]:
        """Hold clamped and pivoted coordinates; returns constraints and what they hold."""
        assembly = self.assembly
        fixed = assembly.add_fixed_coordinate()
        held: list[tuple[LinkEnd, tuple[int, ...]]] = [
            (clamp.held, (0, 1, assembly.kind.clamped)) for clamp in assembly.topology.clamps
        ]
        for pivot in assembly.topology.pivots:
            if assembly.part_of(pivot.held).arms is None:
                held.append((pivot.held, (0, 1)))
            else:
                ground = assembly.add_ground_pin(
                    f"pivot_{pivot.joint}", pivot.held, [0.0, 0.0, 0.0]
                )[0]
                first, x = assembly.end_node(pivot.held)[1], assembly.reference_place(pivot.held)[0]
                self._grounds.append((ground, first, float(x)))
        offsets = []
        for place, coordinates in held:
            node, first = assembly.end_node(place)
            for coordinate in coordinates:
                constraint = assembly.add_constraint(
                    f"support_{node.name}_{coordinate}", fixed, node, coordinate
                )
                offsets.append((constraint, first + coordinate))
        return offsets
