"""Loads of rigid links, equilibria and runs, at crank angles to which further ones can be added."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from flexmech.analyses.strength.forces import Cuts, forces_over_the_turn, internal_forces
from flexmech.analyses.strength.joint_loads import JointLoads, LoadsOfTurn
from flexmech.arrays import FloatArray
from flexmech.linear_system import DisplacedLinks
from flexmech.linkages import InverseDynamics
from flexmech.mechanism import Mechanism

Found = DisplacedLinks | InverseDynamics
"""What internal and joint forces follow from, at a batch of crank angles."""


class SampledLoads(Protocol):
    """Loads at crank angles.

    Attributes
    ----------
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    """

    crank_angles: FloatArray

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Of every link.

        Returns
        -------
        LoadsOfTurn
        """


@dataclass
class LoadsAtAngles:
    """Loads of links that are at rest in their frames at every crank angle.

    Parameters
    ----------
    mechanism : Mechanism
    compute : callable
        From crank angles (m,) in rad to the links there, batch by batch.
    crank_angles : ndarray, shape (A,)
        In rad, increasing; begins without any.
    """

    mechanism: Mechanism
    compute: Callable[[FloatArray], Sequence[Found]]
    crank_angles: FloatArray = field(default_factory=lambda: np.empty(0))
    _found: list[Found] = field(default_factory=list, repr=False)
    _order: FloatArray = field(default_factory=lambda: np.empty(0), repr=False)

    @classmethod
    def of_rigid_links(cls, mechanism: Mechanism, speed: float) -> LoadsAtAngles:
        """Loads of links that are taken as rigid, at a crank speed in rad/s."""
        return cls(mechanism, lambda angles: [forces_over_the_turn(mechanism, angles, speed)])

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """
        new = np.setdiff1d(crank_angles, self.crank_angles)
        if new.size:
            self._found += self.compute(new)
            self._order = np.concatenate([self._order, new])
            self.crank_angles = np.sort(self._order)

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Of every link.

        Returns
        -------
        LoadsOfTurn
        """
        topology = self.mechanism.linkage.topology
        parts = []
        for found in self._found:
            inside = {
                name: internal_forces(found, number, cuts[name])
                for number, name in enumerate(topology.link_names)
            }
            parts.append(LoadsOfTurn(inside, JointLoads.of_links(found, topology)))
        return LoadsOfTurn.joined(parts).at(np.argsort(self._order))


@dataclass
class LoadsOfRun:
    """Loads of a run at its samples, and between them by cubic splines.

    Parameters
    ----------
    angles_of_samples : ndarray, shape (A,)
        In rad, increasing.
    at_samples : callable
        From the cuts of every link to the loads at the samples.
    """

    angles_of_samples: FloatArray
    at_samples: Callable[[Mapping[str, Cuts]], LoadsOfTurn]
    crank_angles: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.crank_angles = self.angles_of_samples

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """
        self.crank_angles = np.union1d(self.crank_angles, crank_angles)

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Of every link.

        Returns
        -------
        LoadsOfTurn
        """
        found, samples = self.at_samples(cuts), self.angles_of_samples
        between = np.setdiff1d(self.crank_angles, samples)
        if not between.size:
            return found
        more = found.mapped(lambda values: CubicSpline(samples, values)(between))
        order = np.argsort(np.concatenate([samples, between]))
        return LoadsOfTurn.joined([found, more]).at(order)
