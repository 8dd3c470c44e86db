"""A slab in units of diffusion: which faces are exposed, how far water goes, how long it takes."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.numbers import check_choice
from flexmech.types import FloatArray

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
