"""Forces and tangents of all links by the independent coordinates, at all crank angles at once.

Arrays end with the batch of positions. Tangents come from the elements' relative coordinates into
a narrow band by one sparse matrix for all positions. What varies with the position goes the long
way, as a block by the independent coordinates that it depends on: elements at dependent ends,
rigid links and sliders, springs in joints, and energies of whole links.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse
from numpy.typing import NDArray
from scipy.linalg.lapack import dgbsv, dpbtrf, dpbtrs

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics import AttachedPoint, Connectors, DisplacedTies, LinkFrames
from flexmech.mechanics.beams.elements import BeamElements
from flexmech.reference.corotational import CorotationalElements, in_positions


@dataclass(frozen=True)
class Ties:
    """Constraints of the links in a batch of positions.

    Parameters
    ----------
    turns : list of ndarray, shape (r, c, B)
        Turns of each link: derivative of the dependent rows by the coordinates that determine them.
    displaced : DisplacedTies, optional
        Where rigid links and lines are, if there are any.
    """

    turns: list[FloatArray]
    displaced: DisplacedTies | None

    def at(self, which: IntArray) -> Ties:
        """Constraints of some positions, where they do not depend on displacements."""
        return Ties([in_positions(turn, which) for turn in self.turns], None)


class LinkRows:
    """Coordinates of a link by the independent coordinates z of the linkage.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    link : int
    rows : ndarray of int, shape (r,)
        Ascending coordinates of the link; all of a rigid one.

    Attributes
    ----------
    columns : ndarray of int, shape (c,)
        Ascending coordinates of z that move them.
    """

    columns: IntArray

    def __init__(self, frames: LinkFrames, link: int, rows: IntArray) -> None:
        self.link, self._count, self._of_rigid = link, len(rows), None
        if frames.links[link].rigid:
            self.columns = np.arange(len(frames.rigid.independent_coordinates))
            self._of_rigid = frames.rigid.of_body(link)
            return
        target = frames.targets[link][rows]
        dependent, determining = frames.dependencies[link]
        place = np.flatnonzero(np.isin(rows, dependent))
        target[place] = -1
        free = np.flatnonzero(target >= 0)
        # Those of the end at these rows alone: with the other end's the band would be wide.
        by = [tie.columns for tie in frames.ties[link] if np.isin(rows, tie.rows).any()]
        self.columns = np.unique(np.concatenate([target[free], *by]))
        self._free = free, np.searchsorted(self.columns, target[free])
        kept = np.flatnonzero(np.isin(determining, self.columns))
        self._place = place[:, None], np.searchsorted(self.columns, determining[kept])
        self._source = np.searchsorted(dependent, rows[place])[:, None], kept

    def derivative(self, ties: Ties) -> FloatArray:
        """Derivative of the rows by the columns, (r, c, B)."""
        if self._of_rigid is not None:
            assert ties.displaced is not None
            return np.moveaxis(
                ties.displaced.coordinates[:, self._of_rigid, : len(self.columns)], 0, -1
            )
        turn = ties.turns[self.link]
        derivative = np.zeros((self._count, len(self.columns), turn.shape[2]))
        derivative[self._free] = 1.0
        derivative[self._place] = turn[self._source]
        return derivative

    def turned(self, matrix: FloatArray, ties: Ties) -> FloatArray:
        """A matrix (r, r) or (B, r, r) of the rows as one of the columns, (c, c, B)."""
        derivative = np.moveaxis(self.derivative(ties), -1, 0)
        return np.moveaxis(np.swapaxes(derivative, 1, 2) @ matrix @ derivative, 0, -1)


class LinkageAssembly:
    """Displacements, forces and tangents of links by the independent coordinates z.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    links : mapping of int to CorotationalElements
        The flexible ones, by their number.
    joined : sequence of ndarray of int
        Coordinates of z that each further energy depends on: springs between links, and such.

    Attributes
    ----------
    order : ndarray of int, shape (size,)
        Order of the coordinates in the band.
    """

    order: IntArray

    def __init__(
        self,
        frames: LinkFrames,
        links: Mapping[int, CorotationalElements],
        joined: Sequence[IntArray] = (),
    ) -> None:
        self.frames, self.links = frames, dict(links)
        self._per_node = next(iter(links.values())).elements.shapes.per_node
        # Independent coordinates of rigid links and sliders are the first ones.
        self._rigid_count = len(frames.rigid.independent_coordinates)
        self._dependent = {
            (link, element): LinkRows(frames, link, self._rows(element))
            for link in links
            for element in self._dependent_elements(link)
        }
        self._blocks = [
            *(rows.columns for rows in self._dependent.values()),
            np.arange(self._rigid_count),
            *joined,
        ]
        self.order, self._scatter = self._band_scatter()

    @property
    def ties_move(self) -> bool:
        """Whether constraints depend on the displacement: there are rigid links or lines."""
        return self.frames.rigid.are_finite

    def ties(self, motion: RigidMotion, z: FloatArray) -> Ties:
        """Constraints of the links in each position.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        z : ndarray, shape (size, B)
            Displacement on which they depend where :attr:`ties_move`.

        Returns
        -------
        Ties
        """
        displaced, rows = None, []
        if self.ties_move:
            displaced = self.frames.displaced_ties(motion, z[: self._rigid_count].T)
            rows = displaced.rows
        else:
            rows = [tie.turn for tie in self.frames.dependent_rows(motion)]
        return Ties([np.ascontiguousarray(np.moveaxis(turn, 0, -1)) for turn in rows], displaced)

    def link_displacement(self, z: FloatArray, ties: Ties) -> list[FloatArray]:
        """Coordinates (n_link, B) of each link from independent ones (size, B)."""
        result = []
        for link, target in enumerate(self.frames.targets):
            q = np.where(target[:, None] >= 0, z[target], 0.0)
            rows, columns = self.frames.dependencies[link]
            q[rows] = (ties.turns[link] * z[columns]).sum(axis=1)
            if ties.displaced is not None:
                ties.displaced.put_places(link, q.T)
            result.append(q)
        return result

    def coordinates(self, motion: RigidMotion, displacement: Sequence[FloatArray]) -> FloatArray:
        """Independent coordinates (size, B) of displacements (B, n_link) of all links.

        A dependent end is taken to satisfy its constraint.
        """
        columns = [q[..., None] for q in displacement]
        z = self.frames.independent(motion, columns)[..., 0].T.copy()
        if self.ties_move:
            pose = self.frames.displaced_ties_by(motion, displacement)
            z[: self._rigid_count] = pose.y[:, self.frames.rigid.independent_coordinates].T
        return z

    def gather(self, forces: Sequence[FloatArray], ties: Ties) -> FloatArray:
        """Generalized forces (size, B) by forces (n_link, B) on the links."""
        total = np.zeros((self.frames.size, forces[0].shape[1]))
        for link, (target, force) in enumerate(zip(self.frames.targets, forces, strict=True)):
            rows, columns = self.frames.dependencies[link]
            total[columns] += (ties.turns[link] * force[rows][:, None]).sum(axis=0)
            free = self.frames.independent_coordinates(link)
            total[target[free]] += force[free]
        return total

    def entries(self, batch: int) -> tuple[FloatArray, dict[int, FloatArray]]:
        """Array (R, B) for the entries of tangents, and views (e, r, r, B) for those of links."""
        rows, views, first = np.empty((self._first_of_blocks[-1], batch)), {}, 0
        for link, shape in self._shapes.items():
            last = first + int(np.prod(shape))
            views[link], first = rows[first:last].reshape(*shape, batch), last
        return rows, views

    def band(
        self,
        entries: tuple[FloatArray, dict[int, FloatArray]],
        ties: Ties,
        rigid: FloatArray | None,
        joined: Iterable[FloatArray],
    ) -> FloatArray:
        """Tangent in band form; see :func:`solve_band`.

        Parameters
        ----------
        entries : tuple
            As :meth:`entries` gives it, with those of all links.
        ties : Ties
        rigid : ndarray, shape (B, n, n), or None
            Geometric stiffness of rigid links and sliders.
        joined : iterable of ndarray, shape (m, m, B)
            Stiffness of each further energy by its coordinates.

        Returns
        -------
        ndarray, shape (size, width + 1, B)
        """
        rows, views = entries
        first = self._first_of_blocks
        stiffness = np.zeros((self._rigid_count, self._rigid_count, 1))
        if rigid is not None:
            stiffness = np.moveaxis(rigid, 0, -1)
        blocks = chain(self._turned(views, ties), [stiffness], joined)
        for columns, place, block in zip(self._blocks, pairwise(first), blocks, strict=True):
            size = len(columns)
            rows[slice(*place)].reshape(size, size, rows.shape[1])[:] = block
        band: FloatArray = self._scatter @ rows
        return band.reshape(self.frames.size, -1, rows.shape[1])

    def _turned(self, views: Mapping[int, FloatArray], ties: Ties) -> Iterable[FloatArray]:
        """Tangents (c, c, B) of elements at dependent ends by their columns."""
        for (link, element), rows in self._dependent.items():
            forces = views[link][element : element + 1]
            yield rows.turned(np.moveaxis(self.links[link].of_nodes(forces)[0], -1, 0), ties)

    def _rows(self, element: int | IntArray) -> IntArray:
        """Coordinates of elements in their link, (..., 2 p)."""
        return self._per_node * np.expand_dims(element, -1) + np.arange(2 * self._per_node)

    def _dependent_elements(self, link: int) -> list[int]:
        """Elements of a link with a dependent coordinate."""
        last = self._shapes[link][0] - 1
        nodes = self.frames.dependencies[link][0] // self._per_node
        return sorted({min(node, last) for node in nodes.tolist()})

    @cached_property
    def _shapes(self) -> dict[int, tuple[int, int, int]]:
        """Shape ``(e, r, r)`` of the entries of each link by relative coordinates."""
        size = 2 * (self._per_node - 1)
        return {
            n: (len(elements.elements.length), size, size) for n, elements in self.links.items()
        }

    @cached_property
    def _first_of_blocks(self) -> IntArray:
        """Row of the entries where each block begins, and their number."""
        inner = sum(int(np.prod(shape)) for shape in self._shapes.values())
        return np.cumsum([inner, *(len(columns) ** 2 for columns in self._blocks)])

    def _band_scatter(self) -> tuple[IntArray, scipy.sparse.csr_matrix]:
        """Order of the coordinates in a narrow band, and the sparse map from entries to it.

        The map leads to the lower band, row by row: ``(size (width + 1), R)``.
        """
        parts, first = [], 0
        for link, elements in self.links.items():
            count, relative, _ = self._shapes[link]
            inner = [n for n in range(count) if (link, n) not in self._dependent]
            number = np.array(inner, dtype=np.intp)
            places, signs = elements.relative_places, elements.node_signs
            within = (places[:, None] * relative + places).ravel()
            source = first + relative**2 * number[:, None] + within
            target = self.frames.targets[link][self._rows(number)]
            parts.append(_pairs(target, source, np.outer(signs, signs).ravel()))
            first += count * relative**2
        for columns, begin in zip(self._blocks, self._first_of_blocks, strict=False):
            inside = np.arange(len(columns) ** 2)
            parts.append(_pairs(columns, begin + inside, np.ones(len(inside))))
        rows, columns, source, sign = (np.concatenate(x) for x in zip(*parts, strict=True))
        size = self.frames.size
        graph = scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(size, size))
        order = scipy.sparse.csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True)
        place = np.argsort(order)
        below = place[rows] - place[columns]
        width, used = int(np.abs(below).max()), below >= 0
        slot = place[columns[used]] * (width + 1) + below[used]
        shape = (size * (width + 1), int(self._first_of_blocks[-1]))
        scatter = scipy.sparse.csr_matrix((sign[used], (slot, source[used])), shape=shape)
        return np.asarray(order, dtype=np.intp), scatter


def _pairs(target: IntArray, source: IntArray, sign: FloatArray) -> tuple[Any, ...]:
    """Entries of square matrices by coordinates (..., n) of z; -1 where fixed.

    ``source`` is of shape (..., n^2), ``sign`` of (n^2,). The result are rows and columns in z,
    sources and signs of all.
    """
    count = target.shape[-1]
    rows, columns = np.repeat(target, count, axis=-1), np.tile(target, count)
    free = (rows >= 0) & (columns >= 0)
    return tuple(x[free] for x in (rows, columns, source, np.broadcast_to(sign, free.shape)))


def angle_per_unit(frames: LinkFrames, links: Mapping[int, BeamElements]) -> FloatArray:
    """Rotation in rad equivalent to a unit of each coordinate of z.

    That of a displacement is over the shortest link, that of a curvature over its link.

    Parameters
    ----------
    frames : LinkFrames
    links : mapping of int to BeamElements
        The flexible ones, by their number.

    Returns
    -------
    ndarray, shape (size, 1)
    """
    lengths = [link.length for link in frames.topology.links]
    shortest, shapes = 1.0 / min(lengths), next(iter(links.values())).shapes
    scale = np.full((frames.size, 1), shortest)
    for link in frames.rigid.links:
        turn = frames.targets[link][2]
        scale[turn[turn >= 0]] = 1.0
    for link in links:
        target = frames.targets[link]
        kind = np.arange(len(target)) % shapes.per_node
        angle = np.where(np.isin(kind, shapes.angles)[:, None], 1.0, lengths[link])
        angle[kind < 2] = shortest
        scale[target[target >= 0]] = angle[target >= 0]
    return scale


class _End(NamedTuple):
    """Sign of an end of a spring, its point, and the rows (r,) of its link that move it."""

    sign: float
    point: AttachedPoint
    rows: IntArray
    by_z: LinkRows


class RadialSprings:
    """Stiffness of the radial springs in the joints of one linkage.

    The force of a joint is ``F = k d`` in ground axes with the gap d between its two ends, which is
    part of the equilibrium. It does not rotate with the links.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links, without constraints of these joints.
    connectors : Connectors

    Attributes
    ----------
    columns : list of ndarray of int
        Independent coordinates that move the ends of each spring.
    """

    columns: list[IntArray]

    def __init__(self, frames: LinkFrames, connectors: Connectors) -> None:
        self._springs: list[tuple[float, list[_End]]] = []
        for spring in connectors.joint_springs:
            if spring.radial_stiffness:
                ends = []
                for sign, point in zip((1.0, -1.0), connectors.joint_points(spring), strict=True):
                    if point is not None:
                        # Those by which the end moves: of an elastic link the displacement there.
                        rows = np.flatnonzero(point.rows[:2].any(axis=0))
                        rows = np.arange(3) if point.rigid else rows
                        ends.append(_End(sign, point, rows, LinkRows(frames, point.link, rows)))
                self._springs.append((spring.radial_stiffness, ends))
        self.columns = [
            np.unique(np.concatenate([end.by_z.columns for end in ends]))
            for _, ends in self._springs
        ]

    def tangents(
        self, motion: RigidMotion, displacement: Sequence[FloatArray], ties: Ties
    ) -> Iterator[FloatArray]:
        """Stiffness of each spring by its :attr:`columns`, (m, m, B), one after the other.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (n_link, B)
        ties : Ties
            Ties of the displaced links.
        """
        for (stiffness, ends), columns in zip(self._springs, self.columns, strict=True):
            moved = np.zeros((len(motion.crank_angle), 2, len(columns)))
            for sign, point, rows, by_z in ends:
                angle = motion.angle[:, point.link]
                axes = np.stack([direction(angle), normal(angle)], axis=2)
                by_link = axes @ point.rows_at(displacement[point.link].T)[:, :2, rows]
                by_ends = by_link @ np.moveaxis(by_z.derivative(ties), -1, 0)
                moved[:, :, np.searchsorted(columns, by_z.columns)] += sign * by_ends
            yield stiffness * np.moveaxis(np.swapaxes(moved, 1, 2) @ moved, 0, -1)


def solve_band(band: FloatArray, right: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Solutions of symmetric band systems, and which of these are positive definite.

    The stiffness of links joined in a chain has a narrow band once its coordinates are well
    ordered: the cost grows linearly with the number of elements. By Cholesky's factors (LAPACK's
    ``pbtrf``), and by LU where a matrix is not positive definite.

    Parameters
    ----------
    band : ndarray, shape (n, width + 1, B)
        ``band[j, k]`` holds entry (j + k, j) of each matrix.
    right : ndarray, shape (n, B)

    Returns
    -------
    solution : ndarray, shape (n, B)
        Not numbers where the matrix is singular.
    positive : ndarray of bool, shape (B,)
    """
    positive, solution = np.ones(band.shape[-1], dtype=bool), right.T.copy()
    for number, lower in enumerate(np.ascontiguousarray(np.moveaxis(band, -1, 0))):
        factors, failed = dpbtrf(lower.T, lower=1)
        if not failed:
            solution[number] = dpbtrs(factors, solution[number], lower=1)[0]
            continue
        positive[number] = False
        size, width = len(lower), lower.shape[1] - 1
        full = np.zeros((3 * width + 1, size))
        full[2 * width :] = lower.T
        for k in range(1, width + 1):
            full[2 * width - k, k:] = lower[: size - k, k]
        *_, solved, singular = dgbsv(width, width, full, solution[number])
        solution[number] = np.nan if singular else solved
    return solution.T, positive
