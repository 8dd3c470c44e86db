"""The periodic motion of a nonlinear simulation, found by shooting.

A simulated turn maps the state at its start to that at its end. The linear equations know
how the end answers a change of the start (their monodromy matrix), which makes Newton's
method with an approximate derivative out of one simulated turn an iteration. It finds the
periodic motion whether or not damping would ever lead there.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.periodic import periodic_state, turn_map
from flexmech.time_domain.recording import Trajectory
from flexmech.time_domain.state import LinkState, VibrationState
from flexmech.types import FloatArray

logger = logging.getLogger(__name__)

Turn = Callable[[LinkState], Trajectory]

# The iteration ends when a turn closes to this part of its greatest displacement. Without
# damping the fastest modes return with phases that the linear equations only guess: where
# they keep it from getting there, the best turn counts if it closes to within the second.
CLOSURE = 2e-4
LEAST_CLOSURE = 2e-3
MOST_TURNS = 12


@dataclass(frozen=True)
class PeriodicOrbit:
    """A simulated turn that ends where it started.

    Parameters
    ----------
    start : LinkState
    turn : Trajectory
    closure : float
        How far it ends from its start, over the greatest displacement.
    turns : int
        Simulated turns that it took to find it.
    """

    start: LinkState
    turn: Trajectory
    closure: float
    turns: int


def simulated_orbit(linkage: DrivenLinkage, steps: int, simulate_turn: Turn) -> PeriodicOrbit:
    """Find the periodic motion of a simulation.

    Parameters
    ----------
    linkage : DrivenLinkage
        Linear equations of the same engine at the same, constant speed.
    steps : int
        Time steps a turn.
    simulate_turn : callable
        Simulates one turn from a state; its samples include start and end.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    ComputationError
        If the iteration does not close the orbit, or the crank speed is critical.
    """
    monodromy, n = turn_map(linkage, steps).monodromy, linkage.size
    gain = np.linalg.inv(np.eye(2 * n) - monodromy)
    equations = linkage.equations(np.zeros(1))
    start = periodic_state(linkage, steps)
    state = np.concatenate([start.position, start.velocity])
    best: PeriodicOrbit | None = None
    for turns in range(1, MOST_TURNS + 1):
        first = linkage.link_state(
            equations, VibrationState(state[None, :n], state[None, n:], np.zeros((1, n)))
        )
        turn = simulate_turn(first)
        orbit = PeriodicOrbit(first, turn, _closure(linkage, turn), turns)
        logger.info("turn %d closes to %.1e of its greatest displacement", turns, orbit.closure)
        if best is not None and orbit.closure >= best.closure:
            break
        best = orbit
        if orbit.closure <= CLOSURE:
            return orbit
        gap = _state(linkage, _at(turn, -1)) - _state(linkage, _at(turn, 0))
        state = state + gain @ gap
    assert best is not None
    if best.closure <= LEAST_CLOSURE:
        return best
    raise ComputationError(
        f"no periodic motion found at crank speed {CRANK_SPEED}: the best of {turns} turns ends "
        f"{100 * best.closure:.3g} % of its greatest displacement away from its start; change the "
        "crank speed a little, or give the links damping",
        crank_speed=linkage.drive.speed,
    )


def _closure(linkage: DrivenLinkage, turn: Trajectory) -> float:
    """Distance of the end from the start over the greatest displacement, at the stations."""
    gap, size = 0.0, 0.0
    for link, q in zip(linkage.engine.links, turn.displacement, strict=True):
        gap = max(gap, float(np.abs(link.shape @ (q[-1] - q[0])).max()))
        size = max(size, float(np.abs(np.einsum("scn,bn->bsc", link.shape, q)).max()))
    return gap / size


def _at(turn: Trajectory, sample: int) -> LinkState:
    return LinkState([q[sample] for q in turn.displacement], [r[sample] for r in turn.rate])


def _state(linkage: DrivenLinkage, state: LinkState) -> FloatArray:
    return np.concatenate(linkage.coordinates(state))
