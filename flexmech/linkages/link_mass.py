"""Mass of a link: distributed, in points, and in attached bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages.topology import Topology
from flexmech.validation import NOT_NEGATIVE, check_number

MassMoments = tuple[FloatArray, ComplexArray, FloatArray]
"""Mass, first moment along and across a link, and polar second moment about its start."""

LEAST_DISTANCE = 1 / 500
"""Least distance of point masses, bodies, loads and springs from each other, in lengths of their
link: a beam element as short is 1e8 times as stiff as the link, and eight of sixteen digits are
left for its lowest frequencies."""


@dataclass(frozen=True)
class LinkBody:
    """A rigid body that is fixed to the axis of a link.

    Parameters
    ----------
    position : float
        Distance from the link's start of the section that it is fixed to, in m.
    mass : float
        In kg.
    inertia : float
        About its own centre of mass, in kg m^2.
    offset : tuple of float
        From the axis at ``position`` to its centre of mass, along and across the link, in m.

    Raises
    ------
    InputError
        If its mass or inertia is negative.
    """

    position: float
    mass: float
    inertia: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_number(self.mass, "mass of a body", "kg", NOT_NEGATIVE)
        check_number(self.inertia, "inertia of a body", "kg m^2", NOT_NEGATIVE)

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of mass along and across the link, from the link's start, in m."""
        return self.position + self.offset[0], self.offset[1]

    def fixed_at(self, position: float) -> LinkBody:
        """The body fixed to another section of the link."""
        along, across = self.offset
        return replace(self, position=position, offset=(along + self.position - position, across))


@dataclass(frozen=True)
class LinkMass:
    """Mass of one link: distributed, point masses on its axis, and attached bodies.

    Parameters
    ----------
    length : float
        In m.
    mass_per_length : float
        Distributed mass in kg/m.
    point_positions, point_masses : tuple of float
        Point masses in kg and their distances from the link's start in m.
    offset : float
        Distance of the distributed mass from the line between the ends in m.
    bodies : tuple of LinkBody
        Rigid bodies that are fixed to the link.
    rotary_inertia : float
        Rotary inertia of the sections per length, about the axis of the distributed mass, in kg m.
    """

    length: float
    mass_per_length: float
    point_positions: tuple[float, ...] = ()
    point_masses: tuple[float, ...] = ()
    offset: float = 0.0
    bodies: tuple[LinkBody, ...] = ()
    rotary_inertia: float = 0.0

    @classmethod
    def of_points(
        cls,
        length: float,
        mass_per_length: float,
        points: Sequence[tuple[float, float]],
        offset: float = 0.0,
        bodies: Sequence[LinkBody] = (),
        rotary_inertia: float = 0.0,
    ) -> LinkMass:
        """Mass of a link with points far enough apart for a beam element between them.

        Points nearer to each other than 1/500 of the link's length become one at their centre of
        mass, and one nearer to an end is shared between the end and that distance as a lever
        would. Mass and first moment stay; the polar second moment changes by less than 1e-6 of
        the points' mass times the length squared. A shorter element would be more than 1e8 times
        as stiff as the link, and round-off of its stiffness would blur the lowest frequencies.
        A body that is fixed so near to an end, a point or another body is fixed there instead;
        its centre of mass stays where it is.

        Parameters
        ----------
        length, mass_per_length, offset, rotary_inertia : float
            As in :class:`LinkMass`.
        points : sequence of (float, float)
            Distance from the link's start in m and mass in kg, in any order.
        bodies : sequence of LinkBody
            In any order.
        """
        least = LEAST_DISTANCE * length
        apart: list[tuple[float, float]] = []
        for position, mass in sorted(_away_from_ends(points, length, least)):
            where, total = position, mass
            inside = apart and apart[-1][0] > 0 and position < length
            if inside and position - apart[-1][0] < least:
                before, other = apart.pop()
                total = other + mass
                where = (before * other + position * mass) / total
            apart.append((where, total))
        positions, masses = zip(*apart, strict=True) if apart else ((), ())
        places = [0.0, length, *positions]
        fixed = []
        for body in sorted(bodies, key=lambda body: body.position):
            nearest = min(places, key=lambda place: abs(place - body.position))
            near = abs(nearest - body.position) < least
            fixed.append(body.fixed_at(nearest) if near else body)
            places.append(fixed[-1].position)
        points_apart = (positions, masses, offset, tuple(fixed))
        return cls(length, mass_per_length, *points_apart, rotary_inertia)

    def before(self, place: FloatArray) -> MassMoments:
        """Mass and moments of the part of the link before cuts.

        Parameters
        ----------
        place : ndarray, shape () or (k,)
            Distances from the link's start in m; a point mass or body exactly there is beyond the
            cut.

        Returns
        -------
        tuple of ndarray, shape () or (k,)
            Mass in kg, first moment about the link's start as a complex number, along and across
            the link, in kg m, and polar second moment in kg m^2.
        """
        return self._moments(place, place)

    @property
    def moments(self) -> MassMoments:
        """Mass and moments of the whole link, as in :meth:`before`."""
        return self._moments(np.asarray(self.length), np.asarray(np.inf))

    def _moments(self, place: FloatArray, reach: FloatArray) -> MassMoments:
        """Distributed mass up to places, and points and bodies before others."""
        mass: FloatArray = self.mass_per_length * place
        first: ComplexArray = mass * (place / 2 + 1j * self.offset)
        second = mass * (place**2 / 3 + self.offset**2) + self.rotary_inertia * place
        points = zip(self.point_positions, self.point_masses, strict=True)
        lumps = [(x, complex(x), lump, 0.0) for x, lump in points]
        for body in self.bodies:
            lumps.append((body.position, complex(*body.centre), body.mass, body.inertia))
        for at, centre, lump, inertia in lumps:
            passed = at < reach
            mass = mass + passed * lump
            first = first + passed * lump * centre
            second = second + passed * (lump * np.abs(centre) ** 2 + inertia)
        return mass, first, second

    @property
    def moment_across(self) -> float:
        """First moment of mass about the line between the ends in kg m."""
        return float(self.moments[1].imag)

    def moment(self, order: int) -> float:
        """Mass in kg, first moment along the link in kg m or polar second moment in kg m^2.

        Parameters
        ----------
        order : {0, 1, 2}
            The second moment is about the link's start, with what lies off the axis and with the
            rotary inertia of the sections.
        """
        return float(np.real(self.moments[order]))

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of mass along and across the link in m; its middle where it has no mass."""
        mass = self.moment(0)
        if mass == 0:
            return self.length / 2, 0.0
        return self.moment(1) / mass, self.moment_across / mass

    @property
    def section_inertia(self) -> float:
        """Rotary inertia of all sections in kg m^2, each about its own centre of mass."""
        return self.rotary_inertia * self.length

    @property
    def central_inertia(self) -> float:
        """Polar second moment about the centre of mass in kg m^2."""
        along, across = self.centre
        return self.moment(2) - self.moment(0) * (along**2 + across**2)

    def lumps(self, elements: int) -> list[tuple[float, float]]:
        """Places and sizes of the distributed mass in equal segments, halved onto their ends.

        Parameters
        ----------
        elements : int
            Number of segments, at least one.

        Returns
        -------
        list of (float, float)
            Distance from the link's start in m and mass in kg of each, one more than segments;
            none where no mass is distributed.
        """
        if not self.mass_per_length:
            return []
        share = self.mass_per_length * self.length / elements
        halves = [share / 2, *[share] * (elements - 1), share / 2]
        return [(self.length * n / elements, mass) for n, mass in enumerate(halves)]

    def lumped(self, elements: int) -> LinkMass:
        """The link with its distributed mass lumped in points.

        Kumar & Chandrakar, Figure 1.5: one element of the crank and four of the coupler and of
        the rocker give twelve lumped masses. Mass and first moments stay; the second moment
        grows by ``mass * length**2 / (6 * elements**2)`` and loses the rotary inertia of the
        sections, which points have not.

        Parameters
        ----------
        elements : int
            As in :meth:`lumps`.

        Returns
        -------
        LinkMass
        """
        lumps = self.lumps(elements)
        if not lumps:
            return self
        if self.offset:
            bodies = [LinkBody(x, mass, offset=(0.0, self.offset)) for x, mass in lumps]
            every = (*bodies, *self.bodies)
            return replace(self, mass_per_length=0.0, offset=0.0, bodies=every, rotary_inertia=0.0)
        places, masses = zip(*lumps, strict=True)
        return replace(
            self,
            mass_per_length=0.0,
            point_positions=(*places, *self.point_positions),
            point_masses=(*masses, *self.point_masses),
            rotary_inertia=0.0,
        )


def lumped_elements(topology: Topology) -> tuple[int, ...]:
    """Elements of each link whose mass is lumped as Kumar & Chandrakar have it.

    Their crank has one element, coupler and rocker have four (Figure 1.5). In any linkage a clamped
    link to which another one is pinned has one and every other link four.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    tuple of int
    """
    clamped = {clamp.link_end.link for clamp in topology.clamps}
    leading = {pin.leader.link for pin in topology.pins}
    return tuple(1 if name in clamped & leading else 4 for name in topology.link_names)


def _away_from_ends(
    points: Sequence[tuple[float, float]], length: float, least: float
) -> Iterator[tuple[float, float]]:
    """Points, those near an end split between the end and the least distance from it."""
    for position, mass in points:
        for end, inner in ((0.0, least), (length, length - least)):
            share = (position - end) / (inner - end)
            if 0 < share < 1:
                yield end, mass * (1 - share)
                yield inner, mass * share
                break
        else:
            yield position, mass
