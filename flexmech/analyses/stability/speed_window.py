"""A window of crank speeds over which the linkage's small periodic system is interpolated.

Stress and moving modes change smoothly with the crank speed. At the nodes of Chebyshev polynomials
the system is built, with the same fixed basis; in between its Fourier coefficients follow by
interpolation, which costs next to nothing. The last Chebyshev coefficient tells the error.
Equilibria at some crank speeds start the search for another one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries

# Of polynomials in the square of the crank speed, which the inertia forces are in proportion to:
# more of them would make more of what each equilibrium is off by.
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


# Crank speeds at which the system is built: of a window of a fortieth of the lowest frequency the
# last Chebyshev coefficient is then 1e-8.
NODES = 6


@dataclass(frozen=True)
class SpeedWindow:
    """The linkage at the nodes of a window.

    Parameters
    ----------
    low, high : float
        Ends of the window in rad/s.
    nodes : sequence of VibratingLinkage
        At :func:`chebyshev_nodes`, all with the same fixed basis and scale.
    equilibria : KnownEquilibria
        At these.
    """

    low: float
    high: float
    nodes: Sequence[VibratingLinkage]
    equilibria: KnownEquilibria = field(default_factory=KnownEquilibria)

    def contains(self, crank_speed: float) -> bool:
        """Whether a speed is in the window."""
        return self.low <= crank_speed <= self.high

    def at(self, crank_speed: float) -> VibratingLinkage:
        """The linkage at a speed in the window; shapes and limits are those of the nearest node."""
        speeds = np.array([node.crank_speed for node in self.nodes])
        nearest = self.nodes[int(np.abs(speeds - crank_speed).argmin())]
        weights = _lagrange(speeds, crank_speed)
        return replace(
            nearest,
            crank_speed=crank_speed,
            conservative=_sum([node.conservative for node in self.nodes], weights),
            dissipative=_sum([node.dissipative for node in self.nodes], weights),
            attached=_sum([node.attached for node in self.nodes], weights),
        )

    @property
    def error(self) -> float:
        """Estimated error of the system's matrix, relative to its greatest entry."""
        values = np.stack([node.conservative.coefficients for node in self.nodes])
        angles = np.pi * (np.arange(NODES) + 0.5) / NODES
        last = np.tensordot(np.cos((NODES - 1) * angles), values, axes=(0, 0)) * 2 / NODES
        return float(np.abs(last).max() / np.abs(values).max())


def chebyshev_nodes(low: float, high: float) -> FloatArray:
    """Crank speeds of the nodes of a window, (NODES,), from the highest to the lowest."""
    angles = np.pi * (np.arange(NODES) + 0.5) / NODES
    return np.asarray((low + high) / 2 + (high - low) / 2 * np.cos(angles))


def _lagrange(nodes: FloatArray, place: float) -> FloatArray:
    """Weights (k,) of the polynomial through values at nodes (k,)."""
    apart = nodes[:, None] - nodes + np.eye(len(nodes))
    factors = np.where(np.eye(len(nodes), dtype=bool), 1.0, (place - nodes) / apart)
    return np.asarray(factors.prod(axis=1))


def _sum(series: Sequence[FourierSeries], weights: FloatArray) -> FourierSeries:
    values = np.stack([each.coefficients for each in series])
    return FourierSeries(np.tensordot(weights, values, axes=(0, 0)))
