"""The settled motion of elastic links under a motor, found directly: every turn as the one before.

Links are linear about a motion of the crank that repeats itself, and their shaft is free. Under the
torque that the motor gives along that motion they have a periodic motion, by which the shaft leaves
it (shooting). What the links then need at the crank besides the rigid linkage is a torque over the
crank angle; with it the equation of the shaft, which is exact in its rotation, has another settled
motion. A few passes do: the shaft's answer to the links, resonant ones too, is part of the linear
equations, and what is left to repeat is of second order.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.response.motor_passes import KnownMotion, MotorPasses
from flexmech.analyses.response.plan import STEPS_PER_PERIOD
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.linkages import SettledRun
from flexmech.linkages.change_points import TURN
from flexmech.linkages.motors.motor_run import (
    SettledMotion,
    TwistedShaft,
    repeated,
    settled_motion,
    turn_series,
)
from flexmech.time_domain import DrivenLinkage, ShaftTorque, linear_run, state_under_motor

logger = logging.getLogger(__name__)

# Of the crank's speed: by which the links still change it. The equation of the shaft has other
# steps than theirs: what these leave does not fall from pass to pass, but with their square.
_CONVERGED, _LEFT_BY_STEPS = 1e-6, 3e-5
_MOST_PASSES = 12
# A quarter of a degree, and steps of the fastest harmonic that counts.
_LEAST_STEPS, _STEPS_A_HARMONIC = 1440, 12
# Harmonics of the motion that frames turn with: the stress of the links along it is known at 120
# places of a turn. Faster ones are vibration of the shaft about it.
_SMOOTH = 20


def settled_with_links(
    engines: Sequence[Engine], request: ResponseRequest, highest: float
) -> SettledRun:
    """A run on the settled motion of elastic links, from that of the rigid linkage.

    By the equations of the reference engine, which have the internal forces of the links: those of
    engines that simulate are linear about an equilibrium that a prescribed shaft holds.

    Parameters
    ----------
    engines : sequence of Engine
        Of one mechanism, with a free shaft and a rotor that turns with it.
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
    run, engine = request.drive, engines[0]
    assert isinstance(run, SettledRun)
    if engine.simulates:
        reference = engine_kind("reference")
        engine = reference(engine.mechanism, engine.elements, shaft="free").fit_for(request.modes)
    last = np.inf
    for number in range(_MOST_PASSES):
        steps = int(np.ceil(max(_LEAST_STEPS, STEPS_PER_PERIOD * highest * run.revolution_time)))
        found, torque = _turn(engine, run, request, steps)
        turn = _settled(run, found, torque, _SMOOTH)
        away = _apart(turn, run.turn)
        logger.info("settled motion: pass %d, crank speed off by %.1e", number + 1, away)
        if away <= _CONVERGED or last / 2 < away <= _LEFT_BY_STEPS:
            turn = _settled(run, found, torque, steps // _STEPS_A_HARMONIC)
            return repeated(turn, run.rigid, run.drive, request.revolutions)
        run, last = repeated(turn, run.rigid, run.drive, request.revolutions), away
    raise ComputationError(
        f"the settled motion of elastic links is not found: after {_MOST_PASSES} passes they still "
        f"change the crank's speed by {100 * away:.3g} % of it; give the links damping or the "
        "shaft more inertia, or choose start rigid and run more revolutions"
    )


def _apart(turn: SettledMotion, before: SettledMotion) -> float:
    """Greatest difference of the speeds of crank and rotor, over the mean speed."""
    rows = [1, 3] if turn.equation.train.is_coupled else [1]
    apart = np.abs(turn.values[rows] - before.values[rows]).max()
    return float(apart) / abs(turn.mean_speed)


def _settled(
    run: SettledRun, found: KnownMotion, torque: FloatArray, harmonics: int
) -> SettledMotion:
    """The settled motion under what the links need over the angle of the rotor.

    Parameters
    ----------
    run : SettledRun
    found : KnownMotion
        About it, over a turn with both ends, (steps + 1,).
    torque : ndarray, shape (steps + 1,)
        On the crank in N m.
    harmonics : int
        Of the crank's turn, of what the links need.

    Returns
    -------
    SettledMotion

    Raises
    ------
    ComputationError
        If there is none.
    """
    steps, equation = len(torque) - 1, run.equation
    once = slice(0, steps)
    time, angle = found.time[once], found.rotor_angle[once]
    # Rates of one closed path: those of the steps would do work over a turn.
    away = np.fft.rfft(found.rotor[once])
    rate = 2j * np.pi / run.revolution_time * np.arange(len(away))
    speed = run.crank_speed(time) + np.fft.irfft(rate * away, steps)
    acceleration = run.crank_acceleration(time) + np.fft.irfft(rate**2 * away, steps)
    needed = equation.load.needed(angle, speed, time) + equation.inertia(angle) * acceleration
    order = np.argsort(angle)

    def over_turn(values: FloatArray) -> FourierSeries:
        return turn_series(angle[order], values[order], harmonics)

    added = over_turn(torque[once] - needed)
    rotor = replace(equation, train=equation.train.without_coupling, added=added)
    states = run.states(0.0)[equation.train.motor_place :]
    twist = over_turn((found.rotor - found.rotation)[once])
    start = run.drive.start_angle
    begin = start
    for _ in range(_MOST_PASSES * equation.train.is_coupled):
        begin = start + float(twist.at(np.asarray(begin / TURN)))
    turn = settled_motion(rotor, np.array([begin, speed[0], *states]))
    if turn is None:
        raise ComputationError(
            "with these links the motor settles at no speed: no turn ends as it begins; choose "
            "start rigid or equilibrium, and look at how the run goes on"
        )
    if not equation.train.is_coupled:
        return turn
    shaft = TwistedShaft(rotor, equation.train, twist)
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
