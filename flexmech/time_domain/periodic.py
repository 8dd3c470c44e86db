"""The periodic steady state at constant crank speed, without running the transient out.

Shooting: a turn of the crank maps the state at its start to that at its end by an affine
map, ``x -> monodromy @ x + forced``. The map is taken along with the trapezoidal rule for
all coordinates at once; its fixed point is where the motion repeats itself. The eigenvalues
of the monodromy matrix are the Floquet multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import ComputationError, InputError
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import initial_state, march, step_operators

__all__ = ["TurnMap", "periodic_state", "turn_map"]

FloatArray = NDArray[np.float64]

BLOCK_STEPS = 256
# Reciprocal condition number below which a turn returns some motion so exactly to itself
# that the fixed point is made of round-off.
RESONANT = 1e-11


@dataclass(frozen=True)
class TurnMap:
    """How a turn of the crank changes the state ``(z, z')``, from crank angle at time zero.

    Parameters
    ----------
    monodromy : ndarray, shape (2 n, 2 n)
    forced : ndarray, shape (2 n,)
        State at the end of a turn that starts at zero.
    """

    monodromy: FloatArray
    forced: FloatArray


def turn_map(linkage: DrivenLinkage, steps: int) -> TurnMap:
    """Map of one turn by the trapezoidal rule.

    Parameters
    ----------
    linkage : DrivenLinkage
        At constant crank speed.
    steps : int
        Time steps a turn.

    Returns
    -------
    TurnMap

    Raises
    ------
    InputError
        If the crank speed is not constant.
    """
    if not linkage.drive.is_constant:
        raise InputError("a periodic motion needs a constant crank speed: leave out the run-up")
    n, step = linkage.size, linkage.drive.revolution_time / steps
    starts = np.concatenate([np.zeros((2 * n, 1)), np.eye(2 * n)], axis=1)
    state = initial_state(linkage.equations(np.zeros(1)), starts[:n], starts[n:])
    for first in range(0, steps, BLOCK_STEPS):
        time = step * np.arange(first + 1, min(first + BLOCK_STEPS, steps) + 1, dtype=float)
        state = march(step_operators(linkage.equations(time), step), state)[-1]
    ends = np.concatenate([state.position, state.velocity])
    return TurnMap(ends[:, 1:] - ends[:, :1], ends[:, 0])


def periodic_state(linkage: DrivenLinkage, steps: int) -> VibrationState:
    """State at time zero of the motion that repeats itself every turn.

    Parameters
    ----------
    linkage : DrivenLinkage
        At constant crank speed.
    steps : int
        Time steps a turn.

    Returns
    -------
    VibrationState
        Arrays of shape (n,).

    Raises
    ------
    InputError
        If the crank speed is not constant.
    ComputationError
        If a free vibration fits a turn exactly, so that without damping the forced motion
        grows without limit.
    """
    turn, n = turn_map(linkage, steps), linkage.size
    equations = linkage.equations(np.zeros(1))
    # Positions by their stiffness and velocities by their mass: both count as energies, and
    # the condition number is none of units.
    energies = (np.diagonal(equations.stiffness[0]), np.diagonal(equations.mass[0]))
    scale = np.sqrt(np.abs(np.concatenate(energies)))
    gap = scale[:, None] * (np.eye(2 * n) - turn.monodromy) / scale
    if 1 / np.linalg.cond(gap) < RESONANT:
        raise ComputationError(
            f"crank speed {linkage.drive.speed:.6g} rad/s is critical: a free vibration fits "
            "one turn of the crank exactly, and without damping no motion is periodic; change "
            "the speed a little, or give the links damping"
        )
    state = np.linalg.solve(gap, scale * turn.forced) / scale
    return initial_state(equations, state[:n], state[n:])


def periodic_turn(linkage: DrivenLinkage, steps: int) -> list[FloatArray]:
    """Displacement of the engine's links along one turn of the periodic motion.

    Parameters
    ----------
    linkage : DrivenLinkage
        At constant crank speed.
    steps : int
        Time steps a turn.

    Returns
    -------
    list of ndarray, shape (steps, n_link)
        In the frames of the rigid motion, at evenly spaced times from zero.

    Raises
    ------
    InputError, ComputationError
        As :func:`periodic_state`.
    """
    state, step = periodic_state(linkage, steps), linkage.drive.revolution_time / steps
    parts: list[list[FloatArray]] = [[] for _ in linkage.links]
    for first in range(0, steps, BLOCK_STEPS):
        last = min(first + BLOCK_STEPS, steps)
        equations = linkage.equations(step * np.arange(first, last + 1, dtype=float))
        history = march(step_operators(equations[1:], step), state)
        moving = linkage.link_motion(equations, history)
        for part, basis, (q, _, _) in zip(parts, linkage.bases, moving, strict=True):
            part.append(q[:-1] @ basis.T)
        state = history[-1]
    return [np.concatenate(part) for part in parts]
