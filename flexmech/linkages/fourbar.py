"""The planar four-bar linkage: assembly, velocities, accelerations, transmission angle."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si
from flexmech.arrays import ROUND_OFF, SAME_PLACE, FloatArray
from flexmech.errors import AssemblyError, InputError
from flexmech.linkages.body_motion import CRANK, GROUND_BODY, BodyMotion
from flexmech.linkages.change_points import ChangePoints, passing
from flexmech.linkages.motion import RigidMotion, checked_drive
from flexmech.linkages.planar.bodies import Refusal
from flexmech.linkages.planar.dyads import Circle, TwoLoci
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Topology
from flexmech.model_text import TomlTable
from flexmech.validation import check_choice, checked_array, checked_tuple

Branch = Literal["open", "crossed"]
GrashofClass = Literal[
    "crank-rocker", "rocker-crank", "double-crank", "double-rocker", "change-point", "triple-rocker"
]

# Numbers of the bodies besides ground and crank.
COUPLER, ROCKER = 2, 3


@dataclass(frozen=True)
class FourBar:
    """Ground pivots O2 = (0, 0) and O4 = (ground, 0), crank O2-A, coupler A-B, rocker O4-B.

    Parameters
    ----------
    ground : float
        Distance r1 between the ground pivots O2 and O4 in m.
    crank : float
        Crank length r2 in m, O2 to A.
    coupler : float
        Coupler length r3 in m, A to B.
    rocker : float
        Rocker length r4 in m, O4 to B.
    branch : {"open", "crossed"}
        "open" has B to the left of the line from A to O4 (above it at crank angle zero). At a
        change point the motion goes on smoothly, to the other side of that line; if one is at
        crank angle zero, the side is that of crank angles above it.
    sprung : tuple of str
        Names of the joints among A, B and O4 with springs in place of a rigid bearing. A
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

    ground: si.Length
    crank: si.Length
    coupler: si.Length
    rocker: si.Length
    branch: Branch = "open"
    sprung: tuple[str, ...] = field(default=(), repr=False)

    kind: ClassVar[str] = "four-bar"

    def __post_init__(self) -> None:
        si.check(self, "length of the {}")
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
            Joints of A, B and O4.

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
        theta = checked_array(crank_angle, "crank_angle", "rad")
        cosine = self._cosine_at_b(np.cos(theta))
        self._dyad.refusal.refuse("apart", ~(np.abs(cosine) <= 1.0 + ROUND_OFF), theta)
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def _cosine_at_b(self, crank_cosine: FloatArray) -> FloatArray:
        """Cosine of the angle at B, by the cosine rule, from that of the crank angle (...)."""
        sides = self.coupler**2 + self.rocker**2 - self.ground**2 - self.crank**2
        opposite = 2 * self.ground * self.crank * crank_cosine
        return np.asarray((sides + opposite) / (2 * self.coupler * self.rocker))

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
        crank, coupler, _ = np.moveaxis(self.motion(crank_angle).angle, -1, 0)
        turned = coupler - crank
        return np.asarray(np.arctan2(np.abs(np.sin(turned)), -np.cos(turned)))

    def transmission_angle_limits(self) -> tuple[float, float]:
        """Least and greatest transmission angle in rad over the crank's range of motion.

        Elamy et al. 2023, eqs. 2 and 3, where the crank passes 0 and 180 degrees; a limit
        position of the crank gives 0 or pi instead.
        """
        cosines = self._cosine_at_b(np.array([1.0, -1.0]))
        least, greatest = np.arccos(np.clip(cosines, -1.0, 1.0)).tolist()
        return least, greatest

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of crank, coupler and rocker.

        Coupler and rocker are a dyad on the crank and the ground. Its derivatives are those of
        Kumar & Chandrakar, eqs. 1.22, 1.23 (angular velocities), 1.35 and 1.36 (angular
        accelerations, corrected: the alpha2 term of 1.36 has sin(theta2 - theta3)).

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
        crank = checked_drive(crank_angle, crank_speed, crank_acceleration)
        theta = np.ravel(crank[0])
        self.change_points.refuse(theta, "all links come into one line")
        bodies = BodyMotion.cranked(np.zeros(4, dtype=complex), theta)
        self._dyad.move(bodies, theta, self.change_points.sides(theta))
        to_o4 = self.ground - bodies.place[:, COUPLER]
        coupler, rocker = bodies.turn[:, COUPLER], bodies.turn[:, ROCKER]
        # The coupler's angle is counted from the line A-O4.
        angles = theta, np.angle(to_o4) + np.angle(coupler * np.conj(to_o4)), np.angle(rocker)
        links = slice(CRANK, ROCKER + 1)
        return bodies.driven_motion(links, bodies.drawn[links], np.stack(angles, axis=-1), crank)

    @cached_property
    def _dyad(self) -> TwoLoci:
        """Coupler and rocker, on circles about A and O4 that meet in B."""
        names = f"coupler and rocker ({self.grashof_class})"
        about_a = Circle(CRANK, complex(self.crank), COUPLER, 0j, complex(self.coupler))
        about_o4 = Circle(GROUND_BODY, complex(self.ground), ROCKER, 0j, complex(self.rocker))
        side = 1.0 if self.branch == "open" else -1.0
        size = sum(self.lengths.values())
        return TwoLoci(Refusal("B", names, 0.0), about_a, about_o4, size, side)

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
        return {"kind": self.kind, **si.table(self), "branch": self.branch}
