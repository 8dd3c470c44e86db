"""Links with nonlocal bending energy in a nonlinear equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.link_matrices import Coupling
from flexmech.linear_system import LinkFrames
from flexmech.reference.dependent_element import Ties


class CoupledLinks:
    """Elastic energies over whole links; see :class:`flexmech.beams.link_matrices.Coupling`.

    A rigid rotation of the link has no curvature, to first order in the rotations of elements
    against it.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    couplings : mapping of int to Coupling
        Of links by their number.

    Attributes
    ----------
    columns : list of ndarray of int
        Independent coordinates that move each of these links.
    """

    columns: list[IntArray]

    def __init__(self, frames: LinkFrames, couplings: Mapping[int, Coupling]) -> None:
        self._frames = frames
        self._couplings = dict(couplings)
        self.columns = [self._columns(link) for link in self._couplings]

    def add_forces(
        self,
        displacement: Sequence[FloatArray],
        forces: Sequence[FloatArray],
        swelling: float = 1.0,
    ) -> None:
        """Add the internal forces of the coupling.

        Parameters
        ----------
        displacement, forces : sequence of ndarray, shape (n_link, B)
        swelling : float
            Part of the swelling that has come on.
        """
        for link, own in self._couplings.items():
            bent = own.rows @ displacement[link] - swelling * own.unloaded[:, None]
            forces[link][:] += own.rows.T @ (own.elastic @ bent)

    def tangents(self, ties: Ties, batch: int) -> Iterator[FloatArray]:
        """Stiffness of each link by its :attr:`columns`, (m, m, B), one after the other.

        Parameters
        ----------
        ties : Ties
            Of the displaced links.
        batch : int
            B, the number of positions.
        """
        for (link, own), columns in zip(self._couplings.items(), self.columns, strict=True):
            target = self._frames.targets[link].copy()
            moved = np.zeros((len(own.rows), self._frames.size, batch))
            for (rows, columns_of_tie), turn in zip(
                self._frames.dependencies(link), ties.turns[link], strict=True
            ):
                moved[:, columns_of_tie] += np.einsum("kr,rcb->kcb", own.rows[:, rows], turn)
                target[rows] = -1
            free = target >= 0
            moved[:, target[free]] += own.rows[:, free, None]
            moved = moved[:, columns]
            stressed = np.einsum("kl,lib->kib", own.elastic, moved)
            yield np.einsum("kib,kjb->ijb", moved, stressed, optimize=True)

    def _columns(self, link: int) -> IntArray:
        target = self._frames.targets[link]
        columns_of_tie = [columns for _, columns in self._frames.dependencies(link)]
        found = np.unique(np.concatenate([target, *columns_of_tie]))
        return found[found >= 0]
