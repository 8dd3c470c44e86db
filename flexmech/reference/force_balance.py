"""Forces and tangents of all links displaced from their straight places, at all crank angles.

Arrays inside end with the batch of positions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.link_matrices import Chain
from flexmech.linear_system import (
    Connectors,
    DeadMoments,
    LinkFrames,
)
from flexmech.linkages import RigidMotion
from flexmech.reference.assembly import LinkageAssembly, LinkRows, RadialSprings, Ties
from flexmech.reference.corotational import (
    CorotationalElements,
    ElementResponse,
    LinearStrain,
    by_elements,
    in_positions,
)


@dataclass(frozen=True)
class Problem:
    """Loads of the equilibrium in a batch of positions.

    Parameters
    ----------
    motion : RigidMotion
    loads : sequence of ndarray, shape (n_link, B)
        Forces on each link.
    greatest : ndarray, shape (B,)
        Greatest force of them on the linkage where it is not displaced.
    extra : sequence of ndarray, shape (e, r, r, B)
        Stiffness that comes with them, by each element's relative coordinates.
    dead : DeadMoments
        Of bodies and rigid links.
    ties : Ties, optional
        Constraints where they do not depend on the displacement.
    swelling : float
        Part of the swelling that has come on.
    """

    motion: RigidMotion
    loads: Sequence[FloatArray]
    greatest: FloatArray
    extra: Sequence[FloatArray]
    dead: DeadMoments
    ties: Ties | None
    swelling: float = 1.0

    def loaded(self, part: float) -> Problem:
        """The problem with a part of the loads and of the swelling."""
        loads, extra = ([part * x for x in arrays] for arrays in (self.loads, self.extra))
        dead, greatest = self.dead.scaled(part), part * self.greatest
        return Problem(self.motion, loads, greatest, extra, dead, self.ties, part)

    def at(self, which: IntArray) -> Problem:
        """Quantities of some positions."""
        loads, extra = (
            [in_positions(x, which) for x in arrays] for arrays in (self.loads, self.extra)
        )
        greatest, ties = self.greatest[which], self.ties and self.ties.at(which)
        motion, dead = self.motion.at(which), self.dead.at(which)
        return Problem(motion, loads, greatest, extra, dead, ties, self.swelling)


@dataclass(frozen=True)
class Imbalance:
    """Residual and tangent at displacements.

    Parameters
    ----------
    residual : ndarray, shape (size, B)
        Outer minus inner forces.
    band : ndarray, shape (size, width + 1, B)
        Tangent stiffness in band form.
    strains : list of LinearStrain
        Of each link's elements.
    """

    residual: FloatArray
    band: FloatArray
    strains: list[LinearStrain]

    @property
    def error(self) -> FloatArray:
        """Greatest force out of balance, shape (B,)."""
        return np.asarray(np.abs(self.residual).max(axis=0, initial=0.0), dtype=float)

    def at(self, which: IntArray) -> Imbalance:
        """Quantities of some positions."""
        strains = [strain.of(which) for strain in self.strains]
        residual, band = (in_positions(values, which) for values in (self.residual, self.band))
        return Imbalance(residual, band, strains)


class ForceBalance:
    """Forces and tangents of one linkage on one mesh.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    chains : mapping of int to Chain
        Each flexible link by its number, all of one kind of elements.
    connectors : Connectors
        Whose radial springs join ends that the frames do not constrain.

    Attributes
    ----------
    links : dict of int to CorotationalElements
        The flexible ones.
    assembly : LinkageAssembly
    """

    def __init__(
        self, frames: LinkFrames, chains: Mapping[int, Chain], connectors: Connectors
    ) -> None:
        self.frames = frames
        self.links = {n: CorotationalElements(own.elements) for n, own in chains.items()}
        self._connectors, self._springs = connectors, RadialSprings(frames, connectors)
        # Energies of whole links, which have off-axis plies between joints. A rigid rotation of the
        # link has no curvature, to first order in the rotations of elements against it.
        self._couplings = {n: x.coupling for n, x in chains.items() if x.coupling is not None}
        every = {n: np.arange(frames.links[n].size) for n in self._couplings}
        self._coupled = {n: LinkRows(frames, n, rows) for n, rows in every.items()}
        joined = [*self._springs.columns, *(rows.columns for rows in self._coupled.values())]
        self.assembly = LinkageAssembly(frames, self.links, joined)

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
            :meth:`CorotationalElements.response`.

        Returns
        -------
        Imbalance
        """
        motion, dead = problem.motion, problem.dead
        entries, ties = self.assembly.entries(z.shape[1]), problem.ties
        if ties is None:
            ties = self.assembly.ties(motion, z)
        displacement = self.assembly.link_displacement(z, ties)
        inner, strains = [np.zeros_like(q) for q in displacement], []
        for place, (number, extra) in enumerate(zip(self.links, problem.extra, strict=True)):
            response = self._response(
                number,
                displacement[number],
                extra,
                problem.swelling,
                None if before is None else before[place],
                entries[1][number],
            )
            inner[number] = self.links[number].on_nodes(response.force)
            strains.append(response.strain)
        dead.add_forces(inner, displacement)
        by_rotation = {}
        for link, (rows, stiffness) in dead.rotation_stiffness(displacement).items():
            if link not in self.links:
                by_rotation[link] = stiffness[0]
                continue
            own, tangent = self.links[link], entries[1][link]
            per_node = own.elements.shapes.per_node
            element = np.minimum(rows // per_node, len(tangent) - 1)
            place = own.relative_places[rows - per_node * element]
            tangent[element, place, place] += stiffness
        self._add_coupling(displacement, inner, problem.swelling)
        for push in self._connectors.radial_forces(motion, [q.T for q in displacement]):
            link, q = push.point.link, displacement[push.point.link].T
            inner[link] -= push.on_link(motion, q).T
            if push.point.rigid:
                by_rotation[link] = by_rotation[link] + push.rotation_stiffness(motion, q)
        unbalanced = [load - force for load, force in zip(problem.loads, inner, strict=True)]
        rigid = None
        if ties.displaced is not None:
            found = ties.displaced.geometric_stiffness([f.T for f in unbalanced], by_rotation)
            rigid = found.projected(self.frames.rigid, ties.displaced.coordinates)
        coupled = (
            rows.turned(self._couplings[link].stiffness, ties)
            for link, rows in self._coupled.items()
        )
        joined = chain(self._springs.tangents(motion, displacement, ties), coupled)
        band = self.assembly.band(entries, ties, rigid, joined)
        return Imbalance(self.assembly.gather(unbalanced, ties), band, strains)

    def _response(
        self, number: int, q: FloatArray, extra: FloatArray, *given: Any
    ) -> ElementResponse:
        """Forces and tangent of a link's elements at displacements q (n, B), with extra stiffness.

        ``given`` is that of :meth:`CorotationalElements.response`.
        """
        relative = self.links[number].relative(q)
        response = self.links[number].response(relative, *given)
        response.force[:] += by_elements(extra, relative)
        response.tangent[:] += extra
        return response

    def _add_coupling(
        self, displacement: Sequence[FloatArray], forces: Sequence[FloatArray], swelling: float
    ) -> None:
        """Add internal forces (n_link, B) of energies of whole links."""
        for link, own in self._couplings.items():
            bent = own.rows @ displacement[link] - swelling * own.unloaded[:, None]
            forces[link][:] += own.rows.T @ (own.elastic @ bent)

    def response(
        self, displacement: Sequence[FloatArray], extra: Sequence[FloatArray]
    ) -> tuple[list[FloatArray], dict[int, FloatArray]]:
        """Internal forces and tangents of the links at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        extra : sequence of ndarray, shape (e, r, r, B)
            Stiffness of each element besides that of the corotational beam, by its relative
            coordinates.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Forces on the nodes; none of a rigid link.
        dict of int to ndarray, shape (B, n_link, n_link)
            Tangent of each flexible link.
        """
        columns, tangents = [q.T for q in displacement], {}
        forces = [np.zeros_like(q) for q in columns]
        for (number, link), more in zip(self.links.items(), extra, strict=True):
            response = self._response(number, columns[number], more, 1.0, None, None)
            forces[number] = link.on_nodes(response.force)
            tangents[number] = link.of_link(response.tangent)
        self._add_coupling(columns, forces, swelling=1.0)
        for number, coupling in self._couplings.items():
            tangents[number] += coupling.stiffness
        return [force.T for force in forces], tangents

    def damping(self, displacement: Sequence[FloatArray]) -> dict[int, FloatArray]:
        """Kelvin-Voigt damping matrix of each flexible link at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        dict of int to ndarray, shape (B, n_link, n_link)
        """
        matrices = {
            number: link.of_link(link.damping(link.relative(displacement[number].T)))
            for number, link in self.links.items()
        }
        for number, coupling in self._couplings.items():
            matrices[number] += coupling.damping_time * coupling.stiffness
        return matrices

    def damping_stiffness(
        self, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> dict[int, FloatArray]:
        """Derivative of each flexible link's damping forces by its displacement at given rates.

        Parameters
        ----------
        displacement, rate : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        dict of int to ndarray, shape (B, n_link, n_link)
        """
        return {
            number: link.of_link(
                link.damping_stiffness(*(link.relative(q[number].T) for q in (displacement, rate)))
            )
            for number, link in self.links.items()
        }
