"""Natural frequencies and damping ratios at given positions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.analyses.frequencies.discretisation import check_angle_indices
from flexmech.analyses.frequencies.extremes import Extremes, extremes_between
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping
from flexmech.analyses.requests import as_many_modes, engine_of, in_radians
from flexmech.arrays import FloatArray
from flexmech.choices import PRESTRESS_LEVELS, Prestress
from flexmech.errors import InputError
from flexmech.mechanics import Engine, RotationTerms
from flexmech.mechanism import Mechanism
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.solvers.reduction import converged_along, converged_modes
from flexmech.threads import one_thread
from flexmech.validation import check_choice, checked_array

# Relative error of an extreme between crank angles; it is refined to a tenth of this.
EXTREMES_WITHIN = 1e-5


def natural_frequencies(
    engine: Engine | Mechanism,
    crank_angle: ArrayLike,
    crank_speed: ArrayLike = 0.0,
    *,
    modes: int | None = None,
    prestress: Prestress = "equilibrium",
    rotation_terms: bool | RotationTerms = True,
) -> FloatArray:
    """Natural frequencies at given positions.

    Parameters
    ----------
    engine : Engine or Mechanism
        A mechanism gets the reference engine.
    crank_angle, crank_speed : array_like
        rad and rad/s; broadcast against each other to shape (...).
    modes : int, optional
        Left out: 4, or as many as the model has and as oscillate at all positions.
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool or RotationTerms

    Returns
    -------
    ndarray, shape (..., modes)
        In Hz, ascending.

    Raises
    ------
    InputError, ComputationError
        See :meth:`flexmech.mechanics.Engine.linear_system` and
        :func:`flexmech.solvers.solve_modes`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism)
    >>> flexmech.natural_frequencies(engine, 0.0, modes=2).round(2)
    array([44.31, 48.08])
    """
    check_choice(prestress, PRESTRESS_LEVELS, "prestress")
    engine = engine_of(engine)
    angle = in_radians("crank_angle", crank_angle)
    speed = checked_array(crank_speed, "crank_speed", "rad/s")

    def compute(count: int) -> FloatArray:
        formulation = Formulation(prestress, rotation_terms, count)
        return frequencies_at(engine.fit_for(count), angle, speed, formulation)

    return as_many_modes(compute, modes)[0]


def frequencies_at(
    engine: Engine, crank_angle: ArrayLike, crank_speed: ArrayLike, formulation: Formulation
) -> FloatArray:
    """Natural frequencies at positions that may be any number of turns apart.

    Parameters
    ----------
    engine : Engine
    crank_angle, crank_speed : array_like
        rad and rad/s; broadcast against each other to shape (...).
    formulation : Formulation

    Returns
    -------
    ndarray, shape (..., modes)
        In Hz, ascending.
    """
    angle, speed, systems = _systems(engine, crank_angle, crank_speed, formulation)
    if not angle.size:
        raise InputError("crank_angle is empty; give one crank angle or more")
    found, _ = _along(systems, angle.ravel(), speed.ravel())
    return found.reshape(*angle.shape, formulation.modes)


def _along(systems: Systems, angle: FloatArray, speed: FloatArray) -> tuple[FloatArray, Systems]:
    """Frequencies (B, modes) at positions, and the systems with as many modes as they need."""
    checks = check_angle_indices(np.arange(angle.size, dtype=float), full_turn=False)
    rest = np.setdiff1d(np.arange(angle.size), checks)
    with one_thread():
        # The stress is the same in whatever modes: it is sought once in the first batch, and in
        # the positions to check along with it.
        first = rest[systems.engine.batches(rest.size)[0]]
        known = np.union1d(first, checks)
        stressed = systems.stressed(angle[known], speed[known])
        there = stressed.at(np.searchsorted(known, checks))
        checked = converged_along(systems, angle, speed, checks, stressed=there)
        found = np.empty((angle.size, checked.modes.count))
        found[checks] = checked.modes.frequency
        if rest.size:
            own = stressed.at(np.searchsorted(known, first))
            found[rest] = frequencies_along(checked.systems, angle[rest], speed[rest], own)
    return found, checked.systems


def frequency_extremes(
    engine: Engine,
    crank_angles: FloatArray,
    crank_speed: float,
    *,
    modes: int,
    prestress: Prestress = "equilibrium",
    wanted: NDArray[np.bool_] | None = None,
) -> Extremes:
    """Lowest and highest natural frequencies over a turn, found between the crank angles.

    Parameters
    ----------
    engine : Engine
    crank_angles : ndarray, shape (A,)
        Evenly spaced over a turn in rad, without its end.
    crank_speed : float
        In rad/s.
    modes : int
    prestress : {"none", "axial", "equilibrium"}
    wanted : ndarray of bool, shape (2, modes), optional
        Which lowest and highest frequencies are sought between the angles; all by default.

    Returns
    -------
    Extremes
        Arrays of shape (modes,), to a millionth of the frequency besides the errors of the model.

    Raises
    ------
    InputError, ComputationError
        As of :func:`natural_frequencies`.
    """
    formulation = Formulation(prestress, True, modes)
    angle, speed, systems = _systems(engine.fit_for(modes), crank_angles, crank_speed, formulation)
    found, systems = _along(systems, angle, speed)
    error = np.full(modes, EXTREMES_WITHIN)
    with one_thread():
        extremes = extremes_between(
            systems,
            crank_angles,
            np.array([crank_speed]),
            found[None],
            error,
            full_turn=True,
            wanted=wanted,
        )
    return extremes.of_speed(0)


def strain_energy_damping(
    engine: Engine | Mechanism,
    crank_angle: ArrayLike,
    crank_speed: ArrayLike = 0.0,
    *,
    modes: int | None = None,
    prestress: Prestress = "equilibrium",
    rotation_terms: bool | RotationTerms = True,
) -> FloatArray:
    """Damping ratios by modal strain energy at given positions.

    Parameters
    ----------
    engine : Engine or Mechanism
        A mechanism gets the reference engine.
    crank_angle, crank_speed : array_like
        rad and rad/s; broadcast against each other to shape (...).
    modes : int, optional
        Left out: 4, or as many as the model has and as oscillate at all positions.
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool or RotationTerms

    Returns
    -------
    ndarray, shape (..., modes)
        Damping ratios of the modes in ascending order of frequency.

    Raises
    ------
    InputError
        If no section of the mechanism has specific damping.
    InputError, ComputationError
        See :func:`flexmech.analyses.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism)
    >>> (100 * flexmech.strain_energy_damping(engine, 0.0, modes=2)).round(2)
    array([0.12, 0.1 ])
    """
    check_choice(prestress, PRESTRESS_LEVELS, "prestress")
    engine = engine_of(engine)
    angle = in_radians("crank_angle", crank_angle)
    speed = checked_array(crank_speed, "crank_speed", "rad/s")

    def compute(count: int) -> FloatArray:
        formulation = Formulation(prestress, rotation_terms, count)
        return _strain_energy_damping(engine.fit_for(count), angle, speed, formulation)

    return as_many_modes(compute, modes)[0]


def _strain_energy_damping(
    engine: Engine, crank_angle: FloatArray, crank_speed: FloatArray, formulation: Formulation
) -> FloatArray:
    loss = StrainEnergyDamping.of(engine)
    if loss is None:
        raise InputError(
            "no section of this mechanism has specific damping, which damping by strain energy "
            "needs: make the sections of plies whose loss is known, or set specific_damping"
        )
    angle, speed, systems = _systems(engine, crank_angle, crank_speed, formulation)
    level = formulation.quasi_static_prestress

    def in_batch(batch: slice) -> FloatArray:
        checked = converged_modes(systems, angle.ravel()[batch], speed.ravel()[batch])
        return loss.ratio(checked.system, checked.modes, level)

    with one_thread():
        parts = [in_batch(batch) for batch in engine.batches(angle.size)]
    return np.concatenate(parts).reshape(*angle.shape, formulation.modes)


def _systems(
    engine: Engine, crank_angle: ArrayLike, crank_speed: ArrayLike, formulation: Formulation
) -> tuple[FloatArray, FloatArray, Systems]:
    """Angles and speeds of one shape, and the systems of an engine there."""
    angle, speed = np.broadcast_arrays(
        np.asarray(crank_angle, dtype=float), np.asarray(crank_speed, dtype=float)
    )
    fastest = 0.0
    # At rest there are no rotation terms.
    if speed.any():
        fastest = engine.fastest(engine.mechanism.linkage.motion(angle.ravel(), speed.ravel()))
    return angle, speed, Systems(engine, formulation, fastest)
