"""Stressed links of an engine with a prescribed or a free shaft."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.errors import InputError
from flexmech.linear_system.assembly.balanced_loads import BalancedLoads, Solve, balanced_loads
from flexmech.linear_system.assembly.element_kinds import ElementKinds
from flexmech.linear_system.assembly.free_shaft import FreeShaft
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.links.body_forces import (
    DeadMoments,
    DisplacedInertia,
    turns_as_one_body,
    without_spin_softening,
)
from flexmech.linear_system.links.link_inertia import inertia_loads
from flexmech.linear_system.links.link_model import LinkModel, StressedLinks
from flexmech.linear_system.links.link_readings import LinkStretch
from flexmech.linear_system.loads.connectors import ConnectedMatrices, Connectors
from flexmech.linear_system.reduction.component_modes import (
    FixedInterfaceLink,
    fix_interfaces,
)
from flexmech.linkages import RigidMotion, Topology
from flexmech.mechanism import Mechanism, require_standing_frame


class EngineLinks(ElementKinds):
    """Link models of an engine from which its linear systems are assembled.

    An engine gives the links in frames that rotate as prescribed, with the shaft's rotation at
    zero. That of a free shaft is one more coordinate; it changes none of their states.

    Attributes
    ----------
    name : str
    mechanism : Mechanism
    solves_connectors : bool
        Whether the engine's own equilibrium includes loads and springs; otherwise their forces
        are applied as loads.
    members : tuple of EngineLinks
        Of a stack the engines of its designs; see :func:`flexmech.linear_system.stack_engines`.
    """

    name: ClassVar[str]
    solves_connectors: ClassVar[bool] = False
    mechanism: Mechanism
    free_shaft: FreeShaft | None
    members: tuple[EngineLinks, ...] = ()

    @cached_property
    def topology(self) -> Topology:
        """Links and connections of the linear system; the clamp says whether the shaft is free."""
        shaft = self.free_shaft
        return self.mechanism.linkage.topology if shaft is None else shaft.topology

    @cached_property
    def rigid_joint_topology(self) -> Topology:
        """Links and connections with rigid joints in place of springs."""
        return self.mechanism.linkage.topology.with_rigid_joints()

    @cached_property
    def links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models in the topology's order, with the inertia of a free shaft."""
        clamped = self.clamped_links
        return clamped if self.free_shaft is None else self.free_shaft.links(clamped)

    @cached_property
    def frames(self) -> LinkFrames:
        """Link frames and constraints of the unreduced links."""
        return LinkFrames(self.topology, self.links)

    @cached_property
    def clamped_frames(self) -> LinkFrames:
        """Link frames and constraints with the shaft's rotation at zero."""
        if self.free_shaft is None:
            return self.frames
        return LinkFrames(self.mechanism.linkage.topology, self.clamped_links)

    @cached_property
    def rigid_joint_frames(self) -> LinkFrames:
        """Link frames and constraints with rigid joints in place of springs, and a held shaft."""
        if self.rigid_joint_topology == self.mechanism.linkage.topology:
            return self.clamped_frames
        return LinkFrames(self.rigid_joint_topology, self.clamped_links)

    @cached_property
    def fixed_interface_links(self) -> tuple[FixedInterfaceLink, ...]:
        """Constraint modes and fixed-interface modes of the flexible links."""
        return fix_interfaces(self.topology, self.links, self.connectors.end_forces())

    @property
    @abstractmethod
    def clamped_links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models in the topology's order, without the shaft's inertia."""

    @property
    def stretches(self) -> tuple[LinkStretch, ...] | None:
        """Second-order stretch of each link; None where an engine does not provide it.

        None as well where links bend or stretch without load, since it is that of straight links.
        """
        return None

    def stressed_links(
        self,
        motion: RigidMotion,
        prestress: Prestress,
        near: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Tangent stiffness of each link in its frame under the motion's inertia forces.

        The equilibrium is that with a prescribed shaft, whether it is free or not.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        prestress : {"none", "axial", "equilibrium"}
        near : sequence of ndarray, shape (B, n_link), optional
            Elastic displacement of each link near that at equilibrium, which an engine may take
            as the start of its iteration; it starts from straight links by default.

        Returns
        -------
        StressedLinks

        Raises
        ------
        ComputationError
            If the equilibrium does not converge or is unstable; names the crank angle.
        """
        stressed = self.stressed_clamped_links(motion, prestress, near)
        if not self._is_straight(motion, prestress):
            stressed = self._without_spin_softening(motion, stressed)
        return replace(stressed, motion=motion)

    @abstractmethod
    def stressed_clamped_links(
        self,
        motion: RigidMotion,
        prestress: Prestress,
        near: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Stressed links without the shaft's inertia; see :meth:`stressed_links`.

        Parameters
        ----------
        motion : RigidMotion
        prestress : {"none", "axial", "equilibrium"}
        near : sequence of ndarray, shape (B, n_link), optional

        Returns
        -------
        StressedLinks
        """

    @property
    def axial_modes_of_bows(self) -> int:
        """Number of axial modes that a bowed link needs to bend without stretch.

        Zero where a few smooth ones are enough: where elements stretch by their ends alone.
        """
        return 0

    @property
    def prestress_at_rest(self) -> Prestress:
        """Prestress level of the linkage at rest.

        ``none``, unless links bend without load or loads and springs act on them.
        """
        bent = self.mechanism.is_free_strained or self.connectors.any
        return "equilibrium" if bent else "none"

    def _loads(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None = None
    ) -> list[FloatArray]:
        """Inertia forces, weight, loads and springs on the clamped links, (B, n_link)."""
        return self.connectors.with_inertia(self.clamped_links, motion, displacement)

    def equilibrium_forces(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Forces on the links that their internal forces balance, up to joint forces.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            At quasi-static equilibrium.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Inertia forces, weight, loads and springs, and :meth:`displaced_inertia`.
        """
        forces = self.connectors.with_inertia(self.links, motion, displacement)
        inertia = self.displaced_inertia(motion)
        if inertia is None:
            return forces
        return [f + more for f, more in zip(forces, inertia.forces(displacement), strict=True)]

    def _without_spin_softening(
        self, motion: RigidMotion, stressed: StressedLinks
    ) -> StressedLinks:
        return without_spin_softening(
            self.clamped_links, motion, stressed, self.displaced_inertia(motion)
        )

    def displaced_inertia(self, motion: RigidMotion) -> DisplacedInertia | None:
        """Inertia forces by displacements of links that rotate as one body; else None."""
        return DisplacedInertia.of(self.mechanism.linkage.topology, self.clamped_links, motion)

    def _dead(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        displacement: Sequence[FloatArray] | None = None,
    ) -> DeadMoments:
        """Moments on bodies and rigid links of loads (B, n_link) at a displacement."""
        links, gravity, virial, moments = self.clamped_links, self.mechanism.gravity, None, None
        if self.connectors.any and not self.solves_connectors:
            virial = self.connectors.virial(motion, displacement)
        if displacement is not None and (inertia := self.displaced_inertia(motion)) is not None:
            moments = inertia.moments(displacement)
        return DeadMoments.of(links, motion, gravity, loads, virial, moments)

    def _quasi_static_loads(self, motion: RigidMotion, solve: Solve) -> BalancedLoads:
        """Loads on the clamped links in the equilibrium that ``solve`` finds."""
        loads = inertia_loads(self.clamped_links, motion, self.mechanism.gravity)
        return balanced_loads(
            self.connectors,
            self.clamped_frames,
            motion,
            loads,
            solve,
            lambda displacement: self.running_clamped_links(motion, displacement).tangent,
            displaced_inertia=self.displaced_inertia(motion),
            solve_connects=self.solves_connectors,
        )

    def _is_straight(self, motion: RigidMotion, prestress: Prestress) -> bool:
        """Whether the links are linearized about the straight, stress-free state."""
        if self.mechanism.is_free_strained:
            if prestress != "equilibrium":
                raise InputError(
                    f"prestress {prestress!r} is of straight links, but moisture or heat bends or "
                    "stretches some of these; use prestress 'equilibrium'"
                )
            return False
        loaded = motion.crank_speed.any() or any(self.mechanism.gravity) or self.connectors.any
        return prestress == "none" or not loaded

    def running_links(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> StressedLinks:
        """Tangent stiffness, internal forces and damping in states of the running linkage.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            Elastic displacement of each link in its frame.

        Returns
        -------
        StressedLinks
        """
        stressed = self.running_clamped_links(motion, displacement)
        return replace(self._without_spin_softening(motion, stressed), motion=motion)

    @abstractmethod
    def running_clamped_links(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> StressedLinks:
        """Running links without the shaft's inertia; see :meth:`running_links`."""

    def damping_stiffness(
        self, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> Sequence[FloatArray] | None:
        """Derivative of the links' damping forces by their displacement at given rates.

        Parameters
        ----------
        displacement, rate : sequence of ndarray, shape (B, n_link)
            Of each link in its frame, and its time derivative.

        Returns
        -------
        sequence of ndarray, shape (B, n_link, n_link), or None
            None where no link is damped, or an engine does not provide it.
        """
        del displacement, rate
        return None

    def connected_matrices(
        self,
        frames: LinkFrames,
        motion: RigidMotion,
        prestress: Prestress,
        displacement: Sequence[FloatArray] | None,
    ) -> ConnectedMatrices | None:
        """Stiffness and damping of loads and springs.

        Parameters
        ----------
        frames : LinkFrames
            Of the links, reduced or not.
        motion : RigidMotion
            Batch of shape (B,).
        prestress : {"none", "axial", "equilibrium"}
        displacement : sequence of ndarray, shape (B, n_link), or None
            Of the unreduced links in the state about which to linearize.

        Returns
        -------
        ConnectedMatrices or None
            In the coordinates of ``frames``; None where there are no loads and springs.
        """
        if not self.connectors.any:
            return None
        return self.connectors.matrices(frames, motion, prestress, displacement)

    def require_prescribed_shaft(self, what: str = "this computation") -> None:
        """Refuse a free shaft where the crank's motion is prescribed.

        Parameters
        ----------
        what : str
            Computation in which it is.

        Raises
        ------
        InputError
            If the shaft is free.
        """
        if self.free_shaft is not None:
            raise InputError(
                f"{what} turns the shaft as prescribed, and that of this engine is free; "
                "use shaft 'prescribed'"
            )

    def require_standing_frame(self, what: str = "this computation") -> None:
        """Refuse a frame on springs where the linkage is on the ground.

        Parameters
        ----------
        what : str
            Computation in which it is.

        Raises
        ------
        InputError
            If the mechanism has a frame on springs.
        """
        require_standing_frame(self.mechanism.frame, what)

    def fastest(self, motion: RigidMotion) -> FloatArray:
        """Greatest angular velocity of a link in a motion in rad/s, (1,); (D,) of a stack."""
        every = np.abs(motion.angular_velocity).reshape(len(self.members) or 1, -1)
        return np.asarray(every.max(axis=1, initial=0.0))

    @property
    def likeness_of_links(self) -> Hashable | None:
        """What the links of several designs must have in common to be stacked.

        None where the engine does not stack them.
        """
        return None

    @property
    def turns_as_one_body(self) -> bool:
        """Whether all links rotate with the shaft as one body.

        Such links are not reduced. Component modes of straight links do not contain the rigid
        rotation of a stretched free one, which would then meet a force, nor the bending without
        stretch of one that is bowed far.
        """
        return turns_as_one_body(self.mechanism.linkage.topology)

    @property
    def rigid_modes(self) -> int:
        """Number of rigid-body modes at rest: that of a shaft that turns freely."""
        return 0 if self.free_shaft is None or self.connectors.restrains_shaft else 1

    @cached_property
    def connectors(self) -> Connectors:
        """Loads on the links and springs between them."""
        return Connectors(self.mechanism, self.links)
