"""Stiffness of a layer in three dimensions, from what is known of its ply in plane stress."""

from __future__ import annotations

import numpy as np

from flexmech.materials.laminate import Layer
from flexmech.materials.ply import Ply
from flexmech.types import FloatArray

# Of Poisson's ratio across the fibres where G23 says more: a ply that is not alike in 2 and 3.
GREATEST_RATIO = 0.5
# Distance from incompressible, in the range that a ratio may have.
MARGIN = 0.02


def solid_stiffness(layer: Layer) -> FloatArray:
    """Stiffness by strains x, y, z, yz, xz and xy in laminate axes, (6, 6), in Pa.

    Through its thickness a ply is taken to be as stiff as across its fibres (``E3 = E2``,
    ``nu13 = nu12``), and ``nu23 = E2 / (2 G23) - 1``: transversely isotropic, as unidirectional
    plies are. In plane stress these assumed values cancel.

    Parameters
    ----------
    layer : Layer

    Returns
    -------
    ndarray, shape (6, 6)
    """
    c, s = np.cos(layer.angle), np.sin(layer.angle)
    turn = np.zeros((6, 6))
    in_plane = [0, 2, 4]
    turn[np.ix_(in_plane, in_plane)] = layer.strain_turn
    turn[1, 1] = 1.0
    through = [3, 5]
    turn[np.ix_(through, through)] = [[c, -s], [s, c]]
    return np.asarray(turn.T @ np.linalg.inv(_compliance(layer.ply)) @ turn)


def _compliance(ply: Ply) -> FloatArray:
    """By stresses 1, 3, 2, 23, 12 and 13 of the ply, (6, 6)."""
    along, across = ply.longitudinal_modulus, ply.transverse_modulus
    contraction = ply.poisson_ratio / along
    compliance = np.diag(
        1
        / np.array(
            [
                along,
                across,
                across,
                ply.transverse_shear_modulus,
                ply.in_plane_shear_modulus,
                ply.longitudinal_shear_modulus,
            ]
        )
    )
    compliance[0, 1:3] = compliance[1:3, 0] = -contraction
    compliance[1, 2] = compliance[2, 1] = -_ratio_across(ply) / across
    return compliance


def _ratio_across(ply: Ply) -> float:
    """Poisson's ratio nu23, for which no stress does negative work."""
    span = 2 * (1 - ply.poisson_ratio**2 * ply.transverse_modulus / ply.longitudinal_modulus)
    isotropic = ply.transverse_modulus / (2 * ply.transverse_shear_modulus) - 1
    upper = min(GREATEST_RATIO, -1 + (1 - MARGIN) * span)
    return float(np.clip(isotropic, -1 + MARGIN * span, upper))
