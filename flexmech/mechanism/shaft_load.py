"""What a rigid linkage asks of the shaft that turns it, as functions of the crank angle.

By inverse dynamics the torque is ``J(theta) alpha + c2 omega^2 + c1 omega + c0``, exactly: springs
and weight make c0, dampers c1, and c2 is half the slope of J. These are functions of the crank
angle over a turn, interpolated by periodic splines of fifth degree whose knots are doubled until
they hold. Loads over crank angle or time have corners: tables are of what a unit of them takes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import Load, ShaftLoad, assemblable
from flexmech.mechanism.mechanism import Mechanism

# Of the splines. At 256 knots the error of a smooth linkage is 1e-10, with the sixth power of them.
_DEGREE, _KNOTS, _MOST_KNOTS = 5, 256, 16_384
# Of the greatest value of each function.
_ACCURATE = 1e-11
# Speed and acceleration by which the parts are told from each other, in rad/s and rad/s^2.
_SPEED, _ACCELERATION = 10.0, 100.0
_TURN = 2 * np.pi
# Functions besides those of loads.
_OWN = 5
_DEGREES = np.radians(np.arange(360.0))


class RigidLinkageLoad(ShaftLoad):
    """Inertia, and torque without acceleration, of a mechanism's rigid linkage.

    Parameters
    ----------
    mechanism : Mechanism

    Raises
    ------
    InputError
        If the crank cannot turn fully, or the connections do not determine the forces.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        linkage = mechanism.linkage
        possible = assemblable(linkage, _DEGREES)
        if not possible.all():
            first = int(np.argmin(possible))
            raise InputError(
                f"drive: a motor needs a crank that turns fully, and at {first} deg this linkage "
                "cannot be assembled; change the lengths, or move the crank by a law"
            )
        self._tables = tuple(load for load in mechanism.loads if load.over != "constant")
        constant = tuple(load for load in mechanism.loads if load.over == "constant")
        self._mechanism = replace(mechanism, loads=constant, drive=None)
        self._units = [replace(self._mechanism, loads=(one,)) for one in _units(self._tables)]
        self._bare = replace(self._mechanism, loads=())
        # Coefficients of the powers of each piece, the highest first, (pieces, 6, n).
        self._pieces = self._fitted()

    @property
    def over_time(self) -> bool:
        """Whether a load goes over time."""
        return any(load.over == "time" for load in self._tables)

    def parts(
        self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """By the splines, and the tables of loads."""
        at, omega = np.asarray(angle, dtype=float), np.asarray(speed, dtype=float)
        turns, count = at / _TURN, len(self._pieces)
        place = (turns - np.floor(turns)) * count
        number = np.minimum(place.astype(np.intp), count - 1)
        inside, pieces = (place - number)[..., None], self._pieces[number]
        values = pieces[..., 0, :]
        for power in range(1, _DEGREE + 1):
            values = values * inside + pieces[..., power, :]
        inertia, still, linear, square, wound = (values[..., column] for column in range(_OWN))
        torque = still + omega * (linear + omega * square) + turns * wound
        for load_number, load in enumerate(self._tables):
            own = slice(_OWN + 3 * load_number, _OWN + 3 * load_number + 3)
            torque = torque + np.sum(values[..., own] * load.values(at, time), axis=-1)
        return inertia, np.asarray(torque)

    def _functions(self, angle: FloatArray) -> FloatArray:
        """All functions at crank angles (m,), (m, 5 + 3 n_tables)."""
        still = self._torque(self._mechanism, angle)
        ahead = self._torque(self._mechanism, angle, _SPEED) - still
        back = self._torque(self._mechanism, angle, -_SPEED) - still
        pulled = self._torque(self._mechanism, angle, 0.0, _ACCELERATION) - still
        # A torsional spring that is wound up takes more from turn to turn, evenly as it turns.
        wound = self._torque(self._mechanism, angle + _TURN) - still
        columns = [
            pulled / _ACCELERATION,
            still - angle / _TURN * wound,
            (ahead - back) / (2 * _SPEED),
            (ahead + back) / (2 * _SPEED**2),
            wound,
        ]
        if self._units:
            bare = self._torque(self._bare, angle)
            columns += [self._torque(unit, angle) - bare for unit in self._units]
        return np.stack(columns, axis=1)

    def _torque(
        self, mechanism: Mechanism, angle: FloatArray, speed: float = 0.0, rate: float = 0.0
    ) -> FloatArray:
        motion = mechanism.linkage.motion(angle, speed, rate)
        return mechanism.inverse_dynamics(motion).driving_torque

    def _fitted(self) -> FloatArray:
        """Periodic splines through the functions, with as many knots as they need, in pieces."""
        from scipy.interpolate import make_interp_spline

        count = _KNOTS
        values = self._functions(_TURN * np.arange(count) / count)
        while True:
            angles = _TURN * np.arange(count + 1) / count
            closed = np.concatenate([values, values[:1]])
            spline = make_interp_spline(angles, closed, k=_DEGREE, bc_type="periodic")
            middle = angles[:-1] + _TURN / (2 * count)
            between = self._functions(middle)
            scale = np.abs(values).max(axis=0) + np.finfo(float).tiny
            # Of the wound torque and of torques the scale is that of all torques at rest.
            scale[[1, 4]] = scale[[1, 4]].max()
            gap = float((np.abs(spline(middle) - between) / scale).max())
            if gap <= _ACCURATE or 2 * count > _MOST_KNOTS:
                return _in_pieces(spline, count)
            both = np.empty((2 * count, values.shape[1]))
            both[::2], both[1::2] = values, between
            values, count = both, 2 * count


def _in_pieces(spline: Any, count: int) -> FloatArray:
    """Coefficients (count, degree + 1, n) of the parts of pieces of even length, highest first."""
    span, begins = _TURN / count, _TURN * np.arange(count) / count
    powers = [
        spline(begins, nu=power) * span**power / math.factorial(power)
        for power in range(_DEGREE, -1, -1)
    ]
    return np.stack(powers, axis=1)


def _units(loads: tuple[Load, ...]) -> list[Load]:
    """Constant loads of one unit: of the force along x and y, and of the torque, of each load."""
    found = []
    for load in loads:
        for x, y, torque in np.eye(3).tolist():
            found.append(replace(load, force=((x, y),), torque=(torque,), over="constant", at=()))
    return found
