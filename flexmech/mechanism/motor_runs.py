"""Motion of a mechanism's rigid linkage under the motor of its drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages import (
    DriveTrain,
    MotorDrive,
    MotorRun,
    SettledRun,
    ShaftEquation,
    repeated,
    settled_motion,
    solved_run,
)
from flexmech.mechanism.mechanism import Mechanism
from flexmech.mechanism.shaft_load import RigidLinkageLoad
from flexmech.validation import POSITIVE, check_instance, check_number


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
    own = drive if drive is not None else mechanism.drive
    check_instance(own, MotorDrive, "drive", "give a flexmech.MotorDrive, or a model with a motor")
    assert isinstance(own, MotorDrive)
    if revolutions is not None:
        check_number(revolutions, "revolutions", "", POSITIVE)
    train = DriveTrain(own.driven_by)
    equation = ShaftEquation(RigidLinkageLoad(mechanism), mechanism.shaft_inertia, train)
    return solved_run(equation, own, revolutions)


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
