"""Rigid bodies of a drawing, what ties them together, and their positions and rates.

Vectors of the plane are complex numbers, x + i y. A body is what is welded together; body 0 is
the ground, body 1 turns with the driven shaft. Rates are derivatives by the crank angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.planar.drawing import Drawing
from flexmech.types import ComplexArray, FloatArray

GROUND_BODY, CRANK = 0, 1


@dataclass(frozen=True)
class Coincidence:
    """A point that two bodies share."""

    point: str
    first: int
    second: int


@dataclass(frozen=True)
class OnLine:
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


@dataclass(frozen=True)
class Bodies:
    """Bodies and the constraints between them.

    Parameters
    ----------
    links : tuple of tuple of str
        Links of each body, in the drawing's order; none of the ground.
    at_point : dict of str to tuple of int
        Bodies that share each point, in ascending order.
    coincidences : tuple of Coincidence
    lines : tuple of OnLine
    """

    links: tuple[tuple[str, ...], ...]
    at_point: dict[str, tuple[int, ...]]
    coincidences: tuple[Coincidence, ...]
    lines: tuple[OnLine, ...]

    def name(self, body: int) -> str:
        """What messages call a body: its first link."""
        return self.links[body][0] if body else "ground"

    def of_link(self, link: str) -> int:
        """Body of a link."""
        return next(number for number, own in enumerate(self.links) if link in own)

    @property
    def constraints(self) -> tuple[Coincidence | OnLine, ...]:
        """All that ties bodies together."""
        return (*self.coincidences, *self.lines)


@dataclass(frozen=True)
class BodyMotion:
    """Where a body is, over a batch of crank angles.

    Parameters
    ----------
    drawn : complex
        Its reference point in the drawing.
    place, place_1, place_2 : ndarray of complex, shape (B,)
        Where that point is, and its derivatives by the crank angle.
    turn : ndarray of complex, shape (B,)
        ``exp(i phi)`` with the angle phi by which the body has turned since the drawing.
    turn_1, turn_2 : ndarray, shape (B,)
        Derivatives of phi.
    """

    drawn: complex
    place: ComplexArray
    turn: ComplexArray
    place_1: ComplexArray
    place_2: ComplexArray
    turn_1: FloatArray
    turn_2: FloatArray

    def point(self, drawn: complex) -> ComplexArray:
        """Where a point of the body is."""
        return self.place + self.turn * (drawn - self.drawn)

    def point_1(self, drawn: complex) -> ComplexArray:
        """First derivative of a point's place."""
        arm = self.turn * (drawn - self.drawn)
        return self.place_1 + 1j * self.turn_1 * arm

    def point_2(self, drawn: complex) -> ComplexArray:
        """Second derivative of a point's place."""
        arm = self.turn * (drawn - self.drawn)
        return self.place_2 + (1j * self.turn_2 - self.turn_1**2) * arm


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
        coincidences += [Coincidence(point, first, other) for other in others]
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
            lines.append(OnLine(point, first, guide, complex(along)))
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
