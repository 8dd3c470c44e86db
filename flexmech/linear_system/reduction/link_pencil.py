"""The quadratic pencil of unreduced links, applied to shapes link by link.

``(lambda^2 M + lambda C + K) x`` without matrices of the whole linkage: with ``q = N z`` of each
link, the force on it in its frame is::

    lambda^2 M q + lambda ((2 omega S + D) q + 2 M N' z)
        + (K - omega^2 M_t + alpha S) q + (2 omega S + D) N' z + M N'' z

See :mod:`flexmech.linear_system.joints.link_frames`, whose matrices these are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.link_place import DependentRows
from flexmech.linear_system.links.chains import LinkMatrix, as_given, as_real, whole
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linkages import RigidMotion

Shapes = list[NDArray[Any]]
"""Vectors of each link, (B, n_link, m)."""


@dataclass(frozen=True)
class LinkPencil:
    """Mass, damping and stiffness of unreduced links in B positions.

    Parameters
    ----------
    frames : LinkFrames
        Of links that are all elastic, without bodies off the axis that turn.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
        In these positions.
    terms : RotationTerms
    """

    frames: LinkFrames
    motion: RigidMotion
    stressed: StressedLinks
    terms: RotationTerms

    def forces(self, z: NDArray[Any]) -> tuple[Shapes, Shapes, Shapes]:
        """Forces on the links by acceleration, velocity and displacement of shapes.

        Parameters
        ----------
        z : ndarray, shape (B, size, m)
            Independent coordinates.

        Returns
        -------
        tuple of list of ndarray, shape (B, n_link, m)
            The coefficients of ``lambda^2``, ``lambda`` and 1.
        """
        columns = as_real(z)
        every: tuple[Shapes, Shapes, Shapes] = ([], [], [])
        dependent = self.frames.dependent_rows(self.motion)
        shapes = self.frames.link_coordinates(self.motion, columns)
        for number, (link, q) in enumerate(zip(self.frames.links, shapes, strict=True)):
            ends = self._dependent_ends(dependent[number], columns)
            for found, own in zip(every, self._on_link(number, link, q, ends), strict=True):
                found.append(as_given(own, z))
        return every

    def projected(
        self, z: NDArray[Any], forces: Sequence[Shapes]
    ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Mass, damping and stiffness by the amplitudes of shapes.

        Parameters
        ----------
        z : ndarray, shape (B, size, m)
            Independent coordinates.
        forces : sequence of list of ndarray, shape (B, n_link, m)
            What :meth:`forces` gives for them.

        Returns
        -------
        tuple of ndarray, shape (B, m, m)
        """
        across = [
            np.conj(np.swapaxes(q, 1, 2)) for q in self.frames.link_coordinates(self.motion, z)
        ]
        mass, damping, stiffness = (
            np.asarray(sum(own @ force for own, force in zip(across, of_links, strict=True)))
            for of_links in forces
        )
        return mass, damping, stiffness

    def _dependent_ends(
        self, dependent: Sequence[DependentRows], z: FloatArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Rows (k,) of a link's dependent ends, and ``N' z`` and ``N'' z`` in them, (B, k, m).

        In all other rows they are zero; ``N''`` has the terms that are counted.
        """
        rows = [np.zeros(0, dtype=np.intp)] + [tie.rows for tie in dependent]
        none = np.zeros((len(z), 0, z.shape[2]))
        rate = [none] + [tie.rate @ z[:, tie.columns] for tie in dependent]
        change = [np.zeros_like(own) for own in rate]
        if self.terms.centripetal or self.terms.tangential:
            change[1:] = [tie.acceleration(self.terms) @ z[:, tie.columns] for tie in dependent]
        return np.concatenate(rows), np.concatenate(rate, axis=1), np.concatenate(change, axis=1)

    def _on_link(
        self,
        number: int,
        link: LinkModel,
        q: FloatArray,
        ends: tuple[IntArray, FloatArray, FloatArray],
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces on a link by its coordinates, their rates by its ends, and those of these."""
        terms, (rows, rate, change) = self.terms, ends
        mass, gyroscopic = whole(link.mass), whole(link.gyroscopic)
        inertia = mass @ q
        by_rate, by_place = np.zeros_like(q), self._tangent(number, link) @ q
        damping = self._damping(number, link)
        if damping.any():
            by_rate += damping @ q
            if terms.coriolis:
                by_place += damping[..., rows] @ rate
        speed = self.motion.angular_velocity[:, number, None, None]
        if terms.coriolis or terms.tangential:
            momentum = gyroscopic @ q
        if terms.coriolis:
            by_rate += 2 * (speed * momentum)
            if len(rows):
                by_rate += 2 * mass[:, rows] @ rate
        if terms.centripetal:
            by_place -= speed**2 * (whole(link.centrifugal_mass) @ q)
            if len(rows):
                by_place += 2 * gyroscopic[:, rows] @ (speed * rate)
        if terms.tangential:
            by_place += self.motion.angular_acceleration[:, number, None, None] * momentum
        if (terms.centripetal or terms.tangential) and len(rows):
            by_place += mass[:, rows] @ change
        return inertia, by_rate, by_place

    def _tangent(self, number: int, link: LinkModel) -> FloatArray:
        own: LinkMatrix = link.stiffness
        return whole(own if self.stressed.unstressed else self.stressed.tangent[number])

    def _damping(self, number: int, link: LinkModel) -> FloatArray:
        own = self.stressed.damping
        return whole(link.damping if own is None else own[number])
