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
from flexmech.linkages import MotorRun
from flexmech.linkages.motors.integrated_run import states_along, yielded_along
from flexmech.linkages.motors.motor import DriveTrain
from flexmech.mechanics.running import RotorCoupling, ShaftTorque, Trajectory

logger = logging.getLogger(__name__)

# Part of the greatest torque by which a run's may be off the motor's along its motion.
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
class KnownMotion:
    """The motion that is known: of the frames, and how shaft and rotor leave these.

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
    rotor, rotor_rate : ndarray, shape (m,)
        Of what the motor turns, the same: of the rotor on its coupling, or of the shaft.
    """

    nominal: MotorRun
    time: FloatArray
    across: FloatArray
    turning: FloatArray
    rotation: FloatArray
    rate: FloatArray
    rotor: FloatArray
    rotor_rate: FloatArray

    @classmethod
    def recorded(cls, nominal: MotorRun, torque: ShaftTorque) -> KnownMotion:
        """What a run has recorded.

        Parameters
        ----------
        nominal : MotorRun
        torque : ShaftTorque
            That acted.

        Returns
        -------
        KnownMotion
        """
        time, *own = torque.history
        return cls(nominal, time, *(own if torque.coupling is not None else [*own, *own[2:]]))

    @property
    def rotor_angle(self) -> FloatArray:
        """Angle of what the motor turns at the crank, in rad, (m,)."""
        return np.asarray(self.nominal.crank_angle(self.time) + self.rotor)

    @property
    def rotor_speed(self) -> FloatArray:
        """Its speed in rad/s, (m,)."""
        return np.asarray(self.nominal.crank_speed(self.time) + self.rotor_rate)

    def at(self, time: FloatArray) -> KnownMotion:
        """The same at other times; the last values stay beyond the last of its own."""
        from scipy.interpolate import CubicSpline

        inside = np.clip(time, self.time[0], self.time[-1])
        moved = (CubicSpline(self.time, own)(inside) for own in self._motion)
        return KnownMotion(self.nominal, time, *moved)

    def turned(self, angle: FloatArray, speed: FloatArray) -> KnownMotion:
        """Shaft and rotor farther by angles (m,) in rad, which turn at speeds (m,) in rad/s."""
        moved = (own + by for own, by in zip(self._motion, [angle, speed] * 3, strict=True))
        return KnownMotion(self.nominal, self.time, *moved)

    @property
    def _motion(self) -> tuple[FloatArray, ...]:
        of_shaft = self.across, self.turning, self.rotation, self.rate
        return *of_shaft, self.rotor, self.rotor_rate


@dataclass
class MotorPasses:
    """Runs of one engine's links under a motor.

    Parameters
    ----------
    run : MotorRun
        The rigid linkage's.
    """

    run: MotorRun
    _known: KnownMotion | None = field(default=None, repr=False)

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
            moved = KnownMotion.recorded(known.nominal, torque)
            given, applied = self._given(moved)[0], self._applied(torque, moved)
            gap = float(np.abs(given - applied).max() / np.abs(given).max())
            logger.info("motor: pass %d, torque off by %.1e", number + 1, gap)
            self._known = moved
            if max(gap, self._coupling_gap(torque, moved)) <= _CONVERGED:
                return self._against_rigid(found, known.nominal)
            if self._train.state_count and gap > _WORTH:
                moved = self._yielded(moved, applied)
            # At the steps that were run: beyond them nothing is known that would be smooth.
            known = _followed(moved)
        raise ComputationError(
            f"the run under the motor does not converge: after {_MOST_PASSES} passes its torque "
            f"is still off by {100 * gap:.3g} %; run fewer revolutions, give the motor or the "
            "shaft more inertia, or take the exudyn engine"
        )

    def torque_along(self, time: FloatArray) -> ShaftTorque:
        """The motor's torque along the rigid linkage's motion, at times (m,) in s."""
        return self._torque(self._start(time))

    @property
    def _train(self) -> DriveTrain:
        """What turns the rotor: the motor and its gear."""
        return self.run.equation.train.without_coupling

    @property
    def _start_states(self) -> FloatArray:
        """Start states of the motor at time zero."""
        return self.run.states(0.0)[self.run.equation.train.motor_place :]

    def _start(self, time: FloatArray) -> KnownMotion:
        if self._known is not None:
            return self._known.at(time)
        still, train = np.zeros_like(time), self.run.equation.train
        rotor = still, still
        if train.is_coupled:
            turned, turning = self.run.states(time)[:2]
            rotor = turned - self.run.crank_angle(time), turning - self.run.crank_speed(time)
        return KnownMotion(self.run, time, still, still, still, still, *rotor)

    def _given(self, known: KnownMotion) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Torque of the motor at the crank along a motion, and its damping and stiffness."""
        train, speed = self._train, known.rotor_speed
        states = states_along(train, known.time, known.rotor_angle, speed, self._start_states)
        torque = train.on_crank(known.rotor_angle, speed, states)[0]
        return torque, *train.answer(speed, states)

    def _applied(self, torque: ShaftTorque, moved: KnownMotion) -> FloatArray:
        """The motor's torque that acted in a run."""
        if torque.coupling is None:
            return torque.beside(moved.time, moved.across, moved.turning)
        return torque.beside(moved.time, moved.rotor, moved.rotor_rate)

    def _coupling_gap(self, torque: ShaftTorque, moved: KnownMotion) -> float:
        """How far the coupling's torque is off that which turned with the shaft."""
        coupling, now = torque.coupling, self._coupling(moved)
        if coupling is None or now is None:
            return 0.0
        known = np.interp(moved.time, torque.time, coupling.torque)
        # It counts as far as the shaft leaves the frames.
        far = float(np.abs(moved.rotation).max())
        return far * float(np.abs(now.torque - known).max() / np.abs(now.torque).max())

    def _yielded(self, known: KnownMotion, applied: FloatArray) -> KnownMotion:
        """A motion nearer to that under the motor, by the rigid linkage and the motor's states."""
        angle, speed = known.rotor_angle, known.rotor_speed
        inertia = self.run.equation.inertia(angle)
        if self.run.equation.train.is_coupled:
            inertia = inertia + self.run.drive.motor.inertia_at_crank
        return known.turned(
            *yielded_along(
                self._train, known.time, angle, speed, applied, inertia, self._start_states
            )
        )

    def _torque(self, known: KnownMotion) -> ShaftTorque:
        coupling = self._coupling(known)
        driven = known.across, known.turning
        if coupling is not None:
            driven = known.rotor, known.rotor_rate
        motor = self.run.drive.motor
        return ShaftTorque(known.time, *self._given(known), *driven, motor, coupling)

    def _coupling(self, known: KnownMotion) -> RotorCoupling | None:
        """The coupling with its torque along a motion; None of a rotor without one."""
        motor, begin = self.run.drive.motor, self.run.values[:, 0]
        if motor.coupling_stiffness is None:
            return None
        start = float(begin[2] - begin[0]), float(begin[3] - begin[1])
        torque = motor.coupling_torque(known.rotor - known.rotation, known.rotor_rate - known.rate)
        lag = motor.coupling_torque(known.across - known.rotation, known.turning - known.rate)
        return RotorCoupling(start, torque, lag)

    def _against_rigid(self, found: Trajectory, nominal: MotorRun) -> Trajectory:
        if nominal is self.run or found.shaft is None:
            return found
        time, shaft = found.time, found.shaft
        rotation = nominal.crank_angle(time) - self.run.crank_angle(time)
        rate = nominal.crank_speed(time) - self.run.crank_speed(time)
        turned = replace(shaft, rotation=shaft.rotation + rotation, rate=shaft.rate + rate)
        return replace(found, shaft=turned)


def _followed(known: KnownMotion) -> KnownMotion:
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
    rotor = known.rotor - smooth(time), known.rotor_rate - smooth(time, nu=1)
    return KnownMotion(
        followed, time, np.sin(rotation), np.cos(rotation) * rate, rotation, rate, *rotor
    )
