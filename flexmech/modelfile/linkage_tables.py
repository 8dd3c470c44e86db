"""Tables of a model file for the linkage, one class for each kind, and for the frame on springs."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from flexmech import si
from flexmech.linkages import CouplerPoint, FourBar, RotatingArm
from flexmech.mechanism import FrameSpring, SprungFrame
from flexmech.modelfile import base_table as base


class CouplerPointTable(base.RecordTable, of=CouplerPoint):
    """A point that moves with the coupler."""


class MountedTable(base.Table):
    """What a linkage is mounted to."""

    ground_thermal_expansion: si.Expansion = base.optional(
        "Thermal expansion of the frame between the ground pivots, or of the hub; 0 if left out",
        0.0,
        "0 1/K",
    )


class FourBarTable(MountedTable, base.RecordTable, of=FourBar):
    """Ground pivots O2 and O4, crank O2-A, coupler A-B, rocker O4-B."""

    kind: Literal["four-bar"]
    coupler_point: CouplerPointTable | None = base.optional(
        "Point of the coupler whose path matters"
    )


class RotatingArmTable(MountedTable, base.RecordTable, of=RotatingArm):
    """One link clamped to a hub that turns about O2."""

    kind: Literal["rotating-arm"]


class PlanarTable(MountedTable):
    """Any planar linkage, drawn once; its links name their points, joints say what points do."""

    kind: Literal["planar"]
    drawn_at: si.AngleOfTurn | None = base.optional(
        "Crank angle of the drawing; the angle of the crank's first beam if left out"
    )
    ground: list[base.Text] = Field(description="Names of the points that do not move")
    points: dict[str, tuple[si.Distance, si.Distance]] = Field(
        description="Coordinates x and y of each point, by its name, at the crank angle drawn_at; "
        "points that lengths of links place are left out"
    )
    near: dict[str, tuple[si.Distance, si.Distance]] = Field(
        default_factory=dict,
        description="Rough coordinates of points that lengths place in two ways: the nearer one is "
        "taken; left out, the upper one, of equally high ones the right one",
    )


LinkageTable = Annotated[FourBarTable | RotatingArmTable | PlanarTable, Field(discriminator="kind")]


class FrameSpringTable(base.RecordTable, of=FrameSpring):
    """A spring between the frame and the floor, with a damper beside it."""


class FrameTable(base.RecordTable, of=SprungFrame):
    """The rigid frame that carries the linkage, on springs."""

    springs: list[FrameSpringTable] = Field(description="Between the frame and the floor")
