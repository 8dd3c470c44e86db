"""Derivatives of natural frequencies by quantities of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.analyses.parameters import Parameters
from flexmech.analyses.requests import as_many_modes, engine_of, in_radians
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.errors import InputError
from flexmech.mechanics import Engine, LinearSystem, RotationTerms
from flexmech.mechanism import Mechanism
from flexmech.solvers.eigenproblem import solve_modes
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.threads import one_thread
from flexmech.validation import checked_array

# Relative change of a quantity over which matrices are differenced. Axial stiffnesses are so much
# greater than bending ones that the error of one step shows: two steps are extrapolated.
STEP = 1e-4
# Modes whose eigenvalues are nearer to each other, relatively, are one: any combination of them is
# a mode, and those of the changed linkage are found among the combinations.
REPEATED = 1e-9


def frequency_derivatives(
    engine: Engine | Mechanism,
    keys: Sequence[str],
    crank_angle: ArrayLike,
    crank_speed: ArrayLike = 0.0,
    *,
    modes: int | None = None,
    prestress: Prestress = "equilibrium",
    rotation_terms: bool | RotationTerms = True,
) -> FloatArray:
    """Derivatives of natural frequencies by quantities of the model file.

    By the left and right eigenvectors y and x of a mode,
    ``lambda' = -y^H (lambda^2 M' + lambda C' + K') x / (y^H (2 lambda M + C) x)`` (Adhikari,
    *Structural Dynamic Analysis with Generalized Damping Models*, 2014, sec. 1.3, for systems that
    are not symmetric). The derivatives of the matrices are extrapolated central differences of
    those of the changed linkage in its own state of stress, so that the equilibrium's derivative is
    in them.
    Repeated modes have the derivatives of their subspace, in ascending order.

    The lowest frequency over a turn has one derivative for an increase of the quantity and another
    for a decrease where its crank angle or mode changes: an optimizer should be given the
    frequencies at several crank angles.

    Parameters
    ----------
    engine : Engine or Mechanism
        A mechanism gets the reference engine.
    keys : sequence of str
        Keys of the model file, such as ``"links.coupler.in_plane_thickness"``, or
        ``"damping-ratio"``, ``"moisture"``, ``"temperature-rise"``.
    crank_angle, crank_speed : array_like
        rad and rad/s; broadcast against each other to shape (...).
    modes : int, optional
        Left out: 4, or as many as the model has and as oscillate at all positions.
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool or RotationTerms

    Returns
    -------
    ndarray, shape (len(keys), ..., modes)
        In Hz per SI unit of the quantity, without the error of component modes.

    Raises
    ------
    InputError
        If the model has no such quantity, or it is zero or infinite there, so that no step is small
        beside it.
    InputError, ComputationError
        See :func:`flexmech.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> (slope,) = flexmech.frequency_derivatives(
    ...     mechanism, ["links.coupler.in_plane_thickness"], 0.0, modes=2
    ... )
    >>> (1e-3 * slope).round(2)  # Hz per mm
    array([24.17,  2.5 ])
    """
    engine = engine_of(engine)
    # The element of the changed linkage is the same: another theory would make a jump.
    engine = engine.with_(element=engine.element).unreduced()
    angle, speed = np.broadcast_arrays(
        in_radians("crank_angle", crank_angle), checked_array(crank_speed, "crank_speed", "rad/s")
    )
    parameters = Parameters.of(engine.mechanism)
    values = [_value_of(parameters, key) for key in keys]

    def compute(count: int) -> FloatArray:
        formulation = Formulation(prestress, rotation_terms, count)
        at = angle.ravel(), speed.ravel()
        system = Systems(engine, formulation).at(*at)
        found = [
            _derivative(system, count, *_changed(parameters, engine, formulation, key, value, at))
            for key, value in zip(keys, values, strict=True)
        ]
        return np.stack(found)

    with one_thread():
        slopes = as_many_modes(compute, modes)[0]
    return slopes.reshape(len(keys), *angle.shape, slopes.shape[-1])


def _value_of(parameters: Parameters, key: str) -> float:
    """Value of a quantity in SI units, which must be finite and not zero."""
    value = parameters.value(key)
    if not value or math.isinf(value):
        size = "infinite" if value else "zero"
        raise InputError(f"{key} is {size} here; a derivative needs a value to change by a part of")
    return value


Position = tuple[FloatArray, FloatArray]
Matrices = tuple[FloatArray, FloatArray, FloatArray]


def _changed(
    parameters: Parameters,
    engine: Engine,
    formulation: Formulation,
    key: str,
    value: float,
    at_positions: Position,
) -> Matrices:
    """Derivatives of mass, damping and stiffness (B, n, n) by a quantity."""

    def at(factor: float) -> FloatArray:
        changed = parameters.engine_with(engine, {key: factor * value}).unreduced()
        system = Systems(changed, formulation).at(*at_positions)
        return np.stack([system.mass, system.damping, system.stiffness])

    def slope(part: float) -> FloatArray:
        return (at(1 + part) - at(1 - part)) / (2 * part * value)

    # Richardson's extrapolation.
    mass, damping, stiffness = (4 * slope(STEP) - slope(2 * STEP)) / 3
    return mass, damping, stiffness


def _derivative(
    system: LinearSystem, count: int, mass: FloatArray, damping: FloatArray, stiffness: FloatArray
) -> FloatArray:
    """Derivatives (B, count) of natural frequencies in Hz by those of the matrices."""
    modes = solve_modes(system, count)
    right: NDArray[Any] = modes.vectors
    eigenvalue = modes.eigenvalues
    left = right if system.is_conservative else _left_vectors(system, eigenvalue, right)
    # (B, count, count): of one mode, or of the subspace of repeated ones.
    square = np.square(eigenvalue)[:, None, :]
    change = _between(left, stiffness, right) + square * _between(left, mass, right)
    change = change + eigenvalue[:, None, :] * _between(left, damping, right)
    scale = 2 * eigenvalue[:, None, :] * _between(left, system.mass, right)
    scale = scale + _between(left, system.damping, right)
    slope = np.empty(eigenvalue.shape)
    for number in range(len(eigenvalue)):
        for group in _groups(eigenvalue[number]):
            pair = number, group[:, None], group
            found = np.linalg.eigvals(-np.linalg.solve(scale[pair], change[pair]))
            # d|lambda| = Re(conj(lambda) lambda') / |lambda|
            own = eigenvalue[number, group]
            slope[number, group] = np.sort((np.conj(own.mean()) * found).real / np.abs(own.mean()))
    return slope / (2 * np.pi)


def _between(left: NDArray[Any], matrix: FloatArray, right: NDArray[Any]) -> NDArray[Any]:
    """``y^H A x`` of all pairs of vectors, (B, m, m)."""
    return np.asarray(np.conj(np.swapaxes(left, 1, 2)) @ (matrix @ right))


def _left_vectors(
    system: LinearSystem, eigenvalue: NDArray[np.complex128], right: NDArray[Any]
) -> NDArray[np.complex128]:
    """Left eigenvectors (B, n, m): null vectors of the conjugate transpose, by inverse iteration.

    Two steps from the right vectors, whose conjugates they are without rotation terms.
    """
    value = eigenvalue[:, :, None, None] * (1 + 1e-12)
    dynamic = np.square(value) * system.mass[:, None] + value * system.damping[:, None]
    adjoint = np.conj(np.swapaxes(dynamic + system.stiffness[:, None], 2, 3))
    vectors = np.swapaxes(right, 1, 2)[..., None].astype(complex)
    for _ in range(3):
        vectors = np.linalg.solve(adjoint, vectors)
        vectors = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
    return np.asarray(np.swapaxes(vectors[..., 0], 1, 2))


def _groups(eigenvalue: NDArray[np.complex128]) -> list[NDArray[np.intp]]:
    """Numbers of the modes with equal eigenvalues, group by group."""
    apart = np.abs(np.diff(eigenvalue)) > REPEATED * np.abs(eigenvalue[1:])
    return np.split(np.arange(len(eigenvalue)), np.flatnonzero(apart) + 1)
