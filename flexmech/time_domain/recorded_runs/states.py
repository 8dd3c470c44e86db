"""Initial states, impacts and shaft motion of runs in time, and their histories at samples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import LINK_DIRECTIONS, LinkDirection
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.errors import ComputationError
from flexmech.linear_system import LinkModel, LinkPoint
from flexmech.linkages import Drive
from flexmech.mechanism import Mechanism
from flexmech.validation import check_choice, check_instance

# A shaft that is ahead or behind by more than this, in rad, no longer turns the linkage through
# the positions for which its torque is made.
RUN_AWAY = np.pi / 2
# Positions whose inverse dynamics are in memory at a time. Memory alone: some kB each.
BATCH = 4096


@dataclass(frozen=True)
class FrameMotion:
    """Motion of a frame on springs at m instants.

    Parameters
    ----------
    displacement : ndarray, shape (m, 3)
        Of its centre of mass along x and y in m, and its rotation in rad.
    rate : ndarray, shape (m, 3)
        Its time derivative.
    """

    displacement: FloatArray
    rate: FloatArray


@dataclass(frozen=True)
class LinkState:
    """Elastic state of all links at an instant, in the frames of their rigid motion.

    Parameters
    ----------
    displacement, rate : list of ndarray, shape (n_link,)
        Each link's coordinates less those of the undeformed link, and their time
        derivatives in that frame.
    frame : FrameMotion, optional
        Of a frame on springs, arrays of shape (1, 3); it stands as it is drawn if left out.
    """

    displacement: list[FloatArray]
    rate: list[FloatArray]
    frame: FrameMotion | None = None

    @property
    def moved(self) -> FrameMotion:
        """Motion of the frame at the instant."""
        return self.frame or FrameMotion(np.zeros((1, 3)), np.zeros((1, 3)))

    @classmethod
    def rigid(cls, links: Sequence[LinkModel]) -> Self:
        """Undeformed links that move with the velocities of the rigid motion."""
        return cls([np.zeros(link.size) for link in links], [np.zeros(link.size) for link in links])


@dataclass(frozen=True)
class Impact:
    """A pulse on a point of a link, in the axes of the link's rigid frame.

    Parameters
    ----------
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across the link's frame or along it; the force turns with the frame.
    pulse : HalfSinePulse

    Raises
    ------
    InputError
        If one is no such thing.
    """

    point: LinkPoint
    direction: LinkDirection
    pulse: HalfSinePulse

    def __post_init__(self) -> None:
        check_instance(self.point, LinkPoint, "point of an impact", "give a flexmech.LinkPoint")
        check_choice(self.direction, LINK_DIRECTIONS, "direction of an impact")
        check_instance(self.pulse, HalfSinePulse, "pulse of an impact", "give a HalfSinePulse")


@dataclass(frozen=True)
class ShaftMotion:
    """Rotation of a free shaft against its prescribed angle at m instants.

    Parameters
    ----------
    rotation : ndarray, shape (m,)
        In rad, positive ahead.
    rate : ndarray, shape (m,)
        Its time derivative in rad/s: by how much the crank speed is off the prescribed one.
    """

    rotation: FloatArray
    rate: FloatArray

    def refuse_runaway(self, drive: Drive, time: FloatArray) -> None:
        """Refuse a shaft that has left its prescribed angle.

        Parameters
        ----------
        drive : Drive
        time : ndarray, shape (m,)
            Of the instants, in s.

        Raises
        ------
        ComputationError
            Names the time and the crank angle.
        """
        away = ~(np.abs(self.rotation) <= RUN_AWAY)
        if not away.any():
            return
        first = int(np.argmax(away))
        at = float(time[first])
        side = "behind" if self.rotation[first] < 0 else "ahead of"
        raise ComputationError(
            f"the free shaft runs away: at time {at:.6g} s it is more than "
            f"{np.degrees(RUN_AWAY):.0f} deg {side} its prescribed crank angle, "
            f"{np.degrees(float(drive.crank_angle(at))):.6g} deg, and the torque that drives the "
            "rigid linkage at the prescribed motion no longer fits where it stands; run fewer "
            "revolutions, give the shaft more inertia, lower the crank speed, or use shaft "
            "'prescribed'"
        )


def rigid_torque(mechanism: Mechanism, drive: Drive, time: FloatArray) -> FloatArray:
    """Torque on the shaft for the prescribed motion of the rigid linkage and the shaft.

    Inverse dynamics under everything that acts on the linkage, and the shaft's own inertia times
    its acceleration in a run-up.

    Parameters
    ----------
    mechanism : Mechanism
    drive : Drive
    time : ndarray, shape (m,)
        In s.

    Returns
    -------
    ndarray, shape (m,)
        In N m.

    Raises
    ------
    InputError
        If the connections do not determine the forces, or a spring has no direction.
    """
    torque = np.empty(len(time))
    for first in range(0, len(time), BATCH):
        some = time[first : first + BATCH]
        motion = drive.motion(mechanism.linkage, some)
        torque[first : first + BATCH] = mechanism.inverse_dynamics(motion, some).driving_torque
    return torque + mechanism.shaft_inertia * drive.crank_acceleration(time)


@dataclass(frozen=True)
class EnergyHistory:
    """Energies at the samples in J, each of shape (N,).

    Parameters
    ----------
    kinetic, strain, gravity : ndarray, shape (N,)
    dissipated, drive_work, prestress_work : ndarray, shape (N,)
        Since the start of the run.
    """

    kinetic: FloatArray
    strain: FloatArray
    gravity: FloatArray
    dissipated: FloatArray
    drive_work: FloatArray
    prestress_work: FloatArray

    @property
    def imbalance(self) -> FloatArray:
        """Energy that nothing accounts for, (N,)."""
        stored = self.kinetic + self.strain + self.gravity
        work = self.drive_work - self.dissipated + self.prestress_work
        return np.asarray(stored - stored[0] - work)


# What a run has at each sample.
HISTORIES = (
    "time",
    "displacement",
    "rate",
    "joint_force",
    "driving_torque",
    "energy",
    "shaft",
    "frame",
)


@dataclass(frozen=True)
class Trajectory:
    """A run of the linkage at N samples.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    displacement, rate : list of ndarray, shape (N, n_link)
        As in :class:`flexmech.time_domain.StepBlock`.
    joint_force : ndarray, shape (N, n_joints, 2)
    driving_torque : ndarray, shape (N,)
        Both as far as the band of the recorder lets them through.
    peak_joint_force : ndarray, shape (n_joints,)
    peak_driving_torque : float
        Greatest size of these at any step.
    energy : EnergyHistory
    energy_error : float
        Greatest ``|work of drive and changing prestress - change of kinetic, strain and gravity
        energy - dissipated|`` over all steps, relative to the peak kinetic energy.
    step : float
        Time step in s.
    shaft : ShaftMotion, optional
        Of a shaft that is free.
    frame : FrameMotion, optional
        Of a frame on springs.
    """

    time: FloatArray
    displacement: list[FloatArray]
    rate: list[FloatArray]
    joint_force: FloatArray
    driving_torque: FloatArray
    peak_joint_force: FloatArray
    peak_driving_torque: float
    energy: EnergyHistory
    energy_error: float
    step: float
    shaft: ShaftMotion | None = None
    frame: FrameMotion | None = None

    def __getitem__(self, where: slice) -> Trajectory:
        """The same run at some of the samples."""
        taken = {name: _changed(lambda x: x[where], getattr(self, name)) for name in HISTORIES}
        return replace(self, **taken)

    def extrapolated(self, coarser: Trajectory, order: int) -> Trajectory:
        """Limit of vanishing steps, by a run with greater ones (Richardson).

        Parameters
        ----------
        coarser : Trajectory
            At the same samples.
        order : int
            Of the method's error.

        Returns
        -------
        Trajectory
            With this run's step. Its energies balance as they do at the samples.
        """
        gain = 1 / ((coarser.step / self.step) ** order - 1)
        limit: Trajectory = _changed(lambda x, y: x + gain * (x - y), self, coarser)
        energy = limit.energy
        error = float(np.abs(energy.imbalance).max() / energy.kinetic.max())
        return replace(limit, energy_error=error, step=self.step)


def _changed(function: Callable[..., Any], *values: Any) -> Any:
    """What a function makes of every array and number of like records and lists; None of none."""
    first: Any = values[0]
    if isinstance(first, list):
        return [_changed(function, *items) for items in zip(*values, strict=True)]
    if is_dataclass(first) and not isinstance(first, type):
        names = [field.name for field in fields(first)]
        changed = (_changed(function, *(getattr(x, name) for x in values)) for name in names)
        return type(first)(*changed)
    return None if first is None else function(*values)
