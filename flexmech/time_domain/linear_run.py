"""A run of the linear equations of motion from a given start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.errors import ComputationError
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.dynamics import LinkageDynamics
from flexmech.time_domain.marching import marching
from flexmech.time_domain.recording import Recorder, Trajectory
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import initial_state
from flexmech.types import FloatArray, StepProgress

# Steps that are recorded at once.
BLOCK_STEPS = 1024
# Displacements beyond this many metres are no small vibration of any linkage.
DIVERGED = 1e6


def linear_run(
    linkage: DrivenLinkage,
    position: FloatArray,
    velocity: FloatArray,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress | None = None,
    *,
    band: float | None = None,
) -> Trajectory:
    """Integrate the equations of motion: see :func:`flexmech.time_domain.marching`.

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
    band : float, optional
        Frequency in Hz up to which joint forces and torque are kept.

    Returns
    -------
    Trajectory

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    march, dynamics = marching(linkage, step), LinkageDynamics(linkage)
    recorder = Recorder(sample_time, step, band, march.stride)
    steps = march.stride * -(-recorder.steps // march.stride)
    state = start_state(linkage, position, velocity)
    for done in range(0, steps, BLOCK_STEPS):
        count = min(BLOCK_STEPS, steps - done)
        time = step * np.arange(done, done + count + 1, dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):
            history, following = march.on(time, state)
        refuse_divergence(linkage, time, history)
        recorder.add(dynamics.step_block(time, following, history))
        state = history[-1]
        if progress is not None:
            progress(done + count, steps)
    run = recorder.finish()
    return replace(
        run,
        displacement=[q @ b.T for q, b in zip(run.displacement, linkage.bases, strict=True)],
        rate=[q @ b.T for q, b in zip(run.rate, linkage.bases, strict=True)],
    )


def start_state(
    linkage: DrivenLinkage, position: FloatArray, velocity: FloatArray
) -> VibrationState:
    """State at time zero whose acceleration satisfies the equations of motion.

    Parameters
    ----------
    linkage : DrivenLinkage
    position, velocity : ndarray, shape (n,)

    Returns
    -------
    VibrationState
        Arrays of shape (n,).
    """
    equations = linkage.equations(np.zeros(1))
    if linkage.stretch is not None:
        pulled = linkage.stretch.remainder(
            linkage.stretch.pin_turns(equations.motion), position[None], velocity[None]
        )
        equations = replace(equations, force=equations.force - pulled)
    return initial_state(equations, position, velocity)


def refuse_divergence(linkage: DrivenLinkage, time: FloatArray, history: VibrationState) -> None:
    """Refuse displacements that grow beyond all bounds.

    Parameters
    ----------
    linkage : DrivenLinkage
    time : ndarray, shape (m,)
        In s.
    history : VibrationState
        At these times.

    Raises
    ------
    ComputationError
        Names the time and the crank angle.
    """
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
