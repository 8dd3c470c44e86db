"""What a motor gives along a motion of its shaft that is known, and how it answers beside it."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motors.speed_control import DrivenBy

# Of the fastest time constant of a motor: a step of the states along a motion.
_PART = 0.25
# Relative and absolute tolerance of a correction, which the next run makes good.
_ROUGH = 1e-7
# Of the speed and of a command, over which the answer is differentiated.
_DIFFERENCE = 1e-6


def states_along(
    motor: DrivenBy, time: FloatArray, speed: FloatArray, start: FloatArray
) -> FloatArray:
    """States of a motor whose shaft moves as known.

    Parameters
    ----------
    motor : DrivenBy
    time : ndarray, shape (m,)
        Increasing, in s.
    speed : ndarray, shape (m,)
        Of the rotor over the gear ratio, in rad/s; a cubic spline between.
    start : ndarray, shape (k,)
        At the first time.

    Returns
    -------
    ndarray, shape (k, m)
    """
    from scipy.interpolate import CubicSpline

    if not motor.state_count:
        return np.zeros((0, len(time)))
    span = np.diff(time)
    parts = max(1, int(np.ceil(span.max() * motor.fastest_rate / _PART)))
    # Speeds at the start, the middle and the end of each part.
    places = np.linspace(0.0, 1.0, 2 * parts + 1)
    speeds = CubicSpline(time, speed)(time[:-1, None] + span[:, None] * places)
    found = np.empty((motor.state_count, len(time)))
    found[:, 0] = state = np.array(start, dtype=float)
    for number, (length, own) in enumerate(zip((span / parts).tolist(), speeds, strict=True)):
        for part in range(0, 2 * parts, 2):
            # The classical Runge-Kutta method: the same steps whatever the motion.
            first = motor.output(own[part], state).rates
            second = motor.output(own[part + 1], state + length / 2 * first).rates
            third = motor.output(own[part + 1], state + length / 2 * second).rates
            fourth = motor.output(own[part + 2], state + length * third).rates
            state = state + length / 6 * (first + 2 * second + 2 * third + fourth)
        found[:, number + 1] = state
    return found


def yielded_along(
    motor: DrivenBy,
    time: FloatArray,
    speed: FloatArray,
    applied: FloatArray,
    inertia: FloatArray,
    start: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """How a shaft with an inertia moves away from a motion whose torque is not quite the motor's.

    Parameters
    ----------
    motor : DrivenBy
    time : ndarray, shape (m,)
        Increasing, in s.
    speed, applied, inertia : ndarray, shape (m,)
        Of the motion: speed in rad/s, torque on the crank in N m, inertia there in kg m^2.
    start : ndarray, shape (k,)
        States of the motor at the first time.

    Returns
    -------
    angle, speed : ndarray, shape (m,)
        To be added to those of the motion.
    """
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    known = CubicSpline(time, np.stack([speed, applied, inertia], axis=1))
    gear = motor.motor.gear_ratio

    def rates(at: float, values: FloatArray) -> FloatArray:
        was, given, own = known(at)
        output = motor.output(was + values[1], values[2:])
        push = (gear * output.torque - given) / own
        return np.concatenate([[values[1], push], output.rates])

    found = solve_ivp(
        rates,
        (float(time[0]), float(time[-1])),
        np.concatenate([np.zeros(2), start]),
        method="DOP853",
        t_eval=time,
        rtol=_ROUGH,
        atol=_ROUGH,
    )
    return found.y[0], found.y[1]


def answer_along(
    motor: DrivenBy, speed: FloatArray, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How the torque on the crank falls with its speed and its angle, once a current has settled.

    Parameters
    ----------
    motor : DrivenBy
    speed : ndarray, shape (m,)
        Of the rotor over the gear ratio, in rad/s.
    state : ndarray, shape (k, m)

    Returns
    -------
    damping, stiffness : ndarray, shape (m,)
        In N m s/rad and N m/rad.
    """
    step = _DIFFERENCE * max(float(np.abs(speed).max()), 1.0)
    faster, slower = (motor.steady_torque(speed + change, state) for change in (step, -step))
    gear = motor.motor.gear_ratio
    damping = gear * (slower - faster) / (2 * step)
    if motor.control is None or not motor.control.has_integral:
        return damping, np.zeros_like(damping)
    moved = state.copy()
    step = _DIFFERENCE * max(float(np.abs(state[-1]).max()), 1.0)
    moved[-1] += step
    change = (motor.steady_torque(speed, moved) - motor.steady_torque(speed, state)) / step
    return damping, gear * motor.control.ki * change
