"""Fick's law in slabs and bars by series, dry at first and wet at the faces.

Crank, *The Mathematics of Diffusion*: a slab with one sealed face is half of one twice as thick,
and of a change a bar has left the product of what two slabs have.
"""

from __future__ import annotations

import numpy as np


def left_over(places, times, thickness, diffusivity, faces="both"):
    """Part of a change at the faces that is still to come (Crank, eq. 4.17), (t, m)."""
    place = np.atleast_1d(places)
    if faces != "both":
        place, thickness = place + (-1, 1)[faces == "lower"] * -thickness / 2, 2 * thickness
    odd = 2 * np.arange(400)[:, None, None] + 1
    fourier = diffusivity * np.atleast_1d(times)[:, None] / thickness**2
    waves = np.cos(odd * np.pi * place / thickness) * np.exp(-((odd * np.pi) ** 2) * fourier)
    return 4 / np.pi * np.sum((-1.0) ** (odd // 2) / odd * waves, axis=0)


def slab_profile(places, times, thickness, diffusivity, *, faces="both"):
    """Saturation at places from the mid-plane and times, (t, m)."""
    return 1 - left_over(places, times, thickness, diffusivity, faces)


def slab_uptake(times, thickness, diffusivity, *, faces="both"):
    """Mean saturation (Crank, eq. 4.18)."""
    odd = 2 * np.arange(4000)[:, None] + 1
    size = thickness if faces == "both" else 2 * thickness
    fourier = diffusivity * np.asarray(times) / size**2
    return 1 - np.sum(8 / (odd * np.pi) ** 2 * np.exp(-((odd * np.pi) ** 2) * fourier), axis=0)


def bar_profile(y, z, times, thickness, width, through, across, *, faces="both"):
    """Saturation over the section of a bar whose sides are wet too, (t, m, n)."""
    first = left_over(y, times, thickness, through, faces)
    return 1 - first[:, :, None] * left_over(z, times, width, across)[:, None]


def bar_uptake(times, thickness, width, through, across, *, faces="both"):
    first = slab_uptake(times, thickness, through, faces=faces)
    second = slab_uptake(times, width, across)
    return first + second - first * second
