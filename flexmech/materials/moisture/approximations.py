"""Short formulas for the water that a slab takes up: the law of the root, and Shen & Springer's.

They are for comparison with what others publish; the series are exact and cost no more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flexmech.materials.moisture.unit_slab import Faces, diffusion_length, fourier_number
from flexmech.types import FloatArray

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
