"""Whether a record is evenly sampled: gaps and unequal steps are found and named."""

from __future__ import annotations

import numpy as np

from flexmech.errors import InputError
from flexmech.types import FloatArray

# Part of the step by which one step may differ from the others, besides the rounding of the file.
JITTER = 0.02
# A step of so many others is a gap if it is a whole number of them within this part of a step.
WHOLE = 0.1


def sampling_interval(time: FloatArray, source: str = "record", rounding: float = 0.0) -> float:
    """Step of an evenly sampled record.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    source : str
        File that messages name.
    rounding : float
        Value in s of the last digit that the file writes.

    Returns
    -------
    float
        In s: the length of the record over the number of its steps.

    Raises
    ------
    InputError
        If the time does not increase, samples are missing, or steps are unequal.
    """
    steps = np.diff(time)
    wrong = np.flatnonzero(steps <= 0)
    if len(wrong):
        raise InputError(
            f"{source}: time goes from {time[wrong[0]]:.9g} s to {time[wrong[0] + 1]:.9g} s, and "
            "must increase; if the file holds several runs, such as those of two engines, keep one"
        )
    usual = float(np.median(steps))
    allowed = JITTER * usual + 1.01 * rounding
    uneven = np.flatnonzero(np.abs(steps - usual) > allowed)
    if len(uneven):
        first = int(uneven[0])
        times = steps[first] / usual
        place = f"from {time[first]:.9g} s to {time[first + 1]:.9g} s"
        missing = round(float(times)) - 1
        if missing >= 1 and abs(times - missing - 1) < WHOLE:
            raise InputError(
                f"{source}: has a gap: {missing} samples of every {usual:.6g} s are missing "
                f"{place}; give a part of the record without gaps"
            )
        raise InputError(
            f"{source}: steps are unequal: one is {steps[first]:.6g} s, {place}, the others "
            f"{usual:.6g} s; resample the record to equal steps, with the filter that this needs"
        )
    return float(time[-1] - time[0]) / (len(time) - 1)
