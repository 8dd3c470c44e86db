"""Equilibria at some crank speeds, from which the search for another one starts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmech.dynamical_systems import FourierSeries
from flexmech.types import FloatArray

# Of polynomials in the square of the crank speed, which the inertia forces are in proportion to.
MOST_SPEEDS = 3


@dataclass(frozen=True)
class KnownEquilibria:
    """Elastic displacements along the turn at the crank speeds solved for so far.

    A start decides how long the search takes; what it finds is the equilibrium to round-off.

    Parameters
    ----------
    displacement : dict of float to sequence of ndarray, shape (N, n_link)
        Of each link, by the crank speed; at any number N of evenly spaced crank angles.
    """

    displacement: dict[float, Sequence[FloatArray]] = field(default_factory=dict)

    def add(self, crank_speed: float, displacement: Sequence[FloatArray] | None) -> None:
        """Remember an equilibrium; None stands for straight links, which need no search."""
        if displacement is not None:
            self.displacement[crank_speed] = displacement

    @classmethod
    def of_all(cls, parts: Iterable[KnownEquilibria]) -> KnownEquilibria:
        """Those of all parts, apart from what is added to them later."""
        return cls({speed: q for part in parts for speed, q in part.displacement.items()})

    def near(self, crank_speed: float, samples: int) -> list[FloatArray] | None:
        """Displacement of each link (samples, n_link) extrapolated to a crank speed.

        Parameters
        ----------
        crank_speed : float
            rad/s.
        samples : int
            Number of crank angles.

        Returns
        -------
        list of ndarray, or None
            None where nothing is known.
        """
        if crank_speed in self.displacement:
            return [_sampled(q, samples) for q in self.displacement[crank_speed]]
        nearest = sorted(self.displacement, key=lambda known: abs(known - crank_speed))
        speeds = nearest[:MOST_SPEEDS]
        if not speeds:
            return None
        weights = _lagrange(np.square(speeds), crank_speed**2)
        links = zip(*(self.displacement[speed] for speed in speeds), strict=True)
        return [
            np.asarray(sum(w * _sampled(q, samples) for w, q in zip(weights, link, strict=True)))
            for link in links
        ]


def _sampled(displacement: FloatArray, samples: int) -> FloatArray:
    if len(displacement) == samples:
        return displacement
    return FourierSeries.through(displacement).samples(samples)


def _lagrange(places: FloatArray, wanted: float) -> FloatArray:
    """Weights (k,) of the polynomial through values at places (k,)."""
    apart = places[:, None] - places + np.eye(len(places))
    factors = np.where(np.eye(len(places), dtype=bool), 1.0, (wanted - places) / apart)
    return np.asarray(factors.prod(axis=1))
