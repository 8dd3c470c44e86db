"""The plan of a run: engines in their environment, samples, and the band of forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.analyses.damping_ratios import with_damping_time
from flexmech.analyses.frequencies import natural_frequencies
from flexmech.analyses.remarks import environment_lines
from flexmech.analyses.requests import engines_of, sampled_turn
from flexmech.analyses.response.request import MOST_SAMPLES, NO_PERIODIC_START, ResponseRequest
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import Engine, OverdampedError
from flexmech.numbers import check_instance
from flexmech.time_domain.equations_of_motion import lowest_axial_frequency
from flexmech.types import FloatArray

SPECTRUM_REACH = 1.5
"""Spectra reach this far above the highest natural frequency asked for."""
# Samples in a period of the highest frequency of the spectra; two would be the limit.
_SAMPLES_PER_PERIOD = 2.5
# Forces and torque count up to this part of the lowest frequency at which the links vibrate
# along themselves: what rings faster depends on the time step and on how the start is idealized.
_FORCE_BAND = 0.5


@dataclass(frozen=True)
class RunPlan:
    """Samples and bands of a run.

    Parameters
    ----------
    refinement : int
        Samples taken for each one asked for.
    time : ndarray, shape (N,)
        Of the samples taken, in s.
    lowest, highest : float
        Natural frequencies between which the spectra are of interest, in Hz.
    band : float
        Frequency in Hz up to which forces and torque count.
    note : str
        What is to be said of the natural frequencies.
    """

    refinement: int
    time: FloatArray
    lowest: float
    highest: float
    band: float
    note: str = ""


def engines_in_state(
    engines: Engine | Sequence[Engine], request: ResponseRequest, environment: Environment | None
) -> tuple[list[Engine], list[str]]:
    """Engines that are fit for a request, of the mechanism as it is in its environment.

    Parameters
    ----------
    engines : Engine or sequence of Engine
        All of one mechanism.
    request : ResponseRequest
    environment : HygrothermalState or Exposure, optional

    Returns
    -------
    list of Engine
    list of str
        What the environment does.

    Raises
    ------
    InputError
        If the linkage locks in the course of a turn, no engine is given, links that bend
        without load are to start straight, or a free shaft is to start on a periodic motion or
        to run by linear equations without prestress.
    """
    check_instance(request, ResponseRequest, "request", "give a flexmech.ResponseRequest")
    chosen = engines_of(engines, request.modes)
    lines = environment_lines(chosen[0].mechanism, environment)
    if environment is not None:
        wet = mechanism_in_state(chosen[0].mechanism, environment)
        chosen = [engine.with_(mechanism=wet).fit_for(request.modes) for engine in chosen]
    if request.shaft is not None:
        chosen = [engine.with_(shaft=request.shaft) for engine in chosen]
    if request.start == "periodic" and any(engine.shaft == "free" for engine in chosen):
        raise InputError(NO_PERIODIC_START)
    linear = [engine.name for engine in chosen if not engine.simulates]
    if linear and chosen[0].shaft == "free" and request.prestress == "none":
        raise InputError(
            f"a free shaft needs the tension of the links in the {linear[0]} engine's run: without "
            "it a turn of the shaft would meet the centrifugal potential of straight links; use "
            "prestress axial or equilibrium"
        )
    mechanism = chosen[0].mechanism
    if request.start == "rigid" and mechanism.is_free_strained:
        raise InputError(
            "start rigid would hold links straight that are bent without any load, and then let "
            "them ring; choose start equilibrium or periodic"
        )
    # A crank that cannot turn round shows itself here, before anything is computed.
    mechanism.linkage.motion(request.drive.crank_angle(request.sample_time()), 1.0)
    return chosen, lines


def planned(engines: Sequence[Engine], request: ResponseRequest) -> RunPlan:
    """Samples and bands of a run of these engines.

    Parameters
    ----------
    engines : sequence of Engine
    request : ResponseRequest

    Returns
    -------
    RunPlan

    Raises
    ------
    InputError
        If the run holds more vibrations than samples can show.
    ComputationError
        If there are no natural frequencies at this speed.
    """
    lowest, highest, without_damping = _predicted_range(engines, request)
    refinement = _refinement(request, highest)
    turn = sampled_turn(request.drive.start_angle)
    band = _FORCE_BAND * lowest_axial_frequency(engines[0], turn)
    time, note = request.sample_time(refinement), ""
    if without_damping:
        note = (
            f"natural frequencies are those without damping: with it fewer than {request.modes} "
            "of the lowest modes oscillate"
        )
    return RunPlan(refinement, time, lowest, highest, band, note)


def _predicted_range(
    engines: Sequence[Engine], request: ResponseRequest
) -> tuple[float, float, bool]:
    """Lowest and highest natural frequency of interest in Hz, and whether damping is left out."""
    engines = [vibrating_engine(engine) for engine in engines]
    first, turn = engines[0], sampled_turn(request.drive.start_angle)

    def at_rest(engine: Engine) -> FloatArray:
        level = engine.prestress_at_rest
        return natural_frequencies(
            engine, turn, modes=request.modes, prestress=level, rotation_terms=False
        )

    def at_speed(engine: Engine) -> FloatArray:
        speed, level = request.drive.speed, request.prestress
        return natural_frequencies(engine, turn, speed, modes=request.modes, prestress=level)

    frequency, without_damping = oscillating(at_rest, first)
    for engine in engines:
        # Frequencies at speed that cannot be computed show themselves before the long run.
        without_damping |= oscillating(at_speed, engine)[1]
    return float(frequency.min()), float(frequency.max()), without_damping


def _refinement(request: ResponseRequest, highest: float) -> int:
    """Samples taken for each one asked for, so that the spectra's frequencies show."""
    fastest = _SAMPLES_PER_PERIOD * SPECTRUM_REACH * highest
    if not fastest * request.duration <= MOST_SAMPLES:
        raise InputError(
            f"a run of {request.duration:.3g} s holds more vibrations of up to "
            f"{SPECTRUM_REACH * highest:.3g} Hz than {MOST_SAMPLES} samples can show; ask for "
            "fewer revolutions, or a higher crank speed"
        )
    return max(1, int(np.ceil(fastest * request.sample_interval)))


def undamped(engine: Engine) -> Engine:
    """The engine whose links, springs and joints have no damping."""
    free = with_damping_time(engine, 0.0)
    mechanism = free.mechanism
    return free.with_(
        mechanism=replace(
            mechanism,
            springs=tuple(replace(spring, damping=0.0) for spring in mechanism.springs),
            joint_springs=tuple(
                replace(own, torsional_damping=0.0, radial_damping=0.0)
                for own in mechanism.joint_springs
            ),
        )
    )


def oscillating(compute: Callable[[Engine], FloatArray], engine: Engine) -> tuple[FloatArray, bool]:
    """Natural frequencies, or those without damping if it keeps some modes from oscillating.

    A run needs them for its samples and its spectra; the run itself may be damped as heavily as
    one likes.

    Parameters
    ----------
    compute : callable
        Gives the natural frequencies of an engine.
    engine : Engine

    Returns
    -------
    ndarray
    bool
        Whether damping is left out.

    Raises
    ------
    ComputationError
        If there are none for another reason.
    """
    try:
        return compute(engine), False
    except OverdampedError:
        return compute(undamped(engine)), True


def vibrating_engine(engine: Engine) -> Engine:
    """The engine whose natural frequencies a run is expected to show.

    Where springs answer a turn of a free shaft, nothing tells its own mode from the others, and
    it may diverge under loads: the frequencies are then those with the shaft held.

    Parameters
    ----------
    engine : Engine
        Of the run.

    Returns
    -------
    Engine
    """
    if engine.shaft == "free" and not engine.rigid_modes:
        return engine.with_(shaft="prescribed")
    return engine
