"""The planar four-bar linkage: assembly, velocities, accelerations, transmission angle."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import ROUND_OFF, SAME_PLACE, FloatArray
from flexmech.errors import AssemblyError, InputError, LockingError
from flexmech.linkages.change_points import ChangePoints, passing
from flexmech.linkages.fourbar_motion import FourBarDimensions
from flexmech.linkages.motion import LOCKING_SINE, RigidMotion, checked_drive
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Topology
from flexmech.model_text import TomlTable, quantity
from flexmech.units import LENGTH
from flexmech.validation import POSITIVE, check_choice, check_number, checked_array, checked_tuple

Branch = Literal["open", "crossed"]
GrashofClass = Literal[
    "crank-rocker", "rocker-crank", "double-crank", "double-rocker", "change-point", "triple-rocker"
]


@dataclass(frozen=True)
class FourBar:
    """Ground pivots O2 = (0, 0) and O4 = (ground, 0), crank O2-A, coupler A-B, rocker O4-B.

    Parameters
    ----------
    ground, crank, coupler, rocker : float
        Link lengths r1, r2, r3, r4 in m.
    branch : {"open", "crossed"}
        "open" has B to the left of the line from A to O4 (above it at crank angle zero). At a
        change point the motion goes on smoothly, to the other side of that line; if one is at
        crank angle zero, the side is that of crank angles above it.
    sprung : tuple of str
        Of the joints A, B and O4, those with springs in place of a rigid bearing. A
        mechanism names those with a radial stiffness by itself.

    Raises
    ------
    InputError
        If a length is not a positive number, the branch is unknown, or the four lengths
        cannot close at any crank angle.

    Examples
    --------
    >>> linkage = flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
    >>> linkage.grashof_class
    'crank-rocker'
    >>> np.degrees(linkage.transmission_angle([0, np.pi])).round(2)
    array([32.21, 81.33])
    """

    ground: float
    crank: float
    coupler: float
    rocker: float
    branch: Branch = "open"
    sprung: tuple[str, ...] = field(default=(), repr=False)

    kind: ClassVar[str] = "four-bar"

    def __post_init__(self) -> None:
        for name, length in self.lengths.items():
            check_number(length, f"length of the {name}", "m", POSITIVE)
        check_choice(self.branch, ("open", "crossed"), "branch")
        sprung = checked_tuple(self.sprung, str, "sprung", "give names of joints, as ('A',)")
        object.__setattr__(self, "sprung", tuple(sorted(sprung)))
        unknown = set(self.sprung) - {"A", "B", "O4"}
        if unknown:
            raise InputError(f"sprung joints of a four-bar are A, B or O4, got {sorted(unknown)}")
        longest = max(self.lengths, key=lambda name: self.lengths[name])
        others = sum(self.lengths.values()) - self.lengths[longest]
        if self.lengths[longest] >= others:
            raise AssemblyError(
                f"the linkage cannot be assembled at any crank angle: the {longest} "
                f"({self.lengths[longest]:g} m) is not shorter than the other three links "
                f"together ({others:g} m); shorten it or lengthen the others"
            )

    def sprung_at(self, joints: Collection[str]) -> Self:
        """The linkage with springs in place of rigid bearings in these joints, and no others.

        Parameters
        ----------
        joints : collection of str
            Of A, B and O4.

        Raises
        ------
        InputError
            If one is no such joint.
        """
        return replace(self, sprung=tuple(joints))

    @property
    def lengths(self) -> dict[str, float]:
        """Link lengths in m by name."""
        return {
            "ground": self.ground,
            "crank": self.crank,
            "coupler": self.coupler,
            "rocker": self.rocker,
        }

    @cached_property
    def topology(self) -> Topology:
        """Crank clamped to the shaft at O2; pins A and B; rocker pivoted at O4."""
        return Topology(
            links=(
                Link("crank", self.crank),
                Link("coupler", self.coupler),
                Link("rocker", self.rocker),
            ),
            clamps=(Clamp("O2", LinkEnd("crank", "start")),),
            pivots=(Pivot("O4", LinkEnd("rocker", "start"), "O4" in self.sprung),),
            pins=(
                Pin("A", LinkEnd("crank", "end"), LinkEnd("coupler", "start"), "A" in self.sprung),
                Pin("B", LinkEnd("coupler", "end"), LinkEnd("rocker", "end"), "B" in self.sprung),
            ),
        )

    @property
    def grashof_class(self) -> GrashofClass:
        """Kind of motion by Grashof's criterion, named input link first."""
        ordered = sorted(self.lengths.values())
        excess = ordered[0] + ordered[3] - ordered[1] - ordered[2]
        if abs(excess) <= SAME_PLACE * sum(ordered):
            return "change-point"
        if excess > 0:
            return "triple-rocker"
        shortest = min(self.lengths, key=lambda name: self.lengths[name])
        kinds: dict[str, GrashofClass] = {
            "ground": "double-crank",
            "crank": "crank-rocker",
            "coupler": "double-rocker",
            "rocker": "rocker-crank",
        }
        return kinds[shortest]

    @cached_property
    def change_points(self) -> ChangePoints:
        """Crank angles at which coupler and rocker change sides; none if they stay on one side.

        A linkage with a change point at 0 and at 180 degrees, such as a parallelogram, returns
        after a turn; a kite whose crank is as long as its ground after two.
        """
        tolerance = SAME_PLACE * sum(self.lengths.values())
        stretched = abs(self.ground + self.crank - self.coupler - self.rocker) <= tolerance
        folded = abs(abs(self.ground - self.crank) - abs(self.coupler - self.rocker)) <= tolerance
        if folded:
            at = [0.0, np.pi] if stretched else [0.0]
            return ChangePoints(np.pi / 2 if stretched else np.pi, np.array(at))
        return ChangePoints(0.0, np.array([np.pi] if stretched else []))

    @property
    def change_angles(self) -> FloatArray:
        """Crank angles in rad of the change points; (P,)."""
        return self.change_points.angles

    @property
    def crank_turns_fully(self) -> bool:
        """Whether the crank can make a full turn without locking."""
        return self.grashof_class in ("crank-rocker", "double-crank")

    def transmission_angle(self, crank_angle: ArrayLike) -> FloatArray:
        """Angle between coupler and rocker at B in rad, between 0 and pi.

        Elamy et al. 2023, eq. 1.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled.
        """
        cosine = self._transmission_cosine(checked_array(crank_angle, "crank_angle", "rad"))
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def _transmission_cosine(self, theta: FloatArray) -> FloatArray:
        cosine = self.dimensions.cosine_at_b(np.cos(theta))
        self._refuse_gaps(theta, cosine)
        return cosine

    def reversed_transmission_angle(self, crank_angle: ArrayLike) -> FloatArray:
        """Angle between coupler and crank at A in rad, between 0 and pi.

        It is the transmission angle while the rocker drives the crank, which Elamy et al. 2023,
        section 2.1, want to be looked at where a cycle drives both ways.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        theta2 = checked_array(crank_angle, "crank_angle", "rad")
        self._refuse_locking(theta2)
        theta3, _ = self._dimensions_at(theta2).follower_angles(theta2)
        turned = theta3 - theta2
        return np.asarray(np.arctan2(np.abs(np.sin(turned)), -np.cos(turned)))

    def transmission_angle_limits(self) -> tuple[float, float]:
        """Least and greatest transmission angle in rad over the crank's range of motion.

        Elamy et al. 2023, eqs. 2 and 3, where the crank passes 0 and 180 degrees; a limit
        position of the crank gives 0 or pi instead.
        """
        cosines = self.dimensions.cosine_at_b(np.array([1.0, -1.0]))
        least, greatest = np.arccos(np.clip(cosines, -1.0, 1.0)).tolist()
        return least, greatest

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of crank, coupler and rocker.

        See :meth:`flexmech.linkages.fourbar_motion.FourBarDimensions.motion`.

        Parameters
        ----------
        crank_angle, crank_speed, crank_acceleration : array_like
            Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

        Returns
        -------
        RigidMotion
            With three links.

        Raises
        ------
        InputError
            Where the linkage cannot be assembled, locks or meets a change point; the
            message names the crank angle.
        """
        theta2, omega2, alpha2 = checked_drive(crank_angle, crank_speed, crank_acceleration)
        self._refuse_locking(theta2)
        return self._dimensions_at(theta2).motion(theta2, omega2, alpha2)

    def _dimensions_at(self, theta: FloatArray) -> FourBarDimensions:
        """Lengths and side at crank angles (...)."""
        sides = self.dimensions.side * self.change_points.sides(theta)
        return replace(self.dimensions, side=sides)

    @property
    def dimensions(self) -> FourBarDimensions:
        """Lengths and branch as numbers; the side is that between the first change points."""
        side = 1.0 if self.branch == "open" else -1.0
        return FourBarDimensions(self.ground, self.crank, self.coupler, self.rocker, side)

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> FourBar:
        """Four-bar with other lengths of crank, coupler and rocker, and a larger ground.

        Parameters
        ----------
        lengths : mapping of str to float
            New length in m of each link.
        ground_growth : float
            New over old distance of the ground pivots.

        Returns
        -------
        FourBar
        """
        ground = self.ground * ground_growth
        crank, coupler, rocker = (lengths[link.name] for link in self.topology.links)
        return replace(self, ground=ground, crank=crank, coupler=coupler, rocker=rocker)

    def described(self) -> list[str]:
        """Kind, lengths, Grashof class and range of the transmission angle, a line each."""
        lengths = ", ".join(f"{name} {size * 1e3:.6g} mm" for name, size in self.lengths.items())
        least, greatest = np.degrees(self.transmission_angle_limits())
        turns = "turns fully" if self.crank_turns_fully else "does not turn fully"
        at = f"{passing(self.change_angles)}, and" if self.change_angles.size else "the crank"
        return [
            f"kind: four-bar, {self.branch} branch",
            f"lengths: {lengths}",
            f"Grashof class: {self.grashof_class}; {at} {turns}",
            f"transmission angle: {least:.4g} to {greatest:.4g} deg",
        ]

    def to_table(self) -> TomlTable:
        """Table ``[linkage]`` of a model file."""
        lengths = {name: quantity(length, LENGTH) for name, length in self.lengths.items()}
        return {"kind": self.kind, **lengths, "branch": self.branch}

    def _refuse_gaps(self, theta: FloatArray, cosine: FloatArray) -> None:
        gaps = ~(np.abs(cosine) <= 1.0 + ROUND_OFF)
        if np.any(gaps):
            angle = _degrees(theta[gaps].flat[0])
            raise AssemblyError(
                f"the linkage cannot be assembled at crank angle {angle:g} deg: coupler and "
                f"rocker do not meet there ({self.grashof_class}); choose crank angles inside "
                "its range of motion or other link lengths"
            )

    def _refuse_locking(self, theta: FloatArray) -> None:
        self.change_points.refuse(theta, "all links come into one line")
        locked = 1 - self._transmission_cosine(theta) ** 2 < LOCKING_SINE**2
        if np.any(locked):
            angle = _degrees(theta[locked].flat[0])
            raise LockingError(
                f"the linkage locks at crank angle {angle:g} deg: coupler and rocker are in "
                "one line (transmission angle 0 or 180 deg) and the crank cannot drive it "
                "through; leave that crank angle out or change the link lengths"
            )


def _degrees(angle: float) -> float:
    return float(np.round(np.degrees(angle), 9))
