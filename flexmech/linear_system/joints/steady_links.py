"""Links of which nothing follows but ends that turn, and the sums of their constant matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.link_place import LinkPlace
from flexmech.linear_system.joints.link_ties import LinkTies
from flexmech.linear_system.links.chains import whole
from flexmech.linear_system.links.link_map import LinkMap, SteadySum, TurningFactors
from flexmech.linear_system.links.link_model import LinkModel


class SteadyLinks:
    """Those links of a linkage whose constant matrices are summed in all positions at once.

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
    factors : TurningFactors
        By which the sums turn.
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
            following = ties.following(number) if steady else []
            self._maps.append(LinkMap.of(target, [rows for rows, _ in following], ties.size))
            leaders.append(ties.leaders(number) if steady else [])
        self.factors = TurningFactors.of(leaders)

    @cached_property
    def mass(self) -> SteadySum:
        """Sum of the links' masses."""
        return self._sum({n: whole(self._links[n].mass) for n in self.numbers})

    def sum_of_tangents(self, tangents: Mapping[int, FloatArray]) -> SteadySum:
        """Sum over tangents (n, n) of some of the links; that of unstressed ones is made once."""
        unstressed = all(x is self._links[n].stiffness for n, x in tangents.items())
        if unstressed and len(tangents) == len(self.numbers):
            return self._stiffness
        return self._sum(tangents)

    @cached_property
    def _stiffness(self) -> SteadySum:
        return self._sum({n: whole(self._links[n].stiffness) for n in self.numbers})

    def _sum(self, matrices: Mapping[int, FloatArray]) -> SteadySum:
        """Sum of ``N'XN`` over symmetric matrices (n, n), by link."""
        # What turns has a row or a column of an end that leads, and those ends come first.
        led = [columns for n in matrices for _, columns in self._ties.following(n)]
        ends = 1 + max((int(pair.max()) for pair in led), default=-1)
        resting = np.zeros((self._ties.size, self._ties.size))
        for number, matrix in matrices.items():
            self._places[number].add_resting(resting, matrix)
        terms = [m.turning_terms(matrices.get(n), ends) for n, m in enumerate(self._maps)]
        return SteadySum.of(resting, np.concatenate(terms))
