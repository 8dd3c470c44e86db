"""The settled motion of elastic links under a motor, found directly: every turn as the one before.

Links are linear about a motion of the crank that repeats itself, and their shaft is free. Under the
torque that the motor gives along that motion they have a periodic motion, by which the shaft leaves
it (shooting). What the links then need at the crank besides the rigid linkage is a torque over the
crank angle; with it the equation of the shaft, which is exact in its rotation, has another settled
motion. Two or three passes do: the shaft's answer to the links, resonant ones too, is part of the
linear equations, and what is left to repeat is of second order.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from flexmech.analyses.response.motor_passes import KnownMotion, MotorPasses
from flexmech.analyses.response.plan import STEPS_PER_PERIOD
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.linkages import (
    AddedTorque,
    SettledMotion,
    SettledRun,
    TwistedShaft,
    periodic_spline,
    repeated,
    settled_motion,
)
from flexmech.time_domain import DrivenLinkage, ShaftTorque, linear_run, state_under_motor

logger = logging.getLogger(__name__)

# Of the crank's speed: by which the links still change it. The equation of the shaft has other
# steps than theirs: what these leave does not fall from pass to pass, but with their square.
_CONVERGED, _LEFT_BY_STEPS = 1e-6, 3e-5
_MOST_PASSES = 12
# A quarter of a degree, and steps of the fastest harmonic that counts.
_LEAST_STEPS, _STEPS_A_HARMONIC = 1440, 12


def settled_with_links(engine: Engine, request: ResponseRequest, highest: float) -> SettledRun:
    """A run on the settled motion of elastic links, from that of the rigid linkage.

    Parameters
    ----------
    engine : Engine
        With a free shaft, and a rotor that turns with it.
    request : ResponseRequest
        Whose drive is the settled run of the rigid linkage.
    highest : float
        Natural frequency up to which links count, in Hz.

    Returns
    -------
    SettledRun

    Raises
    ------
    ComputationError
        If the passes do not converge, or the motor settles at no speed with these links.
    """
    run = request.drive
    assert isinstance(run, SettledRun)
    last = np.inf
    for number in range(_MOST_PASSES):
        steps = int(np.ceil(max(_LEAST_STEPS, STEPS_PER_PERIOD * highest * run.revolution_time)))
        found, torque = _turn(engine, run, request, steps)
        changes = found.rate, found.rotor_rate - _lead(run, found)
        away = max(float(np.abs(own).max()) for own in changes) / abs(run.turn.mean_speed)
        logger.info("settled motion: pass %d, crank speed off by %.1e", number + 1, away)
        if away <= _CONVERGED or last / 2 < away <= _LEFT_BY_STEPS:
            return run
        last = away
        turn = _settled(run, found, torque)
        if turn is None:
            raise ComputationError(
                "with these links the motor settles at no speed: no turn ends as it begins; choose "
                "start rigid or equilibrium, and look at how the run goes on"
            )
        run = repeated(turn, run.rigid, run.drive, request.revolutions)
    raise ComputationError(
        f"the settled motion of elastic links is not found: after {_MOST_PASSES} passes they still "
        f"change the crank's speed by {100 * away:.3g} % of it; give the links damping or the "
        "shaft more inertia, or choose start rigid and run more revolutions"
    )


def _lead(run: SettledRun, found: KnownMotion) -> FloatArray:
    """Speed of the rotor beyond that of the crank in a run, (m,) in rad/s."""
    return run.rotor_speed(found.time) - run.crank_speed(found.time)


def _settled(run: SettledRun, found: KnownMotion, torque: FloatArray) -> SettledMotion | None:
    """The settled motion under what the links need over the angle of the rotor.

    Parameters
    ----------
    run : SettledRun
    found : KnownMotion
        About it, over a turn with both ends, (steps + 1,).
    torque : ndarray, shape (steps + 1,)
        On the crank in N m.

    Returns
    -------
    SettledMotion or None
        None where there is none.
    """
    steps, equation = len(torque) - 1, run.equation
    once = slice(0, steps)
    time, angle, speed = (own[once] for own in (found.time, found.rotor_angle, found.rotor_speed))
    away = np.fft.rfft(found.rotor_rate[once])
    rate = 2j * np.pi / run.revolution_time * np.arange(len(away))
    acceleration = run.crank_acceleration(time) + np.fft.irfft(rate * away, steps)
    needed = equation.load.needed(angle, speed, time) + equation.inertia(angle) * acceleration
    beside = np.fft.rfft(torque[once] - needed)
    beside[steps // _STEPS_A_HARMONIC :] = 0.0
    order = np.argsort(angle)
    load = AddedTorque(equation.load, angle[order], np.fft.irfft(beside, steps)[order])
    rotor = replace(equation, load=load, train=equation.train.without_coupling)
    states = run.states(0.0)[2 * equation.train.is_coupled :]
    turn = settled_motion(rotor, np.array([found.rotor_angle[0], found.rotor_speed[0], *states]))
    if turn is None or not equation.train.is_coupled:
        return turn
    twist = found.rotor - found.rotation
    shaft = TwistedShaft(rotor, equation.train, periodic_spline(angle[order], twist[once][order]))
    return SettledMotion(shaft, turn.time, shaft.values(turn.values))


def _turn(
    engine: Engine, run: SettledRun, request: ResponseRequest, steps: int
) -> tuple[KnownMotion, FloatArray]:
    """A turn of the links on their periodic motion about a run, and the torque on their crank."""
    step = run.revolution_time / steps
    torque = MotorPasses(run).torque_along(step * np.arange(2.0 * (steps + 1)))

    def linkage(given: ShaftTorque) -> DrivenLinkage:
        return DrivenLinkage(
            engine, run, request.prestress, modes=request.modes, shaft_torque=given
        )

    def with_more(more: float) -> ShaftTorque:
        return replace(torque, torque=torque.torque + more, recorded=[])

    pair = linkage(with_more(0.0)), linkage(with_more(1.0))
    state, constant = state_under_motor(*pair, steps)
    given = with_more(constant)
    time = step * np.arange(steps + 1.0)
    found = linear_run(linkage(given), state.position, state.velocity, time, step)
    return KnownMotion.recorded(run, given), found.driving_torque
