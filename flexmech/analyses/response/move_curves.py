"""Residual vibration over the time of a move, between the times that are run.

What the start of a law and its other corners excite reaches the stop with a phase that goes with
the time of the move, so that the amplitude of a mode of frequency f rises and falls within 1/f of
that time. Its complex amplitude has phases between none and ``2 pi f T`` alone: with half of it
taken off, it is smooth over a third of a period, and a cubic spline tells it between the times
(sampling of a band, R. N. Bracewell, *The Fourier Transform and Its Applications*, 3rd ed. 2000,
ch. 10).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.arrays import FloatArray

# Times of the move in a period of a mode, by which its amplitude is known between them: of an arm
# after a cycloid within 1 % of the greatest.
TIMES_PER_PERIOD = 3.0
# Points of a curve in a period of the highest mode: its valleys are seen.
_POINTS_PER_PERIOD = 24
# Fewer times make no spline.
_LEAST_TIMES = 4


def are_resolved(times: FloatArray, frequency: FloatArray) -> NDArray[np.bool_]:
    """Whether the times of a move are near enough to each other for each mode.

    Parameters
    ----------
    times : ndarray, shape (n,)
        In s, increasing.
    frequency : ndarray, shape (m,)
        In Hz.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    if len(times) < _LEAST_TIMES:
        return np.zeros(len(frequency), dtype=bool)
    apart = float(np.diff(times).max())
    return np.asarray(frequency * apart * TIMES_PER_PERIOD <= 1 + 1e-9)


def curve_variables(
    times: FloatArray,
    whole: FloatArray,
    amplitude: NDArray[np.complex128],
    frequency: FloatArray,
) -> xr.Dataset:
    """Amplitudes over the time of a move as curves, of the modes that its times resolve.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Of the move in s, increasing.
    whole : ndarray, shape (n_laws, n)
        Time until the stop in s, a shaper's included.
    amplitude : ndarray of complex, shape (n_laws, n, n_links, m)
        In m.
    frequency : ndarray, shape (m,)
        In Hz.

    Returns
    -------
    xarray.Dataset
        ``move_curve`` over (law, curve_move_time, link, curve_mode) in m, and
        ``curve_whole_time`` over (law, curve_move_time) in s; empty where no mode is resolved.
    """
    from scipy.interpolate import CubicSpline

    modes = np.flatnonzero(are_resolved(times, frequency))
    if not modes.size:
        return xr.Dataset()
    count = _POINTS_PER_PERIOD * float(np.ptp(times)) * float(frequency[modes].max())
    places = np.union1d(times, np.linspace(times[0], times[-1], int(np.ceil(count)) + 1))
    half_phase = np.exp(-1j * np.pi * np.multiply.outer(times, frequency[modes]))
    spline = CubicSpline(times, amplitude[..., modes] * half_phase[None, :, None], axis=1)
    over = ("law", "curve_move_time", "link", "curve_mode")
    return xr.Dataset(
        {
            "move_curve": (over, np.abs(spline(places))),
            "curve_whole_time": (
                ("law", "curve_move_time"),
                np.stack([np.interp(places, times, own) for own in whole]),
            ),
        },
        coords={"curve_move_time": places, "curve_mode": modes + 1},
    )
