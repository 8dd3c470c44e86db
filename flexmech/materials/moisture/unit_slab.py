"""A slab of unit diffusion length and unit diffusivity after a unit step at its faces.

Depth runs from 0, where no water flows (the mid-plane, or the sealed face), to 1 at an exposed
face; time is the Fourier number. Images of the error function converge within a few terms as
long as the water has not reached the far side, cosines do so afterwards (Crank, *The
Mathematics of Diffusion*, 2nd ed., sections 2.2.4, 4.3.1 and 4.3.2).
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import erfc

from flexmech.errors import InputError
from flexmech.types import FloatArray

__all__ = [
    "Faces",
    "checked_faces",
    "depths",
    "diffusion_length",
    "fourier_number",
    "fourier_number_of",
    "remaining_profile",
    "uptake",
]


Faces = Literal["both", "lower", "upper"]
"""The faces of a slab that are exposed; the other one is sealed."""

# Below this Fourier number the images are summed, above it the cosines; there either one's
# first term left out is below 1e-17.
FOURIER_OF_CHANGE = 0.2
TERMS = 6
PLACE_TOLERANCE = 1e-9
# Stands for zero where that would divide.
SMALLEST = 1e-100


def checked_faces(faces: str) -> None:
    """Refuse a word that does not say which faces are exposed."""
    if faces not in get_args(Faces):
        raise InputError(f"faces must be one of {', '.join(get_args(Faces))}; got {faces!r}")


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
    for name, value, unit in (("thickness", thickness, "m"), ("diffusivity", diffusivity, "m^2/s")):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{name} must be positive, got {value} {unit}")
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


def depths(place: ArrayLike, thickness: float, faces: Faces) -> FloatArray:
    """Distances from where no water flows, over the diffusion length.

    Parameters
    ----------
    place : array_like, shape (m,)
        From the mid-plane in m.
    thickness : float
        In m.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (m,)
        From 0 to 1.

    Raises
    ------
    InputError
        If a place lies outside the slab.
    """
    places = np.atleast_1d(np.asarray(place, dtype=float))
    limit = thickness / 2 * (1 + PLACE_TOLERANCE)
    if places.ndim != 1 or not np.all(np.abs(places) <= limit):
        raise InputError(
            f"places must be a row of numbers between {-thickness / 2} and {thickness / 2} m, "
            f"from the mid-plane; got {places}"
        )
    if faces == "both":
        distance = np.abs(places) / (thickness / 2)
    else:
        distance = 0.5 + (places if faces == "upper" else -places) / thickness
    return np.asarray(np.clip(distance, 0.0, 1.0))


def remaining_profile(depth: FloatArray, fourier: FloatArray) -> FloatArray:
    """Part of the change that is still to come.

    Crank, *The Mathematics of Diffusion*, eqs. 2.45 (images) and 4.17 (cosines), which
    state the change itself.

    Parameters
    ----------
    depth : ndarray, shape (m,)
    fourier : ndarray, shape (t,)

    Returns
    -------
    ndarray, shape (t, m)
    """
    remaining = np.empty((fourier.size, depth.size))
    early = fourier < FOURIER_OF_CHANGE
    remaining[early] = 1 - _images(depth, fourier[early, None])
    remaining[~early] = _cosines(depth, fourier[~early, None])
    return remaining


def fourier_number_of(fraction: float) -> float:
    """Fourier number at which the mean has made a part of the change: the root of the series.

    Parameters
    ----------
    fraction : float

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the fraction is not above 0 and below 1.
    """
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
            return float(_early_uptake(np.array([fourier]))[0]) - fraction
        return (1 - fraction) - float(_remaining(np.array([fourier]))[0])

    return float(brentq(excess, 0.999 * earliest, 1.001 * latest, xtol=1e-300, rtol=1e-14))


def _images(depth: FloatArray, fourier: FloatArray) -> FloatArray:
    # At time zero the error function is one at the face and zero elsewhere.
    spread = np.maximum(2 * np.sqrt(fourier), SMALLEST)
    total = np.zeros(np.broadcast_shapes(depth.shape, fourier.shape))
    for n in range(TERMS):
        near, far = 2 * n + 1 - depth, 2 * n + 1 + depth
        total += (-1) ** n * (erfc(near / spread) + erfc(far / spread))
    return total


def _cosines(depth: FloatArray, fourier: FloatArray) -> FloatArray:
    total = np.zeros(np.broadcast_shapes(depth.shape, fourier.shape))
    for n in range(TERMS):
        wave = (2 * n + 1) * np.pi / 2
        total += (-1) ** n * 2 / wave * np.exp(-(wave**2) * fourier) * np.cos(wave * depth)
    return total


def uptake(fourier: FloatArray) -> FloatArray:
    """Part of the change that the mean has made: Crank's eqs. 4.18 and 4.20.

    Parameters
    ----------
    fourier : ndarray, shape (t,)

    Returns
    -------
    ndarray, shape (t,)
    """
    return np.where(fourier < FOURIER_OF_CHANGE, _early_uptake(fourier), 1 - _remaining(fourier))


def _early_uptake(fourier: FloatArray) -> FloatArray:
    root = np.maximum(np.sqrt(fourier), SMALLEST)
    total = np.full(fourier.shape, 1 / np.sqrt(np.pi))
    for n in range(1, TERMS):
        argument = n / root
        total += (
            2 * (-1) ** n * (np.exp(-(argument**2)) / np.sqrt(np.pi) - argument * erfc(argument))
        )
    return np.asarray(2 * np.sqrt(fourier) * total)


def _remaining(fourier: FloatArray) -> FloatArray:
    waves = (2 * np.arange(TERMS) + 1) * np.pi / 2
    return np.asarray(np.exp(-np.multiply.outer(fourier, waves**2)) @ (2 / waves**2))
