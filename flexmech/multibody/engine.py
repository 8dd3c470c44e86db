"""The Exudyn engine: the same mechanism from multibody beam elements."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.linear_system import (
    ConvergenceOrders,
    Engine,
    LinkModel,
    Prestress,
    element_tensions,
    inertia_loads,
    refuse_other_postures,
)
from flexmech.linkages import RigidMotion
from flexmech.multibody.linearize import (
    link_models,
    static_equilibrium,
    unit_tension_stiffness,
)
from flexmech.multibody.model import MultibodyModel

__all__ = ["ExudynEngine"]

FloatArray = NDArray[np.float64]


class ExudynEngine(Engine):
    """Links of Exudyn's ANCF cable or geometrically exact beam elements.

    Mass, stiffness and damping come from Exudyn's linearization, the quasi-static
    equilibrium from its static solver; the transformation to link frames is the one that
    all engines share. Parameters as for :class:`flexmech.linear_system.Engine`; the
    element is ``"ancf"`` or ``"geometrically-exact"``.
    """

    name: ClassVar[str] = "exudyn"
    element_kinds: ClassVar[tuple[str, ...]] = ("ancf", "geometrically-exact")

    def convergence(self, prestress: Prestress) -> ConvergenceOrders:
        """Cubic ANCF: fourth order; linear geometrically exact beam: second.

        Reference strains are constant in a cable, so tension given by them (``axial``)
        converges in second order.
        """
        if self.element == "ancf":
            return ConvergenceOrders(elastic=4, prestress=2 if prestress == "axial" else 4)
        return ConvergenceOrders(elastic=2, prestress=2)

    @cached_property
    def model(self) -> MultibodyModel:
        """The Exudyn system, moved through the crank angles."""
        return MultibodyModel(self.mechanism, self.elements, self.element)

    @cached_property
    def _links(self) -> tuple[LinkModel, ...]:
        return link_models(self.model)

    @property
    def links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models in Exudyn's coordinates, node by node."""
        return self._links

    @cached_property
    def _unit_tension(self) -> list[FloatArray]:
        return unit_tension_stiffness(self.model)

    def tangents(self, motion: RigidMotion, prestress: Prestress) -> list[FloatArray]:
        """Tangent stiffness of each link; see :meth:`Engine.tangents`."""
        unloaded = not motion.crank_speed.any() and not any(self.mechanism.gravity)
        if prestress == "axial" and self.element != "ancf":
            raise InputError(
                "prestress 'axial' needs an element that can carry tension in its straight "
                "shape; the geometrically exact beam cannot: use element 'ancf' or prestress "
                "'equilibrium'"
            )
        if prestress == "none" or unloaded:
            return [link.stiffness for link in self.links]
        if prestress == "axial":
            return self._axial_tangents(motion)
        loads = inertia_loads(self.links, motion, self.mechanism.gravity)
        equilibrium = static_equilibrium(self.model, motion, loads)
        topology = self.mechanism.linkage.topology
        refuse_other_postures(topology, self.links, motion, equilibrium.displacement)
        return equilibrium.tangent

    def _axial_tangents(self, motion: RigidMotion) -> list[FloatArray]:
        nodes = [part.positions for part in self.model.parts]
        tensions = element_tensions(self.mechanism, nodes, motion)
        return [
            link.stiffness + np.tensordot(tension[..., 0], unit, axes=1)
            for link, tension, unit in zip(self.links, tensions, self._unit_tension, strict=True)
        ]
