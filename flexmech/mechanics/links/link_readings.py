"""Displacements, rotations, curvature and second-order stretch of a link from its coordinates.

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
from flexmech.linkages.inverse_dynamics import RANK_TOLERANCE
from flexmech.mesh import curvature_at, shapes_at, station_shapes

# Part of the shortest element: the slope of a cubic is off by the square of it, the difference of
# its deflections by round-off over it, both 1e-8 or less.
SMALL = 1e-4
# Nodes that determine the curvature at a place.
CURVATURE_NODES = 3


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
            Displacement of an elastic link.
        places : ndarray, shape (s,)
            From the link's start in m.
        kinks : sequence of float
            Places in m at which something acts, and the slope of the curvature jumps: it is read
            from nodes on one side of them.
        slope_vectors : ndarray of int, shape (k,)
            Coordinates across of all vectors; see :class:`flexmech.mechanics.LinkModel`.

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


@dataclass(frozen=True)
class LinkStretch:
    """Second-order axial strains of one link, scaled so that their squares are energies.

    A straight link that bends is, to second order, longer than its chord by half the integral of
    the squared slope (von Karman 1910; Crisfield, *Non-linear Finite Element Analysis of Solids
    and Structures*, vol. 1, 1991, ch. 7). Bending itself stays linear; tension and its work
    against the slopes do not.

    Each of the ``s`` strains ``gradient @ q + weights @ (slopes @ q)**2 / 2`` is a mean over a
    part of the link times the square root of that part's stiffness, ``EA`` times length: the
    strain energy is half the sum of their squares, and each strain equals its tension. A link with
    large rotations has bending strains among them.

    Parameters
    ----------
    gradient : ndarray, shape (s, n)
        Linear part.
    slopes : ndarray, shape (g, n)
        Slopes whose squares count.
    weights : ndarray, shape (s, g)
    damping_time : ndarray, shape (s,)
        Kelvin-Voigt: a tension is its strain plus this time in s its rate.
    neutral_axis : float
        Distance of the axis whose strains they are from that of the link in m.
    """

    gradient: FloatArray
    slopes: FloatArray
    weights: FloatArray
    damping_time: FloatArray
    neutral_axis: float = 0.0

    @classmethod
    def none(cls, size: int) -> LinkStretch:
        """No strains, for a link of ``size`` coordinates that does not stretch."""
        return cls(np.zeros((0, size)), np.zeros((0, size)), np.zeros((0, 0)), np.zeros(0))

    def in_coordinates(self, basis: FloatArray) -> LinkStretch:
        """The same strains in other coordinates: ``q = basis @ p``, with basis (n, m)."""
        return replace(self, gradient=self.gradient @ basis, slopes=self.slopes @ basis)

    def projected(self, basis: FloatArray) -> LinkStretch:
        """The same strains with ``q = basis @ p``, where p are fewer.

        Only strains in the range of the linear part are kept: squared slopes of high modes must
        not stretch a link without axial shapes that could relax them (membrane locking).

        Parameters
        ----------
        basis : ndarray, shape (n, m)

        Returns
        -------
        LinkStretch
        """
        gradient = self.gradient @ basis
        combined, times = [gradient[:, :0]], [self.damping_time[:0]]
        for time in np.unique(self.damping_time):
            rows = np.flatnonzero(self.damping_time == time)
            directions, size, _ = np.linalg.svd(gradient[rows], full_matrices=False)
            directions = directions[:, size > RANK_TOLERANCE * size.max(initial=0.0)]
            combined.append(np.zeros((len(gradient), directions.shape[1])))
            combined[-1][rows] = directions
            times.append(np.full(directions.shape[1], time))
        kept = np.concatenate(combined, axis=1).T
        return replace(
            self,
            gradient=kept @ gradient,
            slopes=self.slopes @ basis,
            weights=kept @ self.weights,
            damping_time=np.concatenate(times),
        )

    def nonlinear_forces(
        self, displacement: FloatArray, rate: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Elastic and damping forces beyond those of the linear strain.

        Parameters
        ----------
        displacement, rate : ndarray, shape (m, n)

        Returns
        -------
        tuple of ndarray, shape (m, n)
        """
        slope, linear, second = self._strain(displacement)
        elastic = self._force(slope, linear, second)
        if not self.damping_time.any():
            return elastic, np.zeros_like(elastic)
        linear_rate = rate @ self.gradient.T
        second_rate = (slope * (rate @ self.slopes.T)) @ self.weights.T
        time = self.damping_time
        return elastic, self._force(slope, time * linear_rate, time * second_rate)

    def energy(self, displacement: FloatArray) -> FloatArray:
        """Strain energy beyond that of the linear strain; (m, n) -> (m,)."""
        _, linear, second = self._strain(displacement)
        return np.asarray(np.sum(second * (linear + second / 2), axis=1))

    def _strain(self, displacement: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        slope = displacement @ self.slopes.T
        return slope, displacement @ self.gradient.T, (slope * slope) @ self.weights.T / 2

    def _force(self, slope: FloatArray, linear: FloatArray, second: FloatArray) -> FloatArray:
        along = second @ self.gradient
        return np.asarray(along + (((linear + second) @ self.weights) * slope) @ self.slopes)
