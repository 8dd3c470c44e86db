"""Modes as a laboratory knows them: poles, residues, and residual terms for what lies outside.

The modal assurance criterion says how alike two shapes are, the complexity factor how far a shape
is from a real one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.modal_testing.lscf import StabilisationChart

# Upper terms of the series of what modes above the band give, beyond its constant. Without them a
# mode near the band's end is drawn towards those outside.
UPPER_TERMS = 2


class _ResidualTerms(NamedTuple):
    """Stand-in for all modes outside a band; see :class:`IdentifiedModes`."""

    lower: ComplexArray
    upper: ComplexArray
    series: ComplexArray

    def at(self, s: ComplexArray) -> ComplexArray:
        """Their receptance at some ``s``, shape (F,), for all points: shape (points, F)."""
        value = self.lower[:, None] / s**2 + self.upper[:, None]
        for number, term in enumerate(self.series.T, 1):
            value = value + term[:, None] * s ** (2 * number)
        return np.asarray(value)


@dataclass(frozen=True, eq=False)
class IdentifiedModes:
    r"""Modes that were identified from receptances of one impact point.

    .. math:: H_p(s) = \sum_r \left(\frac{A_{pr}}{s - \lambda_r}
        + \frac{A^*_{pr}}{s - \lambda^*_r}\right)
        + \frac{L_p}{s^2} + U_p + V_{p1} s^2 + V_{p2} s^4

    Parameters
    ----------
    pole : ndarray of complex, shape (k,)
        In 1/s with positive imaginary part, free of what a window added. Not a number where an
        expected mode was not found.
    residue : ndarray of complex, shape (points, k)
        The A in m/(N s).
    further_pole : ndarray of complex, shape (l,)
        Poles of further modes in the band that were found and not asked for: the receptances need
        them.
    further_residue : ndarray of complex, shape (points, l)
    lower_residual : ndarray of complex, shape (points,)
        The L in m/(N s^2): inertia of modes below the band.
    upper_residual : ndarray of complex, shape (points,)
        The U in m/N: compliance of modes above the band.
    upper_series : ndarray of complex, shape (points, 2)
        The V in m s^2/N and m s^4/N: the next terms of the series of what those modes give.
    method : str
        ``"lscf"`` or ``"circle-fit"``.
    band : tuple of float
        In Hz, from and to.
    misfit : float
        Root mean square of what the model leaves of the receptances in the band, over theirs.
    pole_covariance : ndarray, shape (k, 2, 2)
        Covariance of the real and imaginary part of each pole by noise, in 1/s^2.
    chart : StabilisationChart, optional
        Poles of all orders, of ``"lscf"`` alone.
    """

    pole: ComplexArray
    residue: ComplexArray
    further_pole: ComplexArray
    further_residue: ComplexArray
    lower_residual: ComplexArray
    upper_residual: ComplexArray
    upper_series: ComplexArray
    method: str
    band: tuple[float, float]
    misfit: float
    pole_covariance: FloatArray
    chart: StabilisationChart | None = None

    @property
    def frequency(self) -> FloatArray:
        """Undamped natural frequencies ``|pole|/(2 pi)`` in Hz, shape (k,)."""
        return np.asarray(abs(self.pole) / (2 * np.pi))

    @property
    def damping_ratio(self) -> FloatArray:
        """Damping ratios ``-Re pole / |pole|``, shape (k,)."""
        return np.asarray(-self.pole.real / abs(self.pole))

    @property
    def frequency_error(self) -> FloatArray:
        """Standard errors of the natural frequencies by noise in Hz, shape (k,)."""
        size = 2 * np.pi * np.asarray(abs(self.pole), dtype=float)
        along = np.stack([self.pole.real, self.pole.imag], axis=1)
        return self._standard_error(along / size[:, None])

    @property
    def damping_ratio_error(self) -> FloatArray:
        """Standard errors of the damping ratios by noise, shape (k,)."""
        # Derivatives of the ratio -Re/|pole| by the real and the imaginary part.
        size = self.pole.imag / np.asarray(abs(self.pole), dtype=float) ** 3
        along = np.stack([-self.pole.imag, self.pole.real], axis=1)
        return self._standard_error(along * size[:, None])

    def _standard_error(self, slope: FloatArray) -> FloatArray:
        """Standard deviations from slopes (k, 2) by the real and imaginary part of a pole."""
        variance = np.einsum("ki,kij,kj->k", slope, self.pole_covariance, slope)
        return np.asarray(np.sqrt(variance), dtype=float)

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each mode was found, shape (k,)."""
        return np.asarray(np.isfinite(self.pole))

    def receptance(self, frequency: FloatArray, added_damping: float = 0.0) -> ComplexArray:
        """Synthesize the receptances from the modes found and the residual terms.

        Parameters
        ----------
        frequency : ndarray, shape (F,)
            In Hz, above 0.
        added_damping : float
            Decay rate in 1/s of an exponential window that the receptances shall have.

        Returns
        -------
        ndarray of complex, shape (points, F)
            In m/N.
        """
        s = added_damping + 2j * np.pi * np.asarray(frequency, dtype=float)
        found = self.found
        value = modal_sum(s, self.pole[found], self.residue[:, found])
        value += modal_sum(s, self.further_pole, self.further_residue)
        terms = self.lower_residual, self.upper_residual, self.upper_series
        return value + _ResidualTerms(*terms).at(s)

    def circle(self, mode: int, point: int = 0) -> tuple[complex, float]:
        """Circle of a mode in the Nyquist diagram of the receptance.

        Parameters
        ----------
        mode : int
            Column of the modes.
        point : int
            Row of the residues.

        Returns
        -------
        tuple of complex and float
            Centre and radius in m/N. The centre holds what all other modes and the residual terms
            give at the mode's frequency.
        """
        pole, residue = self.pole[mode], self.residue[point, mode]
        half = residue / (-2.0 * pole.real)
        at = 1j * pole.imag
        everything = self.receptance(np.array([pole.imag / (2 * np.pi)]))[point, 0]
        background = everything - residue / (at - pole)
        return complex(background + half), float(abs(half))


def modal_sum(s: ComplexArray, pole: ComplexArray, residue: ComplexArray) -> ComplexArray:
    """Sum of the modes alone at some ``s``.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
    pole : ndarray of complex, shape (k,)
    residue : ndarray of complex, shape (points, k)

    Returns
    -------
    ndarray of complex, shape (points, F)
    """
    direct = 1.0 / (s[None, :] - pole[:, None])
    mirrored = 1.0 / (s[None, :] - pole.conj()[:, None])
    total: ComplexArray = residue @ direct + residue.conj() @ mirrored
    return total


def fit_residues(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray
) -> tuple[ComplexArray, _ResidualTerms]:
    """Residues and residual terms of known poles, by linear least squares over frequency.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
        In 1/s; none of them 0. Records under an exponential window have its rate as the real part,
        and the poles are free of it.
    receptance : ndarray of complex, shape (points, F)
    pole : ndarray of complex, shape (k,)

    Returns
    -------
    tuple of ndarray of complex and _ResidualTerms
        Residues, shape (points, k), and what stands for modes outside the band.

    Notes
    -----
    The least-squares frequency-domain method; see N. M. M. Maia and J. M. M. Silva, Theoretical
    and Experimental Modal Analysis (1997), section 4.4.
    """
    matrix = residue_columns(s, pole)
    values = np.concatenate([receptance.real, receptance.imag], axis=1).T
    # Columns of like size, so that the rank is judged by directions and not by units.
    size = np.linalg.norm(matrix, axis=0)
    solution = (np.linalg.lstsq(matrix / size, values, rcond=None)[0] / size[:, None]).T
    k = pole.size
    residue = solution[:, :k] + 1j * solution[:, k : 2 * k]
    real, imaginary = np.split(solution[:, 2 * k :], 2, axis=1)
    terms = real + 1j * imaginary
    powers = abs(s).max() ** (2 * np.arange(1, UPPER_TERMS + 1))
    return residue, _ResidualTerms(terms[:, 0], terms[:, 1], terms[:, 2:] / powers)


def residue_columns(s: ComplexArray, pole: ComplexArray) -> FloatArray:
    """Functions that residues and residual terms multiply, real and imaginary parts apart.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
    pole : ndarray of complex, shape (k,)

    Returns
    -------
    ndarray, shape (2 F, 2 (k + 4))
        Rows: real parts of the receptance, then imaginary ones. Columns: real parts of residues,
        imaginary ones, real parts of the residual terms, imaginary ones; powers of ``s`` are those
        of its part of the greatest.
    """
    direct = 1.0 / (s[:, None] - pole[None, :])
    mirrored = 1.0 / (s[:, None] - pole.conj()[None, :])
    powers = [(s / abs(s).max()) ** (2 * n) for n in range(1, UPPER_TERMS + 1)]
    rest = np.stack([s**-2, np.ones_like(s), *powers], axis=1)
    # Unknown are real and imaginary parts, because a residue stands there with its conjugate.
    columns = np.concatenate([direct + mirrored, 1j * (direct - mirrored), rest, 1j * rest], axis=1)
    return np.concatenate([columns.real, columns.imag])


def mac(first: NDArray[Any], second: NDArray[Any]) -> FloatArray:
    """Modal assurance criterion of all pairs of two sets of shapes.

    Parameters
    ----------
    first : ndarray, shape (points, k)
        Real or complex shapes as columns; one shape may be of shape (points,).
    second : ndarray, shape (points, l)

    Returns
    -------
    ndarray, shape (k, l)
        ``|a^H b|^2 / (a^H a  b^H b)``: 1 for shapes that differ by a factor alone, 0 for orthogonal
        ones. It is not a number where a shape is zero everywhere or holds no number.

    Raises
    ------
    InputError
        The shapes have different points.

    Notes
    -----
    Source: R. J. Allemang, Sound and Vibration 37 (2003), no. 8, 14-21.

    Examples
    --------
    >>> mac(np.array([1.0, 2.0]), np.array([[2.0j, 2.0], [4.0j, -1.0]])).tolist()
    [[1.0, 0.0]]
    """
    a, b = _columns(first), _columns(second)
    if a.shape[0] != b.shape[0]:
        raise InputError(
            f"shapes at {a.shape[0]} and at {b.shape[0]} points: give both at the same points"
        )
    squares = np.outer(np.sum(abs(a) ** 2, axis=0), np.sum(abs(b) ** 2, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(abs(a.conj().T @ b) ** 2 / squares)


def complexity_factor(shape: NDArray[Any]) -> FloatArray:
    """Modal complexity factor of shapes.

    Parameters
    ----------
    shape : ndarray of complex, shape (points, k)
        Shapes as columns; one shape may be of shape (points,).

    Returns
    -------
    ndarray, shape (k,)
        0 where all points move in phase or against it, 1 where the phases favour no direction:
        ``1 - |sum x^2|^2 / (sum |x|^2)^2``. Not a number for a shape that is zero everywhere.

    Notes
    -----
    With the sums of squares and of products of real and imaginary parts it is
    ``1 - ((Sxx - Syy)^2 + 4 Sxy^2)/(Sxx + Syy)^2``. Source: M. Imregun and D. J. Ewins, Proceedings
    of the 13th International Modal Analysis Conference (1995), 496-506, "Complex modes: origins
    and limits".

    Examples
    --------
    >>> complexity_factor(np.array([[1.0, 1.0], [-2.0, 1.0j]])).tolist()
    [0.0, 1.0]
    """
    x = _columns(shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(1.0 - abs(np.sum(x**2, axis=0)) ** 2 / np.sum(abs(x) ** 2, axis=0) ** 2)


def _columns(shapes: NDArray[Any]) -> NDArray[Any]:
    shapes = np.asarray(shapes)
    return shapes[:, None] if shapes.ndim == 1 else shapes
