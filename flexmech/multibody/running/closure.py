"""Joints put in place after every step, where the integration rule leaves them to drift.

As :mod:`flexmech.multibody.running.user_functions`, this is the text of exported scripts too.
Constraints on velocities leave places and angles to the integration rule, whose errors would add up
where a joint is not linear in the coordinates: the hub and a rigid link turn, arms turn with the
sections that they are on, a weld holds directions, a guide's line turns. The clamp alone would be
off by ``(speed * step)**3 / 12`` more after each step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.multibody.running.user_functions import Shaft


@dataclass(frozen=True)
class JoinedEnd:
    """A point that turns with a node, and the direction of the link there.

    Parameters
    ----------
    first : int
        The node's first coordinate in the system.
    node : tuple of float
        Its reference place in m.
    lever : tuple of float
        The point's place from the node, along and across the link, in m.
    has_slope : bool
        Whether its coordinates from the third are a slope vector, not an angle.
    """

    first: int
    node: tuple[float, float]
    lever: tuple[float, float]
    has_slope: bool

    def angle(self, position: Any) -> float:
        """Angle of the link's axis there in rad."""
        turn = self.first + 2
        if self.has_slope:
            return math.atan2(position[turn + 1], 1 + position[turn])
        return float(position[turn])

    def angle_row(self, position: Any, row: Any, factor: float) -> None:
        """Add the angle's derivative by the coordinates to a row.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        row : ndarray
            Added to.
        factor : float
            What the derivative is multiplied by.
        """
        turn = self.first + 2
        if self.has_slope:
            x, y = 1 + position[turn], position[turn + 1]
            row[turn] -= factor * y / (x * x + y * y)
            row[turn + 1] += factor * x / (x * x + y * y)
        else:
            row[turn] += factor

    def arm(self, position: Any) -> tuple[float, float]:
        """From the node to the point, in m."""
        angle, (x, y) = self.angle(position), self.lever
        cosine, sine = math.cos(angle), math.sin(angle)
        return cosine * x - sine * y, sine * x + cosine * y

    def place(self, position: Any) -> tuple[float, float]:
        """Where the point is, in m."""
        x = position[self.first] + self.node[0]
        y = position[self.first + 1] + self.node[1]
        if not (self.lever[0] or self.lever[1]):
            return x, y
        along, across = self.arm(position)
        return x + along, y + across

    def turn_by(self, position: Any, angle: float) -> None:
        """Turn the node, in place, by an angle in rad; a slope keeps its length."""
        turn = self.first + 2
        if self.has_slope:
            length = math.hypot(1 + position[turn], position[turn + 1])
            angle += self.angle(position)
            position[turn] = length * math.cos(angle) - 1
            position[turn + 1] = length * math.sin(angle)
        else:
            position[turn] += angle

    def place_row(self, position: Any, row: Any, x: float, y: float) -> None:
        """Add the derivative of the place's part along a vector to a row.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        row : ndarray
            Added to.
        x, y : float
            The vector.
        """
        row[self.first] += x
        row[self.first + 1] += y
        if self.lever[0] or self.lever[1]:
            across, along = self.arm(position)
            self.angle_row(position, row, y * across - x * along)


@dataclass(frozen=True)
class PlaceGap:
    """Two points that are one; without a leader, a point and a place of ground or hub.

    Parameters
    ----------
    follower : JoinedEnd
    leader : JoinedEnd or None
    place : tuple of float
        Of the point without a leader, in m.
    on_hub : bool
        Whether that place turns with the hub.
    """

    follower: JoinedEnd
    leader: JoinedEnd | None
    place: tuple[float, float]
    on_hub: bool

    def gap(self, position: Any, turn: float) -> tuple[float, ...]:
        """How far they are apart in m.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        turn : float
            Angle of the hub in rad.
        """
        x, y = self.place
        if self.on_hub:
            x, y = (
                math.cos(turn) * x - math.sin(turn) * y,
                math.sin(turn) * x + math.cos(turn) * y,
            )
        if self.leader is not None:
            x, y = self.leader.place(position)
        own = self.follower.place(position)
        return own[0] - x, own[1] - y

    def close(self, position: Any, turn: float) -> None:
        """Move the follower's node, in place, to close it; see :meth:`gap`."""
        x, y = self.gap(position, turn)
        position[self.follower.first] -= x
        position[self.follower.first + 1] -= y

    def add_rows(self, position: Any, rows: Any) -> None:
        """Add the derivatives of the gap by the coordinates.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        rows : ndarray
            Added to.
        """
        if self.leader is not None:
            self.leader.place_row(position, rows[0], -1.0, 0.0)
            self.leader.place_row(position, rows[1], 0.0, -1.0)
        self.follower.place_row(position, rows[0], 1.0, 0.0)
        self.follower.place_row(position, rows[1], 0.0, 1.0)


@dataclass(frozen=True)
class AngleGap:
    """An angle in rad that stays between two links, or between a link and the hub.

    Parameters
    ----------
    follower : JoinedEnd
    leader : JoinedEnd or None
        Of a hub, the frame that it turns against.
    between : float
        From the leader, or the hub, to the follower in rad.
    on_hub : bool
        Whether it is the hub that leads.
    """

    follower: JoinedEnd
    leader: JoinedEnd | None
    between: float
    on_hub: bool = False

    def gap(self, position: Any, turn: float) -> tuple[float, ...]:
        """How much it has changed in rad.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        turn : float
            Angle of the hub in rad.
        """
        turned = self.follower.angle(position) - self.between
        if self.leader is not None:
            turned -= self.leader.angle(position)
        if self.on_hub:
            turned -= turn
        return (math.remainder(turned, 2 * math.pi),)

    def close(self, position: Any, turn: float) -> None:
        """Turn the follower's node, in place, to close it; see :meth:`gap`."""
        self.follower.turn_by(position, -self.gap(position, turn)[0])

    def add_rows(self, position: Any, rows: Any) -> None:
        """Add the derivatives of the gap by the coordinates.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        rows : ndarray
            Added to.
        """
        if self.leader is not None:
            self.leader.angle_row(position, rows[0], -1.0)
        self.follower.angle_row(position, rows[0], 1.0)


@dataclass(frozen=True)
class LineGap:
    """A point on a line of the ground or of a rigid link.

    Parameters
    ----------
    end : JoinedEnd
    guide : JoinedEnd or None
        A point of the line on the link that guides it.
    place : tuple of float
        A point of a line of the ground in m.
    direction : float
        Angle of the line in rad, in the axes of the ground or of the link.
    """

    end: JoinedEnd
    guide: JoinedEnd | None
    place: tuple[float, float]
    direction: float

    def gap(self, position: Any, turn: float) -> tuple[float, ...]:
        """How far it is off the line in m.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        turn : float
            Angle of the hub in rad.
        """
        cosine, sine, x, y = self._from_line(position)
        return (cosine * y - sine * x,)

    def add_rows(self, position: Any, rows: Any) -> None:
        """Add the derivatives of the gap by the coordinates.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        rows : ndarray
            Added to.
        """
        cosine, sine, x, y = self._from_line(position)
        self.end.place_row(position, rows[0], -sine, cosine)
        if self.guide is not None:
            self.guide.place_row(position, rows[0], sine, -cosine)
            self.guide.angle_row(position, rows[0], -(cosine * x + sine * y))

    def _from_line(self, position: Any) -> tuple[float, float, float, float]:
        """The line's direction, and where the end is from the line's point in m."""
        angle, (x, y) = self.direction, self.place
        if self.guide is not None:
            angle += self.guide.angle(position)
            x, y = self.guide.place(position)
        own = self.end.place(position)
        return math.cos(angle), math.sin(angle), own[0] - x, own[1] - y


@dataclass(frozen=True)
class JointsClosedInTurn:
    """Joints of beams that are closed after every step, one after the other.

    With one clamp and pins alone it is enough to move the nodes of followers.

    Parameters
    ----------
    shaft : Shaft
    gaps : list
        Of joints that drift, a leader's before its followers'.
    """

    shaft: Shaft
    gaps: list[PlaceGap | AngleGap]

    def correct_coordinates(self, position: Any, t: float) -> None:
        """Correct the system's coordinates, in place; the hub's angle comes last."""
        position[-1] = turn = self.shaft.hub_angle(position, t)
        for each in self.gaps:
            each.close(position, turn)

    def after_step(self, mbs: Any, t: float) -> bool:
        """User function of the system after every step."""
        position = mbs.systemData.GetODE2Coordinates()
        self.correct_coordinates(position, t)
        mbs.systemData.SetODE2Coordinates(position)
        return True


@dataclass
class ClosedJoints:
    """All joints of a linkage, closed after a step by the least change of coordinates.

    Parameters
    ----------
    shaft : Shaft
    gaps : list
        Of the joints.
    axis : JoinedEnd or None
        The shaft's axis on a frame that moves.
    """

    shaft: Shaft
    gaps: list[PlaceGap | AngleGap | LineGap]
    axis: JoinedEnd | None = None

    def __post_init__(self) -> None:
        """Begin without an answer to gaps: the least change, as it was found last."""
        self._answer: Any = None
        # Angle of the hub in rad at which it was found.
        self._answer_turn = math.inf

    def correct_coordinates(self, position: Any, t: float) -> None:
        """Correct the system's coordinates, in place, by Gauss-Newton steps.

        What a correction leaves is of the square of the gap, in m and rad; of gaps
        below 1e-9 it is a hundredth or so, which the next step corrects.
        """
        turn = self.shaft.hub_angle(position, t)
        position[-1] = turn
        for _ in range(3):
            # Floats of Python are twice as fast here as those of an array.
            values = position.tolist()
            gap = [part for each in self.gaps for part in each.gap(values, turn)]
            greatest = max(max(gap), -min(gap))
            if greatest < 1e-15:
                break
            small = greatest < 1e-9
            # To seek the answer takes longer than to see how far the joints are open.
            if not small or abs(turn - self._answer_turn) > 0.01:
                self._answer, self._answer_turn = self._least_change(values), turn
            position -= self._answer.dot(gap)
            if small:
                break
        if self.axis is not None:
            position[-3:-1] = self.axis.place(position)
            position[-1] = turn + self.axis.angle(position)

    def _least_change(self, position: Any) -> Any:
        """Least change of coordinates that makes each gap grow by one, (size, gaps)."""
        count = sum(len(each.gap(position, 0.0)) for each in self.gaps)
        gradient, first = np.zeros((count, len(position))), 0
        for each in self.gaps:
            each.add_rows(position, gradient[first:])
            first += len(each.gap(position, 0.0))
        return np.linalg.solve(gradient @ gradient.T, gradient).T

    def after_step(self, mbs: Any, t: float) -> bool:
        """User function of the system after every step."""
        position = mbs.systemData.GetODE2Coordinates()
        self.correct_coordinates(position, t)
        mbs.systemData.SetODE2Coordinates(position)
        return True
