"""Loads on links and springs between them: plain data that rigid and elastic models read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motion import turned
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
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
            Of :meth:`values`.
        angle : ndarray, shape (...)
            Of the section that the load acts on, in rad.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        if self.axes == "ground":
            return values[..., :2]
        return turned(values[..., :2], angle)


@dataclass(frozen=True)
class Spring:
    """A straight spring between two points, with a damper in parallel.

    Parameters
    ----------
    name : str
    first, second : AttachmentPoint
    stiffness : float
        In N/m.
    free_length : float
        Without force, in m.
    damping : float
        In N s/m.

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
    stiffness: float
    free_length: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        what = f"spring {self.name}"
        check_number(self.stiffness, f"{what}: stiffness", "N/m", NOT_NEGATIVE)
        check_number(self.free_length, f"{what}: free_length", "m", NOT_NEGATIVE)
        check_number(self.damping, f"{what}: damping", "N s/m", NOT_NEGATIVE)
        for end in (self.first, self.second):
            check_instance(end, AttachmentPoint, f"each end of {what}", _POINT)
        if self.first.link == self.second.link:
            raise InputError(f"{what} has both ends on {self.first.link}; join two links")


@dataclass(frozen=True)
class JointSpring:
    """Springs and dampers in a pin or pivot.

    Parameters
    ----------
    joint : str
    torsional_stiffness : float
        In N m/rad.
    torsional_damping : float
        In N m s/rad.
    free_angle : float
        Angle of the following link less that of the leading one, or of a pivoted link, in rad,
        at which the spring has no torque; counted on continuously as the linkage turns, from the
        angles at crank angle zero (:func:`flexmech.linkages.continuous_angles`, which
        ``flexmech kinematics`` writes too).
    radial_stiffness : float, optional
        In N/m, the same in all directions; None where the pin is rigid.
    radial_damping : float
        In N s/m.

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
    torsional_stiffness: float = 0.0
    torsional_damping: float = 0.0
    free_angle: float = 0.0
    radial_stiffness: float | None = None
    radial_damping: float = 0.0

    def __post_init__(self) -> None:
        what = f"spring in joint {self.joint}"
        turning, damping = self.torsional_stiffness, self.torsional_damping
        check_number(turning, f"{what}: torsional_stiffness", "N m/rad", NOT_NEGATIVE)
        check_number(damping, f"{what}: torsional_damping", "N m s/rad", NOT_NEGATIVE)
        check_number(self.free_angle, f"{what}: free_angle", "rad")
        check_number(self.radial_damping, f"{what}: radial_damping", "N s/m", NOT_NEGATIVE)
        if self.radial_stiffness is not None:
            check_number(self.radial_stiffness, f"{what}: radial_stiffness", "N/m", POSITIVE)
        elif self.radial_damping:
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
