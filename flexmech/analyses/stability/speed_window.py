"""A window of crank speeds over which the linkage's small periodic system is interpolated.

Stress and moving modes change smoothly with the crank speed. At the nodes of Chebyshev polynomials
the system is built, with the same fixed basis; in between its Fourier coefficients follow by
interpolation, which costs next to nothing. The last Chebyshev coefficient tells the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmech.analyses.stability.known_equilibria import KnownEquilibria
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.dynamical_systems import FourierSeries
from flexmech.types import FloatArray

NODES = 6
"""Crank speeds at which the system is built."""


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

    def holds(self, crank_speed: float) -> bool:
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
