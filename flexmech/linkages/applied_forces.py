"""Loads on links and springs between them, and their forces on the links of a rigid linkage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si, units
from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.body_motion import GROUND_AFTER_LINKS
from flexmech.linkages.motion import RigidMotion, cross, turned
from flexmech.linkages.topology import Topology
from flexmech.model_text import TomlTable, quantity
from flexmech.validation import (
    check_choice,
    check_instance,
    check_number,
    check_pair,
    checked_array,
    checked_tuple,
)

GROUND = "ground"
"""Where a :class:`AttachmentPoint` is that does not move."""

Axes = Literal["ground", "link"]
LoadOver = Literal["constant", "crank_angle", "time"]
AXES: tuple[Axes, ...] = ("ground", "link")
LOAD_OVER: tuple[LoadOver, ...] = ("constant", "crank_angle", "time")


_POINT = "give flexmech.linkages.AttachmentPoint(link, x) with x in m"


@dataclass(frozen=True)
class AttachmentPoint:
    """A point on the axis of a link, or of the ground.

    Parameters
    ----------
    link : str
        Name of the link, or :data:`GROUND`.
    x : float
        Distance from the link's start along its axis in m; ground coordinate of a ground point.
    y : float
        Ground coordinate of a ground point in m; zero on a link.

    Raises
    ------
    InputError
        If a coordinate is no number, or a point of a link is off its axis.
    """

    link: str
    x: float
    y: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.x, f"point on {self.link}: x", "m")
        check_number(self.y, f"point on {self.link}: y", "m")
        if self.link != GROUND and self.y != 0.0:
            raise InputError(
                f"a point on the {self.link} must be on its axis, got y = {self.y:g} m"
            )

    @property
    def is_ground(self) -> bool:
        """Whether the point is on the ground."""
        return self.link == GROUND

    def to_table(self) -> TomlTable | list[str | float]:
        """Place in a model file: link and position, or coordinates of a point of the ground."""
        if self.is_ground:
            return [quantity(self.x, units.LENGTH), quantity(self.y, units.LENGTH)]
        return {"link": self.link, "position": quantity(self.x, units.LENGTH)}


@dataclass(frozen=True)
class Load:
    """A force and a torque on a point of a link.

    Parameters
    ----------
    name : str
    point : AttachmentPoint
        On a link.
    force : tuple of (float, float)
        In N, along x and y of the axes, one for each place of ``at``.
    torque : tuple of float
        In N m, likewise; positive to the left.
    axes : {"ground", "link"}
        Whether the force keeps its direction or turns with the link.
    over : {"constant", "crank_angle", "time"}
    at : tuple of float
        Crank angles in rad, increasing over less than a turn (the load repeats with the
        turn), or times in s (it keeps its first value before and its last one after them).
        Between two places the load is linear. Empty where the load is constant.

    Raises
    ------
    InputError
        If the point is of the ground, or the table is not one.

    Examples
    --------
    >>> place = flexmech.linkages.AttachmentPoint("coupler", 0.1)
    >>> flexmech.Load("push", place, force=((0.0, -5.0),)).values(crank_angle=0.0)
    array([ 0., -5.,  0.])
    """

    name: str
    point: AttachmentPoint
    force: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    torque: tuple[float, ...] = (0.0,)
    axes: Axes = "ground"
    over: LoadOver = "constant"
    at: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        what = f"load {self.name}"
        check_choice(self.axes, AXES, f"{what}: axes")
        check_choice(self.over, LOAD_OVER, f"{what}: over")
        check_instance(self.point, AttachmentPoint, f"{what}: point", _POINT)
        if self.point.is_ground:
            raise InputError(f"{what} acts on the ground; give a point of a link")
        remedy = "give one of each for each place in a tuple"
        object.__setattr__(self, "torque", checked_tuple(self.torque, object, what, remedy))
        object.__setattr__(self, "force", checked_tuple(self.force, object, what, remedy))
        for pair in self.force:
            check_pair(pair, f"{what}: each force", "N")
        places = checked_array(self.at, f"{what}: at", "rad or s")
        rows = 1 if self.over == "constant" else places.size
        if not len(self.force) == len(self.torque) == rows or not rows:
            raise InputError(
                f"{what} has {len(self.force)} forces and {len(self.torque)} torques for {rows} "
                "places; give one of each for each place"
            )
        for torque in self.torque:
            check_number(torque, f"{what}: each torque", "N m")
        if np.any(np.diff(places) <= 0):
            raise InputError(f"{what}: its places must increase, each beyond the one before it")
        if self.over == "crank_angle" and places[-1] - places[0] >= 2 * np.pi:
            raise InputError(f"{what}: its crank angles span a turn or more; give less than one")

    def values(self, crank_angle: ArrayLike, time: ArrayLike = 0.0) -> FloatArray:
        """Force and torque in the load's axes.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.
        time : array_like, shape (...)
            In s.

        Returns
        -------
        ndarray, shape (..., 3)
            Force along x and y in N, torque in N m.
        """
        angle, instant = np.broadcast_arrays(
            np.asarray(crank_angle, dtype=float), np.asarray(time, dtype=float)
        )
        table = np.column_stack([np.asarray(self.force, dtype=float), self.torque])
        if self.over == "constant":
            return np.broadcast_to(table[0], (*angle.shape, 3)).copy()
        period = 2 * np.pi if self.over == "crank_angle" else None
        where = angle if self.over == "crank_angle" else instant
        columns = [np.interp(where, self.at, column, period=period) for column in table.T]
        return np.stack(columns, axis=-1)

    def in_ground_axes(self, values: FloatArray, angle: FloatArray) -> FloatArray:
        """Force along the ground's x and y in N.

        Parameters
        ----------
        values : ndarray, shape (..., 3)
            Values of :meth:`values`.
        angle : ndarray, shape (...)
            Angle of the section that the load acts on, in rad.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        if self.axes == "ground":
            return values[..., :2]
        return turned(values[..., :2], angle)

    def to_table(self) -> TomlTable:
        """Entry of ``[loads]`` of a model file."""
        table = self.point.to_table()
        assert isinstance(table, dict)
        if self.axes != "ground":
            table["axes"] = self.axes
        if self.over == "constant":
            table["force"] = [quantity(along, units.FORCE) for along in self.force[0]]
            return table | {"torque": quantity(self.torque[0], units.TORQUE)}
        place = units.ANGLE if self.over == "crank_angle" else units.TIME
        rows = [
            [
                quantity(at, place),
                *(quantity(along, units.FORCE) for along in force),
                quantity(m, units.TORQUE),
            ]
            for at, force, m in zip(self.at, self.force, self.torque, strict=True)
        ]
        return table | {"over": self.over, "table": rows}


@dataclass(frozen=True)
class Spring:
    """A straight spring between two points, with a damper in parallel.

    Parameters
    ----------
    name : str
    first, second : AttachmentPoint
    stiffness : float
        Force per elongation in N/m.
    free_length : float
        Length without force in m.
    damping : float
        Damping of the damper beside it in N s/m.

    Raises
    ------
    InputError
        If a number is out of its range, or both points are of one link or of the ground.

    Examples
    --------
    >>> first = flexmech.linkages.AttachmentPoint("rocker", 0.1)
    >>> second = flexmech.linkages.AttachmentPoint("ground", x=0.3, y=0.1)
    >>> flexmech.Spring("return", first, second, stiffness=200.0, free_length=0.08).damping
    0.0
    """

    name: str
    first: AttachmentPoint
    second: AttachmentPoint
    stiffness: si.SpringStiffness
    free_length: si.LengthOrZero
    damping: si.Damping = 0.0

    def __post_init__(self) -> None:
        what = f"spring {self.name}"
        si.check(self, f"{what}: {{}}")
        for end in (self.first, self.second):
            check_instance(end, AttachmentPoint, f"each end of {what}", _POINT)
        if self.first.link == self.second.link:
            raise InputError(f"{what} has both ends on {self.first.link}; join two links")

    def to_table(self) -> TomlTable:
        """Entry of ``[springs]`` of a model file."""
        return {"points": [self.first.to_table(), self.second.to_table()], **si.table(self)}


@dataclass(frozen=True)
class JointSpring:
    """Springs and dampers in a pin or pivot.

    Parameters
    ----------
    joint : str
    torsional_stiffness : float
        Stiffness of a spring in a pin or pivot in N m/rad.
    torsional_damping : float
        Damping of a damper in a pin or pivot in N m s/rad.
    free_angle : float
        Angle of the following link less that of the leading one, or of a pivoted link, in rad,
        at which the spring has no torque. It is counted on continuously as the linkage turns, from
        the angles at crank angle zero (:func:`flexmech.linkages.continuous_angles`, which
        ``flexmech kinematics`` writes too).
    radial_stiffness : float, optional
        Stiffness of the bearing in N/m, the same in all directions; without it the pin does
        not give way.
    radial_damping : float
        Damping of the bearing in N s/m, with ``radial_stiffness``.

    Raises
    ------
    InputError
        If a number is out of its range, or there is radial damping without stiffness.

    Examples
    --------
    >>> spring = flexmech.JointSpring("B", torsional_stiffness=0.2, free_angle=0.5)
    >>> spring.torque(np.array([0.6]), np.zeros(1)).round(3)
    array([-0.02])
    """

    joint: str
    torsional_stiffness: si.TorsionalStiffness = 0.0
    torsional_damping: si.TorsionalDamping = 0.0
    free_angle: si.Angle = 0.0
    radial_stiffness: si.RadialStiffness | None = None
    radial_damping: si.Damping = 0.0

    def __post_init__(self) -> None:
        what = f"spring in joint {self.joint}"
        si.check(self, f"{what}: {{}}")
        if self.radial_stiffness is None and self.radial_damping:
            raise InputError(f"{what}: radial_damping needs a radial_stiffness beside it")

    def torque(self, opening: FloatArray, rate: FloatArray) -> FloatArray:
        """Torque of spring and damper on the following link in N m.

        Parameters
        ----------
        opening, rate : ndarray, shape (...)
            Angle of the following link less that of the leading one in rad, and its rate in rad/s.

        Returns
        -------
        ndarray, shape (...)
        """
        torque = -self.torsional_stiffness * (opening - self.free_angle)
        return np.asarray(torque - self.torsional_damping * rate)

    def to_table(self) -> TomlTable:
        """Keys of the joint in a model file."""
        # Stated even where it is zero, so that a spring without effect is read back too.
        stiffness = quantity(self.torsional_stiffness, units.TORSIONAL_STIFFNESS)
        return {"torsional_stiffness": stiffness, **si.table(self)}


Moved = Callable[[int, float], tuple[FloatArray, FloatArray]]
"""From a link's number and a place on it to its displacement from the rigid motion: along ground x
and y with the rotation of the section, (..., 3), and the rate of that."""


@dataclass(frozen=True)
class SpringLine:
    """Line, length and tension of a spring in given positions.

    Parameters
    ----------
    along : ndarray, shape (..., 2)
        Unit vector from the first end to the second, in ground axes.
    length : ndarray, shape (...)
        In m.
    relative_velocity : ndarray, shape (..., 2)
        Velocity of the second end against the first in m/s.
    tension : ndarray, shape (...)
        In N.
    """

    along: FloatArray
    length: FloatArray
    relative_velocity: FloatArray
    tension: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Rate of the length in m/s, (...)."""
        return np.asarray(np.sum(self.along * self.relative_velocity, axis=-1))

    @classmethod
    def of(
        cls,
        spring: Spring,
        topology: Topology,
        motion: RigidMotion,
        moved: Moved | None = None,
        *,
        needs_direction: bool = True,
    ) -> SpringLine:
        """Line of a spring in each position of its linkage.

        Parameters
        ----------
        spring : Spring
        topology : Topology
        motion : RigidMotion
        moved : callable, optional
            See :data:`Moved`; undisplaced links by default.
        needs_direction : bool
            Whether coincident ends are refused. The force of a spring without free length and
            damping is zero there.

        Returns
        -------
        SpringLine

        Raises
        ------
        InputError
            Where the ends meet; names the crank angle.
        """
        first, second = (
            _point_motion(topology, motion, end, moved) for end in (spring.first, spring.second)
        )
        line, relative_velocity = second[0] - first[0], second[1] - first[1]
        length = np.linalg.norm(line, axis=-1)
        size = max(spring.free_length, *(link.length for link in topology.links))
        met = length <= SAME_PLACE * size
        if needs_direction and np.any(met):
            angle = np.degrees(motion.crank_angle[met].flat[0])
            raise InputError(
                f"spring {spring.name}: its ends meet at crank angle {angle:.6g} deg, where its "
                "force has no direction; move an end, or leave that crank angle out"
            )
        along = line / np.where(met, 1.0, length)[..., None]
        tension = spring.stiffness * (length - spring.free_length)
        tension = tension + spring.damping * np.sum(along * relative_velocity, axis=-1)
        return cls(along, length, relative_velocity, tension)


@dataclass(frozen=True)
class ForceOnLink:
    """A force and a torque that act on a link or on the ground.

    Parameters
    ----------
    link : int
        Number of the link in the topology; ``GROUND_AFTER_LINKS`` of the ground.
    x : float or ndarray, shape (...)
        Place along the link's frame in m; an array where it moves along the link.
    force : ndarray, shape (..., 2)
        Ground axes, N.
    torque : ndarray, shape (...)
        In N m.
    y : float or ndarray, shape (...)
        Place across the link's frame in m.
    """

    link: int
    x: float | FloatArray
    force: FloatArray
    torque: FloatArray
    y: float | FloatArray = 0.0

    def moment(self, motion: RigidMotion) -> FloatArray:
        """Moment about the link's start in N m; shape (...)."""
        return cross(motion.arm(self.link, self.x, self.y), self.force) + self.torque

    def power(self, motion: RigidMotion) -> FloatArray:
        """Power on the moving link in W; shape (...)."""
        velocity = motion.velocity(self.link, self.x, self.y)
        turning = self.torque * motion.angular_velocity[..., self.link]
        return np.asarray(np.sum(self.force * velocity, axis=-1) + turning)


def forces_of_loads(
    topology: Topology,
    motion: RigidMotion,
    loads: Sequence[Load],
    time: ArrayLike = 0.0,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Force of each load on its link in each position.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    loads : sequence of Load
    time : array_like, shape (...)
        Time of each position in s, for loads over time.
    moved : callable, optional
        See :data:`Moved`.

    Yields
    ------
    ForceOnLink
    """
    for load in loads:
        link, x = topology.index(load.point.link), load.point.x
        values, angle = load.values(motion.crank_angle, time), motion.angle[..., link]
        if moved is not None:
            angle = angle + moved(link, x)[0][..., 2]
        yield ForceOnLink(link, x, load.in_ground_axes(values, angle), values[..., 2])


def applied_forces(
    topology: Topology,
    motion: RigidMotion,
    loads: Sequence[Load],
    springs: Sequence[Spring],
    joint_springs: Sequence[JointSpring],
    angles: FloatArray,
    time: ArrayLike = 0.0,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Forces of loads, of springs on both their ends, and torques of springs in joints.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    loads : sequence of Load
    springs : sequence of Spring
    joint_springs : sequence of JointSpring
        In pins and pivots; forces of radial springs are joint forces and not among these.
    angles : ndarray, shape (..., n_links)
        Angles of the links in rad, counted on continuously as the linkage turns.
    time : array_like, shape (...)
        Time of each position in s, for loads over time.
    moved : callable, optional
        See :data:`Moved`; undisplaced links by default.

    Yields
    ------
    ForceOnLink

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    yield from forces_of_loads(topology, motion, loads, time, moved)
    for one in forces_of_springs(topology, motion, springs, joint_springs, angles, moved):
        if one.link != GROUND_AFTER_LINKS:
            yield one


def forces_of_springs(
    topology: Topology,
    motion: RigidMotion,
    springs: Sequence[Spring],
    joint_springs: Sequence[JointSpring],
    angles: FloatArray,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Forces of springs on both their ends, and torques of springs in joints, on the ground too.

    Parameters
    ----------
    topology, motion, springs, joint_springs, angles, moved
        As in :func:`applied_forces`.

    Yields
    ------
    ForceOnLink

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    for spring in springs:
        needed = bool(spring.free_length or spring.damping)
        line = SpringLine.of(spring, topology, motion, moved, needs_direction=needed)
        pull = line.tension[..., None] * line.along
        for end, sign in ((spring.first, 1.0), (spring.second, -1.0)):
            link = GROUND_AFTER_LINKS if end.is_ground else topology.index(end.link)
            yield ForceOnLink(link, end.x, sign * pull, 0.0 * line.tension, end.y)
    for joint_spring in joint_springs:
        if joint_spring.torsional_stiffness or joint_spring.torsional_damping:
            gap, rate = joint_gap(topology, motion, joint_spring, angles, moved)
            torque = joint_spring.torque(gap[..., 2], rate[..., 2])
            for sign, link, x in _sides(topology, joint_spring):
                yield ForceOnLink(link, x, np.zeros((*torque.shape, 2)), sign * torque)


def joint_gap(
    topology: Topology,
    motion: RigidMotion,
    spring: JointSpring,
    angles: FloatArray,
    moved: Moved | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Deformation of the springs in a joint: follower's end against leader's, and its rate.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    spring : JointSpring
    angles : ndarray, shape (..., n_links)
        As in :func:`applied_forces`.
    moved : callable, optional
        See :data:`Moved`.

    Returns
    -------
    tuple of ndarray, shape (..., 3)
        Along ground x and y in m, and the angle between the links in rad; and their rates.
    """
    gap, rate = np.zeros((2, *motion.crank_angle.shape, 3))
    gap[..., 2] = topology.joint_angle(spring.joint, angles)
    rate[..., 2] = topology.joint_angle(spring.joint, motion.angular_velocity)
    if moved is not None:
        for sign, link, x in _sides(topology, spring):
            if link != GROUND_AFTER_LINKS:
                displacement, velocity = moved(link, x)
                gap, rate = gap + sign * displacement, rate + sign * velocity
    return gap, rate


def _sides(topology: Topology, spring: JointSpring) -> list[tuple[float, int, float]]:
    """Sign, link and place of the ends at a joint, the follower first."""
    ends = zip((1.0, -1.0), topology.pinned_ends[spring.joint], strict=True)
    ground = (GROUND_AFTER_LINKS, 0.0)
    return [(sign, *(topology.end_place(end) if end else ground)) for sign, end in ends]


def _point_motion(
    topology: Topology, motion: RigidMotion, point: AttachmentPoint, moved: Moved | None
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of a point in ground axes, each of shape (..., 2)."""
    if point.is_ground:
        place = np.broadcast_to((point.x, point.y), (*motion.crank_angle.shape, 2))
        return place, np.zeros_like(place)
    link = topology.index(point.link)
    place, velocity = motion.position(link, point.x), motion.velocity(link, point.x)
    if moved is None:
        return place, velocity
    displacement, rate = moved(link, point.x)
    return place + displacement[..., :2], velocity + rate[..., :2]
