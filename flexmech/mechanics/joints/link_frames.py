"""Link frames: the constraints between the coordinates of links whose frames rotate.

Each link's displacement is written in the frame of its rigid motion. The displacement of a pin is a
coordinate in the leader's frame; that of the follower's end is
``R(theta_follower)^T R(theta_leader)`` times it. At a weld the angle between the frames is constant
and the rotations are equal; an end on a line depends on the slide, and ends on rigid links on these
(:mod:`flexmech.mechanics.joints.joint_coordinates`). With ``q = N(t) z``::

    M_r = N'MN
    C_r = N'(2 M Ndot + 2 omega S N) + N'DN
    K_r = N'(M Nddot + 2 omega S Ndot + (K - omega^2 M_t + alpha S) N) + N'D Ndot

These are Turcic and Midha's M_d, M_dd, M_vel, M_d,vel and M_acc (Kumar & Chandrakar,
eq. 1.57). The same code serves every engine: only the link matrices differ.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion
from flexmech.mechanics.joints.link_ties import DependentRows, LinkTies
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices

Numbers = slice | IntArray


@dataclass(frozen=True)
class LinkPlace:
    """Assembly of a link: the coordinates of the linkage for each coordinate of the link.

    Parameters
    ----------
    runs : list of tuple of slice
        Independent coordinates: runs of consecutive numbers in the link and in the linkage.
    rows, columns : slice or ndarray of int
        Dependent rows of the link, and the columns of the linkage that determine them.
    """

    runs: list[tuple[slice, slice]]
    rows: Numbers
    columns: Numbers

    def add(self, total: FloatArray, matrix: FloatArray, turn: FloatArray) -> None:
        """Add ``Q' X Q`` to a matrix of the linkage.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        turn : ndarray, shape (B, r, c)
            Turn of the dependent rows.
        """
        for row, to_row in self.runs:
            for column, to_column in self.runs:
                total[:, to_row, to_column] += matrix[..., row, column]
        if turn.size:
            for column, to_column in self.runs:
                block = _turned(turn, matrix[..., self.rows, column])
                total[_where(self.columns, to_column)] += block
        self.add_dependent_columns(total, matrix, turn, turn)

    def add_dependent_columns(
        self, total: FloatArray, matrix: FloatArray, turn: FloatArray, right: FloatArray
    ) -> None:
        """Add ``Q' X P``, where P has the rows of dependent coordinates alone.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        turn : ndarray, shape (B, r, c)
            Turn of the dependent rows.
        right : ndarray, shape (B, r, c)
            Those rows of ``P``.
        """
        if not turn.size:
            return
        transposed = np.swapaxes(matrix[..., self.rows], -1, -2)
        turned = np.swapaxes(_turned(right, transposed), 1, 2)
        for row, to_row in self.runs:
            total[_where(to_row, self.columns)] += turned[:, row]
        block = np.swapaxes(turn, 1, 2) @ turned[:, self.rows]
        total[_where(self.columns, self.columns)] += block


def _turned(turn: FloatArray, rows: FloatArray) -> FloatArray:
    """``P' X`` for rows (r, n) or (B, r, n) of a link matrix; (B, c, n)."""
    transposed = np.swapaxes(turn, 1, 2)
    if rows.ndim == 3:
        return transposed @ rows
    batch, columns, count = transposed.shape
    return (transposed.reshape(-1, count) @ rows).reshape(batch, columns, -1)


def _where(rows: Numbers, columns: Numbers) -> tuple[Numbers, ...]:
    """Index of a block of matrices (B, size, size)."""
    if isinstance(rows, slice) or isinstance(columns, slice):
        return slice(None), rows, columns
    return slice(None), rows[:, None], columns


def _numbers(numbers: IntArray) -> Numbers:
    """Slice of numbers that are evenly spaced, in their order; else the numbers."""
    values = numbers.tolist()
    if len(values) < 2:
        return slice(values[0], values[0] + 1) if values else slice(0, 0)
    step = values[1] - values[0]
    if step == 0 or any(b - a != step for a, b in pairwise(values)):
        return numbers
    stop = values[-1] + step
    return slice(values[0], stop if stop >= 0 else None, step)


def _runs(source: IntArray, target: IntArray) -> list[tuple[slice, slice]]:
    """Runs of consecutive numbers in both."""
    ends: list[list[int]] = []
    for s, t in zip(source.tolist(), target.tolist(), strict=True):
        if ends and (s, t) == (ends[-1][1], ends[-1][3]):
            ends[-1][1], ends[-1][3] = s + 1, t + 1
        else:
            ends.append([s, s + 1, t, t + 1])
    return [(slice(a, b), slice(c, d)) for a, b, c, d in ends]


class LinkFrames(LinkTies):
    """The map from independent coordinates z to the coordinates of all links.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        In the topology's order; full or reduced.
    last : sequence of ndarray of bool, shape (n_link,), optional
        Coordinates of each link to number after all others.
    """

    def assemble(
        self,
        motion: RigidMotion,
        stiffness: Sequence[FloatArray],
        terms: RotationTerms,
        damping: Sequence[FloatArray] | None = None,
        guide_stiffness: FloatArray | None = None,
        turns: Sequence[Sequence[FloatArray]] | None = None,
        end_damping: Sequence[FloatArray] | None = None,
    ) -> SystemMatrices:
        """Assemble mass, damping and stiffness in the independent coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        stiffness : sequence of ndarray, shape (n, n) or (B, n, n)
            Tangent stiffness of each link in its frame, at the chosen prestress.
        terms : RotationTerms
        damping : sequence of ndarray, shape (n, n) or (B, n, n), optional
            At the chosen prestress; that of the straight links by default.
        guide_stiffness : ndarray, shape (B, n_sliders), optional
            Geometric stiffness between the rotation of a slider's guide and its slide in N/rad.
        turns : sequence of sequence of ndarray, shape (B,), optional
            Turns of the bodies on each link; see :func:`flexmech.mechanics.body_turns`.
        end_damping : sequence of ndarray, shape (n, n) or (B, n, n), optional
            Damping forces from the rate of the joined ends alone, where they are not the columns
            of ``damping``; see :class:`flexmech.mechanics.links.link_model.EndMatrices`.

        Returns
        -------
        SystemMatrices
        """
        inertia = [link.inertia for link in self.links]
        if damping is None:
            damping = [link.damping for link in self.links]
            end_damping = [link.ends.damping for link in self.links]
        resisting = list(zip(damping, end_damping or damping, strict=True))
        for number, angles in enumerate(turns or ()):
            if (change := self.links[number].inertia_change(angles)) is not None:
                straight = inertia[number]
                inertia[number] = change + (straight if straight.ndim == 4 else straight[:, None])
        shape = (len(motion.crank_angle), self.size, self.size)
        mass, total = np.zeros((2, *shape))
        damped = [bool(matrix.any()) for matrix, _ in resisting]
        damps = terms.coriolis or any(damped)
        rates = np.zeros(shape) if damps else np.broadcast_to(0.0, shape)
        dependent = self.dependent_rows(motion)
        for number, (place, tie) in enumerate(zip(self._places, dependent, strict=True)):
            link_mass, gyroscopic, centrifugal_mass, end_mass, end_gyroscopic = inertia[number]
            damping_matrix, damped_ends = resisting[number]
            speed = motion.angular_velocity[:, number, None, None]
            turn, turning, tangent = tie.turn, tie.rate, stiffness[number]
            if terms.centripetal:
                tangent = tangent - speed**2 * centrifugal_mass
            if terms.tangential:
                change = motion.angular_acceleration[:, number, None, None]
                tangent = tangent + change * gyroscopic
            place.add(mass, link_mass, turn)
            place.add(total, tangent, turn)
            if damped[number]:
                place.add(rates, damping_matrix, turn)
            if terms.coriolis:
                place.add(rates, 2 * speed * gyroscopic, turn)
                place.add_dependent_columns(rates, 2 * end_mass, turn, turning)
                if damped[number]:
                    place.add_dependent_columns(total, damped_ends, turn, turning)
            if terms.centripetal:
                place.add_dependent_columns(total, end_gyroscopic, turn, 2 * speed * turning)
            if terms.centripetal or terms.tangential:
                place.add_dependent_columns(total, end_mass, turn, tie.acceleration(terms))
        if guide_stiffness is not None and guide_stiffness.any():
            total += self.guide_matrix(motion, guide_stiffness)
        return SystemMatrices(mass, rates, total)

    @cached_property
    def _places(self) -> list[LinkPlace]:
        places = []
        for link, target in enumerate(self.targets):
            free = self.independent_coordinates(link)
            dependent = map(_numbers, self.dependencies[link])
            places.append(LinkPlace(_runs(free, target[free]), *dependent))
        return places

    def link_coordinates(self, motion: RigidMotion, vectors: NDArray[Any]) -> list[NDArray[Any]]:
        """Coordinates of each link from independent ones.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        vectors : ndarray, shape (B, size, m)

        Returns
        -------
        list of ndarray, shape (B, n_link, m)
        """
        result = []
        for link, place, dependent in zip(
            self.links, self._places, self.dependent_rows(motion), strict=True
        ):
            q = np.zeros((len(vectors), link.size, vectors.shape[2]), dtype=vectors.dtype)
            for of_link, independent in place.runs:
                q[:, of_link] = vectors[:, independent]
            q[:, dependent.rows] = dependent.turn @ vectors[:, dependent.columns]
            result.append(q)
        return result

    def independent(
        self, motion: RigidMotion, displacement: Sequence[NDArray[Any]]
    ) -> NDArray[Any]:
        """Independent coordinates of displacements of all links, (B, size, m).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link, m)
            A dependent end is taken to satisfy its constraint.
        """
        shape = (len(displacement[0]), self.size, displacement[0].shape[2])
        z = np.zeros(shape, dtype=displacement[0].dtype)
        for place, q in zip(self._places, displacement, strict=True):
            for of_link, independent in place.runs:
                z[:, independent] = q[:, of_link]
        if self.topology.sliders:
            first = len(self.rigid.independent_coordinates)
            z[:, :first] += self._slides(motion, displacement)
        return z

    def link_motion(
        self,
        motion: RigidMotion,
        position: FloatArray,
        velocity: FloatArray,
        acceleration: FloatArray,
    ) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Coordinates of each link and their time derivatives in its frame.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        position, velocity, acceleration : ndarray, shape (B, size)
            Independent coordinates z and their time derivatives.

        Returns
        -------
        list of tuple of ndarray, shape (B, n_link)
            ``q = N z``, ``N z' + N' z`` and ``N z'' + 2 N' z' + N'' z`` of each link.
        """
        z, result = np.stack([position, velocity, acceleration], axis=-1), []
        coordinates, ties = self.link_coordinates(motion, z), self.dependent_rows(motion)
        for moving, tie in zip(coordinates, ties, strict=True):
            q, rate, change = np.ascontiguousarray(np.moveaxis(moving, -1, 0))
            determining = z[:, tie.columns]
            turning = tie.rate @ determining
            changing = tie.acceleration(RotationTerms()) @ determining
            rate[:, tie.rows] += turning[..., 0]
            change[:, tie.rows] += 2 * turning[..., 1] + changing[..., 0]
            result.append((q, rate, change))
        return result

    def by_independent(
        self,
        motion: RigidMotion,
        link: int,
        rows: FloatArray,
        rate: Callable[[DependentRows], FloatArray] | None = None,
    ) -> FloatArray:
        """Rows by the coordinates of one link as rows by the independent ones: ``X N``.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
        rows : ndarray, shape (k, n_link) or (B, k, n_link)
        rate : callable, optional
            Which derivative of the dependent rows by time to take in place of ``N``.

        Returns
        -------
        ndarray, shape (B, k, size)
        """
        total = np.zeros((len(motion.crank_angle), rows.shape[-2], self.size))
        tie = self.dependent_rows(motion)[link]
        total[:, :, tie.columns] = rows[..., tie.rows] @ (tie.turn if rate is None else rate(tie))
        if rate is None:
            for free, independent in self._places[link].runs:
                total[:, :, independent] += rows[..., free]
        return total

    def gather(self, motion: RigidMotion, loads: Sequence[FloatArray]) -> FloatArray:
        """Generalized force in the independent coordinates, ``N' f``; shape (B, size, ...).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link, ...)
            Forces on each link in its frame.
        """
        total = np.zeros((len(motion.crank_angle), self.size, *loads[0].shape[2:]))
        ties = self.dependent_rows(motion)
        for load, place, tie in zip(loads, self._places, ties, strict=True):
            total[:, tie.columns] += np.einsum("bij,bi...->bj...", tie.turn, load[:, tie.rows])
            for of_link, independent in place.runs:
                total[:, independent] += load[:, of_link]
        return total
