"""A mechanism: a linkage, a section for each link, point masses and surroundings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages import CouplerPoint, Linkage, LinkMass
from flexmech.materials import REFERENCE_TEMPERATURE
from flexmech.materials.moisture import Faces
from flexmech.sections import BeamSection

__all__ = ["Mechanism", "PointMass", "Provenance", "Wetting"]


@dataclass(frozen=True)
class PointMass:
    """A point mass in kg on a link, ``position`` m from the link's start."""

    link: str
    position: float
    mass: float


@dataclass(frozen=True)
class Wetting:
    """Where water can enter a link.

    Parameters
    ----------
    faces : {"both", "lower", "upper"}
        Faces that look to the sides of the link in the linkage's plane; lower is that of the
        lowest y of the link's frame.
    sides : bool
        Whether water enters across the joint axes too.
    """

    faces: Faces = "both"
    sides: bool = False


@dataclass(frozen=True)
class Provenance:
    """Where a mechanism came from.

    Parameters
    ----------
    name : str
        Short name, used in titles.
    source : str
        Publication or drawing.
    file : str
        Model file's name, empty when built in Python.
    sha256 : str
        Hash of the model file's bytes, empty when built in Python.
    """

    name: str = "mechanism"
    source: str = ""
    file: str = ""
    sha256: str = ""


@dataclass(frozen=True)
class Mechanism:
    """Everything that an engine needs to know.

    Parameters
    ----------
    linkage : Linkage
    sections : mapping of str to BeamSection
        One for each link of the topology.
    joint_masses : mapping of str to float
        Point masses in kg at joints, by joint name.
    link_masses : tuple of PointMass
        Point masses along links.
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    operating_speeds : tuple of float
        Crank speeds in rad/s that the mechanism is meant for.
    provenance : Provenance
    coupler_point : CouplerPoint, optional
        Point of the coupler whose path matters.
    reference_temperature : float
        Temperature in K at which lengths, sections and masses are as stated.
    ground_thermal_expansion : float
        Of the frame between the ground pivots in 1/K.
    wetting : mapping of str to Wetting
        Where water enters links, by name; through both faces of those left out.

    Raises
    ------
    InputError
        If a link has no section, a mass is negative or off its link, a name is unknown, or a
        number of its surroundings cannot be.
    """

    linkage: Linkage
    sections: Mapping[str, BeamSection]
    joint_masses: Mapping[str, float] = field(default_factory=dict)
    link_masses: tuple[PointMass, ...] = ()
    gravity: tuple[float, float] = (0.0, 0.0)
    operating_speeds: tuple[float, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)
    coupler_point: CouplerPoint | None = None
    reference_temperature: float = REFERENCE_TEMPERATURE
    ground_thermal_expansion: float = 0.0
    wetting: Mapping[str, Wetting] = field(default_factory=dict)

    def __post_init__(self) -> None:
        topology = self.linkage.topology
        if set(self.sections) != set(topology.link_names):
            raise InputError(
                f"sections are given for {sorted(self.sections)}, the links are "
                f"{sorted(topology.link_names)}; give one section for each link"
            )
        for joint, mass in self.joint_masses.items():
            if joint not in topology.joint_names:
                raise InputError(
                    f"joint_masses: unknown joint {joint!r}; joints are {topology.joint_names}"
                )
            if not (np.isfinite(mass) and mass >= 0):
                raise InputError(f"joint_masses: {joint} must be zero or positive, got {mass} kg")
        for point in self.link_masses:
            self._check_point(point)
        if not np.all(np.isfinite(self.gravity)):
            raise InputError(f"gravity must be finite, got {self.gravity}")
        if not (np.isfinite(self.reference_temperature) and self.reference_temperature > 0):
            raise InputError(
                f"reference_temperature must be above 0 K, got {self.reference_temperature} K"
            )
        if not np.isfinite(self.ground_thermal_expansion):
            raise InputError(
                f"ground_thermal_expansion must be a number, got {self.ground_thermal_expansion}"
            )
        for name in self.wetting:
            if name not in topology.link_names:
                raise InputError(f"wetting: unknown link {name!r}; links are {topology.link_names}")

    def _check_point(self, point: PointMass) -> None:
        topology = self.linkage.topology
        if point.link not in topology.link_names:
            raise InputError(
                f"link_masses: unknown link {point.link!r}; links are {topology.link_names}"
            )
        length = topology.links[topology.index(point.link)].length
        if not 0 <= point.position <= length:
            raise InputError(
                f"link_masses: position {point.position:g} m is not on the {point.link} "
                f"(0 to {length:g} m)"
            )
        if not (np.isfinite(point.mass) and point.mass >= 0):
            raise InputError(
                f"link_masses: mass on the {point.link} must be zero or positive, "
                f"got {point.mass} kg"
            )

    def link_mass(self, link: str) -> LinkMass:
        """Mass of one link with its point masses and those of the joints that it leads."""
        topology = self.linkage.topology
        length = topology.links[topology.index(link)].length
        points = [(p.position, p.mass) for p in self.link_masses if p.link == link and p.mass > 0]
        for joint, mass in self.joint_masses.items():
            place = topology.joints[joint]
            if place.link == link and mass > 0:
                points.append((0.0 if place.end == "start" else length, mass))
        points.sort()
        return LinkMass(
            length=length,
            mass_per_length=self.sections[link].mass_per_length,
            point_positions=tuple(p for p, _ in points),
            point_masses=tuple(m for _, m in points),
            offset=self.sections[link].mass_axis,
        )

    def wetting_of(self, link: str) -> Wetting:
        """Where water enters a link."""
        return self.wetting.get(link, Wetting())

    @property
    def is_eccentric(self) -> bool:
        """Whether a link's neutral axis or centre of mass is off the pins' axis."""
        return any(section.is_eccentric for section in self.sections.values())

    @property
    def is_free_strained(self) -> bool:
        """Whether a link stretches or bends without load."""
        return any(section.is_free_strained for section in self.sections.values())

    @property
    def link_masses_in_order(self) -> tuple[LinkMass, ...]:
        """:meth:`link_mass` of every link of the topology."""
        return tuple(self.link_mass(name) for name in self.linkage.topology.link_names)
