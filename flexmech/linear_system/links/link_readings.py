"""Displacements, rotations and curvature of a link from its coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.mesh import curvature_at, shapes_at, station_shapes

# Of the shortest element: the slope of a cubic is off by the square of it, the difference of its
# deflections by round-off over it, both 1e-8 or less.
SMALL = 1e-4


@dataclass(frozen=True)
class LinkReadings:
    """Displacement, rotation and curvature rows of one link, computed on first use.

    Parameters
    ----------
    nodes : ndarray, shape (k,)
        Node positions in m.
    per_node : int
        Coordinates a node.
    displacement_shapes : callable
        Displacement inside elements; see :func:`flexmech.mesh.station_shapes`.
    slope : int
        Which of a node's coordinates is its slope or rotation.
    deflection : int, optional
        Which is its deflection, where the slope is that of the axis; see
        :func:`flexmech.mesh.curvature_at`.
    basis : ndarray, shape (n_full, n), optional
        From a reduced link's coordinates to those of the nodes.
    element_maps : ndarray, shape (k - 1, 2 per_node, 2 per_node), optional
        Coordinates of each element by those of its two nodes, where they are not the same.
    polar : ndarray of int, shape (k,)
        First coordinates of slope vectors that are given by their stretch and their angle.
    """

    nodes: FloatArray
    per_node: int
    displacement_shapes: Callable[[FloatArray, FloatArray], FloatArray]
    slope: int
    deflection: int | None
    basis: FloatArray | None = None
    element_maps: FloatArray | None = None
    polar: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.intp))

    def with_slope_vectors(self, displacement: FloatArray) -> FloatArray:
        """Coordinates (..., n_full) of the nodes with their slope vectors, at finite rotations.

        Rows of displacement and rotation are linear in these.
        """
        moved = displacement.copy()
        stretch, angle = 1.0 + displacement[..., self.polar], displacement[..., self.polar + 1]
        moved[..., self.polar] = stretch * np.cos(angle) - 1.0
        moved[..., self.polar + 1] = stretch * np.sin(angle)
        return moved

    @cached_property
    def shape(self) -> FloatArray:
        """Displacement at evenly spaced stations from start to end, (n_stations, 2, n)."""
        mesh = self.nodes, self.per_node, self.displacement_shapes, self.element_maps
        return self._reduced(station_shapes(*mesh))

    @cached_property
    def curvature(self) -> FloatArray:
        """Bending curvature in the middle of the link, (n,)."""
        (middle,) = self.curvatures_at(self.nodes[-1:] / 2)
        return np.asarray(middle)

    def curvatures_at(self, places: FloatArray) -> FloatArray:
        """Bending curvature at places (s,) in m from the link's start, (s, n)."""
        mesh = self.nodes, self.per_node, self.slope, self.deflection
        return self._reduced(np.stack([curvature_at(place, *mesh) for place in places.tolist()]))

    def displacement_at(self, fraction: FloatArray) -> FloatArray:
        """Displacement along and across at fractions (s,) of the link's length, (s, 2, n)."""
        places = np.asarray(fraction, dtype=float) * self.nodes[-1]
        return self._reduced(self._shapes_at(places))

    def rotation_at(self, fraction: float) -> FloatArray:
        """Rotation at a fraction of the link's length, (n,): of the node there, or of the axis."""
        return np.asarray(self.rotations_at(np.array([fraction]))[0])

    def rotations_at(self, fraction: FloatArray) -> FloatArray:
        """Rotation at fractions (s,) of the link's length, (s, n): of nodes, or of the axis."""
        nodes, places = self.nodes, np.asarray(fraction, dtype=float) * self.nodes[-1]
        nearest = np.abs(nodes - places[:, None]).argmin(axis=1)
        at_node = np.abs(nodes[nearest] - places) <= SAME_PLACE * nodes[-1]
        # Inside an element the axis is a cubic: a small difference is as good as its slope.
        step = SMALL * float(np.diff(nodes).min())
        before, after = (self._shapes_at(places + side)[:, 1] for side in (-step, step))
        rows = (after - before) / (2 * step)
        rows[at_node] = 0.0
        rows[at_node, self.per_node * nearest[at_node] + self.slope] = 1.0
        return self._reduced(rows)

    def projected(self, basis: FloatArray) -> LinkReadings:
        """The same with ``q = basis @ p``; basis (n, m)."""
        return replace(self, basis=basis if self.basis is None else self.basis @ basis)

    def _shapes_at(self, places: FloatArray) -> FloatArray:
        return shapes_at(
            places, self.nodes, self.per_node, self.displacement_shapes, self.element_maps
        )

    def _reduced(self, nodal: FloatArray) -> FloatArray:
        return nodal if self.basis is None else np.asarray(nodal @ self.basis)
