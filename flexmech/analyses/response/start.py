"""Where a run begins: straight, at rest under its loads, or on a periodic motion.

Where links that stretch begin: with the tension that linear equations give them.

Linear equations leave out half the square of the slopes, which runs count: at the displacements of
these a stiff link would have many times its tension, and would ring along itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from flexmech.analyses.response.motor_passes import MotorPasses
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import Prestress
from flexmech.dynamical_systems import VibrationState
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import Drive, Load, MotorRun, RigidMotion
from flexmech.mechanics import COORDINATES, Engine, LinkFrames, RotationTerms
from flexmech.mechanics.running import DrivenLinkage, FrameMotion, LinkState, static_balance
from flexmech.solvers import nonlinear_orbit, periodic_state, require_periodic_motion


def with_usual_start(engines: Sequence[Engine], request: ResponseRequest) -> ResponseRequest:
    """The request with the start of its run, where none is asked for.

    How a linkage moves once it runs is asked for most: at constant speed that is the periodic
    motion. Where no motion repeats itself every turn the links start undeformed.

    Parameters
    ----------
    engines : sequence of Engine
        All of one mechanism.
    request : ResponseRequest

    Returns
    -------
    ResponseRequest
    """
    if request.start is not None:
        return request
    drive = request.drive
    repeats = drive.is_constant and drive.speed != 0
    if not repeats or any(engine.shaft == "free" for engine in engines):
        return replace(request, start="rigid")
    try:
        require_periodic_motion(engines[0])
    except InputError:
        return replace(request, start="rigid")
    return replace(request, start="periodic")


@contextmanager
def or_a_start_up(asked: ResponseRequest, request: ResponseRequest) -> Iterator[None]:
    """Name the other start where the periodic motion fails that nobody has asked for.

    Parameters
    ----------
    asked : ResponseRequest
    request : ResponseRequest
        The same, with the start of its run.

    Raises
    ------
    ComputationError
    """
    try:
        yield
    except ComputationError as error:
        if asked.start is not None or request.start != "periodic":
            raise
        remedy = "; start rigid runs a start-up in place of the periodic motion"
        raise ComputationError(error.message + remedy, crank_speed=error.crank_speed) from error


# Each leaves of the stretch about the part by which the links have turned.
_PASSES = 4


# Internal forces (B, n_link) of nonlinear links at displacements (B, n_link).
Forces = Callable[[list[FloatArray]], Sequence[FloatArray]]


def without_second_order_stretch(
    frames: LinkFrames,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    expected: Sequence[FloatArray],
    internal_forces: Forces,
    held: Sequence[int] | IntArray = (),
) -> list[FloatArray]:
    """Displacements at which nonlinear links have the tension that linear ones have.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the links, reduced or not.
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Displacement of each link in its frame, by the linear equations.
    expected : sequence of ndarray, shape (B, n_link)
        Internal forces by the linear equations: :func:`linear_forces`.
    internal_forces : callable
    held : sequence of int
        Coordinates of the frames that stay: that of a free shaft.

    Returns
    -------
    list of ndarray, shape (B, n_link)
    """
    straight = [link.stiffness for link in frames.links]
    stiffness = frames.assemble(motion, straight, RotationTerms.all_or_none(False)).stiffness
    free = np.setdiff1d(np.arange(stiffness.shape[-1]), held)
    of_free = stiffness[..., free[:, None], free]
    taken_back = list(displacement)
    for _ in range(_PASSES):
        found = internal_forces(taken_back)
        stretching = [
            np.where(link.is_axial, force - linear, 0.0)
            for link, force, linear in zip(frames.links, found, expected, strict=True)
        ]
        gathered = frames.gather(motion, stretching)
        step = np.zeros((*gathered.shape, 1))
        step[:, free] = np.linalg.solve(of_free, gathered[:, free, None])
        moved = frames.link_coordinates(motion, step)
        taken_back = [q - by[..., 0] for q, by in zip(taken_back, moved, strict=True)]
    return taken_back


def linear_forces(
    engine: Engine,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    prestress: Prestress,
) -> list[FloatArray]:
    """Internal force of each link by its tangent in the state that it is linear about.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Displacement of each link in its frame.
    prestress : {"none", "axial", "equilibrium"}
        What the equations are linear about.

    Returns
    -------
    list of ndarray, shape (B, n_link)

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    """
    state = engine.stressed_links(motion, prestress)
    forces = [np.zeros_like(q) for q in displacement]
    beyond = list(displacement)
    if state.displacement is not None:
        assert state.internal_force is not None
        forces = state.internal_force
        beyond = [q - at for q, at in zip(displacement, state.displacement, strict=True)]
    return [
        force + (tangent @ change[..., None])[..., 0]
        for force, tangent, change in zip(forces, state.tangent, beyond, strict=True)
    ]


# Time over which a quasi-static start differentiates its displacement, in turns: the difference is
# of second order, so that its error is 1e-8 and its round-off 1e-11 over the displacement.
_START_INTERVAL = 1e-4
# A quarter of a degree: a periodic start is wanted more precisely than the run that follows.
_LEAST_STEPS_OF_A_TURN = 1440


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
        return replace(
            _equilibrium(engine, request.drive), frame=frame_at_rest(engine, request.drive)
        )
    return _on_periodic_motion(engine, request, step)


def _has_nonlinear_orbit(request: ResponseRequest) -> bool:
    """Whether the periodic motion of the nonlinear equations is found.

    Those of a motor and of other prestress are the linear equations'.
    """
    return request.prestress == "equilibrium" and not isinstance(request.drive, MotorRun)


@dataclass(frozen=True)
class _PeriodicMotion:
    """The periodic motion of the linear equations at the times of a start.

    Parameters
    ----------
    engine : Engine
        With a prescribed shaft.
    time : ndarray, shape (3,)
    motion : RigidMotion
    displacement : list of ndarray, shape (3, n_link)
        Displacement of the engine's links.
    rate : list of ndarray, shape (n_link,)
        At the first of the times.
    frame : list of FrameMotion or None
        Frame of a frame on springs at each time, arrays of shape (1, 3).
    """

    engine: Engine
    time: FloatArray
    motion: RigidMotion
    displacement: list[FloatArray]
    rate: list[FloatArray]
    frame: list[FrameMotion | None]

    @classmethod
    def of(cls, engine: Engine, request: ResponseRequest, step: float) -> _PeriodicMotion:
        """Find it, and its motion for a moment; a motor turns the shaft as its run says."""
        if isinstance(request.drive, MotorRun):
            engine = engine.with_(shaft="prescribed")
        linkage = DrivenLinkage(engine, request.drive, request.prestress, modes=request.modes)
        first = periodic_state(linkage, _steps_of_a_turn(request, step))
        time = _start_times(request.drive)
        after = time[:, None]
        near = VibrationState(
            first.position + after * first.velocity + after**2 / 2 * first.acceleration,
            first.velocity + after * first.acceleration,
            np.tile(first.acceleration, (len(time), 1)),
        )
        links = list(
            zip(linkage.bases, linkage.link_motion(linkage.equations(time), near), strict=True)
        )
        return cls(
            engine,
            time,
            linkage.motion(time),
            [q @ basis.T for basis, (q, _, _) in links],
            [basis @ rate[0] for basis, (_, rate, _) in links],
            [linkage.frame_motion(near[number : number + 1]) for number in range(len(time))],
        )

    def state(self, number: int) -> LinkState:
        """State of the engine's links at one of the times, with the rates at the first."""
        return LinkState([q[number] for q in self.displacement], self.rate, self.frame[number])


def _on_periodic_motion(engine: Engine, request: ResponseRequest, step: float) -> LinkState:
    """On the periodic motion at time zero.

    A simulation counts the stretch by the square of the slopes, which linear equations leave out.
    """
    if _has_nonlinear_orbit(request):
        return nonlinear_orbit(engine, request.drive.speed).state(request.drive.start_angle)
    linear = _PeriodicMotion.of(engine, request, step)
    time, motion, was = linear.time, linear.motion, linear.displacement
    engine = linear.engine
    placed = without_second_order_stretch(
        LinkFrames(engine.rigid_joint_topology, engine.links),
        motion,
        was,
        linear_forces(engine, motion, was, request.prestress),
        partial(engine.internal_forces, motion),
    )
    moved = [q - before for q, before in zip(placed, was, strict=True)]
    return LinkState(
        displacement=[q[0] for q in placed],
        rate=[v + _rate(q, time) for v, q in zip(linear.rate, moved, strict=True)],
        frame=linear.frame[0],
    )


def frame_at_rest(engine: Engine, drive: Drive, begin: float = 0.0) -> FrameMotion | None:
    """Quasi-static displacement of a frame on springs at a time, and how fast it changes.

    Parameters
    ----------
    engine : Engine
    drive : Drive
    begin : float
        That time in s.

    Returns
    -------
    FrameMotion or None
        Arrays of shape (1, 3); None where the frame stands.
    """
    if engine.mechanism.frame is None:
        return None
    time, torque = begin + _start_times(drive), None
    if engine.shaft == "free" and isinstance(drive, MotorRun):
        torque = MotorPasses(drive).torque_along(time)
    linkage = DrivenLinkage(engine, drive, "equilibrium", shaft_torque=torque)
    place = linkage.quasi_static_equations(time).quasi_static(
        constrained=linkage.shaft_coordinates
    )[:, -COORDINATES:]
    return FrameMotion(place[:1], _rate(place, time)[None])


def _equilibrium(engine: Engine, drive: Drive) -> LinkState:
    """Nonlinear quasi-static equilibrium at time zero, and how fast the loads move it."""
    time = _start_times(drive)
    displacement = equilibria_at(engine, drive, time)
    if displacement is None:
        return LinkState.rigid(engine.links)
    return LinkState(
        displacement=[q[0] for q in displacement],
        rate=[_rate(q, time) for q in displacement],
    )


def equilibria_at(engine: Engine, drive: Drive, time: FloatArray) -> list[FloatArray] | None:
    """Nonlinear quasi-static equilibria at some times.

    Loads over time act with what they are at these times: an engine's own equilibria are those
    of crank angles, at which such loads have no value.

    Parameters
    ----------
    engine : Engine
    drive : Drive
    time : ndarray, shape (m,)
        In s.

    Returns
    -------
    list of ndarray, shape (m, n_link), or None
        Of each link; None where links stay straight.

    Raises
    ------
    ComputationError
        If there is none.
    """
    mechanism = engine.mechanism
    if all(load.over != "time" for load in mechanism.loads):
        motion = drive.motion(mechanism.linkage, time)
        return engine.stressed_links(motion, "equilibrium").displacement
    found = []
    for instant in time:
        loads = tuple(_as_it_is_at(load, float(instant)) for load in mechanism.loads)
        motion = drive.motion(mechanism.linkage, np.array([instant]))
        loaded = engine.with_(mechanism=replace(mechanism, loads=loads))
        one = loaded.stressed_links(motion, "equilibrium").displacement
        if one is None:
            return None
        found.append(one)
    return [np.concatenate(of_link) for of_link in zip(*found, strict=True)]


def _as_it_is_at(load: Load, time: float) -> Load:
    """A load over time as the constant load that it is at a time; others as they are."""
    if load.over != "time":
        return load
    x, y, torque = load.values(0.0, time).tolist()
    return replace(load, force=((x, y),), torque=(torque,), over="constant", at=())


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
        if linkage.shaft is not None:
            first = _PeriodicMotion.of(linkage.engine, request, step).state(0)
            return VibrationState(*linkage.coordinates(first), nothing)
        return periodic_state(linkage, _steps_of_a_turn(request, step))
    time = _start_times(request.drive)
    position = linkage.quasi_static_equations(time).quasi_static(
        constrained=linkage.shaft_coordinates
    )
    return VibrationState(position[0], _rate(position, time), nothing)


def _stretching_start(
    linkage: DrivenLinkage, request: ResponseRequest, step: float
) -> VibrationState:
    """Start of links that stretch, in their own balance along their axes.

    The linear equations and the equilibrium of corotational beams put link ends where they
    are but for the fourth order of the slopes; the tension of a link would feel that.
    """
    if request.start == "periodic":
        return _stretching_on_periodic_motion(linkage, request, step)
    position, _ = linkage.coordinates(_equilibrium(linkage.engine, request.drive))
    time = _start_times(request.drive)
    still = np.stack([static_balance(linkage, position, float(t)) for t in time])
    return VibrationState(still[0], _rate(still, time), np.zeros_like(position))


def _stretching_on_periodic_motion(
    linkage: DrivenLinkage, request: ResponseRequest, step: float
) -> VibrationState:
    """The same of links that stretch as the linkage says."""
    assert linkage.stretch is not None
    frames, time = linkage.frames, _start_times(request.drive)
    if _has_nonlinear_orbit(request):
        engine, motion = linkage.engine, linkage.motion(time)
        orbit = nonlinear_orbit(engine, request.drive.speed)
        forces = engine.internal_forces(motion, orbit.at(motion.crank_angle)[0])
        starts = [orbit.state(angle) for angle in motion.crank_angle.tolist()]
    else:
        linear = _PeriodicMotion.of(linkage.engine, request, step)
        motion, starts = linear.motion, [linear.state(number) for number in range(len(time))]
        forces = linear_forces(linear.engine, motion, linear.displacement, request.prestress)
    links = list(zip(frames.links, linkage.stretch.links, strict=True))

    def internal_forces(displacement: list[FloatArray]) -> list[FloatArray]:
        return [
            p @ link.stiffness + stretch.nonlinear_forces(p, np.zeros_like(p))[0]
            for (link, stretch), p in zip(links, displacement, strict=True)
        ]

    states = [linkage.coordinates(*pair) for pair in zip(starts, time.tolist(), strict=True)]
    position = np.stack([z for z, _ in states])
    was = [p[..., 0] for p in frames.link_coordinates(motion, position[..., None])]
    expected = [force @ basis for force, basis in zip(forces, linkage.bases, strict=True)]
    shaft = linkage.shaft
    held = () if shaft is None else np.flatnonzero(shaft.coordinate)
    placed = without_second_order_stretch(frames, motion, was, expected, internal_forces, held)
    moved = [(p - before)[..., None] for p, before in zip(placed, was, strict=True)]
    taken_back = np.zeros_like(position)
    taken_back[:, : frames.size] = frames.independent(motion, moved)[..., 0]
    velocity = states[0][1] + _rate(taken_back, time)
    return VibrationState(position[0] + taken_back[0], velocity, np.zeros_like(velocity))


def _start_times(drive: Drive) -> FloatArray:
    # A locked crank has no cycle, and stands at all times alike.
    cycle = drive.cycle_time if np.isfinite(drive.cycle_time) else 1.0
    return np.asarray(_START_INTERVAL * cycle * np.arange(3.0), dtype=float)


def _rate(position: FloatArray, time: FloatArray) -> FloatArray:
    """Time derivative at the first of three evenly spaced times, of second order."""
    first, second, third = position
    return np.asarray((-3 * first + 4 * second - third) / (2 * (time[1] - time[0])))


def _steps_of_a_turn(request: ResponseRequest, step: float) -> int:
    return max(_LEAST_STEPS_OF_A_TURN, round(request.drive.revolution_time / step))
