"""Assembly of forces and tangents of all links in the independent coordinates.

Arrays end with the batch of positions. The tangent is assembled from the elements' relative
coordinates into a narrow band by one sparse matrix for all positions; only elements at dependent
ends have transformations that vary with the position.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import BeamElements
from flexmech.linear_system import LinkFrames
from flexmech.linkages import RigidMotion
from flexmech.reference.corotational import CorotationalElements
from flexmech.reference.dependent_element import DependentElement, Ties


@dataclass(frozen=True)
class TangentEntries:
    """Entries of all elements' tangents, in one array of rows over the batch.

    Parameters
    ----------
    rows : ndarray, shape (R, B)
        Those of links by relative coordinates, one link after the other; then those of elements
        that turn, by their nodes' coordinates.
    shapes : dict of int to tuple of int
        ``(e, r, r)`` of each flexible link.
    """

    rows: FloatArray
    shapes: dict[int, tuple[int, int, int]]

    def of_link(self, link: int) -> FloatArray:
        """View of a link's entries, (e, r, r, B)."""
        before = (shape for number, shape in self.shapes.items() if number < link)
        first = sum(int(np.prod(shape)) for shape in before)
        shape = self.shapes[link]
        return self.rows[first : first + int(np.prod(shape))].reshape(*shape, -1)

    def block(self, first: int, size: int) -> FloatArray:
        """View of a square matrix from row ``first`` on, (size, size, B)."""
        return self.rows[first : first + size**2].reshape(size, size, -1)


class LinkageTangents:
    """Assembly of link displacements, forces and tangents by the independent coordinates.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    links : mapping of int to CorotationalElements
        The flexible ones, by their number.
    springs : sequence of ndarray of int
        Coordinates of z that each spring between links depends on.

    Attributes
    ----------
    order : ndarray of int, shape (size,)
        Of the coordinates in the band.
    """

    order: IntArray

    def __init__(
        self,
        frames: LinkFrames,
        links: Mapping[int, CorotationalElements],
        springs: Sequence[IntArray] = (),
    ) -> None:
        self._frames = frames
        self._springs = list(springs)
        self._links = dict(links)
        elements = next(iter(self._links.values()))
        self._per_node = elements.elements.shapes.per_node
        relative = len(elements.relative_part)
        self._shapes = {
            link: (own.elements.length.shape[-1], relative, relative) for link, own in links.items()
        }
        # Independent coordinates of rigid links and sliders are the first ones.
        self._rigid_count = len(frames.rigid.independent_coordinates)
        self._dependent = self._dependent_elements()
        entries = self._entries()
        self.order, self._width = _narrow_band(frames.size, entries)
        self._scatter = _band_scatter(entries, self.order, self._width, self._count)

    @property
    def ties_move(self) -> bool:
        """Whether constraints depend on the displacement: there are rigid links or lines."""
        return bool(self._frames.rigid.size)

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
        if not self.ties_move:
            turns = [
                [np.ascontiguousarray(np.moveaxis(tie.turn, 0, -1)) for tie in dependent]
                for dependent in self._frames.dependent_rows(motion)
            ]
            return Ties(turns, None)
        displaced = self._frames.displaced_ties(motion, z[: self._rigid_count].T)
        turns = [[np.moveaxis(tie.turn, 0, -1) for tie in rows] for rows in displaced.rows]
        return Ties(turns, displaced)

    def link_displacement(self, z: FloatArray, ties: Ties) -> list[FloatArray]:
        """Coordinates (n_link, B) of each link from independent ones (size, B)."""
        result = []
        for link, target in enumerate(self._frames.targets):
            q = np.where(target[:, None] >= 0, z[target], 0.0)
            dependent = self._frames.dependencies(link)
            for number, ((rows, columns), turn) in enumerate(
                zip(dependent, ties.turns[link], strict=True)
            ):
                place = None if ties.displaced is None else ties.displaced.rows[link][number].place
                q[rows] = (turn * z[columns]).sum(axis=1) if place is None else place.T
            result.append(q)
        return result

    def coordinates(self, motion: RigidMotion, displacement: Sequence[FloatArray]) -> FloatArray:
        """Independent coordinates (size, B) of displacements (B, n_link) of all links.

        A dependent end is taken to satisfy its constraint.
        """
        if not self.ties_move:
            columns = [q[..., None] for q in displacement]
            return self._frames.independent(motion, columns)[..., 0].T.copy()
        z = np.zeros((self._frames.size, len(displacement[0])))
        for link, (target, q) in enumerate(zip(self._frames.targets, displacement, strict=True)):
            own = self._frames.independent_coordinates(link)
            z[target[own]] = q.T[own]
        pose = self._frames.displaced_ties_by(motion, displacement).pose
        z[: self._rigid_count] = pose.y[:, self._frames.rigid.independent_coordinates].T
        return z

    def gather(self, forces: Sequence[FloatArray], ties: Ties) -> FloatArray:
        """Generalized forces (size, B) by forces (n_link, B) on the links."""
        total = np.zeros((self._frames.size, forces[0].shape[1]))
        for link, (target, force) in enumerate(zip(self._frames.targets, forces, strict=True)):
            free = target >= 0
            for (rows, columns), turn in zip(
                self._frames.dependencies(link), ties.turns[link], strict=True
            ):
                total[columns] += (turn * force[rows][:, None]).sum(axis=0)
                free[rows] = False
            own = np.flatnonzero(free)
            total[target[own]] += force[own]
        return total

    def entries(self, batch: int) -> TangentEntries:
        """Array for the entries of all elements' tangents."""
        return TangentEntries(np.empty((self._count, batch)), self._shapes)

    def band(
        self,
        entries: TangentEntries,
        ties: Ties,
        rigid: FloatArray | None = None,
        springs: Iterable[FloatArray] = (),
    ) -> FloatArray:
        """Tangent in band form; see :mod:`flexmech.reference.banded`.

        Parameters
        ----------
        entries : TangentEntries
            With those of all links.
        ties : Ties
        rigid : ndarray, shape (B, n, n), optional
            Geometric stiffness of rigid links and sliders.
        springs : iterable of ndarray, shape (m, m, B)
            Stiffness of each spring by its coordinates.

        Returns
        -------
        ndarray, shape (size, width + 1, B)
        """
        for tied in self._dependent:
            own = entries.of_link(tied.link)[tied.element : tied.element + 1]
            matrix = self._links[tied.link].of_nodes(own)[0]
            turns = [ties.turns[tied.link][number] for number, _ in tied.ties]
            entries.block(tied.first, len(tied.columns))[:] = tied.turned(matrix, turns)
        if self._rigid_count:
            block = entries.block(self._inner_count + self._dependent_count, self._rigid_count)
            block[:] = 0.0 if rigid is None else np.moveaxis(rigid, 0, -1)
        first = self._inner_count + self._dependent_count + self._rigid_count**2
        for columns, stiffness in zip(self._springs, springs, strict=True):
            entries.block(first, len(columns))[:] = stiffness
            first += len(columns) ** 2
        band: FloatArray = self._scatter @ entries.rows
        return band.reshape(self._frames.size, self._width + 1, -1)

    @property
    def _inner_count(self) -> int:
        return sum(int(np.prod(shape)) for shape in self._shapes.values())

    @property
    def _dependent_count(self) -> int:
        return sum(len(element.columns) ** 2 for element in self._dependent)

    @property
    def _count(self) -> int:
        springs = sum(len(columns) ** 2 for columns in self._springs)
        return self._inner_count + self._dependent_count + self._rigid_count**2 + springs

    def _dependent_elements(self) -> list[DependentElement]:
        """Elements with a dependent row, in the order of their entries."""
        tied, first, size = [], self._inner_count, 2 * self._per_node
        for link, elements in self._links.items():
            of_element: dict[int, list[tuple[int, IntArray]]] = {}
            count = elements.elements.length.shape[-1]
            for number, (rows, _) in enumerate(self._frames.dependencies(link)):
                element = min(int(rows.min()) // self._per_node, count - 1)
                local = rows - self._per_node * element
                assert local.max() < size
                of_element.setdefault(element, []).append((number, local))
            for element, ties in sorted(of_element.items()):
                target = self._frames.targets[link][self._per_node * element + np.arange(size)]
                dependent = [self._frames.dependencies(link)[number][1] for number, _ in ties]
                tied.append(DependentElement.of(link, element, ties, target, dependent, first))
                first += len(tied[-1].columns) ** 2
        return tied

    def _entries(self) -> _Entries:
        size = 2 * self._per_node
        parts, first = [], 0
        tied = {(each.link, each.element): each for each in self._dependent}
        for link, elements in self._links.items():
            count, relative, _ = self._shapes[link]
            places, signs = elements.relative_places, elements.node_signs
            number = np.array([n for n in range(count) if (link, n) not in tied], dtype=np.intp)
            own = self._frames.targets[link][self._per_node * number[:, None] + np.arange(size)]
            within = (places[:, None] * relative + places).ravel()
            source = first + relative**2 * number[:, None] + within
            parts.append(_entries_of(own, source, np.outer(signs, signs).ravel()))
            first += count * relative**2
        for each in self._dependent:
            inside = np.arange(len(each.columns) ** 2)
            parts.append(_entries_of(each.columns, each.first + inside, np.ones(len(inside))))
        rigid = self._rigid_count
        first = self._inner_count + self._dependent_count
        for columns in (np.arange(rigid), *self._springs):
            size = len(columns) ** 2
            parts.append(_entries_of(columns, first + np.arange(size), np.ones(size)))
            first += size
        return _Entries(*(np.concatenate(x) for x in zip(*parts, strict=True)))


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


def _entries_of(own: IntArray, source: IntArray, sign: FloatArray) -> tuple[Any, ...]:
    """Entries of square matrices by coordinates (..., n) of z; -1 where fixed.

    ``source`` is of shape (..., n^2), ``sign`` of (n^2,).
    """
    count = own.shape[-1]
    rows, columns = np.repeat(own, count, axis=-1), np.tile(own, count)
    free = (rows >= 0) & (columns >= 0)
    return tuple(x[free] for x in (rows, columns, source, np.broadcast_to(sign, free.shape)))


@dataclass(frozen=True)
class _Entries:
    """Rows and columns in z of entries of the tangent, with their sources and signs."""

    rows: IntArray
    columns: IntArray
    source: IntArray
    sign: FloatArray


def _narrow_band(size: int, entries: _Entries) -> tuple[IntArray, int]:
    """Order of the coordinates (reverse Cuthill-McKee) and half band width in it."""
    graph = scipy.sparse.csr_matrix(
        (np.ones(len(entries.rows)), (entries.rows, entries.columns)), shape=(size, size)
    )
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True)
    place = np.argsort(order)
    width = int(np.abs(place[entries.rows] - place[entries.columns]).max())
    return np.asarray(order, dtype=np.intp), width


def _band_scatter(
    entries: _Entries, order: IntArray, width: int, count: int
) -> scipy.sparse.csr_matrix:
    """Sparse map from entries to the lower band, row-major (n, width + 1)."""
    place = np.argsort(order)
    below = place[entries.rows] - place[entries.columns]
    used = below >= 0
    slot = place[entries.columns[used]] * (width + 1) + below[used]
    return scipy.sparse.csr_matrix(
        (entries.sign[used], (slot, entries.source[used])),
        shape=(len(order) * (width + 1), count),
    )
