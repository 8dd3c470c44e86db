"""Rigid arms from the pins' axis to the nodes of the neutral axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.beams.elements import BeamElements


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

    def turn_tangent(
        self, relative: FloatArray, tangent: FloatArray, force: FloatArray | None
    ) -> None:
        """Transform a tangent from the neutral axis to the pins' axis, in place.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)
            On the pins' axis.
        tangent : ndarray, shape (e, r, r, B)
        force : ndarray, shape (e, r, B), optional
            On the neutral axis; without it the part of the tangent that turns it is left out.
        """
        if not self.places:
            return
        sine, cosine = self._along_and_across(relative)
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, place] -= c[:, None] * tangent[:, 0] + s[:, None] * tangent[:, 1]
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, :, place] -= c[:, None] * tangent[:, :, 0] + s[:, None] * tangent[:, :, 1]
            if force is not None:
                tangent[:, place, place] += force[:, 0] * s - force[:, 1] * c

    def turn_force(self, relative: FloatArray, force: FloatArray) -> None:
        """Transform forces (e, r, B) from the neutral axis to the pins' axis, in place.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)
            On the pins' axis.
        force : ndarray, shape (e, r, B)
        """
        if not self.places:
            return
        sine, cosine = self._along_and_across(relative)
        for number, place in enumerate(self.places):
            force[:, place] -= force[:, 0] * cosine[:, number] + force[:, 1] * sine[:, number]

    def _along_and_across(self, relative: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Length of each arm times the sine and the cosine of its angle."""
        angle = relative[:, self.places]
        return self.length * np.sin(angle), self.length * np.cos(angle)
