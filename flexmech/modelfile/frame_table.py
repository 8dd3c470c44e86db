"""Table of a model file for the frame of the machine on its springs."""

from __future__ import annotations

from pydantic import Field

from flexmech.mechanism import FrameSpring, SprungFrame
from flexmech.modelfile import base_table as base


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
