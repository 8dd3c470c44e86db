"""Displacement of a few points at every step: what a vibrometer keeps of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from flexmech.choices import LinkDirection
from flexmech.linear_system import LinkModel, LinkPoint, displacement_row
from flexmech.linkages import Topology
from flexmech.time_domain.recording import StepBlock
from flexmech.types import FloatArray


class BlockTaker(Protocol):
    """What a run hands its steps to, block by block."""

    def add(self, block: StepBlock) -> None:
        """Take the next steps."""


class PointRecorder:
    """Keeps the displacement of points of links at every step.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced.
    points : sequence of (LinkPoint, {"transverse", "axial"})

    Raises
    ------
    InputError
        If a point is on no link.
    """

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        points: Sequence[tuple[LinkPoint, LinkDirection]],
    ) -> None:
        self._rows = [
            (number, displacement_row(links[number], point.fraction, direction))
            for point, direction in points
            for number in [point.index(topology)]
        ]
        self._parts: list[FloatArray] = []

    def add(self, block: StepBlock) -> None:
        """Take the next steps; the first one repeats the last step of the block before."""
        moved = np.stack([block.displacement[link] @ row for link, row in self._rows], axis=1)
        self._parts.append(moved[1:] if self._parts else moved)

    def finish(self) -> FloatArray:
        """Displacements at all steps in m, shape (steps + 1, n_points)."""
        return np.concatenate(self._parts)
