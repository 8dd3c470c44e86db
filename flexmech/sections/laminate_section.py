"""A rectangular section of a laminate whose plies are stacked in the linkage's plane.

Bending in the plane of the linkage bends the laminate through its thickness. The section
keeps the axial-bending coupling of an unsymmetric stack: it has a neutral axis off the
mid-plane, where the pins sit. Strains along the link are ``e - y kappa``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.materials import Laminate
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.sections.beam_reduction import (
    REDUCTIONS,
    PlaneState,
    Reduction,
    Strip,
    gauss_points,
    layer_of,
    lost_share,
    shear_across,
)
from flexmech.sections.damping import SpecificDamping
from flexmech.sections.free_edges import (
    FIRST_MODE,
    TWISTS,
    FreeEdges,
    Twist,
    free_edges,
    laminate_solid,
)
from flexmech.sections.shear_theories import (
    SHEAR_THEORIES,
    LayerDirection,
    ShearTheory,
    ThirdOrder,
    ThroughThickness,
    Zigzag,
    check_loads,
    parabolic_shear,
    third_order_of,
    zigzag_of,
)
from flexmech.sections.solid_section import SolidSection
from flexmech.units import LENGTH
from flexmech.validation import POSITIVE, check_choice, check_instance, check_number


@dataclass(frozen=True)
class LaminateSection:
    """Laminate of a width along the joint axes, stacked through the thickness in the plane.

    Parameters
    ----------
    laminate : Laminate
    width : float
        Along the joint axes, in m.
    reduction : {"narrow", "wide"}
        ``narrow``: no stress resultant across the link nor in-plane shear (plane stress);
        ``wide``: no strain across nor in-plane shear (plane strain, cylindrical bending).
    twist : {"free", "held"}, optional
        Of a narrow section whose off-axis plies twist as they bend: ``held`` where joints keep
        both ends from turning about the link's axis (:mod:`flexmech.sections.free_edges`). Left
        out: as the link's joints have it, and free where there is no link.

    Raises
    ------
    InputError
        If the width is not positive or the reduction or the twist unknown.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> glass = flexmech.ply_from_constituents(known["E-glass"], known["polyester"], 0.6)
    >>> carbon = flexmech.ply_from_constituents(known["carbon"], known["polyester"], 0.6)
    >>> laminate = flexmech.Laminate.stacked([glass, carbon], 1e-3, [0.0, 0.0])
    >>> section = flexmech.LaminateSection(laminate, width=0.02)
    >>> round(section.neutral_axis * 1e3, 3)  # towards the stiffer ply, in mm
    0.239
    """

    laminate: Laminate
    width: float
    reduction: Reduction = "narrow"
    twist: Twist | None = None

    def __post_init__(self) -> None:
        check_instance(self.laminate, Laminate, "laminate", "give Laminate(layers)")
        check_number(self.width, "width of a laminate section", "m", POSITIVE)
        check_choice(self.reduction, REDUCTIONS, "reduction")
        if self.twist is not None:
            check_choice(self.twist, TWISTS, "twist")

    def __repr__(self) -> str:
        width = f"{self.width * 1e3:.6g} mm wide"
        return short_repr(self, self.laminate.stacking, width, self.reduction)

    @property
    def in_plane_thickness(self) -> float:
        """Extent in the plane of the linkage in m."""
        return self.laminate.thickness

    @property
    def direction(self) -> LayerDirection:
        """Of the stack."""
        return "through thickness"

    @property
    def breadth(self) -> float:
        """Extent of the plies across the link in m."""
        return self.width

    @property
    def smeared(self) -> LaminateSection:
        """The section itself: its layers are those through the thickness in the plane."""
        return self

    @cached_property
    def axial_stiffness(self) -> float:
        """EA in N."""
        return float(self._classical[0, 0])

    @cached_property
    def coupling_stiffness(self) -> float:
        """B, the integral of E y, in N m: N = EA e - B kappa about the mid-plane."""
        return float(self._classical[0, 1])

    @cached_property
    def neutral_axis(self) -> float:
        """Distance of the neutral axis from the mid-plane in m; exactly 0 if symmetric."""
        return self.coupling_stiffness / self.axial_stiffness

    @cached_property
    def bending_stiffness(self) -> float:
        """EI about the neutral axis in N m^2."""
        return float(self._classical[1, 1]) - self.axial_stiffness * self.neutral_axis**2

    @cached_property
    def shear_stiffness(self) -> float:
        """Shear stiffness kGA in N, from the shear energy of the stack.

        The shear stress that balances the bending stress of a unit shear force has the
        complementary energy ``1 / (2 kGA)`` for each metre (Whitney 1973 for plates; one
        homogeneous layer has k = 5/6). In a narrow link this takes the stress across the
        link too, which the shear within angle plies asks for; its force is zero.
        """
        return float(1 / self._shear_flexibility.sum())

    @cached_property
    def shear_correction(self) -> float:
        """Factor k: kGA over the integral of G, reduced as the section is."""
        moment = self.laminate.shear_moment(0)
        along = moment[1, 1] + shear_across(moment, self.reduction) * moment[0, 1]
        return float(self.shear_stiffness / (self.width * along))

    @cached_property
    def mass_per_length(self) -> float:
        """Mass rho A in kg/m."""
        return self.width * self.laminate.mass_moment(0)

    @cached_property
    def mass_axis(self) -> float:
        """Distance of the centre of mass from the mid-plane in m; exactly 0 if symmetric."""
        axis = self.laminate.mass_moment(1) / self.laminate.mass_moment(0)
        return axis if abs(axis) > ROUND_OFF * self.laminate.thickness else 0.0

    @cached_property
    def rotary_inertia(self) -> float:
        """Mass moment rho I about the centre of mass in kg m."""
        return self.width * self.laminate.mass_moment(2) - self.mass_per_length * self.mass_axis**2

    @cached_property
    def solid(self) -> SolidSection:
        """The cross-section in three dimensions, all edges free: compliance by six loads.

        A narrow link with plies at angles stretches and bends as this section does. Torsion and
        bending across the linkage's plane are told besides.

        Examples
        --------
        >>> aluminium = flexmech.Material(70e9, 2700.0, 0.33)
        >>> layer = flexmech.Layer(flexmech.Ply.isotropic(aluminium), 4e-3)
        >>> section = flexmech.LaminateSection(flexmech.Laminate((layer,)), width=8e-3)
        >>> torsion = 1 / section.solid.compliance[3, 3]
        >>> round(torsion / (aluminium.shear_modulus * 8e-3 * 4e-3**3), 3)  # closed form: 0.229
        0.229
        """
        return laminate_solid(self.laminate, self.width)

    @cached_property
    def third_order(self) -> ThirdOrder:
        """Integrals for Reddy's theory, reduced like the classical ones."""
        return third_order_of(self._strip, self.width)

    @property
    def twists(self) -> bool:
        """Whether bending twists the section, so that joints matter which restrain the twist."""
        return self._free_edges is not None and self._free_edges.torsion > 0

    @cached_property
    def twist_restraint(self) -> float:
        """Where the section is between twist that is free (0) and none at all (1)."""
        edges = self._free_edges
        return 0.0 if self.twist != "held" or edges is None else FIRST_MODE * edges.torsion

    @cached_property
    def zigzag(self) -> Zigzag:
        """Integrals for the zigzag beam, reduced like the classical ones."""
        return zigzag_of(self._strip, self._bent_inside)

    @cached_property
    def specific_damping(self) -> SpecificDamping:
        """Specific damping capacity of stretching, bending, shear and warping.

        Strain energies by ply and direction in the material's axes, each with its own
        capacity (Adams & Bacon 1973; Ni & Adams 1984). All shear through the thickness
        loses with the ply's capacity in shear.
        """
        sheared = np.zeros((len(self.laminate.layers), 3))
        sheared[:, 2] = self._shear_flexibility
        stretched = self._strip.energy_by_direction(self._strains(1.0, 0.0))
        bent = self._strip.energy_by_direction(self._strains(0.0, 1.0))
        axial, bending, shear = (
            lost_share(self.laminate, energy) for energy in (stretched, bent, sheared)
        )
        return SpecificDamping(axial, bending, shear, self.zigzag.loss)

    def places(self, per_layer: int) -> FloatArray:
        """Places through each layer, its faces included.

        Parameters
        ----------
        per_layer : int

        Returns
        -------
        ndarray, shape (N, per_layer)
            In m.

        Raises
        ------
        InputError
            If there are fewer than two a layer.
        """
        if per_layer < 2:
            raise InputError(f"per_layer must be 2 or more, for both faces; got {per_layer}")
        faces = self.laminate.boundaries
        return np.linspace(faces[:-1], faces[1:], per_layer, axis=1)

    def stresses(
        self,
        place: FloatArray,
        axial_force: float = 0.0,
        bending_moment: float = 0.0,
        shear_force: float = 0.0,
        *,
        coupled: bool = True,
        theory: ShearTheory = "equilibrium",
    ) -> ThroughThickness:
        """Strain and stress through the thickness under loads on the neutral axis.

        Strain and normal stress by classical theory. With coupling both shear stresses have
        the shear force as their resultant.

        Parameters
        ----------
        place : ndarray, shape (m,) or (N, m)
            In m. In a list, an interface is of its upper layer; in rows, of which
            :meth:`places` gives some, each layer has its own stress at it.
        axial_force : float
            In N, on the neutral axis (on the mid-plane if not ``coupled``).
        bending_moment : float
            In N m; positive stretches the side of lower y.
        shear_force : float
            In N, along y on the face towards higher x.
        coupled : bool
            Off: the section's axial-bending coupling is left out, as if the stack were
            symmetric; the stresses then do not balance the loads, and the shear stress
            does not vanish at the upper face.
        theory : {"equilibrium", "third-order"}
            Shear stress that balances the normal stress along the link, or Reddy's parabola
            of shear strain ``1 - 4 y^2 / h^2`` with each layer's stiffness, which jumps at
            interfaces.

        Returns
        -------
        ThroughThickness

        Raises
        ------
        InputError
            If a place is outside the laminate, a load not a number or the theory unknown.
        """
        check_loads((axial_force, bending_moment, shear_force))
        check_choice(theory, SHEAR_THEORIES, "theory")
        place = np.asarray(place, dtype=float)
        layer = layer_of(self.laminate, place)
        strains = self._strains(axial_force, bending_moment, coupled)
        if theory == "equilibrium":
            growing = self._state(self._strains(0.0, 1.0, coupled))
            shear = growing.balancing_shear(place, layer)[..., 1]
        else:
            shear = parabolic_shear(self.laminate, self.reduction, place, layer) / self.width
        return ThroughThickness(
            place=place,
            strain=strains[0] + place * strains[1],
            normal_stress=self._state(strains).stress(place, layer)[..., 0],
            shear_stress=shear_force * shear,
        )

    def plane_state(self, axial_force: float, bending_moment: float) -> PlaneState:
        """Its layers under loads on the neutral axis, in N and N m."""
        return self._state(self._strains(axial_force, bending_moment))

    def resized(self, laminate: Laminate, growth: float) -> LaminateSection:
        """The section of another laminate, its plies broader by a factor.

        Parameters
        ----------
        laminate : Laminate
        growth : float

        Returns
        -------
        LaminateSection
        """
        return replace(self, laminate=laminate, width=growth * self.width)

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Keys of a link in a model file; the laminate is added to the shared tables."""
        laminate = shared.name_of("laminates", self.laminate.to_table(shared), "laminate")
        twist = {} if self.twist is None else {"twist": self.twist}
        return {
            "laminate": laminate,
            "out_of_plane_width": quantity(self.width, LENGTH),
            "reduction": self.reduction,
            **twist,
        }

    @cached_property
    def _free_edges(self) -> FreeEdges | None:
        """Edges of a narrow section whose plies are at angles."""
        return None if self.reduction == "wide" else free_edges(self.laminate, self.width)

    @cached_property
    def _strip(self) -> Strip:
        edges = self._free_edges
        relaxation = None if edges is None else edges.relaxation
        return Strip(self.laminate, self.reduction, relaxation, self.twist_restraint)

    @cached_property
    def _classical(self) -> FloatArray:
        """Stiffness by mid-plane strain and its gradient in y, (2, 2)."""
        matrix = self.width * self._strip.stiffness
        # What rounding leaves of a symmetric stack's coupling would move its axis off the pins.
        if abs(matrix[0, 1]) < ROUND_OFF * np.sqrt(matrix[0, 0] * matrix[1, 1]):
            matrix[0, 1] = matrix[1, 0] = 0.0
        return matrix

    def _strains(self, axial_force: float, moment: float, coupled: bool = True) -> FloatArray:
        """Mid-plane strain and its gradient in y under loads on the neutral axis, (2,)."""
        axis = self.neutral_axis if coupled else 0.0
        curvature = moment / (self.bending_stiffness if coupled else self._classical[1, 1])
        return np.array([axial_force / self.axial_stiffness + axis * curvature, -curvature])

    def _state(self, strains: FloatArray) -> PlaneState:
        """The laminate under strain along the link and its gradient in y."""
        return PlaneState(self.laminate, np.tensordot(strains, self._strip.strains, axes=1))

    @property
    def _bent_inside(self) -> PlaneState:
        """The laminate away from its edges under a unit bending moment."""
        inside = self._strip.joined
        strains = np.linalg.solve(self.width * inside.stiffness, np.array([0.0, -1.0]))
        return PlaneState(self.laminate, np.tensordot(strains, inside.strains, axes=1))

    @cached_property
    def _shear_flexibility(self) -> FloatArray:
        """Share of each layer in 1 / kGA, (N,), in 1/N."""
        places, weights = gauss_points(self.laminate)
        every = np.arange(len(places))[:, None]
        stress = self._bent_inside.balancing_shear(places, every)
        stiffness = self.laminate.transformed_shear_stiffness
        if self.reduction == "wide":
            squares = stress[..., 1] ** 2 / stiffness[:, 1, 1, None]
        else:
            squares = np.einsum("nmi,nij,nmj->nm", stress, np.linalg.inv(stiffness), stress)
        return np.asarray(self.width * np.sum(weights * squares, axis=1))
