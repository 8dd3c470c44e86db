"""States of a drive train along a motion of the crank that is known, and beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.linkages.motors.drive_train import DriveTrain

# Of the residual between the nodes, relative: values are off by 3e-8 of the greatest then, also of
# controls at their limits, far below what ends the passes of a run.
_TOLERANCE = 1e-5
# For each time that is given: more are needed where a control meets its limits. Work alone.
_MOST_NODES = 50


def states_along(
    train: DriveTrain, time: FloatArray, angle: FloatArray, speed: FloatArray, start: FloatArray
) -> FloatArray:
    """States of a drive train whose crank moves as known.

    Parameters
    ----------
    train : DriveTrain
    time : ndarray, shape (m,)
        Increasing, in s.
    angle, speed : ndarray, shape (m,)
        Of the crank in rad and rad/s; cubic splines between.
    start : ndarray, shape (k,)
        At the first time.

    Returns
    -------
    ndarray, shape (k, m)

    Raises
    ------
    ComputationError
        If the integration fails; names the time.
    """
    from scipy.interpolate import CubicSpline

    if not train.state_count:
        return np.zeros((0, len(time)))
    known = CubicSpline(time, np.stack([angle, speed], axis=1))

    def rates(at: FloatArray, states: FloatArray) -> FloatArray:
        place, turning = known(at).T
        return train.on_crank(place, turning, states)[1]

    return _integrated(rates, time, start)


def yielded_along(
    train: DriveTrain,
    time: FloatArray,
    angle: FloatArray,
    speed: FloatArray,
    applied: FloatArray,
    inertia: FloatArray,
    start: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """How a crank with an inertia moves away from a motion whose torque is not quite the train's.

    Parameters
    ----------
    train : DriveTrain
    time : ndarray, shape (m,)
        Increasing, in s.
    angle, speed, applied, inertia : ndarray, shape (m,)
        Of the motion: angle in rad, speed in rad/s, torque on the crank in N m, inertia there in
        kg m^2.
    start : ndarray, shape (k,)
        States of the train at the first time.

    Returns
    -------
    angle, speed : ndarray, shape (m,)
        To be added to those of the motion.

    Raises
    ------
    ComputationError
        If the integration fails; names the time.
    """
    from scipy.interpolate import CubicSpline

    known = CubicSpline(time, np.stack([angle, speed, applied, inertia], axis=1))

    def rates(at: FloatArray, values: FloatArray) -> FloatArray:
        place, was, given, own = known(at).T
        torque, changes = train.on_crank(place + values[0], was + values[1], values[2:])
        return np.concatenate([np.stack([values[1], (torque - given) / own]), changes])

    found = _integrated(rates, time, np.concatenate([np.zeros(2), start]))
    return found[0], found[1]


def _integrated(
    rates: Callable[[FloatArray, FloatArray], FloatArray], time: FloatArray, start: FloatArray
) -> FloatArray:
    """Values (n, m) at times (m,), all at once: by collocation of fourth order.

    The method of Kierzenka & Shampine 2001 for boundary values, all of which are at the start: what
    is known between the times is a spline of theirs, at whose knots a method that takes one step
    after the other would have to stop.
    """
    from scipy.integrate import solve_bvp

    found: Any = solve_bvp(
        rates,
        lambda first, _: first - start,
        time,
        np.repeat(start[:, None], len(time), axis=1),
        tol=_TOLERANCE,
        max_nodes=_MOST_NODES * len(time),
    )
    if found.status:
        raise ComputationError(
            f"motor and coupling cannot be followed in the run of {time[-1]:.6g} s: "
            f"{found.message} Check the motor's inductance and the coupling, whose times may be "
            "far shorter than the run"
        )
    return np.asarray(found.sol(time))
