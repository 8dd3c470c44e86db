"""Peaks of histories, found between their samples."""

from __future__ import annotations

import numpy as np

from flexmech.types import FloatArray


def peaks_between(values: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Greatest size of each history, and where it is.

    The vertex of the parabola through the greatest sample and its neighbours; a peak at an end
    of the history is the sample there.

    Parameters
    ----------
    values : ndarray, shape (N, k)
        Evenly sampled.
    place : ndarray, shape (N,)
        Time or crank angle of the samples.

    Returns
    -------
    size, where : ndarray, shape (k,)

    Examples
    --------
    >>> time = np.arange(8.0)
    >>> size, where = peaks_between(-np.cos(0.4 * time - 1.3)[:, None], time)
    >>> size.round(3), where.round(2)
    (array([1.]), array([3.25]))
    """
    size = np.abs(values)
    columns, number = np.arange(values.shape[1]), size.argmax(axis=0)
    if len(values) < 3:
        return size[number, columns], place[number]
    inner = np.clip(number, 1, len(values) - 2)
    before, at, after = (size[inner + step, columns] for step in (-1, 0, 1))
    slope, bend = (after - before) / 2, before - 2 * at + after
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where((bend < 0) & (number == inner), -slope / bend, 0.0)
    spacing = np.where(shift > 0, place[inner + 1] - place[inner], place[inner] - place[inner - 1])
    rounded = at + slope * shift / 2
    return (
        np.where(number == inner, rounded, size[number, columns]),
        np.where(number == inner, place[inner] + shift * spacing, place[number]),
    )
