"""Strain and stress inside a section, and by which theory shear stress is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.model_text import shapes, short_repr

LayerDirection = Literal["through thickness", "across width"]
"""Of a stack: in the plane of the linkage, or along the joint axes, its plies parallel to it."""

ShearTheory = Literal["equilibrium", "third-order"]
SHEAR_THEORIES: tuple[ShearTheory, ...] = get_args(ShearTheory)


@dataclass(frozen=True, repr=False)
class ThroughThickness:
    """Strain and stress at places through the thickness, all of one shape.

    Parameters
    ----------
    place : ndarray
        Distance y from the mid-plane in m.
    strain : ndarray
        Along the link.
    normal_stress, shear_stress : ndarray
        Along the link, and on its cross-section in the plane of the linkage, in Pa.
    """

    place: FloatArray
    strain: FloatArray
    normal_stress: FloatArray
    shear_stress: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))


def check_loads(loads: Sequence[float]) -> None:
    """Refuse loads on a section that are no numbers.

    Parameters
    ----------
    loads : sequence of float
        In N and N m.

    Raises
    ------
    InputError
        If one is not finite.
    """
    if not np.all(np.isfinite(np.array(loads, dtype=float))):
        raise InputError(f"loads on a section must be finite, got {list(map(float, loads))}")
