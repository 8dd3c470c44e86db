"""Forces that keep their direction on links whose ties move with the displacement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system.link_model import LinkModel
from flexmech.linear_system.rigid_coordinates import PoseStiffness
from flexmech.linear_system.rigid_pose import DisplacedTies
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class DeadForces:
    """Forces on all links in a batch of positions.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,).
    loads : list of ndarray, shape (B, n_link)
        On each link in its frame; on rigid ones force and moment about the start.
    virial, moment : ndarray, shape (B, n_links)
        Of rigid links: products of these forces and their places, and their moments about the
        start, where the link is not displaced.
    rigid : tuple of int
        Numbers of the rigid links.
    """

    motion: RigidMotion
    loads: list[FloatArray]
    virial: FloatArray
    moment: FloatArray
    rigid: tuple[int, ...]

    @classmethod
    def of(
        cls,
        links: Sequence[LinkModel],
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        virial: FloatArray | None,
    ) -> Self:
        """Forces on links.

        Parameters
        ----------
        links : sequence of LinkModel
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
        virial : ndarray, shape (B, n_links), optional
            Zero by default.
        """
        rigid = tuple(number for number, link in enumerate(links) if link.rigid)
        moment = np.zeros((len(motion.crank_angle), len(links)))
        for number in rigid:
            moment[:, number] = loads[number][:, 2]
        own = np.zeros_like(moment) if virial is None else virial
        return cls(motion, list(loads), own, moment, rigid)

    def scaled(self, part: float) -> DeadForces:
        """A part of them."""
        loads = [part * load for load in self.loads]
        return replace(self, loads=loads, virial=part * self.virial, moment=part * self.moment)

    def at(self, which: NDArray[np.bool_] | IntArray) -> DeadForces:
        """Those of some positions."""
        return replace(
            self,
            motion=self.motion.at(which),
            loads=[load[which] for load in self.loads],
            virial=self.virial[which],
            moment=self.moment[which],
        )

    def unbalanced(self, posed: DisplacedTies, inner: Sequence[FloatArray]) -> list[FloatArray]:
        """Outer less inner forces (B, n_link) on displaced links."""
        forces = [load - force for load, force in zip(self.loads, inner, strict=True)]
        for link in self.rigid:
            turn = posed.pose.displaced.turn[:, link]
            turned = np.cos(turn) * self.moment[:, link] - np.sin(turn) * self.virial[:, link]
            turned -= inner[link][:, 2]
            forces[link] = np.column_stack([forces[link][:, :2], turned])
        return forces

    def stiffness(self, posed: DisplacedTies, inner: Sequence[FloatArray]) -> PoseStiffness:
        """Stiffness of rigid links and sliders by them and by the forces of the joints."""
        return posed.stiffness(self.unbalanced(posed, inner), self.virial, self.moment)
