"""The linkage running: response in time, by one engine or more.

The settled motion of elastic links under a motor, found directly: every turn as the one before.

Links are linear about a motion of the crank that repeats itself, and their shaft is free. Under the
torque that the motor gives along that motion they have a periodic motion, by which the shaft leaves
it (shooting). What the links then need at the crank besides the rigid linkage is a torque over the
crank angle; with it the equation of the shaft, which is exact in its rotation, has another settled
motion. A few passes do: the shaft's answer to the links, resonant ones too, is part of the linear
equations, and what is left to repeat is of second order.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.requests import Engines, asks, engines_of
from flexmech.analyses.response.dataset import add_mesh_errors, build_dataset
from flexmech.analyses.response.driven import with_motor
from flexmech.analyses.response.motor_passes import KnownMotion, MotorPasses
from flexmech.analyses.response.plan import STEPS_PER_PERIOD, engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.run import mesh_error, run_engine
from flexmech.analyses.response.shaping import check_stops, with_shaped_law
from flexmech.analyses.response.start import or_a_start_up, simulation_start, with_usual_start
from flexmech.arrays import FloatArray, silent
from flexmech.dynamical_systems import ON_A_STEP
from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import MotorRun, SettledRun
from flexmech.linkages.change_points import TURN
from flexmech.linkages.motors.integrated_run import known_until
from flexmech.linkages.motors.motor_run import (
    SettledMotion,
    TwistedShaft,
    repeated,
    settled_motion,
    turn_series,
)
from flexmech.mechanics import Engine
from flexmech.mechanics.running import DrivenLinkage, ShaftTorque
from flexmech.mechanism import Mechanism
from flexmech.solvers import linear_run, state_under_motor
from flexmech.threads import one_thread

if TYPE_CHECKING:
    from flexmech.analyses.default_engines import ExudynEngine, ExudynSystem

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
        Engines of one mechanism, with a free shaft and a rotor that turns with it.
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
        Harmonics of the crank's turn, of what the links need.

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


@asks(ResponseRequest)
def response(mechanism: Engines, request: ResponseRequest) -> Response:
    """Run a linkage at constant crank speed, by a law of motion of its crank, or under a motor.

    Engines that simulate (Exudyn) run the nonlinear motion; the others the equations of
    motion in link frames. Joint forces and torque are those up to half the lowest frequency
    at which the links vibrate along themselves. Each run is repeated with another time step.
    With a shaper a law that stops is run shaped as well.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        All of one mechanism; of a mechanism the reference engine is made.

    Returns
    -------
    Response

    Raises
    ------
    InputError
        If the linkage locks in the course of a turn, no engine is given, or links that bend
        without load (unequally wet ones) are to start straight.
    ComputationError
        If a run diverges or does not converge; names the time and the crank angle.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> run = flexmech.response(engine, 20.0, revolutions=0.25)
    >>> [str(name) for name in run.dataset["deflection"].dims]
    ['engine', 'time', 'link']
    """
    engines, report = engines_of(mechanism, request), request.progress or silent
    request, environment = request.of(engines[0].mechanism), request.environment
    engines, request = with_motor(engines, request, environment)
    asked, request = request, with_usual_start(engines, request)
    chosen, lines = engines_in_state(engines, request, environment)
    check_stops(chosen, request)
    with one_thread():
        loss = CountedLoss.of(chosen[0])
        chosen = [loss.engine(each) for each in chosen]
        plan = planned(chosen, request)
        if isinstance(request.drive, SettledRun):
            turn = settled_with_links(chosen, request, plan.highest)
            request = replace(request, speed=turn)
            plan = replace(plan, time=request.sample_time(plan.refinement))
        elif isinstance(request.drive, MotorRun):
            known = known_until(request.drive, plan.until(request.step))
            request = replace(request, speed=known)
        with or_a_start_up(asked, request):
            runs = [run_engine(engine, request, plan, report) for engine in chosen]
        dataset = build_dataset(runs, request, plan)
        if request.check_mesh:
            add_mesh_errors(dataset, [mesh_error(run, request, plan, report) for run in runs])
        dataset = with_shaped_law(dataset, chosen, request, report)
    if plan.note:
        dataset.attrs["prediction_note"] = plan.note
    dataset.attrs["environment_lines"] = "\n".join(lines)
    dataset.attrs |= theory_attributes(chosen, request.modes) | loss.attributes
    return Response(Response.schema().labelled(dataset))


@asks(ResponseRequest)
def exudyn_system(mechanism: Engine | Mechanism, request: ResponseRequest) -> ExudynSystem:
    """Assemble the Exudyn system that :func:`response` runs, with named items and sensors.

    It is ready for ``system.mbs.SolveDynamic(system.settings)``, for the viewer, and for
    whatever Exudyn can do besides; ``system.script`` makes the same system without flexmech. Where
    no step is asked for, the run of :func:`response` is made first to find one.

    Parameters
    ----------
    mechanism : Mechanism or ExudynEngine

    Returns
    -------
    ExudynSystem

    Raises
    ------
    InputError
        If the engine is not Exudyn's, or :func:`response` would refuse the request.
    ComputationError
        If no step is found, or no start.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ExudynEngine(mechanism, 2)
    >>> system = flexmech.exudyn_system(engine, 20.0, revolutions=0.01, step=1e-4)
    >>> system.nodes["coupler_node_1"], system.objects["pin_A"], system.sensors["driving_torque"]
    (4, 13, 15)
    """
    asked = replace(request, engine=request.engine or "exudyn", environment=None)
    [engine] = engines_of(mechanism, asked if isinstance(mechanism, Mechanism) else request)
    if not hasattr(engine, "running_system"):
        raise InputError(
            f"the {engine.name} engine has no Exudyn system; give flexmech.ExudynEngine(mechanism)"
        )
    report, request = request.progress or silent, request.of(engine.mechanism)
    if isinstance(request.drive, MotorRun):
        raise InputError(
            "drive: an exported Exudyn system has no motor; give a crank speed or a law in its "
            "place, or run it by flexmech response"
        )
    request = with_usual_start([engine], request)
    [chosen], _ = engines_in_state([engine], request, request.environment)
    with one_thread():
        loss = CountedLoss.of(chosen)
        chosen = loss.engine(chosen)
        plan = planned([chosen], request)
        step = request.step
        if step is None:
            run = run_engine(chosen, request, plan, report)
            step = run.trajectory.step
        start = simulation_start(chosen, request, step)
        stride = request.sample_interval / step
        system = cast("ExudynEngine", chosen).running_system(
            request.drive,
            start,
            step,
            max(1, math.ceil(plan.time[-1] / step - ON_A_STEP)),
            integrator=request.integrator,
            stride=round(stride) if abs(stride - round(stride)) < ON_A_STEP else 1,
        )
        return replace(system, remarks=tuple(loss.attributes.values()))
