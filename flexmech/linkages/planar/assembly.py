"""Motion of all bodies of a drawing, batched over crank angles."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.change_points import TURN, ChangePoints, Clearance, change_points_of
from flexmech.linkages.motion import LOCKING_SINE, RigidMotion
from flexmech.linkages.planar.bodies import CRANK, GROUND_BODY, bodies_of
from flexmech.linkages.planar.drawing import Drawing
from flexmech.linkages.planar.dyads import SlidingBody, TwoLoci
from flexmech.linkages.planar.newton import ContinuationPath, NewtonGroup
from flexmech.linkages.planar.plan import assembly_order


class Assembly:
    """The moving linkage of a drawing.

    Parameters
    ----------
    drawing : Drawing
    drawn_at : float
        Crank angle of the drawing in rad.
    """

    def __init__(self, drawing: Drawing, drawn_at: float) -> None:
        self.drawing = drawing
        self.drawn_at = drawn_at
        self.bodies = bodies_of(drawing)
        self.steps = assembly_order(drawing, self.bodies, drawn_at)
        self._paths: dict[int, ContinuationPath] = {}
        self._change_points: dict[int, ChangePoints] = {}

    def check_as_drawn(self) -> None:
        """Refuse a drawing in a dead point."""
        known = self._driven(np.zeros(1))
        for step in self.steps:
            if isinstance(step, NewtonGroup):
                step.refuse_locking(known)
                known |= step.as_drawn(known)
            else:
                known |= step.motion(known, np.zeros(1), np.ones(1))

    def motion(self, theta: FloatArray, omega: FloatArray, alpha: FloatArray) -> RigidMotion:
        """Rigid motion of every beam.

        Parameters
        ----------
        theta, omega, alpha : ndarray, shape (...)
            Crank angle in rad, its speed in rad/s and acceleration in rad/s^2.

        Returns
        -------
        RigidMotion
        """
        turned = np.ravel(theta) - self.drawn_at
        if self.drawing.is_stationary:
            if np.any(omega) or np.any(alpha):
                raise InputError(
                    "the frame stands still, clamped at several points: nothing turns; choose "
                    "crank speed 0"
                )
            turned = np.zeros_like(turned)
        known = self.body_motion(turned)
        columns = [self._beam(known, turned, beam) for beam in self._beams]
        angle, turn_1, turn_2, place, place_1, place_2 = (
            np.stack(np.broadcast_arrays(*column), axis=-1).reshape(*theta.shape, -1)
            for column in zip(*columns, strict=True)
        )
        w, a = omega[..., None], alpha[..., None]
        return RigidMotion(
            crank_angle=theta,
            crank_speed=omega,
            angle=angle,
            angular_velocity=turn_1 * w,
            angular_acceleration=turn_2 * w**2 + turn_1 * a,
            origin=_pairs(place),
            origin_velocity=_pairs(place_1) * w[..., None],
            origin_acceleration=(
                _pairs(place_2) * w[..., None] ** 2 + _pairs(place_1) * a[..., None]
            ),
        )

    def assemblable(self, theta: FloatArray) -> NDArray[np.bool_]:
        """Whether the linkage can be assembled at crank angles of shape (A,)."""
        return self._reached(theta - self.drawn_at, None)

    @cached_property
    def change_angles(self) -> FloatArray:
        """Crank angles in rad of a turn at which dyads go over to the other branch, (P,)."""
        every = [
            self._changes(number, step).angles
            for number, step in enumerate(self.steps)
            if not isinstance(step, NewtonGroup)
        ]
        around = np.mod(self.drawn_at + np.concatenate([np.zeros(0), *every]), TURN)
        return np.unique(np.where(TURN - around < LOCKING_SINE, 0.0, around))

    def transmission_angles(self, theta: FloatArray) -> dict[str, FloatArray]:
        """Transmission angle of each dyad at crank angles, by its joint; each of shape (A,)."""
        known = self.body_motion(theta - self.drawn_at)
        dyads = (step for step in self.steps if not isinstance(step, NewtonGroup))
        found = {dyad.refusal.joint: dyad.transmission_angle(known) for dyad in dyads}
        return {joint: angle for joint, angle in found.items() if angle is not None}

    def _reached(self, angle: FloatArray, steps: int | None) -> NDArray[np.bool_]:
        """Whether the first steps of the plan can be taken at angles (A,) from the drawing."""
        try:
            self.body_motion(angle, steps)
        except InputError:
            if len(angle) == 1:
                return np.array([False])
            half = len(angle) // 2
            halves = angle[:half], angle[half:]
            return np.concatenate([self._reached(own, steps) for own in halves])
        return np.ones(len(angle), dtype=bool)

    def body_motion(self, angle: FloatArray, steps: int | None = None) -> dict[int, BodyMotion]:
        """Motion of the bodies at crank angles from that of the drawing.

        Parameters
        ----------
        angle : ndarray, shape (B,)
            In rad.
        steps : int, optional
            How many steps of the plan to take; all of them by default.

        Returns
        -------
        dict of int to BodyMotion

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        known = self._driven(angle)
        for number, step in enumerate(self.steps[:steps]):
            if isinstance(step, NewtonGroup):
                known |= step.motion(known, _within_half_a_turn(angle), self._path(number, step))
            else:
                changes = self._changes(number, step)
                # By crank angles of the turn from 0 to 360 degrees, in which the drawing is.
                turn = TURN * np.floor(self.drawn_at / TURN)
                changes.refuse(angle + turn, step.refusal.meeting, self.drawn_at - turn)
                known |= step.motion(known, angle, changes.sides(angle))
        return known

    def _changes(self, number: int, dyad: TwoLoci | SlidingBody) -> ChangePoints:
        """Change points of a dyad by the crank angle from that of the drawing."""
        if number not in self._change_points:

            def clearances(angle: FloatArray) -> list[Clearance]:
                reached = self._reached(angle, number)
                known = self.body_motion(angle[reached], number)
                return [own.at(reached) for own in dyad.clearances(known)]

            self._change_points[number] = change_points_of(clearances, 0.0)
        return self._change_points[number]

    def _path(self, number: int, group: NewtonGroup) -> ContinuationPath:
        if number not in self._paths:
            self._paths[number] = group.trace_path(lambda angle: self.body_motion(angle, number))
        return self._paths[number]

    def _driven(self, angle: FloatArray) -> dict[int, BodyMotion]:
        """Motion of the ground and of the crank."""
        zero, one = np.zeros_like(angle), np.ones_like(angle)
        axis = self.drawing.complex_point(self.drawing.drive.point)
        ground = BodyMotion(axis, axis + 0j * one, one + 0j, 0j * one, 0j * one, zero, zero)
        if self.drawing.is_stationary:
            return {GROUND_BODY: ground, CRANK: ground}
        crank = BodyMotion(axis, ground.place, np.exp(1j * angle), 0j * one, 0j * one, one, zero)
        return {GROUND_BODY: ground, CRANK: crank}

    @cached_property
    def _beams(self) -> list[tuple[int, complex, float]]:
        """Body, start and drawn angle of each beam, in order."""
        place = self.drawing.complex_point
        return [
            (
                self.bodies.of_link(link.name),
                place(beam.start),
                float(np.angle(place(beam.end) - place(beam.start))),
            )
            for link in self.drawing.links
            for beam in link.beams
        ]

    def _beam(
        self, known: dict[int, BodyMotion], turned: FloatArray, beam: tuple[int, complex, float]
    ) -> tuple[NDArray[np.number], ...]:
        number, start, drawn_angle = beam
        body = known[number]
        return (
            drawn_angle + (turned if number == CRANK else np.angle(body.turn)),
            body.turn_1,
            body.turn_2,
            body.point(start),
            body.point_1(start),
            body.point_2(start),
        )


def _pairs(vector: NDArray[np.number]) -> FloatArray:
    return np.stack([np.real(vector), np.imag(vector)], axis=-1)


def _within_half_a_turn(angle: FloatArray) -> FloatArray:
    return np.asarray(angle - 2 * np.pi * np.round(angle / (2 * np.pi)))
