"""Rigid bodies of a drawing, the constraints between them, and groups that these determine.

A body is what is welded together; body 0 is the ground, body 1 turns with the driven shaft. Rates
are derivatives by the crank angle. Positions of a group come in closed form
(:mod:`flexmech.linkages.planar.dyads`) or by Newton's method
(:mod:`flexmech.linkages.planar.newton`), rates of all groups from the constraints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import AssemblyError, InputError, LockingError
from flexmech.linkages.body_motion import BodyMotion, BodyPoint
from flexmech.linkages.change_points import in_degrees
from flexmech.linkages.constraints import Coincidence, Constraints, PointOnLine
from flexmech.linkages.planar.drawing import Drawing

# Numbers of the two bodies whose motion is known from the start.
GROUND_BODY, CRANK = 0, 1

PointPlace = Callable[[int, str], complex]
"""From a body's number and the name of a point to the place of the point in the body's axes."""


@dataclass(frozen=True)
class SharedPoint:
    """A point that two bodies share."""

    point: str
    first: int
    second: int

    def condition(self, at: PointPlace) -> Coincidence:
        """Constraint equation, by the places of the point in the two bodies."""
        first, second = (
            BodyPoint(body, at(body, self.point)) for body in (self.first, self.second)
        )
        return Coincidence(first, second)


@dataclass(frozen=True)
class GuidedPoint:
    """A point of one body that stays on a straight line of another.

    Parameters
    ----------
    point : str
        The line passes through it in the drawing.
    body, guide : int
    along : complex
        Unit vector of the line in the drawing.
    """

    point: str
    body: int
    guide: int
    along: complex

    def condition(self, at: PointPlace) -> PointOnLine:
        """Constraint equation, by the places of the point in its body and on its line."""
        point, line = (BodyPoint(body, at(body, self.point)) for body in (self.body, self.guide))
        return PointOnLine(point, line, self.along)


@dataclass(frozen=True)
class Bodies:
    """Bodies and the constraints between them.

    Parameters
    ----------
    links : tuple of tuple of str
        Links of each body, in the drawing's order; none of the ground.
    at_point : dict of str to tuple of int
        Bodies that share each point, in ascending order.
    coincidences : tuple of SharedPoint
    lines : tuple of GuidedPoint
    """

    links: tuple[tuple[str, ...], ...]
    at_point: dict[str, tuple[int, ...]]
    coincidences: tuple[SharedPoint, ...]
    lines: tuple[GuidedPoint, ...]

    def name(self, body: int) -> str:
        """Name of a body in messages: its first link."""
        return self.links[body][0] if body else "ground"

    def of_link(self, link: str) -> int:
        """Body of a link."""
        return next(number for number, own in enumerate(self.links) if link in own)

    @property
    def constraints(self) -> tuple[SharedPoint | GuidedPoint, ...]:
        """All constraints between bodies."""
        return (*self.coincidences, *self.lines)


def bodies_of(drawing: Drawing) -> Bodies:
    """Bodies of a drawing.

    Parameters
    ----------
    drawing : Drawing

    Returns
    -------
    Bodies

    Raises
    ------
    InputError
        If a slider is guided by its own body.
    """
    body_of = _welded(drawing)
    count = 1 + max(body_of.values())
    links = tuple(
        tuple(name for name, own in body_of.items() if own == body) for body in range(count)
    )
    at_point: dict[str, tuple[int, ...]] = {}
    coincidences, lines = [], []
    for point in drawing.points:
        here = {body_of[link] for link in drawing.links_at(point)}
        if point in drawing.ground:
            here.add(GROUND_BODY)
        first, *others = at_point[point] = tuple(sorted(here))
        coincidences += [SharedPoint(point, first, other) for other in others]
        joint = drawing.joint(point)
        if joint.kind == "slider":
            assert joint.direction is not None
            along, guide = np.exp(1j * joint.direction), GROUND_BODY
            if joint.guide:
                beam = drawing.link(joint.guide).beams[0]
                axis = drawing.complex_point(beam.end) - drawing.complex_point(beam.start)
                along, guide = along * axis / abs(axis), body_of[joint.guide]
                if guide in here:
                    raise InputError(
                        f"slider {point}: its guide {joint.guide} is welded to a link that "
                        "slides; a body does not slide along itself, guide it on another one"
                    )
            lines.append(GuidedPoint(point, first, guide, complex(along)))
    return Bodies(links, at_point, tuple(coincidences), tuple(lines))


def _welded(drawing: Drawing) -> dict[str, int]:
    """Body of each link: those that are welded have one; the crank's is 1."""
    label = {link.name: link.name for link in drawing.links}
    for point in drawing.points:
        first, *others = drawing.fixed_together(point) or [""]
        for other in others:
            old, new = label[other], label[first]
            label = {name: new if own == old else own for name, own in label.items()}
    order = dict.fromkeys([label[drawing.crank], *label.values()])
    number = {own: index for index, own in enumerate(order, start=CRANK)}
    return {name: number[own] for name, own in label.items()}


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
        # The axes of all bodies are those of the drawing.
        conditions = [
            own.condition(lambda _, point: drawing.complex_point(point)) for own in joints
        ]
        self.constraints = Constraints(conditions, unknown)
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
        jacobian = self.constraints.jacobian(bodies)
        of_order = (bodies.place_1, bodies.turn_1), (bodies.place_2, bodies.turn_2)
        for order, (place, turn) in enumerate(of_order, start=1):
            left = self.constraints.gap_rate(bodies, order)
            rate = np.asarray(np.linalg.solve(jacobian, -left[..., None])[..., 0])
            place[:, self.unknown] = rate[:, 0::3] + 1j * rate[:, 1::3]
            turn[:, self.unknown] = rate[:, 2::3]
            rates.append(rate / self._scale)
        return rates


Cause = Literal["apart", "locked"]
SAID: dict[Cause, str] = {
    "apart": "the linkage cannot be assembled at crank angle {angle}: {links} do not meet in joint "
    "{joint} there; choose crank angles inside its range of motion or other dimensions",
    "locked": "the linkage locks at crank angle {angle}: at joint {joint} {links} are in a dead "
    "point and the crank cannot drive them through; leave that crank angle out or change the "
    "dimensions",
}


@dataclass(frozen=True)
class Refusal:
    """Message for crank angles at which a joint is open or in a dead point.

    Parameters
    ----------
    joint : str
    links : str
        Those that meet there.
    drawn_at : float
        Crank angle in rad from which angles are counted.
    """

    joint: str
    links: str
    drawn_at: float

    def refuse(self, cause: Cause, where: NDArray[np.bool_], angle: FloatArray) -> None:
        """Refuse crank angles at which the joint cannot be assembled or cannot be driven.

        Parameters
        ----------
        cause : {"apart", "locked"}
        where : ndarray of bool, shape (B,)
            Where that is so.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.

        Raises
        ------
        InputError
            Names the first of them.
        """
        if np.any(where):
            place = self.first(where, angle)
            error = AssemblyError if cause == "apart" else LockingError
            raise error(SAID[cause].format(angle=place, links=self.links, joint=self.joint))

    @property
    def meeting(self) -> str:
        """What comes into one line at the joint."""
        return f"{self.links} come into one line at joint {self.joint}"

    def first(self, where: NDArray[np.bool_], angle: FloatArray) -> str:
        """First of the crank angles in a set, as text."""
        return in_degrees(float(self.drawn_at + np.broadcast_to(angle, where.shape)[where].flat[0]))
