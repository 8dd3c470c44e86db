r"""Identification of modes from measured receptances: poles by LSCF, or by peaks and circles.

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

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import uniform_filter1d
from scipy.optimize import linear_sum_assignment
from scipy.signal import find_peaks

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.modal_testing.identified import IdentifiedModes, fit_residues, modal_sum
from flexmech.modal_testing.lscf import has_lscf, lscf_poles, stabilisation_chart
from flexmech.modal_testing.noise import FrfNoise
from flexmech.modal_testing.refine import pole_covariance, refined_poles, significant_poles

# Least prominence of a peak over the valleys beside it, as a factor of amplitude: that of ripples
# by noise of a few per cent is 1.1.
LEAST_PROMINENCE = 2.0
# Half width of what is fitted, in half-power widths of the peak: nine tenths of the circle.
WIDTH = 3.0
# Frequencies that are fitted at least: 18 numbers at each point for eight unknowns.
LEAST_CIRCLE_LINES = 9
# In lines, of what is tried for the first circle of a peak: from the least number on, and doubled.
HALF_WIDTHS = (4, 8, 16, 32)
# Least part explained of what stands out at a peak: noise is no circle.
LEAST_EXPLAINED = 0.5
# A bound of work alone: all poles are refined together afterwards.
MOST_ROUNDS = 20
# Relative change of the poles in a round. They are refined together afterwards, but where noise
# hides a weak mode the result depends on the start: bias and scatter over a hundred noisy records
# change by a tenth and more with 1e-4.
CONVERGED = 1e-7
# Rounds of Sanathanan and Koerner's iteration, whose weight needs the pole that it leads to:
# this pole serves as a start alone.
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
    places, about = find_peaks(level, prominence=np.log(LEAST_PROMINENCE))
    return np.asarray(places[np.argsort(-about["prominences"], kind="stable")])


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
    smooth = uniform_filter1d(energy, LEAST_CIRCLE_LINES)
    near = np.flatnonzero(abs(frequency - about) < width * about)
    if near.size == 0:
        return near
    maxima, _ = find_peaks(smooth[near])
    highest = near[maxima[np.argsort(-smooth[near][maxima], kind="stable")][:most]]
    # Where two modes make one peak, one has no height of its own.
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
                max(int(np.ceil(width)), LEAST_CIRCLE_LINES // 2),
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
    lines = _around(at, LEAST_CIRCLE_LINES // 2, s.size)
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


IdentificationMethod = Literal["lscf", "circle-fit"]

# Highest number of modes of the models of LSCF: a mode is stable in a fifth of the orders at least,
# which are six then.
ORDERS = 30
# Frequencies in the band that a fit needs: of one point 32 numbers, for the 12 unknowns of a mode
# with the residual terms.
LEAST_LINES = 16
# Part of the greatest receptance: a peak that is left above it is a mode that LSCF has missed.
PEAK_LEFT = 0.1
# Peaks that are tried, the most prominent ones: altogether, and near an expected mode. A bound of
# work: those of noise are dropped afterwards.
MOST_PEAKS, MOST_NEAR = 20, 3
# Part of half their half-power width: poles so near to each other are one.
TOGETHER = 0.2
# Relative: an expected mode is one that is found so near in frequency.
NEAR = 0.05


def best_method() -> IdentificationMethod:
    """``"lscf"`` where its package is installed (extra ``modal-test``), or ``"circle-fit"``."""
    return "lscf" if has_lscf() else "circle-fit"


def identify(
    frequency: FloatArray,
    receptance: ComplexArray,
    *,
    band: tuple[float, float] | None = None,
    count: int | None = None,
    expected: ArrayLike | None = None,
    method: IdentificationMethod | None = None,
    added_damping: float = 0.0,
    noise: FrfNoise | None = None,
    orders: int = ORDERS,
) -> IdentifiedModes:
    """Identify modes from receptances of one impact point (or, as well, of one response point).

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz, evenly spaced multiples of their step.
    receptance : ndarray of complex, shape (points, F)
        Displacement over force in m/N; one function may be of shape (F,).
    band : tuple of float, optional
        In Hz, from and to: what is fitted. Without it all frequencies above 0.
    count : int, optional
        The lowest so many modes alone.
    expected : array_like, shape (k,), optional
        Frequencies in Hz, such as those of a model. The answer has one mode for each, not a number
        where none was found within 5 %.
    method : {"lscf", "circle-fit"}, optional
        Without it that of :func:`best_method`.
    added_damping : float
        Decay rate in 1/s of the exponential window: it is taken off.
    noise : FrfNoise, optional
        How noise of the records stands in the receptances, as :func:`estimate_frf` knows it: by it
        modes are distinguished from noise, and poles have standard errors. Without it, white noise
        of the response under a force that excites all frequencies alike.
    orders : int
        Highest number of modes of a model, for ``"lscf"``.

    Returns
    -------
    IdentifiedModes
        Sorted by frequency, or in the order of ``expected``.

    Raises
    ------
    InputError
        Arrays that do not belong together or hold no numbers, a band with too few frequencies, a
        count below 1, an unknown method, or ``"lscf"`` without its package.
    """
    method = method or best_method()
    if method not in ("lscf", "circle-fit"):
        raise InputError(f'identification by {method!r}: use "lscf" or "circle-fit"')
    if count is not None and count < 1:
        raise InputError(f"{count} modes to identify: give 1 or more")
    frequency, receptance = _checked(frequency, receptance)
    low, high = band or (0.0, float(frequency[-1]))
    inside = (frequency > 0.0) & (frequency >= low) & (frequency <= high)
    if np.count_nonzero(inside) < LEAST_LINES:
        raise InputError(
            f"{np.count_nonzero(inside)} frequencies between {low:g} and {high:g} Hz: a fit needs "
            f"at least {LEAST_LINES}; give a longer record or a wider band"
        )
    kept, values = frequency[inside], receptance[:, inside]
    wanted = None if expected is None else np.atleast_1d(np.asarray(expected, dtype=float))
    chart = None
    if method == "lscf":
        found = lscf_poles(frequency, receptance, (low, high), orders)
        chart = stabilisation_chart(found, added_damping)
        pole = _with_peaks_left(kept, values, chart.pole[chart.chosen], wanted, added_damping)
    else:
        at = _peaks_near(kept, values, wanted)
        pole = circle_fit_poles(kept, values, at, added_damping)
    s = added_damping + 2j * np.pi * kept
    pole = _with_guesses(pole[np.isfinite(pole)], wanted, kept)
    if noise is not None and noise.line.shape != frequency.shape:
        raise InputError(
            f"noise at {noise.line.size} frequencies and receptances at {frequency.size}: give "
            "that of the same frequencies"
        )
    kind = FrfNoise.of_lines(kept, added_damping) if noise is None else noise.at(inside)
    pole = _fitted(s, values, pole, kind)
    pole = pole[np.argsort(abs(pole), kind="stable")]
    residue, outside = fit_residues(s, values, pole)
    left = values - modal_sum(s, pole, residue) - outside.at(s)
    asked = _asked(np.asarray(abs(pole) / (2 * np.pi), dtype=float), wanted, count)
    further = np.setdiff1d(np.arange(pole.size), asked)
    # One more column without a number is that of expected modes that were not found.
    poles = np.append(pole, np.nan)
    residues = np.concatenate([residue, np.full((len(values), 1), np.nan)], axis=1)
    covariance = np.concatenate(
        [pole_covariance(s, values, pole, kind), np.full((1, 2, 2), np.nan)]
    )
    return IdentifiedModes(
        pole=poles[asked],
        residue=residues[:, asked],
        further_pole=pole[further],
        further_residue=residue[:, further],
        lower_residual=outside.lower,
        upper_residual=outside.upper,
        upper_series=outside.series,
        method=method,
        band=(low, high),
        misfit=float(np.linalg.norm(left) / np.linalg.norm(values)),
        pole_covariance=covariance[asked],
        chart=chart,
    )


def _checked(frequency: FloatArray, receptance: ComplexArray) -> tuple[FloatArray, ComplexArray]:
    frequency = np.asarray(frequency, dtype=float)
    receptance = np.atleast_2d(np.asarray(receptance, dtype=complex))
    if frequency.ndim != 1 or receptance.ndim != 2 or receptance.shape[1] != frequency.size:
        raise InputError(
            f"frequencies {frequency.shape} and receptances {receptance.shape}: give (F,) and "
            "(points, F)"
        )
    if frequency.size < LEAST_LINES or not np.all(np.isfinite(frequency)):
        raise InputError(f"{frequency.size} frequencies: give at least {LEAST_LINES}, all finite")
    if not np.all(np.isfinite(receptance)):
        raise InputError("the receptances hold values that are not finite: leave such points out")
    if not np.any(receptance):
        raise InputError("the receptances are zero everywhere: no mode answers at these points")
    step = (frequency[-1] - frequency[0]) / (frequency.size - 1)
    lines = frequency / step if step > 0.0 else np.full(frequency.size, np.nan)
    if not np.allclose(lines, np.round(lines[0]) + np.arange(frequency.size), atol=1e-3, rtol=0):
        raise InputError(
            "the frequencies are no evenly spaced multiples of their step: interpolate the "
            "receptances to such frequencies"
        )
    return frequency, receptance


def _with_guesses(
    pole: ComplexArray, wanted: FloatArray | None, frequency: FloatArray
) -> ComplexArray:
    """Poles with one for each expected mode that has none, damped as the mode nearest to it.

    A mode that overlaps another, or is cut by the band's end, shows neither peak nor circle.
    The fit decides whether it is there.
    """
    if wanted is None or pole.size == 0:
        return pole
    known = np.asarray(abs(pole) / (2 * np.pi), dtype=float)
    ratio = -pole.real / abs(pole)
    guesses = [
        2 * np.pi * f * (-ratio[np.argmin(abs(known - f))] + 1j)
        for f in wanted
        if frequency[0] <= f <= frequency[-1] and not np.any(abs(known - f) < NEAR * f)
    ]
    return np.concatenate([pole, np.array(guesses, dtype=np.complex128)])


def _fitted(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray, noise: FrfNoise
) -> ComplexArray:
    """Poles that are refined together, and are modes and not noise."""
    added_damping = float(s[0].real)
    while True:
        # Two poles of one mode would be driven apart, and the search would not come to an end.
        refined = refined_poles(s, receptance, _distinct(pole, added_damping))
        refined = refined[np.isfinite(refined)]
        kept = significant_poles(s, receptance, _distinct(refined, added_damping), noise)
        if kept.size == refined.size:
            return kept
        # What was dropped had drawn the others along.
        pole = kept


def _distinct(pole: ComplexArray, added_damping: float) -> ComplexArray:
    """Poles without the second of two that lie within a part of their width.

    Two such poles with great residues of opposite sign are one mode.
    """
    kept: list[complex] = []
    for one in pole.tolist():
        width = added_damping - one.real
        if all(abs(one - other) > TOGETHER * width for other in kept):
            kept.append(one)
    return np.array(kept, dtype=np.complex128)


def _with_peaks_left(
    frequency: FloatArray,
    receptance: ComplexArray,
    pole: ComplexArray,
    wanted: FloatArray | None,
    added_damping: float,
) -> ComplexArray:
    """Poles of LSCF with those of peaks that it leaves.

    It is blind at the band's end, which is half its sampling rate, and noise hides from it what
    answers little. Great peaks are added, and those where a mode is expected.
    """
    s = added_damping + 2j * np.pi * frequency
    residue, outside = fit_residues(s, receptance, pole)
    left = receptance - modal_sum(s, pole, residue) - outside.at(s)
    size, whole = (np.linalg.norm(values, axis=0) for values in (left, receptance))
    at = peaks(frequency, left)
    great = at[size[at] > PEAK_LEFT * whole.max()][:MOST_PEAKS]
    known = np.asarray(abs(pole) / (2 * np.pi), dtype=float)
    lonely = [] if wanted is None else [f for f in wanted if not np.any(abs(known - f) < NEAR * f)]
    near = [highest_near(frequency, left, f, NEAR, MOST_NEAR) for f in lonely]
    at = np.unique(np.concatenate([great, *near]))
    more = circle_fit_poles(frequency, left, at, added_damping)
    return np.concatenate([pole, more])


def _peaks_near(
    frequency: FloatArray, receptance: ComplexArray, wanted: FloatArray | None
) -> IntArray:
    """All peaks; if some frequencies are expected, those without a peak of their own as well."""
    at = peaks(frequency, receptance)
    if wanted is None:
        return at[:MOST_PEAKS]
    near = [highest_near(frequency, receptance, one, NEAR, MOST_NEAR) for one in wanted]
    return np.unique(np.concatenate([at[:MOST_PEAKS], *near]))


def _asked(frequency: FloatArray, wanted: FloatArray | None, count: int | None) -> IntArray:
    """Columns of the modes that were asked for; -1 is one that was not found."""
    if wanted is None:
        return np.arange(frequency.size if count is None else min(count, frequency.size))
    distance = abs(frequency[None, :] - wanted[:, None]) / wanted[:, None]
    columns = np.full(wanted.size, -1, dtype=np.intp)
    # What is far costs so much that no near pair is ever given up for it.
    cost = np.where(distance < NEAR, distance, 1e6)
    rows, matched = linear_sum_assignment(cost)
    near = distance[rows, matched] < NEAR
    columns[rows[near]] = matched[near]
    return columns if count is None else columns[:count]
