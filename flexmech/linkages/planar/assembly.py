"""Motion of all bodies of a drawing, batched over crank angles."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, IntArray
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
                step.move(drawn, np.zeros(1), np.ones(1))

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
        numbers, starts, drawn_angles = self._beams
        bodies = self.body_motion(turned)
        turns = np.where(numbers == CRANK, turned[:, None], np.angle(bodies.turn[:, numbers]))
        return bodies.driven_motion(numbers, starts, drawn_angles + turns, (theta, omega, alpha))

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
        dyads = [step for step in self.steps if not isinstance(step, NewtonGroup)]
        angles = {dyad.refusal.joint: dyad.transmission_angle(known) for dyad in dyads}
        return {joint: angle for joint, angle in angles.items() if angle is not None}

    def body_motion(self, angle: FloatArray, steps: int | None = None) -> BodyMotion:
        """Motion of the bodies at crank angles from that of the drawing.

        Parameters
        ----------
        angle : ndarray, shape (B,)
            In rad.
        steps : int, optional
            How many steps of the plan to take; all of them by default.

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
                near = angle - TURN * np.round(angle / TURN)
                step.move(bodies, near, self._path(number, step))
            else:
                changes = self._changes(number, step)
                # By crank angles of the turn from 0 to 360 degrees, in which the drawing is.
                turn = TURN * np.floor(self.drawn_at / TURN)
                changes.refuse(angle + turn, step.refusal.meeting, self.drawn_at - turn)
                step.move(bodies, angle, changes.sides(angle))
        return bodies

    def _changes(self, number: int, dyad: Dyad) -> ChangePoints:
        """Change points of a dyad by the crank angle from that of the drawing."""
        if number not in self._change_points:

            def clearances(angle: FloatArray) -> list[Clearance]:
                reached = can_be_taken(partial(self.body_motion, steps=number), angle)
                known = self.body_motion(angle[reached], number)
                return [clearance.at(reached) for clearance in dyad.clearances(known)]

            self._change_points[number] = change_points_of(clearances, 0.0)
        return self._change_points[number]

    def _path(self, number: int, group: NewtonGroup) -> ContinuationPath:
        if number not in self._paths:
            self._paths[number] = group.trace_path(lambda angle: self.body_motion(angle, number))
        return self._paths[number]

    def _driven(self, angle: FloatArray) -> BodyMotion:
        """All bodies at crank angles (B,), the crank in motion and the others as the ground."""
        bodies = BodyMotion.at_rest(self._references, len(angle))
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
    def _beams(self) -> tuple[IntArray, ComplexArray, FloatArray]:
        """Body, start and drawn angle of each beam, in order."""
        links = [(link.name, beam) for link in self.drawing.links for beam in link.beams]
        place = self.drawing.complex_point
        starts = np.array([place(beam.start) for _, beam in links])
        ends = np.array([place(beam.end) for _, beam in links])
        numbers = np.array([self.bodies.of_link(name) for name, _ in links])
        return numbers, starts, np.angle(ends - starts)
