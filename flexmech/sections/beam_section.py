"""A beam section: stiffness, mass and damping per length."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmech import si, units
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import Topology
from flexmech.linkages.topology import LinkEnd
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr, stated
from flexmech.sections.beam_reduction import ThirdOrder, Zigzag, rectangular_zigzag
from flexmech.sections.damping import DampingTimes, SpecificDamping
from flexmech.sections.laminate_section import LaminateSection
from flexmech.sections.sheet_section import SheetSection
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_instance,
    check_number,
)

Layers = LaminateSection | SheetSection

# Values that go with the layers, and the place that follows from two of these.
_STIFFNESSES = ("axial_stiffness", "bending_stiffness", "shear_stiffness")
_INERTIAS = ("mass_per_length", "rotary_inertia")
_NEUTRAL_AXIS = "neutral_axis"
UNDAMPED = DampingTimes(stated=False)
# Shear stiffness over EI / length^2 of a link, in elements that shear, that has none: its n-th
# frequency is low by (n pi)^2 / 2 over it, 5e-6 n^2. Round-off grows with the square of it, to 1e-4
# with ten times as much (16 elements).
MOST_SHEAR_STIFFNESS = 1e6


@dataclass(frozen=True)
class BeamSection:
    """Stiffness, mass and damping of a beam per length, for bending in the linkage's plane.

    The pins sit on the section's reference axis. An unsymmetric section has its neutral axis
    and its centre of mass off it, at distances along the link frame's y.

    Parameters
    ----------
    axial_stiffness : float
        EA in N.
    bending_stiffness : float
        EI about the neutral axis in N m^2.
    shear_stiffness : float
        kGA in N, with the shear correction factor k; ``math.inf`` of a beam that does not shear.
    mass_per_length : float
        rho A in kg/m.
    rotary_inertia : float
        rho I about the mass axis in kg m, mass moment of inertia per length.
    in_plane_thickness : float
        Extent of the section in m in the linkage's plane.
    neutral_axis : float
        Distance of the neutral axis from the line of the pins in m, to the left positive: an axial
        force on it does not bend.
    mass_axis : float
        Distance of the centre of mass from the line of the pins in m, to the left positive.
    damping : DampingTimes
        Kelvin-Voigt damping.
    specific_damping : SpecificDamping, optional
        Loss in a cycle, where the material tells it.
    layers : LaminateSection or SheetSection, optional
        What the section is made of, where that is known: stresses inside it, the third-order
        theory, heat and moisture need it.
    free_strain : float
        Strain of the neutral axis without load, over the length that the link is given.
    free_curvature : float
        Curvature without load in 1/m, of uneven swelling; positive turns to the left along the
        link.
    damping_frequency : float, optional
        In Hz; where it is given, ``damping`` has the loss of ``specific_damping`` at it.

    Raises
    ------
    InputError
        If a value is not a number, a stiffness or mass not positive, or an axis outside the
        section.

    Examples
    --------
    >>> steel = flexmech.Material(200e9, 7800.0)
    >>> section = flexmech.BeamSection.rectangle(
    ...     steel, in_plane_thickness=4e-3, out_of_plane_width=20e-3
    ... )
    >>> section
    <BeamSection: EA 1.6e+07 N, EI 21.3333 N m^2, kGA 5.22876e+06 N, 624 g/m, 4 mm thick>
    >>> section.with_damping_ratio(0.01, frequency=50.0).damping.is_uniform
    True
    """

    axial_stiffness: si.Force
    bending_stiffness: si.BendingStiffness
    shear_stiffness: si.ShearStiffness
    mass_per_length: si.MassPerLength
    rotary_inertia: si.RotaryInertia
    in_plane_thickness: si.Thickness
    neutral_axis: si.Distance = 0.0
    mass_axis: si.Distance = 0.0
    damping: DampingTimes = UNDAMPED
    specific_damping: SpecificDamping | None = None
    layers: Layers | None = None
    free_strain: si.Ratio = 0.0
    free_curvature: si.Curvature = 0.0
    damping_frequency: si.Frequency | None = None

    def __post_init__(self) -> None:
        si.check(self, "{} of a beam section")
        for name in ("neutral_axis", "mass_axis"):
            value = getattr(self, name)
            if not abs(value) < self.in_plane_thickness / 2:
                raise InputError(f"{name} must lie inside the section, got {value} m")

    def __repr__(self) -> str:
        return short_repr(
            self,
            f"EA {self.axial_stiffness:.6g} N",
            f"EI {self.bending_stiffness:.6g} N m^2",
            f"kGA {self.shear_stiffness:.6g} N" if self.shears else "rigid in shear",
            f"{self.mass_per_length * 1e3:.6g} g/m",
            f"{self.in_plane_thickness * 1e3:.6g} mm thick",
        )

    @classmethod
    def rectangle(
        cls, material: Material, in_plane_thickness: float, out_of_plane_width: float
    ) -> BeamSection:
        """Solid rectangle of one material.

        Parameters
        ----------
        material : Material
        in_plane_thickness : float
            h in m, in the plane of the linkage: I = b h^3 / 12.
        out_of_plane_width : float
            b in m, along the joint axes.

        Returns
        -------
        BeamSection
            Undamped. Shear correction factor of Cowper (1966) for a rectangle,
            k = 10 (1 + nu) / (12 + 11 nu).
        """
        check_instance(material, Material, "material", "give Material(youngs_modulus, density)")
        check_number(in_plane_thickness, "in_plane_thickness", "m", POSITIVE)
        check_number(out_of_plane_width, "out_of_plane_width", "m", POSITIVE)
        area = in_plane_thickness * out_of_plane_width
        second_moment = out_of_plane_width * in_plane_thickness**3 / 12
        nu = material.poisson_ratio
        correction = 10 * (1 + nu) / (12 + 11 * nu)
        return cls(
            axial_stiffness=material.youngs_modulus * area,
            bending_stiffness=material.youngs_modulus * second_moment,
            shear_stiffness=correction * material.shear_modulus * area,
            mass_per_length=material.density * area,
            rotary_inertia=material.density * second_moment,
            in_plane_thickness=in_plane_thickness,
            layers=LaminateSection(
                Laminate((Layer(Ply.isotropic(material), in_plane_thickness),)), out_of_plane_width
            ),
        )

    @classmethod
    def of_laminate(cls, layers: Layers) -> BeamSection:
        """Section of a laminate.

        Parameters
        ----------
        layers : LaminateSection or SheetSection
            Its layers through the thickness in the plane of the linkage, or across the width.

        Returns
        -------
        BeamSection
            Without Kelvin-Voigt damping; see :meth:`with_damping_frequency`.
        """
        damped = any(layer.ply.specific_damping.any for layer in layers.laminate.layers)
        return cls(
            axial_stiffness=layers.axial_stiffness,
            bending_stiffness=layers.bending_stiffness,
            shear_stiffness=layers.shear_stiffness,
            mass_per_length=layers.mass_per_length,
            rotary_inertia=layers.rotary_inertia,
            in_plane_thickness=layers.in_plane_thickness,
            neutral_axis=layers.neutral_axis,
            mass_axis=layers.mass_axis,
            specific_damping=layers.specific_damping if damped else None,
            layers=layers,
        )

    @property
    def third_order(self) -> ThirdOrder:
        """Integrals of Reddy's third-order theory.

        Raises
        ------
        InputError
            If the layers are not known.
        """
        if self.layers is None:
            raise InputError(
                "the third-order theory needs the layers of every section; give links of "
                "section 'rectangle' or 'laminate', or choose element 'timoshenko'"
            )
        return self.layers.smeared.third_order

    @cached_property
    def zigzag(self) -> Zigzag:
        """Integrals of the zigzag beam; a solid rectangle's where the layers are not known."""
        ratio = self.bending_stiffness / self.shear_stiffness
        if self.layers is None:
            return rectangular_zigzag(self.in_plane_thickness, ratio)
        # The section may be stated to be stiffer than its layers make it.
        layer_ratio = self.layers.bending_stiffness / self.layers.shear_stiffness
        zigzag = self.layers.smeared.zigzag
        return replace(zigzag, fall_off=zigzag.fall_off * np.sqrt(ratio / layer_ratio))

    @property
    def shears(self) -> bool:
        """Whether it has a shear flexibility."""
        return self.shear_stiffness < math.inf

    @property
    def damping_times(self) -> FloatArray:
        """Kelvin-Voigt times of stretching, bending, warping and shear in s, (4,)."""
        times = self.damping
        return np.array([times.axial, times.bending, times.of_warping, times.shear])

    def shearing_over(self, length: float) -> BeamSection:
        """The section with a shear flexibility that elements that shear can have.

        Parameters
        ----------
        length : float
            Length of the link in m.

        Returns
        -------
        BeamSection
            With a shear stiffness of at most :data:`MOST_SHEAR_STIFFNESS` times EI / length^2.
        """
        most = MOST_SHEAR_STIFFNESS * self.bending_stiffness / length**2
        return self if self.shear_stiffness <= most else replace(self, shear_stiffness=most)

    @property
    def is_eccentric(self) -> bool:
        """Whether the neutral axis or the centre of mass is off the pins' axis."""
        return self.neutral_axis != 0.0 or self.mass_axis != 0.0

    @property
    def is_free_strained(self) -> bool:
        """Whether the section stretches or bends without load."""
        return self.free_strain != 0.0 or self.free_curvature != 0.0

    @property
    def coupling_stiffness(self) -> float:
        """Integral of E y in N m about the reference axis: N = EA e - B kappa there."""
        return self.axial_stiffness * self.neutral_axis

    @property
    def first_moment_of_mass(self) -> float:
        """Integral of rho y in kg about the reference axis."""
        return self.mass_per_length * self.mass_axis

    def without_coupling(self) -> BeamSection:
        """The section with its axial-bending coupling left out.

        The bending stiffness is then that about the reference axis, which is too stiff.
        """
        added = self.axial_stiffness * self.neutral_axis**2
        return replace(
            self,
            bending_stiffness=self.bending_stiffness + added,
            neutral_axis=0.0,
            layers=None,
        )

    def with_damping_frequency(self, frequency: float) -> BeamSection:
        """The same section with the Kelvin-Voigt times of its specific damping.

        Parameters
        ----------
        frequency : float
            At which a cycle takes what the specific damping says, in Hz.

        Returns
        -------
        BeamSection

        Raises
        ------
        InputError
            If the section has no specific damping or the frequency is not positive.
        """
        if self.specific_damping is None:
            raise InputError(
                "a damping frequency needs the specific damping of the plies; give that, or "
                "damping_time"
            )
        return replace(
            self,
            damping=self.specific_damping.times(2 * np.pi * frequency),
            damping_frequency=frequency,
        )

    def with_damping_time(self, damping_time: float) -> BeamSection:
        """The same section with one Kelvin-Voigt time ``damping_time`` in s."""
        return replace(self, damping=DampingTimes.uniform(damping_time), damping_frequency=None)

    def with_damping_ratio(self, ratio: float, frequency: float) -> BeamSection:
        """The same section, damped by ``ratio`` of critical at ``frequency`` in Hz.

        A mode of pure Kelvin-Voigt material has the damping ratio omega tau / 2.
        """
        check_number(ratio, "damping ratio", "", NOT_NEGATIVE)
        check_number(frequency, "damping frequency", "Hz", POSITIVE)
        return self.with_damping_time(2 * ratio / (2 * np.pi * frequency))

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Table of a link in a model file.

        Parameters
        ----------
        shared : SharedTables
            Its material or its laminate is added.

        Returns
        -------
        dict
            A rectangle or a laminate where that gives the same section to the last bit, else
            its stiffness and mass per length.
        """
        layers, damping = self.layers, self._short_damping()
        if layers is not None and damping is not None:
            single = layers.laminate.layers[0]
            material = single.ply.isotropic_material
            if material is not None and self == BeamSection.rectangle(
                material, single.thickness, layers.width
            ).damped_as(self):
                return {
                    "section": "rectangle",
                    "material": shared.name_of("materials", material.to_table(), "material"),
                    "in_plane_thickness": quantity(single.thickness, units.LENGTH),
                    "out_of_plane_width": quantity(layers.width, units.LENGTH),
                    **damping,
                }
            if self == BeamSection.of_laminate(layers).damped_as(self):
                return {"section": "laminate", **layers.to_table(shared), **damping}
        numbers = si.table(self, without={"damping_frequency"})
        return {"section": "general", **numbers, **self._tables_within(shared)}

    def damped_as(self, other: BeamSection) -> BeamSection:
        """The same section with the damping of another one."""
        return replace(self, damping=other.damping, damping_frequency=other.damping_frequency)

    def _short_damping(self) -> TomlTable | None:
        """Key of a link that says its damping; None if it takes more than one."""
        frequency, loss = self.damping_frequency, self.specific_damping
        if frequency is None and self.damping.is_uniform:
            said = self.damping.any or (loss is not None and self.damping.stated)
            return stated(damping_time=(self.damping.axial if said else None, units.TIME))
        if frequency and loss and loss.times(2 * np.pi * frequency) == self.damping:
            return stated(damping_frequency=(frequency, units.FREQUENCY))
        return None

    def _tables_within(self, shared: SharedTables) -> TomlTable:
        """Layers and damping of a general section, in keys and tables of a link."""
        table = {} if self.layers is None else self.layers.to_table(shared)
        short = self._short_damping()
        if short is None:
            short = stated(damping_frequency=(self.damping_frequency, units.FREQUENCY))
            short["damping_times"] = self.damping.to_table()
        table |= short
        if self.specific_damping is not None:
            table["specific_damping"] = self.specific_damping.to_table()
        return table


def with_layers(section: BeamSection, layers: Layers) -> BeamSection:
    """The section with each stiffness and inertia changed as that of its layers.

    Parameters
    ----------
    section : BeamSection
        Whose layers are known, and may be stated to be stiffer or heavier than these make it.
    layers : LaminateSection or SheetSection
        As they have become.

    Returns
    -------
    BeamSection
        With a neutral axis that is stated where it was; all else stays.
    """
    changed: dict[str, float] = {}
    for name in (*_STIFFNESSES, *_INERTIAS, _NEUTRAL_AXIS):
        stated, before, after = (
            getattr(source, name) for source in (section, section.layers, layers)
        )
        # To the last bit: it tells whose stiffness is that of its layers.
        if stated == before:
            changed[name] = after
        elif name != _NEUTRAL_AXIS:
            changed[name] = stated * (after / before)
    return replace(section, layers=layers, **changed)  # type: ignore[arg-type]


def stiffened_section(section: BeamSection, factor: float) -> BeamSection:
    """The same section with every stiffness times a factor.

    All moduli of its layers are, and with them A, B, D and the shear stiffnesses of a laminate, the
    warping of its cross-section, and what joints restrain of its twist. Mass, damping, free strain
    and free curvature stay.

    Parameters
    ----------
    section : BeamSection
    factor : float

    Returns
    -------
    BeamSection

    Raises
    ------
    InputError
        If the factor is not positive.

    Examples
    --------
    >>> coupler = flexmech.load_mechanism("models/composite_fourbar.toml").sections["coupler"]
    >>> stiffer = flexmech.sections.stiffened_section(coupler, 1.1)
    >>> round(stiffer.layers.bending_stiffness / coupler.bending_stiffness, 12)
    1.1
    """
    check_number(factor, "factor of a stiffness", "", POSITIVE)
    before = section.layers
    if before is None:
        scaled = {name: factor * getattr(section, name) for name in _STIFFNESSES}
        return replace(section, **scaled)
    layers = tuple(
        replace(layer, ply=layer.ply.stiffened(factor)) for layer in before.laminate.layers
    )
    return with_layers(section, before.resized(replace(before.laminate, layers=layers), 1.0))


def sections_between_joints(
    topology: Topology, sections: Mapping[str, BeamSection]
) -> dict[str, BeamSection]:
    """Sections of links, those that twist as they bend with what their joints do to that.

    Parameters
    ----------
    topology : Topology
    sections : mapping of str to BeamSection
        By link.

    Returns
    -------
    dict of str to BeamSection
        With the twist held where both ends of a link are at joints, and the section does not
        say otherwise. A section whose stiffness is stated rather than its layers' stays as it is.
    """
    joined = topology.joined_ends
    return {
        name: _restrained(section)
        if {LinkEnd(name, "start"), LinkEnd(name, "end")} <= joined
        else section
        for name, section in sections.items()
    }


def _restrained(section: BeamSection) -> BeamSection:
    layers = section.layers
    if not isinstance(layers, LaminateSection) or layers.twist is not None or not layers.twists:
        return section
    if section != BeamSection.of_laminate(layers).damped_as(section):
        return section
    untwisted = BeamSection.of_laminate(replace(layers, twist="held"))
    if section.damping_frequency is None or section.specific_damping is None:
        return untwisted.damped_as(section)
    return untwisted.with_damping_frequency(section.damping_frequency)
