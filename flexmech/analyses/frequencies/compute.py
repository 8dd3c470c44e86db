"""Moving natural frequencies: how they change with crank angle and crank speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.analyses.environment import environment_lines
from flexmech.analyses.frequencies.dataset import EngineMap, SpeedMap, build_dataset, with_states
from flexmech.analyses.frequencies.discretisation import check_angle_indices, discretisation_error
from flexmech.analyses.frequencies.eigenproblem import Modes, solve_modes
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.frequency_map import frequency_map, systems_at
from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping
from flexmech.analyses.frequencies.reduction import settled
from flexmech.analyses.frequencies.request import FrequencyRequest, operating_speeds
from flexmech.analyses.frequencies.result import MovingFrequencies
from flexmech.analyses.frequencies.speed_effect import speed_effect_terms
from flexmech.analyses.frequencies.tracking import Tracker, same_shapes
from flexmech.analyses.requests import engines_of
from flexmech.choices import MODES, MapPrestress
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import Engine
from flexmech.threads import one_thread
from flexmech.types import FloatArray, IntArray, LabelledProgress

__all__ = ["moving_frequencies"]

# Modes followed besides those asked for, so that a branch may dip out and come back.
SPARE_MODES = 2


def moving_frequencies(
    engine: Engine | Sequence[Engine],
    crank_angles: ArrayLike,
    crank_speeds: ArrayLike | None = None,
    *,
    modes: int = MODES,
    prestress: MapPrestress = "equilibrium",
    rotation_terms: bool = True,
    speed_effect: bool = False,
    environment: Environment | None = None,
    speed_unit: str = "rad/s",
    progress: LabelledProgress | None = None,
) -> MovingFrequencies:
    """Tracked natural frequencies over crank angles and speeds, with their errors.

    Parameters
    ----------
    engine : Engine or sequence of Engine
        Several engines give results side by side.
    crank_angles : array_like, shape (A,)
        Increasing, rad.
    crank_speeds : array_like, shape (S,), optional
        rad/s. Left out: zero and the speeds at which the mechanism operates; 0, 10 and 20 if it
        names none.
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
        Also split the effect of speed by term, with the first engine; not of links that bend
        without load, which have no unstressed state to begin with.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture: the mechanism is computed in them and dry.
    speed_unit : str
        In which the result speaks of crank speeds, such as ``"rpm"``.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    MovingFrequencies
        With an environment over ``state`` too, of which there are two: dry, and the environment's.

    Raises
    ------
    InputError
        If the request makes no sense or the linkage cannot reach a crank angle.
    ComputationError
        If an equilibrium does not converge or a mode does not oscillate.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> result = flexmech.moving_frequencies(engine, np.radians([0, 60, 120]), [0, 20])
    >>> result.dataset["frequency"].shape
    (1, 2, 3, 4)
    """
    engines = engines_of(engine)
    formulation = Formulation(prestress, rotation_terms, modes)
    if crank_speeds is None:
        crank_speeds = operating_speeds(engines[0].mechanism)
    request = FrequencyRequest(crank_angles, crank_speeds, formulation, speed_effect, speed_unit)
    if prestress == "trajectory" and not any(each.simulates for each in engines):
        names = " and ".join(each.name for each in engines)
        raise InputError(
            f"prestress 'trajectory' needs an engine that simulates the running linkage, and "
            f"{names} does not: use the exudyn engine, or prestress 'equilibrium'"
        )
    report = progress or (lambda label, done, total: None)
    if environment is None:
        return MovingFrequencies(_in_one_state(engines, request, report))
    mechanism = engines[0].mechanism
    exposed = [
        each.with_(mechanism=mechanism_in_state(each.mechanism, environment)) for each in engines
    ]
    # The same elements in both states: only heat and moisture shall make a difference.
    dry = [
        each.with_(mechanism=mechanism, element=one.element)
        for each, one in zip(engines, exposed, strict=True)
    ]
    found = _in_one_state(exposed, request, report)
    return MovingFrequencies(
        with_states(
            {"dry": _in_one_state(dry, request, report), environment.label: found},
            environment_lines(mechanism, environment),
        )
    )


def _in_one_state(
    engines: Sequence[Engine], request: FrequencyRequest, report: LabelledProgress
) -> Any:
    """Dataset of engines on one mechanism."""
    with one_thread():
        maps = [_map_engine(each, _request_of(each, request), report) for each in engines]
        quasi_static = None
        if request.formulation.prestress == "trajectory":
            quasi_static = np.stack([_quasi_static(each, request) for each in maps])
        terms = None
        if request.splits_speed and not engines[0].mechanism.is_free_strained:
            terms = speed_effect_terms(maps[0].engine, request, maps[0].detail, report)
    return build_dataset(engines, request, maps, terms, quasi_static)


def _request_of(engine: Engine, request: FrequencyRequest) -> FrequencyRequest:
    """What an engine is asked: those that do not simulate have no trajectory."""
    if engine.simulates:
        return request
    return replace(request, formulation=request.formulation.quasi_static)


def _quasi_static(of: EngineMap, request: FrequencyRequest) -> FloatArray:
    """Frequencies at the quasi-static equilibrium next to those of an engine, (S, A, modes)."""
    still = replace(request, formulation=request.formulation.quasi_static)
    if of.engine.simulates:
        return frequency_map(of.engine, still, of.detail)
    return np.stack([s.frequency[:, : request.formulation.modes] for s in of.speeds])


def _map_engine(engine: Engine, request: FrequencyRequest, report: LabelledProgress) -> EngineMap:
    """Map of one engine, speed by speed; a speed begins with the branches of the one before."""
    where = check_angle_indices(request.crank_angles, request.full_turn)
    losses = StrainEnergyDamping.of(engine)
    total = len(request.crank_speeds) * len(request.crank_angles)
    numbering: IntArray | None = None
    start_shapes: NDArray[Any] | None = None
    speeds: list[SpeedMap] = []
    finest = Systems(engine, request.formulation)
    for number, speed in enumerate(request.crank_speeds.tolist()):
        checked = settled(
            systems_at(engine, request, speed), request.crank_angles[where], speed, SPARE_MODES
        )
        systems = checked.systems
        if systems.detail > finest.detail or not systems.engine.component_modes:
            finest = systems
        shapes = checked.system.displacements(checked.modes.vectors)
        if start_shapes is not None:
            numbering = same_shapes(start_shapes, shapes[0], numbering)
        start_shapes = shapes[0]
        tracker, done = Tracker(numbering), number * len(request.crank_angles)
        parts = []
        for modes, ratio in _follow(
            systems, request.crank_angles, speed, checked.modes.count, losses, tracker
        ):
            parts.append((modes.frequency, modes.damping_ratio, ratio))
            done += len(ratio)
            report(engine.name, done, total)
        frequency, damping, by_strain_energy = map(np.concatenate, zip(*parts, strict=True))
        speeds.append(
            SpeedMap(
                frequency=frequency,
                damping_ratio=damping,
                strain_energy_damping=by_strain_energy if losses else None,
                branches=tracker.finish(frequency, request.full_turn),
                mode_shape=shapes[:, : request.formulation.modes],
                reduction_error=checked.reduction_error,
                discretisation_error=discretisation_error(
                    systems, request.crank_angles[where], speed
                ),
            )
        )
    return EngineMap(finest.engine, finest.detail, where, speeds)


def _follow(
    systems: Systems,
    crank_angles: FloatArray,
    crank_speed: float,
    count: int,
    losses: StrainEnergyDamping | None,
    tracker: Tracker,
) -> Iterator[tuple[Modes, FloatArray]]:
    """Modes along the crank angles, batch by batch, and what their strain energy loses."""
    for system in systems.batches(crank_angles, crank_speed):
        modes = solve_modes(system, count)
        tracker.add(system.inertial_shapes(modes.vectors))
        ratio = np.zeros_like(modes.frequency)
        if losses is not None:
            states = systems.states(system.motion.crank_angle)
            prestress = systems.formulation.quasi_static_prestress
            ratio = losses.ratio(system, modes, prestress, states)
        yield modes, ratio
