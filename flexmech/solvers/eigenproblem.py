"""The frozen eigenproblem of a linear system, in many positions at once.

Damped or turning systems have the quadratic eigenproblem ``(lambda^2 M + lambda C + K) x = 0``.
Strong damping lets high modes creep back instead of swinging: each gives two real eigenvalues, a
fast one and one near ``-1 / tau``, slower perhaps than modes that oscillate. A shape x has the
natural frequency ``sqrt(x^H K x / x^H M x)``. A mode that oscillates shows it in ``|lambda|`` and
one that creeps is slower, in a turning frame perhaps on a spiral with a small imaginary part. Which
modes are the lowest is decided by the natural frequencies of their shapes, so that no creeping mode
is passed over, and none counts that lies above those asked for.

It is solved as one of matrices of twice the size, the companion form. A shaft that turns freely
adds a mode that deforms nothing: at rest its two eigenvalues are zero, and the stiffness has no
inverse. Eigenvalues are shifted by a real number instead, which is no eigenvalue, and the two
whose shapes are most alike to the rigid motion are taken out.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.mechanics import (
    BucklingError,
    LinearSystem,
    OverdampedError,
    TooManyModesError,
    refuse_positions,
)


def _without_rigid_modes(
    system: LinearSystem,
) -> tuple[NDArray[Any], NDArray[Any], FloatArray, NDArray[np.complex128]]:
    """Eigenvalues and states of a system with rigid modes; those of these are set to zero.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions, n coordinates, r rigid modes.

    Returns
    -------
    ndarray of complex, shape (B, 2 n)
        ``unit / lambda``; zero of the rigid modes.
    ndarray of complex, shape (B, 2 n, 2 n)
        States; their first halves are the shapes.
    ndarray, shape (B, 1)
        The units.
    ndarray of complex, shape (B, 2 r)
        Eigenvalues of the rigid modes in rad/s.
    """
    shapes, about = _rigid_shapes(system)
    shift, count = about[:, None, None], 2 * system.rigid_modes
    damping = system.damping + 2 * shift * system.mass
    stiffness = system.stiffness + shift * system.damping + shift**2 * system.mass
    companion, unit = _inverse_companion(system.mass, damping, stiffness)
    inverse, states = np.linalg.eig(companion)
    eigenvalues = about[:, None] + unit / inverse.astype(complex)
    moved = states[:, : system.size]
    inertia = system.mass @ shapes
    alike = (np.abs(np.swapaxes(inertia, 1, 2) @ moved) ** 2).sum(axis=1)
    alike /= np.einsum("bim,bij,bjm->bm", moved.conj(), system.mass, moved).real
    rigid = np.argsort(-alike, axis=1)[:, :count]
    of_rigid = np.take_along_axis(eigenvalues, rigid, axis=1)
    np.put_along_axis(eigenvalues, rigid, np.inf, axis=1)
    return unit / eigenvalues, states, unit, of_rigid


def _inverse_companion(
    mass: FloatArray, damping: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Matrices (B, 2 n, 2 n) whose eigenvalues are ``unit / lambda``, and the units (B, 1).

    The lowest modes are their largest eigenvalues. In units of time of the slowest mode both
    blocks are of order one.
    """
    size = mass.shape[1]
    flexible = np.linalg.solve(stiffness, np.concatenate([damping, mass], axis=2))
    unit = 1 / np.sqrt(np.abs(flexible[:, :, size:]).sum(axis=2).max(axis=1))[:, None]
    companion = np.zeros((len(flexible), 2 * size, 2 * size))
    companion[:, :size, :size] = -flexible[:, :, :size] * unit[:, None]
    companion[:, :size, size:] = -flexible[:, :, size:] * unit[:, None] ** 2
    companion[:, np.arange(size, 2 * size), np.arange(size)] = 1.0
    return companion, unit


def _rigid_shapes(system: LinearSystem) -> tuple[FloatArray, FloatArray]:
    """Rigid shapes (B, n, r) of unit mass, and the lowest frequency (B,) of the others in rad/s.

    The rigid motion is the softest shape of the symmetric part of the stiffness.
    """
    half = np.linalg.inv(np.linalg.cholesky(system.mass))
    across = np.swapaxes(half, 1, 2)
    symmetric = (system.stiffness + np.swapaxes(system.stiffness, 1, 2)) / 2
    squares, vectors = np.linalg.eigh(half @ symmetric @ across)
    count = system.rigid_modes
    return across @ vectors[:, :, :count], np.sqrt(np.abs(squares[:, count]))


# Eigenvalues with a greater damping ratio may be of shapes that creep back.
NEARLY_CREEPING = 0.9
# Such a shape creeps if its eigenvalue is slower than this part of its natural frequency; of
# modes that oscillate both are equal but for gyroscopic terms.
SLOWER_THAN_ITS_SHAPE = 0.7
# Positive real eigenvalues this many times as fast as the slowest mode are round-off.
ROUND_OFF = 1e-9
# Relative difference of the sizes of two eigenvalues below which they are a pair of flutter, one of
# which grows as fast as the other decays: the root of round-off. Smaller damping ratios are none.
SAME = 1e-8


@dataclass(frozen=True)
class QuadraticModes:
    """Lowest modes of B positions in ascending order of their natural frequencies.

    Parameters
    ----------
    eigenvalues : ndarray of complex, shape (B, m)
        ``lambda`` in rad/s, imaginary part positive. A mode that creeps has ``-w``, with w the
        natural frequency of its shape. Among two modes of one frequency the one that grows stands
        first.
    vectors : ndarray of complex, shape (B, n, m)
        Without scale; m is zero where they were not asked for.
    oscillating : ndarray of int, shape (B,)
        How many of the modes that must oscillate do so, below the first one that creeps.
    diverges : ndarray of bool, shape (B,)
        Whether an eigenvalue is real and positive.
    rigid : ndarray of complex, shape (B, 2 r)
        Both eigenvalues of each of the system's r rigid modes, which are none of the m modes.
    """

    eigenvalues: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    oscillating: IntArray
    diverges: NDArray[np.bool_]
    rigid: NDArray[np.complex128]


def quadratic_modes(
    system: LinearSystem, count: int, spare: int = 0, *, shapes: bool = True
) -> QuadraticModes:
    """Lowest modes of a system.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions.
    count : int
        Modes that must oscillate.
    spare : int
        Further modes.
    shapes : bool
        Whether mode shapes are wanted; without them it takes half the time.

    Returns
    -------
    QuadraticModes
        ``count + spare`` of them.
    """
    most, size, states = count + spare, system.size, None
    rigid = np.zeros((len(system.mass), 0), dtype=complex)
    if system.rigid_modes:
        inverse, states, unit, rigid = _without_rigid_modes(system)
    else:
        companion, unit = _inverse_companion(system.mass, system.damping, system.stiffness)
        if shapes:
            inverse, states = np.linalg.eig(companion)
        else:
            inverse = np.linalg.eigvals(companion)
    order, unclear = _oscillating_modes(inverse, most)
    eigenvalues = _of(unit, inverse, order)
    vectors = np.zeros((len(unit), size, 0), dtype=complex)
    if states is not None:
        vectors = np.take_along_axis(states[:, :size], order[:, None, :], axis=2).astype(complex)
    oscillating = np.full(len(unclear), count)
    for place in np.flatnonzero(unclear).tolist():
        one, shapes_of_one = (
            np.linalg.eig(companion[place]) if states is None else (inverse[place], states[place])
        )
        sorted_values, which, creeping = _sorted_out(
            system, place, unit[place], one, shapes_of_one[:size]
        )
        eigenvalues[place] = sorted_values[:most]
        if states is not None:
            vectors[place] = shapes_of_one[:size, which[:most]]
        # Before the first one that creeps.
        oscillating[place] = np.append(creeping[:count], True).argmax()
    return QuadraticModes(eigenvalues, vectors, oscillating, _diverges(inverse), rigid)


def _of(unit: FloatArray, inverse: NDArray[Any], order: IntArray) -> NDArray[np.complex128]:
    """Eigenvalues in an order; zero ones of the inverse are no modes."""
    chosen = np.take_along_axis(inverse, order, axis=1).astype(complex)
    with np.errstate(over="ignore"):
        return np.asarray(unit / np.where(chosen == 0, np.finfo(float).tiny, chosen))


def _oscillating_modes(inverse: NDArray[Any], count: int) -> tuple[IntArray, NDArray[np.bool_]]:
    """Lowest modes that oscillate beyond doubt, and where others might be as low.

    Parameters
    ----------
    inverse : ndarray of complex, shape (B, 2 n)
        ``unit / lambda``.
    count : int

    Returns
    -------
    order : ndarray of int, shape (B, count)
    unclear : ndarray of bool, shape (B,)
        An eigenvalue that may belong to a creeping shape is lower than the last of them.
    """
    size = np.abs(inverse)
    damped = -inverse.real > NEARLY_CREEPING * size
    swings = (inverse.imag < 0) & ~damped  # the inverse of a + ib has imaginary part -b
    rank = np.where(swings, size, 0.0)
    order = _growing_first(np.argsort(-rank, axis=1), inverse)[:, :count]
    last = np.take_along_axis(rank, order[:, -1:], axis=1)
    unclear: NDArray[np.bool_] = (damped & (size > last)).any(axis=1) | (last[:, 0] == 0)
    return order, unclear


def _growing_first(order: IntArray, eigenvalues: NDArray[Any]) -> IntArray:
    """An order by size in which, of two modes of one frequency, the one that grows stands first.

    Parameters
    ----------
    order : ndarray of int, shape (B, k)
    eigenvalues : ndarray of complex, shape (B, n)
        Or their inverses, whose real parts have the same signs.

    Returns
    -------
    ndarray of int, shape (B, k)
    """
    ordered = np.take_along_axis(eigenvalues, order, axis=1)
    size = np.abs(ordered)
    growth = ordered.real / np.where(size > 0, size, 1.0)
    swapped = np.abs(np.diff(size, axis=1)) <= SAME * size[:, :-1]
    swapped &= np.diff(growth, axis=1) > SAME
    swapped[:, 1:] &= ~swapped[:, :-1]
    row, place = np.nonzero(swapped)
    order = order.copy()
    order[row, place], order[row, place + 1] = order[row, place + 1], order[row, place]
    return order


def _sorted_out(
    system: LinearSystem,
    place: int,
    unit: FloatArray,
    inverse: NDArray[Any],
    shapes: NDArray[Any],
) -> tuple[NDArray[Any], IntArray, NDArray[np.bool_]]:
    """All modes of one position in ascending order, those that creep back among them.

    Parameters
    ----------
    system : LinearSystem
    place : int
        Number of the position.
    unit : ndarray, shape (1,)
    inverse : ndarray of complex, shape (2 n,)
        ``unit / lambda``.
    shapes : ndarray, shape (n, 2 n)

    Returns
    -------
    eigenvalues : ndarray of complex, shape (m,)
        As in :class:`QuadraticModes`. A fast real eigenvalue stands for itself.
    which : ndarray of int, shape (m,)
        Their numbers among the eigenvalues given.
    creeps : ndarray of bool, shape (m,)
    """
    which = np.flatnonzero((inverse.imag <= 0) & (inverse != 0))  # one of each pair
    values, x = unit / inverse[which].astype(complex), shapes[:, which]
    stiffness, mass = (
        np.abs(np.sum(x.conj() * (matrix[place] @ x), axis=0))
        for matrix in (system.stiffness, system.mass)
    )
    natural, size = np.sqrt(stiffness / mass), np.abs(values)
    slow = (values.imag == 0) | (size < SLOWER_THAN_ITS_SHAPE * natural)
    creeps = slow & (-values.real > NEARLY_CREEPING * size)
    values = np.where(creeps, -np.maximum(natural, size), values)
    [order] = _growing_first(np.argsort(np.abs(values))[None], values[None])
    return values[order], which[order], creeps[order]


def _diverges(inverse: NDArray[Any]) -> NDArray[np.bool_]:
    growing = np.where(inverse.imag == 0, inverse.real, 0.0).max(axis=1)
    return np.asarray(growing > ROUND_OFF * np.abs(inverse).max(axis=1))


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
        modes = quadratic_modes(system, count, shapes=False)
        _refuse_unsteady(system, modes, count)
        return modes.eigenvalues
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
    vectors = unit_mass @ vectors[:, :, : rigid + count]
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
    """Stiffness ``W' K W`` in coordinates y of unit mass, and W with ``z = W y``, (B, n, n)."""
    lower = np.linalg.inv(np.linalg.cholesky(system.mass))
    unit_mass = np.swapaxes(lower, 1, 2)
    return lower @ system.stiffness @ unit_mass, unit_mass


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
    modes = quadratic_modes(system, count, spare)
    _refuse_unsteady(system, modes, count)
    shapes = modes.vectors
    norm = np.einsum("bim,bij,bjm->bm", shapes.conj(), system.mass, shapes, optimize=True)
    return Modes(modes.eigenvalues, shapes / np.sqrt(norm.real)[:, None, :], modes.rigid)


def _refuse_unsteady(system: LinearSystem, modes: QuadraticModes, count: int) -> None:
    _refuse(system, modes.diverges, "the frozen linkage diverges without oscillating")
    creeps = modes.oscillating < count
    least = int(modes.oscillating.min())
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
