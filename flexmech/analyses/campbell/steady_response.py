"""Peaks of the periodic motion over the quasi-static ones, for the diagram's lower panel."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.speed_sweep import (
    highest_frequency,
    periodic_peaks,
    quasi_static_peaks,
    vibrating_linkage,
)
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine

logger = logging.getLogger(__name__)

MOST_RESPONSES = 100
"""Speeds at which the periodic motion is computed, evenly chosen from those asked for."""
RESPONSE_MODES = 3
"""Harmonics of the crank that reach higher modes are weak."""
# A turn at a low speed is long, and its motion quasi-static.
SLOWEST = 0.05


@dataclass(frozen=True)
class SteadyResponse:
    """Peaks at R crank speeds.

    Parameters
    ----------
    crank_speed : ndarray, shape (R,)
        rad/s.
    ratio : ndarray, shape (R, n_links)
        Peak deflection of the periodic motion over that of the quasi-static one.
    left_out : dict of float to str
        Why there is no periodic motion, by crank speed.
    """

    crank_speed: FloatArray
    ratio: FloatArray
    left_out: dict[float, str]


def response_speeds(crank_speeds: FloatArray) -> FloatArray:
    """Those of the crank speeds at which the periodic motion is computed.

    From a twentieth of the greatest speed on, and of many speeds a hundred, evenly chosen.

    Parameters
    ----------
    crank_speeds : ndarray, shape (S,)
        rad/s.

    Returns
    -------
    ndarray, shape (R,)

    Examples
    --------
    >>> response_speeds(np.array([0.0, 1.0, 10.0, 100.0])).tolist()
    [10.0, 100.0]
    """
    size = np.abs(crank_speeds)
    fast = crank_speeds[(size > 0) & (size >= SLOWEST * size.max())]
    some = np.linspace(0, len(fast) - 1, min(len(fast), MOST_RESPONSES))
    return np.asarray(fast[np.unique(np.round(some).astype(np.intp))])


def steady_response(
    engine: Engine,
    crank_speeds: FloatArray,
    prestress: Prestress,
    report: Callable[[int], None],
    speed_unit: str,
) -> SteadyResponse:
    """Peaks of the periodic motion of the linear equations over the quasi-static peaks.

    Parameters
    ----------
    engine : Engine
    crank_speeds : ndarray, shape (R,)
        rad/s, not zero.
    prestress : {"none", "axial", "equilibrium"}
    report : callable
        Called with 1 after each speed.
    speed_unit : str
        In which reasons speak of crank speeds.

    Returns
    -------
    SteadyResponse
        Without the speeds that have no periodic motion, as a critical one without damping.
    """
    highest = highest_frequency(engine, RESPONSE_MODES)
    found, ratios, left_out = [], [], {}
    for speed in crank_speeds.tolist():
        try:
            linkage = vibrating_linkage(engine, speed, RESPONSE_MODES, prestress)
            moving, still = periodic_peaks(linkage, highest), quasi_static_peaks(linkage)
        except ComputationError as error:
            logger.info("no periodic motion at %g rad/s: %s", speed, error)
            left_out[speed] = error.told(speed_unit)
        else:
            found.append(speed)
            # A link that no load bends has no ratio; it does not vibrate either.
            ratios.append(np.where(still > 0, moving / np.where(still > 0, still, 1.0), 1.0))
        report(1)
    links = len(engine.mechanism.linkage.topology.link_names)
    return SteadyResponse(
        np.array(found, dtype=float), np.array(ratios, dtype=float).reshape(-1, links), left_out
    )
