"""How far the joints of a link keep it from twisting as its off-axis plies bend.

A laminate with plies off the link's axis twists as it bends (``D16``). Where pins along the joint
axes hold both ends, the ends cannot turn about the link's axis: a torque along the whole link,
the same everywhere, takes the twist back on the average. It adds the energy
``c^2 GJ (phi_2 - phi_1)^2 / (2 L)``, with c the twist that a unit of curvature brings, GJ the
torsional stiffness and phi the rotations of the ends. A half sine, the first mode between pins,
meets ``8 / pi^2`` of ``c^2 GJ``; the second mode, which turns both ends alike, nothing.

GJ is Saint-Venant's of an orthotropic rectangle (Lekhnitskii, *Theory of Elasticity of an
Anisotropic Body*, 1963, sec. 36; Timoshenko & Goodier, *Theory of Elasticity*, sec. 109): the
shear stress of torsion turns round at the edges of the width, within a layer of about the
thickness. A link as wide as thick holds little of the plate's torsional stiffness, a wide one all.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from flexmech.types import FloatArray

__all__ = ["TWISTS", "Twist", "torsion_factor", "twist_restraint"]

Twist = Literal["free", "held"]
TWISTS: tuple[Twist, ...] = get_args(Twist)

FIRST_MODE = 8 / np.pi**2
"""Share of the twist's energy that a half sine between two joints meets."""
# Of Saint-Venant's series, whose terms fall off with the fifth power.
TERMS = 100
# Coupling of bending and twist below which a stack has none.
ROUNDING = 1e-12


def torsion_factor(slenderness: float) -> float:
    """Torsional stiffness of a rectangle over that of a plate as wide, ``4 G_xz b h^3 / 12``.

    Parameters
    ----------
    slenderness : float
        Width over thickness, times the root of the shear modulus through the thickness over
        that in the plane of the plies.

    Returns
    -------
    float
        From 0 to 1; ``1 - 0.63 / slenderness`` where that is large.
    """
    odd = np.arange(1, 2 * TERMS, 2)
    layers = np.tanh(odd * np.pi * slenderness / 2) / odd**5
    return float(1 - 192 / np.pi**5 * layers.sum() / slenderness)


def twist_restraint(
    stiffness: FloatArray, thickness: float, width: float, shear_modulus: float
) -> float:
    """Where the bending stiffness stands between twist free (0) and no twist at all (1).

    Parameters
    ----------
    stiffness : ndarray, shape (3, 3)
        By strain along the link, its gradient in y, and the gradient of the shear strain in the
        plane of the plies, for each metre of width.
    thickness, width : float
        In m.
    shear_modulus : float
        Effective modulus of shear through the thickness in Pa.

    Returns
    -------
    float
    """
    compliance = np.linalg.inv(stiffness)
    coupling = compliance[:2, 2]
    bending, twisting = compliance[1, 1], compliance[2, 2]
    if coupling[1] ** 2 <= ROUNDING * bending * twisting:
        return 0.0
    in_plane = 12 / (thickness**3 * twisting)
    factor = torsion_factor(width / thickness * np.sqrt(shear_modulus / in_plane))

    def bending_stiffness(part: float) -> float:
        """About the neutral axis, with a part of the plate's torsional stiffness."""
        return float(1 / (bending - part * coupling[1] ** 2 / twisting))

    free, held = bending_stiffness(0.0), bending_stiffness(1.0)
    return FIRST_MODE * (bending_stiffness(factor) - free) / (held - free)
