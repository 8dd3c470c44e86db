"""Waves across the width of a bar, in which diffusion through its sides falls apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.types import FloatArray


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves across the width of a bar whose sides are in the same ambient conditions.

    Parameters
    ----------
    rate : ndarray, shape (m,)
        Decay over the diffusivity across the width in 1/m^2; 0 for a slab.
    mean : ndarray, shape (m,)
        Mean of each wave over the width; also the part of a uniform saturation in it.
    shape : ndarray, shape (m, k)
        The waves in the cells of half the width, from the middle to the side.
    boundaries : ndarray, shape (k + 1,)
        Of those cells in m, from the middle.
    """

    rate: FloatArray
    mean: FloatArray
    shape: FloatArray
    boundaries: FloatArray

    @classmethod
    def none(cls) -> Waves:
        """Those of a slab: the same all over the width."""
        one = np.ones(1)
        return cls(np.zeros(1), one, one[:, None], np.array([0.0, np.inf]))


def side_waves(boundaries: FloatArray) -> Waves:
    """Waves in half a width whose side is exposed, exact for its finite volumes.

    They are the singular vectors of the differences between cells, which keeps small rates as
    accurate as large ones.

    Parameters
    ----------
    boundaries : ndarray, shape (k + 1,)
        Of the cells in m, from the middle at 0 to the side.

    Returns
    -------
    Waves
    """
    sizes = np.diff(boundaries)
    half = boundaries[-1]
    weights = sizes / half
    # Conductance over the half width from each cell outward, the last one to the side itself.
    outward = 1 / (half * np.append((sizes[1:] + sizes[:-1]) / 2, sizes[-1] / 2))
    cells = sizes.size
    difference = np.diag(np.ones(cells)) - np.diag(np.ones(cells - 1), 1)
    scaled = np.sqrt(outward)[:, None] * difference / np.sqrt(weights)
    _, values, vectors = np.linalg.svd(scaled)
    shape = vectors / np.sqrt(weights)
    return Waves(values**2, shape @ weights, shape, boundaries)
