"""Forces on the links of a model at standstill, which keep their direction.

A rigid link may turn under them. What distributed forces do to it then is told by their sum,
their moment and their virial about the link's start, the sum of force times place: the sum acts
at the start, and a couple of forces at start and end has the moment and the virial.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.types import FloatArray


class StaticLoads:
    """Loads on every coordinate of the links, set anew for each position.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet; the point masses of its cables are added along.
    """

    def __init__(self, assembly: LinkAssembly) -> None:
        self._assembly = assembly
        self._at_points: list[tuple[ItemNumber, int]] = []
        self._couples: dict[int, tuple[ItemNumber, ItemNumber]] = {}
        self._nodal = self._add_nodal_forces()
        for link, part in enumerate(assembly.parts):
            if isinstance(part, RigidPart):
                self._couples[link] = self._add_couple(f"load_{link}", part.body, part.length)
        for count, attached in enumerate(assembly.attached):
            name, length = f"attached_load_{count}", assembly.parts[attached.link].length
            couple = self._add_couple(name, attached.number, length)
            self._couples[len(assembly.parts) + count] = couple

    def set(self, forces: FloatArray, couples: FloatArray) -> None:
        """Give the forces.

        Parameters
        ----------
        forces : ndarray, shape (size,)
            Generalized forces on the coordinates of all links, in the crank's frame. The moment
            on a rigid link is not read.
        couples : ndarray, shape (n_links + n_attached, 2)
            Force at the end of each rigid link, with its opposite at the start, in the crank's
            frame; and those of each attached body, as far apart as the ends of its link.
        """
        mbs, at_nodes = self._assembly.mbs, forces.copy()
        for load, first in self._at_points:
            _set_load(mbs, load, at_nodes[first : first + 2])
            at_nodes[first : first + 2] = 0.0
        for number, (at_start, at_end) in self._couples.items():
            couple, carried = couples[number], np.zeros(2)
            if number < len(self._assembly.parts):
                own = self._assembly.parts[number].coordinates
                carried = forces[own][:2]
                at_nodes[own] = 0.0
            _set_load(mbs, at_start, carried - couple)
            _set_load(mbs, at_end, couple)
        if self._nodal is not None:
            mbs.SetObjectParameter(self._nodal, "forceVector", at_nodes[self._elastic])

    def _add_nodal_forces(self) -> ItemNumber | None:
        """One object that carries forces on every coordinate and the point masses."""
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
            marker = self._assembly.add_axis_point(part, number, f"{name}_point")
            self._at_points.append((self._add_load(name, marker), coordinate))

    def _add_couple(
        self, name: str, body: ItemNumber, length: float
    ) -> tuple[ItemNumber, ItemNumber]:
        """Forces at the node of a body and at a length from it along its link."""
        start, end = (
            self._add_load(
                f"{name}_{i}", self._assembly.add_body_frame(body, f"{name}_point_{i}", x)
            )
            for i, x in enumerate((0.0, length))
        )
        return start, end

    def _add_load(self, name: str, marker: ItemNumber) -> ItemNumber:
        return self._assembly.items.add(
            "LoadForceVector", name, markerNumber=marker, loadVector=[0.0, 0.0, 0.0]
        )


def _set_load(mbs: Any, load: ItemNumber, force: FloatArray) -> None:
    mbs.SetLoadParameter(load, "loadVector", [float(force[0]), float(force[1]), 0.0])
