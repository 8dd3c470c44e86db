"""Rigid arms between the pins' axis and the nodes of beams whose neutral axis is off it.

A beam stretches and bends without coupling about its neutral axis, so its nodes are there.
All other parts use displacements of the pins' axis. With the neutral axis at the distance
n and the section rotated by phi, a node is at ``u - n sin(phi)``, ``v + n (cos(phi) - 1)``.
The map holds in every frame if phi is the angle against that frame.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from flexmech.arrays import FloatArray

# Coordinates of a node: place along and across, rotation.
PER_NODE = 3


@dataclass(frozen=True)
class Arms:
    """Rigid arms of one link from axis points to nodes, which rotate with the nodes.

    Parameters
    ----------
    length : float
        Distance of the nodes from the axis along the link frame's y in m.
    """

    length: float

    @property
    def inverse(self) -> Arms:
        """Inverse map, from the nodes to the axis points."""
        return Arms(-self.length)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Coordinates of the nodes, less the reference ones.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
            Coordinates of the axis points, less the reference ones.

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = axis.copy()
        angle = axis[..., 2::PER_NODE]
        nodes[..., 0::PER_NODE] -= self.length * np.sin(angle)
        nodes[..., 1::PER_NODE] -= 2 * self.length * np.sin(angle / 2) ** 2
        return nodes

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Velocities of the nodes.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., n)
            Coordinates and velocities of the axis points.

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = rate.copy()
        angle, spin = axis[..., 2::PER_NODE], rate[..., 2::PER_NODE]
        nodes[..., 0::PER_NODE] -= self.length * np.cos(angle) * spin
        nodes[..., 1::PER_NODE] -= self.length * np.sin(angle) * spin
        return nodes

    def force(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Forces on the nodes' coordinates as those on the axis points, ``J' f``.

        Parameters
        ----------
        axis, force : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        on_axis = force.copy()
        angle = axis[..., 2::PER_NODE]
        along, across = force[..., 0::PER_NODE], force[..., 1::PER_NODE]
        on_axis[..., 2::PER_NODE] -= self.length * (along * np.cos(angle) + across * np.sin(angle))
        return on_axis

    def matrix(self, axis: FloatArray, matrix: FloatArray) -> FloatArray:
        """A matrix of the nodes' coordinates in those of the axis points, ``J' X J``.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        matrix : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        size = axis.shape[-1]
        gradient = np.zeros((*axis.shape, size))
        every, angles = np.arange(size), np.arange(2, size, PER_NODE)
        gradient[..., every, every] = 1.0
        gradient[..., angles - 2, angles] = -self.length * np.cos(axis[..., angles])
        gradient[..., angles - 1, angles] = -self.length * np.sin(axis[..., angles])
        return np.asarray(np.swapaxes(gradient, -1, -2) @ matrix @ gradient)

    def tangent(self, axis: FloatArray, stiffness: FloatArray, force: FloatArray) -> FloatArray:
        """Tangent stiffness in coordinates of the axis points.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        stiffness : ndarray, shape (..., n, n)
            Of the nodes.
        force : ndarray, shape (..., n)
            Internal forces on the nodes; the arms that turn change their moments.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        tangent = self.matrix(axis, stiffness)
        angles = np.arange(2, axis.shape[-1], PER_NODE)
        along, across = force[..., angles - 2], force[..., angles - 1]
        turn = axis[..., angles]
        tangent[..., angles, angles] += self.length * (along * np.sin(turn) - across * np.cos(turn))
        return tangent


class _NodeMap(Protocol):
    """Map from a link's coordinates to those of its nodes, less the reference ones."""

    @property
    def inverse(self) -> _NodeMap: ...

    def to_nodes(self, axis: FloatArray, /) -> FloatArray: ...

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray, /) -> FloatArray: ...


class LinkArms:
    """Arms of all links of a mechanism, over the coordinates of all links together.

    Parameters
    ----------
    maps : sequence of _NodeMap or None
        None for a link whose coordinates are those of its nodes.
    coordinates : sequence of slice
        Where each link's coordinates are.
    size : int, optional
        Number of coordinates of all links; where bodies follow them.
    body_coordinates : sequence of int
        Coordinates of links that those of attached bodies are, in order: they come after those
        of all links among Exudyn's.
    """

    def __init__(
        self,
        maps: Sequence[_NodeMap | None],
        coordinates: Sequence[slice],
        size: int | None = None,
        body_coordinates: Sequence[int] = (),
    ) -> None:
        self._links = [(m, own) for m, own in zip(maps, coordinates, strict=True) if m is not None]
        self._size = size
        self._body_coordinates = list(body_coordinates)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Exudyn's coordinates, less the reference ones, of points on the pins' axis.

        Parameters
        ----------
        axis : ndarray, shape (..., size)

        Returns
        -------
        ndarray, shape (..., size)
        """
        return self._mapped(axis, lambda arms, own: arms.to_nodes(axis[..., own]))

    def to_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`to_nodes`.

        Parameters
        ----------
        nodes : ndarray, shape (..., size)

        Returns
        -------
        ndarray, shape (..., size)
        """
        return self._inverse.to_nodes(nodes[..., : self._size])

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Exudyn's velocities of points on the pins' axis.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., size)

        Returns
        -------
        ndarray, shape (..., size)
        """
        return self._mapped(
            rate, lambda arms, own: arms.rate_to_nodes(axis[..., own], rate[..., own])
        )

    def rate_to_axis(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Inverse of :meth:`rate_to_nodes`.

        Parameters
        ----------
        nodes, rate : ndarray, shape (..., size)

        Returns
        -------
        ndarray, shape (..., size)
        """
        return self._inverse.rate_to_nodes(nodes, rate)

    @cached_property
    def _inverse(self) -> LinkArms:
        """Inverse map from the nodes to the axis points, without bodies."""
        return LinkArms([arms.inverse for arms, _ in self._links], [own for _, own in self._links])

    def _mapped(
        self, values: FloatArray, mapped: Callable[[_NodeMap, slice], FloatArray]
    ) -> FloatArray:
        """Values mapped link by link, with those of attached bodies appended."""
        nodes = values.copy() if self._links else values
        for arms, own in self._links:
            nodes[..., own] = mapped(arms, own)
        if not self._body_coordinates:
            return nodes
        return np.concatenate([nodes, values[..., self._body_coordinates]], axis=-1)
