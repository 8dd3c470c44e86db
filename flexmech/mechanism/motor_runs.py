"""Motion of a mechanism's rigid linkage under the motor of its drive.

By inverse dynamics the torque on the shaft is ``J(theta) alpha + c2 omega^2 + c1 omega + c0``,
exactly: springs and weight make c0, dampers c1, and c2 is half the slope of J. These are functions
of the crank angle over a turn, interpolated by periodic splines of fifth degree whose knots are
doubled until they hold. Loads over crank angle or time have corners: tables are of what a unit of
them takes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import Load, MotorDrive, MotorRun, SettledRun, assemblable
from flexmech.linkages.motors.integrated_run import solved_run
from flexmech.linkages.motors.motor import DriveTrain
from flexmech.linkages.motors.motor_run import ShaftEquation, ShaftLoad, repeated, settled_motion
from flexmech.mechanism.mechanism import Mechanism
from flexmech.validation import POSITIVE, check_instance, check_number

# Knots of the splines. With 256 a smooth linkage has an error of 1e-10, of sixth order.
_DEGREE, _KNOTS, _MOST_KNOTS = 5, 256, 16_384
# Error of a spline, over the greatest value of its function.
_ACCURATE = 1e-11
# Speed and acceleration that separate the parts of the torque, in rad/s and rad/s^2.
_SPEED, _ACCELERATION = 10.0, 100.0
_TURN = 2 * np.pi
# Functions besides those of loads.
_OWN = 5
_DEGREES = np.radians(np.arange(360.0))


def motor_run(
    mechanism: Mechanism, drive: MotorDrive | None = None, revolutions: float | None = None
) -> MotorRun:
    """Motion of the rigid linkage under a motor, from rest.

    Parameters
    ----------
    mechanism : Mechanism
    drive : MotorDrive, optional
        Left out: the mechanism's.
    revolutions : float, optional
        Turns of the crank after which the run ends where the drive states no time. Left out: until
        its speed repeats itself from turn to turn.

    Returns
    -------
    MotorRun
        A drive as any other; a motor that stalls ends it.

    Raises
    ------
    InputError
        If there is no motor, the crank cannot turn fully, or nothing has any inertia.
    ComputationError
        If the integration fails; names the time and the crank angle.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/slider_crank.toml")
    >>> motor = flexmech.TorqueMotor((0.0, 200.0), (0.4, 0.0), inertia=2e-4)
    >>> run = flexmech.motor_run(mechanism, flexmech.MotorDrive(motor))
    >>> round(run.settled.mean_speed, 3), run.stall
    (196.231, None)
    """
    motor_drive = drive if drive is not None else mechanism.drive
    check_instance(
        motor_drive, MotorDrive, "drive", "give a flexmech.MotorDrive, or a model with a motor"
    )
    assert isinstance(motor_drive, MotorDrive)
    if revolutions is not None:
        check_number(revolutions, "revolutions", "", POSITIVE)
    train = DriveTrain(motor_drive.motor, motor_drive.control)
    equation = ShaftEquation(RigidLinkageLoad(mechanism), mechanism.shaft_inertia, train)
    return solved_run(equation, motor_drive, revolutions)


def settled_run(mechanism: Mechanism, drive: MotorDrive, revolutions: float = 1.0) -> SettledRun:
    """Turns of the rigid linkage's settled motion under a motor.

    Parameters
    ----------
    mechanism : Mechanism
    drive : MotorDrive
        Whose time, if it states one, is that of the run.
    revolutions : float
        Turns of the run otherwise.

    Returns
    -------
    SettledRun
        From the drive's start angle on.

    Raises
    ------
    InputError
        If the motor stalls or settles at no speed, or as :func:`motor_run`.
    ComputationError
        If the integration fails; names the time and the crank angle.
    """
    run = motor_run(mechanism, replace(drive, time=None))
    if run.stall is not None:
        angle = np.degrees(run.stall.crank_angle) % 360
        raise InputError(
            f"drive: the motor stalls at {angle:.4g} deg, and so has no settled motion; give a "
            "stronger one"
        )
    near = run.values[:, -1].copy()
    near[run.equation.train.angles] -= near[0] - drive.start_angle
    turn = settled_motion(run.equation, near)
    if turn is None:
        raise InputError(
            "drive: the motor settles at no speed: its torque does not fall with speed, or a load "
            "goes over time; choose start rigid or equilibrium, and state how long the run lasts"
        )
    return repeated(turn, turn, drive, revolutions)


def with_motor_run(mechanism: Mechanism, run: MotorRun) -> Mechanism:
    """A mechanism whose shaft has the inertia of a rotor that turns rigidly with it.

    Parameters
    ----------
    mechanism : Mechanism
    run : MotorRun

    Returns
    -------
    Mechanism
        A rotor on a coupling has a motion of its own, and adds nothing.
    """
    inertia = mechanism.shaft_inertia + run.equation.train.rigid_inertia
    return replace(mechanism, shaft_inertia=inertia)


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
        self._spline = self._fitted()

    @property
    def over_time(self) -> bool:
        """Whether a load goes over time."""
        return any(load.over == "time" for load in self._tables)

    def parts(
        self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """By the splines, and the tables of loads."""
        at, omega = np.asarray(angle, dtype=float), np.asarray(speed, dtype=float)
        turns = at / _TURN
        values = self._spline((turns - np.floor(turns)) * _TURN)
        inertia, still, linear, square, wound = (values[..., column] for column in range(_OWN))
        torque = still + omega * (linear + omega * square) + turns * wound
        for load_number, load in enumerate(self._tables):
            columns = slice(_OWN + 3 * load_number, _OWN + 3 * load_number + 3)
            torque = torque + np.sum(values[..., columns] * load.values(at, time), axis=-1)
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

    def _fitted(self) -> Any:
        """Periodic splines through the functions, with as many knots as they need."""
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
            # Wound torque and torques are scaled by all torques at rest.
            scale[[1, 4]] = scale[[1, 4]].max()
            gap = float((np.abs(spline(middle) - between) / scale).max())
            if gap <= _ACCURATE or 2 * count > _MOST_KNOTS:
                return spline
            both = np.empty((2 * count, values.shape[1]))
            both[::2], both[1::2] = values, between
            values, count = both, 2 * count


def _units(loads: tuple[Load, ...]) -> list[Load]:
    """Constant loads of one unit: of the force along x and y, and of the torque, of each load."""
    units = []
    for load in loads:
        for x, y, torque in np.eye(3).tolist():
            units.append(replace(load, force=((x, y),), torque=(torque,), over="constant", at=()))
    return units
