"""Response of a periodic system to a harmonic force: harmonic transfer functions.

A force ``exp(i w t)`` on ``x' = A(t) x + b(t) u`` whose matrices repeat themselves with the
frequency ``W = 2 pi / T`` answers, once what is free has died out, at ``w + n W`` for every order
n. The amplitudes are the harmonic transfer functions H_n(w) (N. M. Wereley & S. R. Hall, Frequency
response of linear time periodic systems, 29th IEEE Conference on Decision and Control (1990)
3650-3655; N. M. Wereley, thesis, MIT 1991). They follow from the one solution
``x = xi(t) exp(i w t)`` whose xi repeats itself. Over a step of length h, with the transition
matrix G of :mod:`flexmech.dynamical_systems.floquet`::

    xi(t + h) = exp(-i w h) (G xi(t) + sum_j w_j exp(i w s_j)),   H_n(w) = mean(c xi exp(-i n W t))

Within a step ``exp(i w t)`` is a polynomial through five points s_j, whose coefficients are further
states of the propagator: so the answers w_j are as exact as the transition matrix, and what dies
out within a step is as exact as the rest. A first march from rest gives the state at the start of
a turn to which the turn leads back, a second one from there the answer. The
static answer R of what the states leave out is added. Harmonic balance, which balances the
harmonics of x, is another way to the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.dynamical_systems.floquet import (
    PeriodicSystem,
    SampledPeriodicSystem,
    transition_matrices,
)
from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.errors import ComputationError
from flexmech.validation import check_count, checked_array

# Frequencies whose answers are in memory at a time. Memory alone: 40 MB with ten thousand steps.
BATCH = 256
# Points of a step through which exp(i w t) is interpolated: with sixteen steps in a period they
# miss it by 1e-6.
POINTS = 5


@dataclass(frozen=True)
class ForcedPeriodicSystem:
    """``x' = A(t) x + b(t) u``, ``y = c(t) x + r(t) u`` with one input and one output.

    Parameters
    ----------
    system : SampledPeriodicSystem
        System of A, (n, n).
    force : FourierSeries
        Force of b, (n,).
    reading : FourierSeries
        Reading of c, (n,).
    residual : FourierSeries
        Residual of r, (): the static answer of what the states leave out.
    """

    system: SampledPeriodicSystem
    force: FourierSeries
    reading: FourierSeries
    residual: FourierSeries

    @classmethod
    def constant(
        cls,
        mass: FloatArray,
        damping: FloatArray,
        stiffness: FloatArray,
        force: FloatArray,
        reading: FloatArray,
        period: float,
    ) -> ForcedPeriodicSystem:
        """A constant system ``M z'' + C z' + K z = force u``, ``y = reading z``.

        Parameters
        ----------
        mass, damping, stiffness : ndarray, shape (m, m)
        force, reading : ndarray, shape (m,)
        period : float
            Any, in s.

        Returns
        -------
        ForcedPeriodicSystem
            With n = 2 m states.
        """
        size = len(mass)
        solved = np.linalg.solve(mass, np.column_stack([stiffness, damping, force]))
        matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-solved[:, : 2 * size]]])
        nothing = np.zeros(size)
        return cls(
            SampledPeriodicSystem(FourierSeries.constant(matrix), period),
            FourierSeries.constant(np.concatenate([nothing, solved[:, -1]])),
            FourierSeries.constant(np.concatenate([reading, nothing])),
            FourierSeries.constant(np.zeros(())),
        )

    @property
    def turning(self) -> float:
        """``W`` in rad/s."""
        return 2 * np.pi / self.system.period


def harmonic_response(
    forced: ForcedPeriodicSystem, frequency: ArrayLike, orders: ArrayLike, steps: int
) -> ComplexArray:
    """Harmonic transfer functions by the propagator.

    Parameters
    ----------
    forced : ForcedPeriodicSystem
    frequency : array_like, shape (F,)
        Frequency of the input, in Hz.
    orders : array_like of int, shape (O,)
        ``n``: the output is that at the input's frequency and n times ``1 / T``.
    steps : int
        Steps of the propagator a period; they resolve the fastest mode. A constant system is solved
        exactly whatever the steps.

    Returns
    -------
    ndarray of complex, shape (O, F)
        Output over input; phases count from the start of the period.

    Raises
    ------
    InputError
        If a frequency is not finite, or the steps are no count.
    ComputationError
        If vibrations grow beyond all numbers within a turn.

    Examples
    --------
    >>> from flexmech.dynamical_systems import ForcedPeriodicSystem, harmonic_response
    >>> one = np.eye(1)
    >>> oscillator = ForcedPeriodicSystem.constant(one, 0.1 * one, 4 * one, one[0], one[0], 1.0)
    >>> response = harmonic_response(oscillator, [0.0], [0, 1], 16)
    >>> [round(float(abs(value)), 12) for value in response[:, 0]]
    [0.25, 0.0]
    """
    input_rate, wanted = _checked(frequency, orders)
    check_count(steps, "steps")
    if forced.system.is_constant:
        return _of_constant_matrix(forced, input_rate, wanted)
    march = _march(forced, steps)
    answer = np.empty((len(wanted), len(input_rate)), dtype=complex)
    for first in range(0, len(input_rate), BATCH):
        columns = slice(first, first + BATCH)
        answer[:, columns] = march(input_rate[columns])[wanted % steps]
    if not np.isfinite(answer).all():
        raise ComputationError(
            "vibrations grow beyond all numbers within a turn; take more damping, or a higher "
            "crank speed"
        )
    return answer + _harmonics(forced.residual, wanted)[:, None]


@dataclass(frozen=True)
class _Pushed(PeriodicSystem):
    """The system with u and its derivatives as further states, ``u' = u_1 / h, u_1' = u_2 / h``.

    Parameters
    ----------
    period : float
        In s.
    forced : ForcedPeriodicSystem
    step : float
        h in s.
    """

    period: float
    forced: ForcedPeriodicSystem
    step: float

    def matrices(self, count: int, shift: float, which: slice = slice(None)) -> FloatArray:
        """Matrices at the times ``(k + shift) period / count``, or at a part of them."""
        system_matrices = self.forced.system.matrices(count, shift, which)
        size = system_matrices.shape[1]
        chain = np.arange(size, size + POINTS)
        extended = np.zeros((len(system_matrices), size + POINTS, size + POINTS))
        extended[:, :size, :size] = system_matrices
        extended[:, :size, size] = self.forced.force.samples(count, shift, which)
        extended[:, chain[:-1], chain[1:]] = 1 / self.step
        return extended


def _march(forced: ForcedPeriodicSystem, steps: int) -> Callable[[FloatArray], ComplexArray]:
    """Solve the steps of a period once for all frequencies.

    The result gives harmonics (N, F) of the answer to forces of circular frequencies (F,) in rad/s.
    """
    size, step = forced.system.size, forced.system.period / steps
    whole = transition_matrices(_Pushed(forced.system.period, forced, step), steps)
    # Derivatives at the start of a step, in lengths of it, of the polynomial through values.
    powers = np.linalg.inv(np.vander(np.arange(POINTS) / (POINTS - 1), increasing=True))
    derivatives = powers * [[factorial(j)] for j in range(POINTS)]
    transitions = whole[:, :size, :size].copy()
    # The state at a step's end by the force at each of its points.
    pushed = (whole[:, :size, size:] @ derivatives).reshape(-1, POINTS)
    reading = forced.reading.samples(steps)

    def harmonics(rate: FloatArray) -> ComplexArray:
        phase = np.exp(1j * np.outer(np.arange(POINTS) / (POINTS - 1), rate * step))
        back = 1 / phase[-1]
        push = (pushed @ phase).reshape(steps, size, -1) * back
        with np.errstate(over="ignore", invalid="ignore"):
            state, turned = np.zeros((size, len(rate)), dtype=complex), np.eye(size)
            for transition, input_push in zip(transitions, push, strict=True):
                state = _times(transition, state) * back + input_push
                turned = transition @ turned
            closed = np.eye(size) - back[:, None, None] ** steps * turned
            state = np.linalg.solve(closed, state.T[..., None])[..., 0].T
            read = np.empty((steps, len(rate)), dtype=complex)
            for number, (transition, input_push) in enumerate(zip(transitions, push, strict=True)):
                read[number] = reading[number] @ state
                state = _times(transition, state) * back + input_push
        return np.asarray(np.fft.fft(read, axis=0) / steps)

    return harmonics


def _times(matrix: FloatArray, vectors: ComplexArray) -> ComplexArray:
    """Product of a real matrix with complex vectors (n, F): of both parts at once."""
    return np.asarray((matrix @ np.ascontiguousarray(vectors).view(float)).view(complex))


def balanced_response(
    forced: ForcedPeriodicSystem, frequency: ArrayLike, orders: ArrayLike, harmonics: int
) -> ComplexArray:
    """Harmonic transfer functions by harmonic balance.

    ``i (w + k W) X_k - sum_l A_(k - l) X_l = b_k`` for k and l from ``-harmonics`` to
    ``harmonics``: Hill's matrix, cut off. It knows neither steps nor modes.

    Parameters
    ----------
    forced : ForcedPeriodicSystem
    frequency : array_like, shape (F,)
        Frequency of the input, in Hz.
    orders : array_like of int, shape (O,)
    harmonics : int

    Returns
    -------
    ndarray of complex, shape (O, F)

    Raises
    ------
    InputError
        If a frequency is not finite, or the harmonics are no count.
    """
    input_rate, wanted = _checked(frequency, orders)
    check_count(harmonics, "harmonics")
    number = np.arange(-harmonics, harmonics + 1)
    size = forced.system.size
    rows = len(number) * size
    hill = _harmonics(forced.system.matrix, number[:, None] - number)
    hill = hill.transpose(0, 2, 1, 3).reshape(rows, rows)
    force = _harmonics(forced.force, number).reshape(rows)
    reading = _harmonics(forced.reading, wanted[:, None] - number).reshape(len(wanted), rows)
    place = np.arange(rows)
    answer = np.empty((len(wanted), len(input_rate)), dtype=complex)
    for column, rate in enumerate(input_rate):
        matrix = -hill
        matrix[place, place] += 1j * (rate + forced.turning * np.repeat(number, size))
        answer[:, column] = reading @ np.linalg.solve(matrix, force)
    return answer + _harmonics(forced.residual, wanted)[:, None]


def _checked(frequency: ArrayLike, orders: ArrayLike) -> tuple[FloatArray, IntArray]:
    """Input's circular frequency (F,) in rad/s, and orders (O,)."""
    values = np.atleast_1d(checked_array(frequency, "frequency", "Hz"))
    return 2 * np.pi * values, np.atleast_1d(np.asarray(orders, dtype=np.intp))


def _of_constant_matrix(
    forced: ForcedPeriodicSystem, input_rate: FloatArray, wanted: IntArray
) -> ComplexArray:
    """By the resolvent of A alone: each harmonic of the force is answered at its own frequency."""
    matrix = forced.system.matrix.coefficients[0]
    unit = np.eye(len(matrix))
    number = np.arange(-forced.force.harmonics, forced.force.harmonics + 1)
    force = _harmonics(forced.force, number)
    reading = _harmonics(forced.reading, wanted[:, None] - number)
    answer = np.zeros((len(wanted), len(input_rate)), dtype=complex)
    for column, order in enumerate(number):
        rate = input_rate + order * forced.turning
        states = np.linalg.solve(
            1j * rate[:, None, None] * unit - matrix,
            np.broadcast_to(force[column][:, None], (len(rate), len(unit), 1)),
        )
        answer += reading[:, column] @ states[..., 0].T
    return answer + _harmonics(forced.residual, wanted)[:, None]


def _harmonics(series: FourierSeries, number: IntArray) -> ComplexArray:
    """Coefficients of ``exp(2 pi i number phase)``, zero beyond the last; (*number, ...)."""
    place = np.minimum(np.abs(number), series.harmonics)
    coefficients = series.coefficients[place]
    coefficients = np.where(_beside(number >= 0, coefficients), coefficients, coefficients.conj())
    return np.where(_beside(np.abs(number) <= series.harmonics, coefficients), coefficients, 0.0)


def _beside(chosen: NDArray[np.bool_], values: ComplexArray) -> NDArray[np.bool_]:
    """Axes of length one after those of a choice, so that it is one among the values."""
    return chosen.reshape(*chosen.shape, *(1,) * (values.ndim - chosen.ndim))
