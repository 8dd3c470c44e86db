"""Steps of the propagator in a turn, and whether they fit into memory."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.stability.request import MOST_STEPS
from flexmech.analyses.stability.vibrating_linkage import SHAPE_ANGLES, VibratingLinkage
from flexmech.errors import CRANK_SPEED, ComputationError

# Steps are this part of a period of the fastest moving mode over 2 pi, or shorter.
RADIANS_A_STEP = 1.5
# A free shaft moves far more slowly, and what the steps leave of the fastest modes shows there.
RADIANS_BESIDE_A_FREE_SHAFT = 0.5
LEAST_STEPS = 128
# Bytes that the steps of a turn may take, and what is kept of each step: matrices of the size of A,
# and waves of each harmonic (measured).
MOST_BYTES, MATRICES_A_STEP, WAVES_A_STEP = 4e9, 10, 12


def steps_of_turn(moving: VibratingLinkage, asked: int | None, *, beside_free_shaft: bool) -> int:
    """Steps of a turn: those asked for, or as many as the fastest moving mode wants.

    Parameters
    ----------
    moving : VibratingLinkage
        A constant one is solved by its eigenvalues, with any number of steps.
    asked : int or None
        A multiple of :data:`SHAPE_ANGLES`, at most :data:`MOST_STEPS`.
    beside_free_shaft : bool
        Whether the crank's shaft rotates freely.

    Returns
    -------
    int

    Raises
    ------
    ComputationError
        If the steps do not fit into memory.
    """
    if asked is None:
        steps = _wanted_steps(moving, beside_free_shaft=beside_free_shaft)
        remedy = "fewer modes or faster crank speeds"
    else:
        steps, remedy = asked, "fewer steps"
    if moving.is_constant:
        return int(min(steps, MOST_STEPS))
    _refuse_too_many_steps(steps, moving, remedy)
    return int(steps)


def _wanted_steps(moving: VibratingLinkage, *, beside_free_shaft: bool) -> float:
    """Steps that the fastest moving mode wants, however many."""
    radians = RADIANS_BESIDE_A_FREE_SHAFT if beside_free_shaft else RADIANS_A_STEP
    wanted = max(LEAST_STEPS, moving.fastest * moving.period / radians)
    return float(2 * SHAPE_ANGLES * np.ceil(wanted / (2 * SHAPE_ANGLES)))


def _refuse_too_many_steps(steps: float, moving: VibratingLinkage, remedy: str) -> None:
    """Refuse steps that do not fit into memory."""
    matrices = MATRICES_A_STEP * (2 * moving.size) ** 2
    waves = WAVES_A_STEP * len(moving.conservative.coefficients)
    size = np.dtype(float).itemsize * steps * (matrices + waves)
    frequency = moving.fastest / (2 * np.pi)
    if size > MOST_BYTES:
        raise ComputationError(
            f"a turn at crank speed {CRANK_SPEED} takes {steps:.7g} steps, since the fastest mode "
            f"vibrates at {frequency:.3g} Hz; they need some {size / 1e9:.2g} GB, and at most "
            f"{MOST_BYTES / 1e9:g} are taken: ask for {remedy}",
            crank_speed=moving.crank_speed,
        )
