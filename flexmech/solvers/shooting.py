"""Periodic steady state at constant crank speed by shooting, without a transient.

A turn of the crank maps the state at its start to that at its end. For linear equations the map is
affine, ``x -> monodromy @ x + forced``: it is computed by the trapezoidal rule for all coordinates
at once, and its fixed point is the periodic motion. The eigenvalues of the monodromy matrix are the
Floquet multipliers.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.dynamical_systems import VibrationState, initial_state
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.mechanics.running.driven_linkage import DrivenLinkage, StaticExpansion
from flexmech.solvers.march import LinearMarch

# Steps whose matrices are solved at once. Memory alone: fewer than in a single run, because a
# motion from a unit of each coordinate is kept for all of them.
BLOCK_STEPS = 256
# A turn returns some motion to itself but for this part: what it is excited to is made of
# round-off, or of the steps' errors. At the critical speed of an arm, found to all digits, each
# step of the trapezoidal rule leaves 6e-14, so that a turn of some million of them leaves this; a
# speed that is off by a millionth of itself is periodic within 1e-5.
CRITICAL = 1e-7


def periodic_state(linkage: DrivenLinkage, steps: int) -> VibrationState:
    """State at time zero of the periodic motion.

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
    state = _fixed_point(linkage, *_turn_map(linkage, steps))
    n = linkage.size
    return initial_state(linkage.equations(np.zeros(1)), state[:n], state[n:])


def state_under_motor(
    linkage: DrivenLinkage, stronger: DrivenLinkage, steps: int
) -> tuple[VibrationState, float]:
    """State at time zero of a periodic motion whose shaft a motor turns.

    The shaft has its nominal angle at time zero: which instant that is may be chosen. For it a
    constant torque is found, besides the motor's, that makes the time of a turn the nominal one;
    it is zero when the nominal motion has the right time.

    Parameters
    ----------
    linkage : DrivenLinkage
        About a motion that repeats itself, with the motor's torque along it.
    stronger : DrivenLinkage
        The same, whose motor has 1 N m more at the crank.
    steps : int
        Time steps a turn.

    Returns
    -------
    VibrationState
        Arrays of shape (n,).
    float
        The constant torque at the crank in N m.

    Raises
    ------
    InputError, ComputationError
        As :func:`periodic_state`.
    """
    monodromy, forced = _turn_map(linkage, steps)
    pushed = _turn_map(stronger, steps)[1] - forced
    count, n = len(forced), linkage.size
    bordered = np.zeros((count + 1, count + 1))
    bordered[:count, :count], bordered[:count, -1] = np.eye(count) - monodromy, -pushed
    shaft = linkage.shaft_coordinates[0]
    bordered[-1, shaft] = 1.0
    scale = _energy_scale(linkage)
    rows = np.append(scale, scale[shaft])
    columns = np.append(scale, np.linalg.norm(scale * pushed))
    solution = _solved(linkage, bordered, np.append(forced, 0.0), rows, columns)
    equations = linkage.equations(np.zeros(1))
    return initial_state(equations, solution[:n], solution[n:count]), float(solution[-1])


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
    return MotionsOfTurn.of(linkage, steps).periodic()


@dataclass(frozen=True)
class MotionsOfTurn:
    """All motions of a linkage over a turn: the forced one from rest, and one of each coordinate.

    Parameters
    ----------
    linkage : DrivenLinkage
    blocks : tuple of (ndarray, StaticExpansion, VibrationState)
        As :func:`_all_motions` yields them.
    monodromy : ndarray, shape (2 n, 2 n)
    forced : ndarray, shape (2 n,)
        State at the end of a turn that starts at zero.
    """

    linkage: DrivenLinkage
    blocks: tuple[tuple[FloatArray, StaticExpansion, VibrationState], ...]
    monodromy: FloatArray
    forced: FloatArray

    @classmethod
    def of(cls, linkage: DrivenLinkage, steps: int) -> MotionsOfTurn:
        """March through a turn; refuses as :func:`periodic_state`."""
        blocks = tuple(_all_motions(linkage, steps))
        return cls(linkage, blocks, *_affine_map(blocks[-1][2][-1]))

    def free_vibrations(self) -> tuple[ComplexArray, FloatArray]:
        """Logarithms of the Floquet multipliers, and the frequencies by which to know them.

        A multiplier says by what part a vibration misses whole periods in a turn, and not of how
        many: at the start of the turn its state ``(z, z')`` has the frequency
        ``Im(z* M z') / z* M z``, as one of constant equations has.

        Returns
        -------
        ndarray of complex, shape (2 n,)
        ndarray, shape (2 n,)
            In rad/s; negative of the conjugate of a vibration.
        """
        values, vectors = np.linalg.eig(self.monodromy.astype(complex))
        position, velocity = np.split(vectors, 2)
        mass = self.linkage.equations(np.zeros(1)).mass[0]
        crossed, squared = (
            np.einsum("ij,ij->j", position.conj(), mass @ other) for other in (velocity, position)
        )
        return np.asarray(np.log(values)), np.asarray(crossed.imag / squared.real)

    def periodic(self) -> list[FloatArray]:
        """Displacement of the engine's links on the periodic motion; see :func:`periodic_turn`."""
        linkage, start = self.linkage, _fixed_point(self.linkage, self.monodromy, self.forced)
        # Each motion is the forced one plus what a unit of a coordinate at the start adds to it.
        share = np.concatenate([[1 - start.sum()], start])
        parts: list[list[FloatArray]] = [[] for _ in linkage.links]
        for time, expansion, history in self.blocks:
            motion = VibrationState(
                history.position @ share, history.velocity @ share, history.acceleration @ share
            )
            moving = linkage.frames.link_motion(linkage.motion(time), *expansion.expanded(motion))
            for states, basis, (q, _, _) in zip(parts, linkage.bases, moving, strict=True):
                states.append(q[:-1] @ basis.T)
        return [np.concatenate(states) for states in parts]


def quasi_static_turn(linkage: DrivenLinkage, steps: int) -> list[FloatArray]:
    """Displacement of the engine's links along one turn if nothing vibrated.

    Parameters
    ----------
    linkage : DrivenLinkage
    steps : int

    Returns
    -------
    list of ndarray, shape (steps, n_link)
        As of :func:`periodic_turn`.

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    """
    time = linkage.drive.revolution_time * np.arange(steps) / steps
    equations = linkage.quasi_static_equations(time)
    position = equations.quasi_static()
    at_rest = VibrationState(position, np.zeros_like(position), np.zeros_like(position))
    links = linkage.link_motion(equations, at_rest)
    return [q @ basis.T for basis, (q, _, _) in zip(linkage.bases, links, strict=True)]


def _all_motions(
    linkage: DrivenLinkage, steps: int
) -> Iterator[tuple[FloatArray, StaticExpansion, VibrationState]]:
    """March through a turn from zero and from a unit of each coordinate, block by block.

    Yields
    ------
    ndarray, shape (m + 1,)
        Times of the start of the block and of the end of each of its m steps.
    StaticExpansion
        At these times.
    VibrationState
        At the same times; arrays of shape (m + 1, n, 1 + 2 n).

    Raises
    ------
    InputError
        If the crank speed is not constant, or loads do not repeat themselves with the turn.
    """
    if linkage.shaft is None or not linkage.shaft.has_motor:
        linkage.engine.require_prescribed_shaft("a periodic motion")
    if not linkage.drive.repeats:
        raise InputError("a periodic motion needs a constant crank speed: leave out the run-up")
    linkage.connectors.require_periodic()
    n, step = linkage.size, linkage.drive.revolution_time / steps
    march = LinearMarch(linkage, step)
    starts = np.concatenate([np.zeros((2 * n, 1)), np.eye(2 * n)], axis=1)
    state = initial_state(linkage.equations(np.zeros(1)), starts[:n], starts[n:])
    for first in range(0, steps, BLOCK_STEPS):
        last = min(first + BLOCK_STEPS, steps)
        time = step * np.arange(first, last + 1, dtype=float)
        history, expansion = march.advance(time, state)
        state = history[-1]
        yield time, expansion, history


def _turn_map(linkage: DrivenLinkage, steps: int) -> tuple[FloatArray, FloatArray]:
    """Map of the state ``(z, z')`` over a turn of the crank, as of :func:`_affine_map`."""
    [(_, _, history)] = deque(_all_motions(linkage, steps), maxlen=1)
    return _affine_map(history[-1])


def _affine_map(end: VibrationState) -> tuple[FloatArray, FloatArray]:
    """Map of the state over a turn from the end states of all motions.

    Parameters
    ----------
    end : VibrationState
        State at the end of the last block of :func:`_all_motions`.

    Returns
    -------
    ndarray, shape (2 n, 2 n)
        Monodromy matrix from crank angle at time zero.
    ndarray, shape (2 n,)
        State at the end of a turn that starts at zero.
    """
    ends = np.concatenate([end.position, end.velocity])
    return ends[:, 1:] - ends[:, :1], ends[:, 0]


def _fixed_point(linkage: DrivenLinkage, monodromy: FloatArray, forced: FloatArray) -> FloatArray:
    """Fixed point of the map: position and velocity at time zero, (2 n,)."""
    scale = _energy_scale(linkage)
    return _solved(linkage, np.eye(len(forced)) - monodromy, forced, scale, scale)


def _energy_scale(linkage: DrivenLinkage) -> FloatArray:
    """Positions by their stiffness and velocities by their mass, (2 n,): both count as energies."""
    equations = linkage.equations(np.zeros(1))
    energies = (np.diagonal(equations.stiffness[0]), np.diagonal(equations.mass[0]))
    scale = np.sqrt(np.abs(np.concatenate(energies)))
    return np.where(scale > 0, scale, 1.0)


def _solved(
    linkage: DrivenLinkage,
    matrix: FloatArray,
    forced: FloatArray,
    rows: FloatArray,
    columns: FloatArray,
) -> FloatArray:
    """Solution of the equations that close a turn, which count and whose unknowns count so much."""
    gap = rows[:, None] * matrix / columns
    if np.linalg.svd(gap, compute_uv=False)[-1] < CRITICAL:
        raise ComputationError(
            f"crank speed {CRANK_SPEED} is critical: a free vibration fits one turn of the crank "
            "exactly, and without damping no motion is periodic; change the speed a little, or "
            "give the links damping",
            crank_speed=np.copysign(2 * np.pi / linkage.drive.revolution_time, linkage.drive.speed),
        )
    return np.asarray(np.linalg.solve(gap, rows * forced) / columns)
