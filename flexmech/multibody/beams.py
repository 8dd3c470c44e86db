"""The two beam elements of Exudyn that a link can be made of: coordinates, stiffness and strains.

Strains are by displacements from the straight link, not by places: strains of 1e-9 keep their
digits, which the difference of two lengths would lose to round-off.

The mass of geometrically exact beams is in rigid bodies at their nodes. Exudyn's element has the
mass of linear interpolation, whose frequencies are of second order in the element length h, and
carries it on its own axis alone. Here the elements have none. Each node carries the rigid segment
of the link around it, half an element to either side, off the neutral axis where the section's
matter is. The remaining error of second order is removed by two differences between the nodes of an
element, of their velocities and of their spins:

    2 T = sum of m h (v^2 + (r^2 + h^2 / 12) phi^2)
          - m h / 12 (v_1 - v_2)^2 + (EI / kGA) m h / 12 (phi_1 - phi_2)^2,

with the mass m and the squared radius of gyration r^2 of the section. With the stiffness of
:func:`element_shear` a wave along the beam then has the frequency of Timoshenko's theory to fourth
order, up to terms in the fourth power of r over the wave's length; a rod, whose phi is zero, to
fourth order too. At the ends of the link, and where a point mass interrupts it, integration by
parts leaves ``m h^2 / 12`` times ``v (v' + phi)``: half of it moves mass from the last node to the
one before, half of it moves the centre of mass of the last body inwards. Mass, first and second
moment of a rigid link are those of the section exactly.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.mechanics import RigidFields
from flexmech.mechanics.beams.theories import hermite
from flexmech.mechanism import Mechanism
from flexmech.multibody.items import ItemNumber, Made, SystemItems
from flexmech.multibody.running.user_functions import difference_mass
from flexmech.sections import BeamSection

# Exudyn integrates a cable's axial strain to order 9 and its curvature to order 5.
# So many of Gauss's points do the same: 2 n - 1.
AXIAL_POINTS = 5
BENDING_POINTS = 3
# Slope vector of the straight link, for each of many points.
ALONG = np.array([1.0, 0.0])[:, None, None, None]


@dataclass(frozen=True)
class Strain:
    """One strain of a chain of elements at their integration points.

    Parameters
    ----------
    value, rate : ndarray, shape (m, e, g)
        Axial strain, shear angle or curvature (1/m) and its time derivative.
    weight : ndarray, shape (e, g)
        Stiffness times the integration weight of the point in m: half of it times the strain
        squared is the strain energy in J.
    damping_time : float or ndarray, shape (e,)
        Kelvin-Voigt time of this strain in s.
    """

    value: FloatArray
    rate: FloatArray
    weight: FloatArray
    damping_time: float | FloatArray

    @property
    def energy(self) -> FloatArray:
        """Strain energy in J, shape (m,)."""
        return np.asarray(np.einsum("meg,meg,eg->m", self.value, self.value, self.weight) / 2)

    @property
    def element_power(self) -> FloatArray:
        """Power of the elastic stress in each element in W, (m, e), the rate of :attr:`energy`."""
        return np.asarray(np.einsum("meg,meg,eg->me", self.value, self.rate, self.weight))

    @property
    def dissipation(self) -> FloatArray:
        """Dissipated power of Kelvin-Voigt damping in W, shape (m,)."""
        power = np.einsum("meg,meg,eg->me", self.rate, self.rate, self.weight)
        return np.asarray((self.damping_time * power).sum(axis=1))


class BeamKind(ABC):
    """A kind of beam element of Exudyn, and the coordinates of a chain of them.

    Attributes
    ----------
    node, element : str
        Names of Exudyn's classes.
    straight : tuple of float
        Coordinates of a node of the straight link, after those of its place.
    per_node : int
        Coordinates a node.
    vectors : tuple of tuple of int
        Pairs of a node's coordinates that turn as a vector with the link.
    clamped : int
        The node's coordinate that a clamp holds besides the position: slope or rotation.
    deflection : int or None
        The node's coordinate across the link if its slope follows from it (no shear).
    has_angles : bool
        Whether a node's section is rigid and turns by an angle, with what sits off the neutral
        axis. Bodies at the nodes carry the link's mass then, with the rotary inertia of sections;
        otherwise the elements do, without it.
    """

    node: str
    element: str
    straight: tuple[float, ...]
    per_node: int
    vectors: tuple[tuple[int, int], ...]
    clamped: int
    deflection: int | None
    has_angles: bool

    def add_element(
        self,
        items: SystemItems,
        name: str,
        nodes: list[ItemNumber],
        length: float,
        section: BeamSection,
    ) -> ItemNumber:
        """Beam element between two nodes.

        Parameters
        ----------
        items : SystemItems
        name : str
        nodes : list of ItemNumber
            Coordinates of its two nodes.
        length : float
            In m.
        section : BeamSection

        Returns
        -------
        ItemNumber
        """
        return items.add(
            self.element,
            name,
            nodeNumbers=nodes,
            length=length,
            bendingStiffness=section.bending_stiffness,
            axialStiffness=section.axial_stiffness,
            bendingDamping=section.damping.bending * section.bending_stiffness,
            axialDamping=section.damping.axial * section.axial_stiffness,
            **self.further_values(section, length),
            **self.free_strains(section),
        )

    @abstractmethod
    def further_values(self, section: BeamSection, length: float) -> dict[str, float]:
        """Arguments of Exudyn's element of a length in m besides axial and bending stiffness."""

    def free_strains(self, section: BeamSection) -> dict[str, float]:
        """Strains of an element without stress, by their names in Exudyn."""
        return {"referenceCurvature": section.free_curvature}

    @abstractmethod
    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Displacement inside elements, (s, 2, 2 per_node) for places (s,)."""

    def rigid_fields(self, nodes: FloatArray) -> RigidFields:
        """Coordinates of a rigid link's accelerations."""
        along, across, centripetal, tangential = np.zeros((4, len(nodes), self.per_node))
        along[:, 0] = across[:, 1] = 1.0
        centripetal[:, 0] = tangential[:, 1] = nodes
        for slope, _ in self.vectors[1:]:
            centripetal[:, slope] = 1.0
        tangential[:, self.clamped] = 1.0
        return RigidFields(along.ravel(), across.ravel(), centripetal.ravel(), tangential.ravel())

    @abstractmethod
    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """The strains by which Exudyn's element stores energy, at its integration points.

        Parameters
        ----------
        displacement, rate : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link along x, and their
            time derivatives, in axes that may turn with the link.
        length : ndarray, shape (k - 1,)
            Length of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        list of Strain
        """

    def internal_force(
        self, displacement: FloatArray, length: FloatArray, section: BeamSection
    ) -> FloatArray:
        """Elastic forces on the nodes, the derivative of the strain energy.

        Parameters
        ----------
        displacement : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link.
        length : ndarray, shape (k - 1,)
            Length of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        ndarray, shape (m, k * per_node)
        """
        # Each force is the power of a unit rate, at every other node at once: no element has two.
        count, elements = self.per_node, len(length)
        node = np.arange(elements + 1)
        units = np.zeros((2, count, elements + 1, count))
        for unit in range(count):
            units[node % 2, unit, node, unit] = 1.0
        rates = np.tile(units.reshape(2 * count, -1), (len(displacement), 1))
        places = np.repeat(displacement, 2 * count, axis=0)
        powers = [one.element_power for one in self.strains(places, rates, length, section)]
        by_element = np.sum(powers, axis=0).reshape(-1, 2, count, elements)
        padded = np.pad(by_element, ((0, 0), (0, 0), (0, 0), (1, 1)))
        by_node = (padded[..., 1:] + padded[..., :-1])[:, node % 2, :, node]
        return np.asarray(np.moveaxis(by_node, 0, 1)).reshape(displacement.shape)

    def is_axial(self, count: int) -> NDArray[np.bool_]:
        """Whether coordinates of a chain of ``count`` nodes are displacements along its axis."""
        axial = np.zeros(self.per_node, dtype=bool)
        axial[[x for x, _ in self.vectors]] = True
        return np.tile(axial, count)

    def vector_pairs(self, count: int) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in a chain of ``count`` nodes."""
        base = self.per_node * np.arange(count)[:, None]
        pairs = np.array(self.vectors)
        return (base + pairs[:, 0]).ravel(), (base + pairs[:, 1]).ravel()


class AncfCable(BeamKind):
    """``ObjectANCFCable2D``: position and slope vector a node, no shear, no rotary inertia."""

    node = "NodePoint2DSlope1"
    element = "ObjectANCFCable2D"
    straight = (1.0, 0.0)
    per_node = 4
    vectors = ((0, 1), (2, 3))
    clamped = 3
    deflection = 1
    has_angles = False

    def further_values(self, section: BeamSection, length: float) -> dict[str, float]:
        """See :class:`BeamKind`."""
        return {"massPerLength": section.mass_per_length}

    def free_strains(self, section: BeamSection) -> dict[str, float]:
        """See :class:`BeamKind`."""
        return {"referenceAxialStrain": section.free_strain, **super().free_strains(section)}

    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Cubic Hermite in both directions; see :class:`BeamKind`."""
        [cubics] = hermite(fraction, np.broadcast_to(length, fraction.shape), 0)
        values = np.zeros((len(fraction), 2, 8))
        values[:, 0, 0::2] = values[:, 1, 1::2] = cubics
        return values

    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """Stretch ``|r'| - 1`` and curvature ``r' x r'' / |r'|**2``; see :class:`BeamKind`."""
        points, weights = np.polynomial.legendre.leggauss(AXIAL_POINTS)
        first = _cubic_derivatives(points, length)[0]
        turned, slope_rate = _interpolated(displacement, first), _interpolated(rate, first)
        slope = turned + ALONG
        norm = np.sqrt(_dot(slope, slope))
        stretch = Strain(
            # |r'| - 1 = (|r'|^2 - 1) / (|r'| + 1)
            value=(2 * turned[0] + _dot(turned, turned)) / (norm + 1) - section.free_strain,
            rate=_dot(slope, slope_rate) / norm,
            weight=section.axial_stiffness * length[:, None] / 2 * weights,
            damping_time=section.damping.axial,
        )
        points, weights = np.polynomial.legendre.leggauss(BENDING_POINTS)
        first, second = _cubic_derivatives(points, length)
        slope, slope_rate = _interpolated(displacement, first) + ALONG, _interpolated(rate, first)
        bend, bend_rate = _interpolated(displacement, second), _interpolated(rate, second)
        square = _dot(slope, slope)
        curvature = _cross(slope, bend) / square
        change = _cross(slope_rate, bend) + _cross(slope, bend_rate)
        bending = Strain(
            value=curvature - section.free_curvature,
            rate=(change - 2 * curvature * _dot(slope, slope_rate)) / square,
            weight=section.bending_stiffness * length[:, None] / 2 * weights,
            damping_time=section.damping.bending,
        )
        return [stretch, bending]


class GeometricallyExactBeam(BeamKind):
    """``ObjectBeamGeometricallyExact2D``: position and rotation a node, shear, rotary inertia.

    Its mass sits at the nodes; see :func:`add_node_bodies`.
    """

    node = "NodeRigidBody2D"
    element = "ObjectBeamGeometricallyExact2D"
    straight = (0.0,)
    per_node = 3
    vectors = ((0, 1),)
    clamped = 2
    deflection = None
    has_angles = True

    def further_values(self, section: BeamSection, length: float) -> dict[str, float]:
        """See :class:`BeamKind`."""
        [stiffness], [time] = element_shear(section, np.array([length]))
        return {"shearStiffness": float(stiffness), "shearDamping": float(time * stiffness)}

    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Linear in all coordinates; see :class:`BeamKind`."""
        values = np.zeros((len(fraction), 2, 6))
        for component in (0, 1):
            values[:, component, component] = 1 - fraction
            values[:, component, component + 3] = fraction
        return values

    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """Stretch, shear and curvature, all in the middle of the element; see :class:`BeamKind`.

        The shear contains what the element bends one way and back; see :func:`element_shear`.
        """
        nodes, node_rates = (v.reshape(len(v), -1, 3) for v in (displacement, rate))
        turn = (nodes[:, 1:, 2] + nodes[:, :-1, 2]) / 2
        spin = (node_rates[:, 1:, 2] + node_rates[:, :-1, 2]) / 2
        slope = np.moveaxis(np.diff(nodes, axis=1) / length[:, None], -1, 0)
        slope_rate = np.moveaxis(np.diff(node_rates, axis=1) / length[:, None], -1, 0)
        along = np.stack([np.cos(turn), np.sin(turn)])
        across = np.stack([-np.sin(turn), np.cos(turn)])
        # (e_x + u') . along = 1 + stretch, with cos(turn) - 1 = -2 sin(turn / 2)^2.
        stretch = _dot(slope, along) - 2 * np.sin(turn / 2) ** 2
        shear = _dot(slope, across) - np.sin(turn)
        damping, bend = section.damping, slope[2] - section.free_curvature
        stretching = _dot(slope_rate, along) + spin * shear
        shearing = _dot(slope_rate, across) - spin * (1 + stretch)
        kinds = (
            (stretch, stretching, section.axial_stiffness, damping.axial),
            (shear, shearing, *element_shear(section, length)),
            (bend, slope_rate[2], section.bending_stiffness, damping.bending),
        )
        return [
            Strain(value[..., None], change[..., None], (stiffness * length)[:, None], time)
            for value, change, stiffness, time in kinds
        ]


def element_shear(section: BeamSection, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shear stiffness of exact beam elements, ``1 / (1 / kGA + h^2 / (12 EI))``, and its damping.

    The element is linear, with its strains taken in the middle. Where the nodes of an element turn
    alike, its one strain is the shear, but a beam between these nodes bends besides, one way and
    back. Its flexibility is that of shear plus that of this bending (the residual bending
    flexibility of MacNeal, A simple quadrilateral shell element, Computers & Structures 8 (1978)
    175-183; Hughes, The Finite Element Method, 1987, sec. 5.4). With it the stiffness of a
    straight element is the exact one of Timoshenko's theory, for loads at nodes.

    Parameters
    ----------
    section : BeamSection
    length : ndarray, shape (e,)
        Length of the elements in m.

    Returns
    -------
    ndarray, shape (e,)
        Stiffness in N. What it strains is the shear angle of the section and the bending of the
        element together; their common shear force is right.
    ndarray, shape (e,)
        Kelvin-Voigt time in s. The two flexibilities have a time each: under one shear force their
        rates add up, and so do the losses.
    """
    shearing, times = 1 / section.shear_stiffness, section.damping
    bending = np.asarray(length**2 / (12 * section.bending_stiffness))
    both = shearing + bending
    return 1 / both, (times.shear * shearing + times.bending * bending) / both


BEAM_KINDS: dict[str, BeamKind] = {
    "ancf": AncfCable(),
    "geometrically-exact": GeometricallyExactBeam(),
}


def refuse_sections(mechanism: Mechanism, kind: str) -> None:
    """Refuse sections that an element cannot have.

    Parameters
    ----------
    mechanism : Mechanism
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.

    Raises
    ------
    InputError
        If the element would ignore that a section is eccentric, or stretches without load;
        names the links.
    """
    links = mechanism.linkage.topology.links
    sections = [(link.name, mechanism.sections[link.name]) for link in links if not link.rigid]
    eccentric = [name for name, section in sections if section.is_eccentric]
    stretched = [name for name, section in sections if section.free_strain]
    if eccentric and not BEAM_KINDS[kind].has_angles:
        raise InputError(
            f"the section of {', '.join(eccentric)} has its neutral axis or its centre of mass off "
            f"the pins' axis, which Exudyn's element {kind!r} cannot have; use element "
            "'geometrically-exact'"
        )
    if stretched and kind == "geometrically-exact":
        raise InputError(
            f"the section of {', '.join(stretched)} has a free_strain, which Exudyn's element "
            f"{kind!r} has no reference strain for; give the link its swollen length instead, or "
            "use element 'ancf'"
        )


def _cubic_derivatives(points: FloatArray, length: FloatArray) -> list[FloatArray]:
    """First and second derivatives of the cubics at points (g,) from -1 to 1, (e, g, 4)."""
    places = np.tile((points + 1) / 2, len(length)), np.repeat(length, len(points))
    return [shapes.reshape(len(length), len(points), 4) for shapes in hermite(*places, 2)[1:]]


def _interpolated(chain: FloatArray, shapes: FloatArray) -> FloatArray:
    """Vectors (2, m, e, g) from nodal positions and slopes (m, 4 (e + 1)).

    One product with all shapes, which are few, gives both components.
    """
    elements, points = shapes.shape[:2]
    matrix = np.zeros((elements + 1, 2, elements, points))
    for number, shape in enumerate(shapes):
        matrix[number : number + 2, :, number] = shape.T.reshape(2, 2, points)
    flat = matrix.reshape(2 * (elements + 1), -1)
    parts = [np.ascontiguousarray(chain[:, axis::2]) @ flat for axis in range(2)]
    return np.stack(parts).reshape(2, len(chain), elements, points)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def segment_inertia(section: BeamSection, positions: FloatArray) -> FloatArray:
    """Rotary inertia of a rigid segment around each node, as a line, in kg m^2, (e + 1,).

    Parameters
    ----------
    section : BeamSection
    positions : ndarray, shape (e + 1,)
        Positions of the nodes in m.
    """
    return section.mass_per_length * _halves(np.diff(positions) ** 3 / 12)


def add_node_bodies(
    items: SystemItems,
    link: str,
    nodes: list[ItemNumber],
    positions: FloatArray,
    section: BeamSection,
    point_masses: FloatArray,
    first: int,
) -> list[ItemNumber]:
    """Add bodies at the nodes of a link, and masses of the differences between nodes.

    Parameters
    ----------
    items : SystemItems
    link : str
        Name of the link.
    nodes : list of ItemNumber
    positions : ndarray, shape (e + 1,)
        Positions of the nodes along the link in m.
    section : BeamSection
    point_masses : ndarray, shape (e + 1,)
        On the pins' axis in kg; they interrupt the link.
    first : int
        First coordinate of the link in the system.

    Returns
    -------
    list of ItemNumber
        Numbers of the bodies.
    """
    length, per_length = np.diff(positions), section.mass_per_length
    soft = section.bending_stiffness / section.shear_stiffness
    # Mass of each node, and its first moment along the link about the node.
    share, along = per_length * _halves(length), np.zeros(len(positions))
    velocity = per_length * length / 12
    for start, last in _uniform_pieces(length, point_masses):
        for end, inwards in ((start, 1), (last, -1)):
            element = min(end, end + inwards)
            moved = per_length * length[element] / 24
            share[[end, end + inwards]] += [-moved, moved]
            along[end] += inwards * moved * length[element]
            velocity[element] += moved
    rotary = section.rotary_inertia * _halves(length) + segment_inertia(section, positions)
    velocity = _kept(section, float(length.min())) * velocity
    spin = soft * per_length * length / 12
    at, pins = section.mass_axis - section.neutral_axis, -section.neutral_axis
    mass = share + point_masses
    across = share * at + point_masses * pins
    inertia = rotary + share * at**2 + point_masses * pins**2
    items.begin(f"{link}: bodies at the nodes, which carry its mass and point masses")
    values = np.stack([mass, along / mass, across / mass, inertia], axis=1).tolist()
    bodies = [
        items.add_body(f"{link}_body_{i}", node, first + 3 * i, m, (x, y), about).number
        for i, (node, (m, x, y, about)) in enumerate(zip(nodes, values, strict=True))
    ]
    items.begin(f"{link}: mass by the differences between nodes, for fourth order")
    differences = zip(pairwise(nodes), velocity, spin, strict=True)
    for number, (pair, less, more) in enumerate(differences):
        matrix = Made(difference_mass, (-float(less), float(more)))
        items.add_mass(f"{link}_difference_{number}", list(pair), first + 3 * number, matrix)
    return bodies


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
