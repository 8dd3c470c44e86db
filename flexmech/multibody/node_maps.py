"""Maps from the coordinates of links to those of Exudyn's nodes, where these are not the same.

A beam stretches and bends without coupling about its neutral axis, so its nodes are there, and all
other parts use displacements of the pins' axis. With the neutral axis at the distance n and the
section rotated by phi, a node is at ``u - n sin(phi)``, ``v + n (cos(phi) - 1)``.

A cable's node has a slope vector ``(1 + s_x, s_y)``. A weld keeps the angle between two such
vectors, and a body on a node turns with one; the stretch of each is the link's own. By stretch e
and angle phi,

    s_x = (1 + e) cos(phi) - 1,    s_y = (1 + e) sin(phi),

such a condition is linear: two angles differ by a constant. Its forces then add nothing to the
tangent stiffness but what this map adds, second derivatives of the slope times the forces on it.
To first order about the straight link both pairs of coordinates are the same.

Both maps hold in every frame if phi is the angle against that frame.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np

from flexmech.arrays import FloatArray, IntArray


class NodeMap(ABC):
    """Map of links, block by block of their coordinates, less the reference ones.

    Parameters
    ----------
    first : ndarray of int, shape (k,)
        First coordinate of each block; all coordinates in no block are the nodes' own.
    length : float or ndarray, shape (k,)
        Distance of the nodes from the axis along the link frame's y in m.
    """

    block: ClassVar[int]
    """Coordinates of a block."""

    def __init__(self, first: IntArray, length: float | FloatArray = 0.0) -> None:
        self.first, self.length = first, length
        self.at = first[:, None] + np.arange(self.block)

    @classmethod
    def joined(cls, maps: Sequence[tuple[NodeMap, int]]) -> Self:
        """Map of several links, each with its first coordinate among those of all."""
        none: list[IntArray] = [np.zeros(0, dtype=np.intp)]
        first = [one.first + start for one, start in maps]
        length = [np.full(len(one.first), one.length) for one, _ in maps]
        return cls(np.concatenate(first or none), np.concatenate(length or none))

    @abstractmethod
    def of_nodes(self, q: FloatArray) -> FloatArray:
        """Nodes' coordinates of blocks q, (..., k, b)."""

    @abstractmethod
    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`of_nodes`."""

    @abstractmethod
    def gradient(self, q: FloatArray) -> FloatArray:
        """Derivative of the nodes' coordinates by those of blocks q, (..., k, b, b)."""

    @abstractmethod
    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """Second derivative of the work of constant forces (..., k, b), (..., k, b, b)."""

    def gradient_rate(self, q: FloatArray, rate: FloatArray) -> FloatArray:
        """Time derivative of :meth:`gradient` at rates (..., k, b) of blocks, (..., k, b, b)."""
        units = np.eye(self.block)
        rows = [self.curvature(q, np.broadcast_to(u, q.shape)) @ rate[..., None] for u in units]
        return np.stack([row[..., 0] for row in rows], axis=-2)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Coordinates of the nodes.

        Parameters
        ----------
        axis : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = axis.copy()
        nodes[..., self.at] = self.of_nodes(axis[..., self.at])
        return nodes

    def to_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`to_nodes`; angles are within half a turn.

        Parameters
        ----------
        nodes : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        axis = nodes.copy()
        axis[..., self.at] = self.of_axis(nodes[..., self.at])
        return axis

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Velocities of the nodes.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        return self._rates(self.gradient(axis[..., self.at]), rate)

    def rate_to_axis(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Inverse of :meth:`rate_to_nodes` by the coordinates and velocities of the nodes.

        Parameters
        ----------
        nodes, rate : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        gradient = self.gradient(self.of_axis(nodes[..., self.at]))
        return self._rates(np.asarray(np.linalg.inv(gradient), dtype=float), rate)

    def force(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Forces on the nodes' coordinates as those on the link's, ``J' f``.

        Parameters
        ----------
        axis, force : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        return self._rates(np.swapaxes(self.gradient(axis[..., self.at]), -1, -2), force)

    def matrix(self, axis: FloatArray, matrix: FloatArray) -> FloatArray:
        """A matrix of the nodes' coordinates in those of the link, ``J' X J``.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        matrix : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        whole = self._gradient_of_all(axis)
        return np.asarray(np.swapaxes(whole, -1, -2) @ matrix @ whole)

    def tangent(self, axis: FloatArray, stiffness: FloatArray, force: FloatArray) -> FloatArray:
        """Tangent stiffness in the link's coordinates.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        stiffness : ndarray, shape (..., n, n)
            Of the nodes.
        force : ndarray, shape (..., n)
            Internal forces on the nodes, less outer ones that keep their direction.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        tangent, at = self.matrix(axis, stiffness), self.at
        tangent[..., at[:, :, None], at[:, None]] += self.curvature(axis[..., at], force[..., at])
        return tangent

    def damping_stiffness(
        self, axis: FloatArray, rate: FloatArray, stiffness: FloatArray, damping: FloatArray
    ) -> FloatArray:
        """Derivative of damping forces ``J' D J q.`` by the link's coordinates q.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., n)
        stiffness, damping : ndarray, shape (..., n, n)
            Derivatives of the forces on the nodes by their coordinates and by their velocities.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        whole, at = self._gradient_of_all(axis), self.at
        changing = np.zeros_like(whole)
        turning = self.gradient_rate(axis[..., at], rate[..., at])
        changing[..., at[:, :, None], at[:, None]] = turning
        force = (damping @ self.rate_to_nodes(axis, rate)[..., None])[..., 0]
        by_rate = np.swapaxes(whole, -1, -2) @ damping @ changing
        return self.tangent(axis, stiffness, force) + np.asarray(by_rate)

    def _gradient_of_all(self, axis: FloatArray) -> FloatArray:
        """Derivative of all nodes' coordinates by those of the link, (..., n, n)."""
        whole = np.zeros((*axis.shape, axis.shape[-1]))
        whole[..., :, :] = np.eye(axis.shape[-1])
        whole[..., self.at[:, :, None], self.at[:, None]] = self.gradient(axis[..., self.at])
        return whole

    def _rates(self, matrices: FloatArray, values: FloatArray) -> FloatArray:
        mapped = values.copy()
        mapped[..., self.at] = (matrices @ values[..., self.at, None])[..., 0]
        return mapped


class Arms(NodeMap):
    """Rigid arms from points on the pins' axis to the nodes, which turn with the sections.

    The blocks are the coordinates of each node; see :class:`NodeMap`.
    """

    block = 3

    def of_nodes(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        return self._moved(q, 1.0)

    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        return self._moved(nodes, -1.0)

    def gradient(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        gradient = np.zeros((*q.shape, 3))
        gradient[..., :, :] = np.eye(3)
        gradient[..., 0, 2] = -self.length * np.cos(q[..., 2])
        gradient[..., 1, 2] = -self.length * np.sin(q[..., 2])
        return gradient

    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        curvature, angle = np.zeros((*q.shape, 3)), q[..., 2]
        turned = force[..., 0] * np.sin(angle) - force[..., 1] * np.cos(angle)
        curvature[..., 2, 2] = self.length * turned
        return curvature

    def _moved(self, q: FloatArray, sign: float) -> FloatArray:
        moved, length = q.copy(), sign * self.length
        moved[..., 0] -= length * np.sin(q[..., 2])
        moved[..., 1] -= 2 * length * np.sin(q[..., 2] / 2) ** 2
        return moved


class PolarSlopes(NodeMap):
    """Stretch and angle of the slope as coordinates of nodes of cables.

    The blocks are the stretch and the angle of each; see :class:`NodeMap`.
    """

    block = 2

    def of_nodes(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        stretch, angle = q[..., 0], q[..., 1]
        # (1 + e) cos(phi) - 1, whose digits a difference of ones would lose.
        nodes = np.empty_like(q)
        nodes[..., 0] = stretch * np.cos(angle) - 2 * np.sin(angle / 2) ** 2
        nodes[..., 1] = (1 + stretch) * np.sin(angle)
        return nodes

    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        x, y, axis = 1 + nodes[..., 0], nodes[..., 1], np.empty_like(nodes)
        axis[..., 0], axis[..., 1] = np.hypot(x, y) - 1, np.arctan2(y, x)
        return axis

    def gradient(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        length, cosine, sine = 1 + q[..., 0], np.cos(q[..., 1]), np.sin(q[..., 1])
        rows = [[cosine, -length * sine], [sine, length * cosine]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))

    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        cosine, sine = np.cos(q[..., 1]), np.sin(q[..., 1])
        x, y = force[..., 0], force[..., 1]
        along, across = x * cosine + y * sine, y * cosine - x * sine
        rows = [[np.zeros_like(along), across], [across, -(1 + q[..., 0]) * along]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


class LinkNodes:
    """Map from coordinates of all links together to Exudyn's, less the reference ones.

    Parameters
    ----------
    mapped : NodeMap
        Of all links.
    size : int
        Number of coordinates of all links.
    bodies : sequence of int
        Coordinates of links that those of attached bodies are, in order: they come after those
        of all links among Exudyn's.
    """

    def __init__(self, mapped: NodeMap, size: int, bodies: Sequence[int]) -> None:
        self._map, self._links, self._bodies = mapped, slice(0, size), list(bodies)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Exudyn's coordinates (..., system_size) of links (..., size)."""
        return np.concatenate([self._map.to_nodes(axis), axis[..., self._bodies]], axis=-1)

    def to_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`to_nodes`, (..., size)."""
        return self._map.to_axis(nodes[..., self._links])

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Exudyn's velocities (..., system_size) of links (..., size)."""
        moved = self._map.rate_to_nodes(axis, rate)
        return np.concatenate([moved, rate[..., self._bodies]], axis=-1)

    def rate_to_axis(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Inverse of :meth:`rate_to_nodes`, (..., size)."""
        return self._map.rate_to_axis(nodes[..., self._links], rate[..., self._links])
