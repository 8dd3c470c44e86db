"""Bands of the moving natural frequencies at a few crank speeds, to hold Floquet frequencies to.

Without rotation terms, for with them frozen frequencies depend on the frame that they are written
in. The stress of the running links is in them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.stability.request import StabilityRequest
from flexmech.choices import Prestress
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine, stressed_along_turn
from flexmech.time_domain import SampledTurn
from flexmech.types import FloatArray

MOST_SPEEDS = 9
ANGLES = 36


@dataclass(frozen=True)
class MovingBands:
    """Natural frequencies over a turn, of the modes asked for or of as many as there are.

    Parameters
    ----------
    crank_speed : ndarray, shape (s,)
        rad/s.
    lowest, mean, highest : ndarray, shape (s, m)
        In Hz; zero where the linkage is statically unstable.
    """

    crank_speed: FloatArray
    lowest: FloatArray
    mean: FloatArray
    highest: FloatArray


def moving_bands(engine: Engine, request: StabilityRequest) -> MovingBands:
    """Bands at nine of a map's crank speeds at most; those without equilibrium are left out.

    Parameters
    ----------
    engine : Engine
    request : StabilityRequest

    Returns
    -------
    MovingBands
        About the quasi-static equilibrium where the map is about the periodic motion.
    """
    level: Prestress = "equilibrium" if request.prestress == "trajectory" else request.prestress
    speeds = request.crank_speeds
    places = np.linspace(0, len(speeds) - 1, min(len(speeds), MOST_SPEEDS)).round().astype(int)
    found, rows = [], []
    for speed in speeds[places].tolist():
        try:
            hertz = _frequencies(engine, speed, level, request.modes)
        except ComputationError:
            continue
        found.append(speed)
        rows.append((hertz.min(axis=0), hertz.mean(axis=0), hertz.max(axis=0)))
    modes = len(rows[0][0]) if rows else request.modes
    table = np.array(rows).reshape(len(rows), 3, modes)
    return MovingBands(np.array(found), *np.moveaxis(table, 1, 0))


def _frequencies(engine: Engine, speed: float, prestress: Prestress, modes: int) -> FloatArray:
    """Of the lowest modes at evenly spaced crank angles, (ANGLES, m)."""
    angle = 2 * np.pi / ANGLES * np.arange(ANGLES)
    motion = engine.mechanism.linkage.motion(angle, speed)
    stressed = stressed_along_turn(engine, motion, prestress)
    turn = SampledTurn.of(engine, motion, stressed, prestress, modes)
    squares = turn.frozen_squares[:, turn.rigid_modes :][:, :modes]
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi))
