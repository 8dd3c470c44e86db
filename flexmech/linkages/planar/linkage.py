"""Any planar linkage of one degree of freedom, drawn once at one crank angle."""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import ROUND_OFF, SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.body_motion import CRANK, GROUND_BODY, BodyMotion
from flexmech.linkages.change_points import passing
from flexmech.linkages.linkage import assemblable
from flexmech.linkages.motion import RigidMotion, checked_drive
from flexmech.linkages.planar.assembly import Assembly
from flexmech.linkages.planar.bodies import Bodies, JointConstraints, SharedPoint
from flexmech.linkages.planar.drawing import Drawing, PlanarJoint, PlanarLink, derived_topology
from flexmech.linkages.topology import Topology
from flexmech.model_text import TomlTable, quantity
from flexmech.units import ANGLE, LENGTH
from flexmech.validation import (
    check_angle,
    check_instance,
    check_pair,
    checked_array,
    checked_tuple,
)

# Fields that hold several things: of which type, and what to give.
_PARTS: tuple[tuple[str, type, str], ...] = (
    ("links", PlanarLink, "give PlanarLink(name, points) in a tuple"),
    ("ground", str, "give names of points in a tuple"),
    ("joints", PlanarJoint, "give PlanarJoint(point, kind) in a tuple"),
    ("sprung", str, "give names of joints in a tuple"),
)


@dataclass(frozen=True)
class PlanarLinkage:
    """Links between points, drawn at one crank angle.

    The linkage moves on the branch of the drawing: no joint changes the side on which it is drawn
    but at a change point, where the motion goes on smoothly.

    Parameters
    ----------
    points : mapping of str to tuple of float
        Coordinates in m in ground axes, at the crank angle ``drawn_at``.
    links : tuple of PlanarLink
    ground : tuple of str
        Points that do not move. Links turn about them; the clamp is one of them.
    joints : tuple of PlanarJoint
        Kinds of points that are not pins; the clamp is one. Several clamps fix a frame of welded
        links, which is stationary at every crank angle.
    drawn_at : float, optional
        Crank angle of the drawing in rad; that of the crank's first beam if left out.
    sprung : tuple of str
        Joints of the topology, pins or pivots, with springs in place of a rigid bearing. A
        mechanism names those with a radial stiffness by itself.

    Raises
    ------
    InputError
        One message for what is wrong: an unknown point, a chain that does not close or is
        overconstrained, a drawing in a dead point.

    Examples
    --------
    >>> slider_crank = flexmech.PlanarLinkage(
    ...     points={"O2": (0, 0), "A": (0, 0.15), "B": (0.25, 0)},
    ...     links=(
    ...         flexmech.PlanarLink("crank", ("O2", "A")),
    ...         flexmech.PlanarLink("rod", ("A", "B")),
    ...     ),
    ...     ground=("O2",),
    ...     joints=(
    ...         flexmech.PlanarJoint("O2", "clamp"),
    ...         flexmech.PlanarJoint("B", "slider", direction=0.0),
    ...     ),
    ... )
    >>> rod = slider_crank.topology.links[1]
    >>> slider_crank.motion(crank_angle=0.0).position(1, rod.length).round(6) + 0.0
    array([0.441548, 0.      ])
    """

    points: Mapping[str, tuple[float, float]]
    links: tuple[PlanarLink, ...]
    ground: tuple[str, ...]
    joints: tuple[PlanarJoint, ...] = ()
    drawn_at: float | None = None
    sprung: tuple[str, ...] = ()

    kind: ClassVar[str] = "planar"

    def __post_init__(self) -> None:
        check_instance(self.points, Mapping, "points", "give coordinates in m by name")
        for name, pair in self.points.items():
            check_pair(pair, f"points: {name}", "m")
        places = {name: (float(x), float(y)) for name, (x, y) in self.points.items()}
        object.__setattr__(self, "points", places)
        for field_name, kind, remedy in _PARTS:
            items = checked_tuple(getattr(self, field_name), kind, field_name, remedy)
            object.__setattr__(self, field_name, items)
        object.__setattr__(self, "sprung", tuple(sorted(self.sprung)))
        # A pin needs no joint, so that none is kept for it.
        joints = tuple(joint for joint in self.joints if joint != PlanarJoint(joint.point))
        for joint in self.joints:
            self.drawing.joint(joint.point)
        object.__setattr__(self, "joints", joints)
        if self.drawn_at is not None:
            check_angle(self.drawn_at, "drawn_at")
        _ = self.topology
        self._assembly.check_as_drawn()

    @cached_property
    def drawing(self) -> Drawing:
        """Points, links and joints as drawn."""
        return Drawing(self.points, self.links, self.joints, self.ground)

    @cached_property
    def topology(self) -> Topology:
        """Links and connections, see :func:`flexmech.linkages.planar.drawing.derived_topology`."""
        return derived_topology(self.drawing, self.sprung)

    @cached_property
    def _assembly(self) -> Assembly:
        return Assembly(self.drawing, self.drawn_angle)

    def sprung_at(self, joints: Collection[str]) -> Self:
        """The linkage with springs in place of rigid bearings in these joints, and no others.

        Parameters
        ----------
        joints : collection of str
            Pins or pivots of the topology.

        Raises
        ------
        InputError
            If one is no such joint.
        """
        return replace(self, sprung=tuple(joints))

    @property
    def drawn_angle(self) -> float:
        """Crank angle of the drawing in rad."""
        if self.drawn_at is not None:
            return self.drawn_at
        first = self.drawing.link(self.drawing.crank).beams[0]
        start, end = (self.drawing.complex_point(name) for name in (first.start, first.end))
        return cmath.phase(end - start)

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of every beam.

        Parameters
        ----------
        crank_angle, crank_speed, crank_acceleration : array_like
            Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

        Returns
        -------
        RigidMotion
            In the order of the topology's links.

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks; names the crank angle and the joint.
        """
        theta, omega, alpha = checked_drive(crank_angle, crank_speed, crank_acceleration)
        return self._assembly.motion(theta, omega, alpha)

    def transmission_angles(self, crank_angle: ArrayLike) -> dict[str, FloatArray]:
        """Transmission angle at each joint that a dyad closes, between 0 and 90 degrees.

        It lies between the two links, or between the link that pushes a slider and the normal of
        its line: 90 degrees less the pressure angle. Bodies without a closed form have none.

        Parameters
        ----------
        crank_angle : array_like, shape (A,)
            In rad.

        Returns
        -------
        dict of str to ndarray, shape (A,)
            In rad, by the joint.

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        return self._assembly.transmission_angles(checked_array(crank_angle, "crank_angle", "rad"))

    @property
    def change_angles(self) -> FloatArray:
        """Crank angles in rad of a turn at which joints change sides smoothly; (P,)."""
        return self._assembly.change_angles

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> PlanarLinkage:
        """Linkage whose beams have other lengths, on a larger ground.

        The angles between the beams of a link and between welded links stay, and so do the
        directions of lines.

        Parameters
        ----------
        lengths : mapping of str to float
            New length in m of each beam.
        ground_growth : float
            New over old distances of the ground's points and lines.

        Returns
        -------
        PlanarLinkage
            Drawn at the same crank angle.

        Raises
        ------
        InputError
            If it is a stationary frame.
        """
        known = {link.name: link.length for link in self.topology.links}
        if ground_growth == 1 and all(lengths[name] == length for name, length in known.items()):
            return self
        if self.drawing.is_stationary:
            raise InputError(
                "a frame that stands still has the lengths of its drawing: held at several points, "
                "it would be stressed by others; draw it anew"
            )
        points = resized_points(self.drawing, self._assembly.bodies, lengths, ground_growth)
        return replace(self, points=points, drawn_at=self.drawn_angle)

    def described(self) -> list[str]:
        """Kind, lengths, joints and range of motion, a line each."""
        lengths = ", ".join(
            f"{link.name} {link.length * 1e3:.6g} mm{' (rigid)' if link.rigid else ''}"
            for link in self.topology.links
        )
        joints = zip(self.topology.joint_names, self.topology.joint_kinds, strict=True)
        return [
            f"kind: planar, drawn at crank angle {math.degrees(self.drawn_angle):.6g} deg",
            f"lengths: {lengths}",
            f"joints: {', '.join(f'{name} {kind}' for name, kind in joints)}",
            self._range(),
        ]

    def _range(self) -> str:
        if self.drawing.is_stationary:
            return "it stands still: nothing drives it"
        angles = np.radians(np.arange(0.0, 360.0))
        if self.change_angles.size:
            return f"{passing(self.change_angles)}, and does not turn fully"
        turns = assemblable(self, angles).all()
        return "the crank turns fully" if turns else "the crank does not turn fully"

    def to_table(self) -> TomlTable:
        """Table ``[linkage]`` of a model file; links and joints have tables of their own."""
        table: TomlTable = {"kind": self.kind}
        if self.drawn_at is not None:
            table["drawn_at"] = quantity(self.drawn_at, ANGLE)
        table["ground"] = list(self.ground)
        table["points"] = {
            name: [quantity(along, LENGTH) for along in place]
            for name, place in self.points.items()
        }
        return table


# A bound of work: Newton's method takes five where links swell by some percent; where it takes 30,
# nothing fits.
ITERATIONS = 30
# Part of the size: as near as rounding lets joints close, so that a linkage resized back is
# the same.
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
    places = {
        point: placed.moving_point(here[0], shapes.at[here[0], point]).place[0]
        for point, here in bodies.at_point.items()
    }
    return {point: (float(place.real), float(place.imag)) for point, place in places.items()}


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
