"""Fick's law in slabs and bars by series: what the numerical diffusion is held against.

A slab with one sealed face is half of one twice as thick, and a bar the product of two slabs.
Everything is linear, so drying (``initial`` above ``surface``) follows the same functions.
Places are in m, times in s, diffusivities in m^2/s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfc

from flexmech.arrays import FloatArray
from flexmech.materials.moisture import Faces
from flexmech.materials.moisture.slab import (
    EXPONENT,
    FACTOR,
    FOURIER_OF_CHANGE,
    SMALLEST,
    TERMS,
    diffusion_length,
    fourier_number,
)
from flexmech.verification.methods.moisture import slab_uptake


def slab_profile(
    place: ArrayLike,
    time: ArrayLike,
    thickness: float,
    diffusivity: float,
    *,
    faces: Faces = "both",
    initial: float = 0.0,
    surface: float = 1.0,
) -> FloatArray:
    """Moisture at places (m,) from the mid-plane and times (t,) after a step at the faces, (t, m).

    Crank, *The Mathematics of Diffusion*, eqs. 2.45 (images) and 4.17 (cosines).
    """
    length = diffusion_length(thickness, diffusivity, faces)
    depth = _depths(place, thickness, faces)
    fourier = fourier_number(time, length, diffusivity)
    return surface + (initial - surface) * _remaining_profile(depth, fourier)


def bar_profile(
    y: ArrayLike,
    z: ArrayLike,
    time: ArrayLike,
    thickness: float,
    width: float,
    diffusivity_y: float,
    diffusivity_z: float,
    *,
    faces: Faces = "both",
    initial: float = 0.0,
    surface: float = 1.0,
) -> FloatArray:
    """Moisture over the cross-section of a bar whose sides are exposed too, (t, m, n).

    What is left of the change is the product of what is left in two slabs (Crank, *The
    Mathematics of Diffusion*, section 2.5).
    """
    through = slab_profile(y, time, thickness, diffusivity_y, faces=faces, initial=1.0, surface=0.0)
    across = slab_profile(z, time, width, diffusivity_z, initial=1.0, surface=0.0)
    return surface + (initial - surface) * through[:, :, None] * across[:, None, :]


def bar_uptake(
    time: ArrayLike,
    thickness: float,
    width: float,
    diffusivity_y: float,
    diffusivity_z: float,
    *,
    faces: Faces = "both",
) -> FloatArray:
    """Part of its final change that the mean moisture of a bar has made."""
    through = slab_uptake(time, thickness, diffusivity_y, faces=faces)
    across = slab_uptake(time, width, diffusivity_z)
    return through + across - through * across


def time_to_saturation_shen_springer(
    fraction: float, thickness: float, diffusivity: float, *, faces: Faces = "both"
) -> float:
    """Time for a part of the final change by Shen & Springer's fit, solved for the time."""
    length = diffusion_length(thickness, diffusivity, faces)
    fourier = (-np.log1p(-fraction) / FACTOR) ** (1 / EXPONENT)
    return float(fourier) * (2 * length) ** 2 / diffusivity


def _depths(place: ArrayLike, thickness: float, faces: Faces) -> FloatArray:
    """Distances from where no water flows, over the diffusion length."""
    places = np.atleast_1d(np.asarray(place, dtype=float))
    if faces == "both":
        distance = np.abs(places) / (thickness / 2)
    else:
        distance = 0.5 + (places if faces == "upper" else -places) / thickness
    return np.asarray(np.clip(distance, 0.0, 1.0))


def _remaining_profile(depth: FloatArray, fourier: FloatArray) -> FloatArray:
    """Part of the change that is still to come at depths (m,) and Fourier numbers (t,), (t, m)."""
    remaining = np.empty((fourier.size, depth.size))
    early = fourier < FOURIER_OF_CHANGE
    remaining[early] = 1 - _images(depth, fourier[early, None])
    remaining[~early] = _cosines(depth, fourier[~early, None])
    return remaining


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
