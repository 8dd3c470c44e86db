"""Moving natural frequencies: how they change with crank angle and crank speed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.analyses.dataset import EngineMap, SpeedMap, build_dataset
from flexmech.analyses.discretisation import check_angle_indices, discretisation_error
from flexmech.analyses.eigenproblem import Modes, solve_frequencies, solve_modes
from flexmech.analyses.mapping import FrequencyRequest, Mapping, MapPrestress
from flexmech.analyses.modal_damping import StrainEnergyDamping
from flexmech.analyses.reduction import accurate_reduction
from flexmech.analyses.result import MovingFrequencies
from flexmech.analyses.running_states import RunningStates
from flexmech.analyses.speed_effect import speed_effect_terms
from flexmech.analyses.tracking import Tracker, same_shapes
from flexmech.errors import InputError
from flexmech.linear_system import Engine, LinearSystem, Prestress
from flexmech.threads import one_thread
from flexmech.time_domain import Simulator
from flexmech.types import FloatArray, IntArray, LabelledProgress

__all__ = ["frequency_map", "moving_frequencies", "natural_frequencies"]


def natural_frequencies(
    engine: Engine,
    crank_angle: ArrayLike,
    crank_speed: ArrayLike = 0.0,
    *,
    modes: int = 4,
    prestress: Prestress = "equilibrium",
    rotation_terms: bool = True,
) -> FloatArray:
    """Natural frequencies at given positions.

    Parameters
    ----------
    engine : Engine
    crank_angle, crank_speed : array_like
        rad and rad/s; broadcast against each other to shape (...).
    modes : int
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool

    Returns
    -------
    ndarray, shape (..., modes)
        In Hz, ascending.

    Raises
    ------
    InputError, ComputationError
        See :meth:`flexmech.linear_system.Engine.linear_system` and
        :func:`flexmech.analyses.solve_modes`.
    """
    angle, speed = np.broadcast_arrays(
        np.asarray(crank_angle, dtype=float), np.asarray(crank_speed, dtype=float)
    )
    motion = engine.mechanism.linkage.motion(angle, speed)

    def system(engine: Engine, detail: float, which: IntArray) -> LinearSystem:
        return engine.linear_system(
            angle.ravel()[which],
            speed.ravel()[which],
            prestress=prestress,
            rotation_terms=rotation_terms,
            modes=modes,
            fastest=float(np.abs(motion.angular_velocity).max(initial=0.0)),
            detail=detail,
        )

    every = np.arange(angle.size)
    some = check_angle_indices(every.astype(float), full_turn=False)
    with one_thread():
        checked = accurate_reduction(
            engine, lambda engine, detail: system(engine, detail, some), modes
        )
        if len(some) == len(every):
            return checked.modes.frequency.reshape(*angle.shape, modes)
        size = checked.engine.batch_size
        parts = [
            solve_frequencies(
                system(checked.engine, checked.detail, every[start : start + size]), modes
            )
            for start in range(0, len(every), size)
        ]
        return np.concatenate(parts).reshape(*angle.shape, modes)


def frequency_map(engine: Engine, request: FrequencyRequest, detail: float = 1.0) -> FloatArray:
    """Natural frequencies of a map without tracking or error estimates.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    detail : float
        How many component modes to take.

    Returns
    -------
    ndarray, shape (S, A, modes)
        In Hz, ascending.
    """
    mapping = Mapping(engine, request, detail)

    def along_angles(speed: float) -> FloatArray:
        batches = mapping.systems(speed)
        return np.concatenate([solve_frequencies(s, request.modes) for s in batches])

    with one_thread():
        return np.stack([along_angles(float(speed)) for speed in request.crank_speeds])


def moving_frequencies(
    engine: Engine | Sequence[Engine],
    crank_angles: ArrayLike,
    crank_speeds: ArrayLike,
    *,
    modes: int = 4,
    prestress: MapPrestress = "equilibrium",
    rotation_terms: bool = True,
    speed_effect: bool = False,
    progress: LabelledProgress | None = None,
) -> MovingFrequencies:
    """Tracked natural frequencies over crank angles and speeds, with their errors.

    Parameters
    ----------
    engine : Engine or sequence of Engine
        Several engines give results side by side.
    crank_angles : array_like, shape (A,)
        Increasing, rad.
    crank_speeds : array_like, shape (S,)
        rad/s.
    modes : int
        Number of natural frequencies.
    prestress : {"none", "axial", "equilibrium", "trajectory"}
        With ``trajectory`` engines that simulate are linearized in the states of their
        settled motion, and the result holds the quasi-static frequencies besides; other
        engines give the quasi-static ones alone.
    rotation_terms : bool
        Terms of the turning link frames; off gives the frozen inertial form. With them,
        frozen eigenvalues depend on the frame in which they are written (Floquet
        multipliers do not): here each link's own.
    speed_effect : bool
        Also split the effect of speed by term, with the first engine.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    MovingFrequencies

    Raises
    ------
    InputError
        If the request makes no sense or the linkage cannot reach a crank angle.
    ComputationError
        If an equilibrium does not converge or a mode does not oscillate.
    """
    engines = [engine] if isinstance(engine, Engine) else list(engine)
    if not engines:
        raise InputError("moving_frequencies needs an engine, got an empty list")
    request = FrequencyRequest(
        np.asarray(crank_angles, dtype=float),
        np.asarray(crank_speeds, dtype=float),
        modes,
        prestress,
        rotation_terms,
    )
    report = progress or (lambda label, done, total: None)
    with one_thread():
        if prestress == "trajectory" and not any(isinstance(e, Simulator) for e in engines):
            RunningStates.of(engines[0], 1.0)  # says which engine it needs
        requests = [_request_of(each, request) for each in engines]
        maps = [_map_engine(e, r, report) for e, r in zip(engines, requests, strict=True)]
        quasi_static = _quasi_static(maps, requests) if prestress == "trajectory" else None
        terms = (
            speed_effect_terms(_effect_map(maps[0]), maps[0].engine, request, report)
            if speed_effect
            else None
        )
    return MovingFrequencies(build_dataset(engines, request, maps, terms, quasi_static))


def _request_of(engine: Engine, request: FrequencyRequest) -> FrequencyRequest:
    """What an engine is asked: those that do not simulate have no trajectory."""
    if isinstance(engine, Simulator):
        return request
    return replace(request, prestress=request.quasi_static_prestress)


def _quasi_static(maps: Sequence[EngineMap], requests: Sequence[FrequencyRequest]) -> FloatArray:
    """Frequencies at the quasi-static equilibrium next to those asked for, (E, S, A, modes)."""
    parts = []
    for each, request in zip(maps, requests, strict=True):
        if request.prestress == "trajectory":
            still = replace(request, prestress=request.quasi_static_prestress)
            parts.append(frequency_map(each.engine, still, each.detail))
        else:
            parts.append(np.stack([s.frequency[:, : request.modes] for s in each.speeds]))
    return np.stack(parts)


def _effect_map(of: EngineMap) -> Callable[[Engine, FrequencyRequest], FloatArray]:
    """Frequency map with as many component modes as an earlier map has needed."""
    return lambda engine, request: frequency_map(engine, request, of.detail)


def _map_engine(engine: Engine, request: FrequencyRequest, report: LabelledProgress) -> EngineMap:
    where = check_angle_indices(request.crank_angles, request.full_turn)
    total = len(request.crank_speeds) * len(request.crank_angles)
    numbering: IntArray | None = None
    start_shapes: NDArray[Any] | None = None
    speeds: list[SpeedMap] = []
    finest = Mapping(engine, request)
    losses = StrainEnergyDamping.of(engine)
    done = 0
    for speed in request.crank_speeds.tolist():
        mapping = Mapping(engine, request)
        checked = mapping.check(speed, where)
        if mapping.detail > finest.detail or not mapping.engine.component_modes:
            finest = mapping
        shapes = checked.system.displacements(checked.modes.vectors)
        if start_shapes is not None:
            numbering = same_shapes(start_shapes, shapes[0], numbering)
        start_shapes = shapes[0]
        tracker = Tracker(numbering)
        along = _follow(mapping, speed, checked.modes.frequency.shape[1], losses, tracker)
        frequency, damping, by_strain_energy = [], [], []
        for modes, energy_ratio in along:
            frequency.append(modes.frequency)
            damping.append(modes.damping_ratio)
            by_strain_energy.append(energy_ratio)
            done += len(modes.frequency)
            report(engine.name, done, total)
        every = np.concatenate(frequency)
        speeds.append(
            SpeedMap(
                frequency=every,
                damping_ratio=np.concatenate(damping),
                strain_energy_damping=np.concatenate(by_strain_energy) if losses else None,
                branches=tracker.finish(every, request.full_turn),
                mode_shape=shapes[:, : request.modes],
                reduction_error=checked.reduction_error,
                discretisation_error=discretisation_error(
                    mapping.engine,
                    request.crank_angles[where],
                    speed,
                    modes=request.modes,
                    prestress=request.quasi_static_prestress,
                    rotation_terms=request.rotation_terms,
                    detail=mapping.detail,
                ),
            )
        )
    return EngineMap(engine=finest.engine, detail=finest.detail, check_angles=where, speeds=speeds)


def _follow(
    mapping: Mapping,
    speed: float,
    count: int,
    losses: StrainEnergyDamping | None,
    tracker: Tracker,
) -> Iterator[tuple[Modes, FloatArray]]:
    """Modes along the crank angles, batch by batch, and what their strain energy loses."""
    for system in mapping.systems(speed):
        modes = solve_modes(system, count)
        tracker.add(system.inertial_shapes(modes.vectors))
        ratio = np.zeros_like(modes.frequency)
        if losses is not None:
            states = mapping.states(system.motion.crank_angle, speed)
            ratio = losses.ratio(system, modes, mapping.request.quasi_static_prestress, states)
        yield modes, ratio
