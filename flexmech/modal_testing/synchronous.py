"""What a running machine repeats in every period, taken off its records.

A simulated hammer test of a running linkage has a twin run without impact. A laboratory has none,
but what the linkage does in every turn is known from the turns in which nothing was hit: the
synchronous average. Source: S. G. Braun, *The extraction of periodic waveforms by time domain
averaging*, Acustica 32 (1975), 69-77.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.numbers import check_count
from flexmech.types import FloatArray


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
