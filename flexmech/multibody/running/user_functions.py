"""User functions of a running linkage in Exudyn, and the motion of its shaft.

An exported script contains the text of these functions and classes as it stands here. They
need nothing but ``math``, ``bisect``, NumPy and plain numbers, so that what the program runs and
what it exports are the same.

Joints are put in place after every step, where the integration rule leaves them to drift:
constraints on velocities leave places and angles to the integration rule, whose errors would add up
where a joint is not linear in the coordinates: the hub and a rigid link turn, arms turn with the
sections that they are on, a weld holds directions, a guide's line turns. The clamp alone would be
off by ``(speed * step)**3 / 12`` more after each step.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Shaft:
    """Prescribed angle of the driven link at its clamp: a law, then a constant speed.

    The law is in pieces: from the time ``start`` on the angle is that at time zero and
    ``sum(c[k] * tau**k) + sum(a * sin(w * tau + phase))``, with the part
    ``tau = (t - start) / duration``.
    A shaft that is free is turned by a torque, and its hub stands where that takes it.

    Parameters
    ----------
    start_angle : float
        At time zero, in rad.
    final_speed : float
        In rad/s.
    pieces : tuple
        Pieces (start, duration, c, ((a, w, phase), ...)) in s and rad; a constant
        speed has none.
    is_free : bool
        Whether the angle is that of the mean motion alone.
    """

    start_angle: float
    final_speed: float
    pieces: tuple[Any, ...] = ()
    is_free: bool = False

    def angle(self, t: float) -> float:
        """Angle at a time in s."""
        return self.motion(t)[0]

    def motion(self, t: float) -> tuple[float, float, float]:
        """Angle, angular speed and angular acceleration at a time in s."""
        if not self.pieces:
            return self.start_angle + self.final_speed * t, self.final_speed, 0.0
        number = bisect.bisect_right(self.pieces, t, key=lambda piece: piece[0])
        start, duration, polynomial, sines = self.pieces[max(number - 1, 0)]
        after = t - (start + duration) if number == len(self.pieces) else -1.0
        fraction = 1.0 if after >= 0 else (t - start) / duration
        angle, speed, gain = 0.0, 0.0, 0.0
        for coefficient in reversed(polynomial):
            gain = gain * fraction + 2 * speed
            speed = speed * fraction + angle
            angle = angle * fraction + coefficient
        for size, rate, phase in sines:
            angle += size * math.sin(rate * fraction + phase)
            speed += size * rate * math.cos(rate * fraction + phase)
            gain -= size * rate**2 * math.sin(rate * fraction + phase)
        angle += self.start_angle
        if after < 0:
            return angle, speed / duration, gain / duration**2
        return angle + self.final_speed * after, self.final_speed, 0.0

    def hub_angle(self, position: Any, t: float, below: float = 0.0) -> float:
        """Angle of the hub against what carries it, in rad.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system, of which the last one is the hub's angle.
        t : float
            In s.
        below : float
            Angle of a frame on springs in rad.
        """
        return float(position[-1]) - below if self.is_free else self.angle(t)

    def constraint_angle(self, mbs: Any, t: float, number: int, offset: float) -> float:
        """User function of a constraint: its offset.

        Parameters
        ----------
        mbs, t, number, offset
            What Exudyn gives to a constraint.
        """
        return self.angle(t)

    def constraint_speed(self, mbs: Any, t: float, number: int, offset: float) -> float:
        """User function of a constraint: the time derivative of its offset.

        Parameters
        ----------
        mbs, t, number, offset
            What Exudyn gives to a constraint.
        """
        return self.motion(t)[1]

    def tip_deflection(
        self, mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any
    ) -> list[float]:
        """Sensor: distance of a clamped link's tip from the tangent at its clamp.

        The sensors are the positions of its start and its end, and the rotation of a
        frame on springs, if one carries the shaft.

        Parameters
        ----------
        mbs, t, sensors, factors, configuration
            What Exudyn gives to a sensor.
        """
        x0, y0, _ = mbs.GetSensorValues(sensors[0], configuration)
        x1, y1, _ = mbs.GetSensorValues(sensors[1], configuration)
        angle = self.angle(t)
        if len(sensors) > 2:
            angle += mbs.GetSensorValues(sensors[2], configuration)[2]
        return [math.cos(angle) * (y1 - y0) - math.sin(angle) * (x1 - x0)]


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

    def add_row(self, position: Any, row: Any, x: float, y: float, turn: float) -> None:
        """Add the derivatives of the place along a vector and of the angle to a row.

        Parameters
        ----------
        position : ndarray
            Coordinates of the system.
        row : ndarray
            Added to.
        x, y : float
            The vector.
        turn : float
            What the derivative of the angle is multiplied by.
        """
        row[self.first] += x
        row[self.first + 1] += y
        if self.lever[0] or self.lever[1]:
            across, along = self.arm(position)
            turn += y * across - x * along
        if self.has_slope:
            x, y = 1 + position[self.first + 2], position[self.first + 3]
            row[self.first + 2] -= turn * y / (x * x + y * y)
            row[self.first + 3] += turn * x / (x * x + y * y)
        else:
            row[self.first + 2] += turn


@dataclass(frozen=True)
class PlaceGap:
    """Two points that are one: of a follower, and of its leader, or of the ground.

    Parameters
    ----------
    follower : JoinedEnd
    leader : JoinedEnd or None
        None of the ground.
    place : tuple of float
        From the leader, or of the point of the ground, in m.
    on_hub : bool
        Whether that place turns with the hub, and with its leader.
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
        x, y = self._arm(position, turn)
        if self.leader is not None:
            leader = self.leader.place(position)
            x, y = x + leader[0], y + leader[1]
        follower = self.follower.place(position)
        return follower[0] - x, follower[1] - y

    def _arm(self, position: Any, turn: float) -> tuple[float, float]:
        x, y = self.place
        if not self.on_hub:
            return x, y
        if self.leader is not None:
            turn += self.leader.angle(position)
        cosine, sine = math.cos(turn), math.sin(turn)
        return cosine * x - sine * y, sine * x + cosine * y

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
            # The hub's angle is the last coordinate; other places do not turn.
            x, y = self._arm(position, position[-1]) if self.on_hub else (0.0, 0.0)
            self.leader.add_row(position, rows[0], -1.0, 0.0, y)
            self.leader.add_row(position, rows[1], 0.0, -1.0, -x)
        self.follower.add_row(position, rows[0], 1.0, 0.0, 0.0)
        self.follower.add_row(position, rows[1], 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class AngleGap:
    """An angle in rad that stays between two links, or between a link and the hub.

    Parameters
    ----------
    follower : JoinedEnd
    leader : JoinedEnd or None
        For a hub, the frame that it turns against.
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
            self.leader.add_row(position, rows[0], 0.0, 0.0, -1.0)
        self.follower.add_row(position, rows[0], 0.0, 0.0, 1.0)


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
        self.end.add_row(position, rows[0], -sine, cosine, 0.0)
        if self.guide is not None:
            along = cosine * x + sine * y
            self.guide.add_row(position, rows[0], sine, -cosine, -along)

    def _from_line(self, position: Any) -> tuple[float, float, float, float]:
        """The line's direction, and where the end is from the line's point in m."""
        angle, (x, y) = self.direction, self.place
        if self.guide is not None:
            angle += self.guide.angle(position)
            x, y = self.guide.place(position)
        end = self.end.place(position)
        return math.cos(angle), math.sin(angle), end[0] - x, end[1] - y


@dataclass
class ClosedJoints:
    """Joints of a linkage, closed after a step by the least change of coordinates.

    With one clamp and pins alone it is enough to move the nodes of followers, joint by
    joint.

    Parameters
    ----------
    shaft : Shaft
    gaps : list
        Gaps of the joints. Where they are closed in turn, of those that drift alone, a
        leader's before its followers'.
    axis : JoinedEnd or None
        The shaft's axis on a frame that moves.
    in_turn : bool
        Whether one joint is closed after the other, by moving its follower.
    """

    shaft: Shaft
    gaps: list[Any]
    axis: JoinedEnd | None = None
    in_turn: bool = False

    def __post_init__(self) -> None:
        """Begin without an answer to gaps: the least change, as it was found last."""
        self._answer: Any = None
        # Angle of the hub in rad at which it was found.
        self._answer_turn = math.inf

    def correct_coordinates(self, position: Any, t: float) -> None:
        """Correct the system's coordinates, in place, by Gauss-Newton steps.

        What a correction leaves is of the square of the gap, in m and rad; of gaps
        below 1e-9 it is a hundredth or so, which the next step corrects. The hub's
        angle is the last coordinate.
        """
        below = 0.0 if self.axis is None else self.axis.angle(position)
        position[-1] = turn = self.shaft.hub_angle(position, t, below)
        if self.in_turn:
            for gap in self.gaps:
                gap.close(position, turn)
            return
        for _ in range(3):
            # Floats of Python are twice as fast here as those of an array.
            values = position.tolist()
            open_by = [value for gap in self.gaps for value in gap.gap(values, turn)]
            greatest = max(max(open_by), -min(open_by))
            if greatest < 1e-15:
                break
            small = greatest < 1e-9
            # To seek the answer takes longer than to see how far the joints are open.
            if not small or abs(turn - self._answer_turn) > 0.01:
                self._answer, self._answer_turn = self._least_change(values), turn
            position -= self._answer.dot(open_by)
            if small:
                break
        if self.axis is not None:
            position[-3:-1] = self.axis.place(position)
            position[-1] = turn + self.axis.angle(position)

    def _least_change(self, position: Any) -> Any:
        """Least change of coordinates that makes each gap grow by one, (size, gaps)."""
        counts = [len(gap.gap(position, 0.0)) for gap in self.gaps]
        gradient, first = np.zeros((sum(counts), len(position))), 0
        for gap, count in zip(self.gaps, counts, strict=True):
            gap.add_rows(position, gradient[first:])
            first += count
        return np.linalg.solve(gradient @ gradient.T, gradient).T

    def after_step(self, mbs: Any, t: float) -> bool:
        """User function of the system after every step."""
        position = mbs.systemData.GetODE2Coordinates()
        self.correct_coordinates(position, t)
        mbs.systemData.SetODE2Coordinates(position)
        return True


def middle_deflection(
    mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any
) -> list[float]:
    """Sensor: distance of a link's middle from the line between its ends.

    Positive to the left of it. The sensors are the positions of the start, of points
    before and behind the middle, and of the end; the factor is how far from the one to
    the other the middle is.

    Parameters
    ----------
    mbs, t, sensors, factors, configuration
        What Exudyn gives to a sensor.
    """
    x0, y0, _ = mbs.GetSensorValues(sensors[0], configuration)
    x1, y1, _ = mbs.GetSensorValues(sensors[3], configuration)
    before = mbs.GetSensorValues(sensors[1], configuration)
    behind = mbs.GetSensorValues(sensors[2], configuration)
    x, y, _ = before + factors[0] * (behind - before)
    cross = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    return [cross / math.hypot(x1 - x0, y1 - y0)]


def constraint_force(
    mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any
) -> list[float]:
    """Sensor: sum of the forces of the constraints whose numbers the factors are.

    They act on the held or following link, in ground axes: minus the multipliers.
    A force has two of them in turn, a torque one.

    Parameters
    ----------
    mbs, t, sensors, factors, configuration
        What Exudyn gives to a sensor.
    """
    multipliers = mbs.systemData.GetAECoordinates()
    numbers = [int(number) for number in factors]
    rows = [row for number in numbers for row in mbs.systemData.GetObjectLTGAE(number)]
    force = [0.0] * min(2, len(rows))
    for count, row in enumerate(rows):
        force[count % len(force)] -= float(multipliers[row])
    return force


def guide_line_force(
    mbs: Any, t: float, sensors: Any, factors: Any, configuration: Any
) -> list[float]:
    """Sensor: force of a line on the end that slides on it, in ground axes.

    The first factor is the number of the constraint, the second the angle of the line's
    normal in rad; a sensor, if any, is that of the rotation of what the line is on.

    Parameters
    ----------
    mbs, t, sensors, factors, configuration
        What Exudyn gives to a sensor.
    """
    row = mbs.systemData.GetObjectLTGAE(int(factors[0]))[0]
    force = float(mbs.systemData.GetAECoordinates()[row])
    angle = factors[1]
    if len(sensors):
        angle += mbs.GetSensorValues(sensors[0], configuration)[2]
    return [force * math.cos(angle), force * math.sin(angle)]


def difference_mass(mass: float, inertia: float) -> Any:
    """Mass in kg and inertia in kg m^2 by the difference of two nodes' velocities."""
    difference = np.array([[1.0, -1.0], [-1.0, 1.0]])
    return np.kron(difference, np.diag([mass, mass, inertia]))


def load_history(
    shaft: Shaft, crank_lead: float, over: str, places: Any, rows: Any, is_torque: bool
) -> Any:
    """User function of a load from a table, linear between its places.

    Parameters
    ----------
    shaft : Shaft
    crank_lead : float
        Angle of the driven link less that of the crank, in rad.
    over : {"constant", "crank_angle", "time"}
    places : list of float
        Crank angles in rad, of a load that repeats with the turn, or times in s.
    rows : list of list of float
        Force along x and y in N and torque in N m at each place.
    is_torque : bool
        Whether the torque is wanted.
    """
    columns, at = np.array(rows).T, np.array(places)
    if over == "constant":
        columns, at = columns[:, :1], np.zeros(1)
    if over == "crank_angle":
        # The last place, a turn back, and the first one, a turn on, close the circle.
        order = np.argsort(at % (2 * math.pi))
        order = np.concatenate([order[-1:], order, order[:1]])
        columns, at = columns[:, order], at[order] % (2 * math.pi)
        at[0], at[-1] = at[0] - 2 * math.pi, at[-1] + 2 * math.pi
    chosen = columns[2:] if is_torque else columns[:2]
    # Iterations of a step ask for the same instant.
    last: tuple[float, list[float]] = (math.nan, [])

    def values(mbs: Any, t: float, load: Any) -> list[float]:
        nonlocal last
        if t != last[0]:
            where = t
            if over == "crank_angle":
                where = (shaft.angle(t) - crank_lead) % (2 * math.pi)
            now = [float(np.interp(where, at, column)) for column in chosen]
            last = (t, [0.0, 0.0, *now] if is_torque else [*now, 0.0])
        return last[1]

    return values


def section_couples(
    shaft: Shaft, crank_lead: float, crank_angles: Any, angle: Any, inertia: float
) -> Any:
    """User function of the force on a link's end by the couples that turn its sections.

    These are constant along the link and act as two forces across it, at its ends.

    Parameters
    ----------
    shaft : Shaft
    crank_lead : float
        Angle of the driven link less that of the crank, in rad.
    crank_angles : list of float
        First and last crank angle, in rad; a turn apart where the crank turns round.
    angle : list of float
        Angle of the link in rad between these: coefficients of Chebyshev polynomials.
    inertia : float
        Rotary inertia of the sections in kg m; with the other sign at the link's start.
    """
    series = np.polynomial.Chebyshev(angle, crank_angles)
    first, last = crank_angles
    pieces = 1440
    at = np.linspace(first, last, pieces + 1)
    across = -inertia * np.stack([-np.sin(series(at)), np.cos(series(at))])
    first_rate, second_rate = series.deriv()(at), series.deriv(2)(at)
    table = np.concatenate([across * first_rate, across * second_rate]).T
    turns = last - first > 2 * math.pi - 1e-9
    known: tuple[float, list[float]] = (math.nan, [])

    def force(mbs: Any, t: float, load: Any) -> list[float]:
        nonlocal known
        if t != known[0]:
            crank, speed, gain = shaft.motion(t)
            where = crank - crank_lead - first
            if turns:
                where %= 2 * math.pi
            place = min(max(where / (last - first), 0.0), 1.0) * pieces
            before = min(int(place), pieces - 1)
            change = table[before + 1] - table[before]
            x, y, x2, y2 = (table[before] + (place - before) * change).tolist()
            square = speed**2
            known = t, [gain * x + square * x2, gain * y + square * y2, 0.0]
        return known[1]

    return force


def turned_frame(x: float, y: float, angle: float) -> Any:
    """Frame of a marker in its body's.

    Parameters
    ----------
    x, y : float
        Its place in m.
    angle : float
        In rad.
    """
    frame = np.eye(4)
    cosine, sine = math.cos(angle), math.sin(angle)
    frame[:2, :2] = [[cosine, -sine], [sine, cosine]]
    frame[:2, 3] = x, y
    return frame
