"""Forces and tangents of all links in the independent coordinates of the linkage.

Arrays end with the batch of positions. The tangent is summed straight from the elements' relative
coordinates into a narrow band, by one sparse matrix for all positions; only elements at an end
that follows another link turn with the position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse

from flexmech.linear_system import LinkFrames
from flexmech.linkages import RigidMotion
from flexmech.reference.corotational import CorotationalElements
from flexmech.types import FloatArray, IntArray

__all__ = ["LinkageTangents", "TangentEntries"]


@dataclass(frozen=True)
class TangentEntries:
    """Entries of all elements' tangents, in one array of rows over the batch.

    Parameters
    ----------
    rows : ndarray, shape (R, B)
        Those of links by relative coordinates, one link after the other; then those of elements
        that turn, by their nodes' coordinates.
    shapes : list of tuple of int
        ``(e, r, r)`` of each link.
    """

    rows: FloatArray
    shapes: list[tuple[int, int, int]]

    def of_link(self, link: int) -> FloatArray:
        """View of a link's entries, (e, r, r, B)."""
        first = sum(int(np.prod(shape)) for shape in self.shapes[:link])
        shape = self.shapes[link]
        return self.rows[first : first + int(np.prod(shape))].reshape(*shape, -1)

    def of_turning(self, number: int, size: int) -> FloatArray:
        """View of the entries of a turning element, (2 p, 2 p, B)."""
        first = sum(int(np.prod(shape)) for shape in self.shapes) + number * size**2
        return self.rows[first : first + size**2].reshape(size, size, -1)


class LinkageTangents:
    """How link displacements, forces and tangents hang on the independent coordinates.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    links : sequence of CorotationalElements

    Attributes
    ----------
    order : ndarray of int, shape (size,)
        Of the coordinates in the band.
    """

    order: IntArray

    def __init__(self, frames: LinkFrames, links: Sequence[CorotationalElements]) -> None:
        self._frames = frames
        self._links = links
        self._per_node = links[0].elements.shapes.per_node
        relative = len(links[0].relative_part)
        self._shapes = [(len(link.elements.length), relative, relative) for link in links]
        self._turning = [
            (link, element)
            for link in range(len(links))
            for element in sorted({self._element_at(link, pair) for pair in self._pairs(link)})
        ]
        entries = self._entries()
        self.order, self._width = _narrow_band(frames.size, entries)
        self._scatter = _band_scatter(entries, self.order, self._width, self._count)

    def turns(self, motion: RigidMotion) -> list[list[FloatArray]]:
        """Rotation (2, 2, B) of each link's following ends from their leaders' frames."""
        return [
            [np.ascontiguousarray(np.moveaxis(led.turn, 0, -1)) for led in following]
            for following in self._frames.following_rows(motion)
        ]

    def link_displacement(
        self, z: FloatArray, turns: Sequence[Sequence[FloatArray]]
    ) -> list[FloatArray]:
        """Coordinates (n_link, B) of each link from independent ones (size, B)."""
        result = []
        for link, target in enumerate(self._frames.targets):
            q = np.where(target[:, None] >= 0, z[target], 0.0)
            for pair, turn in zip(self._pairs(link), turns[link], strict=True):
                q[pair] = (turn * q[pair]).sum(axis=1)
            result.append(q)
        return result

    def coordinates(self, displacement: Sequence[FloatArray]) -> FloatArray:
        """Independent coordinates (size, B) of displacements (B, n_link) of all links.

        An end that follows another link's is taken to be where that is.
        """
        z = np.zeros((self._frames.size, len(displacement[0])))
        for link, (target, q) in enumerate(zip(self._frames.targets, displacement, strict=True)):
            own = self._frames.own(link)
            z[target[own]] = q.T[own]
        return z

    def gather(
        self, forces: Sequence[FloatArray], turns: Sequence[Sequence[FloatArray]]
    ) -> FloatArray:
        """Forces (size, B) on the independent coordinates of those (n_link, B) on the links."""
        total = np.zeros((self._frames.size, forces[0].shape[1]))
        for link, (target, force) in enumerate(zip(self._frames.targets, forces, strict=True)):
            for pair, turn in zip(self._pairs(link), turns[link], strict=True):
                force[pair] = (turn * force[pair][:, None]).sum(axis=0)
            free = np.flatnonzero(target >= 0)
            total[target[free]] += force[free]
        return total

    def entries(self, batch: int) -> TangentEntries:
        """Room for the entries of all elements' tangents."""
        return TangentEntries(np.empty((self._count, batch)), self._shapes)

    def band(self, entries: TangentEntries, turns: Sequence[Sequence[FloatArray]]) -> FloatArray:
        """Tangent in band form, (size, width + 1, B); see :mod:`flexmech.reference.banded`."""
        size = 2 * self._per_node
        for number, (link, element) in enumerate(self._turning):
            own = entries.of_link(link)[element : element + 1]
            matrix = self._links[link].of_nodes(own)[0]
            for pair, turn in zip(self._pairs(link), turns[link], strict=True):
                if self._element_at(link, pair) != element:
                    continue
                place = pair - self._per_node * element
                matrix[:, place] = (matrix[:, place, None] * turn).sum(axis=1)
                matrix[place] = (turn[:, :, None] * matrix[place][:, None]).sum(axis=0)
            entries.of_turning(number, size)[:] = matrix
        band: FloatArray = self._scatter @ entries.rows
        return band.reshape(self._frames.size, self._width + 1, -1)

    @property
    def _count(self) -> int:
        inner = sum(int(np.prod(shape)) for shape in self._shapes)
        return inner + len(self._turning) * (2 * self._per_node) ** 2

    def _pairs(self, link: int) -> list[IntArray]:
        """Coordinates of each following end of a link."""
        return [np.asarray(pair) for pair in self._frames.following(link).reshape(-1, 2)]

    def _element_at(self, link: int, pair: IntArray) -> int:
        """The element at an end of a link."""
        last = self._frames.links[link].size - self._per_node
        assert pair[0] in (0, last)
        return 0 if pair[0] == 0 else len(self._links[link].elements.length) - 1

    def _entries(self) -> _Entries:
        size = 2 * self._per_node
        parts, first = [], 0
        for link, (elements, shape) in enumerate(zip(self._links, self._shapes, strict=True)):
            places, signs = elements.relative_places, elements.node_signs
            target = self._frames.targets[link]
            for element in range(shape[0]):
                own = target[self._per_node * element + np.arange(size)]
                if (link, element) in self._turning:
                    number = self._turning.index((link, element))
                    begin = sum(int(np.prod(s)) for s in self._shapes) + number * size**2
                    source, sign = begin + np.arange(size**2), np.ones(size**2)
                else:
                    begin = first + element * shape[1] ** 2
                    source = (begin + places[:, None] * shape[1] + places).ravel()
                    sign = np.outer(signs, signs).ravel()
                rows, columns = (c.ravel() for c in np.meshgrid(own, own, indexing="ij"))
                free = (rows >= 0) & (columns >= 0)
                parts.append([x[free] for x in (rows, columns, source, sign)])
            first += int(np.prod(shape))
        return _Entries(*(np.concatenate(x) for x in zip(*parts, strict=True)))


@dataclass(frozen=True)
class _Entries:
    """Row and column in z of entries of the tangent, where they come from and their signs."""

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
