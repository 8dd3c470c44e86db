"""The frame on springs in a running Exudyn system: a rigid body under the linkage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.mechanism import Mechanism, SprungFrame
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.running.user_functions import JoinedEnd
from flexmech.time_domain import FrameMotion, StepBlock


@dataclass(frozen=True)
class FrameBody:
    """Rigid body of a frame, with its springs and its weight.

    Parameters
    ----------
    frame : SprungFrame
    items : SystemItems
    first : int
        Its first coordinate in the system.
    node, body : ItemNumber
    """

    frame: SprungFrame
    items: SystemItems
    first: int
    node: ItemNumber
    body: ItemNumber

    @classmethod
    def of(cls, mechanism: Mechanism, items: SystemItems, first: int) -> FrameBody | None:
        """Add the frame of a mechanism to a system; None where it stands.

        Parameters
        ----------
        mechanism : Mechanism
        items : SystemItems
        first : int
            Number of coordinates that the system has.
        """
        frame = mechanism.frame
        if frame is None:
            return None
        items.begin("frame: a rigid body on springs")
        node = items.add("NodeRigidBody2D", "frame_node", referenceCoordinates=[*frame.centre, 0.0])
        body = items.add(
            "ObjectRigidBody2D",
            "frame",
            nodeNumber=node,
            mass=frame.mass,
            inertia=frame.inertia,
        )
        made = cls(frame, items, first, node, body)
        made._add_springs()
        if any(mechanism.gravity):
            marker = items.add("MarkerNodeRigid", "frame_centre", nodeNumber=node)
            weight = [*(frame.mass * value for value in mechanism.gravity), 0.0]
            items.add("LoadForceVector", "frame_weight", markerNumber=marker, loadVector=weight)
        return made

    def _add_springs(self) -> None:
        for number, spring in enumerate(self.frame.springs):
            name = f"frame_spring_{number}"
            floor = self.items.add(
                "ObjectGround", f"{name}_floor", referencePosition=[*spring.point, 0.0]
            )
            markers = [
                self.items.add("MarkerBodyPosition", f"{name}_on_floor", bodyNumber=floor),
                self.add_marker(spring.point, f"{name}_on_frame"),
            ]
            self.items.add(
                "CartesianSpringDamper",
                name,
                markerNumbers=markers,
                stiffness=[*spring.stiffness, 0.0],
                damping=[*spring.damping, 0.0],
            )

    def add_marker(self, place: tuple[float, float], name: str) -> ItemNumber:
        """Add a marker at a place, in ground axes in m, of the frame as it is drawn."""
        x, y = self._lever(place)
        return self.items.add(
            "MarkerBodyRigid", name, bodyNumber=self.body, localPosition=[x, y, 0.0]
        )

    def add_angle_marker(self, name: str) -> ItemNumber:
        """Add a marker of its angle."""
        return self.items.add("MarkerNodeCoordinate", name, nodeNumber=self.node, coordinate=2)

    def joined(self, place: tuple[float, float]) -> JoinedEnd:
        """A point of it, by its place in ground axes in m as it is drawn."""
        return JoinedEnd(self.first, self.frame.centre, self._lever(place), has_slope=False)

    def motion(self, position: FloatArray, velocity: FloatArray) -> FrameMotion:
        """Its motion from coordinates (m, total_size) of the system and their rates."""
        own = slice(self.first, self.first + 3)
        return FrameMotion(position[:, own], velocity[:, own])

    def added(
        self, block: StepBlock, moved: FrameMotion, gravity: tuple[float, float]
    ) -> StepBlock:
        """Records of steps with the motion of the frame and its energies.

        Parameters
        ----------
        block : StepBlock
        moved : FrameMotion
        gravity : tuple of float
            In m/s^2.
        """
        pair = moved.displacement, moved.rate
        ends = [self.frame.point_motion(spring.point, *pair) for spring in self.frame.springs]
        places, rates = (np.array(part) for part in zip(*ends, strict=True))
        stiffness, damping = (
            np.array([getattr(spring, name) for spring in self.frame.springs])[:, None]
            for name in ("stiffness", "damping")
        )
        kinetic = moved.rate**2 @ np.diag(self.frame.inertia_matrix) / 2
        centre = np.asarray(self.frame.centre) + moved.displacement[:, :2]
        strain = (stiffness * places**2).sum(axis=(0, 2)) / 2
        dissipated = (damping * rates**2).sum(axis=(0, 2))
        return replace(
            block,
            kinetic_energy=block.kinetic_energy + kinetic,
            strain_energy=block.strain_energy + strain,
            gravity_energy=block.gravity_energy - self.frame.mass * centre @ np.asarray(gravity),
            dissipation_power=block.dissipation_power + dissipated,
            frame=moved,
        )

    def _lever(self, place: tuple[float, float]) -> tuple[float, float]:
        """From the centre to a place in m."""
        x, y = self.frame.centre
        return float(place[0]) - x, float(place[1]) - y
