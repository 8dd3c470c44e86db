"""Least squares with intervals that stay honest where the residual is no white noise.

Parameters that the computed record is linear in are solved for at every step of the search for the
others (variable projection; G. H. Golub and V. Pereyra, SIAM Journal on Numerical Analysis 10
(1973), 413-432).

A parameter's covariance is that of the Jacobian for independent errors of one size. Where the
model is incomplete, neighbouring residuals are alike; then the residual is taken as an
autoregressive process, and the covariance is that of least squares under such errors (the
sandwich formula). Where errors are larger at samples that tell much, as beside the resonances of
a frequency-response function, their own sizes count. An interval is never made narrower by either.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.signal
import scipy.stats

from flexmech.arrays import FloatArray, StepProgress
from flexmech.errors import ComputationError

# Confidence of the intervals, as laboratories state them.
_CONFIDENCE = 0.95
# Orders among which the autoregressive process is chosen: at most this part of the samples, so that
# each coefficient is known to a third or better.
_MOST_ORDER = 40
_SAMPLES_AN_ORDER = 8
# Step of the central differences, over a parameter's scale: their error is far below
# noise.
_DIFFERENCE = 1e-4
# Up to which progress counts; a fit of a few parameters takes fewer.
_MOST_EVALUATIONS = 100
# Relative step of the scaled parameters at which a fit ends: of an answer, and of a start.
_EXACTLY, _ROUGHLY = 1e-10, 1e-3
# Condition of the slopes, each over its size, beyond which parameters have the same effect.
_MOST_CONDITION = 1e6
# At which the spectrum of an autoregressive process is added up: peaks of modes with a damping of
# 0.5 %, at forty samples a period, are drawn by four.
_FREQUENCIES = 8192


@dataclass(frozen=True)
class Parameter:
    """Parameter to be fitted.

    Parameters
    ----------
    name : str
    unit : str
        Unit of the printed value; empty for a ratio.
    start : float
        Value in this unit from which the fit begins.
    scale : float
        Typical size in this unit.
    least : float
        Below which no value makes sense.
    linear : bool
        Whether the computed record is linear in it, so that it is solved for and not sought.
    """

    name: str
    unit: str
    start: float
    scale: float
    least: float = -np.inf
    linear: bool = False


class Problem(Protocol):
    """A record and a model with parameters."""

    @property
    def parameters(self) -> Sequence[Parameter]:
        """Parameters to be fitted."""

    @property
    def measured(self) -> FloatArray:
        """Record, (k, N): k curves whose neighbouring values were measured one after the other."""

    @property
    def linear_unknowns(self) -> int:
        """Numbers that the model finds by itself for any parameters, such as a state."""

    def computed(self, values: Sequence[float]) -> FloatArray:
        """Computed record (k, N) at values of the parameters, nearest to the measured one."""

    def with_linear(self, values: Sequence[float]) -> list[float]:
        """Values with those of the linear parameters replaced by the nearest to the record."""


@dataclass(frozen=True)
class Fit:
    """Fitted parameters of p names and how far they can be trusted.

    Parameters
    ----------
    parameters : tuple of Parameter
    values, standard_error, lower, upper : ndarray, shape (p,)
        In the parameters' units; the last two are the ends of the 95 % interval.
    correlation : ndarray, shape (p, p)
    computed : ndarray, shape (k, N)
        At the values.
    unexplained : float
        Variance of the residual over that of the record.
    order : int
        Order of the autoregressive process that the residual looks like; 0 for white noise.
    widened : float
        How many times wider the widest-grown interval is than for white noise.
    """

    parameters: tuple[Parameter, ...]
    values: FloatArray
    standard_error: FloatArray
    lower: FloatArray
    upper: FloatArray
    correlation: FloatArray
    computed: FloatArray
    unexplained: float
    order: int
    widened: float


def fitted(problem: Problem, progress: StepProgress | None = None) -> Fit:
    """Fit the parameters of a model to a record.

    Parameters
    ----------
    problem : Problem
    progress : callable, optional
        Called with the evaluations done and the most that may be needed.

    Returns
    -------
    Fit

    Raises
    ------
    ComputationError
        If the fit does not converge, or the record does not tell a parameter.
    """
    parameters, values, jacobian = _nearest(problem, progress)
    measured = problem.measured
    computed = problem.computed(values.tolist())
    unknowns = len(parameters) + problem.linear_unknowns
    return _judged(parameters, values, measured, computed, jacobian, unknowns)


def nearest_values(problem: Problem) -> FloatArray:
    """Values of the parameters at which a model is nearest to a record, to a thousandth.

    Parameters
    ----------
    problem : Problem

    Returns
    -------
    ndarray, shape (p,)

    Raises
    ------
    ComputationError
        If the fit does not converge.
    """
    return _nearest(problem, None, _ROUGHLY)[1]


def _nearest(
    problem: Problem, progress: StepProgress | None, tolerance: float = _EXACTLY
) -> tuple[tuple[Parameter, ...], FloatArray, FloatArray]:
    """Parameters, their values of least squares (p,), and slopes (k N, p) of the residual.

    The slopes are by scaled parameters. What the record is linear in is solved for at every step
    (variable projection), so that its size, its sign and its start do not matter.
    """
    parameters, measured = tuple(problem.parameters), problem.measured
    size = _size(measured)
    sought = np.array([not p.linear for p in parameters], dtype=bool)
    scale, least, start = (
        np.array([getattr(p, name) for p in parameters], dtype=float)
        for name in ("scale", "least", "start")
    )
    done = 0

    def residual(values: FloatArray) -> FloatArray:
        nonlocal done
        done += 1
        if progress is not None:
            progress(min(done, _MOST_EVALUATIONS), _MOST_EVALUATIONS)
        return np.asarray((measured - problem.computed(values.tolist())).ravel() / size)

    def solved(x: FloatArray) -> FloatArray:
        values = start.copy()
        values[sought] = x * scale[sought]
        return values if sought.all() else np.array(problem.with_linear(values.tolist()))

    def left(x: FloatArray) -> FloatArray:
        return residual(solved(x))

    x = start[sought] / scale[sought]
    if sought.any():
        bound = least[sought] / scale[sought]
        fit = scipy.optimize.least_squares(
            left,
            np.maximum(x, bound),
            lambda x: _central(left, x, bound),
            (bound, np.full(len(x), np.inf)),
            xtol=tolerance,
            ftol=tolerance / 100,
            gtol=tolerance / 100,
            max_nfev=60,
        )
        if not fit.success:
            raise ComputationError(
                f"the fit of {_names(parameters)} does not converge; fit fewer parameters, or give "
                "a model nearer to the measurement"
            )
        x = fit.x
    values = solved(x)
    # A linear parameter's own size is its scale: steps of differences are not lost in rounding.
    parameters = tuple(
        replace(p, scale=max(p.scale, abs(value))) if p.linear else p
        for p, value in zip(parameters, values.tolist(), strict=True)
    )
    jacobian = np.zeros((measured.size, 0))
    if len(parameters) and tolerance == _EXACTLY:
        scale = np.array([p.scale for p in parameters])
        jacobian = _central(lambda y: residual(y * scale), values / scale, least / scale)
    return parameters, values, jacobian * size


def _judged(
    parameters: tuple[Parameter, ...],
    values: FloatArray,
    measured: FloatArray,
    computed: FloatArray,
    jacobian: FloatArray,
    unknowns: int,
) -> Fit:
    """Intervals and what remains, from the slopes (k N, p) of the residual by scaled parameters."""
    residual, scale = measured - computed, np.array([p.scale for p in parameters])
    process = autoregression(residual)
    white = _white_covariance(parameters, jacobian, residual, unknowns)
    error, quantile = np.sqrt(np.diagonal(white)), _quantile(residual.size - unknowns)
    covariance, wider = white, np.ones(len(error))
    if len(parameters):
        uneven = _uneven_covariance(jacobian, residual, unknowns)
        wider = np.maximum(np.sqrt(np.diagonal(uneven)) / error, 1.0)
    if len(process) and len(parameters):
        independent = _independent_samples(process) * residual.size
        freedom = max(independent - unknowns, 1.0)
        coloured = _coloured_covariance(jacobian, residual, process) * (independent / freedom)
        ratio = np.sqrt(np.diagonal(coloured)) * _quantile(freedom) / (error * quantile)
        wider = np.maximum(ratio, wider)
        covariance = coloured
    reach = wider * quantile * error * scale
    spread = np.sum((measured - measured.mean(axis=1)[:, None]) ** 2)
    deviation = np.sqrt(np.diagonal(covariance))
    return Fit(
        parameters,
        values,
        wider * error * scale,
        values - reach,
        values + reach,
        covariance / np.outer(deviation, deviation),
        computed,
        float(np.sum(residual**2) / spread),
        len(process),
        float(wider.max(initial=1.0)),
    )


def _quantile(freedom: float) -> float:
    """Half the width of a confidence interval in standard errors."""
    return float(scipy.stats.t.ppf((1 + _CONFIDENCE) / 2, max(freedom, 1.0)))


def _white_covariance(
    parameters: Sequence[Parameter], jacobian: FloatArray, residual: FloatArray, unknowns: int
) -> FloatArray:
    """Covariance (p, p) of the scaled parameters for independent errors of one size."""
    if not len(parameters):
        return np.zeros((0, 0))
    sizes = np.linalg.norm(jacobian, axis=0)
    # Slopes that are differences have half as many digits.
    if not sizes.all() or np.linalg.cond(jacobian / sizes) > _MOST_CONDITION:
        raise ComputationError(
            f"this record does not tell {', '.join(p.name for p in parameters)} apart: one changes "
            "the computed curve as the others together do, or not at all; fit fewer of them"
        )
    variance = float(np.sum(residual**2)) / max(residual.size - unknowns, 1)
    return variance * _inverse(jacobian)


def _inverse(jacobian: FloatArray) -> FloatArray:
    """Inverse of ``J' J``, by the QR decomposition, which squares no condition number."""
    upper = np.linalg.qr(jacobian, mode="r")
    inverse = scipy.linalg.solve_triangular(upper, np.eye(len(upper)))
    return np.asarray(inverse @ inverse.T)


def _uneven_covariance(jacobian: FloatArray, residual: FloatArray, unknowns: int) -> FloatArray:
    """Covariance (p, p) of the scaled parameters for independent errors of different sizes.

    H. White, Econometrica 48 (1980) 817-838.
    """
    inverse, weighted = _inverse(jacobian), jacobian * residual.reshape(-1, 1)
    freedom = max(residual.size - unknowns, 1)
    return np.asarray(residual.size / freedom * inverse @ (weighted.T @ weighted) @ inverse)


def _coloured_covariance(
    jacobian: FloatArray, residual: FloatArray, process: FloatArray
) -> FloatArray:
    """Covariance (p, p) of least squares whose errors are an autoregressive process."""
    polynomial = np.concatenate([[1.0], -process])
    innovation = scipy.signal.lfilter(polynomial, [1.0], residual, axis=1)
    power = float(np.mean(innovation[:, len(process) :] ** 2))
    columns = jacobian.reshape(*residual.shape, -1)
    # The process is white noise through a filter: the transposed filter runs the other way.
    filtered = scipy.signal.lfilter([1.0], polynomial, columns[:, ::-1], axis=1)
    flat, inverse = filtered.reshape(-1, columns.shape[2]), _inverse(jacobian)
    return np.asarray(power * inverse @ (flat.T @ flat) @ inverse)


def _independent_samples(process: FloatArray) -> float:
    """Independent samples for each one: one over the sum of squares of the autocorrelation."""
    _, response = scipy.signal.freqz([1.0], np.concatenate([[1.0], -process]), _FREQUENCIES)
    spectrum = np.abs(response) ** 2
    return float(spectrum.mean() ** 2 / np.mean(spectrum**2))


def autoregression(residual: FloatArray) -> FloatArray:
    """Coefficients of the autoregressive process that residuals look like.

    ``r_t = a_1 r_(t-1) + ... + a_q r_(t-q) + e_t`` by Burg's method, which finds sharp resonances
    in short records and is always stable, with the order q of the least Bayesian information
    criterion; none for white noise.

    Parameters
    ----------
    residual : ndarray, shape (k, N)
        Curves of one process.

    Returns
    -------
    ndarray, shape (q,)
    """
    most = min(_MOST_ORDER, residual.shape[1] // _SAMPLES_AN_ORDER)
    power = float(np.mean(residual**2))
    coefficients, chosen = np.zeros(0), np.zeros(0)
    if power <= 0:
        return chosen
    best = residual.size * np.log(power)
    ahead, behind = residual[:, 1:], residual[:, :-1]
    for order in range(1, most + 1):
        both = np.sum(ahead**2 + behind**2)
        if not both > 0:
            break
        reflection = float(2 * np.sum(ahead * behind) / both)
        coefficients = np.concatenate(
            [coefficients - reflection * coefficients[::-1], [reflection]]
        )
        power *= 1 - reflection**2
        ahead, behind = (
            (ahead - reflection * behind)[:, 1:],
            (behind - reflection * ahead)[:, :-1],
        )
        if power <= 0:
            break
        criterion = residual.size * np.log(power) + order * np.log(residual.size)
        if criterion < best:
            best, chosen = criterion, coefficients
    return chosen


def _central(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, least: FloatArray
) -> FloatArray:
    """Central differences of a function of vectors, one-sided at a bound."""
    columns = []
    for index in range(len(x)):
        step = np.zeros(len(x))
        step[index] = _DIFFERENCE
        back = x - step if x[index] - _DIFFERENCE >= least[index] else x
        columns.append((function(x + step) - function(back)) / (x + step - back)[index])
    return np.stack(columns, axis=1)


def _size(measured: FloatArray) -> float:
    return float(np.std(measured)) or 1.0


def _names(parameters: Sequence[Parameter]) -> str:
    return ", ".join(parameter.name for parameter in parameters)
