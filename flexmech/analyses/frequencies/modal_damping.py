"""Damping ratio of each mode by what its strain energy loses in a cycle.

A vibration that stores the energy U and loses DU of it in a cycle has the damping ratio
``DU / (4 pi U)`` (Ungar & Kerwin 1962). A composite's loss is known as a part psi of the
strain energy of each kind of deformation, whatever the frequency (Adams & Bacon 1973). The
Kelvin-Voigt damping matrix C1 of sections with the times ``psi / (2 pi)`` is the stiffness
matrix weighted by psi, over 2 pi; a mode ``phi`` of frequency omega loses ``pi phi^H C1 phi``
in a cycle and has::

    zeta = phi^H C1 phi / (omega^2 phi^H M phi + phi^H K phi)

The denominator is four times the energy of the vibration. At rest both its parts are twice
the strain energy. At speed K holds what tension adds, which stores energy and loses none, so
that zeta falls; with the terms of turning frames kinetic and potential energy differ, and
half their sum is what a gyroscopic system keeps. So zeta is, to first order, the real part
of the eigenvalue that small damping C1 / omega adds, without what turning frames add to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine, LinearSystem, Prestress
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, DampingTimes
from flexmech.solvers.eigenproblem import Modes


def links_without_loss(mechanism: Mechanism) -> tuple[str, ...]:
    """Links whose sections tell no loss in a cycle: no specific damping, or zero."""
    return tuple(
        name
        for name in mechanism.links_with_sections
        if not _loss_times(mechanism.sections[name]).any
    )


@dataclass(frozen=True)
class StrainEnergyDamping:
    """Loss in a cycle of the modes of an engine's linear systems.

    Parameters
    ----------
    engine : Engine
        On the mechanism whose Kelvin-Voigt times lose, at 1 rad/s, what the specific damping
        says; its links are otherwise those of the systems.
    """

    engine: Engine

    @classmethod
    def of(cls, engine: Engine) -> Self | None:
        """For an engine; None if no section of its mechanism tells a loss.

        A link without specific damping is taken to lose nothing, whatever Kelvin-Voigt
        damping it has: that one depends on the frequency.
        """
        mechanism = engine.mechanism
        if len(links_without_loss(mechanism)) == len(mechanism.sections):
            return None
        losing = replace(
            mechanism,
            sections={
                name: replace(section, damping=_loss_times(section))
                for name, section in mechanism.sections.items()
            },
        )
        return cls(engine.with_(mechanism=losing, element=engine.element))

    def ratio(
        self,
        system: LinearSystem,
        modes: Modes,
        prestress: Prestress,
        running: Sequence[FloatArray] | None = None,
    ) -> FloatArray:
        """Damping ratio of modes.

        Parameters
        ----------
        system : LinearSystem
            Batch of B positions, reduced or not.
        modes : Modes
            Modes of the system.
        prestress : {"none", "axial", "equilibrium"}
            As the system's.
        running : sequence of ndarray, shape (B, n_link), optional
            States that the system is linearized about in place of the prestress.

        Returns
        -------
        ndarray, shape (B, m)
        """
        engine, vectors = self.engine, modes.vectors
        stressed = (
            engine.stressed_links(system.motion, prestress)
            if running is None
            else engine.running_links(system.motion, running)
        )
        damping = stressed.damping or [link.damping for link in engine.links]
        # The unreduced links count: a reduction may condense by another stiffness than theirs.
        loss = sum(
            _square(matrix, q)
            for matrix, q in zip(damping, _unreduced(system, vectors), strict=True)
        )
        kinetic = np.abs(modes.eigenvalues) ** 2 * _square(system.mass, vectors)
        return np.asarray(loss / (kinetic + _square(system.stiffness, vectors)), dtype=float)


def _loss_times(section: BeamSection) -> DampingTimes:
    """Kelvin-Voigt times that lose at 1 rad/s what the specific damping says."""
    if section.specific_damping is None:
        return DampingTimes()
    return section.specific_damping.times(angular_frequency=1.0)


def _unreduced(system: LinearSystem, vectors: NDArray[Any]) -> list[NDArray[Any]]:
    """Coordinates of each unreduced link, (B, n_link, m); its following ends turned with it."""
    links = system.link_coordinates(vectors)
    if system.bases is None:
        return links
    return [basis @ q for basis, q in zip(system.bases, links, strict=True)]


def _square(matrix: FloatArray, vectors: NDArray[Any]) -> FloatArray:
    """``x^H A x`` of shapes (B, n, m) with matrices (n, n) or (B, n, n); (B, m)."""
    return np.asarray(np.sum(vectors.conj() * (matrix @ vectors), axis=1).real, dtype=float)
