"""Motion of a mechanism's rigid linkage under the motor of its drive."""

from __future__ import annotations

from dataclasses import replace

from flexmech.errors import InputError
from flexmech.linkages import MotorDrive, MotorRun, ShaftEquation, solved_run
from flexmech.mechanism.mechanism import Mechanism
from flexmech.mechanism.shaft_load import ShaftLoad
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
    equation = ShaftEquation(ShaftLoad(mechanism), mechanism.shaft_inertia, own.driven_by)
    return solved_run(equation, own, revolutions)


def with_motor_run(mechanism: Mechanism, run: MotorRun) -> Mechanism:
    """A mechanism whose shaft has the inertia of a rotor that turns with it.

    Parameters
    ----------
    mechanism : Mechanism
    run : MotorRun

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        If the rotor is on a coupling: it has a motion of its own.
    """
    if run.equation.is_coupled:
        raise InputError(
            "drive: the rotor of this motor is on a coupling, which runs of elastic links do not "
            "have; leave coupling_stiffness out, or ask for the rigid linkage by flexmech "
            "kinematics"
        )
    inertia = mechanism.shaft_inertia + run.drive.motor.inertia_at_crank
    return replace(mechanism, shaft_inertia=inertia)
