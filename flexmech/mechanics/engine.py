"""Engine: the contract and the common part of the finite-element engines."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.choices import (
    MODES,
    MOST_MODES,
    PRESTRESS_LEVELS,
    Prestress,
)
from flexmech.errors import InputError
from flexmech.linkages import RigidMotion, Topology, lumped_elements
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import checked_drive
from flexmech.mechanics.engine_parameters import EngineParameters, check_elastic
from flexmech.mechanics.joints.carried_linkage import CarriedLinkage
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.joints.position_errors import TooManyModesError
from flexmech.mechanics.links.body_forces import (
    DeadMoments,
    DisplacedInertia,
    turns_as_one_body,
    without_spin_softening,
)
from flexmech.mechanics.links.component_modes import (
    ComponentModes,
    FixedInterfaceLink,
    component_modes,
    fix_interfaces,
)
from flexmech.mechanics.links.link_inertia import inertia_loads
from flexmech.mechanics.links.link_model import LinkModel, StressedLinks
from flexmech.mechanics.links.link_readings import LinkStretch
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.mechanics.loads.connectors import ConnectedMatrices, Connectors
from flexmech.mechanics.prestress import (
    BalancedLoads,
    balanced_links,
    refuse_large_displacements,
    straight_forces,
    with_rigid_links,
)
from flexmech.mechanics.system import LinearSystem, assembled_system
from flexmech.validation import (
    POSITIVE,
    check_choice,
    check_count,
    check_number,
)

# A map of that many frequencies needs two more, among which it tracks modes.
SYSTEM_MODES = MODES + 2
# Cached reductions. Speed alone: a map over speeds needs some at each speed, and not again.
KEPT_REDUCTIONS = 16
# Working memory of a batch. Memory alone: what is alive at a time is independent of the map's size.
BATCH_BYTES = 32_000_000
# Speed alone: fewer positions take as long as these, however large their matrices are.
LEAST_BATCH = 4


class Engine(EngineParameters):
    """Turns a mechanism and crank positions into a :class:`LinearSystem`.

    An engine is a value: it does not change, and two that compute the same are equal.
    :meth:`with_` makes another one.

    It gives the links in frames that rotate as prescribed, with the shaft's rotation at zero. That
    of a free shaft is one more coordinate; it changes none of their states.

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
    solves_connectors : bool
        Whether the engine's own equilibrium includes loads and springs; otherwise their forces
        are applied as loads.
    simulates : bool
        Whether the engine runs the linkage with large displacements; see
        :mod:`flexmech.mechanics.running.recorded_run`.

    Raises
    ------
    InputError
        If the mechanism is none, the element unknown or the number of elements no such.
    """

    @property
    def lumped_mass_count(self) -> int:
        """Number of lumped masses; zero where mass is distributed."""
        if self._lumped is None:
            return 0
        elements = zip(self.mechanism.link_masses_in_order, self._lumped, strict=True)
        return sum(len(mass.lumps(count)) for mass, count in elements)

    @cached_property
    def _lumped(self) -> tuple[int, ...] | None:
        """Elements whose mass is lumped, by link; None where mass is distributed."""
        if self.mass == "distributed":
            return None
        return lumped_elements(self.mechanism.linkage.topology)

    @property
    def batch_size(self) -> int:
        """Number of positions to hold in memory at a time."""
        entries = sum(link.size**2 for link in self.links)
        return max(LEAST_BATCH, BATCH_BYTES // (8 * 4 * entries))

    def batches(self, count: int) -> list[slice]:
        """Batches of equal size for a number of positions.

        A batch may exceed :attr:`batch_size` by a quarter, which avoids a small last one: each
        batch takes some time however small it is. There is an empty one for no position alone.
        """
        number = max(1, math.ceil(count / self.batch_size - 1 / 4))
        edges = [count * place // number for place in range(number + 1)]
        return [slice(*both) for both in pairwise(edges)]

    def linear_system(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        *,
        prestress: Prestress = "equilibrium",
        rotation_terms: bool | RotationTerms = True,
        modes: int | None = None,
        fastest: float | None = None,
        detail: float | None = None,
        stressed: StressedLinks | None = None,
    ) -> LinearSystem:
        """Linear system at crank angles and speeds.

        Parameters
        ----------
        crank_angle, crank_speed : array_like
            In rad and rad/s; broadcast against each other and flattened to a batch of B.
        prestress : {"none", "axial", "equilibrium"}
        rotation_terms : bool or RotationTerms
            Terms of the turning frames; at crank speed zero they vanish.
        modes : int, optional
            Number of natural frequencies that the reduction must get right. Left out: six, or as
            many as there are.
        fastest : float, optional
            Greatest angular velocity of a link in the whole map in rad/s, by which the
            reduction is chosen; of this batch by default.
        detail : float, optional
            Multiplies the frequency up to which component modes are kept, whose error
            ``natural_frequencies`` measures; left out: all coordinates are kept.
        stressed : StressedLinks, optional
            Links to linearize about in these positions, in place of those of the prestress.

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
            check_number(fastest, "fastest", "rad/s")
        terms = RotationTerms.of(rotation_terms)
        angle, speed, _ = checked_drive(crank_angle, crank_speed, 0.0)
        if not angle.size:
            raise InputError("crank_angle is empty; give one crank angle or more")
        if stressed is None or (motion := stressed.motion) is None:
            motion = self.mechanism.linkage.motion(angle.ravel(), speed.ravel())
        if not motion.crank_speed.any():
            terms = RotationTerms.all_or_none(False)
        if stressed is None:
            stressed = self.stressed_links(motion, prestress)
        reduction = None
        if detail is not None and self.component_modes and not self.turns_as_one_body:
            greatest = self.fastest(motion) if fastest is None else abs(fastest)
            greatest = greatest if terms.any else 0.0
            loaded = not stressed.unstressed and any(t.ndim == 3 for t in stressed.tangent)
            reduction = self._reduction(modes or SYSTEM_MODES, greatest, loaded, detail)
        system = assembled_system(
            self.frames, reduction, motion, stressed, terms, self.connectors, prestress
        )
        if reduction is None and modes is not None and system.size < modes:
            raise TooManyModesError(
                f"modes: {modes} were asked for, the model has {system.size}; ask for fewer "
                "modes or more elements",
                most_modes=system.size,
            )
        carried = CarriedLinkage.of(self.mechanism, system.frames, self.links, system.bases)
        if carried is not None:
            matrices = SystemMatrices(system.mass, system.damping, system.stiffness)
            at = system.motion, matrices, terms, system.expansion
            matrices = carried.added(*at, prestress=prestress)
            system = replace(system, **vars(matrices), carried=carried)
        return replace(system, rigid_modes=self.rigid_modes, circulates=self.connectors.circulates)

    def _reduction(self, modes: int, fastest: float, loaded: bool, detail: float) -> ComponentModes:
        key = (modes, fastest, loaded, detail)
        if key not in self._reductions:
            if len(self._reductions) >= KEPT_REDUCTIONS:
                del self._reductions[next(iter(self._reductions))]
            self._reductions[key] = component_modes(
                self.topology,
                self.links,
                modes,
                fastest,
                couples_axially=loaded,
                detail=detail,
                with_damping_shapes=True,
                fixed=self.fixed_interface_links,
            )
        return self._reductions[key]

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
        if self._is_straight(motion, prestress):
            return replace(StressedLinks.unloaded(self.clamped_links), motion=motion)
        axial = prestress == "axial"
        stressed = self._axial(motion) if axial else self._equilibrium(motion, near)
        return self._in_motion(motion, stressed)

    def _in_motion(self, motion: RigidMotion, stressed: StressedLinks) -> StressedLinks:
        """Links under dead loads without the centrifugal stiffness of what turns on them."""
        inertia = self.displaced_inertia(motion)
        stressed = without_spin_softening(self.clamped_links, motion, stressed, inertia)
        return replace(stressed, motion=motion)

    def _equilibrium(self, motion: RigidMotion, near: Sequence[FloatArray] | None) -> StressedLinks:
        """Links at equilibrium without the shaft's inertia; see :meth:`stressed_links`."""

        def solve(under: BalancedLoads) -> StressedLinks:
            dead = self._dead(motion, under.loads, under.at)
            start = near if under.at is None else under.at
            elastic = self._elastic_equilibrium(motion, under.loads, dead, start)
            return self._under_dead_loads(motion, under.loads, elastic)

        stressed = balanced_links(
            self.connectors,
            self.clamped_frames,
            motion,
            inertia_loads(self.clamped_links, motion, self.mechanism.gravity),
            solve,
            displaced_inertia=self.displaced_inertia(motion),
            solve_connects=self.solves_connectors,
        )
        assert stressed.displacement is not None
        refuse_large_displacements(self.clamped_links, motion, stressed.displacement)
        return stressed

    @abstractmethod
    def _elastic_equilibrium(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        dead: DeadMoments,
        near: Sequence[FloatArray] | None,
    ) -> StressedLinks:
        """Clamped links at equilibrium under loads (B, n_link) and dead moments.

        With elastic tangents, forces and damping, as :meth:`running_links`.
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

    def _axial(self, motion: RigidMotion) -> StressedLinks:
        """Straight links with the geometric stiffness of their tension."""
        loads, frames, connectors = self._loads(motion), self.rigid_joint_frames, self.connectors
        virial = connectors.virial(motion)
        dead = DeadMoments.of(self.clamped_links, motion, self.mechanism.gravity, loads, virial)
        forces, of_rigid = straight_forces(
            self.mechanism, frames, motion, loads, dead, connectors, self._lumped
        )
        straight = [np.zeros_like(load.T) for load in loads]
        tangents = dead.add_stiffness(self._tensioned(motion, forces), straight)
        return with_rigid_links(frames, tangents, of_rigid)

    @abstractmethod
    def _tensioned(self, motion: RigidMotion, forces: LinkForces) -> dict[int, FloatArray]:
        """Tangents (B, n_link, n_link) of the flexible straight links under forces in them."""

    def _under_dead_loads(
        self, motion: RigidMotion, loads: Sequence[FloatArray], elastic: StressedLinks
    ) -> StressedLinks:
        """Displaced links with the geometric stiffness of what turns on them.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
            Forces on the links, without those that the engine solves for.
        elastic : StressedLinks
            Elastic tangents, forces and damping. What dead moments lose as bodies turn becomes a
            force in their links, in place.
        """
        frames, displacement = self.clamped_frames, elastic.displacement
        inner = elastic.internal_force
        assert displacement is not None
        assert inner is not None
        columns, of_rigid = [q.T for q in displacement], None
        dead = self._dead(motion, loads, displacement)
        pairs = enumerate(zip(self.clamped_links, elastic.tangent, strict=True))
        flexible = {number: tangent for number, (link, tangent) in pairs if not link.rigid}
        tangents = dead.add_stiffness(flexible, columns)
        dead.add_forces([force.T for force in inner], columns)
        if frames.has_arms:
            beside = [load - force for load, force in zip(loads, inner, strict=True)]
            by_rotation = dead.by_link(columns)
            pushes = self.connectors.radial_forces(motion, displacement)
            if self.solves_connectors:
                pushes += self.connectors.point_forces(motion, displacement)
            for push in pushes:
                link, q = push.point.link, displacement[push.point.link]
                beside[link] += push.on_link(motion, q)
                if push.point.rigid:
                    by_rotation[link] = by_rotation[link] + push.rotation_stiffness(motion, q)
            ties = frames.displaced_ties_by(motion, displacement)
            of_rigid = ties.geometric_stiffness(beside, by_rotation)
        stiffened = with_rigid_links(frames, tangents, of_rigid)
        # A rigid link that turns meets its tangent as it is, against the forces that cause it.
        for turned in np.flatnonzero([link.rigid for link in self.clamped_links]).tolist():
            at = displacement[turned][..., None]
            inner[turned][:] = (stiffened.tangent[turned] @ at)[..., 0]
        guides = stiffened.guide_stiffness
        return replace(elastic, tangent=stiffened.tangent, guide_stiffness=guides)

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

    @abstractmethod
    def internal_forces(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Elastic forces of displaced links, none of rigid ones.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            Elastic displacement of each link in its frame.

        Returns
        -------
        list of ndarray, shape (B, n_link)
        """

    @abstractmethod
    def running_links(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Elastic tangent stiffness, internal forces and damping of displaced links.

        Effects of inertia on turning bodies and rigid links are not among them.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            Elastic displacement of each link in its frame.
        rate : sequence of ndarray, shape (B, n_link), optional
            Its time derivative, at which the tangents have the change of the damping forces by
            the displacement as well.

        Returns
        -------
        StressedLinks
        """

    @property
    def has_damped_links(self) -> bool:
        """Whether a link is damped."""
        return any(link.damping.any() for link in self.clamped_links)

    def connected_matrices(
        self,
        frames: LinkFrames,
        motion: RigidMotion,
        prestress: Prestress,
        stressed: StressedLinks,
    ) -> ConnectedMatrices | None:
        """Stiffness and damping between links: of loads and springs, and of guides under forces.

        Parameters
        ----------
        frames : LinkFrames
            Frames of the links, reduced or not.
        motion : RigidMotion
            Batch of shape (B,).
        prestress : {"none", "axial", "equilibrium"}
        stressed : StressedLinks
            The state about which to linearize.

        Returns
        -------
        ConnectedMatrices or None
            In the coordinates of ``frames``; None where nothing acts between links.
        """
        connected = None
        if self.connectors.any:
            connected = self.connectors.matrices(frames, motion, prestress, stressed.displacement)
        if stressed.guide_stiffness is None or not stressed.guide_stiffness.any():
            return connected
        guides = frames.guide_matrix(motion, stressed.guide_stiffness)
        if connected is not None:
            return replace(connected, stiffness=connected.stiffness + guides)
        zero = np.zeros_like(guides)
        return ConnectedMatrices(guides, zero, zero, is_conservative=True)

    def fastest(self, motion: RigidMotion) -> float:
        """Greatest angular velocity of a link in a motion in rad/s."""
        return float(np.abs(motion.angular_velocity).max(initial=0.0))

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


# Change along the turn, relative to the greatest value, that round-off makes: some five hundred
# times the unit round-off, of sums over the elements. A load of 1e-3 of the others is none.
UNCHANGED = 1e-13


def has_relative_motion(topology: Topology) -> bool:
    """Whether a link turns against another one or slides, so that the constraints vary.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    bool
    """
    return bool(topology.pins or topology.sliders)


def all_constant(arrays: Iterable[FloatArray], size: float = 0.0) -> bool:
    """Whether arrays (B, ...) are constant over the positions, up to round-off.

    Parameters
    ----------
    arrays : iterable of ndarray, shape (B, ...)
        Empty ones are the same.
    size : float
        To which round-off is relative where the arrays' own size is less.

    Returns
    -------
    bool
    """
    return all(
        not array.size or np.ptp(array, axis=0).max() <= UNCHANGED * max(np.abs(array).max(), size)
        for array in arrays
    )


def has_constant_tangents(tangents: ConnectedMatrices, motion: RigidMotion) -> bool:
    """Whether stiffness and damping of connectors are constant over the positions.

    Parameters
    ----------
    tangents : ConnectedMatrices
        Over a batch of shape (B,).
    motion : RigidMotion
        Motion of that batch.

    Returns
    -------
    bool
    """
    # A spring without tension pulls by round-off, which damping forces are large against.
    turning = float(np.abs(motion.crank_speed).max() * np.abs(tangents.damping).max())
    return all_constant((tangents.stiffness + tangents.rate_stiffness, tangents.damping), turning)


def is_constant_turn(engine: Engine, motion: RigidMotion) -> bool:
    """Whether all forces on the links are constant in the link frames over the positions.

    It is computed: the frame stands, no link turns against another one, and the forces of inertia,
    gravity, loads and springs on the straight links, and the stiffness of springs, are constant.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).

    Returns
    -------
    bool
    """
    if has_relative_motion(engine.topology) or engine.mechanism.frame is not None:
        return False
    links, connectors = engine.clamped_links, engine.connectors
    # Together: a spring without tension pulls by round-off, which differs at all positions.
    loads = connectors.with_inertia(links, motion)
    if not all_constant((motion.angular_velocity, motion.angular_acceleration, *loads)):
        return False
    tangents = connectors.matrices(engine.rigid_joint_frames, motion, "equilibrium")
    return has_constant_tangents(tangents, motion)


def stressed_along_turn(
    engine: Engine,
    motion: RigidMotion,
    prestress: Prestress,
    near: Sequence[FloatArray] | None = None,
) -> StressedLinks:
    """Stressed links over a turn; where all is constant, one position is solved for all.

    Solved one by one, positions differ by the tolerance of their equilibria, and Floquet's theory
    would take what is constant for periodic: a stability map of Exudyn takes four times as long.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).
    prestress : {"none", "axial", "equilibrium"}
    near : sequence of ndarray, shape (B, n_link), optional
        As of :meth:`flexmech.mechanics.Engine.stressed_links`.

    Returns
    -------
    StressedLinks
        Stressed links at all positions.

    Raises
    ------
    ComputationError
        If the equilibrium does not converge or is unstable; names the crank angle.
    """
    if not is_constant_turn(engine, motion):
        return engine.stressed_links(motion, prestress, near)
    first = slice(0, 1)
    start = None if near is None else [q[first] for q in near]
    stressed = engine.stressed_links(motion.at(first), prestress, start)
    every = np.zeros(len(motion.crank_angle), dtype=np.intp)
    return replace(stressed.at(every), motion=None)
