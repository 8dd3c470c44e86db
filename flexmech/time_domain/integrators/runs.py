"""Runs of a driven linkage in time from a given start.

Linear equations are integrated by the trapezoidal rule, those of links that stretch by the
square of their slopes by Lobatto's method of fourth order: what a step of them costs is spent
on the forces that are not linear, of which longer steps ask for fewer. Runs with large
displacements are those of an engine that simulates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol, cast

import numpy as np

from flexmech.arrays import FloatArray, StepProgress
from flexmech.choices import Integrator, LinkDirection
from flexmech.dynamical_systems import VibrationState, initial_state
from flexmech.dynamical_systems.lobatto import STAGES
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system import Engine, LinkPoint
from flexmech.linkages import Drive
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage, StaticExpansion
from flexmech.time_domain.equations_of_motion.dynamics import LinkageDynamics
from flexmech.time_domain.integrators.linear_march import LinearMarch
from flexmech.time_domain.integrators.stretch_march import StretchMarch
from flexmech.time_domain.recorded_runs.recording import Recorder
from flexmech.time_domain.recorded_runs.states import Impact, LinkState, Trajectory

# Steps that are recorded at once. Speed and memory alone: to record a block takes about ten
# milliseconds besides its steps, and some 20 MB of a four-bar's matrices and forces.
BLOCK_STEPS = 2048
# Displacements beyond this many metres are no small vibration of any linkage.
DIVERGED = 1e6


def marching(linkage: DrivenLinkage, step: float) -> LinearMarch | StretchMarch:
    """Time integration method for a linkage.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        Between recorded instants, in s.

    Returns
    -------
    LinearMarch or StretchMarch
    """
    if linkage.stretch is None:
        return LinearMarch(linkage, step)
    return StretchMarch(linkage, step)


def step_lag(angle: float, *, stretches: bool) -> float:
    """Relative period error: lowering of a free vibration's frequency, to leading order.

    Parameters
    ----------
    angle : float
        Of the vibration in one step, in rad.
    stretches : bool
        Whether the method is that of links that stretch.

    Returns
    -------
    float
    """
    return float((STAGES * angle) ** 4 / 720 if stretches else angle**2 / 12)


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
    """Integrate the equations of motion by the method of :func:`marching`.

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
    start = position, velocity
    for done, time, history, expansion in _blocks(linkage, march, start, step, steps):
        recorder.add(dynamics.step_block(time, expansion, history))
        if progress is not None:
            progress(done, steps)
    run = recorder.finish()
    run = replace(
        run,
        displacement=[q @ b.T for q, b in zip(run.displacement, linkage.bases, strict=True)],
        rate=[q @ b.T for q, b in zip(run.rate, linkage.bases, strict=True)],
    )
    return run if linkage.shaft is None else linkage.shaft.turned_back(run)


def end_state(
    linkage: DrivenLinkage, position: FloatArray, velocity: FloatArray, end: float, steps: int
) -> LinkState:
    """State of the engine's links at the end of a run, of which nothing else is kept.

    Parameters
    ----------
    linkage : DrivenLinkage
    position, velocity : ndarray, shape (n,)
        Independent coordinates at time zero and their time derivatives.
    end : float
        In s.
    steps : int
        At least: a method may take its steps in groups.

    Returns
    -------
    LinkState

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    stride = (LinearMarch if linkage.stretch is None else StretchMarch).stride
    steps = stride * -(-steps // stride)
    march = marching(linkage, end / steps)
    *_, (*_, history, _) = _blocks(linkage, march, (position, velocity), end / steps, steps)
    return linkage.link_state(linkage.equations(np.array([end])), history[-1:])


def _blocks(
    linkage: DrivenLinkage,
    march: LinearMarch | StretchMarch,
    start: tuple[FloatArray, FloatArray],
    step: float,
    steps: int,
) -> Iterator[tuple[int, FloatArray, VibrationState, StaticExpansion]]:
    """Run from a position and velocity, block by block; each begins where the last one ends.

    Yields
    ------
    int
        Steps done.
    ndarray, shape (m,)
        Times of the block in s.
    VibrationState
        Arrays of shape (m, n).
    StaticExpansion

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    equations = linkage.equations(np.zeros(1))
    if linkage.stretch is not None:
        moving = [part[None] for part in start]
        pulled = linkage.stretch.nonlinear_forces(equations.motion, *moving)
        equations = replace(equations, force=equations.force - pulled)
    state = initial_state(equations, *start)
    for first in range(0, steps, BLOCK_STEPS):
        done = min(first + BLOCK_STEPS, steps)
        time = step * np.arange(first, done + 1, dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):
            history, expansion = march.advance(time, state)
        _refuse_divergence(linkage, time, history)
        yield done, time, history, expansion
        state = history[-1]


def _refuse_divergence(linkage: DrivenLinkage, time: FloatArray, history: VibrationState) -> None:
    """Refuse displacements that grow beyond all bounds."""
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


class Simulator(Protocol):
    """An engine that runs the linkage with large displacements."""

    def simulate(
        self,
        drive: Drive,
        start: LinkState,
        sample_time: FloatArray,
        step: float,
        *,
        integrator: Integrator = "trapezoidal",
        progress: StepProgress | None = None,
        band: float | None = None,
        impacts: Sequence[Impact] = (),
    ) -> Trajectory:
        """Run from a state of the links.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        sample_time : ndarray, shape (N,)
            Increasing, zero or later, in s.
        step : float
            Time step in s.
        integrator : {"trapezoidal", "generalized-alpha"}
        progress : callable, optional
            Called with the steps done and the steps to do.
        band : float, optional
            Frequency in Hz up to which joint forces and torque are kept.
        impacts : sequence of Impact
            Pulses on points of links, whose work the energy balance does not know.

        Returns
        -------
        Trajectory

        Raises
        ------
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """

    def point_histories(
        self,
        drive: Drive,
        start: LinkState,
        points: Sequence[tuple[LinkPoint, LinkDirection]],
        step: float,
        steps: int,
        *,
        impacts: Sequence[Impact] = (),
        progress: StepProgress | None = None,
    ) -> FloatArray:
        """Displacement of points of links at every step of the trapezoidal rule.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        points : sequence of (LinkPoint, {"transverse", "axial"})
        step : float
            In s.
        steps : int
        impacts : sequence of Impact
        progress : callable, optional
            Called with the steps done and the steps to do.

        Returns
        -------
        ndarray, shape (steps + 1, n_points)
            In m, in the frames of the rigid links.
        """


def simulator(engine: Engine) -> Simulator:
    """An engine that simulates; others are refused."""
    if not engine.simulates:
        raise InputError(
            f"the {engine.name} engine does not simulate the running linkage with large "
            "displacements; use the exudyn engine"
        )
    return cast(Simulator, engine)
