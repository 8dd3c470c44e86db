"""Pictures at one scale along x and y: their heights, and round lengths for scale bars."""

from __future__ import annotations

import numpy as np
from matplotlib.transforms import Bbox


def height_of(limits: Bbox, width: float, least: float, most: float) -> float:
    """Height of a panel of a width that shows what is within limits at one scale.

    Parameters
    ----------
    limits : Bbox
    width, least, most : float
        Width of the panel, and what its height may be, in inches.

    Returns
    -------
    float
    """
    return float(min(max(width * limits.height / limits.width, least), most))


def round_length(most: float) -> float:
    """Longest of 1, 2 and 5 times a power of ten that is not above a length."""
    decade = 10.0 ** np.floor(np.log10(most))
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= most * (1 + 1e-9)))
