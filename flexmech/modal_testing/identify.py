"""Identification of modes from measured receptances."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.modal_testing.circle_fit import circle_fit_poles, highest_near, peaks
from flexmech.modal_testing.identified import IdentifiedModes, fit_residues, modal_sum
from flexmech.modal_testing.lscf import has_lscf, lscf_poles, stabilisation_chart
from flexmech.modal_testing.noise import FrfNoise
from flexmech.modal_testing.refine import pole_covariance, refined_poles, significant_poles

IdentificationMethod = Literal["lscf", "circle-fit"]

# Highest number of modes of the models of LSCF: a mode is stable in a fifth of the orders at least,
# which are six then.
ORDERS = 30
# Frequencies in the band that a fit needs: of one point 32 numbers, for the 12 unknowns of a mode
# with the residual terms.
LEAST_LINES = 16
# Of the greatest receptance: a peak that is left above it is a mode that LSCF has missed.
PEAK_LEFT = 0.1
# Peaks that are tried, the most prominent ones: altogether, and near an expected mode. A bound of
# work: those of noise are dropped afterwards.
MOST_PEAKS, MOST_NEAR = 20, 3
# Of half their half-power width: poles so near to each other are one.
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
        modes are told from noise, and poles have standard errors. Without it, white noise of the
        response under a force that excites all frequencies alike.
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
    Whether it is there is told by the fit.
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

    One mode is told by two such poles with great residues of opposite sign.
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
    size, whole = (np.linalg.norm(each, axis=0) for each in (left, receptance))
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
