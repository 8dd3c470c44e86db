"""States of motion: of the links in their frames, and in independent coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.linear_system import LinkModel
from flexmech.types import FloatArray


@dataclass(frozen=True)
class LinkState:
    """Elastic state of all links at an instant, in the frames of their rigid motion.

    Parameters
    ----------
    displacement, rate : list of ndarray, shape (n_link,)
        Each link's coordinates less those of the undeformed link, and their time
        derivatives in that frame.
    """

    displacement: list[FloatArray]
    rate: list[FloatArray]

    @classmethod
    def rigid(cls, links: Sequence[LinkModel]) -> Self:
        """Undeformed links that move with the velocities of the rigid motion."""
        return cls([np.zeros(link.size) for link in links], [np.zeros(link.size) for link in links])


@dataclass(frozen=True)
class VibrationState:
    """Independent coordinates z, z', z'' of a driven linkage; see each use for the shapes."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def __getitem__(self, where: int | slice) -> VibrationState:
        """The same at some of the instants."""
        return VibrationState(self.position[where], self.velocity[where], self.acceleration[where])
