"""The reference engine: plane beams of four theories on NumPy and SciPy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

from flexmech.beams.comparison import compare_theories
from flexmech.beams.link_matrices import Chain, assemble_chain, build_chain
from flexmech.beams.theories import BEAM_SHAPES
from flexmech.choices import ELEMENTS, MASSES, MassChoice
from flexmech.linear_system import (
    Engine,
    LinkFrames,
    LinkModel,
    LinkStretch,
    Prestress,
    StressedLinks,
    TheoryComparison,
    element_tensions,
    inertia_loads,
    refuse_large_displacements,
)
from flexmech.linkages import LinkMass, RigidMotion, lumped_elements
from flexmech.mechanism import Mechanism
from flexmech.reference.equilibrium import Equilibrium
from flexmech.reference.stretch import chain_stretch
from flexmech.types import FloatArray

__all__ = ["ReferenceEngine"]


class ReferenceEngine(Engine):
    """Beam elements with consistent mass, in link frames.

    Elements: ``euler`` (Euler-Bernoulli, without rotary inertia), ``timoshenko`` (shear and
    rotary inertia), ``reddy`` (third-order shear; sections whose layers are known) and
    ``zigzag`` (cross-sections that warp as their layers ask for, as of sandwiches).

    Prestress levels: ``none``; ``axial`` (Turcic & Midha 1984: tension of each element
    from the linear static solution, geometric stiffness of Kumar & Chandrakar, eq. 1.58);
    ``equilibrium`` (corotational beams and Newton's method). Mass: distributed, or ``lumped``
    as Kumar & Chandrakar's twelve masses (their Figure 1.5). Parameters as for
    :class:`flexmech.linear_system.Engine`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=8)
    >>> engine.with_(element="timoshenko").element
    'timoshenko'
    """

    name: ClassVar[str] = "reference"
    element_kinds: ClassVar[tuple[str, ...]] = ELEMENTS["reference"]
    counterparts: ClassVar[dict[str, str]] = {
        "ancf": "euler",
        "geometrically-exact": "timoshenko",
    }
    masses: ClassVar[tuple[MassChoice, ...]] = MASSES
    theories: ClassVar[dict[str, str]] = {theory: theory for theory in BEAM_SHAPES}

    @classmethod
    def compare_theories(cls, mechanism: Mechanism, modes: int) -> TheoryComparison:
        """See :meth:`Engine.compare_theories`."""
        return compare_theories(mechanism, modes)

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        """Links of beam elements, in the topology's order."""
        return tuple(
            build_chain(
                name,
                self.mechanism.sections[name],
                mass,
                self.elements,
                BEAM_SHAPES[self.element],
            )
            for name, mass in zip(
                self.mechanism.linkage.topology.link_names, self._masses, strict=True
            )
        )

    @cached_property
    def _lumped(self) -> tuple[int, ...] | None:
        """Elements whose mass is lumped, by link; None where mass is distributed."""
        if self.mass == "distributed":
            return None
        return lumped_elements(self.mechanism.linkage.topology)

    @property
    def _masses(self) -> tuple[LinkMass, ...]:
        masses = self.mechanism.link_masses_in_order
        if self._lumped is None:
            return masses
        return tuple(mass.lumped(n) for mass, n in zip(masses, self._lumped, strict=True))

    @cached_property
    def held_links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models, coordinates (u, v, phi, ...) node by node."""
        return tuple(chain.model for chain in self.chains)

    @cached_property
    def held_stretches(self) -> tuple[LinkStretch, ...] | None:
        """Second-order stretch of each link; see :attr:`Engine.stretches`."""
        if self.mechanism.is_free_strained:
            return None
        return tuple(chain_stretch(chain) for chain in self.chains)

    @property
    def nodes(self) -> list[FloatArray]:
        """Node positions of each link in m."""
        return [chain.nodes for chain in self.chains]

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Solver for the quasi-static equilibrium on this mesh."""
        frames = LinkFrames(self.mechanism.linkage.topology, self.held_links)
        return Equilibrium(frames, [chain.elements for chain in self.chains])

    def stressed_held_links(
        self,
        motion: RigidMotion,
        prestress: Prestress,
        near: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Tangent stiffness of each link; see :meth:`Engine.stressed_links`."""
        if self._is_straight(motion, prestress):
            return StressedLinks.unloaded(self.held_links)
        if prestress == "axial":
            loads = inertia_loads(self.held_links, motion, self.mechanism.gravity)
            return StressedLinks(self._axial_tangents(motion), loads=loads)
        return self._equilibrium(motion, near)

    def _equilibrium(self, motion: RigidMotion, near: Sequence[FloatArray] | None) -> StressedLinks:
        varying = self._geometric(motion, varying_part_only=True)

        def displaced(loads: list[FloatArray]) -> list[FloatArray]:
            return self.equilibrium.solve(motion, loads, varying, near)

        loads = self._quasi_static_loads(motion, displaced)
        displacement = displaced(loads)
        topology = self.mechanism.linkage.topology
        refuse_large_displacements(topology, self.held_links, motion, displacement)
        return replace(self._displaced(displacement, varying), loads=loads)

    def running_held_links(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> StressedLinks:
        """Stiffness and internal forces in running states; see :meth:`Engine.running_links`.

        The tension varies inside an element as the inertia forces of the rigid motion make it;
        what those of the elastic motion add inside it is left out, and falls with the square
        of the element length. Their mean is that of the state.
        """
        return self._displaced(displacement, self._geometric(motion, varying_part_only=True))

    def _displaced(
        self, displacement: Sequence[FloatArray], varying: Sequence[FloatArray]
    ) -> StressedLinks:
        force, tangent = self.equilibrium.response(displacement, varying)
        damping = None
        if any(section.damping.any for section in self.mechanism.sections.values()):
            damping = [assemble_chain(d) for d in self.equilibrium.damping(displacement)]
        return StressedLinks(tangent, list(displacement), force, damping)

    def _axial_tangents(self, motion: RigidMotion) -> list[FloatArray]:
        geometric = self._geometric(motion, varying_part_only=False)
        return [
            link.stiffness + assemble_chain(extra)
            for link, extra in zip(self.held_links, geometric, strict=True)
        ]

    def _geometric(self, motion: RigidMotion, *, varying_part_only: bool) -> list[FloatArray]:
        """Geometric stiffness of each element, (B, e, 6, 6), by link.

        A corotational element knows its mean tension by itself; what inertia forces add
        inside it is the varying part.
        """
        matrices = []
        for chain, tension in zip(
            self.chains,
            element_tensions(self.mechanism, self.nodes, motion, self._lumped),
            strict=True,
        ):
            if varying_part_only:
                tension[..., 0] = 0.0
            matrices.append(chain.elements.geometric_stiffness(tension))
        return matrices
