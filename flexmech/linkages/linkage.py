"""Interface of all linkages; where they can be assembled, and their angles along turns."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import InputError, LockingError
from flexmech.linkages.change_points import TURN, in_degrees
from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.topology import Topology
from flexmech.model_text import TomlTable


class Linkage(Protocol):
    """A rigid linkage of one degree of freedom, driven by its crank."""

    @property
    def kind(self) -> str:
        """Its name in model files, such as ``"four-bar"``."""
        ...

    @property
    def topology(self) -> Topology:
        """Links and connections."""
        ...

    @property
    def change_angles(self) -> FloatArray:
        """Crank angles in rad of a turn at which the motion goes over to another branch; (P,).

        Smoothly, but its forces and its elastic links are not determined there.
        """
        ...

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> Self:
        """The linkage with links of other lengths, as after swelling.

        Parameters
        ----------
        lengths : mapping of str to float
            New length in m of each link of the topology.
        ground_growth : float
            New over old size of what the links are mounted to.

        Returns
        -------
        Linkage
        """
        ...

    def sprung_at(self, joints: Collection[str]) -> Self:
        """The linkage with springs in place of rigid bearings in these joints, and no others.

        Parameters
        ----------
        joints : collection of str
            Pins or pivots.

        Returns
        -------
        Linkage
        """
        ...

    def described(self) -> list[str]:
        """Description in lines: kind, lengths, range of motion."""
        ...

    def to_table(self) -> TomlTable:
        """Table ``[linkage]`` of a model file."""
        ...

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of every link.

        Parameters
        ----------
        crank_angle, crank_speed, crank_acceleration : array_like
            Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

        Returns
        -------
        RigidMotion

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks; names the crank angle.
        """
        ...


def assemblable(linkage: Linkage, crank_angles: FloatArray) -> NDArray[np.bool_]:
    """Whether a linkage can be assembled at each of some crank angles.

    Parameters
    ----------
    linkage : Linkage
    crank_angles : ndarray, shape (A,)
        In rad.

    Returns
    -------
    ndarray of bool, shape (A,)
    """
    return can_be_taken(linkage.motion, crank_angles)


def can_be_taken(move: Callable[[FloatArray], object], angles: FloatArray) -> NDArray[np.bool_]:
    """Whether each of some angles is not refused.

    Parameters
    ----------
    move : callable
        Raises InputError where one of the angles (B,) that it is given cannot be taken.
    angles : ndarray, shape (A,)

    Returns
    -------
    ndarray of bool, shape (A,)
    """
    try:
        move(angles)
    except InputError:
        if len(angles) <= 1:
            return np.zeros(len(angles), dtype=bool)
        # Halves of halves: ranges of motion are few.
        halves = np.array_split(angles, 2)
        return np.concatenate([can_be_taken(move, half) for half in halves])
    return np.ones(len(angles), dtype=bool)


def refuse_passing(linkage: Linkage, crank_angles: FloatArray) -> None:
    """Refuse a way of the crank through a change point, for links that are elastic.

    Parameters
    ----------
    linkage : Linkage
    crank_angles : ndarray, shape (A,)
        Along the way in rad; the way leads from the least to the greatest of them.

    Raises
    ------
    LockingError
        Names the first change point on it.
    """
    low, high = float(crank_angles.min()), float(crank_angles.max())
    ahead = np.mod(linkage.change_angles - low, TURN)
    if np.any(ahead <= high - low):
        at = in_degrees(low + float(ahead.min()))
        raise LockingError(
            f"the crank passes a change point at crank angle {at}: "
            "all forces that hold the links there are in one line, so that elastic links may leave "
            "it in either branch and their motion is not determined; let the crank swing on one "
            "side of it, or change the dimensions"
        )


# Steps of a turn, at which angles are followed: half a degree. No link may turn by half a turn from
# one to the next, as it would in a linkage that passes a dead point within a quarter of a degree.
STEPS = 720
# Part of a step: how far beside a change point a place stands for it.
_BESIDE = 1 / 16


def continuous_angles(linkage: Linkage, motion: RigidMotion) -> FloatArray:
    """Angles of the links without jumps of whole turns.

    A linkage gives each angle within one turn. Here every angle is unwrapped from crank angle zero,
    where it keeps its value, and continued over further turns of the crank. Where the crank does
    not turn fully, each range of crank angles is unwrapped separately, the one around zero from
    there and any other from its start; a whole turn more is the same posture.

    Parameters
    ----------
    linkage : Linkage
    motion : RigidMotion
        Motion of the linkage.

    Returns
    -------
    ndarray, shape (..., n_links)
        In rad; ``motion.angle`` but for whole turns.
    """
    around, possible = _placed_around(linkage)
    turns, places = np.divmod(np.rint(motion.crank_angle * (STEPS / TURN)).astype(int), STEPS)
    if np.all(possible):
        unwrapped = np.unwrap(linkage.motion(around).angle, axis=0)
        gained = TURN * np.round((unwrapped[-1] - unwrapped[0]) / TURN)
        near = unwrapped[places] + turns[..., None] * gained
    else:
        near = _in_ranges(linkage, around[:-1], possible[:-1], motion.angle.shape[-1])[places]
        # A range too narrow to be met by a step is its own.
        near = np.where(np.isnan(near), motion.angle, near)
    counted: FloatArray = motion.angle + TURN * np.round((near - motion.angle) / TURN)
    return counted


def _placed_around(linkage: Linkage) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Crank angles of the steps of a turn, and whether the linkage can be assembled there.

    In place of a change point an angle beside it, and in place of an angle beyond the change point
    that limits a posture the same angle of the turn before or after.
    """
    step = TURN / STEPS
    around = np.asarray(step * np.arange(STEPS + 1), dtype=float)
    possible = assemblable(linkage, around)
    if linkage.change_angles.size:
        for turn in (0.0, -TURN, TURN):
            for shift in (turn, turn + step * _BESIDE):
                placed = ~possible
                if placed.any():
                    placed[placed] = assemblable(linkage, around[placed] + shift)
                around, possible = around + shift * placed, possible | placed
    return around, possible


def _in_ranges(
    linkage: Linkage, around: FloatArray, possible: NDArray[np.bool_], links: int
) -> FloatArray:
    """Angles over a turn, followed in each range of motion; not a number elsewhere."""
    unwrapped = np.full((len(around), links), np.nan)
    # Begun where the linkage cannot be assembled, no range runs over the end.
    order = np.roll(np.arange(len(around)), -int(np.argmin(possible)))
    edges = np.flatnonzero(np.diff(possible[order].astype(int))) + 1
    for rows in np.split(order, edges):
        if possible[rows[0]]:
            angles = np.unwrap(linkage.motion(around[rows]).angle, axis=0)
            if 0 in rows:
                kept = linkage.motion(around[0]).angle
                angles = angles + TURN * np.round((kept - angles[rows == 0][0]) / TURN)
            unwrapped[rows] = angles
    # Between the last step of a range and its end.
    for shift in (1, -1):
        beside = np.roll(unwrapped, shift, axis=0)
        unwrapped = np.where(np.isnan(unwrapped) & ~np.isnan(beside), beside, unwrapped)
    return unwrapped
