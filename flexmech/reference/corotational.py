"""A geometrically nonlinear plane beam element in corotational coordinates.

The element's pure deformation is its elongation and the two slopes against its chord;
large rotations are those of the chord. The axial strain is averaged over the element and
contains the slopes (shallow arch), so that the tangent at a straight, tensioned element is
exactly eq. 1.58 of Kumar & Chandrakar and no membrane locking appears. After Crisfield,
*Non-linear Finite Element Analysis of Solids and Structures*, vol. 1 (1991), ch. 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["corotational_response", "material_stiffness"]

FloatArray = NDArray[np.float64]


def corotational_response(
    displacement: FloatArray,
    length: FloatArray,
    axial_stiffness: FloatArray,
    bending_stiffness: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Internal forces and tangent stiffness of deformed elements.

    Parameters
    ----------
    displacement : ndarray, shape (B, e, 6)
        (u1, v1, phi1, u2, v2, phi2) of each element in the frame of the straight link.
    length, axial_stiffness, bending_stiffness : ndarray, shape (e,)
        Undeformed element length in m, EA in N, EI in N m^2.

    Returns
    -------
    force : ndarray, shape (B, e, 6)
    tangent : ndarray, shape (B, e, 6, 6)
    """
    pure = _PureDeformation.of(displacement, length)
    tension = axial_stiffness * pure.strain
    bending = bending_stiffness / length
    moment1 = tension * length * pure.arch1 + bending * (4 * pure.slope1 + 2 * pure.slope2)
    moment2 = tension * length * pure.arch2 + bending * (4 * pure.slope2 + 2 * pure.slope1)
    stresses = np.stack([tension, moment1, moment2], axis=-1)
    force = np.einsum("...k,...ki->...i", stresses, pure.gradients)

    local = _local_stiffness(pure, length, axial_stiffness, bending_stiffness)
    local[..., 1, 1] += tension * length * 4 / 30
    local[..., 2, 2] += tension * length * 4 / 30
    local[..., 1, 2] -= tension * length / 30
    local[..., 2, 1] -= tension * length / 30
    tangent = np.swapaxes(pure.gradients, -1, -2) @ (local @ pure.gradients)
    along, turning = pure.gradients[..., 0, :], pure.turning
    turn_turn = turning[..., :, None] * turning[..., None, :]
    along_turn = along[..., :, None] * turning[..., None, :]
    along_turn = along_turn + np.swapaxes(along_turn, -1, -2)
    tangent += (tension * pure.chord)[..., None, None] * turn_turn
    tangent += ((moment1 + moment2) / pure.chord)[..., None, None] * along_turn
    return force, tangent


def material_stiffness(
    displacement: FloatArray,
    length: FloatArray,
    axial_stiffness: FloatArray,
    bending_stiffness: FloatArray,
) -> FloatArray:
    """Part of the tangent that strains the material, without that of the stress.

    Kelvin-Voigt damping is ``tau`` times it: a bowed element that bends further stretches
    no fibre on its axis, and nothing is to be damped there.

    Parameters
    ----------
    displacement, length, axial_stiffness, bending_stiffness : ndarray
        As in :func:`corotational_response`.

    Returns
    -------
    ndarray, shape (B, e, 6, 6)
    """
    pure = _PureDeformation.of(displacement, length)
    local = _local_stiffness(pure, length, axial_stiffness, bending_stiffness)
    return np.asarray(np.swapaxes(pure.gradients, -1, -2) @ (local @ pure.gradients))


@dataclass(frozen=True)
class _PureDeformation:
    """Elongation and slopes against the chord of elements (B, e), and their gradients."""

    chord: FloatArray
    strain: FloatArray
    slope1: FloatArray
    slope2: FloatArray
    arch1: FloatArray
    arch2: FloatArray
    turning: FloatArray
    gradients: FloatArray

    @classmethod
    def of(cls, displacement: FloatArray, length: FloatArray) -> _PureDeformation:
        u1, v1, phi1, u2, v2, phi2 = np.moveaxis(displacement, -1, 0)
        du, dv = u2 - u1, v2 - v1
        chord = np.hypot(length + du, dv)
        # (chord^2 - length^2) / (chord + length): no cancellation at small strain
        elongation = (2 * length * du + du**2 + dv**2) / (chord + length)
        cosine, sine = (length + du) / chord, dv / chord
        turned = np.arctan2(dv, length + du)
        slope1, slope2 = phi1 - turned, phi2 - turned

        zero, one = np.zeros_like(chord), np.ones_like(chord)
        along = np.stack([-cosine, -sine, zero, cosine, sine, zero], axis=-1)
        turning = np.stack([sine, -cosine, zero, -sine, cosine, zero], axis=-1)
        turning = turning / chord[..., None]
        node1 = np.stack([zero, zero, one, zero, zero, zero], axis=-1) - turning
        node2 = np.stack([zero, zero, zero, zero, zero, one], axis=-1) - turning
        return cls(
            chord=chord,
            strain=elongation / length + (2 * slope1**2 - slope1 * slope2 + 2 * slope2**2) / 30,
            slope1=slope1,
            slope2=slope2,
            arch1=(4 * slope1 - slope2) / 30,
            arch2=(4 * slope2 - slope1) / 30,
            turning=turning,
            gradients=np.stack([along, node1, node2], axis=-2),
        )


def _local_stiffness(
    pure: _PureDeformation,
    length: FloatArray,
    axial_stiffness: FloatArray,
    bending_stiffness: FloatArray,
) -> FloatArray:
    """Derivative of tension and moments by the pure deformation at constant arch, (B, e, 3, 3)."""
    bending, membrane = bending_stiffness / length, axial_stiffness * length
    arch1, arch2 = pure.arch1, pure.arch2
    local = np.empty((*pure.chord.shape, 3, 3))
    local[..., 0, 0] = axial_stiffness / length
    local[..., 0, 1] = local[..., 1, 0] = axial_stiffness * arch1
    local[..., 0, 2] = local[..., 2, 0] = axial_stiffness * arch2
    local[..., 1, 1] = membrane * arch1**2 + 4 * bending
    local[..., 2, 2] = membrane * arch2**2 + 4 * bending
    local[..., 1, 2] = local[..., 2, 1] = membrane * arch1 * arch2 + 2 * bending
    return local
