"""Water in a slab by Fick's law: exact series, and the short formulas that others publish.

Constant ambient, one diffusivity, faces at once in equilibrium. In units of the diffusion length,
time is the Fourier number. Images of the error function converge within a few terms as long as
the water has not reached the far side, cosines do so afterwards (Crank, *The Mathematics of
Diffusion*, 2nd ed., sections 2.2.4, 4.3.1 and 4.3.2).
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import scipy
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.validation import POSITIVE, check_choice, check_number

Faces = Literal["both", "lower", "upper"]
"""The faces of a slab that are exposed; the other one is sealed."""


def checked_faces(faces: str) -> None:
    """Refuse a word that does not say which faces are exposed."""
    check_choice(faces, get_args(Faces), "faces")


def diffusion_length(thickness: float, diffusivity: float, faces: Faces) -> float:
    """The way in m that the last of the water goes: half the slab, or all of it.

    Parameters
    ----------
    thickness : float
        In m.
    diffusivity : float
        In m^2/s; only checked.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the thickness or the diffusivity is not positive or ``faces`` no such word.
    """
    check_number(thickness, "thickness", "m", POSITIVE)
    check_number(diffusivity, "diffusivity", "m^2/s", POSITIVE)
    checked_faces(faces)
    return thickness / 2 if faces == "both" else thickness


def fourier_number(time: ArrayLike, length: float, diffusivity: float) -> FloatArray:
    """Times over the diffusion time ``length**2 / diffusivity``.

    Parameters
    ----------
    time : array_like, shape (t,)
        In s, from zero on.
    length : float
        In m.
    diffusivity : float
        In m^2/s.

    Returns
    -------
    ndarray, shape (t,)

    Raises
    ------
    InputError
        If a time is negative or not a number.
    """
    times = np.atleast_1d(np.asarray(time, dtype=float))
    if times.ndim != 1 or not np.all(np.isfinite(times) & (times >= 0)):
        raise InputError(f"times must be a row of numbers of zero or more, got {times}")
    return times * diffusivity / length**2


# Below this Fourier number the images are summed, above it the cosines; there either one's
# first term left out is below 1e-17 with so many terms.
FOURIER_OF_CHANGE = 0.2
TERMS = 6
# Stands for a root of zero where that would divide; the square of its inverse is still a number.
SMALLEST = 1e-100


def time_to_saturation(
    fraction: float, thickness: float, diffusivity: float, *, faces: Faces = "both"
) -> float:
    """Time after which a slab has made a part of its final change: the root of the series.

    Parameters
    ----------
    fraction : float
        Above 0 and below 1.
    thickness : float
        In m.
    diffusivity : float
        In m^2/s.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    float
        In s.

    Raises
    ------
    InputError
        If the fraction is not between 0 and 1, or the slab is no slab.
    """
    length = diffusion_length(thickness, diffusivity, faces)
    return _fourier_number_of(fraction) * length**2 / diffusivity


def early_uptake(fourier: FloatArray) -> FloatArray:
    """Part of the change that the mean has made, by images: Crank's eq. 4.20."""
    root = np.maximum(np.sqrt(fourier), SMALLEST)
    total = np.full(fourier.shape, 1 / np.sqrt(np.pi))
    for n in range(1, TERMS):
        argument = n / root
        total += (
            2
            * (-1) ** n
            * (np.exp(-(argument**2)) / np.sqrt(np.pi) - argument * scipy.special.erfc(argument))
        )
    return np.asarray(2 * np.sqrt(fourier) * total)


def remaining_uptake(fourier: FloatArray) -> FloatArray:
    """Part of the change that the mean has yet to make, by cosines: Crank's eq. 4.18."""
    waves = (2 * np.arange(TERMS) + 1) * np.pi / 2
    return np.asarray(np.exp(-np.multiply.outer(fourier, waves**2)) @ (2 / waves**2))


def _fourier_number_of(fraction: float) -> float:
    """Fourier number at which the mean has made a part of the change."""
    if not 0 < fraction < 1:
        raise InputError(
            f"fraction of saturation must lie above 0 and below 1, got {fraction}; full "
            "saturation takes for ever, ask for 0.999"
        )
    # The law of the root is never below the uptake, and what is left of the change never above
    # what it were if all of it were in the slowest cosine.
    earliest = np.pi * fraction**2 / 4
    latest = -4 / np.pi**2 * np.log1p(-fraction)

    def excess(fourier: float) -> float:
        if fourier < FOURIER_OF_CHANGE:
            return float(early_uptake(np.array([fourier]))[0]) - fraction
        return (1 - fraction) - float(remaining_uptake(np.array([fourier]))[0])

    return float(
        scipy.optimize.brentq(excess, 0.999 * earliest, 1.001 * latest, xtol=1e-300, rtol=1e-14)
    )


# Factor of Shen & Springer's fit, as published.
FACTOR = 7.3
EXPONENT = 0.75


def short_time_uptake(
    time: ArrayLike, thickness: float, diffusivity: float, *, faces: Faces = "both"
) -> FloatArray:
    """Uptake before the water from one face meets the other's: ``4 sqrt(D t / (pi s^2))``.

    The thickness s counts twice if only one face is exposed. Crank, *The Mathematics of
    Diffusion*, eq. 4.20 without its images; beyond saturation it goes on to grow.

    Parameters
    ----------
    time : array_like, shape (t,)
        Since the step in s.
    thickness : float
        In m.
    diffusivity : float
        In m^2/s.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (t,)
        Part of the final change.

    Raises
    ------
    InputError
        If a time is negative or the slab is no slab.
    """
    length = diffusion_length(thickness, diffusivity, faces)
    return np.asarray(2 * np.sqrt(fourier_number(time, length, diffusivity) / np.pi))


def shen_springer_uptake(
    time: ArrayLike, thickness: float, diffusivity: float, *, faces: Faces = "both"
) -> FloatArray:
    """Uptake by Shen & Springer's fit to the series: ``1 - exp(-7.3 (D t / s^2)^0.75)``.

    *J. Compos. Mater.* 10 (1976) 2-20. The thickness s counts twice if only one face is exposed.

    Parameters
    ----------
    time : array_like, shape (t,)
        Since the step in s.
    thickness : float
        In m.
    diffusivity : float
        In m^2/s.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (t,)
        Part of the final change.

    Raises
    ------
    InputError
        If a time is negative or the slab is no slab.
    """
    length = diffusion_length(thickness, diffusivity, faces)
    fourier = fourier_number(time, 2 * length, diffusivity)
    return np.asarray(-np.expm1(-FACTOR * fourier**EXPONENT))
