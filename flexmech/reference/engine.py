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
    inertia_loads,
)
from flexmech.linkages import RigidMotion, inverse_dynamics
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

    @property
    def convergence(self) -> ConvergenceOrders:
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

    def element_tensions(self, motion: RigidMotion) -> list[FloatArray]:
        """Axial force in each element under the motion's inertia forces, in N.

        With the crank held the linkage is statically determinate, so the linear static
        solution's axial force is that of the rigid linkage; it is quadratic along an
        element, and its mean is what the element's end displacements alone would give.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        list of ndarray, shape (B, e, 3)
            Legendre coefficients along each element: mean, linear, quadratic.
        """
        mechanism = self.mechanism
        forces = inverse_dynamics(
            mechanism.linkage.topology, motion, mechanism.link_masses_in_order, mechanism.gravity
        )
        tensions = []
        for link, nodes in enumerate(self.nodes):
            length = np.diff(nodes)
            inside = 1e-9 * length  # off the point masses that may sit at the nodes
            places = [nodes[:-1] + inside, nodes[:-1] + length / 2, nodes[1:] - inside]
            near, middle, far = (
                np.stack([forces.axial_force(link, float(x)) for x in place], axis=-1)
                for place in places
            )
            mean = (near + 4 * middle + far) / 6
            linear = (far - near) / 2
            quadratic = (near + far - 2 * middle) / 3
            tensions.append(np.stack([mean, linear, quadratic], axis=-1))
        return tensions

    def tangents(self, motion: RigidMotion, prestress: Prestress) -> list[FloatArray]:
        """Tangent stiffness of each link; see :meth:`Engine.tangents`."""
        unloaded = not motion.crank_speed.any() and not any(self.mechanism.gravity)
        if prestress == "none" or unloaded:
            return [link.stiffness for link in self.links]
        if prestress == "axial":
            return self._axial_tangents(motion)
        return self._equilibrium_tangents(motion)

    def _equilibrium_tangents(self, motion: RigidMotion) -> list[FloatArray]:
        varying = self._geometric(motion, varying_part_only=True)
        loads = inertia_loads(self.links, motion, self.mechanism.gravity)
        displacement = self.equilibrium.solve(motion, loads, varying)
        return [
            assemble_chain(tangent + extra)
            for tangent, extra in zip(
                self.equilibrium.tangents(displacement), varying, strict=True
            )
        ]

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
        for nodes, tension in zip(self.nodes, self.element_tensions(motion), strict=True):
            if varying_part_only:
                tension[..., 0] = 0.0
            matrices.append(geometric_stiffness(np.diff(nodes), tension))
        return matrices
