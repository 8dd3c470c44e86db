"""Static response of a linkage's unreduced links, by condensation to their joined ends.

Forces inside a link displace it as one whose ends are held (its flexibility), and push its ends as
its constraint modes say (Guyan 1965). What is left is a small system of the ends alone. That is
exact, and no matrix of the whole linkage is made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.links.chains import LinkMatrix, as_given, as_real, whole
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linear_system.reduction.fixed_interface_modes import FixedInterfaceLink, static_modes
from flexmech.linkages import RigidMotion, Topology


@dataclass(frozen=True)
class CondensedLink:
    """A link condensed to its joined ends.

    Parameters
    ----------
    model : LinkModel
        By the displacements of these ends.
    constraint_modes : ndarray, shape (..., n, b)
        Static displacement by a unit of each of them.
    flexibility : ndarray, shape (..., n, n)
        With its joined ends held.
    """

    model: LinkModel
    constraint_modes: FloatArray
    flexibility: FloatArray

    @classmethod
    def of(cls, fixed: FixedInterfaceLink, tangent: LinkMatrix | None) -> Self:
        """Condense a flexible link.

        Parameters
        ----------
        fixed : FixedInterfaceLink
            The straight link.
        tangent : ndarray, shape (n, n) or (B, n, n), optional
            Its tangent stiffness; that of the straight link by default.

        Returns
        -------
        CondensedLink
        """
        link, stiffness = fixed.link, fixed.link.stiffness
        inner, modes = fixed.flexibility, fixed.constraint_modes
        if tangent is not None:
            stiffness, (inner, modes) = tangent, static_modes(fixed.boundary, tangent)
        own = np.swapaxes(modes, -1, -2) @ (whole(stiffness) @ modes)
        flexibility = np.zeros(stiffness.shape)
        flexibility[..., inner.free[:, None], inner.free] = inner.matrix
        return cls(link.held_by(fixed.boundary.kept, own), modes, flexibility)


@dataclass(frozen=True)
class StaticResponse:
    """Displacements of elastic links in B positions of their linkage, by forces on them.

    Parameters
    ----------
    topology : Topology
        Of links that are all elastic.
    links : sequence of FixedInterfaceLink
    motion : RigidMotion
        Batch of shape (B,).
    tangent : sequence of ndarray, optional
        Tangent stiffness (n, n) or (B, n, n) of each link; that of straight links by default.
    """

    topology: Topology
    links: Sequence[FixedInterfaceLink]
    motion: RigidMotion
    tangent: Sequence[LinkMatrix] | None = None

    @cached_property
    def _condensed(self) -> list[CondensedLink]:
        tangent: Sequence[LinkMatrix | None] = self.tangent or [None] * len(self.links)
        return [CondensedLink.of(*pair) for pair in zip(self.links, tangent, strict=True)]

    @cached_property
    def _frames(self) -> LinkFrames:
        return LinkFrames(self.topology, [link.model for link in self._condensed])

    @cached_property
    def _flexibility(self) -> FloatArray:
        """Of the ends, (B, e, e)."""
        still = RotationTerms.all_or_none(False)
        stiffness = [link.model.stiffness for link in self._condensed]
        matrices = self._frames.assemble(self.motion, stiffness, still)
        return np.asarray(np.linalg.inv(matrices.stiffness), dtype=float)

    def displacements(self, forces: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
        """Displacements of all links.

        Parameters
        ----------
        forces : sequence of ndarray, shape (B, n_link, m)
            Each column a load, in the frame of its link; real or complex.

        Returns
        -------
        list of ndarray, shape (B, n_link, m)
        """
        found = self._displacements([as_real(force) for force in forces])
        return [as_given(*pair) for pair in zip(found, forces, strict=True)]

    def _displacements(self, forces: Sequence[FloatArray]) -> list[FloatArray]:
        on_ends = [
            np.swapaxes(link.constraint_modes, -1, -2) @ force
            for link, force in zip(self._condensed, forces, strict=True)
        ]
        z = self._flexibility @ self._frames.gather(self.motion, on_ends)
        moved = []
        ends = self._frames.link_coordinates(self.motion, z)
        for link, force, end in zip(self._condensed, forces, ends, strict=True):
            moved.append(link.constraint_modes @ end + link.flexibility @ force)
        return moved
