"""Motion of all bodies of a drawing, batched over crank angles."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.change_points import TURN, ChangePoints, Clearance, change_points_of
from flexmech.linkages.linkage import can_be_taken
from flexmech.linkages.motion import LOCKING_SINE, RigidMotion
from flexmech.linkages.planar.bodies import CRANK, bodies_of
from flexmech.linkages.planar.drawing import Drawing
from flexmech.linkages.planar.dyads import Dyad
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
        drawn = self._driven(np.zeros(1))
        for step in self.steps:
            if isinstance(step, NewtonGroup):
                step.fill_as_drawn(drawn)
            else:
                step.fill_positions(drawn, np.zeros(1), np.ones(1))

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
        numbers, starts, drawn_angles = map(np.array, zip(*self._beams, strict=True))
        body = self.body_motion(turned).of(numbers)
        crank_turns = np.where(numbers == CRANK, turned[:, None], np.angle(body.turn))
        shape = (*theta.shape, len(numbers))
        angle = np.reshape(drawn_angles + crank_turns, shape)
        turn_1, turn_2 = body.turn_1.reshape(shape), body.turn_2.reshape(shape)
        places = (body.point(starts), body.point_1(starts), body.point_2(starts))
        place, place_1, place_2 = (own.reshape(shape) for own in places)
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

    @cached_property
    def change_angles(self) -> FloatArray:
        """Crank angles in rad of a turn at which dyads go over to the other branch, (P,)."""
        every = [
            self._changes(number, step).angles
            for number, step in enumerate(self.steps)
            if isinstance(step, Dyad)
        ]
        around = np.mod(self.drawn_at + np.concatenate([np.zeros(0), *every]), TURN)
        return np.unique(np.where(TURN - around < LOCKING_SINE, 0.0, around))

    def transmission_angles(self, theta: FloatArray) -> dict[str, FloatArray]:
        """Transmission angle of each dyad at crank angles, by its joint; each of shape (A,)."""
        known = self.body_motion(theta - self.drawn_at, needs_rates=False)
        forms = [step.form for step in self.steps if isinstance(step, Dyad)]
        found = {form.refusal.joint: form.transmission_angle(known) for form in forms}
        return {joint: angle for joint, angle in found.items() if angle is not None}

    def body_motion(
        self, angle: FloatArray, steps: int | None = None, *, needs_rates: bool = True
    ) -> BodyMotion:
        """Motion of the bodies at crank angles from that of the drawing.

        Parameters
        ----------
        angle : ndarray, shape (B,)
            In rad.
        steps : int, optional
            How many steps of the plan to take; all of them by default.
        needs_rates : bool
            Whether derivatives by the crank angle are asked for; they are zeros otherwise.

        Returns
        -------
        BodyMotion
            Of all bodies, (B, n); those of later steps are as the ground.

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        bodies = self._driven(angle)
        for number, step in enumerate(self.steps[:steps]):
            if isinstance(step, NewtonGroup):
                near = _within_half_a_turn(angle)
                step.fill_positions(bodies, near, self._path(number, step))
            else:
                changes = self._changes(number, step)
                # By crank angles of the turn from 0 to 360 degrees, in which the drawing is.
                turn = TURN * np.floor(self.drawn_at / TURN)
                changes.refuse(angle + turn, step.form.refusal.meeting, self.drawn_at - turn)
                step.fill_positions(bodies, angle, changes.sides(angle))
            if needs_rates:
                step.fill_rates(bodies)
        return bodies

    def _changes(self, number: int, dyad: Dyad) -> ChangePoints:
        """Change points of a dyad by the crank angle from that of the drawing."""
        if number not in self._change_points:

            def clearances(angle: FloatArray) -> list[Clearance]:
                reached = can_be_taken(
                    partial(self.body_motion, steps=number, needs_rates=False), angle
                )
                known = self.body_motion(angle[reached], number, needs_rates=False)
                return [own.at(reached) for own in dyad.form.clearances(known)]

            self._change_points[number] = change_points_of(clearances, 0.0)
        return self._change_points[number]

    def _path(self, number: int, group: NewtonGroup) -> ContinuationPath:
        if number not in self._paths:
            self._paths[number] = group.trace_path(lambda angle: self.body_motion(angle, number))
        return self._paths[number]

    def _driven(self, angle: FloatArray) -> BodyMotion:
        """All bodies at crank angles (B,), the crank in motion and the others as the ground."""
        nothing = np.zeros((len(angle), len(self._references)))
        bodies = BodyMotion(
            self._references,
            nothing + self._references,
            1 + 0j * nothing,
            0j * nothing,
            0j * nothing,
            nothing.copy(),
            nothing,
        )
        if not self.drawing.is_stationary:
            bodies.turn[:, CRANK], bodies.turn_1[:, CRANK] = np.exp(1j * angle), 1.0
        return bodies

    @cached_property
    def _references(self) -> ComplexArray:
        """Reference point of each body in the drawing, (n,)."""
        drawing, axis = self.drawing, self.drawing.drive.point
        firsts = [drawing.link(links[0]).points[0] for links in self.bodies.links[CRANK + 1 :]]
        return np.array([drawing.complex_point(name) for name in (axis, axis, *firsts)])

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


def _pairs(vector: NDArray[np.number]) -> FloatArray:
    return np.stack([np.real(vector), np.imag(vector)], axis=-1)


def _within_half_a_turn(angle: FloatArray) -> FloatArray:
    return np.asarray(angle - 2 * np.pi * np.round(angle / (2 * np.pi)))
