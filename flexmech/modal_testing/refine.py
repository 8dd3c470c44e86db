r"""Poles that fit the receptances best, near those that were identified, without those of noise.

LSCF and circles fit products of the receptance, whose errors are larger where the receptance is
larger, so that noise pulls their poles to one side. Here the receptances themselves are fitted,

.. math:: \min_{\lambda, A, L, U} \sum_p \sum_f |H_p(s_f) - \hat H_p(s_f)|^2,

which is the maximum-likelihood estimate if their noise is white. For given poles the best residues
and residual terms are those of a linear least-squares problem; only the poles are searched. Source:
G. H. Golub and V. Pereyra, SIAM Journal on Numerical Analysis 10 (1973), 413-432 (variable
projection), with the derivative of L. Kaufman, BIT 15 (1975), 49-57.

Noise alone gives a pole residues whose squares over their covariance are chi-squared with as many
degrees of freedom as a mode has numbers: a residue at each point, and a pole. The greatest of as
many trials as there are spectral lines is what noise can look like at best. The covariance is that
of noise of the records (:mod:`.noise`): it is neither equal nor independent over the lines.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import chi2

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.modal_testing.identified import residue_columns
from flexmech.modal_testing.noise import FrfNoise

# A bound of work: from poles of another method the squares fall to their least in a few.
MOST_STEPS = 30
# Relative: a pole that moves further is no longer the one that was identified.
FAR = 0.05

# Probability that noise alone gives a mode somewhere in the band.
FALSE_ALARM = 1e-3


def refined_poles(s: ComplexArray, receptance: ComplexArray, pole: ComplexArray) -> ComplexArray:
    """Refine poles by least squares of the receptances.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
        In 1/s; none of them 0.
    receptance : ndarray of complex, shape (points, F)
    pole : ndarray of complex, shape (k,)
        Where the search begins.

    Returns
    -------
    ndarray of complex, shape (k,)
        Not a number where a pole would leave its place or grow: it only served noise.
    """
    kept = np.arange(pole.size)
    refined = np.full(pole.shape, np.nan, dtype=np.complex128)
    while kept.size:
        first = pole[kept]
        problem = _Projection(s, receptance, np.asarray(abs(first), dtype=float))
        solution = least_squares(
            problem.residual,
            problem.parameters(first),
            jac=problem.derivative,
            method="lm",
            max_nfev=MOST_STEPS,
            x_scale="jac",
        )
        last = problem.poles(solution.x)
        way = np.where(last.real < s.real.min(), abs(last - first) / abs(first), np.inf)
        if np.all(way < FAR):
            refined[kept] = last
            break
        # One at a time: the others may have been drawn along.
        kept = np.delete(kept, np.argmax(way))
    return refined


class _Projection:
    """Remainder of the receptances beside the best residues of some poles."""

    def __init__(self, s: ComplexArray, receptance: ComplexArray, size: FloatArray) -> None:
        self._s, self._size = s, size
        self._values = np.concatenate([receptance.real, receptance.imag], axis=1).T
        self.scale = float(np.linalg.norm(self._values))
        self._last: tuple[FloatArray, tuple[FloatArray, ComplexArray]] | None = None

    def parameters(self, pole: ComplexArray) -> FloatArray:
        return np.concatenate([pole.real / self._size, pole.imag / self._size])

    def poles(self, x: FloatArray) -> ComplexArray:
        real, imaginary = np.split(x, 2)
        return np.asarray(self._size * (real + 1j * imaginary))

    def residual(self, x: FloatArray) -> FloatArray:
        basis, _ = self._basis(x)
        left = self._values - basis @ (basis.T @ self._values)
        return np.asarray(left.T.ravel() / self.scale)

    def derivative(self, x: FloatArray) -> FloatArray:
        pole = self.poles(x)
        basis, residue = self._basis(x)
        direct = 1.0 / (self._s[:, None] - pole) ** 2
        mirrored = 1.0 / (self._s[:, None] - pole.conj()) ** 2
        columns = []
        for turn in (1.0, 1j):  # along the real and the imaginary part of a pole
            for number, size in enumerate(self._size):
                moved = turn * residue[:, number, None] * direct[:, number]
                moved = moved + np.conj(turn * residue[:, number, None]) * mirrored[:, number]
                slope = np.concatenate([moved.real, moved.imag], axis=1).T * size
                slope -= basis @ (basis.T @ slope)
                columns.append(-slope.T.ravel() / self.scale)
        return np.stack(columns, axis=1)

    def _basis(self, x: FloatArray) -> tuple[FloatArray, ComplexArray]:
        """Orthonormal columns that the poles span, and their residues, shape (points, k)."""
        # The derivative is asked for where the residual has just been.
        if self._last is None or not np.array_equal(self._last[0], x):
            self._last = x.copy(), self._spanned(self.poles(x))
        return self._last[1]

    def _spanned(self, pole: ComplexArray) -> tuple[FloatArray, ComplexArray]:
        matrix = residue_columns(self._s, pole)
        size = np.linalg.norm(matrix, axis=0)
        basis, triangle = np.linalg.qr(matrix / size)
        solution = np.linalg.solve(triangle, basis.T @ self._values) / size[:, None]
        k = pole.size
        return basis, (solution[:k] + 1j * solution[k : 2 * k]).T


def significant_poles(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray, noise: FrfNoise
) -> ComplexArray:
    """Poles without those that noise explains as well; the least one is taken out first.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
        In 1/s; none of them 0.
    receptance : ndarray of complex, shape (points, F)
    pole : ndarray of complex, shape (k,)
    noise : FrfNoise
        At these frequencies.

    Returns
    -------
    ndarray of complex, shape (l,)
    """
    points, lines = receptance.shape
    least = chi2.isf(FALSE_ALARM / lines, 2 * points + 2)
    while pole.size:
        significance = _significance(s, receptance, pole, noise)
        weakest = int(np.argmin(significance))
        if significance[weakest] > least:
            break
        pole = np.delete(pole, weakest)
    return pole


def _significance(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray, noise: FrfNoise
) -> FloatArray:
    """Squares of each pole's residues over their covariance by noise, added up; shape (k,)."""
    fit = _LinearFit(s, receptance, pole, noise)
    significance = np.zeros(pole.size)
    for number in range(pole.size):
        rows = fit.rows([number, pole.size + number])
        seen = noise.of_response(rows)
        for values, level, row in zip(fit.values.T, fit.levels, receptance, strict=True):
            hit = noise.force_level * noise.of_force(rows, row)
            covariance = level**2 * (seen @ seen.T) + hit @ hit.T
            size = rows @ values
            significance[number] += size @ np.linalg.solve(covariance, size)
    return significance


def pole_covariance(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray, noise: FrfNoise
) -> FloatArray:
    """Covariance of the real and imaginary part of each pole of least squares, by noise.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
        In 1/s; none of them 0.
    receptance : ndarray of complex, shape (points, F)
    pole : ndarray of complex, shape (k,)
        Poles by least squares.
    noise : FrfNoise
        At these frequencies.

    Returns
    -------
    ndarray, shape (k, 2, 2)
        In 1/s^2.
    """
    if not pole.size:
        return np.zeros((0, 2, 2))
    size = np.asarray(abs(pole), dtype=float)
    problem = _Projection(s, receptance, size)
    # Kaufman's slopes are those of the least squares with the residues following.
    slopes = problem.derivative(problem.parameters(pole)) * problem.scale
    basis, triangle = np.linalg.qr(slopes)
    rows = np.linalg.solve(triangle, basis.T).reshape(2 * pole.size, len(receptance), -1)
    fit = _LinearFit(s, receptance, pole, noise)
    whole = sum(
        noise.covariance(rows[:, point], receptance[point], fit.levels[point])
        for point in range(len(receptance))
    )
    pairs = np.asarray(whole).reshape(2, pole.size, 2, pole.size)
    number = np.arange(pole.size)
    return np.asarray(pairs[:, number, :, number] * (size**2)[:, None, None])


class _LinearFit:
    """Residues and residual terms of poles by least squares, and the noise that they leave."""

    def __init__(
        self, s: ComplexArray, receptance: ComplexArray, pole: ComplexArray, noise: FrfNoise
    ) -> None:
        matrix = residue_columns(s, pole)
        self._size = np.linalg.norm(matrix, axis=0)
        self._basis, self._triangle = np.linalg.qr(matrix / self._size)
        self.values = np.concatenate([receptance.real, receptance.imag], axis=1).T
        left = self.values - self._basis @ (self._basis.T @ self.values)
        remaining = left.size - self._basis.shape[1] * len(receptance)
        # Where as many numbers are fitted as there are, nothing is known of the noise.
        free = max(remaining - 2 * pole.size, 1) / max(remaining, 1)
        self.levels = [
            noise.response_level(rest, self._basis, row, free)
            for rest, row in zip(left.T, receptance, strict=True)
        ]

    def rows(self, numbers: list[int]) -> FloatArray:
        """Factors of the receptance in some of the residues, (r, 2 F)."""
        unit = np.eye(len(self._triangle))[numbers]
        inverse = np.linalg.solve(self._triangle.T, unit.T).T
        return np.asarray(inverse @ self._basis.T / self._size[numbers][:, None])
