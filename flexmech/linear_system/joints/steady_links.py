"""Links whose only dependent rows are pinned ends: sums of their constant matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.link_place import LinkPlace
from flexmech.linear_system.joints.link_ties import LinkTies
from flexmech.linear_system.links.link_model import LinkModel


class SteadyLinks:
    """Links whose constant matrices are summed for all positions at once.

    Parameters
    ----------
    ties : LinkTies
    links : sequence of LinkModel
        All of them.
    places : sequence of LinkPlace
        Of all links.

    Attributes
    ----------
    numbers : frozenset of int
        Which links these are.
    factors : RotationFactors
        Cosines and sines by which the sums vary.
    """

    def __init__(
        self, ties: LinkTies, links: Sequence[LinkModel], places: Sequence[LinkPlace]
    ) -> None:
        self._ties, self._links, self._places = ties, links, places
        self.numbers = frozenset(n for n in range(len(links)) if not ties.is_general(n))
        self._maps = []
        leaders: list[list[int]] = []
        for number, target in enumerate(ties.targets):
            steady = number in self.numbers
            dependencies = ties.dependencies(number) if steady else []
            self._maps.append(LinkMap.of(target, [rows for rows, _ in dependencies], ties.size))
            leaders.append(ties.leaders(number) if steady else [])
        self.factors = RotationFactors.of(leaders)

    @cached_property
    def mass(self) -> SteadySum:
        """Sum of the links' masses."""
        return self._sum({n: self._links[n].mass for n in self.numbers})

    def sum_of_tangents(self, tangents: Mapping[int, FloatArray]) -> SteadySum:
        """Sum over tangents (..., n, n) of some of the links; that of unstressed ones is cached."""
        unstressed = all(x is self._links[n].stiffness for n, x in tangents.items())
        if unstressed and len(tangents) == len(self.numbers):
            return self._stiffness
        return self._sum(tangents)

    @cached_property
    def _stiffness(self) -> SteadySum:
        return self._sum({n: self._links[n].stiffness for n in self.numbers})

    def write_coriolis(self, total: FloatArray, speed: FloatArray, numbers: Sequence[int]) -> None:
        """Write the constant part of ``N' 2 omega S N`` of some links, and zero elsewhere.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
            Of several designs as many positions of each, one after the other.
        speed : ndarray, shape (B, n_links)
            Angular velocities in rad/s.
        numbers : sequence of int
        """
        if not numbers:
            total[:] = 0.0
            return
        order, (*designs, count, entries) = sorted(self.numbers), self._coriolis.shape
        each = (*designs, len(total) // (designs or [1])[0])
        counted = speed[:, order] * [float(number in numbers) for number in order]
        whole_one = total.reshape(*each, entries)
        np.matmul(counted.reshape(*each, count), self._coriolis, out=whole_one)

    @cached_property
    def _coriolis(self) -> FloatArray:
        """Constant part of ``N' 2 S N`` of each of these links, (..., k, size size)."""
        size, found = self._ties.size, []
        for number in sorted(self.numbers):
            matrix = 2 * self._links[number].gyroscopic
            found.append(np.zeros((*matrix.shape[:-2], size, size)))
            self._places[number].add_constant(found[-1], matrix)
        every = np.stack(found, axis=-3)
        return every.reshape(*every.shape[:-2], size * size)

    def _sum(self, matrices: Mapping[int, FloatArray]) -> SteadySum:
        """Sum of ``N'XN`` over symmetric matrices (..., n, n), by link."""
        # Terms that vary have a row or a column of a leading end, and those come first.
        leading = [columns for n in matrices for _, columns in self._ties.dependencies(n)]
        ends = 1 + max((int(pair.max()) for pair in leading), default=-1)
        designs = next((matrix.shape[:-2] for matrix in matrices.values()), ())
        constant = np.zeros((*designs, self._ties.size, self._ties.size))
        for number, matrix in matrices.items():
            self._places[number].add_constant(constant, matrix)
        terms = [m.rotating_terms(matrices.get(n), ends) for n, m in enumerate(self._maps)]
        every = [np.broadcast_to(each, (*designs, *each.shape[-3:])) for each in terms]
        return SteadySum.of(constant, np.concatenate(every, axis=-3))


@dataclass(frozen=True)
class LinkMap:
    """``N_i``: a link's coordinates from those of the linkage, term by term.

    Parameters
    ----------
    parts : ndarray, shape (m, n, size)
        Factors of 1, and of the cosine and the sine of each dependent end's angle.
    """

    parts: FloatArray

    @classmethod
    def of(cls, target: IntArray, pairs: Sequence[IntArray], size: int) -> LinkMap:
        """Map of a link.

        Parameters
        ----------
        target : ndarray of int, shape (n,)
            Coordinate of the linkage for each of the link; -1 where fixed.
        pairs : sequence of ndarray of int, shape (2,)
            Coordinates of the link's dependent ends.
        size : int
            Number of coordinates of the linkage.
        """
        parts = np.zeros((1 + 2 * len(pairs), len(target), size))
        free = np.flatnonzero(target >= 0)
        parts[0, free, target[free]] = 1.0
        for pair, cosine, sine in zip(pairs, parts[1::2], parts[2::2], strict=True):
            parts[0, pair] = 0.0
            cosine[pair, target[pair]] = 1.0
            sine[pair, target[pair[::-1]]] = [-1.0, 1.0]
        return cls(parts)

    def rotating_terms(self, matrix: FloatArray | None, rows: int) -> FloatArray:
        """Coefficients of the products of factors in rows of ``N'XN``.

        Parameters
        ----------
        matrix : ndarray, shape (..., n, n), or None
            Symmetric; None for zero.
        rows : int
            How many, the first ones.

        Returns
        -------
        ndarray, shape (..., r, rows, size)
            Of ``f_i f_j`` for i <= j without the first, constant one; r = m (m + 1) / 2 - 1.
        """
        first, second = _two_of(len(self.parts))
        if matrix is None or not len(first):
            return np.zeros((len(first), rows, self.parts.shape[2]))
        left = np.swapaxes(self.parts[:, None, :, :rows], 2, 3) @ matrix[..., None, None, :, :]
        products = left @ self.parts
        mirrored = np.where(first == second, 0.0, 1.0)[:, None, None]
        return np.asarray(
            products[..., first, second, :, :] + mirrored * products[..., second, first, :, :]
        )


@dataclass(frozen=True)
class RotationFactors:
    """Products ``f_i f_j`` of the factors of all links, by the angles of their frames.

    Parameters
    ----------
    leaders, followers : ndarray of int, shape (k,)
        Leading and following link of each dependent end.
    first, second : ndarray of int, shape (1 + r,)
        Numbers of two factors: the first is 1, those of end e are 1 + 2 e and 2 + 2 e. The first
        product is 1, then come those of one link after the other.
    """

    leaders: IntArray
    followers: IntArray
    first: IntArray
    second: IntArray

    @classmethod
    def of(cls, leaders: Sequence[Sequence[int]]) -> RotationFactors:
        """Factors of links with the leaders of each."""
        first, second = [np.zeros(1, dtype=np.intp)], [np.zeros(1, dtype=np.intp)]
        followers: list[int] = []
        for link, leading in enumerate(leaders):
            own = np.concatenate([[0], 1 + 2 * len(followers) + np.arange(2 * len(leading))])
            for products, numbers in zip((first, second), _two_of(len(own)), strict=True):
                products.append(own[numbers])
            followers += [link] * len(leading)
        every = np.array([leader for leading in leaders for leader in leading], dtype=np.intp)
        numbers = np.array(followers, dtype=np.intp)
        return cls(every, numbers, np.concatenate(first), np.concatenate(second))

    def at(self, angle: FloatArray) -> FloatArray:
        """Products at angles of the frames.

        Parameters
        ----------
        angle : ndarray, shape (B, n_links)
            In rad.

        Returns
        -------
        ndarray, shape (1 + r, B)
        """
        turned = angle.T[self.leaders] - angle.T[self.followers]
        factors = np.ones((1 + 2 * len(turned), len(angle)))
        np.cos(turned, out=factors[1::2])
        np.sin(turned, out=factors[2::2])
        return np.asarray(factors[self.first] * factors[self.second])


@dataclass(frozen=True)
class SteadySum:
    """Sum of ``N'XN`` over links whose matrices are the same in all positions of a design.

    Parameters
    ----------
    constant : ndarray, shape (..., size, size)
        The part that does not depend on the angles.
    terms : ndarray, shape (..., 1 + r, e, w)
        First rows and columns of that part and of the coefficients of the products of factors. All
        other rows are constant but, by symmetry, in these columns.
    """

    constant: FloatArray
    terms: FloatArray

    @classmethod
    def of(cls, constant: FloatArray, terms: FloatArray) -> SteadySum:
        """Sum without the columns that are constant.

        Parameters
        ----------
        constant : ndarray, shape (..., size, size)
        terms : ndarray, shape (..., r, e, size)
        """
        ends = terms.shape[-2]
        turning = np.flatnonzero(terms.any(axis=tuple(range(terms.ndim - 1))))
        width = max(ends, 1 + int(turning[-1]) if len(turning) else 0)
        every = np.concatenate([constant[..., None, :ends, :], terms], axis=-3)
        return cls(constant, np.ascontiguousarray(every[..., :width]))

    def write(self, total: FloatArray, factors: FloatArray) -> None:
        """Write the sum in all positions.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
            Of several designs as many positions of each, one after the other.
        factors : ndarray, shape (1 + r, B)
            See :class:`RotationFactors`.
        """
        designs, (count, ends, width) = self.terms.shape[:-3], self.terms.shape[-3:]
        each = (*designs, len(total) // (designs[0] if designs else 1))
        own = factors.T.reshape(*each, count)
        turned = own @ self.terms.reshape(*designs, count, -1)
        turned = turned.reshape(len(total), ends, width)
        total.reshape(*each, *total.shape[1:])[:] = self.constant[..., None, :, :]
        total[:, :ends, :width] = turned
        total[:, ends:width, :ends] = np.swapaxes(turned[:, :, ends:], 1, 2)


@cache
def _two_of(count: int) -> tuple[IntArray, IntArray]:
    """Numbers i <= j of two factors, without those of 1 alone."""
    first, second = np.triu_indices(count)
    return first[1:], second[1:]
