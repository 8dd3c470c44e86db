"""Motion of all bodies of a drawing: in which order, by dyads and Newton's method."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import InputError, LockingError
from flexmech.linkages.body_motion import CRANK, GROUND_BODY, BodyMotion, cross
from flexmech.linkages.change_points import (
    TURN,
    ChangePoints,
    Clearance,
    change_points_of,
    in_degrees,
)
from flexmech.linkages.linkage import can_be_taken
from flexmech.linkages.motion import LOCKING_SINE, RigidMotion
from flexmech.linkages.planar.bodies import Bodies, Refusal, SharedPoint, bodies_of
from flexmech.linkages.planar.drawing import Drawing
from flexmech.linkages.planar.dyads import Circle, Dyad, Line, SlidingBody, TwoLoci
from flexmech.linkages.planar.newton import ContinuationPath, NewtonGroup

Step = Dyad | NewtonGroup
# Between lines that count as parallel: angles are written in degrees, which leave 1e-16, and a body
# that two lines at this sine guide would turn by it over its whole way.
PARALLEL_SINE = 1e-9


def _refuse_two_drives(drawing: Drawing, bodies: Bodies) -> None:
    """Several clamps fix a frame whose links are all welded; a mechanism has one."""
    if len(bodies.links) > CRANK + 1:
        named = " and ".join(joint.point for joint in drawing.joints if joint.kind == "clamp")
        raise InputError(
            f"joints {named} are clamps: two drives; keep one, make others pins, or weld all links "
            "to a frame that stands still"
        )


def _refuse_unjoined(bodies: Bodies) -> None:
    reached = {GROUND_BODY, CRANK}
    for _ in bodies.links:
        for joint in bodies.joints:
            if reached & {*joint.bodies}:
                reached.update(joint.bodies)
    for body in range(len(bodies.links)):
        if body not in reached:
            raise InputError(
                f"link {bodies.name(body)} is joined to nothing that the crank drives; let it "
                "share a point with another link, or leave it out"
            )


class _Order:
    """Bodies known so far, and the choice of the next ones."""

    def __init__(self, drawing: Drawing, bodies: Bodies, drawn_at: float) -> None:
        self.drawing = drawing
        self.bodies = bodies
        self.drawn_at = drawn_at
        self.known = {GROUND_BODY, CRANK}

    def steps(self) -> tuple[Step, ...]:
        """Steps that give the motion of all bodies from that of the crank.

        Raises
        ------
        InputError
            If a body is joined to nothing, can move freely, or is overconstrained.
        """
        if self.drawing.is_stationary:
            _refuse_two_drives(self.drawing, self.bodies)
            return ()
        _refuse_unjoined(self.bodies)
        self.refuse_redundant((CRANK,), 0)
        steps: list[Step] = []
        while self.unknown:
            steps.append(self.next_step())
            self.known.update(steps[-1].unknown)
        return tuple(steps)

    @property
    def unknown(self) -> list[int]:
        """Bodies whose motion is not known yet."""
        return [body for body in range(len(self.bodies.links)) if body not in self.known]

    def refuse_redundant(self, group: tuple[int, ...], equations: int) -> None:
        """Refuse bodies with more equations to known ones than they have unknowns."""
        joints = self._on(group)
        if sum(joint.equations for joint in joints) > equations:
            if group == (CRANK,):
                drive = self.drawing.drive.point
                redundant = [joint.point for joint in joints if joint.point != drive]
                if not redundant:
                    return
                point = redundant[0]
            else:
                point = joints[-1].point
            names = ", ".join(self.bodies.name(body) for body in group)
            raise LockingError(
                f"{names}: the chain is redundant at joint {point}, at crank angle "
                f"{in_degrees(self.drawn_at)} as drawn: it is held by more joints than it needs "
                "and locks; remove a link or a joint there"
            )

    def next_step(self) -> Step:
        """Smallest group of bodies that can be solved together, in closed form where it has one."""
        unknown = self.unknown
        for size in range(1, len(unknown) + 1):
            for chosen in combinations(unknown, size):
                joints = self._on(chosen)
                if sum(joint.equations for joint in joints) >= 3 * size:
                    self.refuse_redundant(chosen, 3 * size)
                    dyad = self._closed_form(joints, chosen)
                    if dyad is not None:
                        return dyad
                    return NewtonGroup(self.drawing, self.bodies, joints, chosen, self.drawn_at)
        free = self.bodies.name(self._freest(unknown))
        raise InputError(
            f"the chain does not close: link {free} can still move while the crank stands; join "
            "its free end to another link, to the ground or to a slider"
        )

    def _freest(self, unknown: list[int]) -> int:
        """Body of the unknown ones with the fewest conditions."""
        conditions = dict.fromkeys(unknown, 0)
        for joint in self.bodies.joints:
            for body in {*joint.bodies} & {*unknown}:
                conditions[body] += joint.equations
        return min(unknown, key=lambda body: conditions[body])

    def _on(self, group: tuple[int, ...]) -> tuple[SharedPoint, ...]:
        """Joints of bodies with each other and with known ones.

        Where several bodies meet, a known one counts for the point, whichever it is.
        """
        joints: list[SharedPoint] = []
        at: dict[str, int] = {}
        for point, here in self.bodies.at_point.items():
            present = [body for body in here if body in self.known or body in group]
            if present:
                base = at[point] = min(present, key=lambda body: (body not in self.known, body))
                new = (body for body in present if body in group and body != base)
                joints += [SharedPoint(point, base, body) for body in new]
        for line in self.bodies.lines:
            inside = line.second in self.known or line.second in group
            if inside and line.point in at and {line.second, at[line.point]} & set(group):
                joints.append(replace(line, first=at[line.point]))
        return tuple(joints)

    def _closed_form(
        self, joints: tuple[SharedPoint, ...], unknown: tuple[int, ...]
    ) -> Dyad | None:
        """Closed form of one or two bodies; None of other groups."""
        shared = [joint for joint in joints if joint.along is None]
        lines = [joint for joint in joints if joint.along is not None]
        pivots = {joint.second: joint for joint in shared if joint.first in self.known}
        if len(unknown) == 1 and len(shared) == len(lines) == 1:
            (pivot,), (line,) = shared, lines
            assert line.along is not None
            if line.second in self.known:
                on_line = Line(line.second, self._drawn(line.point), line.along)
                return self._two_loci(line.point, self._circle(pivot, line.point), on_line)
            return SlidingBody(
                self._refusal(line.point, (*unknown, *self.bodies.at_point[line.point])),
                unknown[0],
                pivot.first,
                line.first,
                self._drawn(pivot.point),
                self._drawn(line.point),
                line.along,
                self.drawing.size,
            )
        if len(unknown) != 2 or len(shared) != len(pivots) + 1:
            return None
        # Where the two meet, each is on a circle about its pivot, or on the line along which it
        # translates.
        (meeting,) = (joint.point for joint in shared if joint.first in unknown)
        circles = [self._circle(joint, meeting) for joint in pivots.values()]
        others = [self._translation(lines, body, meeting) for body in {*unknown} - {*pivots}]
        loci: list[Circle | Line] = [*circles, *(line for line in others if line is not None)]
        return self._two_loci(meeting, *loci) if len(loci) == 2 else None

    def _translation(self, lines: list[SharedPoint], body: int, point: str) -> Line | None:
        """Line along which a point of a body translates: two of its points slide along it."""
        guided = [line for line in lines if line.first == body and line.second in self.known]
        if len(guided) != 2 or guided[0].second != guided[1].second:
            return None
        along, other = guided[0].along, guided[1].along
        assert along is not None
        assert other is not None
        if abs(cross(along, other)) >= PARALLEL_SINE:
            return None
        return Line(guided[0].second, self._drawn(point), along, body)

    def _circle(self, pivot: SharedPoint, point: str) -> Circle:
        centre = self._drawn(pivot.point)
        return Circle(pivot.first, centre, pivot.second, centre, self._drawn(point) - centre)

    def _two_loci(self, point: str, first: Circle | Line, second: Circle | Line) -> TwoLoci:
        refusal = self._refusal(point, self.bodies.at_point[point])
        side = float(np.sign(cross(first.drawn_normal, second.drawn_normal)))
        return TwoLoci(refusal, first, second, self.drawing.size, side)

    def _refusal(self, point: str, bodies: Iterable[int]) -> Refusal:
        names = [self.bodies.name(body) for body in dict.fromkeys(bodies)]
        slides = any(line.point == point for line in self.bodies.lines)
        links = " and ".join([*names, *(["its line"] if slides else [])])
        return Refusal(point, links, self.drawn_at)

    def _drawn(self, point: str) -> complex:
        return self.drawing.complex_point(point)


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
        self.steps = _Order(drawing, self.bodies, drawn_at).steps()
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
            Motion of all bodies, (B, n); those of later steps are as the ground.

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
        if self.drawing.is_stationary:
            return BodyMotion.at_rest(self._references, len(angle))
        return BodyMotion.cranked(self._references, angle)

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
