"""Sparse matrices of the unreduced links of many elements.

They are those of :meth:`flexmech.linear_system.LinkFrames.assemble`, position by position. Their
entries grow with the number of elements, where those of whole matrices grow with its square.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, coo_array, csc_array

from flexmech.arrays import IntArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.link_place import DependentRows
from flexmech.linear_system.links.body_forces import body_turns
from flexmech.linear_system.links.chains import ChainMatrix, LinkMatrix, in_positions
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linkages import RigidMotion


@dataclass(frozen=True)
class SparseMatrices:
    """Mass, damping and stiffness in one position; each sparse, (n, n)."""

    mass: csc_array
    damping: csc_array
    stiffness: csc_array


class SparsePositions:
    """Matrices of a linkage in the independent coordinates of its unreduced links.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
        There, without guides of sliders that turn.
    terms : RotationTerms
    """

    def __init__(
        self,
        frames: LinkFrames,
        motion: RigidMotion,
        stressed: StressedLinks,
        terms: RotationTerms,
    ) -> None:
        self._frames, self._stressed, self.terms = frames, stressed, terms
        self._motion = frames.displaced(motion, stressed.displacement)
        self._turns = body_turns(frames.links, stressed.displacement)
        self._dependent = frames.dependent_rows(self._motion)
        self._steady = [
            tuple(map(_sparse, (link.mass, link.gyroscopic, link.centrifugal_mass)))
            for link in frames.links
        ]

    def at(self, position: int) -> SparseMatrices:
        """Matrices in one of the positions.

        Parameters
        ----------
        position : int

        Returns
        -------
        SparseMatrices
        """
        terms, size = self.terms, self._frames.size
        mass, rates, total = (csc_array((size, size)) for _ in range(3))
        for number, (inertia, gyroscopic, translational) in enumerate(self._steady):
            speed = self._motion.angular_velocity[position, number]
            acceleration = self._motion.angular_acceleration[position, number]
            if self._turns is not None:
                change = self._inertia_change(number, position)
                inertia, gyroscopic, translational = (
                    own + more
                    for own, more in zip((inertia, gyroscopic, translational), change, strict=True)
                )
            value, rate, centripetal, tangential = self._maps(number, position)
            across = value.T
            tangent, damping = self._stress(number, position)
            if terms.centripetal:
                tangent = tangent - speed**2 * translational
            if terms.tangential:
                tangent = tangent + acceleration * gyroscopic
            mass = mass + across @ (inertia @ value)
            moved = tangent @ value
            if damping is not None:
                rates = rates + across @ (damping @ value)
            if terms.coriolis:
                turning = speed * (gyroscopic @ value) + inertia @ rate
                rates = rates + across @ (2 * turning)
                if damping is not None:
                    moved = moved + damping @ rate
            if terms.centripetal:
                moved = moved + inertia @ centripetal + (2 * speed) * (gyroscopic @ rate)
            if terms.tangential:
                moved = moved + inertia @ tangential
            total = total + across @ moved
        return SparseMatrices(*(csc_array(matrix) for matrix in (mass, rates, total)))

    def _stress(self, number: int, position: int) -> tuple[csc_array, csc_array | None]:
        """Tangent stiffness of a link, and its damping if there is any."""
        stressed = self._stressed
        tangent = _sparse(_at(stressed.tangent[number], position))
        damping = self._frames.links[number].damping
        if stressed.damping is not None:
            damping = _at(stressed.damping[number], position)
        return tangent, _sparse(damping) if damping.any() else None

    def _inertia_change(self, number: int, position: int) -> list[csc_array]:
        """Change of mass, gyroscopic matrix and centrifugal mass by rotated bodies."""
        assert self._turns is not None
        link = self._frames.links[number]
        if not link.bodies:
            return [csc_array((link.size, link.size))] * 3
        rows = csc_array(np.concatenate([body.rows for body in link.bodies]))
        pairs = zip(link.bodies, self._turns[number], strict=True)
        blocks = [body.inertia_change(angle[position]) for body, angle in pairs]
        return [
            csc_array(rows.T @ block_diag(own, "csc") @ rows) for own in zip(*blocks, strict=True)
        ]

    def _maps(self, number: int, position: int) -> list[csc_array]:
        """``N`` of a link and its time derivatives: ``N.``, ``N..`` in its two parts."""
        dependent = self._dependent[number]
        own = self._frames.targets[number].copy()
        for tie in dependent:
            own[tie.rows] = -1
        free = np.flatnonzero(own >= 0)
        shape = (len(own), self._frames.size)
        maps = []
        for name in ("turn", "rate", "centripetal", "tangential"):
            begin = (free, own[free]) if name == "turn" else (free[:0], own[:0])
            maps.append(_map(shape, begin, dependent, name, position))
        return maps


def _at(matrix: LinkMatrix, position: int) -> LinkMatrix:
    """A link matrix (n, n) in one position."""
    if matrix.ndim == 2:
        return matrix
    one = in_positions(matrix, slice(position, position + 1))
    return ChainMatrix(one.elements[0]) if isinstance(one, ChainMatrix) else one[0]


def _sparse(matrix: LinkMatrix) -> csc_array:
    return matrix.sparse() if isinstance(matrix, ChainMatrix) else csc_array(matrix)


def _map(
    shape: tuple[int, int],
    own: tuple[IntArray, IntArray],
    dependent: Sequence[DependentRows],
    name: str,
    position: int,
) -> csc_array:
    """Sparse matrix with ones at places ``own`` and one part of the dependent rows."""
    rows, columns, entries = [own[0]], [own[1]], [np.ones(len(own[0]))]
    for tie in dependent:
        rows.append(np.repeat(tie.rows, len(tie.columns)))
        columns.append(np.tile(tie.columns, len(tie.rows)))
        entries.append(getattr(tie, name)[position].ravel())
    places = (np.concatenate(rows), np.concatenate(columns))
    return csc_array(coo_array((np.concatenate(entries), places), shape=shape))
