"""Initial states, impacts and shaft motion of runs in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

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
