"""The mass of links of geometrically exact beams: rigid bodies at their nodes.

Exudyn's element has the mass of linear interpolation, whose frequencies are of second order
in the element length h, and carries it on its own axis alone. Here the elements have none.
Each node carries the rigid segment of the link around it, half an element to either side, off
the neutral axis where the section's matter is. The remaining error of second order is removed by
two differences between the nodes of an element, of their velocities and of their spins:

    2 T = sum of m h (v^2 + (r^2 + h^2 / 12) phi^2)
          - m h / 12 (v_1 - v_2)^2 + (EI / kGA) m h / 12 (phi_1 - phi_2)^2,

with the mass m and the squared radius of gyration r^2 of the section. With the stiffness of
:func:`flexmech.multibody.strains.element_shear_stiffness` a wave along the beam then has the
frequency of Timoshenko's theory to fourth order, up to terms in the fourth power of r
over the wave's length; a rod, whose phi is zero, to fourth order too. At the ends of the link,
and where a point mass interrupts it, integration by parts leaves ``m h^2 / 12`` times ``v (v' +
phi)``: half of it moves mass from the last node to the one before, half of it moves the centre
of mass of the last body inwards. Mass, first and second moment of a rigid link are those of the
section exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism
from flexmech.multibody.items import ItemNumber, Made, SystemItems
from flexmech.multibody.running.user_functions import difference_mass
from flexmech.sections import BeamSection


@dataclass(frozen=True)
class NodalMass:
    """Mass of one link at its nodes and in the differences between them.

    Parameters
    ----------
    share : ndarray, shape (e + 1,)
        Mass of each node in kg.
    along : ndarray, shape (e + 1,)
        First moment of it along the link about the node in kg m.
    rotary : ndarray, shape (e + 1,)
        Rotary inertia of the section in kg m^2.
    segment : ndarray, shape (e + 1,)
        Rotary inertia of a rigid segment around the node, as a line, in kg m^2.
    velocity, spin : ndarray, shape (e,)
        Mass in kg and inertia in kg m^2 by the difference of the nodes' velocities and spins.
    """

    share: FloatArray
    along: FloatArray
    rotary: FloatArray
    segment: FloatArray
    velocity: FloatArray
    spin: FloatArray

    @classmethod
    def of(cls, section: BeamSection, positions: FloatArray, point_masses: FloatArray) -> NodalMass:
        """Mass of a section along a link.

        Parameters
        ----------
        section : BeamSection
        positions : ndarray, shape (e + 1,)
            Of the nodes in m.
        point_masses : ndarray, shape (e + 1,)
            In kg; they are not counted, but interrupt the link.

        Returns
        -------
        NodalMass
        """
        length = np.diff(positions)
        mass, soft = section.mass_per_length, section.bending_stiffness / section.shear_stiffness
        share, along = mass * _halves(length), np.zeros(len(positions))
        velocity = mass * length / 12
        for first, last in _uniform_pieces(length, point_masses):
            for end, inwards in ((first, 1), (last, -1)):
                element = min(end, end + inwards)
                moved = mass * length[element] / 24
                share[[end, end + inwards]] += [-moved, moved]
                along[end] += inwards * moved * length[element]
                velocity[element] += moved
        return cls(
            share=share,
            along=along,
            rotary=section.rotary_inertia * _halves(length),
            segment=mass * _halves(length**3 / 12),
            velocity=_kept(section, float(length.min())) * velocity,
            spin=soft * mass * length / 12,
        )


@dataclass(frozen=True)
class NodeBodies:
    """Bodies at the nodes of one link, with their mass.

    Parameters
    ----------
    numbers : list of ItemNumber
        Of the bodies, node by node.
    mass : ndarray, shape (e + 1,)
        In kg.
    centre : ndarray, shape (e + 1, 2)
        Their centres of mass from the nodes, along and across the link, in m.
    inertia : ndarray, shape (e + 1,)
        About the nodes in kg m^2.
    link : NodalMass
    """

    numbers: list[ItemNumber]
    mass: FloatArray
    centre: FloatArray
    inertia: FloatArray
    link: NodalMass

    def moment(self, nodes: FloatArray) -> FloatArray:
        """Mass times the place of their centre but for a constant, (m, 2).

        Parameters
        ----------
        nodes : ndarray, shape (m, e + 1, 3)
            Displacement and angle of the nodes.
        """
        (along, across), angle = self.centre.T[..., None], nodes[..., 2]
        places = nodes[..., :2] + along * direction(angle) + across * normal(angle)
        return np.asarray(np.einsum("mek,e->mk", places, self.mass))

    def kinetic_energy(self, angle: FloatArray, rate: FloatArray) -> FloatArray:
        """Kinetic energy with that of the differences between the nodes, (m,).

        Parameters
        ----------
        angle : ndarray, shape (m, e + 1)
            Of the nodes in rad.
        rate : ndarray, shape (m, e + 1, 3)
            Their velocities and spins.
        """
        (along, across), spin = self.centre.T[..., None], rate[..., 2]
        lever = along * normal(angle) - across * direction(angle)
        velocity = np.sum(rate[..., :2] * (rate[..., :2] + 2 * spin[..., None] * lever), axis=-1)
        change = np.diff(rate, axis=1) ** 2
        return np.asarray(
            velocity @ self.mass / 2
            + spin**2 @ self.inertia / 2
            - change[..., :2].sum(axis=-1) @ self.link.velocity / 2
            + change[..., 2] @ self.link.spin / 2
        )

    @classmethod
    def added(
        cls,
        items: SystemItems,
        link: str,
        nodes: list[ItemNumber],
        positions: FloatArray,
        section: BeamSection,
        point_masses: FloatArray,
    ) -> NodeBodies:
        """Add the bodies and the masses of the differences between nodes to a system.

        Parameters
        ----------
        items : SystemItems
        link : str
            Name of the link.
        nodes : list of ItemNumber
        positions : ndarray, shape (e + 1,)
            Of the nodes along the link in m.
        section : BeamSection
        point_masses : ndarray, shape (e + 1,)
            On the pins' axis in kg.

        Returns
        -------
        NodeBodies
        """
        own = NodalMass.of(section, positions, point_masses)
        at, pins = section.mass_axis - section.neutral_axis, -section.neutral_axis
        mass = own.share + point_masses
        across = own.share * at + point_masses * pins
        centre = np.stack([own.along, across], axis=1) / mass[:, None]
        inertia = own.rotary + own.segment + own.share * at**2 + point_masses * pins**2
        items.begin(f"{link}: bodies at the nodes, which carry its mass and point masses")
        numbers = [
            items.add(
                "ObjectRigidBody2D",
                f"{link}_body_{number}",
                nodeNumber=node,
                mass=float(m),
                inertia=float(i),
                centerOfMass=[float(x), float(y)],
            )
            for number, (node, m, i, (x, y)) in enumerate(
                zip(nodes, mass, inertia, centre, strict=True)
            )
        ]
        items.begin(f"{link}: mass by the differences between nodes, for fourth order")
        differences = zip(pairwise(nodes), own.velocity, own.spin, strict=True)
        for number, (pair, velocity, spin) in enumerate(differences):
            matrix = Made(difference_mass, (-float(velocity), float(spin)))
            items.add(
                "ObjectGenericODE2",
                f"{link}_difference_{number}",
                nodeNumbers=list(pair),
                massMatrix=matrix,
            )
        return cls(numbers, mass, centre, inertia, own)


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


def _halves(values: FloatArray) -> FloatArray:
    """Half of each element's value to either of its nodes."""
    return np.asarray(np.append(values / 2, 0.0) + np.append(0.0, values / 2))


def _uniform_pieces(length: FloatArray, point_masses: FloatArray) -> list[tuple[int, int]]:
    """First and last node of each piece of equal elements without a point mass between."""
    uneven = ~np.isclose(length[1:], length[:-1], rtol=SAME_PLACE, atol=0.0)
    inner = np.flatnonzero(uneven | (point_masses[1:-1] > 0)) + 1
    return list(pairwise([0, *inner.tolist(), len(length)]))


def _kept(section: BeamSection, length: float) -> float:
    """Part of the difference of velocities that is subtracted, from 0 to 1.

    All of it, unless the centre of mass is so far off the neutral axis that the mass of nodes
    moving to and fro in turn would not be positive any more. It takes a third off that mass
    inside a link, half of it at its ends.
    """
    square = (section.mass_axis - section.neutral_axis) ** 2
    turning = section.rotary_inertia / section.mass_per_length + length**2 / 12
    turning += section.bending_stiffness / section.shear_stiffness / 3
    return float(np.clip(2 * turning / (square + turning), 0.0, 1.0))
