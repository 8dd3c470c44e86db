"""A drawing whose beams have other lengths, put together again at the same crank angle."""

from __future__ import annotations

import cmath
from collections.abc import Mapping

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.planar.bodies import CRANK, GROUND_BODY, Bodies, GuidedPoint, SharedPoint
from flexmech.linkages.planar.drawing import Drawing

ITERATIONS = 30
# Of the size.
SETTLED, CLOSED = 1e-15, 1e-12
# Of the size: frames of welded beams that close must close after they have grown.
FITS = 1e-9


def resized_points(
    drawing: Drawing, bodies: Bodies, lengths: Mapping[str, float], ground_growth: float
) -> dict[str, tuple[float, float]]:
    """Points of a drawing whose beams have other lengths.

    Parameters
    ----------
    drawing : Drawing
    bodies : Bodies
    lengths : mapping of str to float
        New length in m of each beam.
    ground_growth : float
        New over old coordinates of the ground's points and lines.

    Returns
    -------
    dict of str to tuple of float
        Coordinates in m, near those of the drawing.

    Raises
    ------
    InputError
        If the linkage cannot be put together with these lengths.
    """
    shapes = _Shapes(drawing, bodies, lengths, ground_growth)
    places = _assembled(shapes)
    found = {
        point: places[here[0]][0] + places[here[0]][1] * shapes.at[here[0], point]
        for point, here in bodies.at_point.items()
    }
    return {point: (place.real, place.imag) for point, place in found.items()}


class _Shapes:
    """Bodies with their new dimensions; each has its own axes, turned as in the drawing.

    Attributes
    ----------
    at : dict of (int, str) to complex
        Place of a point in a body.
    """

    def __init__(
        self, drawing: Drawing, bodies: Bodies, lengths: Mapping[str, float], growth: float
    ) -> None:
        self.drawing = drawing
        self.bodies = bodies
        self.growth = growth
        self.lengths = lengths
        self.at: dict[tuple[int, str], complex] = {
            (GROUND_BODY, point): drawing.complex_point(point) * growth for point in drawing.ground
        }
        for body, links in enumerate(bodies.links):
            if links:
                self._lay_out(body, links)

    def through(self, line: GuidedPoint) -> complex:
        """Where a line passes in its guide."""
        drawn = self.drawing.complex_point(line.point)
        guide = self.drawing.joint(line.point).guide
        if not guide:
            return drawn * self.growth
        beam = self.drawing.link(guide).beams[0]
        start, end = (self.drawing.complex_point(name) for name in (beam.start, beam.end))
        growth = self.lengths[beam.name] / abs(end - start)
        return self.at[line.guide, beam.start] + (drawn - start) * growth

    def _lay_out(self, body: int, links: tuple[str, ...]) -> None:
        """Places of a body's points, beam by beam from its first point."""
        first = self.drawing.drive.point if body == CRANK else self.drawing.link(links[0]).points[0]
        self.at[body, first] = 0j
        beams = [beam for link in links for beam in self.drawing.link(link).beams]
        waiting = list(beams)
        while waiting:
            beam = next(
                b for b in waiting if (body, b.start) in self.at or (body, b.end) in self.at
            )
            waiting.remove(beam)
            drawn = self.drawing.complex_point(beam.end) - self.drawing.complex_point(beam.start)
            along = drawn / abs(drawn) * self.lengths[beam.name]
            for known, new, step in ((beam.start, beam.end, along), (beam.end, beam.start, -along)):
                if (body, known) in self.at:
                    self._set(body, new, self.at[body, known] + step)

    def _set(self, body: int, point: str, place: complex) -> None:
        known = self.at.setdefault((body, point), place)
        if abs(known - place) > FITS * self.drawing.size:
            raise InputError(
                f"links that are welded to a closed frame at {point} do not fit after they have "
                "changed their lengths; give them one material"
            )


def _assembled(shapes: _Shapes) -> list[tuple[complex, complex]]:
    """Origin and turn of each body, by Newton's method from the drawing."""
    drawing, bodies = shapes.drawing, shapes.bodies
    drive = drawing.drive.point
    places: list[tuple[complex, complex]] = [(0j, 1 + 0j)]
    for body in range(1, len(bodies.links)):
        point = next(name for (own, name) in shapes.at if own == body)
        places.append((drawing.complex_point(point), 1 + 0j))
    places[CRANK] = (shapes.at[GROUND_BODY, drive], 1 + 0j)
    constraints = [own for own in bodies.constraints if not _of_crank_and_ground(own)]
    for _ in range(ITERATIONS):
        residual, matrix = _equations(shapes, constraints, places)
        if not residual.size or np.abs(residual).max() < SETTLED * drawing.size:
            break
        change = np.linalg.lstsq(matrix, -residual, rcond=None)[0]
        for body in range(2, len(places)):
            x, y, phi = change[3 * body - 6 : 3 * body - 3]
            origin, turn = places[body]
            places[body] = (origin + complex(x, y), turn * cmath.exp(1j * phi))
    residual, _matrix = _equations(shapes, constraints, places)
    if residual.size and not np.abs(residual).max() < CLOSED * drawing.size:
        raise InputError(
            "the linkage cannot be put together at the crank angle of its drawing after its links "
            "have changed their lengths; draw it farther from a dead point"
        )
    return places


def _of_crank_and_ground(own: SharedPoint | GuidedPoint) -> bool:
    return isinstance(own, SharedPoint) and {own.first, own.second} == {GROUND_BODY, CRANK}


def _equations(
    shapes: _Shapes,
    constraints: list[SharedPoint | GuidedPoint],
    places: list[tuple[complex, complex]],
) -> tuple[FloatArray, FloatArray]:
    """Residuals in m, and their derivatives by origins and angles of bodies 2 and up."""
    residual: list[float] = []
    rows: list[FloatArray] = []
    for own in constraints:
        if isinstance(own, SharedPoint):
            moved = [_moved(shapes, body, own.point, places) for body in (own.first, own.second)]
            gap = moved[0] - moved[1]
            parts = ((own.first, 1.0), (own.second, -1.0))
            for normal in (1 + 0j, 1j):
                row = np.zeros(3 * len(places))
                for (body, sign), place in zip(parts, moved, strict=True):
                    row[3 * body : 3 * body + 3] += sign * _row(normal, place - places[body][0])
                residual.append((np.conj(normal) * gap).real)
                rows.append(row)
            continue
        origin, turn = places[own.guide]
        normal = 1j * turn * own.along
        place = _moved(shapes, own.body, own.point, places)
        gap = place - origin - turn * shapes.through(own)
        row = np.zeros(3 * len(places))
        row[3 * own.body : 3 * own.body + 3] += _row(normal, place - places[own.body][0])
        row[3 * own.guide : 3 * own.guide + 3] -= _row(normal, place - origin)
        residual.append((np.conj(normal) * gap).real)
        rows.append(row)
    return np.array(residual), np.array(rows).reshape(-1, 3 * len(places))[:, 6:]


def _moved(
    shapes: _Shapes, body: int, point: str, places: list[tuple[complex, complex]]
) -> complex:
    origin, turn = places[body]
    return origin + turn * shapes.at[body, point]


def _row(normal: complex, arm: complex) -> FloatArray:
    """Derivative of a place along a normal by the displacement and angle of its body."""
    return np.array([normal.real, normal.imag, (np.conj(normal) * 1j * arm).real])
