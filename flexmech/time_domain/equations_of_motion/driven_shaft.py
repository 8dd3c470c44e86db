"""A free shaft in the linear equations of motion: its rotation is one of the coordinates.

The frames of the links turn with the prescribed motion. The shaft carries the torque that keeps the
rigid linkage in it, by virtual work: the forces on the links and this torque do no work as the
rigid linkage turns. What the linear equations give is turned back afterwards into the frames of
the rigid linkage at the angle that the shaft has, to first order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine, LinkFrames, LinkModel
from flexmech.linkages import CrankDrive, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.time_domain.recorded_runs.recording import StepBlock
from flexmech.time_domain.recorded_runs.states import ShaftMotion, rigid_torque


@dataclass(frozen=True)
class DrivenShaft:
    """The free shaft of a driven linkage.

    Parameters
    ----------
    engine : Engine
    drive : CrankDrive
    frames : LinkFrames
        Of the reduced links.
    fields : tuple of ndarray, shape (n_link, 3)
        Of each reduced link: unit displacements along and across, and unit rotation.
    column : int
        Coordinate of the frames that is the shaft's rotation.
    """

    engine: Engine
    drive: CrankDrive
    frames: LinkFrames
    fields: tuple[FloatArray, ...]
    column: int

    @classmethod
    def of(
        cls,
        engine: Engine,
        drive: CrankDrive,
        frames: LinkFrames,
        links: Sequence[LinkModel],
        bases: Sequence[FloatArray],
    ) -> Self | None:
        """The shaft of an engine; None where it is prescribed.

        Parameters
        ----------
        engine : Engine
        drive : CrankDrive
        frames : LinkFrames
        links : sequence of LinkModel
            Reduced.
        bases : sequence of ndarray, shape (n_full, n_link)
            From each reduced link's coordinates to the engine's.

        Returns
        -------
        DrivenShaft or None
        """
        if engine.shaft == "prescribed":
            return None
        fields = []
        for full, basis in zip(engine.links, bases, strict=True):
            own = full.fields
            rigid = np.stack([own.along, own.across, own.tangential], axis=1)
            # Static shapes of a straight link show how it moves as a rigid body.
            fields.append(np.asarray(np.linalg.lstsq(basis, rigid)[0]))
        number = next(i for i, link in enumerate(links) if len(link.shaft))
        column = int(frames.targets[number][links[number].shaft[0]])
        return cls(engine, drive, frames, tuple(fields), column)

    def with_torque(self, motion: RigidMotion, force: FloatArray) -> FloatArray:
        """Forces on the coordinates of the frames with the torque that balances them.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        force : ndarray, shape (m, size)
            Of all that acts on the rigid linkage, inertia included.

        Returns
        -------
        ndarray, shape (m, size)
        """
        balanced = force.copy()
        balanced[:, self.column] -= np.sum(self.turn(motion) * force, axis=1)
        return balanced

    def turn(self, motion: RigidMotion) -> FloatArray:
        """Coordinates of the frames as the rigid linkage turns by 1 rad of the shaft, (m, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        """
        fields = self._fields_of_turn(motion)[0]
        moved = [(c @ f.T)[..., None] for c, f in zip(fields, self.fields, strict=True)]
        return self.frames.independent(motion, moved)[..., 0]

    def carried(
        self, block: StepBlock, motion: RigidMotion, position: FloatArray, velocity: FloatArray
    ) -> StepBlock:
        """Steps in the frames of the rigid linkage at the angle that the shaft has.

        Parameters
        ----------
        block : StepBlock
            In the frames of the prescribed motion.
        motion : RigidMotion
            That, batch of shape (m,).
        position, velocity : ndarray, shape (m, size)
            Coordinates of the frames.

        Returns
        -------
        StepBlock
            With the torque that the shaft is given.
        """
        shaft = ShaftMotion(position[:, self.column], velocity[:, self.column])
        shaft.refuse_runaway(self.drive, block.time)
        displacement, rate = [], []
        turn, change = self._fields_of_turn(motion)
        phi, speed = shaft.rotation[:, None], shaft.rate[:, None]
        for number, field in enumerate(self.fields):
            displacement.append(block.displacement[number] - phi * turn[number] @ field.T)
            moving = speed * turn[number] + phi * change[number]
            rate.append(block.rate[number] - moving @ field.T)
        return replace(
            block,
            crank_speed=block.crank_speed + shaft.rate,
            displacement=displacement,
            rate=rate,
            driving_torque=rigid_torque(self.engine.mechanism, self.drive, block.time),
            shaft=shaft,
        )

    def _fields_of_turn(self, motion: RigidMotion) -> tuple[list[FloatArray], list[FloatArray]]:
        """Rigid displacement of each link as the shaft turns by 1 rad, and its rate; (m, 3)."""
        linkage = self.engine.mechanism.linkage
        unit = linkage.motion(motion.crank_angle, 1.0)
        speed = motion.crank_speed[:, None]
        turn, change = [], []
        for link in range(len(self.fields)):
            along, across = direction(unit.angle[:, link]), normal(unit.angle[:, link])
            moved, moving = unit.origin_velocity[:, link], unit.origin_acceleration[:, link]
            spin, spinning = unit.angular_velocity[:, link], unit.angular_acceleration[:, link]
            x, y = np.sum(moved * along, axis=1), np.sum(moved * across, axis=1)
            turn.append(np.stack([x, y, spin], axis=1))
            rates = (
                np.sum(moving * along, axis=1) + spin * y,
                np.sum(moving * across, axis=1) - spin * x,
                spinning,
            )
            change.append(speed * np.stack(rates, axis=1))
        return turn, change
