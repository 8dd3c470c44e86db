"""Displacements of points of links along a run, without energies and forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import LinkDirection
from flexmech.linear_system import LinkModel, LinkPoint, displacement_row
from flexmech.linkages import Topology


class PointRecorder:
    """Records the displacement of points of links at every step.

    Energies and forces, which take longer, are not asked for.

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

    def add(self, displacement: Sequence[FloatArray]) -> None:
        """Take the links' displacements (m, n_link) of the next steps.

        The first one repeats the last step of the block before.
        """
        moved = np.stack([displacement[link] @ row for link, row in self._rows], axis=1)
        self._parts.append(moved[1:] if self._parts else moved)

    def finish(self) -> FloatArray:
        """Displacements at all steps in m, shape (steps + 1, n_points)."""
        return np.concatenate(self._parts)
