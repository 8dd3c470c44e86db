"""The equation of the curve that a coupler point traces: a tricircular sextic."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.linkages.coupler_curve import CouplerPoint
from flexmech.linkages.fourbar import FourBar
from flexmech.types import FloatArray


def coupler_sextic(linkage: FourBar, point: CouplerPoint, position: ArrayLike) -> FloatArray:
    """Residual of the coupler curve's equation, zero on the curves of all its circuits.

    The circles on which A and B stay, about O2 and O4 and about E, are linear in the sine and
    the cosine of the coupler's angle, which are eliminated (S. Roberts 1876; Hartenberg &
    Denavit 1964, ch. 6). With d the ground, a and c crank and rocker, e and f the distances of
    E from A and B under the angle epsilon, r2 and r4 those from O2 and O4:

        U = r2^2 + e^2 - a^2,    V = r4^2 + f^2 - c^2,    W = x^2 - x d + y^2,
        f^2 r4^2 U^2 + e^2 r2^2 V^2 - 2 e f U V (W cos epsilon + y d sin epsilon)
            = 4 e^2 f^2 (y d cos epsilon - W sin epsilon)^2.

    The right side vanishes on the circle of singular foci, on which the double points lie. The
    highest power is b^2 r2^6, b being the coupler's length.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    point : CouplerPoint
    position : array_like, shape (..., 2)
        Places (x, y) in ground axes in m.

    Returns
    -------
    ndarray, shape (...)
        Left less right side over b^2 (a + e)^6, where a + e is the longest reach from O2:
        about (r2 / (a + e))^6 far from the curve, some 1e-14 on it.

    Raises
    ------
    InputError
        If the last axis of the places is not of length two.
    """
    place = np.asarray(position, dtype=float)
    if place.ndim == 0 or place.shape[-1] != 2:
        raise InputError(
            f"places must be (x, y) along their last axis, got an array of shape {place.shape}"
        )
    e, f, cosine, sine = point.triangle(linkage.coupler)
    ground = linkage.ground
    x, y = place[..., 0], place[..., 1]
    r2, r4 = x**2 + y**2, (x - ground) ** 2 + y**2
    u = r2 + e**2 - linkage.crank**2
    v = r4 + f**2 - linkage.rocker**2
    w = r2 - x * ground
    left = (f * u) ** 2 * r4 + (e * v) ** 2 * r2
    left -= 2 * e * f * u * v * (w * cosine + y * ground * sine)
    right = (2 * e * f * (y * ground * cosine - w * sine)) ** 2
    residual: FloatArray = (left - right) / (linkage.coupler**2 * (linkage.crank + e) ** 6)
    return residual
