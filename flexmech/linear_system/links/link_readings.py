"""Displacements, rotations and curvature of a link from its coordinates.

Across the frame of a link that bends by finite angles, its axis of arc length s is displaced by
v(s), with ``v' = sin(theta)`` where it does not stretch, so that ``kappa = theta' = v'' /
cos(theta)``; Antman, *Nonlinear Problems of Elasticity*, 2nd ed. 2005, ch. 4.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.mesh import curvature_at, shapes_at, station_shapes

# Of the shortest element: the slope of a cubic is off by the square of it, the difference of its
# deflections by round-off over it, both 1e-8 or less.
SMALL = 1e-4
# Nodes that determine the curvature at a place.
CURVATURE_NODES = 3


@dataclass(frozen=True)
class LinkReadings:
    """Displacement, rotation and curvature rows of one link, computed on first use.

    Parameters
    ----------
    nodes : ndarray, shape (k,)
        Node positions in m; (D, k) of a link of several designs, of which nothing is read.
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

    @property
    def _own_nodes(self) -> FloatArray:
        """Nodes of one link; those of several designs are at different places."""
        if self.nodes.ndim > 1:
            raise TypeError("displacements are read of one design, and not of a stack")
        return self.nodes

    @cached_property
    def shape(self) -> FloatArray:
        """Displacement at evenly spaced stations from start to end, (n_stations, 2, n)."""
        mesh = self._own_nodes, self.per_node, self.displacement_shapes, self.element_maps
        return self._reduced(station_shapes(*mesh))

    @cached_property
    def curvature(self) -> FloatArray:
        """Bending curvature in the middle of the link, (n,)."""
        (middle,) = self.curvatures_at(self._own_nodes[-1:] / 2)
        return np.asarray(middle)

    def curvatures_at(self, places: FloatArray) -> FloatArray:
        """Bending curvature at places (s,) in m from the link's start, (s, n)."""
        mesh = self._own_nodes, self.per_node, self.slope, self.deflection
        return self._reduced(np.stack([curvature_at(place, *mesh) for place in places.tolist()]))

    def bent_curvature(
        self,
        displacement: FloatArray,
        places: FloatArray,
        kinks: Sequence[float],
        slope_vectors: IntArray,
    ) -> FloatArray:
        """Bending curvature at finite rotations, where the axis turns in its frame.

        Parameters
        ----------
        displacement : ndarray, shape (B, n)
            Of an elastic link of one design.
        places : ndarray, shape (s,)
            From the link's start in m.
        kinks : sequence of float
            Places in m at which something acts, and the slope of the curvature jumps: it is read
            from nodes on one side of them.
        slope_vectors : ndarray of int, shape (k,)
            Coordinates across of all vectors; see :class:`flexmech.linear_system.LinkModel`.

        Returns
        -------
        ndarray, shape (B, s)
            In 1/m, positive where it curves the link towards the y axis of its frame.
        """
        readings, q = self, displacement
        if self.basis is not None:
            readings, q = replace(self, basis=None), q @ self.basis.T
        q = readings.with_slope_vectors(q)
        rows = readings._curvatures_between(kinks, places)
        if self.deflection is None:
            # Sections that shear turn by their rotations alone, which are angles.
            return np.asarray(q @ rows.T)
        slope = q @ readings.rotations_at(places / self.nodes[-1]).T
        if self.slope in slope_vectors:
            # Slope vectors have the sine itself, but for the strain.
            return np.asarray(q @ rows.T / np.sqrt(1.0 - np.clip(slope, -1.0, 1.0) ** 2))
        q = q.copy()
        q[:, self.slope :: self.per_node] = np.sin(q[:, self.slope :: self.per_node])
        return np.asarray(q @ rows.T / np.cos(slope))

    def _curvatures_between(self, kinks: Sequence[float], places: FloatArray) -> FloatArray:
        """:meth:`curvatures_at` by nodes on one side of kinks, (s, n)."""
        nodes, per_node = self.nodes, self.per_node
        near = SAME_PLACE * float(nodes[-1])
        ends = np.unique([0.0, *kinks, float(nodes[-1])])
        side = np.clip(np.searchsorted(ends, places, side="right") - 1, 0, len(ends) - 2)
        rows = np.zeros((len(places), per_node * len(nodes)))
        for number in np.unique(side):
            first, last = ends[number] - near, ends[number + 1] + near
            (span,) = np.nonzero((nodes >= first) & (nodes <= last))
            here = side == number
            if len(span) < CURVATURE_NODES:
                rows[here] = self.curvatures_at(places[here])
                continue
            columns, start = slice(per_node * span[0], per_node * (span[-1] + 1)), nodes[span[0]]
            between = replace(self, nodes=nodes[span] - start)
            rows[here, columns] = between.curvatures_at(places[here] - start)
        return rows

    def displacement_at(self, fraction: FloatArray) -> FloatArray:
        """Displacement along and across at fractions (s,) of the link's length, (s, 2, n)."""
        places = np.asarray(fraction, dtype=float) * self._own_nodes[-1]
        return self._reduced(self._shapes_at(places))

    def rotation_at(self, fraction: float) -> FloatArray:
        """Rotation at a fraction of the link's length, (n,): of the node there, or of the axis."""
        return np.asarray(self.rotations_at(np.array([fraction]))[0])

    def rotations_at(self, fraction: FloatArray) -> FloatArray:
        """Rotation at fractions (s,) of the link's length, (s, n): of nodes, or of the axis."""
        nodes, places = self._own_nodes, np.asarray(fraction, dtype=float) * self._own_nodes[-1]
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
            places, self._own_nodes, self.per_node, self.displacement_shapes, self.element_maps
        )

    def _reduced(self, nodal: FloatArray) -> FloatArray:
        return nodal if self.basis is None else np.asarray(nodal @ self.basis)
