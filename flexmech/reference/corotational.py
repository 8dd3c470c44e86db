"""Geometrically nonlinear plane beam elements in corotational coordinates.

An element's pure deformation is its elongation and what its nodes turn and bend against
its chord; large rotations are those of the chord. The axial strain is averaged over the
element and contains the slopes (shallow arch), so that the tangent at a straight, tensioned
element is exactly eq. 1.58 of Kumar & Chandrakar and no membrane locking appears. After
Crisfield, *Non-linear Finite Element Analysis of Solids and Structures*, vol. 1 (1991),
ch. 7. Where the neutral axis is off the pins' axis, rigid arms that turn with the nodes
lead to it. Without load an element has the strain and the curvature that its section takes
by itself: the strain is that of the arc, so that a chord shortens as it bends.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.beams.elements import BeamElements
from flexmech.types import FloatArray, IntArray

__all__ = ["CorotationalElements"]


@dataclass(frozen=True)
class CorotationalElements:
    """Elements of one link that may turn by any angle and bend by small ones.

    Parameters
    ----------
    elements : BeamElements
        Their small displacements: e elements of p coordinates a node.
    """

    elements: BeamElements

    def response(
        self, displacement: FloatArray, swelling: float = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Internal forces and tangent stiffness of deformed elements.

        Parameters
        ----------
        displacement : ndarray, shape (B, e, 2 p)
            Coordinates of each element's nodes in the frame of the straight link.
        swelling : float
            Part of the section's free strain and curvature that has come on.

        Returns
        -------
        force : ndarray, shape (B, e, 2 p)
        tangent : ndarray, shape (B, e, 2 p, 2 p)
        """
        arms = _Arms.of(self.elements, displacement)
        pure = self._pure(arms.moved(displacement))
        length, axial = self.elements.length, self._axial_stiffness
        free = swelling * self.elements.section.free_strain
        tension = axial * (pure.strain - free)
        moments = (tension * length)[..., None] * pure.lift
        bent = pure.turns - swelling * self._arc
        moments = moments + np.einsum("eij,bej->bei", self._bending, bent)
        force = tension[..., None] * pure.along
        force = force + np.einsum("bek,beki->bei", moments, pure.gradients[..., 1:, :])

        local = self._local(pure, axial, self._bending)
        local[..., 1:, 1:] += (tension * length)[..., None, None] * self._arch
        tangent = np.swapaxes(pure.gradients, -1, -2) @ (local @ pure.gradients)
        couple = moments @ self._turning
        along_turn = pure.along[..., :, None] * pure.turning[..., None, :]
        along_turn = along_turn + np.swapaxes(along_turn, -1, -2)
        turn_turn = pure.turning[..., :, None] * pure.turning[..., None, :]
        tangent += (tension * pure.chord)[..., None, None] * turn_turn
        tangent += (couple / pure.chord)[..., None, None] * along_turn
        return arms.force(force), arms.tangent(force, tangent)

    def damping(self, displacement: FloatArray) -> FloatArray:
        """Kelvin-Voigt damping matrix of deformed elements.

        A bowed element that bends further stretches no fibre on its axis, and nothing is to
        be damped there: only what strains the material counts, not the part of the tangent
        that comes from the stress.

        Parameters
        ----------
        displacement : ndarray, shape (B, e, 2 p)
            As in :meth:`response`.

        Returns
        -------
        ndarray, shape (B, e, 2 p, 2 p)
        """
        arms = _Arms.of(self.elements, displacement)
        pure = self._pure(arms.moved(displacement))
        axial = self.elements.section.damping.axial * self._axial_stiffness
        own = self._coordinates
        bending = self.elements.neutral_damping[:, own[:, None], own]
        local = self._local(pure, axial, bending)
        matrix = np.swapaxes(pure.gradients, -1, -2) @ (local @ pure.gradients)
        return arms.tangent(None, matrix)

    @cached_property
    def _coordinates(self) -> IntArray:
        """An element's coordinates that turn and bend it: all but displacements, (k,)."""
        per_node = self.elements.shapes.per_node
        every = np.arange(2 * per_node)
        return every[every % per_node >= 2]

    @cached_property
    def _turning(self) -> FloatArray:
        """1 for those of them that are angles, 0 for the others, (k,)."""
        shapes = self.elements.shapes
        return np.isin(self._coordinates % shapes.per_node, shapes.angles).astype(float)

    @cached_property
    def _arc(self) -> FloatArray:
        """Turns of the nodes of elements without load, (e, k)."""
        return self.elements.shapes.arc(self.elements.section, self.elements.length)

    @cached_property
    def _bending(self) -> FloatArray:
        own = self._coordinates
        return self.elements.neutral_stiffness[:, own[:, None], own]

    @cached_property
    def _arch(self) -> FloatArray:
        own = self._coordinates
        return self.elements.arch[:, own[:, None], own]

    @cached_property
    def _axial_stiffness(self) -> float:
        return float(self.elements.neutral_stiffness[0, 0, 0] * self.elements.length[0])

    def _pure(self, displacement: FloatArray) -> _PureDeformation:
        per_node = self.elements.shapes.per_node
        length = self.elements.length
        u1, v1, u2, v2 = (displacement[..., i] for i in (0, 1, per_node, per_node + 1))
        du, dv = u2 - u1, v2 - v1
        chord = np.hypot(length + du, dv)
        # (chord^2 - length^2) / (chord + length): no cancellation at small strain
        elongation = (2 * length * du + du**2 + dv**2) / (chord + length)
        cosine, sine = (length + du) / chord, dv / chord
        turned = np.arctan2(dv, length + du)
        turns = displacement[..., self._coordinates] - turned[..., None] * self._turning
        lift = np.einsum("eij,bej->bei", self._arch, turns)

        along = np.zeros_like(displacement)
        along[..., 0], along[..., 1] = -cosine, -sine
        along[..., per_node], along[..., per_node + 1] = cosine, sine
        turning = np.zeros_like(displacement)
        turning[..., 0], turning[..., 1] = sine, -cosine
        turning[..., per_node], turning[..., per_node + 1] = -sine, cosine
        turning /= chord[..., None]
        gradients = np.zeros((*chord.shape, 1 + len(self._coordinates), displacement.shape[-1]))
        gradients[..., 0, :] = along
        gradients[..., 1:, :] = -self._turning[:, None] * turning[..., None, :]
        gradients[..., 1 + np.arange(len(self._coordinates)), self._coordinates] += 1.0
        strain = elongation / length + np.einsum("bei,bei->be", turns, lift) / 2
        return _PureDeformation(chord, strain, turns, lift, along, turning, gradients)

    def _local(
        self, pure: _PureDeformation, axial_stiffness: float, bending: FloatArray
    ) -> FloatArray:
        """Derivative of tension and moments by the pure deformation at constant arch."""
        length = self.elements.length
        count = pure.lift.shape[-1]
        local = np.empty((*pure.chord.shape, 1 + count, 1 + count))
        local[..., 0, 0] = axial_stiffness / length
        local[..., 0, 1:] = local[..., 1:, 0] = axial_stiffness * pure.lift
        lifted = pure.lift[..., :, None] * pure.lift[..., None, :]
        local[..., 1:, 1:] = (axial_stiffness * length)[:, None, None] * lifted + bending
        return local


@dataclass(frozen=True)
class _PureDeformation:
    """Deformation of elements (B, e) against their chords, and its gradients.

    ``turns`` are the nodes' k turns and bends, ``lift`` the derivative of the axial strain
    by them; ``along`` and ``turning`` the gradients of elongation and of the chord's angle.
    """

    chord: FloatArray
    strain: FloatArray
    turns: FloatArray
    lift: FloatArray
    along: FloatArray
    turning: FloatArray
    gradients: FloatArray


@dataclass(frozen=True)
class _Arms:
    """Rigid arms from the pins' axis to the nodes of the neutral axis.

    Parameters
    ----------
    per_node : int
    places : tuple of int
        Coordinates of an element that turn an arm.
    sine, cosine : ndarray, shape (B, e, number of places)
        Arm times sine and cosine of its angle, in m.
    lowered : ndarray, shape (B, e, number of places)
        Arm times one less the cosine.
    """

    per_node: int
    places: tuple[int, ...]
    sine: FloatArray
    cosine: FloatArray
    lowered: FloatArray

    @classmethod
    def of(cls, elements: BeamElements, displacement: FloatArray) -> _Arms:
        """Arms of displaced elements; none where the neutral axis is the pins' axis."""
        shapes, per_node = elements.shapes, elements.shapes.per_node
        arms = [
            (a, arm) for a, arm in zip(shapes.angles, shapes.arms(elements.section), strict=True)
        ]
        used = [(first + a, arm) for first in (0, per_node) for a, arm in arms if arm]
        places = tuple(place for place, _ in used)
        length = np.array([arm for _, arm in used])
        angle = displacement[..., places]
        cosine = length * np.cos(angle)
        return cls(
            per_node, places, length * np.sin(angle), cosine, 2 * length * np.sin(angle / 2) ** 2
        )

    def moved(self, displacement: FloatArray) -> FloatArray:
        """Displacements of the neutral axis's nodes."""
        if not self.places:
            return displacement
        moved = displacement.copy()
        for number, first in enumerate(self._firsts):
            moved[..., first] -= self.sine[..., number]
            moved[..., first + 1] -= self.lowered[..., number]
        return moved

    def force(self, force: FloatArray) -> FloatArray:
        """Forces on the pins' axis of forces on the neutral axis's nodes."""
        if not self.places:
            return force
        return np.asarray(np.einsum("beji,bej->bei", self._gradient(force.shape[-1]), force))

    def tangent(self, force: FloatArray | None, tangent: FloatArray) -> FloatArray:
        """Tangent on the pins' axis; without ``force`` its part that turns the force is left."""
        if not self.places:
            return tangent
        gradient = self._gradient(tangent.shape[-1])
        total = np.swapaxes(gradient, -1, -2) @ (tangent @ gradient)
        if force is not None:
            for number, (place, first) in enumerate(zip(self.places, self._firsts, strict=True)):
                total[..., place, place] += (
                    force[..., first] * self.sine[..., number]
                    - force[..., first + 1] * self.cosine[..., number]
                )
        return total

    @property
    def _firsts(self) -> list[int]:
        """First coordinate of the node that each arm belongs to."""
        return [place - place % self.per_node for place in self.places]

    def _gradient(self, size: int) -> FloatArray:
        gradient = np.zeros((*self.sine.shape[:-1], size, size))
        gradient[..., np.arange(size), np.arange(size)] = 1.0
        for number, (place, first) in enumerate(zip(self.places, self._firsts, strict=True)):
            gradient[..., first, place] = -self.cosine[..., number]
            gradient[..., first + 1, place] = -self.sine[..., number]
        return gradient
