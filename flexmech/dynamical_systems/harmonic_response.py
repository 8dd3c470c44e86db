"""Response of a periodic system to a harmonic force: harmonic transfer functions.

A force ``exp(i w t)`` on ``x' = A(t) x + b(t) u`` whose matrices repeat themselves with the
frequency ``W = 2 pi / T`` answers, once what is free has died out, at ``w + n W`` for every order
n. The amplitudes are the harmonic transfer functions H_n(w) (N. M. Wereley & S. R. Hall, Frequency
response of linear time periodic systems, 29th IEEE Conference on Decision and Control (1990)
3650-3655; N. M. Wereley, thesis, MIT 1991). They follow from the one solution with
``x(T) = exp(i w T) x(0)``. In the Floquet modes ``x = Phi(t) z``, which the
propagator of :mod:`flexmech.dynamical_systems.floquet` gives, that solution is known harmonic by
harmonic::

    z_j' = lambda_j z_j + beta_j(t) exp(i w t),   beta = Phi^-1 b,   gamma = c Phi

    H_n(w) = sum_j sum_k gamma_(j, n - k) beta_(j, k) / (i (w + k W) - lambda_j) + R_n

with the Fourier coefficients of beta, gamma and of the static answer R of what the states leave
out. Harmonic balance, which balances the harmonics of x themselves, is another way to the same
numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.dynamical_systems.floquet import floquet_modes
from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.dynamical_systems.periodic_system import SampledPeriodicSystem
from flexmech.errors import ComputationError
from flexmech.validation import check_count, checked_array

# Frequencies whose answers are in memory at a time. Memory alone: with some thousand harmonics and
# modes, 4 MB.
BATCH = 256


@dataclass(frozen=True)
class ForcedPeriodicSystem:
    """``x' = A(t) x + b(t) u``, ``y = c(t) x + r(t) u`` with one input and one output.

    Parameters
    ----------
    system : SampledPeriodicSystem
        Of A, (n, n).
    force : FourierSeries
        Of b, (n,).
    reading : FourierSeries
        Of c, (n,).
    residual : FourierSeries
        Of r, (): the static answer of what the states leave out.
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
        Of the input, in Hz.
    orders : array_like of int, shape (O,)
        ``n``: the output is that at the input's frequency and n times ``1 / T``.
    steps : int
        Of the propagator a period; they resolve the fastest mode. A constant system is solved
        exactly whatever the steps. Two modes that coincide, as at the edge of a band of growing
        vibrations, cost half of the digits.

    Returns
    -------
    ndarray of complex, shape (O, F)
        Output over input; phases count from the start of the period.

    Raises
    ------
    InputError
        If a frequency is not finite, or the steps are no count.
    ComputationError
        If the steps are too few for the propagator, or damping is so strong that Floquet modes
        cannot be told.

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
    modes = floquet_modes(forced.system, steps)
    with np.errstate(all="ignore"):
        shapes = modes.shapes()
    if not np.isfinite(shapes).all():
        raise ComputationError(
            "vibrations die out so far within a turn that the shapes of their Floquet modes are "
            "beyond all numbers; ask for fewer modes (of a hammer test: a narrower --bandwidth) "
            "or for less damping"
        )
    into = _centred(np.linalg.solve(shapes, forced.force.samples(steps)[..., None])[..., 0])
    out = _centred(np.einsum("ks,ksj->kj", forced.reading.samples(steps), shapes))
    harmonic, weight = _weights(into, out, wanted)
    # All pairs of a harmonic and a mode that count for any order, in one row.
    counts = np.abs(weight).max(axis=0) > np.finfo(float).eps * np.abs(weight).max()
    pole = (modes.exponent - 1j * forced.turning * harmonic[:, None])[counts]
    weight = weight[:, counts]
    answer = np.empty((len(wanted), len(input_rate)), dtype=complex)
    for first in range(0, len(input_rate), BATCH):
        some = slice(first, first + BATCH)
        answer[:, some] = weight @ (1.0 / (1j * input_rate[some] - pole[:, None]))
    return answer + _harmonics(forced.residual, wanted)[:, None]


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
        Of the input, in Hz.
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
    own = series.coefficients[place]
    own = np.where(_beside(number >= 0, own), own, own.conj())
    return np.where(_beside(np.abs(number) <= series.harmonics, own), own, 0.0)


def _beside(chosen: NDArray[np.bool_], values: ComplexArray) -> NDArray[np.bool_]:
    """Axes of length one after those of a choice, so that it is one among the values."""
    return chosen.reshape(*chosen.shape, *(1,) * (values.ndim - chosen.ndim))


def _centred(samples: NDArray[Any]) -> ComplexArray:
    """Fourier coefficients (N, n) of samples over the period, from -N/2 on."""
    return np.asarray(np.fft.fftshift(np.fft.fft(samples, axis=0), axes=0) / len(samples))


def _weights(
    into: ComplexArray, out: ComplexArray, wanted: IntArray
) -> tuple[IntArray, ComplexArray]:
    """Harmonics k (N,), and ``gamma_(j, n - k) beta_(j, k)`` of the orders, (O, N, n)."""
    count = len(into)
    number = np.arange(count) - count // 2
    place = wanted[:, None] - number + count // 2
    inside = (place >= 0) & (place < count)
    weight = np.where(inside[..., None], out[np.clip(place, 0, count - 1)], 0.0) * into
    return number, weight
