r"""Poles by peaks and circles, with nothing but NumPy and SciPy.

Near its resonance a mode draws a circle in the Nyquist diagram of the receptance,

.. math:: H_p(s) = \frac{A_p}{s - \lambda} + B_p + C_p s,

moved by what the other modes give there. Multiplied by ``s - lambda`` this is linear in the pole
and in three more numbers a point. The fit is repeated with the last pole in the weights, so that
errors of the receptance count and not errors of the product; and mode after mode with the circles
of all others taken off first. Sources: C. C. Kennedy and C. D. P. Pancu, Journal of the
Aeronautical Sciences 14 (1947), 603-625; C. K. Sanathanan and J. Koerner, IEEE Transactions on
Automatic Control 8 (1963), 56-58.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import find_peaks

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.modal_testing.identified import fit_residues, modal_sum

# Of a peak over the valleys beside it, as a factor of amplitude: that of ripples by noise of a few
# per cent is 1.1.
LEAST_PROMINENCE = 2.0
# Half width of what is fitted, in half-power widths of the peak: nine tenths of the circle.
WIDTH = 3.0
# Frequencies that are fitted at least: 18 numbers at each point for eight unknowns.
LEAST_LINES = 9
# In lines, of what is tried for the first circle of a peak: from the least number on, and doubled.
HALF_WIDTHS = (4, 8, 16, 32)
# Of what stands out at a peak: noise is no circle.
LEAST_EXPLAINED = 0.5
# A bound of work alone: all poles are refined together afterwards.
MOST_ROUNDS = 20
# Relative change of the poles in a round. They are refined together afterwards, but where noise
# hides a weak mode the result depends on the start: bias and scatter over a hundred noisy records
# change by a tenth and more with 1e-4.
CONVERGED = 1e-7
# Of Sanathanan and Koerner's iteration, whose weight needs the pole that it leads to: this pole
# serves as a start alone.
WEIGHT_ROUNDS = 4


def peaks(frequency: FloatArray, receptance: ComplexArray) -> IntArray:
    """Peaks of the root mean square mobility over all points, those of greatest prominence first.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz.
    receptance : ndarray of complex, shape (points, F)

    Returns
    -------
    ndarray of int, shape (k,)
        Indices into the frequencies.
    """
    amplitude = frequency * np.sqrt(np.mean(abs(receptance) ** 2, axis=0))
    level = np.log(np.maximum(amplitude, np.finfo(float).tiny))
    found, about = find_peaks(level, prominence=np.log(LEAST_PROMINENCE))
    return np.asarray(found[np.argsort(-about["prominences"], kind="stable")])


def highest_near(
    frequency: FloatArray, receptance: ComplexArray, about: float, width: float, most: int
) -> IntArray:
    """A frequency's own place, and the highest ones of the mobility near it.

    The mobility is smoothed, so that noise hides its heights less.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz.
    receptance : ndarray of complex, shape (points, F)
    about : float
        In Hz.
    width : float
        Relative, to either side.
    most : int
        Places at most.

    Returns
    -------
    ndarray of int, shape (k,)
        Indices into the frequencies.
    """
    energy = frequency**2 * np.mean(abs(receptance) ** 2, axis=0)
    smooth = uniform_filter1d(energy, LEAST_LINES)
    near = np.flatnonzero(abs(frequency - about) < width * about)
    if near.size == 0:
        return near
    found, _ = find_peaks(smooth[near])
    highest = near[found[np.argsort(-smooth[near][found], kind="stable")][:most]]
    # Of two modes that make one peak, one has no height of its own.
    return np.unique(np.append(highest, np.argmin(abs(frequency - about))))


def circle_fit_poles(
    frequency: FloatArray, receptance: ComplexArray, at: IntArray, added_damping: float
) -> ComplexArray:
    """Fit the poles of some peaks, in turn until none moves.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz, above 0, evenly spaced.
    receptance : ndarray of complex, shape (points, F)
    at : ndarray of int, shape (k,)
        Where the peaks are.
    added_damping : float
        Decay rate of the exponential window in 1/s, which the receptances hold.

    Returns
    -------
    ndarray of complex, shape (k,)
        Poles in 1/s, free of what the window added; not a number where no circle was found.
    """
    s = added_damping + 2j * np.pi * frequency
    step = frequency[1] - frequency[0]
    pole = np.full(len(at), np.nan, dtype=np.complex128)
    home: list[IntArray] = []
    for number, one in enumerate(at.tolist()):
        pole[number], lines = _first_circle(frequency, s, receptance, one)
        home.append(lines)
    for _ in range(MOST_ROUNDS):
        before = pole.copy()
        for number in np.flatnonzero(np.isfinite(pole)).tolist():
            known = np.flatnonzero(np.isfinite(pole))
            others = known[known != number]
            residue, _ = fit_residues(s, receptance, pole[known])
            rest = receptance - modal_sum(s, pole[others], residue[:, known != number])
            width = WIDTH * (added_damping - pole[number].real) / (np.pi * step)
            near = _around(
                int(np.argmin(abs(s.imag - pole[number].imag))),
                max(int(np.ceil(width)), LEAST_LINES // 2),
                s.size,
            )
            pole[number], _ = _circle(s[near], rest[:, near], pole[number])
            # A pole that has left its peak is none, and shall not spoil the others.
            if not _at_home(pole[number], s[home[number]]):
                pole[number] = np.nan
        with np.errstate(invalid="ignore"):
            moved = abs(pole - before) > CONVERGED * abs(before)
        if not np.any(moved):
            break
    return pole


def _first_circle(
    frequency: FloatArray, s: ComplexArray, receptance: ComplexArray, at: int
) -> tuple[complex, IntArray]:
    """The pole of a peak from its own lines alone, as few of them as show a circle."""
    # As wide as the distance of two lines: this pole serves the weights alone.
    first = 2j * np.pi * frequency[at] - np.pi * (frequency[1] - frequency[0])
    lines = _around(at, LEAST_LINES // 2, s.size)
    for half in HALF_WIDTHS:
        lines = _around(at, half, s.size)
        pole, explained = _circle(s[lines], receptance[:, lines], first)
        if explained >= LEAST_EXPLAINED and _at_home(pole, s[lines]):
            return pole, lines
    return complex(np.nan, np.nan), lines


def _around(centre: int, half: int, size: int) -> IntArray:
    return np.arange(max(centre - half, 0), min(centre + half + 1, size), dtype=np.intp)


def _at_home(pole: complex, s: ComplexArray) -> bool:
    """Whether a pole decays, the window's part included, and lies among the lines of its peak."""
    return bool(s.imag[0] <= pole.imag <= s.imag[-1] and pole.real < s.real[0])


def _circle(s: ComplexArray, receptance: ComplexArray, pole: complex) -> tuple[complex, float]:
    """Fit one pole to all points with a constant and a linear background each.

    Gives the pole, and the part of what the background leaves that the circle explains.
    """
    centre, span = s[s.size // 2], abs(s[-1] - s[0])
    x = (s - centre) / span
    shapes = np.stack([np.ones_like(x), x, x**2], axis=1)
    explained = 0.0
    for _ in range(WEIGHT_ROUNDS):
        weight = 1.0 / abs(s - pole)
        # The background is solved for at each point, and the pole with what it leaves of all.
        basis, _ = np.linalg.qr(shapes * weight[:, None])
        values = (receptance * weight).T
        moments = x[:, None] * values
        values = values - basis @ (basis.conj().T @ values)
        moments = moments - basis @ (basis.conj().T @ moments)
        power = float(np.sum(abs(values) ** 2))
        total = float(np.sum(abs(moments) ** 2))
        if power == 0.0 or total == 0.0:
            return complex(np.nan, np.nan), 0.0
        place = np.sum(values.conj() * moments) / power
        explained = 1.0 - float(np.sum(abs(moments - place * values) ** 2)) / total
        pole = complex(centre + span * place)
    return pole, explained
