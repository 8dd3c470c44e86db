"""Diffusion of water into a slab: the numerical solution and the series."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.materials import moisture
from flexmech.materials.moisture import slab

# In m and m^2/s, as those of laminates are; uptake over the Fourier number does not depend on them.
THICKNESS, DIFFUSIVITY = 2e-3, 1e-12
UNIT = THICKNESS**2 / DIFFUSIVITY
SLAB = moisture.DiffusionLayer(THICKNESS, moisture.Diffusivity(DIFFUSIVITY), 60.0)


def slab_uptake(
    time: FloatArray, thickness: float, diffusivity: float, *, faces: moisture.Faces = "both"
) -> FloatArray:
    """Part of its final change that the mean of a slab has made: Crank's eqs. 4.18 and 4.20.

    Parameters
    ----------
    time : ndarray, shape (t,)
        In s.
    thickness : float
        In m.
    diffusivity : float
        In m^2/s.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (t,)
    """
    length = slab.diffusion_length(thickness, diffusivity, faces)
    fourier = slab.fourier_number(time, length, diffusivity)
    early = fourier < slab.FOURIER_OF_CHANGE
    return np.asarray(
        np.where(early, slab.early_uptake(fourier), 1 - slab.remaining_uptake(fourier))
    )


def series_uptake(*, fourier: Sequence[float], faces: moisture.Faces) -> FloatArray:
    """Uptake of a slab by series.

    Parameters
    ----------
    fourier : sequence of float
        Fourier numbers of the slab's thickness.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (n,)
    """
    return slab_uptake(UNIT * np.asarray(fourier, dtype=float), THICKNESS, DIFFUSIVITY, faces=faces)


def _history(fourier: Sequence[float], faces: moisture.Faces) -> moisture.MoistureHistory:
    water = moisture.Ambient.constant(1.0, 293.15)
    return moisture.diffuse([SLAB], water, UNIT * np.asarray(fourier, dtype=float), faces=faces)


def diffused_uptake(*, fourier: Sequence[float], faces: moisture.Faces) -> FloatArray:
    """Uptake of a slab by the numerical diffusion.

    Parameters
    ----------
    fourier : sequence of float
        Fourier numbers of the slab's thickness.
    faces : {"both", "lower", "upper"}
        Those exposed.

    Returns
    -------
    ndarray, shape (n,)
    """
    return _history(fourier, faces).uptake


def mass_balance_errors(*, fourier: Sequence[float], faces: Sequence[moisture.Faces]) -> FloatArray:
    """Water that the numerical diffusion loses or makes, over that at the end.

    Parameters
    ----------
    fourier : sequence of float
        Fourier numbers of the slab's thickness.
    faces : sequence of {"both", "lower", "upper"}
        Those exposed: one number for each.

    Returns
    -------
    ndarray, shape (n,)
    """
    return np.array([_history(fourier, which).mass_balance_error for which in faces])


def half_time() -> FloatArray:
    """Fourier number at half saturation, by the series."""
    return np.array([moisture.time_to_saturation(0.5, 1.0, 1.0)])


def crank_half_time() -> FloatArray:
    """Fourier number at half saturation as Crank's section 10.3 approximates it."""
    share = np.pi**2 / 16
    return np.array([-np.log(share - share**9 / 9) / np.pi**2])
