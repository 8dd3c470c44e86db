"""Constants of corotational elements, of one design or of several, and their rigid arms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import BeamElements


@dataclass(frozen=True)
class ElementNumbers:
    """Constants of e elements, by which their forces are computed.

    Those of one design are the same in all positions; those of several are given in each of B.

    Parameters
    ----------
    length : ndarray, shape (e, 1) or (e, B)
        In m.
    axial_stiffness : ndarray, shape () or (B,)
        EA in N.
    bending, arch : ndarray, shape (e, k, k) or (e, k, k, B)
        Stiffness against what turns and bends an element, and mean of the squared slope.
    """

    length: FloatArray
    axial_stiffness: FloatArray
    bending: FloatArray
    arch: FloatArray

    def at(self, designs: IntArray) -> ElementNumbers:
        """Numbers of D designs (..., D) in positions (B,)."""
        return ElementNumbers(*(in_positions(values, designs) for values in vars(self).values()))


@dataclass(frozen=True)
class RigidArms:
    """Rigid arms at the nodes of an element, in its relative coordinates.

    An arm of length ``a`` at angle ``phi`` moves the neutral axis's node by ``-a sin(phi)`` along
    and ``-a (1 - cos(phi))`` across.

    Parameters
    ----------
    places : tuple of int
        Relative coordinates that turn an arm; none where the neutral axis is the pins' axis.
    length : ndarray, shape (number of places, 1)
        In m; with its sign turned for arms of the first node, against which the second moves.
    """

    places: tuple[int, ...]
    length: FloatArray

    @classmethod
    def of(cls, elements: BeamElements) -> RigidArms:
        """Arms of elements."""
        shapes = elements.shapes
        arms = [
            (a, arm)
            for a, arm in zip(shapes.angles, shapes.arms(elements.section), strict=True)
            if arm
        ]
        ends = ((0, -1.0), (shapes.per_node - 2, 1.0))
        used = [(first + a, sign * arm) for first, sign in ends for a, arm in arms]
        places = tuple(place for place, _ in used)
        return cls(places, np.array([arm for _, arm in used]).reshape(-1, 1))

    def moved(self, relative: FloatArray) -> FloatArray:
        """Relative coordinates (e, r, B) of the nodes on the neutral axis."""
        if not self.places:
            return relative
        angle = relative[:, self.places]
        moved = relative.copy()
        moved[:, 0] -= (self.length * np.sin(angle)).sum(axis=1)
        moved[:, 1] -= (2 * self.length * np.sin(angle / 2) ** 2).sum(axis=1)
        return moved

    def turn(self, relative: FloatArray, force: FloatArray | None, tangent: FloatArray) -> None:
        """Transform forces and a tangent from the neutral axis to the pins' axis, in place.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)
            On the pins' axis.
        force : ndarray, shape (e, r, B), optional
            Without it the part of the tangent that turns it is left out.
        tangent : ndarray, shape (e, r, r, B)
        """
        if not self.places:
            return
        angle = relative[:, self.places]
        sine, cosine = self.length * np.sin(angle), self.length * np.cos(angle)
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, place] -= c[:, None] * tangent[:, 0] + s[:, None] * tangent[:, 1]
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, :, place] -= c[:, None] * tangent[:, :, 0] + s[:, None] * tangent[:, :, 1]
            if force is not None:
                tangent[:, place, place] += force[:, 0] * s - force[:, 1] * c
                force[:, place] -= force[:, 0] * c + force[:, 1] * s


def in_positions(values: FloatArray, which: IntArray) -> FloatArray:
    """Values (..., B) in some positions, which stay along memory: by an index they would not."""
    return np.take(values, which, axis=-1)


def by_elements(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) of elements times columns (e, k, B)."""
    if matrix.ndim == 3:
        return np.asarray(matrix @ turns)
    return np.asarray(np.einsum("eijb,ejb->eib", matrix, turns))


def over_positions(matrix: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) with a dimension for positions."""
    return matrix[..., None] if matrix.ndim == 3 else matrix
