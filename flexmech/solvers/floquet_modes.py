"""Floquet modes of the running linkage in the band of the natural frequencies asked for.

What follows from their exponents alone, and the error of the steps of a turn, or of round-off
where no steps are needed.

:class:`VibratingLinkage` is the linkage at a crank speed: a small periodic system and its shapes,
whose frequencies decide the steps of the propagator in a turn, which must fit into memory.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems import (
    FourierSeries,
    SampledPeriodicSystem,
    floquet_modes,
    krein_signature,
)
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.solvers.moving_modes import MovingModes

# Greatest number of steps of a turn; more do not fit into memory with the smallest of linkages.
MOST_STEPS = 1_000_000
SHAPE_ANGLES = 16
"""Crank angles a turn at which the shapes of modes are compared: a shape changes as the linkage's
position does, in the first few harmonics of the turn."""


@dataclass(frozen=True)
class VibratingLinkage:
    """The linkage in m moving modes, without the matrices from which they were made.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    scale : ndarray, shape (m,)
        See :class:`flexmech.solvers.MovingModes`.
    conservative, dissipative : FourierSeries
        Matrix (2 m, 2 m) of the system without damping, and what damping of links adds to it.
    attached : FourierSeries
        What dampers of springs and joints and follower forces add to it.
    weighted : ndarray, shape (SHAPE_ANGLES, N, m)
        From y to the coordinates of all unreduced links, weighted by their mass.
    lowest : ndarray, shape (SHAPE_ANGLES, modes, m)
        From y to the amplitudes of the lowest natural modes at the same crank angles, without
        rigid ones.
    rigid : ndarray, shape (SHAPE_ANGLES, r, m)
        From y to the amplitudes of rigid modes: that of a free shaft.
    fastest : float
        Greatest natural frequency in rad/s that the steps must resolve.
    highest : float
        Greatest natural frequency in rad/s of the modes whose Floquet modes are kept.
    least_square, least_angle : float
        Least square of a natural frequency in (rad/s)^2, and its crank angle in rad.
    is_definite : bool
        Whether the Hamilton function is positive definite at all crank angles.
    orbit_distance, orbit_residual : float or None
        Distance and residual of the periodic motion, if the modes belong to one.
    """

    crank_speed: float
    scale: FloatArray
    conservative: FourierSeries
    dissipative: FourierSeries
    attached: FourierSeries
    weighted: FloatArray
    lowest: FloatArray
    rigid: FloatArray
    fastest: float
    highest: float
    least_square: float
    least_angle: float
    is_definite: bool
    orbit_distance: float | None = None
    orbit_residual: float | None = None

    @classmethod
    def of(cls, moving: MovingModes, modes: int) -> VibratingLinkage:
        """Take what is needed from moving modes.

        Parameters
        ----------
        moving : MovingModes
        modes : int
            Natural modes whose Floquet modes are kept.

        Returns
        -------
        VibratingLinkage
        """
        turn = moving.turn
        at_shapes = slice(None, None, len(moving.basis) // SHAPE_ANGLES)
        basis, squares = moving.basis[at_shapes], turn.frozen_squares
        first = turn.rigid_modes
        natural = np.swapaxes(turn.frozen_modes[at_shapes, :, : first + modes], 1, 2)
        amplitude = natural @ turn.mass[at_shapes] @ basis
        least = int(turn.static_squares.argmin())
        # A constant system is solved exactly, whatever else moves in it.
        asked = min(first + modes, moving.size)
        counted = asked if turn.is_constant else moving.size
        return cls(
            crank_speed=turn.crank_speed,
            scale=moving.scale,
            conservative=moving.conservative,
            dissipative=moving.dissipative,
            attached=moving.attached,
            weighted=turn.weighted_shapes(basis, at_shapes),
            lowest=amplitude[:, first:],
            rigid=amplitude[:, :first],
            fastest=float(np.sqrt(max(squares[:, counted - 1].max(), 0.0))),
            highest=float(np.sqrt(max(squares[:, asked - 1].max(), 0.0))),
            least_square=float(turn.static_squares[least]),
            least_angle=float(turn.motion.crank_angle[least]),
            is_definite=moving.is_definite,
        )

    @property
    def size(self) -> int:
        """Number m of moving modes."""
        return len(self.scale)

    @property
    def is_constant(self) -> bool:
        """Whether nothing changes in the turn, so that the Floquet modes are eigenvectors."""
        return not any(
            series.harmonics for series in (self.conservative, self.attached, self.dissipative)
        )

    @property
    def period(self) -> float:
        """Time of a turn in s."""
        return 2 * np.pi / abs(self.crank_speed)

    def spacing(self, steps: int) -> int:
        """Steps between instants that show all harmonics of the modes kept."""
        wanted = max(LEAST_STEPS, SHAPES_A_PERIOD * self.highest * self.period / (2 * np.pi))
        places = steps // SHAPE_ANGLES
        divisors = [n for n in range(1, places + 1) if places % n == 0]
        return max([1, *(n for n in divisors if steps / n >= wanted)])

    def system(self, damping: float) -> SampledPeriodicSystem:
        """Periodic system with the damping of links times a factor; 0 leaves it out."""
        matrix = self.conservative.plus(self.attached, 1.0).plus(self.dissipative, damping)
        return SampledPeriodicSystem(matrix, self.period)

    def with_potential_alone(self) -> VibratingLinkage:
        """The linkage without dampers of springs and joints and without follower forces."""
        return replace(self, attached=FourierSeries(np.zeros_like(self.attached.coefficients)))


# Steps are this part of a period of the fastest moving mode over 2 pi, or shorter: a propagator of
# sixth order then leaves 1e-7 of the multipliers of the modes asked for, which are slower.
RADIANS_A_STEP = 1.5
# A free shaft moves far more slowly, and what the steps leave of the fastest modes shows there.
RADIANS_BESIDE_A_FREE_SHAFT = 0.5
# Least steps of a turn at speeds above all modes: eight a crank angle at which shapes are compared.
LEAST_STEPS = 128
# Instants in a period of the highest frequency kept: the harmonics of a mode are some orders of the
# crank around its frequency, and two would be the limit.
SHAPES_A_PERIOD = 2.5
# Bytes that the steps of a turn may take, and what is kept of each step: matrices of the size of A,
# and waves of each harmonic (measured).
MOST_BYTES, MATRICES_A_STEP, WAVES_A_STEP = 4e9, 10, 12


def steps_of_turn(moving: VibratingLinkage, asked: int | None, *, beside_free_shaft: bool) -> int:
    """Steps of a turn: those asked for, or as many as the fastest moving mode wants.

    Parameters
    ----------
    moving : VibratingLinkage
        A constant one is solved by its eigenvalues, with any number of steps.
    asked : int or None
        A multiple of :data:`SHAPE_ANGLES`, at most :data:`MOST_STEPS`.
    beside_free_shaft : bool
        Whether the crank's shaft rotates freely.

    Returns
    -------
    int

    Raises
    ------
    ComputationError
        If the steps do not fit into memory.
    """
    if asked is None:
        steps = _wanted_steps(moving, beside_free_shaft=beside_free_shaft)
        remedy = "fewer modes or faster crank speeds"
    else:
        steps, remedy = asked, "fewer steps"
    if moving.is_constant:
        return int(min(steps, MOST_STEPS))
    _refuse_too_many_steps(steps, moving, remedy)
    return int(steps)


def _wanted_steps(moving: VibratingLinkage, *, beside_free_shaft: bool) -> float:
    """Steps that the fastest moving mode wants, however many."""
    radians = RADIANS_BESIDE_A_FREE_SHAFT if beside_free_shaft else RADIANS_A_STEP
    wanted = max(LEAST_STEPS, moving.fastest * moving.period / radians)
    return float(2 * SHAPE_ANGLES * np.ceil(wanted / (2 * SHAPE_ANGLES)))


def _refuse_too_many_steps(steps: float, moving: VibratingLinkage, remedy: str) -> None:
    """Refuse steps that do not fit into memory."""
    matrices = MATRICES_A_STEP * (2 * moving.size) ** 2
    waves = WAVES_A_STEP * len(moving.conservative.coefficients)
    size = np.dtype(float).itemsize * steps * (matrices + waves)
    frequency = moving.fastest / (2 * np.pi)
    if size > MOST_BYTES:
        raise ComputationError(
            f"a turn at crank speed {CRANK_SPEED} takes {steps:.7g} steps, since the fastest mode "
            f"vibrates at {frequency:.3g} Hz; they need some {size / 1e9:.2g} GB, and at most "
            f"{MOST_BYTES / 1e9:g} are taken: ask for {remedy}",
            crank_speed=moving.crank_speed,
        )


# Logarithm of a multiplier's modulus that is growth, and not round-off: multipliers that meet on
# the unit circle are known to the root of it, 1e-8.
GROWS = 1e-7


@dataclass(frozen=True)
class FloquetExponents:
    """Exponents of k Floquet modes.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    exponent : ndarray of complex, shape (k,)
        1/s.
    """

    crank_speed: float
    exponent: NDArray[np.complex128]

    @property
    def period(self) -> float:
        """Time of a turn in s."""
        return 2 * np.pi / abs(self.crank_speed)

    @property
    def log_modulus(self) -> FloatArray:
        """Logarithm of the multipliers' moduli, (k,)."""
        return np.asarray(self.exponent.real * self.period)

    @property
    def angle(self) -> FloatArray:
        """Angle of the multipliers between -pi and pi, (k,)."""
        return wrapped(self.exponent.imag * self.period)

    @property
    def multiplier_modulus(self) -> float:
        """Greatest of all; infinite where it is beyond the largest number, 1.8e308."""
        with np.errstate(over="ignore"):
            return float(np.exp(self.log_modulus.max()))

    @property
    def growth_rate(self) -> float:
        """Greatest of all, 1/s."""
        return float(self.exponent.real.max())

    def grows_beyond(self, error: FloatArray) -> bool:
        """Whether a modulus exceeds one by more than errors (k,) of the logarithms."""
        # 1 - 1/modulus is at most one, where a modulus of a slow turn is beyond all numbers.
        growing = -np.expm1(-np.maximum(self.log_modulus, 0.0))
        return bool(np.any(growing > error))


def wrapped(values: FloatArray, turn: float = 2 * np.pi) -> FloatArray:
    """Values less the whole turns in them: between minus and plus half a turn."""
    return np.asarray(values - turn * np.round(values / turn))


# Harmonics to either side of the largest whose share is given: more hold a thousandth.
HARMONICS = 4


@dataclass(frozen=True)
class SelectedModes(FloquetExponents):
    """The k = 2 m Floquet modes that m natural modes make, at one crank speed.

    A pair of complex conjugate modes is two of them.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    exponent : ndarray of complex, shape (k,)
        Exponents in 1/s: from the family ``lambda + i n omega`` the member whose harmonic is
        largest.
    shape : ndarray of complex, shape (SHAPE_ANGLES, N, k)
        At evenly spaced times of a turn, weighted by the links' mass: ``y^H y`` is that of the
        displacement. Its largest harmonic is the mean.
    harmonic_share : ndarray, shape (2 h + 1, k)
        Part of ``y^H y`` in the harmonics -h to h about the largest.
    signature : ndarray, shape (k,)
        Krein signatures at the start of a turn, in the scaled states; of a damped linkage's modes
        they mean nothing.
    liouville_defect : float
    steps : int
    rigid : ndarray of complex, shape (2 r,)
        Exponents in 1/s of the modes of r rigid motions, which are none of the k modes; their
        imaginary parts are known up to multiples of the crank's speed.
    """

    shape: NDArray[np.complex128]
    harmonic_share: FloatArray
    signature: FloatArray
    liouville_defect: float
    steps: int
    rigid: NDArray[np.complex128]

    def taken(self, order: IntArray) -> SelectedModes:
        """The modes in another order."""
        return replace(
            self,
            exponent=self.exponent[order],
            shape=self.shape[..., order],
            harmonic_share=self.harmonic_share[:, order],
            signature=self.signature[order],
        )


@dataclass(frozen=True)
class SelectedGrowth:
    """Part of :class:`SelectedModes` that growth alone needs.

    Parameters
    ----------
    growth_rate : float
        Greatest of all selected modes, 1/s.
    liouville_defect : float
    """

    growth_rate: float
    liouville_defect: float


def selected_modes(linkage: VibratingLinkage, damping: float, steps: int) -> SelectedModes:
    """Floquet modes that lie in the lowest natural modes of all crank angles.

    Parameters
    ----------
    linkage : VibratingLinkage
    damping : float
        Factor on the damping of the linkage.
    steps : int
        Steps of the propagator a turn; a multiple of :data:`SHAPE_ANGLES`.

    Returns
    -------
    SelectedModes

    Raises
    ------
    ComputationError
        If modes grow so far within a turn that they overflow.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return _kept(linkage, damping, steps)


def _kept(linkage: VibratingLinkage, damping: float, steps: int) -> SelectedModes:
    floquet = floquet_modes(linkage.system(damping), steps)
    states = floquet.shapes(steps // SHAPE_ANGLES)
    displaced = _displacements(states, linkage)
    kept, rigid = _within(linkage.lowest, displaced), _within(linkage.rigid, displaced)
    if floquet.whole_turns is None:
        largest, shares = _largest_harmonic(floquet.shapes(linkage.spacing(steps), kept))
    else:
        largest, shares = _one_harmonic(floquet.whole_turns[kept])
    weighted = linkage.weighted @ _about_harmonic(displaced[..., kept], largest)
    if not np.isfinite(weighted).all():
        raise ComputationError(
            f"modes grow beyond all numbers within a turn at crank speed {CRANK_SPEED}: the "
            "linkage is far from stable there; take a stiffer linkage, less load, or other speeds",
            crank_speed=linkage.crank_speed,
        )
    return SelectedModes(
        linkage.crank_speed,
        floquet.exponent[kept] + 2j * np.pi * largest / linkage.period,
        weighted / np.sqrt((np.abs(weighted) ** 2).sum(axis=(0, 1))),
        shares,
        krein_signature(states[0][:, kept]),
        floquet.liouville_defect,
        steps,
        floquet.exponent[rigid],
    )


def selected_growth(linkage: VibratingLinkage, damping: float, steps: int) -> SelectedGrowth:
    """Growth of the modes that :func:`selected_modes` keeps, in two thirds of its time.

    Parameters
    ----------
    linkage : VibratingLinkage
    damping : float
    steps : int

    Returns
    -------
    SelectedGrowth
    """
    floquet = floquet_modes(linkage.system(damping), steps)
    states = floquet.shapes(steps // SHAPE_ANGLES)
    kept = _within(linkage.lowest, _displacements(states, linkage))
    return SelectedGrowth(float(floquet.exponent.real[kept].max()), floquet.liouville_defect)


def matched(first: NDArray[np.complex128], second: NDArray[np.complex128]) -> IntArray:
    """Counterpart of each first logarithm of multipliers (k,) among the second (n,).

    Parameters
    ----------
    first, second : ndarray of complex
        Logarithms, whose imaginary parts are angles.

    Returns
    -------
    ndarray of int, shape (k,)
    """
    gap = first[:, None] - second
    pairs = scipy.optimize.linear_sum_assignment(np.hypot(gap.real, wrapped(gap.imag)))
    return np.asarray(pairs[1], dtype=np.intp)


def _largest_harmonic(states: NDArray[np.complex128]) -> tuple[IntArray, FloatArray]:
    """Number of the largest harmonic of each mode (N, 2 m, k); shares of those by it.

    Harmonics are measured by the scaled states, as actions: displacements count for slow ones,
    velocities for fast ones.
    """
    # Mode by mode: slow turns take thousands of steps.
    shapes = np.moveaxis(states, 2, 0)
    size = np.stack([(np.abs(np.fft.fft(y, axis=0)) ** 2).sum(axis=1) for y in shapes], axis=1)
    steps, count = size.shape
    place = size.argmax(axis=0)
    near = (place + np.arange(-HARMONICS, HARMONICS + 1)[:, None]) % steps
    shares = size[near, np.arange(count)] / size.sum(axis=0)
    number = np.where(place < steps / 2, place, place - steps)
    return number.astype(np.intp), shares


def _one_harmonic(turns: FloatArray) -> tuple[IntArray, FloatArray]:
    """Result of :func:`_largest_harmonic` for shapes that are one harmonic each."""
    shares = np.zeros((2 * HARMONICS + 1, len(turns)))
    shares[HARMONICS] = 1.0
    return turns.astype(np.intp), shares


def _about_harmonic(displaced: NDArray[np.complex128], number: IntArray) -> NDArray[np.complex128]:
    """Displacements y of modes (angles, m, k) without the turns of a harmonic each."""
    angles = len(displaced)
    turned = np.exp(-2j * np.pi * np.outer(np.arange(angles), number) / angles)
    return np.asarray(displaced * turned[:, None])


def _displacements(
    states: NDArray[np.complex128], linkage: VibratingLinkage
) -> NDArray[np.complex128]:
    """Displacements y (angles, m, n) of scaled states (angles, 2 m, n)."""
    return np.asarray(states[:, : linkage.size] / np.sqrt(linkage.scale)[:, None])


def _within(natural: FloatArray, shapes: NDArray[np.complex128]) -> IntArray:
    """The 2 m modes whose displacement (angles, n, k) lies most in m natural modes."""
    inside = (np.abs(natural @ shapes) ** 2).sum(axis=(0, 1))
    of_all = (np.abs(shapes) ** 2).sum(axis=(0, 1))
    # Round-off must not part two conjugate modes.
    order = np.argsort(-np.round(inside / of_all, 9), kind="stable")
    return np.sort(order[: 2 * natural.shape[1]])


def step_error(moving: VibratingLinkage, modes: SelectedModes, damping: float) -> FloatArray:
    """Change of the logarithms of multipliers (k,) when the steps are halved in number.

    Steps solve a constant system exactly. What is left is the round-off of its eigenvalues:
    machine precision times the matrix's norm, the condition of the eigenvalue and the time of a
    turn (G. H. Golub & C. F. Van Loan, Matrix Computations, section 7.2.2).

    Parameters
    ----------
    moving : VibratingLinkage
    modes : SelectedModes
        Found with all steps.
    damping : float
        Factor on the damping, with which they were found.

    Returns
    -------
    ndarray, shape (k,)
    """
    system = moving.system(damping)
    if system.is_constant:
        return _round_off(system, modes)
    coarse = floquet_modes(system, modes.steps // 2)
    log, other = modes.exponent * modes.period, coarse.exponent * coarse.period
    gap = log - other[matched(log, other)]
    return np.hypot(gap.real, wrapped(gap.imag))


def _round_off(system: SampledPeriodicSystem, modes: SelectedModes) -> FloatArray:
    """Round-off of the logarithms of a constant system's multipliers, (k,)."""
    matrix = system.matrices(1, 0.0)[0]
    values, left, right = scipy.linalg.eig(matrix, left=True, right=True)
    cosine = np.abs(np.einsum("in,in->n", left.conj(), right))
    size = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
    error = np.finfo(float).eps * np.linalg.norm(matrix, 2) * size / cosine * system.period
    nearest = np.abs(modes.exponent[:, None] - values).argmin(axis=1)
    return np.asarray(error[nearest])
