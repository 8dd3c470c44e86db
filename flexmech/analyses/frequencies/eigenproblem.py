"""The frozen eigenproblem of a linear system, in many positions at once."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.quadratic_eigenproblem import QuadraticModes, quadratic_modes
from flexmech.arrays import FloatArray
from flexmech.linear_system import (
    BucklingError,
    LinearSystem,
    OverdampedError,
    TooManyModesError,
    refuse_positions,
)

# Round-off that is allowed in a squared frequency, relatively: tables write ten digits.
BLUR = 1e-10


@dataclass(frozen=True)
class Modes:
    """Lowest modes over a batch of B positions, in ascending order of frequency.

    Parameters
    ----------
    eigenvalues : ndarray of complex, shape (B, m)
        ``lambda`` in rad/s, imaginary part positive.
    vectors : ndarray, shape (B, n, m)
        Mode shapes in the system's coordinates, normalized so that x^H M x = 1; real for
        a conservative system.
    rigid : ndarray of complex, shape (B, 2 r)
        Both eigenvalues of each of the system's r rigid modes, which are none of the m modes.
    """

    eigenvalues: NDArray[np.complex128]
    vectors: NDArray[Any]
    rigid: NDArray[np.complex128] = field(default_factory=lambda: np.zeros((0, 0), dtype=complex))

    @property
    def count(self) -> int:
        """Number of modes m."""
        return int(self.eigenvalues.shape[1])

    def lowest(self, count: int) -> Modes:
        """The first ``count`` of them."""
        return Modes(self.eigenvalues[:, :count], self.vectors[:, :, :count], self.rigid)

    @property
    def frequency(self) -> FloatArray:
        """Natural frequency ``|lambda| / 2 pi`` in Hz, shape (B, m)."""
        return np.abs(self.eigenvalues) / (2 * np.pi)

    @property
    def damping_ratio(self) -> FloatArray:
        """``-Re(lambda) / |lambda|``, shape (B, m)."""
        # 0.0 - x rather than -x: an undamped mode has ratio 0, not -0
        return (0.0 - self.eigenvalues.real) / np.abs(self.eigenvalues)


def solve_modes(system: LinearSystem, count: int, spare: int = 0) -> Modes:
    """Lowest ``count`` modes in each position, and some more.

    A conservative system (frozen inertial form without damping) is solved as
    ``(K - w^2 M) x = 0``; any other as ``(lambda^2 M + lambda C + K) x = 0``. Rigid modes of the
    system are left out.

    Parameters
    ----------
    system : LinearSystem
    count : int
        Modes that must oscillate.
    spare : int
        Further modes. One that does not oscillate stands with the eigenvalue ``-w``, w the
        natural frequency of its shape.

    Returns
    -------
    Modes
        ``count + spare`` of them.

    Raises
    ------
    InputError
        If the system has fewer coordinates than modes asked for.
    ComputationError
        If a mode asked for does not oscillate (the frozen linkage is unstable or
        overdamped there); names the crank angle and speed.
    """
    _require(system, count + spare)
    if system.is_conservative:
        return _conservative(system, count + spare)
    return _general(system, count, spare)


def solve_frequencies(system: LinearSystem, count: int) -> FloatArray:
    """Lowest ``count`` natural frequencies in Hz, without mode shapes; shape (B, count).

    Errors as for :func:`solve_modes`.
    """
    return np.asarray(np.abs(solve_eigenvalues(system, count)) / (2 * np.pi), dtype=float)


def solve_eigenvalues(system: LinearSystem, count: int) -> NDArray[np.complex128]:
    """Eigenvalues of the lowest ``count`` modes in rad/s, without mode shapes; shape (B, count).

    Errors as for :func:`solve_modes`.
    """
    _require(system, count)
    if not system.is_conservative:
        found = quadratic_modes(system, count, shapes=False)
        _refuse_unsteady(system, found, count)
        return found.eigenvalues
    if system.rigid_modes:
        return _conservative(system, count).eigenvalues
    every = np.asarray(np.linalg.eigvalsh(_standard_form(system)[0]), dtype=float)
    values = every[:, :count].copy()
    _sharpen(system, every, values)
    _refuse_unstable(system, values)
    return np.asarray(1j * np.sqrt(values))


def _require(system: LinearSystem, count: int) -> None:
    most = system.size - system.rigid_modes
    if not 1 <= count <= most:
        raise TooManyModesError(
            f"modes: {count} were asked for, the model has {most}; ask for fewer modes or more "
            "elements",
            most_modes=most,
        )


def _conservative(system: LinearSystem, count: int) -> Modes:
    stiffness, unit_mass = _standard_form(system)
    every, vectors = np.linalg.eigh(stiffness)
    rigid = system.rigid_modes
    vectors = vectors[:, :, : rigid + count]
    vectors[:, : unit_mass.shape[1]] = unit_mass @ vectors[:, : unit_mass.shape[1]]
    rigid_shapes, shapes = vectors[:, :, :rigid], np.ascontiguousarray(vectors[:, :, rigid:])
    values = every[:, rigid : rigid + count].copy()
    _sharpen(_with_springs(system, rigid_shapes, every[:, -1]), every[:, rigid:], values, shapes)
    _refuse_unstable(system, values)
    return Modes(1j * np.sqrt(values), shapes, _rigid_eigenvalues(system, rigid_shapes))


def _with_springs(system: LinearSystem, shapes: FloatArray, square: FloatArray) -> LinearSystem:
    """The system with springs that give shapes (B, n, r) of unit mass a squared frequency."""
    if not shapes.shape[2]:
        return system
    inertia = system.mass @ shapes
    springs = square[:, None, None] * (inertia @ np.swapaxes(inertia, 1, 2))
    return replace(system, stiffness=system.stiffness + springs)


def _rigid_eigenvalues(system: LinearSystem, shapes: FloatArray) -> NDArray[np.complex128]:
    """Both eigenvalues (B, 2 r) of each rigid shape (B, n, r) of unit mass.

    By Rayleigh's quotient: round-off of the fastest modes hides the eigenvalue itself.
    """
    squares = np.einsum("bir,bij,bjr->br", shapes, system.stiffness, shapes)
    values = np.sqrt(np.asarray(-squares, dtype=complex))
    return np.concatenate([values, -values], axis=1)


def _standard_form(system: LinearSystem) -> tuple[FloatArray, FloatArray]:
    """Stiffness in coordinates of unit mass, and how the first of them are made.

    ``z = W y`` with ``W' M W = 1``. Where the mass is the unit matrix from coordinate e on,
    W differs from the unit matrix in its first e rows and columns alone.

    Returns
    -------
    stiffness : ndarray, shape (B, n, n)
        Its lower triangle, which is what ``numpy.linalg.eigh`` reads.
    unit_mass : ndarray, shape (B, e, e)
        First rows and columns of W.
    """
    ends = system.size if system.unit_mass_from is None else system.unit_mass_from
    lower = np.linalg.inv(np.linalg.cholesky(system.mass[:, :ends, :ends]))
    unit_mass, stiffness = np.swapaxes(lower, 1, 2), system.stiffness.copy()
    np.matmul(system.stiffness[:, :, :ends], unit_mass, out=stiffness[:, :, :ends])
    stiffness[:, :ends, :ends] = lower @ stiffness[:, :ends, :ends]
    return stiffness, unit_mass


def _sharpen(
    system: LinearSystem, every: FloatArray, squares: FloatArray, shapes: FloatArray | None = None
) -> None:
    """Compute the lowest modes anew where round-off of the highest blurs them, in place.

    The lowest frequencies are the greatest eigenvalues of the flexibility, whose round-off is
    relative to them. Scaling by the diagonal keeps a soft link apart from a stiff one. Where
    the stiffness is not positive, nothing is changed.

    Parameters
    ----------
    system : LinearSystem
    every : ndarray, shape (B, n)
        Squared frequencies, ascending.
    squares : ndarray, shape (B, count)
        The lowest of them.
    shapes : ndarray, shape (B, n, count), optional
        Their modes.
    """
    count = squares.shape[1]
    blur = np.finfo(float).eps * every[:, -1]
    for number in np.flatnonzero(blur > BLUR * np.abs(every[:, 0])):
        stiffness, mass = system.stiffness[number], system.mass[number]
        scale = 1 / np.sqrt(np.abs(np.diagonal(stiffness)))
        try:
            lower = np.linalg.cholesky(scale[:, None] * stiffness * scale)
        except np.linalg.LinAlgError:
            continue
        half = np.linalg.inv(lower) * scale
        flexible, vectors = np.linalg.eigh(half @ mass @ half.T)
        lowest = flexible[: -count - 1 : -1]
        squares[number] = 1 / lowest
        if shapes is not None:
            shapes[number] = half.T @ vectors[:, : -count - 1 : -1] / np.sqrt(lowest)


def _refuse_unstable(system: LinearSystem, squares: FloatArray) -> None:
    unstable = ~np.all(squares > 0, axis=1)
    _refuse(system, unstable, "the frozen linkage is statically unstable")


def _general(system: LinearSystem, count: int, spare: int) -> Modes:
    found = quadratic_modes(system, count, spare)
    _refuse_unsteady(system, found, count)
    shapes = found.vectors
    norm = np.einsum("bim,bij,bjm->bm", shapes.conj(), system.mass, shapes, optimize=True)
    return Modes(found.eigenvalues, shapes / np.sqrt(norm.real)[:, None, :], found.rigid)


def _refuse_unsteady(system: LinearSystem, found: QuadraticModes, count: int) -> None:
    _refuse(system, found.diverges, "the frozen linkage diverges without oscillating")
    creeps = found.oscillating < count
    least = int(found.oscillating.min())
    fewer = f"ask for no more than {least}, or " if least else ""
    refuse_positions(
        system.motion,
        creeps,
        f"fewer than {count} of the lowest modes oscillate (overdamped)",
        f"; {fewer}lower the damping of links, springs and joints",
        partial(OverdampedError, most_modes=least),
    )


def _refuse(system: LinearSystem, failed: NDArray[np.bool_], what: str) -> None:
    remedy = "; lower the crank speed, ask for fewer modes, or stiffen the links"
    if not system.motion.crank_speed[failed].any():
        remedy = (
            "; at rest only gravity, loads, springs, heat or water can do that, or links "
            "whose lengths, stiffnesses and masses differ beyond all proportion: check their units"
        )
    refuse_positions(system.motion, failed, what, remedy, BucklingError)
