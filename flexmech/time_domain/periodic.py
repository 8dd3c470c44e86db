"""The periodic steady state at constant crank speed, without running the transient out.

Shooting: a turn of the crank maps the state at its start to that at its end by an affine
map, ``x -> monodromy @ x + forced``. The map is taken along with the trapezoidal rule for
all coordinates at once; its fixed point is where the motion repeats itself. The eigenvalues
of the monodromy matrix are the Floquet multipliers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations import Equations, Following
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.step_table import StepTable
from flexmech.time_domain.trapezoidal import initial_state, march
from flexmech.types import FloatArray

# Steps whose matrices are solved at once; fewer than in a single run, because a motion from a
# unit of each coordinate is kept for all of them.
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
        If the crank speed is not constant, or loads do not repeat themselves with the turn.
    """
    state = None
    for _, _, history in _all_motions(linkage, steps):
        state = history[-1]
    assert state is not None
    return _map_to(state)


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
        If the crank speed is not constant, or loads do not repeat themselves with the turn.
    ComputationError
        If a free vibration fits a turn exactly, so that without damping the forced motion
        grows without limit.
    """
    equations = linkage.equations(np.zeros(1))
    position, velocity = _fixed_point(linkage, turn_map(linkage, steps), equations)
    return initial_state(equations, position, velocity)


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
    blocks = list(_all_motions(linkage, steps))
    turn = _map_to(blocks[-1][2][-1])
    start = np.concatenate(_fixed_point(linkage, turn, linkage.equations(np.zeros(1))))
    # Each motion is the forced one plus what a unit of a coordinate at the start adds to it.
    share = np.concatenate([[1 - start.sum()], start])
    parts: list[list[FloatArray]] = [[] for _ in linkage.links]
    for time, following, history in blocks:
        motion = VibrationState(
            history.position @ share, history.velocity @ share, history.acceleration @ share
        )
        moving = linkage.frames.link_motion(linkage.motion(time), *following.expanded(motion))
        for part, basis, (q, _, _) in zip(parts, linkage.bases, moving, strict=True):
            part.append(q[:-1] @ basis.T)
    return [np.concatenate(part) for part in parts]


def _all_motions(
    linkage: DrivenLinkage, steps: int
) -> Iterator[tuple[FloatArray, Following, VibrationState]]:
    """March through a turn from zero and from a unit of each coordinate, block by block.

    Yields
    ------
    ndarray, shape (m + 1,)
        Times of the start of the block and of the end of each of its m steps.
    Following
        At these times.
    VibrationState
        At the same times; arrays of shape (m + 1, n, 1 + 2 n).

    Raises
    ------
    InputError
        If the crank speed is not constant, or loads do not repeat themselves with the turn.
    """
    linkage.engine.require_prescribed_shaft("a periodic motion")
    if not linkage.drive.is_constant:
        raise InputError("a periodic motion needs a constant crank speed: leave out the run-up")
    linkage.connectors.require_periodic()
    n, step = linkage.size, linkage.drive.revolution_time / steps
    table = StepTable(linkage, step)
    starts = np.concatenate([np.zeros((2 * n, 1)), np.eye(2 * n)], axis=1)
    state = initial_state(linkage.equations(np.zeros(1)), starts[:n], starts[n:])
    for first in range(0, steps, BLOCK_STEPS):
        last = min(first + BLOCK_STEPS, steps)
        time = step * np.arange(first, last + 1, dtype=float)
        rows = table.rows(time)
        history = march(rows.linear[1:], state)
        state = history[-1]
        yield time, rows.following, history


def _map_to(end: VibrationState) -> TurnMap:
    ends = np.concatenate([end.position, end.velocity])
    return TurnMap(ends[:, 1:] - ends[:, :1], ends[:, 0])


def _fixed_point(
    linkage: DrivenLinkage, turn: TurnMap, equations: Equations
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity that a turn returns to; ``equations`` begin at time zero."""
    n = linkage.size
    # Positions by their stiffness and velocities by their mass: both count as energies, and
    # the condition number is none of units.
    energies = (np.diagonal(equations.stiffness[0]), np.diagonal(equations.mass[0]))
    scale = np.sqrt(np.abs(np.concatenate(energies)))
    gap = scale[:, None] * (np.eye(2 * n) - turn.monodromy) / scale
    if 1 / np.linalg.cond(gap) < RESONANT:
        raise ComputationError(
            f"crank speed {CRANK_SPEED} is critical: a free vibration fits one turn of the crank "
            "exactly, and without damping no motion is periodic; change the speed a little, or "
            "give the links damping",
            crank_speed=linkage.drive.speed,
        )
    state = np.linalg.solve(gap, scale * turn.forced) / scale
    return state[:n], state[n:]
