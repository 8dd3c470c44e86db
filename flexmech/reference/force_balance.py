"""Residual forces of a displaced linkage, and its tangent stiffness.

Arrays end with the batch of positions.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import DeadMoments
from flexmech.reference.corotational import CorotationalElements, LinearStrain
from flexmech.reference.coupled_links import CoupledLinks
from flexmech.reference.dependent_element import Ties
from flexmech.reference.element_numbers import by_elements
from flexmech.reference.linkage_tangents import LinkageTangents, TangentEntries
from flexmech.reference.newton_state import Imbalance, Problem
from flexmech.reference.nodal_chains import node_forces, relative_coordinates
from flexmech.reference.radial_springs import RadialSprings


@dataclass(frozen=True)
class ForceBalance:
    """Residual and tangent of one linkage on one mesh.

    Parameters
    ----------
    links : mapping of int to CorotationalElements
        The flexible ones, by their number.
    tangents : LinkageTangents
    springs : RadialSprings
    coupled : CoupledLinks
    per_node : int
        Coordinates of a node.
    """

    links: Mapping[int, CorotationalElements]
    tangents: LinkageTangents
    springs: RadialSprings
    coupled: CoupledLinks
    per_node: int

    def ties(self, z: FloatArray, problem: Problem) -> Ties:
        """Constraints of the linkage displaced by z (size, B)."""
        if problem.loads is None:
            return problem.ties
        return self.tangents.ties(problem.motion, z)

    def imbalance(
        self, z: FloatArray, problem: Problem, before: Sequence[LinearStrain] | None = None
    ) -> Imbalance:
        """Residual forces and tangent stiffness at displacements.

        Parameters
        ----------
        z : ndarray, shape (size, B)
        problem : Problem
        before : sequence of LinearStrain, optional
            Of each link's elements where a step came from that has led to z; see
            :meth:`CorotationalElements.relative_response`.

        Returns
        -------
        Imbalance
        """
        entries, ties = self.tangents.entries(z.shape[1]), self.ties(z, problem)
        displacement = self.tangents.link_displacement(z, ties)
        inner, strains = [np.zeros_like(q) for q in displacement], []
        for place, (number, extra) in enumerate(zip(self.links, problem.extra, strict=True)):
            relative = relative_coordinates(displacement[number], self.per_node)
            force, tangent, strain = self.links[number].relative_response(
                relative,
                problem.swelling,
                None if before is None else before[place],
                out=entries.of_link(number),
                design=problem.motion.design,
            )
            force += by_elements(extra, relative)
            tangent += extra
            inner[number] = node_forces(force, self.per_node)
            strains.append(strain)
        problem.dead.add_forces(inner, displacement)
        self._stiffen(problem.dead, displacement, entries)
        self.coupled.add_forces(displacement, inner, problem.swelling)
        rotation_stiffness: FloatArray | None = None
        springs: Iterable[FloatArray] = ()
        if self.springs.columns:
            given = problem.motion, displacement, inner, ties.displaced
            rotation_stiffness = self.springs.add_forces(*given)
            springs = self.springs.tangents(problem.motion, ties)
        springs = chain(springs, self.coupled.tangents(ties, z.shape[1]))
        residual = self._unbalanced(inner, ties, problem)
        if problem.loads is None or ties.displaced is None:
            return Imbalance(residual, self.tangents.band(entries, ties, springs=springs), strains)
        unbalanced = [(load - force).T for load, force in zip(problem.loads, inner, strict=True)]
        stiffness = ties.displaced.geometric_stiffness(
            unbalanced, problem.dead.by_link(displacement)
        )
        if rotation_stiffness is not None:
            stiffness = replace(
                stiffness, rotation_stiffness=stiffness.rotation_stiffness + rotation_stiffness
            )
        band = self.tangents.band(entries, ties, ties.displaced.matrix(stiffness), springs)
        return Imbalance(residual, band, strains)

    def _unbalanced(self, inner: Sequence[FloatArray], ties: Ties, problem: Problem) -> FloatArray:
        """Residual forces (size, B) in independent coordinates."""
        if problem.loads is None:
            return problem.outer - self.tangents.gather(inner, ties)
        unbalanced = [load - force for load, force in zip(problem.loads, inner, strict=True)]
        return self.tangents.gather(unbalanced, ties)

    def _stiffen(
        self, dead: DeadMoments, displacement: Sequence[FloatArray], entries: TangentEntries
    ) -> None:
        """Add the geometric stiffness of bodies to the tangents of flexible links."""
        for link, (rows, stiffness) in dead.rotation_stiffness(displacement).items():
            if link not in self.links:
                continue
            tangent = entries.of_link(link)
            element = np.minimum(rows // self.per_node, len(tangent) - 1)
            place = self.links[link].relative_places[rows - self.per_node * element]
            tangent[element, place, place] += stiffness
