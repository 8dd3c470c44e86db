"""Internal forces of links that run, by d'Alembert's principle.

To the dead forces of :mod:`.section_forces` come the inertia forces of the motion in the links'
frames, at the places to which their matter is displaced. The joint forces balance them, so that all
internal forces are in balance with each other and with what moves (Shabana, *Dynamics of Multibody
Systems*, 5th ed., ch. 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.assembly.engine import Engine
from flexmech.linear_system.assembly.section_forces import DisplacedLinks, ForcesAlong, cross
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal


@dataclass(frozen=True)
class RunningLinks(DisplacedLinks):
    """Links of a mechanism that move in their frames.

    Parameters
    ----------
    mechanism : Mechanism
    links : tuple of LinkModel
        Unreduced.
    motion : RigidMotion
        Of the rigid linkage, for a batch of shape (B,).
    displacement : list of ndarray, shape (B, n_link)
    acting : tuple of PointForce
        Loads and springs at these displacements.
    rate, acceleration : list of ndarray, shape (B, n_link)
        Of the links' coordinates, in their frames.
    """

    rate: list[FloatArray]
    acceleration: list[FloatArray]

    @classmethod
    def of_run(
        cls,
        engine: Engine,
        motion: RigidMotion,
        time: FloatArray,
        displacement: list[FloatArray],
        rate: list[FloatArray],
        acceleration: list[FloatArray],
    ) -> RunningLinks:
        """Links of an engine along a run.

        Parameters
        ----------
        engine : Engine
        motion : RigidMotion
            Of the rigid linkage at B samples, with what a free shaft has turned.
        time : ndarray, shape (B,)
            In s.
        displacement, rate, acceleration : list of ndarray, shape (B, n_link)
            Of the links' coordinates, in their frames.

        Returns
        -------
        RunningLinks
        """
        engine.require_standing_frame("the strength of links")
        connectors, acting = engine.connectors, []
        if connectors.any:
            acting = connectors.point_forces(motion, displacement, time)
        links = engine.mechanism, engine.links, motion, displacement, tuple(acting)
        return cls(*links, rate, acceleration)

    def _inertia(
        self,
        link: int,
        place: FloatArray,
        mass: FloatArray,
        arm: FloatArray,
        inertia: FloatArray | float = 0.0,
        vibrates: bool = True,
    ) -> ForcesAlong:
        """As :meth:`DisplacedLinks._inertia`, with the motion in the link's frame."""
        motion, angle = self.motion, self.motion.angle[:, link]
        pull = motion.origin_acceleration[:, link] - np.asarray(self.mechanism.gravity)
        along, across = (np.sum(pull * axis(angle), axis=-1) for axis in (direction, normal))
        turning = motion.angular_velocity[:, link, None]
        change = motion.angular_acceleration[:, link, None]
        at = self._arms(link, place, arm)
        speed, gain, spin = self._motion_in_frame(link, place, at)
        x, y = at[..., 0], at[..., 1]
        force = -mass[:, None] * np.stack(
            [
                along[:, None]
                + gain[..., 0]
                - turning**2 * x
                - change * y
                - 2 * turning * speed[..., 1],
                across[:, None]
                + gain[..., 1]
                - turning**2 * y
                + change * x
                + 2 * turning * speed[..., 0],
            ],
            axis=-1,
        )
        turned = change + spin if vibrates else change
        return ForcesAlong(place, force, cross(at, force) - inertia * turned)

    def _motion_in_frame(
        self, link: int, place: FloatArray, at: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Velocity and acceleration (B, j, 2) of points that sections carry, and angular one."""
        rows, turned = self._rows(link, place)
        rate, gain = self.rate[link], self.acceleration[link]
        speed, change = (np.einsum("kcn,bn->bkc", rows, each) for each in (rate, gain))
        spin, spin_gain = rate @ turned.T, gain @ turned.T
        moved = self._moved(link, place)
        arm = at - np.stack([place + moved[..., 0], moved[..., 1]], axis=-1)
        across = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return (
            speed + spin[..., None] * across,
            change + spin_gain[..., None] * across - spin[..., None] ** 2 * arm,
            spin_gain,
        )

    def _rows(self, link: int, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacement (k, 2, n) and rotation (k, n) at places by a link's coordinates."""
        model = self.links[link]
        if model.rigid:
            shift = np.zeros((len(place), 2, model.size))
            shift[:, 0, 0] = shift[:, 1, 1] = 1.0
            shift[:, 1, 2] = place
            turned = np.zeros((len(place), model.size))
            turned[:, 2] = 1.0
            return shift, turned
        fraction = place / model.readings.nodes[-1]
        return model.readings.displacement_at(fraction), model.readings.rotations_at(fraction)
