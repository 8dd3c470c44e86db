"""Where a run begins: straight, at rest under its loads, or on a periodic motion."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.second_order import without_second_order_stretch
from flexmech.linear_system import Engine
from flexmech.linkages import CrankDrive
from flexmech.time_domain import DrivenLinkage, LinkState, VibrationState, periodic_state
from flexmech.types import FloatArray

__all__ = ["linear_start", "simulation_start"]


# Time over which a quasi-static start differentiates its displacement, in turns.
START_INTERVAL = 1e-4
LEAST_STEPS_OF_A_TURN = 1440


def simulation_start(engine: Engine, request: ResponseRequest, step: float) -> LinkState:
    """Start of a simulation, in the engine's own coordinates.

    Parameters
    ----------
    engine : Engine
        One that simulates.
    request : ResponseRequest
    step : float
        Time step in s, which a periodic start must know.

    Returns
    -------
    LinkState

    Raises
    ------
    ComputationError
        If there is no equilibrium, or no periodic motion.
    """
    if request.start == "rigid":
        return LinkState.rigid(engine.links)
    if request.start == "equilibrium":
        return _equilibrium(engine, request.drive)
    return _on_periodic_motion(engine, request, step)


def _on_periodic_motion(engine: Engine, request: ResponseRequest, step: float) -> LinkState:
    """On the periodic motion of the linear equations at time zero.

    A simulation counts the stretch by the square of the slopes, which these leave out.
    """
    linkage = DrivenLinkage(
        engine, request.drive, request.prestress, modes=request.modes, with_energy=False
    )
    first = periodic_state(linkage, _steps_of_a_turn(request, step))
    if not engine.simulates:
        start = VibrationState(first.position[None], first.velocity[None], first.acceleration[None])
        return linkage.link_state(linkage.equations(np.zeros(1)), start)
    time = _start_times(request.drive)
    after = time[:, None]
    near = VibrationState(
        first.position + after * first.velocity + after**2 / 2 * first.acceleration,
        first.velocity + after * first.acceleration,
        np.tile(first.acceleration, (len(time), 1)),
    )
    motions = linkage.link_motion(linkage.equations(time), near)
    linear = [q @ basis.T for basis, (q, _, _) in zip(linkage.bases, motions, strict=True)]
    placed = without_second_order_stretch(engine, linkage.motion(time), linear, request.prestress)
    return LinkState(
        displacement=[q[0] for q in placed],
        rate=[
            basis @ rate[0] + _rate(q - was, time)
            for basis, (_, rate, _), q, was in zip(
                linkage.bases, motions, placed, linear, strict=True
            )
        ],
    )


def _equilibrium(engine: Engine, drive: CrankDrive) -> LinkState:
    """Nonlinear quasi-static equilibrium at time zero, and how fast the loads move it."""
    time = _start_times(drive)
    motion = drive.motion(engine.mechanism.linkage, time)
    displacement = engine.stressed_links(motion, "equilibrium").displacement
    if displacement is None:
        return LinkState.rigid(engine.links)
    return LinkState(
        displacement=[q[0] for q in displacement],
        rate=[_rate(q, time) for q in displacement],
    )


def linear_start(linkage: DrivenLinkage, request: ResponseRequest, step: float) -> VibrationState:
    """Start of a run of the linear equations.

    Parameters
    ----------
    linkage : DrivenLinkage
    request : ResponseRequest
    step : float
        Time step in s, which a periodic start must know.

    Returns
    -------
    VibrationState
        Position and velocity; the acceleration follows from the equations.

    Raises
    ------
    ComputationError
        If there is no equilibrium, or no periodic motion.
    """
    nothing = np.zeros(linkage.size)
    if request.start == "rigid":
        return VibrationState(linkage.unstressed(), nothing, nothing)
    if linkage.stretch is not None:
        return _stretching_start(linkage, request, step)
    if request.start == "periodic":
        return periodic_state(linkage, _steps_of_a_turn(request, step))
    time = _start_times(request.drive)
    position = linkage.standing(time).quasi_static(held=linkage.shaft_coordinates)
    return VibrationState(position[0], _rate(position, time), nothing)


def _stretching_start(
    linkage: DrivenLinkage, request: ResponseRequest, step: float
) -> VibrationState:
    """Start of links that stretch, in their own balance along their axes.

    The linear equations and the equilibrium of corotational beams put link ends where they
    are but for the fourth order of the slopes; the tension of a link would feel that.
    """
    position, velocity = linkage.coordinates(simulation_start(linkage.engine, request, step))
    if request.start == "periodic":
        return VibrationState(linkage.balanced(position, axial_only=True), velocity, 0 * velocity)
    time = _start_times(request.drive)
    still = np.stack([linkage.balanced(position, float(t)) for t in time])
    return VibrationState(still[0], _rate(still, time), 0 * velocity)


def _start_times(drive: CrankDrive) -> FloatArray:
    return np.asarray(START_INTERVAL * drive.revolution_time * np.arange(3.0), dtype=float)


def _rate(position: FloatArray, time: FloatArray) -> FloatArray:
    """Time derivative at the first of three evenly spaced times, of second order."""
    first, second, third = position
    return np.asarray((-3 * first + 4 * second - third) / (2 * (time[1] - time[0])))


def _steps_of_a_turn(request: ResponseRequest, step: float) -> int:
    return max(LEAST_STEPS_OF_A_TURN, round(request.drive.revolution_time / step))
