"""Unreduced links without matrices of the whole linkage: their static response, and their pencil.

By these the error of component modes is measured (inverse iteration). Forces inside a link
displace it as one whose ends are held (its flexibility), and push its ends as its constraint modes
say (Guyan 1965). What is left is a small system of the ends alone. That is exact.

The pencil ``(lambda^2 M + lambda C + K) x`` is applied to shapes link by link: with ``q = N z`` of
each link, the force on it in its frame is::

    lambda^2 M q + lambda ((2 omega S + D) q + 2 M N' z)
        + (K - omega^2 M_t + alpha S) q + (2 omega S + D) N' z + M N'' z

See :mod:`flexmech.mechanics.joints.link_frames`, whose matrices these are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion, Topology
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.links.component_modes import (
    FixedInterfaceLink,
    constraint_modes,
)
from flexmech.mechanics.links.link_model import LinkModel, StressedLinks
from flexmech.mechanics.links.rotation_terms import RotationTerms


@dataclass(frozen=True)
class StaticResponse:
    """Displacements of elastic links in B positions of their linkage, by forces on them.

    Parameters
    ----------
    topology : Topology
        Topology of links that are all elastic.
    links : sequence of FixedInterfaceLink
    motion : RigidMotion
        Batch of shape (B,).
    tangent : sequence of ndarray, optional
        Tangent stiffness (n, n) or (B, n, n) of each link; that of straight links by default.
    """

    topology: Topology
    links: Sequence[FixedInterfaceLink]
    motion: RigidMotion
    tangent: Sequence[FloatArray] | None = None

    @cached_property
    def _modes(self) -> list[tuple[FloatArray, FloatArray]]:
        """Constraint modes (..., n, b) and flexibility (..., n, n) of each link."""
        if self.tangent is None:
            return [(link.constraint_modes, link.flexibility) for link in self.links]
        return [
            constraint_modes(tangent, link.boundary.unit, link.boundary.inner)
            for link, tangent in zip(self.links, self.tangent, strict=True)
        ]

    @cached_property
    def _ends(self) -> tuple[LinkFrames, FloatArray]:
        """Frames of the links condensed to their ends, and flexibility (B, e, e) of these."""
        tangent = self.tangent or [own.link.stiffness for own in self.links]
        stiffness = [
            np.swapaxes(modes, -1, -2) @ (matrix @ modes)
            for (modes, _), matrix in zip(self._modes, tangent, strict=True)
        ]
        # The links by their ends alone, whose stiffness is given.
        ends = [own.link.projected(own.boundary.unit, own.boundary.kept) for own in self.links]
        frames = LinkFrames(self.topology, ends)
        still = RotationTerms.all_or_none(False)
        matrices = frames.assemble(self.motion, stiffness, still)
        return frames, np.asarray(np.linalg.inv(matrices.stiffness))

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
        real = [_as_real(force) for force in forces]
        frames, flexibility = self._ends
        pairs = zip(self._modes, real, strict=True)
        on_ends = [np.swapaxes(modes, -1, -2) @ force for (modes, _), force in pairs]
        z = flexibility @ frames.gather(self.motion, on_ends)
        ends = frames.link_coordinates(self.motion, z)
        moved = [
            modes @ end + inner @ force
            for (modes, inner), end, force in zip(self._modes, ends, real, strict=True)
        ]
        return [_as_given(*pair) for pair in zip(moved, forces, strict=True)]


Shapes = list[NDArray[Any]]
"""Vectors of each link, (B, n_link, m)."""


@dataclass(frozen=True)
class LinkPencil:
    """Mass, damping and stiffness of unreduced links in B positions.

    Parameters
    ----------
    frames : LinkFrames
        Frames of links that are all elastic, without bodies off the axis that turn.
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
        columns = _as_real(z)
        every: tuple[Shapes, Shapes, Shapes] = ([], [], [])
        shapes = self.frames.link_coordinates(self.motion, columns)
        for number, (link, q) in enumerate(zip(self.frames.links, shapes, strict=True)):
            ends = self.frames.end_rates(self.motion, number, columns, self.terms)
            for found, own in zip(every, self._on_link(number, link, q, ends), strict=True):
                found.append(_as_given(own, z))
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

    def _on_link(
        self,
        number: int,
        link: LinkModel,
        q: FloatArray,
        ends: tuple[IntArray, FloatArray, FloatArray],
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces on a link by its coordinates, their rates by its ends, and those of these."""
        terms, (rows, rate, change) = self.terms, ends
        mass, gyroscopic, stressed = link.mass, link.gyroscopic, self.stressed
        inertia = mass @ q
        tangent = link.stiffness if stressed.unstressed else stressed.tangent[number]
        damping = link.damping if stressed.damping is None else stressed.damping[number]
        by_rate, by_place = np.zeros_like(q), tangent @ q
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
                by_rate += 2 * mass[..., rows] @ rate
        if terms.centripetal:
            by_place -= speed**2 * (link.centrifugal_mass @ q)
            if len(rows):
                by_place += 2 * gyroscopic[..., rows] @ (speed * rate)
        if terms.tangential:
            by_place += self.motion.angular_acceleration[:, number, None, None] * momentum
        if (terms.centripetal or terms.tangential) and len(rows):
            by_place += mass[..., rows] @ change
        return inertia, by_rate, by_place


def _as_real(columns: NDArray[Any]) -> FloatArray:
    """Columns (B, n, m), each complex one as two: its real and its imaginary part."""
    return np.ascontiguousarray(columns).view(float)


def _as_given(real: FloatArray, columns: NDArray[Any]) -> NDArray[Any]:
    """Columns (B, n, m) of the type of ``columns`` from their real and imaginary parts."""
    return np.ascontiguousarray(real).view(columns.dtype)
