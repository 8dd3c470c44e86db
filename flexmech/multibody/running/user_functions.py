"""What Exudyn calls while a linkage runs, and what prescribes the motion of its shaft.

An exported script contains the text of these functions and classes as it stands here. They
need nothing but ``math``, ``bisect`` and plain numbers, so that what the program runs and what
it exports are the same.
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
        Of (start, duration, c, ((a, w, phase), ...)) in s and rad; none of a constant
        speed.
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

    def speed(self, t: float) -> float:
        """Angular speed at a time in s."""
        return self.motion(t)[1]

    def motion(self, t: float) -> tuple[float, float, float]:
        """Angle, angular speed and angular acceleration at a time in s."""
        if not self.pieces:
            return self.start_angle + self.final_speed * t, self.final_speed, 0.0
        number = bisect.bisect_right(self.pieces, t, key=lambda piece: piece[0])
        start, duration, polynomial, sines = self.pieces[max(number - 1, 0)]
        after = t - (start + duration) if number == len(self.pieces) else -1.0
        part = 1.0 if after >= 0 else (t - start) / duration
        angle, speed, gain = 0.0, 0.0, 0.0
        for coefficient in reversed(polynomial):
            gain = gain * part + 2 * speed
            speed = speed * part + angle
            angle = angle * part + coefficient
        for size, rate, phase in sines:
            angle += size * math.sin(rate * part + phase)
            speed += size * rate * math.cos(rate * part + phase)
            gain -= size * rate**2 * math.sin(rate * part + phase)
        angle += self.start_angle
        if after < 0:
            return angle, speed / duration, gain / duration**2
        return angle + self.final_speed * after, self.final_speed, 0.0

    def hub_angle(self, position: Any, t: float) -> float:
        """Angle of the hub, whose coordinate is the last one of the system."""
        return float(position[-1]) if self.is_free else self.angle(t)

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
        return self.speed(t)

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
    normal in rad; a sensor, if any, is that of the rotation of the link or frame it is on.

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
            found = [float(np.interp(where, at, column)) for column in chosen]
            last = (t, [0.0, 0.0, *found] if is_torque else [*found, 0.0])
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


def torque_history(times: Any, torques: Any) -> Any:
    """User function of the torque on a shaft that is free, linear between its times.

    Parameters
    ----------
    times : list of float
        Increasing, in s.
    torques : list of float
        In N m.
    """
    at, values = np.array(times), np.array(torques)

    def torque(mbs: Any, t: float, load: Any) -> list[float]:
        return [0.0, 0.0, float(np.interp(t, at, values))]

    return torque


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
