"""A run under a motor by the reference engine: linear about a motion, again and again.

The rigid linkage's motion under the motor is the first one. The links run about it with the shaft
free, under the torque that the motor gives along the shaft's last motion and with what that torque
answers (Newton's method on the whole motion, with a current that follows at once). When the torque
is that of the motor along the motion that it makes, the run is exact in the shaft's rotation: what
was linear in it is zero then. A shaft that leaves the motion that the frames turn with takes these
along.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.linkages import MotorRun, answer_along, states_along, yielded_along
from flexmech.time_domain import ShaftTorque, Trajectory

logger = logging.getLogger(__name__)

# Of the greatest torque: by which that of a run may be off the motor's along its motion.
_CONVERGED = 1e-5
# A correction by the rigid linkage gains more than a pass, up to what its splines leave.
_WORTH = 5e-5
_MOST_PASSES = 25
# In rad: a shaft that is farther off takes the frames along. Links in natural coordinates are exact
# at any rotation, others to first order.
_FAR = 0.01
# Pieces of the smooth part of the shaft's motion that frames follow, in a turn: what is faster is
# vibration, which stays a coordinate.
_PIECES_OF_A_TURN = 12
_DEGREE = 5


@dataclass
class _Known:
    """The motion of the shaft that is known: of the frames, and how it leaves these.

    Parameters
    ----------
    nominal : MotorRun
        Motion that the frames turn with.
    time : ndarray, shape (m,)
        In s.
    across, turning : ndarray, shape (m,)
        Coordinate by which the shaft turns, and its rate.
    rotation, rate : ndarray, shape (m,)
        Of the shaft against the nominal motion, in rad and rad/s.
    """

    nominal: MotorRun
    time: FloatArray
    across: FloatArray
    turning: FloatArray
    rotation: FloatArray
    rate: FloatArray

    def at(self, time: FloatArray) -> _Known:
        """The same at other times; the last values stay beyond the last of its own."""
        from scipy.interpolate import CubicSpline

        inside = np.clip(time, self.time[0], self.time[-1])
        moved = (
            CubicSpline(self.time, own)(inside)
            for own in (self.across, self.turning, self.rotation, self.rate)
        )
        return _Known(self.nominal, time, *moved)


@dataclass
class MotorPasses:
    """Runs of one engine's links under a motor.

    Parameters
    ----------
    run : MotorRun
        The rigid linkage's.
    """

    run: MotorRun
    _known: _Known | None = field(default=None, repr=False)

    def trajectory(
        self,
        march: Callable[[MotorRun, ShaftTorque], Trajectory],
        until: float,
        step: float,
    ) -> Trajectory:
        """The run at which the motor's torque is that along its motion.

        Parameters
        ----------
        march : callable
            Runs the links with frames that turn as a drive says, under a torque.
        until : float
            Time in s until which the run goes.
        step : float
            In s.

        Returns
        -------
        Trajectory
            Whose shaft's rotation is against the rigid linkage's motion.

        Raises
        ------
        ComputationError
            If the passes do not converge, or a run fails.
        """
        time = step * np.arange(int(np.ceil(until / step)) + 4, dtype=float)
        known = self._start(time)
        for number in range(_MOST_PASSES):
            torque = self._torque(known)
            found = march(known.nominal, torque)
            moved = _Known(known.nominal, *torque.history)
            given = self._given(moved)[0]
            applied = torque.beside(moved.time, moved.across, moved.turning)
            gap = float(np.abs(given - applied).max() / np.abs(given).max())
            logger.info("motor: pass %d, torque off by %.1e", number + 1, gap)
            self._known = moved
            if gap <= _CONVERGED:
                return self._against_rigid(found, known.nominal)
            if self.run.equation.motor.state_count and gap > _WORTH:
                moved = self._yielded(moved, applied)
            # At the steps that were run: beyond them nothing is known that would be smooth.
            known = _followed(moved)
        raise ComputationError(
            f"the run under the motor does not converge: after {_MOST_PASSES} passes its torque "
            f"is still off by {100 * gap:.3g} %; run fewer revolutions, give the motor or the "
            "shaft more inertia, or take the exudyn engine"
        )

    def _start(self, time: FloatArray) -> _Known:
        if self._known is not None:
            return self._known.at(time)
        return _Known(self.run, time, *np.zeros((4, len(time))))

    def _given(self, known: _Known) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Torque on the crank along a motion, and its damping and stiffness."""
        motor = self.run.equation.motor
        speed = known.nominal.crank_speed(known.time) + known.rate
        state = states_along(motor, known.time, speed, self.run.values[2:, 0])
        torque = motor.motor.gear_ratio * motor.output(speed, state).torque
        return torque, *answer_along(motor, speed, state)

    def _yielded(self, known: _Known, applied: FloatArray) -> _Known:
        """A motion nearer to that under the motor, by the rigid linkage and the motor's states."""
        equation, nominal = self.run.equation, known.nominal
        angle = nominal.crank_angle(known.time) + known.rotation
        speed = nominal.crank_speed(known.time) + known.rate
        inertia = equation.inertia(angle)
        start = self.run.values[2:, 0]
        turned, faster = yielded_along(equation.motor, known.time, speed, applied, inertia, start)
        rotation, rate = known.rotation + turned, known.rate + faster
        return replace(
            known,
            across=known.across + turned,
            turning=known.turning + faster,
            rotation=rotation,
            rate=rate,
        )

    def _torque(self, known: _Known) -> ShaftTorque:
        return ShaftTorque(known.time, *self._given(known), known.across, known.turning)

    def _against_rigid(self, found: Trajectory, nominal: MotorRun) -> Trajectory:
        if nominal is self.run or found.shaft is None:
            return found
        time, shaft = found.time, found.shaft
        rotation = nominal.crank_angle(time) - self.run.crank_angle(time)
        rate = nominal.crank_speed(time) - self.run.crank_speed(time)
        turned = replace(shaft, rotation=shaft.rotation + rotation, rate=shaft.rate + rate)
        return replace(found, shaft=turned)


def _followed(known: _Known) -> _Known:
    """The same motion with frames that follow the smooth part of a shaft that is far off."""
    if np.abs(known.rotation).max() <= _FAR:
        return known
    from scipy.interpolate import BSpline, CubicSpline

    time, nominal = known.time, known.nominal
    turns = abs(float(np.ptp(nominal.crank_angle(time)))) / (2 * np.pi)
    count = max(2, min(int(np.ceil(_PIECES_OF_A_TURN * turns)), len(time) // (4 * _DEGREE)))
    inner = np.linspace(time[0], time[-1], count + 1)
    knots = np.concatenate([[time[0]] * _DEGREE, inner, [time[-1]] * _DEGREE])
    # Without the first three: value, speed and acceleration stay zero at the start.
    basis = BSpline.design_matrix(time, knots, _DEGREE).toarray()[:, 3:]
    weights = np.linalg.lstsq(basis, known.rotation)[0]
    smooth = BSpline(knots, np.concatenate([np.zeros(3), weights]), _DEGREE)
    some = np.union1d(nominal.time[nominal.time <= time[-1]], inner)
    law = (nominal.crank_angle(some), nominal.crank_speed(some), nominal.crank_acceleration(some))
    jerk = CubicSpline(some, law[2])(some, 1)
    moved = [own + smooth(some, nu=order) for order, own in enumerate((*law, jerk))]
    followed = replace(
        nominal,
        time=some,
        values=np.stack(moved[:2]),
        rates=np.stack(moved[1:3]),
        second_rates=np.stack(moved[2:4]),
    )
    rotation, rate = known.rotation - smooth(time), known.rate - smooth(time, nu=1)
    return _Known(followed, time, np.sin(rotation), np.cos(rotation) * rate, rotation, rate)
