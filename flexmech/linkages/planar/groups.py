"""Groups of bodies whose motion follows from that of others by the conditions of their joints.

Positions come in closed form (:mod:`flexmech.linkages.planar.dyads`) or by Newton's method
(:mod:`flexmech.linkages.planar.newton`); their derivatives by the crank angle come from the
conditions themselves, of all groups alike.
"""

from __future__ import annotations

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.constraints import Constraints
from flexmech.linkages.planar.bodies import Bodies, GuidedPoint, SharedPoint
from flexmech.linkages.planar.drawing import Drawing
from flexmech.linkages.planar.dyads import SlidingBody, TwoLoci


class BodyGroup:
    """Bodies that are found together.

    Parameters
    ----------
    drawing : Drawing
    bodies : Bodies
    joints : tuple of SharedPoint and GuidedPoint
        As many equations as unknowns.
    unknown : tuple of int
        The bodies, in order.
    """

    def __init__(
        self,
        drawing: Drawing,
        bodies: Bodies,
        joints: tuple[SharedPoint | GuidedPoint, ...],
        unknown: tuple[int, ...],
    ) -> None:
        self.size = drawing.size
        self.unknown = list(unknown)
        self.constraints = Constraints([own.condition(drawing) for own in joints], unknown)
        self._scale = np.tile([self.size, self.size, 1.0], len(unknown))

    def fill(self, bodies: BodyMotion, place: ComplexArray, turn: ComplexArray) -> None:
        """Put the group's bodies into positions.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing, (B, n); those of the group are changed.
        place, turn : ndarray of complex, shape (B, m)
            As of :class:`BodyMotion`.
        """
        bodies.place[:, self.unknown], bodies.turn[:, self.unknown] = place, turn

    def jacobian(self, bodies: BodyMotion) -> FloatArray:
        """Jacobian of the joints' conditions, lengths in parts of the size; (B, 3 m, 3 m)."""
        return np.asarray(self.constraints.jacobian(bodies) * self._scale / self.size)

    def fill_rates(self, bodies: BodyMotion) -> list[FloatArray]:
        """Give the group's bodies in their positions derivatives by the crank angle.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing, (B, n); those of the group are changed.

        Returns
        -------
        list of ndarray, shape (B, 3 m)
            First and second derivatives of the unknowns, lengths in parts of the size.
        """
        rates: list[FloatArray] = []
        jacobian = self.jacobian(bodies)
        of_order = (bodies.place_1, bodies.turn_1), (bodies.place_2, bodies.turn_2)
        for order, (place, turn) in enumerate(of_order, start=1):
            left = self.constraints.gap_rate(bodies, order) / self.size
            rates.append(np.asarray(np.linalg.solve(jacobian, -left[..., None])[..., 0]))
            x, y, phi = np.moveaxis((rates[-1] * self._scale).reshape(len(left), -1, 3), -1, 0)
            place[:, self.unknown], turn[:, self.unknown] = x + 1j * y, phi
        return rates


class Dyad(BodyGroup):
    """One or two bodies with a closed form.

    Parameters
    ----------
    drawing, bodies, joints
        As of :class:`BodyGroup`.
    form : TwoLoci or SlidingBody
    """

    def __init__(
        self,
        drawing: Drawing,
        bodies: Bodies,
        joints: tuple[SharedPoint | GuidedPoint, ...],
        form: TwoLoci | SlidingBody,
    ) -> None:
        super().__init__(drawing, bodies, joints, form.solves)
        self.form = form

    def fill_positions(self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray) -> None:
        """Put the bodies where the closed form has them.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing at the crank angles, (B, n); those of the dyad are changed.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the dyad is on the side of the drawing, -1 where it is on the other one.

        Raises
        ------
        InputError
            Where the bodies do not meet, or lock.
        """
        placements = self.form.placements(bodies, angle, sides)
        reference = np.asarray(bodies.drawn)[self.unknown]
        places = [
            place + turn * (own - drawn)
            for own, (drawn, place, turn) in zip(reference, placements, strict=True)
        ]
        turns = [turn for *_, turn in placements]
        self.fill(bodies, np.stack(places, axis=-1), np.stack(turns, axis=-1))
