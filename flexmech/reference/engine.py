"""The reference engine: Euler-Bernoulli beams on NumPy and SciPy alone."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system import (
    ConvergenceOrders,
    Engine,
    LinkFrames,
    LinkModel,
    Prestress,
    StressedLinks,
    element_tensions,
    inertia_loads,
    refuse_other_postures,
)
from flexmech.linkages import RigidMotion
from flexmech.reference.elements import geometric_stiffness
from flexmech.reference.equilibrium import Equilibrium
from flexmech.reference.link_matrices import assemble_chain, link_model

__all__ = ["ReferenceEngine"]

FloatArray = NDArray[np.float64]


class ReferenceEngine(Engine):
    """Axial and Hermite beam elements with consistent mass, in link frames.

    Prestress levels: ``none``; ``axial`` (Turcic & Midha 1984: tension of each element
    from the linear static solution, geometric stiffness of eq. 1.58); ``equilibrium``
    (corotational beams and Newton's method). Parameters as for
    :class:`flexmech.linear_system.Engine`; the element is ``"euler"``.
    """

    name: ClassVar[str] = "reference"
    element_kinds: ClassVar[tuple[str, ...]] = ("euler",)

    def convergence(self, prestress: Prestress) -> ConvergenceOrders:
        """Hermite elements: fourth order, prestressed or not."""
        return ConvergenceOrders(elastic=4, prestress=4)

    @cached_property
    def _built(self) -> tuple[tuple[LinkModel, ...], list[FloatArray]]:
        models, nodes = [], []
        for name in self.mechanism.linkage.topology.link_names:
            model, positions = link_model(
                name, self.mechanism.sections[name], self.mechanism.link_mass(name), self.elements
            )
            models.append(model)
            nodes.append(positions)
        return tuple(models), nodes

    @property
    def links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models, coordinates (u, v, phi) node by node."""
        return self._built[0]

    @property
    def nodes(self) -> list[FloatArray]:
        """Node positions of each link in m."""
        return self._built[1]

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Solver for the quasi-static equilibrium on this mesh."""
        topology = self.mechanism.linkage.topology
        sections = [self.mechanism.sections[name] for name in topology.link_names]
        return Equilibrium(LinkFrames(topology, self.links), self.nodes, sections)

    def stressed_links(self, motion: RigidMotion, prestress: Prestress) -> StressedLinks:
        """Tangent stiffness of each link; see :meth:`Engine.stressed_links`."""
        unloaded = not motion.crank_speed.any() and not any(self.mechanism.gravity)
        if prestress == "none" or unloaded:
            return StressedLinks.unloaded(self.links)
        if prestress == "axial":
            return StressedLinks(self._axial_tangents(motion))
        return self._equilibrium(motion)

    def _equilibrium(self, motion: RigidMotion) -> StressedLinks:
        varying = self._geometric(motion, varying_part_only=True)
        loads = inertia_loads(self.links, motion, self.mechanism.gravity)
        displacement = self.equilibrium.solve(motion, loads, varying)
        topology = self.mechanism.linkage.topology
        refuse_other_postures(topology, self.links, motion, displacement)
        force, tangent = self.equilibrium.response(displacement, varying)
        damping = None
        if any(section.damping_time for section in self.equilibrium.sections):
            damping = [assemble_chain(d) for d in self.equilibrium.damping(displacement)]
        return StressedLinks([assemble_chain(k) for k in tangent], displacement, force, damping)

    def _axial_tangents(self, motion: RigidMotion) -> list[FloatArray]:
        geometric = self._geometric(motion, varying_part_only=False)
        return [
            link.stiffness + assemble_chain(extra)
            for link, extra in zip(self.links, geometric, strict=True)
        ]

    def _geometric(self, motion: RigidMotion, *, varying_part_only: bool) -> list[FloatArray]:
        """Geometric stiffness of each element, (B, e, 6, 6), by link.

        A corotational element knows its mean tension by itself; what inertia forces add
        inside it is the varying part.
        """
        matrices = []
        for nodes, tension in zip(
            self.nodes, element_tensions(self.mechanism, self.nodes, motion), strict=True
        ):
            if varying_part_only:
                tension[..., 0] = 0.0
            matrices.append(geometric_stiffness(np.diff(nodes), tension))
        return matrices
