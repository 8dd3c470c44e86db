"""Engine: the contract and the common part of the finite-element engines."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.choices import (
    MODES,
    MOST_MODES,
    PRESTRESS_LEVELS,
    SHAFTS,
    MassChoice,
    Prestress,
    ShaftChoice,
)
from flexmech.errors import InputError
from flexmech.linear_system.assembly.batches import (
    BATCH_BYTES,
    LEAST_BATCH,
    check_elastic,
    checked_elements,
    checked_mechanism,
    equal_batches,
)
from flexmech.linear_system.assembly.engine_links import EngineLinks
from flexmech.linear_system.assembly.free_shaft import FreeShaft
from flexmech.linear_system.assembly.reduced_system import assembled_system
from flexmech.linear_system.assembly.system import LinearSystem
from flexmech.linear_system.joints.carried_linkage import CarriedLinkage
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.position_errors import TooManyModesError
from flexmech.linear_system.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linear_system.reduction.component_modes import ComponentModes, component_modes
from flexmech.linkages import RigidMotion, lumped_elements
from flexmech.linkages.motion import checked_drive
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    POSITIVE,
    check_choice,
    check_count,
    check_flag,
    check_number,
    checked_array,
)

# A map of that many frequencies needs two more, among which it tracks modes.
SYSTEM_MODES = MODES + 2
# Cached reductions. Speed alone: a map over speeds needs some at each speed, and not again.
KEPT_REDUCTIONS = 16


class Engine(EngineLinks):
    """Turns a mechanism and crank positions into a :class:`LinearSystem`.

    An engine is a value: it does not change, and two that compute the same are equal.
    :meth:`with_` makes another one.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Finite elements a link.
    element : str, optional
        Kind of beam element; one of ``element_kinds``. Left out: that of the beam theory which
        the mechanism needs, see :meth:`default_element`.
    component_modes : bool
        Reduce each link to component modes (Craig-Bampton). Off: all coordinates.
    modes : int
        Natural frequencies for which an element that is left out must be fit. Analyses choose
        it anew for those that they are asked for.
    shaft : {"prescribed", "free"}
        Whether the shaft turns as prescribed; or its rotation against that is one more
        coordinate, with the mechanism's ``shaft_inertia`` and with the torque that the mean
        motion takes.
    mass : {"distributed", "lumped"}
        Whether links have their mass along them, or in points at the ends of as many elements
        as :func:`flexmech.linkages.lumped_elements` says: massless coordinates are condensed
        statically. Lumped masses have neither component modes nor runs in time.

    Attributes
    ----------
    name : str
    element_kinds : tuple of str
    masses : tuple of str
        Which of the mass models it has.
    free_shaft : FreeShaft or None
        The shaft, where it is free.
    simulates : bool
        Whether the engine runs the linkage with large displacements; see
        :mod:`flexmech.time_domain.recorded_runs.states`.

    Raises
    ------
    InputError
        If the mechanism is none, the element unknown or the number of elements no such.
    """

    name: ClassVar[str]
    simulates: ClassVar[bool] = False
    masses: ClassVar[tuple[MassChoice, ...]] = ("distributed",)

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int = 8,
        element: str | None = None,
        component_modes: bool = True,
        modes: int = MODES,
        shaft: ShaftChoice = "prescribed",
        mass: MassChoice = "distributed",
    ) -> None:
        self.mechanism = checked_mechanism(mechanism)
        self.elements = checked_elements(elements)
        check_count(modes, "modes", most=MOST_MODES)
        self.modes = modes
        if element is not None:
            check_choice(element, self.element_kinds, f"element of the {self.name} engine")
        check_flag(component_modes, "component_modes")
        self.element = self.default_element(mechanism, modes) if element is None else element
        check_choice(mass, self.masses, f"mass of the {self.name} engine")
        self.mass = mass
        self.component_modes = component_modes and mass == "distributed"
        self._component_modes_asked = component_modes
        check_choice(shaft, SHAFTS, "shaft")
        self.shaft = shaft
        self.free_shaft = FreeShaft.of(mechanism) if shaft == "free" else None
        self._element_asked = element
        self._reductions: dict[tuple[int, tuple[float, ...], bool, float], ComponentModes] = {}

    def with_(
        self,
        *,
        mechanism: Mechanism | None = None,
        elements: int | None = None,
        element: str | None = None,
        component_modes: bool | None = None,
        modes: int | None = None,
        shaft: ShaftChoice | None = None,
        mass: MassChoice | None = None,
    ) -> Self:
        """Make a copy of the engine with some parameters changed.

        Parameters
        ----------
        mechanism : Mechanism, optional
            An element that was not asked for is chosen anew for it.
        elements : int, optional
        element : str, optional
        component_modes : bool, optional
        modes : int, optional
            An element that was not asked for is chosen anew for them.
        shaft : {"prescribed", "free"}, optional
        mass : {"distributed", "lumped"}, optional

        Returns
        -------
        Engine

        Raises
        ------
        InputError
            As of a new engine.
        """
        return type(self)(
            self.mechanism if mechanism is None else mechanism,
            self.elements if elements is None else elements,
            self._element_asked if element is None else element,
            self._component_modes_asked if component_modes is None else component_modes,
            self.modes if modes is None else modes,
            self.shaft if shaft is None else shaft,
            self.mass if mass is None else mass,
        )

    def unreduced(self) -> Self:
        """Make a copy without component modes that shares the link models."""
        other = copy(self)
        vars(other).update(component_modes=False, _component_modes_asked=False, _reductions={})
        return other

    def __repr__(self) -> str:
        modes = "" if self.component_modes else ", without component modes"
        if self.shaft == "free":
            modes += ", shaft free"
        if self.mass == "lumped":
            modes = modes.replace("without component modes", "lumped masses")
        name, plural = self.mechanism.provenance.name, "s" if self.elements > 1 else ""
        beams = f"{self.elements} {self.element} element{plural} a link"
        return f"{type(self).__name__}({name}, {beams}{modes})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Engine) or type(self) is not type(other):
            return NotImplemented
        return self._computes == other._computes and self.mechanism == other.mechanism

    def __hash__(self) -> int:
        # A mechanism has none, because its sections are in a dictionary.
        return hash((type(self), self._computes, self.mechanism.provenance))

    def __setattr__(self, name: str, value: object) -> None:
        # What has been computed from an attribute would not follow it.
        if name in vars(self):
            raise AttributeError(f"an engine does not change; make another by with_({name}=...)")
        super().__setattr__(name, value)

    @property
    def _computes(self) -> tuple[int, str, bool, str, str]:
        """Parameters that determine the results, besides the mechanism."""
        return self.elements, self.element, self.component_modes, self.shaft, self.mass

    @property
    def lumped_mass_count(self) -> int:
        """Number of lumped masses; zero where mass is distributed."""
        if self.mass == "distributed":
            return 0
        topology = self.mechanism.linkage.topology
        elements = zip(self.mechanism.link_masses_in_order, lumped_elements(topology), strict=True)
        return sum(len(mass.lumps(count)) for mass, count in elements)

    def check_runs(self) -> None:
        """Refuse models that are for natural frequencies alone.

        Raises
        ------
        InputError
            If masses are lumped: between them nothing would move in time; or if all links are
            rigid.
        """
        check_elastic(self.mechanism)
        if self.mass == "lumped":
            raise InputError(
                "lumped masses are for natural frequencies; for motion in time make the engine "
                'with mass="distributed"'
            )

    def fit_for(self, modes: int) -> Self:
        """The engine with an element fit for so many natural frequencies, if none was asked for."""
        if modes == self.modes or not self.chooses_element:
            return self
        other = self.with_(modes=modes)
        return self if other.element == self.element else other

    @property
    def chooses_element(self) -> bool:
        """Whether no element was asked for, so that the mechanism decides."""
        return self._element_asked is None

    @property
    def designs(self) -> int | None:
        """Number of designs of a stack."""
        return len(self.members) or None

    @property
    def batch_size(self) -> int:
        """Number of positions to hold in memory at a time."""
        entries = sum(link.size**2 for link in self.links)
        return max(LEAST_BATCH, BATCH_BYTES // (8 * 4 * entries))

    def batches(self, count: int) -> list[slice]:
        """Batches of equal size for a number of positions; of a stack there is one."""
        return equal_batches(count, self.batch_size if self.designs is None else count)

    def linear_system(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        *,
        prestress: Prestress = "equilibrium",
        running: Sequence[FloatArray] | None = None,
        rotation_terms: bool | RotationTerms = True,
        modes: int | None = None,
        fastest: FloatArray | float | None = None,
        detail: float | None = None,
        stressed: StressedLinks | None = None,
    ) -> LinearSystem:
        """Linear system at crank angles and speeds.

        Parameters
        ----------
        crank_angle, crank_speed : array_like
            In rad and rad/s; broadcast against each other and flattened to a batch of B.
        prestress : {"none", "axial", "equilibrium"}
        running : sequence of ndarray, shape (B, n_link), optional
            Elastic displacements of states to linearize about, in place of the prestress.
        rotation_terms : bool or RotationTerms
            Terms of the turning frames; at crank speed zero they vanish.
        modes : int, optional
            Number of natural frequencies that the reduction must get right. Left out: six, or as
            many as there are.
        fastest : float, optional
            Greatest angular velocity of a link in the whole map in rad/s, by which the
            reduction is chosen, of each design (D,) of a stack; of this batch by default.
        detail : float, optional
            Multiplies the frequency up to which component modes are kept, whose error
            ``natural_frequencies`` measures; left out: all coordinates are kept.
        stressed : StressedLinks, optional
            What :meth:`stressed_links` or :meth:`running_links` gave in these positions.

        Returns
        -------
        LinearSystem
            Batch of B positions.

        Raises
        ------
        InputError
            If an argument is none of the kind, all links are rigid, or where the linkage cannot
            be assembled or locks.
        ComputationError
            If the equilibrium does not converge.
        """
        check_elastic(self.mechanism)
        check_choice(prestress, PRESTRESS_LEVELS, "prestress")
        if modes is not None:
            check_count(modes, "modes", most=MOST_MODES)
        if detail is not None:
            check_number(detail, "detail", "", POSITIVE)
        if fastest is not None:
            checked_array(fastest, "fastest", "rad/s")
        terms = RotationTerms.of(rotation_terms)
        angle, speed, _ = checked_drive(crank_angle, crank_speed, 0.0)
        if not angle.size:
            raise InputError("crank_angle is empty; give one crank angle or more")
        if stressed is None or (motion := stressed.motion) is None:
            motion = self.mechanism.linkage.motion(angle.ravel(), speed.ravel())
        if not motion.crank_speed.any():
            terms = RotationTerms.all_or_none(False)
        if stressed is None and running is not None:
            stressed = self.running_links(motion, running)
        elif stressed is None:
            stressed = self.stressed_links(motion, prestress)
        reduction = None
        if detail is not None and self.component_modes and not self.turns_as_one_body:
            greatest = self.fastest(motion) if fastest is None else np.abs(np.atleast_1d(fastest))
            greatest = greatest if terms.any else 0 * greatest
            loaded = not stressed.unstressed and any(t.ndim == 3 for t in stressed.tangent)
            reduction = self._reduction(modes or SYSTEM_MODES, greatest, loaded, detail)

        def connect(
            frames: LinkFrames, motion: RigidMotion, matrices: SystemMatrices
        ) -> SystemMatrices:
            return self.connectors.added(
                frames, motion, matrices, terms, prestress, stressed.displacement
            )

        system = assembled_system(self.frames, reduction, motion, stressed, terms, connect)
        if reduction is None and modes is not None and system.size < modes:
            raise TooManyModesError(
                f"modes: {modes} were asked for, the model has {system.size}; ask for fewer "
                "modes or more elements",
                most_modes=system.size,
            )
        carried = CarriedLinkage.of(self.mechanism, system.frames, self.links, system.bases)
        if carried is not None:
            matrices = SystemMatrices(system.mass, system.damping, system.stiffness)
            matrices = carried.added(system.motion, matrices, terms, system.expansion)
            system = replace(system, **vars(matrices), carried=carried, unit_mass_from=None)
        circulates, rigid = self.connectors.circulates, self.rigid_modes
        return replace(system, rigid_modes=rigid, circulates=circulates)

    def _reduction(
        self, modes: int, fastest: FloatArray, loaded: bool, detail: float
    ) -> ComponentModes:
        key = (modes, tuple(fastest.tolist()), loaded, detail)
        if key not in self._reductions:
            if len(self._reductions) >= KEPT_REDUCTIONS:
                del self._reductions[next(iter(self._reductions))]
            self._reductions[key] = component_modes(
                self.topology,
                self.links,
                modes,
                float(fastest[0]) if self.designs is None else fastest,
                couples_axially=loaded,
                detail=detail,
                with_damping_shapes=any(link.damping.any() for link in self.links),
                fixed=self.fixed_interface_links,
                decouples_mass=True,
            )
        return self._reductions[key]
