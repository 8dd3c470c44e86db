"""Fick's law solved exactly: constant surroundings, one diffusivity, faces at once in equilibrium.

A slab with one sealed face is half of one twice as thick, and a bar the product of two slabs.
Everything is linear, so drying (``initial`` above ``surface``) follows the same functions.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from flexmech.materials.moisture.unit_slab import (
    Faces,
    depths,
    diffusion_length,
    fourier_number,
    fourier_number_of,
    remaining_profile,
    uptake,
)
from flexmech.types import FloatArray

__all__ = ["bar_profile", "bar_uptake", "slab_profile", "slab_uptake", "time_to_saturation"]


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
    """Saturation, or any other measure of moisture, through a slab after a step at its faces.

    Crank, *The Mathematics of Diffusion*, eqs. 2.45 (images) and 4.17 (cosines).

    Parameters
    ----------
    place : array_like, shape (m,)
        From the mid-plane in m, -h/2 to h/2.
    time : array_like, shape (t,)
        Since the step in s; at zero only the exposed faces have changed.
    thickness : float
        In m.
    diffusivity : float
        In m^2/s.
    faces : {"both", "lower", "upper"}
        Those exposed.
    initial, surface : float
        Before the step everywhere, and after it at the exposed faces.

    Returns
    -------
    ndarray, shape (t, m)

    Raises
    ------
    InputError
        If a place lies outside the slab, a time is negative, or the slab is no slab.
    """
    length = diffusion_length(thickness, diffusivity, faces)
    depth = depths(place, thickness, faces)
    fourier = fourier_number(time, length, diffusivity)
    return surface + (initial - surface) * remaining_profile(depth, fourier)


def slab_uptake(
    time: ArrayLike, thickness: float, diffusivity: float, *, faces: Faces = "both"
) -> FloatArray:
    """Part of its final change that a slab's mean moisture has made after a step.

    Crank, *The Mathematics of Diffusion*, eqs. 4.18 and 4.20.

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

    Raises
    ------
    InputError
        If a time is negative or the slab is no slab.
    """
    length = diffusion_length(thickness, diffusivity, faces)
    return uptake(fourier_number(time, length, diffusivity))


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
    """Moisture in the cross-section of a bar whose sides are exposed too, after a step.

    What is left of the change is the product of what is left in two slabs (Crank, *The
    Mathematics of Diffusion*, section 2.5).

    Parameters
    ----------
    y : array_like, shape (m,)
        Through the thickness in m, -h/2 to h/2.
    z : array_like, shape (n,)
        Across the width in m, -w/2 to w/2.
    time : array_like, shape (t,)
        Since the step in s.
    thickness, width : float
        In m.
    diffusivity_y, diffusivity_z : float
        Through the thickness and across the width in m^2/s.
    faces : {"both", "lower", "upper"}
        Faces exposed, of those at the ends of y; both sides are.
    initial, surface : float
        Before the step everywhere, and after it at the exposed surfaces.

    Returns
    -------
    ndarray, shape (t, m, n)

    Raises
    ------
    InputError
        If a place lies outside the bar, a time is negative, or the bar is no bar.
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
    """Part of its final change that the mean moisture of a bar has made after a step.

    Parameters
    ----------
    time : array_like, shape (t,)
        Since the step in s.
    thickness, width : float
        In m.
    diffusivity_y, diffusivity_z : float
        Through the thickness and across the width in m^2/s.
    faces : {"both", "lower", "upper"}
        Faces exposed, of those at the ends of the thickness; both sides are.

    Returns
    -------
    ndarray, shape (t,)

    Raises
    ------
    InputError
        If a time is negative or the bar is no bar.
    """
    through = slab_uptake(time, thickness, diffusivity_y, faces=faces)
    across = slab_uptake(time, width, diffusivity_z)
    return through + across - through * across


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
    return fourier_number_of(fraction) * length**2 / diffusivity
