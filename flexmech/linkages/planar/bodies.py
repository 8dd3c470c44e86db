"""Rigid bodies of a drawing, the joints between them and their constraints.

A body is what is welded together; body 0 is the ground, body 1 turns with the driven shaft. Their
motion by the crank angle comes in closed form (:mod:`flexmech.linkages.planar.dyads`) or by
Newton's method on the constraints (:mod:`flexmech.linkages.planar.newton`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import AssemblyError, InputError, LockingError
from flexmech.linkages.body_motion import CRANK, GROUND_BODY, BodyPoint, Coincidence, Constraints
from flexmech.linkages.change_points import in_degrees
from flexmech.linkages.planar.drawing import Drawing


@dataclass(frozen=True)
class SharedPoint:
    """A point that two bodies share, or a point of one that stays on a straight line of the other.

    Parameters
    ----------
    point : str
        The line passes through it in the drawing.
    first, second : int
    along : complex, optional
        Unit vector in the drawing of a line of the second body.
    """

    point: str
    first: int
    second: int
    along: complex | None = None

    @property
    def bodies(self) -> tuple[int, int]:
        """Both bodies."""
        return self.first, self.second

    @property
    def equations(self) -> int:
        """Number of its constraint equations."""
        return 2 if self.along is None else 1


@dataclass(frozen=True)
class Bodies:
    """Bodies and the constraints between them.

    Parameters
    ----------
    links : tuple of tuple of str
        Links of each body, in the drawing's order; none of the ground.
    at_point : dict of str to tuple of int
        Bodies that share each point, in ascending order.
    joints : tuple of SharedPoint
    """

    links: tuple[tuple[str, ...], ...]
    at_point: dict[str, tuple[int, ...]]
    joints: tuple[SharedPoint, ...]

    def name(self, body: int) -> str:
        """Name of a body in messages: its first link."""
        return self.links[body][0] if body else "ground"

    def of_link(self, link: str) -> int:
        """Body of a link."""
        return next(number for number, links in enumerate(self.links) if link in links)

    @property
    def lines(self) -> tuple[SharedPoint, ...]:
        """Joints at points on lines."""
        return tuple(joint for joint in self.joints if joint.along is not None)


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
        tuple(name for name, number in body_of.items() if number == body) for body in range(count)
    )
    at_point: dict[str, tuple[int, ...]] = {}
    shared, lines = [], []
    for point in drawing.points:
        here = {body_of[link] for link in drawing.links_at(point)}
        if point in drawing.ground:
            here.add(GROUND_BODY)
        first, *others = at_point[point] = tuple(sorted(here))
        shared += [SharedPoint(point, first, other) for other in others]
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
            lines.append(SharedPoint(point, first, guide, complex(along)))
    return Bodies(links, at_point, (*shared, *lines))


def _welded(drawing: Drawing) -> dict[str, int]:
    """Body of each link: those that are welded have one; the crank's is 1."""
    label = {link.name: link.name for link in drawing.links}
    for point in drawing.points:
        first, *others = drawing.fixed_together(point) or [""]
        for other in others:
            old, new = label[other], label[first]
            label = {name: new if text == old else text for name, text in label.items()}
    order = dict.fromkeys([label[drawing.crank], *label.values()])
    number = {text: index for index, text in enumerate(order, start=CRANK)}
    return {name: number[text] for name, text in label.items()}


class JointConstraints:
    """Constraint equations of joints, with a slide for each point on a line.

    Parameters
    ----------
    joints : sequence of SharedPoint
    unknown : sequence of int
        Bodies that the joints determine.
    at : callable
        From a body's number and the name of a point to the place of the point in its axes.

    Attributes
    ----------
    equations : Constraints
    along : ndarray of complex, shape (s,)
        Unit vectors of the lines in their guides' axes.
    """

    def __init__(
        self,
        joints: Sequence[SharedPoint],
        unknown: Sequence[int],
        at: Callable[[int, str], complex],
    ) -> None:
        lines = [joint for joint in joints if joint.along is not None]
        conditions = []
        for joint in joints:
            first, second = (BodyPoint(body, at(body, joint.point)) for body in joint.bodies)
            if joint.along is not None:
                second = BodyPoint(joint.second, slide=lines.index(joint), along=joint.along)
            conditions.append(Coincidence(first, second))
        self.equations = Constraints(conditions, unknown, len(lines))
        self.along = np.array([line.along for line in lines], dtype=complex)
        self._guides = [line.second for line in lines]
        self._through = np.array([at(line.second, line.point) for line in lines], dtype=complex)

    def slid(self, drawn: ComplexArray, slides: FloatArray) -> ComplexArray:
        """Where points on lines are in the axes of their guides, and its derivatives, (3, B, s).

        Parameters
        ----------
        drawn : ndarray of complex, shape (n,)
            Reference points of the bodies in their axes.
        slides : ndarray, shape (3, B, s)
            Distances along the lines from the drawn places in m, and their derivatives.
        """
        slid: ComplexArray = np.asarray(self.along * slides, dtype=complex)
        slid[0] += self._through - drawn[self._guides]
        return slid


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
        if where.any():
            place = self.first(where, angle)
            error = AssemblyError if cause == "apart" else LockingError
            raise error(SAID[cause].format(angle=place, links=self.links, joint=self.joint))

    @property
    def meeting(self) -> str:
        """Sentence on the links that come into one line at the joint."""
        return f"{self.links} come into one line at joint {self.joint}"

    def first(self, where: NDArray[np.bool_], angle: FloatArray) -> str:
        """First of the crank angles in a set, as text."""
        return in_degrees(float(self.drawn_at + np.broadcast_to(angle, where.shape)[where].flat[0]))
