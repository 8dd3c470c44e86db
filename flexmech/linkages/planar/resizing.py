"""A drawing with other beam lengths, assembled again at the same crank angle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmech.arrays import ROUND_OFF, SAME_PLACE
from flexmech.errors import InputError
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.planar.bodies import (
    CRANK,
    GROUND_BODY,
    Bodies,
    JointConstraints,
    SharedPoint,
)
from flexmech.linkages.planar.drawing import Drawing

# A bound of work: Newton's method takes five where links swell by some percent; where it takes 30,
# nothing fits.
ITERATIONS = 30
# Of the size: as near as rounding lets joints close, so that a linkage resized back is the same.
CONVERGED = 1e-15


def resized_points(
    drawing: Drawing, bodies: Bodies, lengths: Mapping[str, float], ground_growth: float
) -> dict[str, tuple[float, float]]:
    """Points of a drawing with other beam lengths.

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
    placed = _assembled(shapes)
    found = {
        point: placed.moving_point(here[0], shapes.at[here[0], point]).place[0]
        for point, here in bodies.at_point.items()
    }
    return {point: (float(place.real), float(place.imag)) for point, place in found.items()}


class _Shapes:
    """Bodies with their new dimensions; each has its own axes, turned as in the drawing.

    Attributes
    ----------
    at : dict of (int, str) to complex
        Place of a point in a body, and of the point of a line in its guide.
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
        self.at |= {(line.second, line.point): self._through(line) for line in bodies.lines}

    def _through(self, line: SharedPoint) -> complex:
        """Point of a line in the axes of its guide."""
        drawn = self.drawing.complex_point(line.point)
        guide = self.drawing.joint(line.point).guide
        if not guide:
            return drawn * self.growth
        beam = self.drawing.link(guide).beams[0]
        start, end = (self.drawing.complex_point(name) for name in (beam.start, beam.end))
        growth = self.lengths[beam.name] / abs(end - start)
        return self.at[line.second, beam.start] + (drawn - start) * growth

    def _lay_out(self, body: int, links: tuple[str, ...]) -> None:
        """Places of a body's points, beam by beam from its first point."""
        first = self.drawing.drive.point if body == CRANK else self.drawing.link(links[0]).points[0]
        self.at[body, first] = 0j
        waiting = [beam for link in links for beam in self.drawing.link(link).beams]
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
        if abs(known - place) > SAME_PLACE * self.drawing.size:
            raise InputError(
                f"links that are welded to a closed frame at {point} do not fit after they have "
                "changed their lengths; give them one material"
            )


def _assembled(shapes: _Shapes) -> BodyMotion:
    """Bodies at rest, assembled by Newton's method from the drawing; a batch of shape (1,)."""
    drawing, bodies = shapes.drawing, shapes.bodies
    # Reversed: of a body's points the first one stays.
    first = {body: drawing.complex_point(point) for body, point in reversed(shapes.at)}
    first |= {GROUND_BODY: 0j, CRANK: shapes.at[GROUND_BODY, drawing.drive.point]}
    count = len(bodies.links)
    placed = BodyMotion.at_rest(np.zeros(count, dtype=complex), 1)
    placed.place[0] = [first[body] for body in range(count)]
    joints = [joint for joint in bodies.joints if not _of_crank_and_ground(joint)]
    moving = range(CRANK + 1, count)
    constraints = JointConstraints(joints, moving, lambda body, point: shapes.at[body, point])
    equations, slides = constraints.equations, np.zeros(len(constraints.along))
    for _ in range(ITERATIONS + 1):
        slid = constraints.slid(placed.drawn, np.stack([slides, 0 * slides, 0 * slides])[:, None])
        gap = equations.gap(placed, slid[0])[0]
        if np.abs(gap).max(initial=0.0) < CONVERGED * drawing.size:
            break
        jacobian = equations.jacobian(placed, None, slid[0])[0]
        change = np.linalg.lstsq(jacobian, -gap, rcond=None)[0]
        x, y, phi = change[: 3 * len(moving)].reshape(-1, 3).T
        placed.place[0, moving] += x + 1j * y
        placed.turn[0, moving] *= np.exp(1j * phi)
        slides = slides + change[3 * len(moving) :]
    if not np.abs(gap).max(initial=0.0) < ROUND_OFF * drawing.size:
        raise InputError(
            "the linkage cannot be put together at the crank angle of its drawing after its links "
            "have changed their lengths; draw it farther from a dead point"
        )
    return placed


def _of_crank_and_ground(joint: SharedPoint) -> bool:
    return joint.along is None and {*joint.bodies} == {GROUND_BODY, CRANK}
