"""The plan of a run: engines in their environment, samples, and the band of forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from flexmech.analyses.damping_ratios import with_damping_time
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.requests import ANGLES, engines_of
from flexmech.analyses.response.request import MOST_SAMPLES, NO_PERIODIC_START, ResponseRequest
from flexmech.analyses.summary import environment_lines
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import look_ahead
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linkages import MotorRun, refuse_passing
from flexmech.mechanics import Engine, LinkFrames, LinkModel, OverdampedError, RotationTerms
from flexmech.validation import check_instance

# Spectra reach this far above the highest natural frequency asked for, so that its peak stands
# within the picture.
SPECTRUM_REACH = 1.5
# Samples in a period of the highest frequency of the spectra; two would be the limit.
_SAMPLES_PER_PERIOD = 2.5
# Forces and torque count up to this part of the lowest frequency at which the links vibrate
# along themselves: what rings faster depends on the time step and on how the start is idealized.
_FORCE_BAND = 0.5
# Part of the greatest eigenvalue: what is below is round-off of links that turn.
_LOOSE = 1e-10

# Steps that a method may need beyond the last value that counts, and some.
_STEPS_BEYOND = 10

# Steps in a period of the highest frequency of a run with one step, which is not extrapolated: the
# trapezoidal rule lowers that frequency by 2e-3 of itself.
STEPS_PER_PERIOD = 40


@dataclass(frozen=True)
class RunPlan:
    """Samples and bands of a run.

    Parameters
    ----------
    refinement : int
        Samples taken for each one asked for.
    time : ndarray, shape (N,)
        Time of the samples taken, in s.
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

    def until(self, step: float | None) -> float:
        """Time in s until which a run goes, at the longest, for its last forces to be filtered.

        Parameters
        ----------
        step : float, optional
            In s; left out of a run that chooses one below the interval of the samples.
        """
        longest = float(self.time[1] - self.time[0]) if step is None else step
        return float(self.time[-1]) + look_ahead(self.band) + _STEPS_BEYOND * longest


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
        without load are to start straight, the law's speed jumps where an engine does not simulate,
        or a free shaft is to start on a periodic motion or to run by linear equations without
        prestress.
    """
    check_instance(request, ResponseRequest, "request", "give a flexmech.analyses.ResponseRequest")
    chosen = engines_of(engines, modes=request.modes)
    lines = environment_lines(chosen[0].mechanism, environment)
    if environment is not None:
        wet = mechanism_in_state(chosen[0].mechanism, environment)
        chosen = [engine.with_(mechanism=wet).fit_for(request.modes) for engine in chosen]
    free = any(engine.shaft == "free" for engine in chosen)
    if request.start == "periodic" and free and not isinstance(request.drive, MotorRun):
        raise InputError(NO_PERIODIC_START)
    linear = [engine.name for engine in chosen if not engine.simulates]
    if linear and chosen[0].shaft == "free" and request.prestress == "none":
        raise InputError(
            f"a free shaft needs the tension of the links in the {linear[0]} engine's run: without "
            "it a turn of the shaft would meet the centrifugal potential of straight links; use "
            "prestress axial or equilibrium"
        )
    blow = request.drive.law.blow
    if linear and blow is not None:
        raise InputError(
            f"the speed of the law jumps by {blow[1]:.4g} rad/s at {blow[0]:.4g} s: a blow, where "
            f"the theory of the {linear[0]} engine's equations ends; run it by the exudyn engine, "
            'or take a table with ends = "rest", or "free" to run until there'
        )
    mechanism = chosen[0].mechanism
    if request.start == "rigid" and mechanism.is_free_strained:
        raise InputError(
            "start rigid would hold links straight that are bent without any load, and then let "
            "them ring; choose start equilibrium or periodic"
        )
    # A crank that cannot turn round shows itself here, before anything is computed.
    passed = request.drive.crank_angle(request.sample_time())
    mechanism.linkage.motion(passed, 1.0)
    refuse_passing(mechanism.linkage, passed)
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
    turn = request.drive.passed_angles(ANGLES)
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
    first, turn = engines[0], request.drive.passed_angles(ANGLES)

    def at_rest(engine: Engine) -> FloatArray:
        level = engine.prestress_at_rest
        return natural_frequencies(
            engine, turn, modes=request.modes, prestress=level, rotation_terms=False
        )

    def at_speed(engine: Engine) -> FloatArray:
        speed, level = request.drive.greatest_speed, request.prestress
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
    """The engine whose links, springs and joints have no damping, nor a frame on springs."""
    free = with_damping_time(engine, 0.0)
    mechanism, frame = free.mechanism, free.mechanism.frame
    return free.with_(
        mechanism=replace(
            mechanism,
            springs=tuple(replace(spring, damping=0.0) for spring in mechanism.springs),
            joint_springs=tuple(
                replace(own, torsional_damping=0.0, radial_damping=0.0)
                for own in mechanism.joint_springs
            ),
            frame=None if frame is None else frame.undamped,
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
        Engine of the run.

    Returns
    -------
    Engine
    """
    if engine.shaft == "free" and not engine.rigid_modes:
        return engine.with_(shaft="prescribed")
    return engine


def lowest_axial_frequency(engine: Engine, crank_angle: FloatArray) -> float:
    """Lowest natural frequency of a linkage whose links stretch but do not bend, in Hz.

    Straight links, pinned as they are, with all masses and without stress: a truss, in which
    a clamped link does not turn. The least of all positions. Bearings hold in it. Welds are pins
    in it: links that turn about these without stretching any do not vibrate and are not counted,
    nor are rigid links, of which a truss may be loose.

    Parameters
    ----------
    engine : Engine
    crank_angle : ndarray, shape (m,)
        In rad.

    Returns
    -------
    float
    """
    engine.check_runs()
    topology = engine.rigid_joint_topology
    links = [_straight(link) for link in engine.links]
    frames = LinkFrames(topology, links)
    matrices = frames.assemble(
        engine.mechanism.linkage.motion(crank_angle, 0.0),
        [link.stiffness for link in links],
        RotationTerms.all_or_none(False),
    )
    clamped = [topology.index(clamp.link_end.link) for clamp in topology.clamps]
    turning = [frames.targets[number][-2:] for number in clamped]
    free = np.setdiff1d(np.arange(frames.size), turning)
    loose = bool(topology.welds or any(link.rigid for link in links))
    squares = [
        _lowest(k, m, loose)
        for k, m in zip(
            matrices.stiffness[:, free[:, None], free],
            matrices.mass[:, free[:, None], free],
            strict=True,
        )
    ]
    return float(np.sqrt(max(min(squares), 0.0)) / (2 * np.pi))


def _lowest(stiffness: FloatArray, mass: FloatArray, loose: bool) -> float:
    """Lowest eigenvalue; of a loose truss the lowest of what stretches."""
    if not loose:
        found = scipy.linalg.eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, 0])
        return float(found[0])
    found = scipy.linalg.eigh(stiffness, mass, eigvals_only=True)
    return float(found[found > _LOOSE * found[-1]][0])


def _straight(link: LinkModel) -> LinkModel:
    """A link that only stretches and turns: its last two coordinates move its ends across."""
    if link.rigid:
        return link
    axial = np.flatnonzero(link.is_axial)
    along = np.zeros((link.size, len(axial)))
    along[axial, np.arange(len(axial))] = 1.0
    at_end = link.fields.tangential / float(link.fields.centripetal[link.end[0]])
    basis = np.column_stack([along, link.fields.across - at_end, at_end])
    start, end = np.searchsorted(axial, [link.start[0], link.end[0]])
    places = {"start": np.array([start, len(axial)]), "end": np.array([end, len(axial) + 1])}
    return link.projected(basis, places)
