"""A run of the linear equations of motion from a given start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.errors import ComputationError
from flexmech.time_domain.driven_linkage import DrivenLinkage, Equations
from flexmech.time_domain.dynamics import LinkageDynamics
from flexmech.time_domain.recording import Recorder, Trajectory
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import (
    StepOperators,
    initial_state,
    march,
    step_operators,
)
from flexmech.types import FloatArray, StepProgress

__all__ = ["linear_run"]


# Steps whose matrices are solved at once.
BLOCK_STEPS = 512
# Displacements beyond this many metres are no small vibration of any linkage.
DIVERGED = 1e6


@dataclass(frozen=True)
class _Block:
    """Equations at the start and the ends of consecutive steps, and their solution."""

    equations: Equations
    operators: StepOperators


class _Blocks:
    """Blocks of steps; those of a first turn serve for all later ones where they repeat."""

    def __init__(self, linkage: DrivenLinkage, step: float, steps: int) -> None:
        self.linkage, self.step, self.steps = linkage, step, steps
        turn = linkage.drive.revolution_time / step
        self.repeats = round(turn)
        constant = linkage.drive.is_constant and abs(turn - self.repeats) < 1e-9 * turn
        self._kept: dict[int, _Block] | None = {} if constant and steps > self.repeats else None

    def __iter__(self) -> Iterator[tuple[FloatArray, _Block]]:
        start = 0
        while start < self.steps:
            place = start % self.repeats if self._kept is not None else start
            limit = self.repeats - place if self._kept is not None else self.steps
            count = min(BLOCK_STEPS, limit, self.steps - start)
            yield (
                self.step * np.arange(start, start + count + 1, dtype=float),
                self._block(place, count),
            )
            start += count

    def _block(self, place: int, count: int) -> _Block:
        kept = self._kept
        if kept is not None and place in kept and len(kept[place].operators.forced) == count:
            return kept[place]
        equations = self.linkage.equations(
            self.step * np.arange(place, place + count + 1, dtype=float)
        )
        block = _Block(equations, step_operators(equations[1:], self.step))
        if kept is not None:
            kept[place] = block
        return block


def linear_run(
    linkage: DrivenLinkage,
    position: FloatArray,
    velocity: FloatArray,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress | None = None,
) -> Trajectory:
    """Integrate the equations of motion by the trapezoidal rule.

    Parameters
    ----------
    linkage : DrivenLinkage
    position, velocity : ndarray, shape (n,)
        Independent coordinates at time zero and their time derivatives.
    sample_time : ndarray, shape (N,)
        Increasing from zero or later, in s.
    step : float
        In s.
    progress : callable, optional
        Called with the steps done and the steps to do.

    Returns
    -------
    Trajectory

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    steps = int(np.ceil(sample_time[-1] / step - 1e-9))
    dynamics, recorder = LinkageDynamics(linkage), Recorder(sample_time, step)
    state = initial_state(linkage.equations(np.zeros(1)), position, velocity)
    done = 0
    for time, block in _Blocks(linkage, step, steps):
        with np.errstate(over="ignore", invalid="ignore"):
            history = march(block.operators, state)
        _refuse_divergence(linkage, time, history)
        recorder.add(dynamics.step_block(time, block.equations, history))
        state = history[-1]
        done += len(time) - 1
        if progress is not None:
            progress(done, steps)
    return recorder.finish()


def _refuse_divergence(linkage: DrivenLinkage, time: FloatArray, history: VibrationState) -> None:
    size = np.abs(history.position).max(axis=1)
    wrong = ~(size < DIVERGED)
    if not wrong.any():
        return
    first = float(time[np.flatnonzero(wrong)[0]])
    angle = np.degrees(float(linkage.drive.crank_angle(first)))
    raise ComputationError(
        f"the linear response (prestress '{linkage.prestress}') diverges: at time {first:.6g} s, "
        f"crank angle {angle:.6g} deg, displacements exceed any linkage; the linearized motion "
        "is unstable at this crank speed: lower it, or add the prestress that stiffens the links"
    )
