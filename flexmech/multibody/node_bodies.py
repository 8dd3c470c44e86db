"""The mass of links whose matter is off the neutral axis: beams and bodies at their nodes.

A beam element of Exudyn carries its mass on its own axis. What sits off it is a rigid body
at each node, with the mass of the half elements beside the node, its centre of mass and its
rotary inertia: lumped. Lumped masses alone would make a rigid link's moment of inertia too
great, so the elements add the difference to the consistent mass: their own mass, and as
much negative mass at the nodes. The sum has the section's mass, first moment and rotary
inertia.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.mechanism import Mechanism
from flexmech.multibody.library import load_exudyn
from flexmech.sections import BeamSection
from flexmech.types import FloatArray

__all__ = ["BeamInertia", "NodeBodies", "point_masses_at"]


@dataclass(frozen=True)
class BeamInertia:
    """What a beam element carries on its axis, per length.

    Parameters
    ----------
    mass_per_length : float
        In kg/m.
    rotary_inertia : float
        In kg m.
    """

    mass_per_length: float
    rotary_inertia: float

    @classmethod
    def of(cls, section: BeamSection) -> BeamInertia:
        """All of a section on whose neutral axis its matter is centred, or the share of it."""
        if not section.is_eccentric:
            return cls(section.mass_per_length, section.rotary_inertia)
        return cls(_consistent_share(section) * section.mass_per_length, 0.0)


@dataclass(frozen=True)
class NodeBodies:
    """Bodies at the nodes of one link, and what they weigh.

    Parameters
    ----------
    numbers : list of int
        Exudyn's numbers of the bodies, node by node.
    mass : ndarray, shape (e + 1,)
        In kg.
    centre : ndarray, shape (e + 1,)
        Distance of their centres of mass from the neutral axis in m.
    """

    numbers: list[int]
    mass: FloatArray
    centre: FloatArray

    @classmethod
    def added(
        cls,
        mbs: Any,
        nodes: list[int],
        positions: FloatArray,
        section: BeamSection,
        point_masses: FloatArray,
    ) -> NodeBodies:
        """Add the bodies to a system.

        Parameters
        ----------
        mbs : exudyn.MainSystem
        nodes : list of int
            Exudyn's numbers.
        positions : ndarray, shape (e + 1,)
            Of the nodes along the link in m.
        section : BeamSection
        point_masses : ndarray, shape (e + 1,)
            On the pins' axis in kg.

        Returns
        -------
        NodeBodies
        """
        items = load_exudyn().itemInterface
        half = np.diff(positions) / 2
        share = section.mass_per_length * (np.append(half, 0.0) + np.append(0.0, half))
        at, pins = section.mass_axis - section.neutral_axis, -section.neutral_axis
        mass = share + point_masses
        centre = (share * at + point_masses * pins) / mass
        own = section.rotary_inertia / section.mass_per_length
        inertia = share * (own + at**2) + point_masses * pins**2
        numbers = [
            int(
                mbs.AddObject(
                    items.ObjectRigidBody2D(
                        nodeNumber=node, mass=m, inertia=i, centerOfMass=[0.0, y]
                    )
                )
            )
            for node, m, i, y in zip(nodes, mass, inertia, centre, strict=True)
        ]
        for node, twice in zip(nodes, _consistent_share(section) * share, strict=True):
            removed = np.diag([-twice, -twice, 0.0])
            mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=removed))
        return cls(numbers, mass, centre)


def point_masses_at(mechanism: Mechanism, link: str, positions: FloatArray) -> FloatArray:
    """Point mass at each node of a link.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    positions : ndarray, shape (e + 1,)
        Of the nodes in m.

    Returns
    -------
    ndarray, shape (e + 1,)
        In kg.
    """
    points, masses = mechanism.link_mass(link), np.zeros(len(positions))
    for x, value in zip(points.point_positions, points.point_masses, strict=True):
        masses[np.argmin(np.abs(positions - x))] += value
    return masses


def _consistent_share(section: BeamSection) -> float:
    """How much of the consistent mass replaces lumped mass, from 0 to 1.

    Consistent mass of nodes that move to and fro in turn is a third of the lumped one. The
    mass matrix stays positive while that, against rotary inertia about the neutral axis,
    outweighs the first moment: all of it may be consistent if the centre of mass is nearer
    to the neutral axis than the radius of gyration by a factor of the square root of 3.
    """
    square = (section.mass_axis - section.neutral_axis) ** 2
    ratio = square / (square + section.rotary_inertia / section.mass_per_length)
    return float(min(1.0, (4 - 4 * ratio) / 3))
