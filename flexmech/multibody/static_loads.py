"""Dead loads on the links of a static model.

A rigid link may rotate under them. The effect of distributed dead loads is given by their
resultant, their moment and their virial about the link's start, the sum of force times place: the
resultant acts at the start, and a couple of forces at start and end has the moment and the virial.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_parts import BeamPart, RigidPart


@dataclass(frozen=True)
class TurningBody:
    """A rigid link, or a body at a node, on which dead loads have a moment.

    Parameters
    ----------
    link : int
    angle : int
        Its angle among the coordinates of all links.
    at_start, at_end : ItemNumber
        Loads as far apart as the ends of the link.
    """

    link: int
    angle: int
    at_start: ItemNumber
    at_end: ItemNumber


class StaticLoads:
    """Loads on every coordinate of the links, set anew for each position.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet; the point masses of its cables are added along.

    Attributes
    ----------
    turning : list of TurningBody
    """

    def __init__(self, assembly: LinkAssembly) -> None:
        self._assembly = assembly
        self._at_points: list[tuple[ItemNumber, int]] = []
        self._nodal = self._add_nodal_forces()
        self.turning = [
            self._add_couple(link, angle, body)
            for link, part in enumerate(assembly.parts)
            for angle, body in self._turning_bodies(link, part).items()
        ]

    def set(self, forces: FloatArray, couples: FloatArray) -> None:
        """Set the forces.

        Parameters
        ----------
        forces : ndarray, shape (size,)
            Generalized forces on the coordinates of all links, in the crank's frame. The moment
            on a rigid link is not read.
        couples : ndarray, shape (n_turning, 2)
            Force on each of :attr:`turning` at its end, with its opposite at the start, in the
            crank's frame.
        """
        mbs, at_nodes = self._assembly.mbs, forces.copy()
        for load, first in self._at_points:
            _set_load(mbs, load, at_nodes[first : first + 2])
            at_nodes[first : first + 2] = 0.0
        for turned, couple in zip(self.turning, couples, strict=True):
            part, start_force = self._assembly.parts[turned.link], np.zeros(2)
            if isinstance(part, RigidPart):
                start_force = forces[part.coordinates][:2]
                at_nodes[part.coordinates] = 0.0
            _set_load(mbs, turned.at_start, start_force - couple)
            _set_load(mbs, turned.at_end, couple)
        if self._nodal is not None:
            mbs.SetObjectParameter(self._nodal, "forceVector", at_nodes[self._elastic])

    def _add_nodal_forces(self) -> ItemNumber | None:
        """Object with generalized forces on every coordinate and with the point masses."""
        assembly = self._assembly
        elastic = np.zeros(assembly.size, dtype=bool)
        mass = np.zeros((assembly.size, assembly.size))
        for link, part in assembly.beams:
            elastic[part.coordinates] = True
            at = part.coordinates.start + assembly.kind.per_node * np.arange(len(part.nodes))
            if part.bodies is None:
                mass[at, at] = mass[at + 1, at + 1] = assembly.point_masses(part)
            if part.arms is not None:
                self._add_points(link, part, at.tolist())
        self._elastic = np.flatnonzero(elastic)
        every = [node for _, part in assembly.beams for node in part.nodes]
        if not every:
            return None
        return assembly.items.add(
            "ObjectGenericODE2",
            "loads",
            nodeNumbers=every,
            massMatrix=mass[np.ix_(elastic, elastic)] if mass.any() else None,
            forceVector=np.zeros(len(self._elastic)),
        )

    def _add_points(self, link: int, part: BeamPart, first: list[int]) -> None:
        """Forces on points of the pins' axis, off the nodes of an eccentric link."""
        for number, coordinate in enumerate(first):
            name = f"load_{link}_{number}"
            marker = self._assembly.add_axis_marker(part, part.positions[number], f"{name}_point")
            self._at_points.append((self._add_load(name, marker), coordinate))

    def _turning_bodies(self, link: int, part: BeamPart | RigidPart) -> dict[int, ItemNumber]:
        """Bodies of a link on which dead loads have moments, by their angle coordinate."""
        if isinstance(part, RigidPart):
            return {part.coordinates.stop - 1: part.body}
        found: dict[int, ItemNumber] = {}
        if part.bodies is not None and part.section.mass_axis:
            first = part.coordinates.start + part.kind.clamped
            found = {
                first + part.kind.per_node * node: body
                for node, body in enumerate(part.bodies.numbers)
            }
        attached = (own for own in self._assembly.attached if own.link == link)
        return found | {own.angle: own.number for own in attached}

    def _add_couple(self, link: int, angle: int, body: ItemNumber) -> TurningBody:
        """Forces at the node of a body and at a link's length from it along the link."""
        name, length = f"load_{link}_{angle}", self._assembly.parts[link].length
        start, end = (
            self._add_load(
                f"{name}_at_{i}", self._assembly.add_body_frame(body, f"{name}_point_{i}", x)
            )
            for i, x in enumerate((0.0, length))
        )
        return TurningBody(link, angle, start, end)

    def _add_load(self, name: str, marker: ItemNumber) -> ItemNumber:
        return self._assembly.items.add(
            "LoadForceVector", name, markerNumber=marker, loadVector=[0.0, 0.0, 0.0]
        )


def _set_load(mbs: Any, load: ItemNumber, force: FloatArray) -> None:
    mbs.SetLoadParameter(load, "loadVector", [float(force[0]), float(force[1]), 0.0])
