"""Tables of a model file that describe linkages: one class for each kind.

Table of a model file for the frame of the machine on its springs.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from flexmech.linkages import CouplerPoint, FourBar, RotatingArm
from flexmech.mechanism import FrameSpring, SprungFrame
from flexmech.modelfile import base_table as base


class CouplerPointTable(base.Table):
    """A point that moves with the coupler."""

    distance: base.LengthOrZero = Field(description="Distance e from A")
    angle: base.Angle = Field(
        description="Angle gamma at A from the line A-B to the point, to the left positive"
    )


class MountedTable(base.Table):
    """What a linkage is mounted to."""

    ground_thermal_expansion: base.Expansion = base.optional(
        "Of the frame between the ground pivots, or of the hub; 0 if left out", 0.0, "0 1/K"
    )

    @property
    def point(self) -> CouplerPoint | None:
        """Point of the coupler whose path matters."""
        return None


class FourBarTable(MountedTable):
    """Ground pivots O2 and O4, crank O2-A, coupler A-B, rocker O4-B."""

    kind: Literal["four-bar"]
    ground: base.Length = Field(description="Distance r1 between the ground pivots O2 and O4")
    crank: base.Length = Field(description="Crank length r2, O2 to A")
    coupler: base.Length = Field(description="Coupler length r3, A to B")
    rocker: base.Length = Field(description="Rocker length r4, O4 to B")
    branch: Literal["open", "crossed"] = base.optional(
        "'open' has B above at crank angle zero", "open"
    )
    coupler_point: CouplerPointTable | None = base.optional(
        "Point of the coupler whose path matters"
    )

    @property
    def linkage(self) -> FourBar:
        """The linkage that is described."""
        return FourBar(self.ground, self.crank, self.coupler, self.rocker, self.branch)

    @property
    def point(self) -> CouplerPoint | None:
        """Point of the coupler whose path matters."""
        point = self.coupler_point
        return None if point is None else CouplerPoint(point.distance, point.angle)


class RotatingArmTable(MountedTable):
    """One link clamped to a hub that turns about O2."""

    kind: Literal["rotating-arm"]
    length: base.Length = Field(description="Arm length, from the clamp to the free end")
    hub_radius: base.LengthOrZero = base.optional(
        "Distance from the axis to the clamp; zero if left out", 0.0, "0 m"
    )

    @property
    def linkage(self) -> RotatingArm:
        """The linkage that is described."""
        return RotatingArm(self.length, self.hub_radius)


class PlanarTable(MountedTable):
    """Any planar linkage, drawn once; its links name their points, joints say what points do."""

    kind: Literal["planar"]
    drawn_at: base.AngleOfTurn | None = base.optional(
        "Crank angle of the drawing; the angle of the crank's first beam if left out"
    )
    ground: list[base.Text] = Field(description="Names of the points that do not move")
    points: dict[str, tuple[base.Distance, base.Distance]] = Field(
        description="Coordinates x and y of each point, by its name, at the crank angle drawn_at; "
        "points that lengths of links place are left out"
    )
    near: dict[str, tuple[base.Distance, base.Distance]] = Field(
        default_factory=dict,
        description="Rough coordinates of points that lengths place in two ways: the nearer one is "
        "taken; left out, the upper one, of equally high ones the right one",
    )


LinkageTable = Annotated[FourBarTable | RotatingArmTable | PlanarTable, Field(discriminator="kind")]


class FrameSpringTable(base.Table):
    """A spring between the frame and the floor, with a damper beside it."""

    point: tuple[base.Distance, base.Distance] = Field(
        description="Of the frame, in the axes of the ground as the frame is drawn"
    )
    stiffness: tuple[base.SpringStiffness, base.SpringStiffness] = Field(
        description="Along x and y; it is without force where the frame is drawn"
    )
    damping: tuple[base.Damping, base.Damping] = base.optional(
        "Along x and y; 0 if left out", (0.0, 0.0), ["0 N s/m", "0 N s/m"]
    )


class FrameTable(base.Table):
    """The rigid frame that carries the linkage, on springs."""

    mass: base.Mass = Field(description="Without the linkage")
    inertia: base.Inertia = Field(description="About its centre of mass")
    centre: tuple[base.Distance, base.Distance] = Field(description="Its centre of mass")
    springs: list[FrameSpringTable] = Field(description="Between the frame and the floor")

    @property
    def frame(self) -> SprungFrame:
        """The frame that is stated."""
        springs = (FrameSpring(own.point, own.stiffness, own.damping) for own in self.springs)
        return SprungFrame(self.mass, self.inertia, self.centre, tuple(springs))
