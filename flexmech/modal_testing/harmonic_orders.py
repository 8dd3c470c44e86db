"""Harmonic transfer functions from impacts on a periodic system.

An impact whose force has the spectrum P is answered at the frequency v by all orders at once,
``Y(v) = sum_n H_n(v - n F) P(v - n F)``, with the frequency F at which the system repeats itself
and times that count from the start of one of its periods. Impacts at as many places of the
period as there are orders tell them apart: the unknowns ``H_n(v - n F)`` follow by least squares.

A simulated hammer test of a running linkage has a twin run without impact. A laboratory has none,
but what the linkage does in every turn is known from the turns in which nothing was hit: the
synchronous average. Source: S. G. Braun, *The extraction of periodic waveforms by time domain
averaging*, Acustica 32 (1975), 69-77.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.validation import check_count

# Condition number of the equations above which impacts do not tell the orders apart: noise of a per
# mille would be as great as the answer.
WORST_CONDITION = 1e3


@dataclass(frozen=True)
class HarmonicEstimate:
    """Harmonic transfer functions of the orders -N to N at the bins 0 to B - 1 of the input.

    Parameters
    ----------
    response : ndarray of complex, shape (2 N + 1, B)
    condition : float
        Greatest condition number of the equations of any frequency; their columns are scaled to
        the same length.
    misfit : float
        What the orders leave of the responses, over these, by root mean square: the orders
        beyond N, noise, and what is not linear. Zero where there are no more impacts than orders.
    """

    response: ComplexArray
    condition: float
    misfit: float


def estimate_harmonics(
    force: ComplexArray, response: ComplexArray, *, highest_order: int, shift: int, bins: int
) -> HarmonicEstimate:
    """Least squares over impacts at each frequency of the response.

    Parameters
    ----------
    force, response : ndarray of complex, shape (R, M)
        Fourier integrals of R impacts and of what they add to the response, at the bins 0 to
        M - 1 of real records; times count from the start of a period.
    highest_order : int
        N.
    shift : int
        Bins of the frequency at which the system repeats itself: the periods in a record.
    bins : int
        B, at most M - 2 N ``shift``.

    Returns
    -------
    HarmonicEstimate

    Raises
    ------
    InputError
        If there are fewer impacts than orders, bins beyond the record's last, or impacts that
        do not tell the orders apart.
    """
    orders = np.arange(-highest_order, highest_order + 1)
    count, reach = force.shape[1], highest_order * shift
    if len(force) < len(orders):
        raise InputError(
            f"{len(force)} impacts cannot tell {len(orders)} orders apart; give one impact or more "
            "for each order"
        )
    # The last bin of the response takes input from as many bins beyond it.
    if (needed := bins + 2 * reach) > count:
        raise InputError(
            f"{bins} bins of the input and {highest_order} orders need {needed} bins of the "
            f"records, which have {count}; sample them more often"
        )
    output = np.arange(-reach, bins + reach)
    entering = output[:, None] - shift * orders
    matrix = np.moveaxis(_at(force, entering), 0, 1)
    size = np.linalg.norm(matrix, axis=1, keepdims=True)
    scaled = matrix / np.where(size == 0, 1.0, size)
    condition = float(np.linalg.cond(scaled).max())
    if not condition < WORST_CONDITION:
        raise InputError(
            f"the impacts do not tell the orders apart (condition number {condition:.3g}); spread "
            "them over the period"
        )
    measured = _at(response, output).T[..., None]
    coefficients = np.linalg.pinv(scaled) @ measured
    rest = measured - scaled @ coefficients
    misfit = float(np.linalg.norm(rest) / np.linalg.norm(measured))
    coefficients = coefficients[..., 0] / size[:, 0]
    place = np.arange(bins) + reach + shift * orders[:, None]
    answer = coefficients[place, np.arange(len(orders))[:, None]]
    return HarmonicEstimate(answer, condition, misfit if len(force) > len(orders) else 0.0)


def _at(spectrum: ComplexArray, number: np.ndarray) -> ComplexArray:
    """Spectrum of real records at bins of either sign; (R, *number)."""
    values = spectrum[:, np.abs(number)]
    return np.where(number >= 0, values, values.conj())


def without_synchronous_average(
    record: FloatArray, samples_a_period: int, quiet: NDArray[np.bool_]
) -> FloatArray:
    """Take off a record what it repeats in every period.

    Parameters
    ----------
    record : ndarray, shape (..., N)
        Sampled at equal steps of the crank angle: a record over time is interpolated to them first.
    samples_a_period : int
        P; a period is a turn of the crank.
    quiet : ndarray of bool, shape (N,)
        Samples at which nothing but the periodic motion is seen: before the impact, or so long
        after it that it has decayed. The more periods they are, the less noise the average adds.

    Returns
    -------
    ndarray, shape (..., N)
        The record less the mean of its quiet samples at the same place of the period.

    Raises
    ------
    InputError
        If the record holds values that are not finite, or a place of the period has no quiet
        sample.

    Examples
    --------
    >>> turn = np.array([0.0, 2.0, 1.0])
    >>> record = np.concatenate([turn, turn + [0.0, 0.5, -0.5]])
    >>> flexmech.modal_testing.without_synchronous_average(record, 3, np.arange(6) < 3)
    array([ 0. ,  0. ,  0. ,  0. ,  0.5, -0.5])
    """
    check_count(samples_a_period, "samples_a_period")
    record, quiet = np.asarray(record, dtype=float), np.asarray(quiet, dtype=bool)
    count = record.shape[-1]
    if quiet.shape != (count,):
        raise InputError(f"quiet has the shape {quiet.shape}; give one value for each of {count}")
    if not np.all(np.isfinite(record)):
        raise InputError("the record holds values that are not finite; cut or fill such gaps")
    place = np.arange(count) % samples_a_period
    number = np.bincount(place[quiet], minlength=samples_a_period)
    if not number.all():
        raise InputError(
            f"{np.count_nonzero(number == 0)} of {samples_a_period} places of the period have no "
            "quiet sample; give a record with at least one period that is free of the impact"
        )
    by_place = record[..., quiet][..., np.argsort(place[quiet], kind="stable")]
    sums = np.add.reduceat(by_place, np.cumsum(number) - number, axis=-1)
    return np.asarray(record - (sums / number)[..., place])
