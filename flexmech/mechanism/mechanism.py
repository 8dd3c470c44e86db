"""A mechanism: a linkage, a section for each link, point masses, and how water enters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from numpy.typing import ArrayLike

from flexmech import units
from flexmech.errors import InputError
from flexmech.linkages import (
    CouplerPoint,
    Drive,
    InverseDynamics,
    JointSpring,
    Linkage,
    LinkBody,
    LinkMass,
    Load,
    MotorDrive,
    PlanarLink,
    PlanarLinkage,
    RigidMotion,
    Spring,
    Topology,
    continuous_angles,
    inverse_dynamics,
)
from flexmech.materials import REFERENCE_TEMPERATURE
from flexmech.mechanism.checks import (
    PARTS,
    check_frame,
    check_joint_masses,
    check_shaft,
    check_wetting,
    checked_parts,
    checked_speeds,
    places_apart,
    sprung_linkage,
)
from flexmech.mechanism.drawing import notebook_html, part_lines
from flexmech.mechanism.parts import (
    AttachedBody,
    JointPin,
    PointMass,
    Provenance,
    SprungFrame,
    Wetting,
)
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.sections import BeamSection, Layers, sections_between_joints
from flexmech.units import from_si, to_si
from flexmech.validation import POSITIVE, check_instance, check_number, check_pair


@dataclass(frozen=True)
class Mechanism:
    """Everything that an engine needs to know.

    Parameters
    ----------
    linkage : Linkage
        Its joints that have a radial stiffness among the ``joint_springs`` have no rigid bearing.
    sections : mapping of str to BeamSection
        One for each link of the topology; a rigid link may do without, and has the mass of
        its ``bodies`` then.
    joint_masses : mapping of str to float
        Point masses in kg at joints, by joint name.
    link_masses : tuple of PointMass
        Point masses along links; kept in the order of the links.
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    operating_speeds : tuple of float
        Crank speeds that the mechanism is meant for: in rad/s, whatever ``speed_unit`` is.
    provenance : Provenance
    coupler_point : CouplerPoint, optional
        Point of the coupler whose path matters.
    reference_temperature : float
        Temperature in K at which lengths, sections and masses are as stated.
    ground_thermal_expansion : float
        Thermal expansion of the frame between the ground pivots in 1/K.
    wetting : mapping of str to Wetting
        Where water enters links, by name; through both faces of those left out. Links that
        are wet through both faces are not kept.
    bodies : tuple of AttachedBody
        Rigid bodies that are fixed to links; kept in the order of the links.
    loads : tuple of Load
        Forces and torques on links.
    springs : tuple of Spring
        Between points of links and the ground.
    joint_springs : tuple of JointSpring
        Springs and dampers in pins and pivots.
    joint_pins : tuple of JointPin
        Sizes of pins, pivots and the pins of sliders, for their strength.
    shaft_inertia : float
        Inertia of the shaft that drives the crank, about its axis, in kg m^2.
    drive : Drive or MotorDrive, optional
        How the crank turns, or by which motor; runs take it where no speed is asked for.
    frame : SprungFrame, optional
        Rigid frame on springs that carries the linkage; it does not move where left out.
    speed_unit : str
        In which results speak of crank speeds that nobody typed: that of the last speed of a
        model file. It does not count in comparisons.

    Raises
    ------
    InputError
        If an elastic link has no section, a mass is negative or off its link, a name is
        unknown, or a number is out of its range.

    Examples
    --------
    >>> section = flexmech.BeamSection.rectangle(flexmech.Material(200e9, 7800.0), 4e-3, 20e-3)
    >>> linkage = flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
    >>> links = ("crank", "coupler", "rocker")
    >>> flexmech.Mechanism(linkage, dict.fromkeys(links, section), joint_masses={"A": 0.02})
    <Mechanism: mechanism, four-bar, crank 102 mm, coupler 279.4 mm, rocker 266.7 mm>
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
    bodies: tuple[AttachedBody, ...] = ()
    loads: tuple[Load, ...] = ()
    springs: tuple[Spring, ...] = ()
    joint_springs: tuple[JointSpring, ...] = ()
    joint_pins: tuple[JointPin, ...] = ()
    shaft_inertia: float = 0.0
    drive: Drive | MotorDrive | None = None
    frame: SprungFrame | None = None
    speed_unit: str = field(default=units.ANGULAR_SPEED.unit, compare=False)

    def __post_init__(self) -> None:
        topology = self._checked_topology()
        check_joint_masses(topology, self.joint_masses)
        for name in PARTS:
            object.__setattr__(self, name, checked_parts(topology, name, getattr(self, name)))
        object.__setattr__(self, "linkage", sprung_linkage(self.linkage, self.joint_springs))
        check_pair(self.gravity, "gravity", "m/s^2")
        check_shaft(self.shaft_inertia, self.drive)
        check_frame(self.frame)
        object.__setattr__(self, "operating_speeds", checked_speeds(self.operating_speeds))
        try:
            to_si(1.0, self.speed_unit, units.ANGULAR_SPEED)
        except InputError as error:
            raise error.within("speed_unit") from error
        check_number(self.reference_temperature, "reference_temperature", "K", POSITIVE)
        check_number(self.ground_thermal_expansion, "ground_thermal_expansion", "1/K")
        if self.coupler_point is not None and "coupler" not in topology.link_names:
            raise InputError(
                f"coupler_point: the linkage has no coupler; its links are {topology.link_names}"
            )
        check_wetting(topology, self.wetting)
        self._unite_spellings()

    def _checked_topology(self) -> Topology:
        """Topology of the linkage, which has one section for each link."""
        topology = getattr(self.linkage, "topology", None)
        if not isinstance(topology, Topology):
            raise InputError(
                f"linkage must be a linkage such as FourBar or RotatingArm, got {self.linkage!r}"
            )
        check_instance(self.sections, Mapping, "sections", "give a section for each link by name")
        elastic = {link.name for link in topology.links if not link.rigid}
        if not elastic <= set(self.sections) <= set(topology.link_names):
            raise InputError(
                f"sections are given for {sorted(self.sections)}, the links are "
                f"{sorted(topology.link_names)}; give one section for each link"
                + ("" if len(elastic) == len(topology.links) else " that is not rigid")
            )
        for name, section in self.sections.items():
            remedy = "make one, as with BeamSection.rectangle"
            check_instance(section, BeamSection, f"section of the {name}", remedy)
        check_instance(self.provenance, Provenance, "provenance", "give Provenance(name, source)")
        return topology

    def _unite_spellings(self) -> None:
        """Keep equivalent entries in one form, so that equal mechanisms compare equal."""
        topology = self.linkage.topology
        links, joints = topology.link_names, topology.joint_names
        kept: dict[str, Any] = {
            "sections": sections_between_joints(topology, self.sections),
            "link_masses": sorted(self.link_masses, key=lambda mass: links.index(mass.link)),
            "bodies": sorted(self.bodies, key=lambda body: links.index(body.link)),
            "joint_springs": sorted(
                self.joint_springs, key=lambda spring: joints.index(spring.joint)
            ),
            "joint_pins": sorted(self.joint_pins, key=lambda pin: joints.index(pin.joint)),
            "gravity": self.gravity,
            "wetting": {
                link: wetting for link, wetting in self.wetting.items() if wetting != Wetting()
            },
        }
        for name, value in kept.items():
            if not isinstance(value, Mapping):
                value = tuple(value)
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        links = (f"{x.name} {x.length * 1e3:.6g} mm" for x in self.linkage.topology.links)
        kind = getattr(self.linkage, "kind", type(self.linkage).__name__)
        return short_repr(self, f"{self.provenance.name:.60}", kind, *links)

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def link_mass(self, link: str) -> LinkMass:
        """Mass of one link with its point masses, bodies and the joints that it leads or slides."""
        topology = self.linkage.topology
        length = topology.links[topology.index(link)].length
        points = [(p.position, p.mass) for p in self.link_masses if p.link == link and p.mass > 0]
        for joint, mass in self.joint_masses.items():
            place = topology.joints[joint]
            if place.link == link and mass > 0:
                points.append((0.0 if place.end == "start" else length, mass))
        bodies = [
            LinkBody(body.position, body.mass, body.inertia, body.offset)
            for body in self.bodies
            if body.link == link
        ]
        section = self.sections.get(link)
        if section is None:
            return LinkMass.of_points(length, 0.0, points, bodies=bodies)
        mass, axis, rotary = section.mass_per_length, section.mass_axis, section.rotary_inertia
        return LinkMass.of_points(length, mass, points, axis, bodies, rotary)

    def inverse_dynamics(
        self, motion: RigidMotion, time: ArrayLike = 0.0, lumped: Sequence[int] | None = None
    ) -> InverseDynamics:
        """Forces in the rigid linkage under everything that acts on it.

        Parameters
        ----------
        motion : RigidMotion
            Motion of the linkage.
        time : array_like, shape (...)
            Time of each position in s, for loads over time.
        lumped : sequence of int, optional
            Number of elements of each link whose distributed mass is lumped at their ends.

        Returns
        -------
        InverseDynamics

        Raises
        ------
        InputError
            If the connections do not determine the forces, or a spring has no direction.
        """
        masses = self.link_masses_in_order
        if lumped is not None:
            masses = tuple(mass.lumped(n) for mass, n in zip(masses, lumped, strict=True))
        turning = any(spring.torsional_stiffness for spring in self.joint_springs)
        return inverse_dynamics(
            self.linkage.topology,
            motion,
            masses,
            self.gravity,
            loads=self.loads,
            springs=self.springs,
            joint_springs=self.joint_springs,
            time=time,
            continuous_angles=continuous_angles(self.linkage, motion) if turning else None,
        )

    @property
    def links_with_sections(self) -> tuple[str, ...]:
        """Links whose section is stated, in order: all but some that are rigid."""
        return tuple(name for name in self.linkage.topology.link_names if name in self.sections)

    def layers_of(self, link: str) -> Layers | None:
        """Layers of a link's section; None where they are not known, or it has no section."""
        section = self.sections.get(link)
        return None if section is None else section.layers

    def acting_at(self, link: str) -> list[float]:
        """Where loads and springs act on a link, m from its start, apart from masses and ends."""
        points = [load.point for load in self.loads]
        points += [point for spring in self.springs for point in (spring.first, spring.second)]
        mass = self.link_mass(link)
        taken = [*mass.point_positions, *(body.position for body in mass.bodies)]
        return places_apart(points, link, mass.length, taken)

    @property
    def without_loads_over_time(self) -> Mechanism:
        """The mechanism at rest or in steady motion: loads over time are left out."""
        kept = tuple(load for load in self.loads if load.over != "time")
        return self if len(kept) == len(self.loads) else replace(self, loads=kept)

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

    @cached_property
    def link_masses_in_order(self) -> tuple[LinkMass, ...]:
        """:meth:`link_mass` of every link of the topology."""
        return tuple(self.link_mass(name) for name in self.linkage.topology.link_names)

    @property
    def total_mass(self) -> float:
        """Mass in kg of all links, with the point masses along them and at their joints."""
        return sum(link.moment(0) for link in self.link_masses_in_order)

    def described(self) -> list[str]:
        """Masses, bodies, loads, gravity, operating speeds and coupler point, a line each."""
        x, y = self.gravity
        speeds = ", ".join(f"{from_si(w, self.speed_unit):.6g}" for w in self.operating_speeds)
        inertia = self.shaft_inertia
        turning = {
            "shaft": f"{inertia:.6g} kg m^2" if inertia else "",
            "drive": "" if self.drive is None else self.drive.words,
            "frame": "" if self.frame is None else self.frame.words,
        }
        lines = [
            *part_lines(*(getattr(self, name) for name in ("joint_masses", *PARTS))),
            *(f"{kind}: {words}" for kind, words in turning.items() if words),
            f"total mass: {1e3 * self.total_mass:.6g} g",
            f"gravity: ({x:g}, {y:g}) m/s^2",
            f"operating speeds: {f'{speeds} {self.speed_unit}' if speeds else 'none stated'}",
        ]
        if (point := self.coupler_point) is not None:
            place = f"{1e3 * point.distance:.6g} mm from A, {math.degrees(point.angle):.6g} deg"
            lines.append(f"coupler point: {place}")
        return lines

    def to_toml(self) -> str:
        """Write a model file that loads back equal.

        Returns
        -------
        str
            TOML. Every number reads back to the last bit; what can be said in several ways is
            written resolved, such as a damping ratio as a damping time. Notes and comments of
            a file that the mechanism came from are not in it.
        """
        import tomli_w

        shared = SharedTables()
        links = self._links_table(shared)
        linkage = self.linkage.to_table()
        if self.ground_thermal_expansion:
            expansion = quantity(self.ground_thermal_expansion, units.EXPANSION)
            linkage["ground_thermal_expansion"] = expansion
        if self.coupler_point is not None:
            linkage["coupler_point"] = self.coupler_point.to_table()
        document: TomlTable = {
            "name": self.provenance.name,
            "source": self.provenance.source,
            "linkage": linkage,
            **shared.in_order,
            "links": links,
        }
        environment: TomlTable = {}
        if any(self.gravity):
            environment["gravity"] = [quantity(along, units.ACCELERATION) for along in self.gravity]
        if self.reference_temperature != REFERENCE_TEMPERATURE:
            kept = quantity(self.reference_temperature, units.TEMPERATURE)
            environment["reference_temperature"] = kept
        speeds = [quantity(speed, units.ANGULAR_SPEED) for speed in self.operating_speeds[:-1]]
        for last in self.operating_speeds[-1:]:
            speeds.append(quantity(last, units.ANGULAR_SPEED, self.speed_unit, always=True))
        inertia = self.shaft_inertia
        optional = {
            "joints": self._joints_table(),
            "shaft": {"inertia": quantity(inertia, units.INERTIA)} if inertia else {},
            "drive": {} if self.drive is None else self.drive.to_table(),
            "frame": {} if self.frame is None else self.frame.to_table(),
            "loads": _by_name("loads", [(load.name, load.to_table()) for load in self.loads]),
            "springs": _by_name(
                "springs", [(spring.name, spring.to_table()) for spring in self.springs]
            ),
            "environment": environment,
            "operation": {"crank_speeds": speeds} if speeds else {},
        }
        return tomli_w.dumps(document | {key: table for key, table in optional.items() if table})

    def _links_table(self, shared: SharedTables) -> TomlTable:
        """Table ``[links]``; tables that several links name are put among the shared ones."""
        drawn = self.linkage.links if isinstance(self.linkage, PlanarLinkage) else ()
        keys = {link.name: _drawn_keys(link) for link in drawn}
        beams_of = {link.name: [beam.name for beam in link.beams] for link in drawn}
        single = {name: [name] for name in self.linkage.topology.link_names}
        tables: TomlTable = {}
        for name, beams in (beams_of or single).items():
            sections = [self._beam_table(beam, shared) for beam in beams]
            tables[name] = keys.get(name, {}) | sections[0]
            for key, parts in (("point_masses", self.link_masses), ("bodies", self.bodies)):
                entries = [
                    attached.to_table()
                    | ({"beam": beams.index(attached.link) + 1} if beams[1:] else {})
                    for attached in parts
                    if attached.link in beams
                ]
                tables[name] |= {key: entries} if entries else {}
            further = zip(beams[1:], sections[1:], strict=True)
            tables |= {beam: table for beam, table in further if table != sections[0]}
        return tables

    def _beam_table(self, beam: str, shared: SharedTables) -> TomlTable:
        """Keys of a beam's section and of where water enters it."""
        section = self.sections.get(beam)
        table: TomlTable = {} if section is None else section.to_table(shared)
        return table | self.wetting_of(beam).to_table()

    def _joints_table(self) -> TomlTable:
        """Table ``[joints]``; empty where no joint is drawn, has mass, a spring or a diameter."""
        drawn = self.linkage.joints if isinstance(self.linkage, PlanarLinkage) else ()
        tables: dict[str, TomlTable] = {joint.point: joint.to_table() for joint in drawn}
        masses = {
            name: {"mass": quantity(mass, units.MASS)} for name, mass in self.joint_masses.items()
        }
        springs = [(spring.joint, spring.to_table()) for spring in self.joint_springs]
        pins = [(pin.joint, pin.to_table()) for pin in self.joint_pins]
        for keys in (masses, _by_name("joint_springs", springs), _by_name("joint_pins", pins)):
            for joint, table in keys.items():
                tables.setdefault(joint, {}).update(table)
        return tables


def _drawn_keys(link: PlanarLink) -> TomlTable:
    """Keys of a drawn link besides its section."""
    return {"points": list(link.points), **({"rigid": True} if link.rigid else {})}


def _by_name(what: str, entries: Iterable[tuple[str, TomlTable]]) -> TomlTable:
    """Tables by name; a model file has one of a name."""
    tables: TomlTable = {}
    for name, table in entries:
        if name in tables:
            raise InputError(f"{what}: {name!r} is there twice, a model file has one of a name")
        tables[name] = table
    return tables
