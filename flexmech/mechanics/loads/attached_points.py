"""Points of links: where forces act, a hammer hits or a vibrometer looks, and how they move.

The displacement of a point is that of its link's shape functions, so that a point need not be a
node: ``u = row @ q`` with the coordinates q of the link, and ``row @ z`` with those of the linear
system. A force on the point in the same direction does the work ``f u``, so the transposed row is
its consistent load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import LINK_DIRECTIONS, LinkDirection
from flexmech.errors import InputError, suggestion
from flexmech.linkages import RigidMotion, Topology
from flexmech.linkages.motion import direction
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.links.link_model import LinkModel
from flexmech.validation import Bounds, check_choice, check_instance, check_number

ON_THE_LINK = Bounds(least=0.0, most=1.0)
EXAMPLE = "write LINK:FRACTION, such as coupler:0.5 for the middle of the coupler"


@dataclass(frozen=True)
class AttachedPoint:
    """A point on the axis of a link.

    Parameters
    ----------
    link : int
        Number of the link.
    x : float
        Distance from the link's start in m.
    rows : ndarray, shape (3, n_link)
        Displacement along and across the link's frame, and rotation, by the link's coordinates;
        of a rigid link for small rotations. Of links that are displaced (B, 3, n_link).
    end_rows : ndarray, shape (3, n_link)
        The same by the link's joined ends alone; see
        :class:`flexmech.mechanics.links.link_model.EndMatrices`.
    rigid : bool
        Whether the link is rigid.
    """

    link: int
    x: float
    rows: FloatArray
    end_rows: FloatArray
    rigid: bool = False

    @classmethod
    def of(
        cls, links: Sequence[LinkModel], link: int, fraction: float, length: float
    ) -> AttachedPoint:
        """Point at a fraction of a link's length.

        Parameters
        ----------
        links : sequence of LinkModel
            Reduced or not.
        link : int
        fraction : float
            Fraction of the link's length from its start.
        length : float
            Length of the link in m.
        """
        rows, end_rows = (
            np.concatenate(
                [r.displacement_at(np.array([fraction]))[0], r.rotation_at(fraction)[None]]
            )
            for r in (links[link].readings, links[link].ends.readings)
        )
        return cls(link, fraction * length, rows, end_rows, links[link].rigid)

    def rows_at(self, q: FloatArray) -> FloatArray:
        """Derivative of the finite displacement in the link's axes, (B, 3, n_link).

        Parameters
        ----------
        q : ndarray, shape (B, n_link)
            Displacement of the link.
        """
        rows = np.tile(self.rows, (len(q), 1, 1))
        if self.rigid:
            rows[:, 0, 2], rows[:, 1, 2] = -self.x * np.sin(q[:, 2]), self.x * np.cos(q[:, 2])
        return rows

    def force(
        self,
        motion: RigidMotion,
        force: FloatArray,
        torque: FloatArray,
        q: FloatArray | None = None,
        *,
        finite: bool = False,
    ) -> FloatArray:
        """Generalized force on the link's coordinates.

        On a rigid link at the rotation phi it is finite with its arm as it is turned, and else its
        moment is that of :mod:`flexmech.mechanics.links.body_forces`, in
        ``cos(phi) moment - sin(phi) virial``. A torque does not depend on the rotation: its part of
        the moment is ``torque cos(phi)``, and of the virial ``-torque sin(phi)``.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        force : ndarray, shape (B, 2)
            In ground axes.
        torque : ndarray, shape (B,)
        q : ndarray, shape (B, n_link), optional
            Displacement of the link; zero where it is left out.
        finite : bool
            Whether it acts on the link as it is displaced.

        Returns
        -------
        ndarray, shape (B, n_link)
        """
        pushed = _turned(np.column_stack([force, torque]), -motion.angle[:, self.link])
        if q is None or not self.rigid:
            return np.asarray(pushed @ self.rows)
        if finite:
            return np.asarray((pushed[:, None] @ self.rows_at(q))[:, 0])
        pushed[:, 2] *= np.cos(q[:, 2])
        return np.asarray(pushed @ self.rows)

    def virial(
        self,
        motion: RigidMotion,
        force: FloatArray,
        torque: FloatArray,
        q: FloatArray | None = None,
    ) -> FloatArray:
        """Virial in N m of a force on a rigid link about the link's start, (B,).

        Parameters
        ----------
        motion : RigidMotion
        force, torque, q : ndarray
            As of :meth:`force`.
        """
        along = np.sum(force * direction(motion.angle[:, self.link]), axis=1)
        turned = 0.0 if q is None else torque * np.sin(q[:, 2])
        return np.asarray(self.x * along - turned)

    def displacement(
        self, motion: RigidMotion, q: FloatArray, *, finite: bool = False
    ) -> FloatArray:
        """Displacement in ground axes and rotation.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,), not displaced.
        q : ndarray, shape (B, n_link)
            Displacement of the link.
        finite : bool
            Whether a rigid link turns by a finite angle.

        Returns
        -------
        ndarray, shape (B, 3)
        """
        return _turned(self._in_frame(q, finite), motion.angle[:, self.link])

    def displacement_rate(
        self, motion: RigidMotion, q: FloatArray, rate: FloatArray, *, finite: bool = False
    ) -> FloatArray:
        """Time derivative of :meth:`displacement`.

        Parameters
        ----------
        motion : RigidMotion
        q, rate : ndarray, shape (B, n_link)
            Coordinates of the link and their rates in its frame.
        finite : bool
            As of :meth:`displacement`.

        Returns
        -------
        ndarray, shape (B, 3)
        """
        moved, speed = self._in_frame(q, finite), motion.angular_velocity[:, self.link]
        velocity = rate @ self.rows.T
        if finite and self.rigid:
            velocity = (self.rows_at(q) @ rate[..., None])[..., 0]
        velocity[:, 0] -= speed * moved[:, 1]
        velocity[:, 1] += speed * moved[:, 0]
        return _turned(velocity, motion.angle[:, self.link])

    def _in_frame(self, q: FloatArray, finite: bool) -> FloatArray:
        """Displacement and rotation in the link's frame, (B, 3)."""
        moved = q @ self.rows.T
        if finite and self.rigid:
            turn = q[:, 2]
            moved[:, 0] += self.x * (np.cos(turn) - 1.0)
            moved[:, 1] += self.x * (np.sin(turn) - turn)
        return moved


def _turned(vectors: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors and rotations (B, 3, ...) turned by angles (B,)."""
    angle = angle.reshape(-1, *[1] * (vectors.ndim - 2))
    cosine, sine = np.cos(angle), np.sin(angle)
    turned, x, y = vectors.copy(), vectors[:, 0], vectors[:, 1]
    turned[:, 0], turned[:, 1] = cosine * x - sine * y, sine * x + cosine * y
    return turned


@dataclass(frozen=True)
class PointJacobian:
    """Jacobian of a point's displacement in ground axes and rotation by independent coordinates.

    Parameters
    ----------
    value, rate : ndarray, shape (B, 3, size)
        The Jacobian, and its time derivative.
    """

    value: FloatArray
    rate: FloatArray

    @classmethod
    def of(
        cls,
        point: AttachedPoint,
        frames: LinkFrames,
        motion: RigidMotion,
    ) -> PointJacobian:
        """Jacobian of a point of a link in the coordinates of link frames.

        Parameters
        ----------
        point : AttachedPoint
            Point of the links of ``frames``.
        frames : LinkFrames
        motion : RigidMotion
            Batch of shape (B,).
        """
        link = point.link
        value = frames.by_independent(motion, link, point.rows)
        rate = frames.by_independent(motion, link, point.end_rows, lambda tie: tie.rate)
        speed, angle = motion.angular_velocity[:, link, None], motion.angle[:, link]
        rate[:, 0] -= speed * value[:, 1]
        rate[:, 1] += speed * value[:, 0]
        return cls(_turned(value, angle), _turned(rate, angle))


@dataclass(frozen=True)
class LinkPoint:
    """A point on a link's axis.

    Parameters
    ----------
    link : str
    fraction : float
        Fraction of the link's length from its first joint, from 0 to 1.

    Raises
    ------
    InputError
        If the fraction is off the link.

    Examples
    --------
    >>> flexmech.LinkPoint.parse("coupler:0.5")
    LinkPoint(link='coupler', fraction=0.5)
    """

    link: str
    fraction: float

    def __post_init__(self) -> None:
        check_instance(self.link, str, "link of a point", EXAMPLE)
        check_number(self.fraction, f"the point's fraction of link {self.link!r}")
        if not ON_THE_LINK.hold(self.fraction):
            raise InputError(
                f"the point {self.link}:{self.fraction:g} is off its link; give a fraction of the "
                "link's length from 0, its first joint, to 1, its other end"
            )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``LINK:FRACTION``.

        Parameters
        ----------
        text : str

        Returns
        -------
        LinkPoint

        Raises
        ------
        InputError
            If it is no such text, or the point is off its link.
        """
        link, colon, fraction = text.strip().rpartition(":")
        try:
            number = float(fraction)
        except ValueError:
            colon = ""
        if not (colon and link.strip()):
            raise InputError(f"got {text!r}, which is no point of a link; {EXAMPLE}")
        return cls(link.strip(), number)

    def __str__(self) -> str:
        return f"{self.link}:{self.fraction:g}"

    def index(self, topology: Topology) -> int:
        """Number of its link.

        Parameters
        ----------
        topology : Topology

        Returns
        -------
        int

        Raises
        ------
        InputError
            If there is no such link; lists those that there are.
        """
        names = topology.link_names
        if self.link not in names:
            raise InputError(
                f"the point {self} is on no link of this linkage; {suggestion(self.link, names)}"
            )
        return topology.index(self.link)


def displacement_row(link: LinkModel, fraction: float, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in its link's coordinates.

    Parameters
    ----------
    link : LinkModel
        Reduced or not.
    fraction : float
        Fraction of the link's length, from 0 to 1.
    direction : {"transverse", "axial"}
        Across the link's frame or along it.

    Returns
    -------
    ndarray, shape (n_link,)
        In m for coordinates in m and rad.

    Raises
    ------
    InputError
        If the direction is neither.
    """
    check_choice(direction, LINK_DIRECTIONS, "direction")
    shapes = link.readings.displacement_at(np.array([fraction]))
    return np.asarray(shapes[0, 0 if direction == "axial" else 1])
