"""Natural frequencies of one engine over a map, without tracking or error estimates."""

from __future__ import annotations

from functools import partial

import numpy as np

from flexmech.analyses.frequencies.eigenproblem import solve_frequencies
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.frequencies.running_states import RunningStates
from flexmech.linear_system import Engine, StressedLinks
from flexmech.threads import one_thread
from flexmech.types import FloatArray


def systems_at(
    engine: Engine, request: FrequencyRequest, crank_speed: float, detail: float = 1.0
) -> Systems:
    """Linear systems of an engine at one crank speed of a map.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    crank_speed : float
        In rad/s.
    detail : float
        How many component modes to take.

    Returns
    -------
    Systems
        About running states where they are asked for; at rest there is nothing to run.
    """
    fastest = 0.0
    if crank_speed:
        motion = engine.mechanism.linkage.motion(request.crank_angles, 1.0)
        fastest = float(np.abs(motion.angular_velocity).max()) * abs(crank_speed)
    runs = request.formulation.prestress == "trajectory" and crank_speed
    running = RunningStates.of(engine, crank_speed) if runs else None
    return Systems(engine, request.formulation, fastest, detail, running)


def frequency_map(engine: Engine, request: FrequencyRequest, detail: float = 1.0) -> FloatArray:
    """Natural frequencies of a map without tracking or error estimates.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    detail : float
        How many component modes to take.

    Returns
    -------
    ndarray, shape (S, A, modes)
        In Hz, ascending.
    """
    with one_thread():
        return np.stack(
            [
                frequencies_along(
                    systems_at(engine, request, speed, detail), request.crank_angles, speed
                )
                for speed in request.crank_speeds.tolist()
            ]
        )


def frequencies_along(
    systems: Systems,
    crank_angles: FloatArray,
    crank_speed: FloatArray | float,
    stressed: StressedLinks | None = None,
) -> FloatArray:
    """Natural frequencies of systems along crank angles.

    Parameters
    ----------
    systems : Systems
    crank_angles : ndarray, shape (A,)
        In rad.
    crank_speed : float or ndarray, shape (A,)
        In rad/s.
    stressed : StressedLinks, optional
        In the first batch of positions; it is sought if left out.

    Returns
    -------
    ndarray, shape (A, modes)
        In Hz, ascending.
    """
    # By map no system is kept beside the next one, whose matrices then take its memory.
    solve = partial(solve_frequencies, count=systems.formulation.modes)
    return np.concatenate(list(map(solve, systems.batches(crank_angles, crank_speed, stressed))))
