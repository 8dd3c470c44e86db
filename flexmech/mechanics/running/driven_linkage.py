"""Driven linkage: linear equations of motion in link frames with time-varying matrices.

``M(t) z'' + C(t) z' + K(t) z = f(t)``: the matrices of
:mod:`flexmech.mechanics.joints.link_frames` with all rotation terms, the inertia forces of the
rigid motion and weight as load. Links are reduced to component modes whose constraint
modes rotate with the pins as a whole (Galerkin): a response in time does not depend on the frame in
which it is written, as frozen eigenvalues do. Axial modes above
the frequencies of interest are condensed: a bowed link stretches when it bends.

They are linear about straight links, or their quasi-static equilibrium. On request links stretch by
half the square of their slopes (:class:`LinkageStretch`); then no axial mode is condensed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.dynamical_systems import EquationsOfMotion, VibrationState
from flexmech.errors import ComputationError
from flexmech.linkages import Drive, RigidMotion, Topology
from flexmech.mechanics import (
    COORDINATES,
    CarriedLinkage,
    ComponentModes,
    Engine,
    LinkFrames,
    Prestress,
    RotationTerms,
    SystemMatrices,
    component_modes,
    condense,
    inertia_loads,
)
from flexmech.mechanics.running.driven_connectors import DrivenConnectors
from flexmech.mechanics.running.driven_shaft import DrivenShaft, ShaftTorque
from flexmech.mechanics.running.linkage_stretch import LinkageStretch
from flexmech.mechanics.running.natural_coordinates import (
    RunLink,
    natural_links,
    with_turning_sections,
)
from flexmech.mechanics.running.recorded_run import FrameMotion, LinkState
from flexmech.mechanics.running.stress_history import StressHistory

# A start at speed shakes more than the lowest modes: component modes are kept up to this
# many times the frequency that the natural frequencies themselves would need.
DETAIL = 8.0
# Axial modes of a link that a bow couples to bending, at the usual detail. Of bell cranks and other
# chains that bow by their neighbours' couples half of them leave errors of 1e-4.
AXIAL_MODES = 12
# Axial modes of a link that stretches by the square of its slopes. Its tension is a constant
# and as many waves along the link, whose lowest are all that the lowest bending modes feel.
STRETCHING_MODES = 3
# Newton's method for a start in balance takes four passes from the linear one; 30 are a bound of
# work. It ends at a change of the greatest displacement whose square is less than round-off. Beside
# stiff bars of rigid links that is larger: a small change that no longer falls is made of it.
MOST_PASSES = 30
CONVERGED = 1e-10
STAGNATED = 1e-7
# Displacements in m, and slopes, that are none: links without load rest in round-off of the start.
NOTHING = 1e-12


def unreduced_links(engine: Engine) -> list[RunLink]:
    """The engine's links unreduced; links with massless nodes are refused."""
    engine.check_runs()
    return list(map(RunLink.of, engine.links))


def _in_modes(links: Sequence[RunLink], reduction: ComponentModes) -> list[RunLink]:
    """Links with constraint modes that rotate with the pins."""
    return [
        replace(
            link,
            reduced=replace(model, reduced_ends=None),
            basis=modes.basis,
            condensed=modes.condensed,
        )
        for link, model, modes in zip(links, reduction.models, reduction.links, strict=True)
    ]


def is_reduced(engine: Engine) -> bool:
    """Whether an engine's linear equations in time are reduced to component modes.

    Those of links that are bent without load are not: modes of straight links do not contain
    the approach of the ends of a deep bow (2 % of the deflections of a coupler of
    280 mm that is bowed by 8 mm, of which double the detail recovers a tenth).
    Nor are links that rotate as one body on a free shaft: see
    :attr:`flexmech.mechanics.Engine.turns_as_one_body`.

    Parameters
    ----------
    engine : Engine

    Returns
    -------
    bool
    """
    if engine.shaft == "free" and engine.turns_as_one_body:
        return False
    return engine.component_modes and not engine.mechanism.is_free_strained


def stretches_in_runs(engine: Engine, prestress: Prestress) -> bool:
    """Whether a run by an engine's linear equations includes the second-order stretch.

    Parameters
    ----------
    engine : Engine
        One that simulates runs without them.
    prestress : {"none", "axial", "equilibrium"}

    Returns
    -------
    bool
    """
    return prestress == "equilibrium" and not engine.simulates and engine.stretches is not None


def stretching_links(engine: Engine, modes: int, detail: float) -> tuple[Topology, list[RunLink]]:
    """Links for a run with second-order stretch, without condensed axial modes.

    Slopes stretch a link along its chord, whose direction does not depend on a bow.

    Parameters
    ----------
    engine : Engine
    modes : int
    detail : float
        As of :func:`prestressed_links`.

    Returns
    -------
    Topology
        Whose moving rigid links are elastic bars.
    list of RunLink
    """
    topology, links = natural_links(engine)
    if is_reduced(engine):
        reduction = component_modes(
            topology,
            [link.model for link in links],
            modes,
            0.0,
            couples_axially=True,
            detail=detail,
            axial_modes=round(STRETCHING_MODES * max(1.0, detail / DETAIL)),
            turning_sections=False,
        )
        links = _in_modes(links, reduction)
    else:
        engine.check_runs()
    return topology, [
        with_turning_sections(engine, topology, *numbered) for numbered in enumerate(links)
    ]


def prestressed_links(
    engine: Engine, drive: Drive, prestress: Prestress, modes: int, detail: float
) -> list[RunLink]:
    """Links for linear equations at a level of prestress.

    Parameters
    ----------
    engine : Engine
    drive : Drive
    prestress : {"none", "axial", "equilibrium"}
    modes : int
        Number of natural frequencies for which the reduction is accurate.
    detail : float
        Multiplies the frequency up to which component modes are kept.

    Returns
    -------
    list of RunLink
    """
    if not is_reduced(engine):
        return unreduced_links(engine)
    motion = drive.motion(engine.mechanism.linkage, drive.passing_times)
    return _in_modes(
        list(map(RunLink.of, engine.links)),
        component_modes(
            engine.topology,
            engine.links,
            modes,
            float(np.abs(motion.angular_velocity).max()),
            couples_axially=prestress == "equilibrium",
            detail=detail,
            axial_modes=max(
                round(AXIAL_MODES * max(1.0, detail / DETAIL)), engine.axial_modes_of_bows
            ),
        ),
    )


@dataclass(frozen=True)
class StaticExpansion:
    """All coordinates of the frames by z, and by the loads, at m instants (static condensation).

    Parameters
    ----------
    matrix : ndarray, shape (m, size, n) or (1, n, n)
        From z to the coordinates of the frames; one unit matrix where none is condensed.
    offset : ndarray, shape (m, size)
        What the loads alone add to the condensed ones.
    """

    matrix: FloatArray
    offset: FloatArray

    @classmethod
    def of_all(cls, size: int) -> Self:
        """Expansion of ``size`` coordinates of which none is condensed."""
        return cls(np.eye(size)[None], np.zeros((1, size)))

    def under(
        self, force: FloatArray, flexibility: FloatArray, eliminated: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray]:
        """What forces on all coordinates add to the condensed ones, and those forces on z.

        Parameters
        ----------
        force : ndarray, shape (m, size)
        flexibility : ndarray, shape (m, i, i)
            Flexibility of the condensed coordinates.
        eliminated : ndarray of bool, shape (size,)
            Coordinates that are condensed.

        Returns
        -------
        ndarray, shape (m, size)
            To add to ``offset``.
        ndarray, shape (m, n)
        """
        offset = np.zeros_like(force)
        offset[:, eliminated] = (flexibility @ force[:, eliminated, None])[..., 0]
        return offset, (force[:, None] @ self.matrix)[:, 0]

    def expanded(self, vibration: VibrationState) -> tuple[FloatArray, FloatArray, FloatArray]:
        """All coordinates of the frames and their time derivatives, each (m, size).

        Parameters
        ----------
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        tuple of ndarray
        """
        parts = (vibration.position, vibration.velocity, vibration.acceleration)
        if self.matrix.shape[1] == self.matrix.shape[2]:
            return parts
        position, velocity, acceleration = (
            (self.matrix @ values[..., None])[..., 0] for values in parts
        )
        return position + self.offset, velocity, acceleration


@dataclass(frozen=True)
class Equations(EquationsOfMotion):
    """Equations of motion of a linkage at m instants.

    Parameters
    ----------
    mass, damping, stiffness : ndarray, shape (m, n, n)
    force : ndarray, shape (m, n)
    motion : RigidMotion
        Batch of shape (m,).
    expansion : StaticExpansion
        To the condensed coordinates of the frames.
    flexibility : ndarray, shape (m, i, i)
        Flexibility of the condensed coordinates.
    """

    motion: RigidMotion
    expansion: StaticExpansion
    flexibility: FloatArray

    @classmethod
    def condensed(
        cls,
        motion: RigidMotion,
        matrices: SystemMatrices,
        force: FloatArray,
        eliminated: NDArray[np.bool_],
    ) -> Self:
        """Equations after static condensation of some coordinates (Guyan, 1965).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        matrices : SystemMatrices
            Matrices of all coordinates of the frames.
        force : ndarray, shape (m, size)
        eliminated : ndarray of bool, shape (size,)
            Coordinates that are condensed.

        Returns
        -------
        Equations
        """
        inner = np.flatnonzero(eliminated)
        flexibility = np.asarray(
            np.linalg.inv(matrices.stiffness[:, inner[:, None], inner]), dtype=float
        )
        expansion = StaticExpansion.of_all(len(eliminated))
        if len(inner):
            matrices, matrix = condense(matrices, eliminated)
            expansion = StaticExpansion(matrix, np.zeros_like(force))
            offset, force = expansion.under(force, flexibility, eliminated)
            expansion = StaticExpansion(matrix, offset)
        parts = matrices.mass, matrices.damping, matrices.stiffness, force
        return cls(*parts, motion, expansion, flexibility)


class DrivenLinkage:
    """Linear equations of motion of an engine's links under a drive.

    Parameters
    ----------
    engine : Engine
        With component modes or without.
    drive : Drive
    prestress : {"none", "axial", "equilibrium"}
        ``equilibrium`` linearizes about that, whose displacement is part of the response.
    modes : int
        Number of natural frequencies for which the reduction is accurate.
    detail : float
        Multiplies the frequency up to which component modes are kept.
    stretches : bool
        Let straight links stretch in place of a prestress; see :func:`stretches_in_runs`.
    shaft_torque : ShaftTorque, optional
        Shaft torque of a motor on a free shaft.

    Attributes
    ----------
    links : tuple of LinkModel
        Reduced.
    unreduced : tuple of LinkModel
        Links of the run: those of the engine, or in natural coordinates for large rotations.
    bases, run_bases : tuple of ndarray, shape (n_full, n)
        From each reduced link's coordinates to the engine's, and to those of ``unreduced``.
    frames : LinkFrames
    connectors : DrivenConnectors
        Loads and springs.
    stretch : LinkageStretch or None
        Second-order stretch, besides the linear equations.
    shaft : DrivenShaft or None
        A shaft that is free.
    rotor : RotorCoupling or None
        On a coupling to that, whose coordinate comes after those of the links.
    carried : CarriedLinkage or None
        With the frame on springs that carries the linkage, whose coordinates are the last three.
    condensed : ndarray of bool, shape (size,)
        Which coordinates of the frames are condensed statically.
    stress : StressHistory
        Stress of the reduced links.
    """

    def __init__(
        self,
        engine: Engine,
        drive: Drive,
        prestress: Prestress = "equilibrium",
        *,
        modes: int = MODES,
        detail: float = DETAIL,
        stretches: bool = False,
        shaft_torque: ShaftTorque | None = None,
    ) -> None:
        self.engine, self.drive, self.prestress = engine, drive, prestress
        topology = engine.topology
        if stretches:
            topology, links = stretching_links(engine, modes, detail)
        else:
            links = prestressed_links(engine, drive, prestress, modes, detail)
        self.links = tuple(link.reduced for link in links)
        self.unreduced = tuple(link.model for link in links)
        self.run_bases = tuple(link.basis for link in links)
        self.bases = tuple(link.to_engine @ link.basis for link in links)
        self._from_engine = [link.from_engine for link in links]
        self.frames = LinkFrames(topology, self.links)
        self.carried = CarriedLinkage.of(
            engine.mechanism, self.frames, self.unreduced, self.run_bases
        )
        self._motor = shaft_torque
        self.rotor = None if shaft_torque is None else shaft_torque.coupling
        others = int(self.rotor is not None) + self._frame_size
        self.stretch = None
        if stretches:
            self.stretch = LinkageStretch(engine, self.frames, links, others)
        self.shaft = DrivenShaft.of(engine, drive, self.frames, links, shaft_torque)
        turns_far = self.shaft is not None and self.shaft.is_natural
        self.connectors = DrivenConnectors(engine, self.frames, follower_torque=turns_far)
        self.condensed = np.zeros(self.frames.size + others, dtype=bool)
        for target, link in zip(self.frames.targets, links, strict=True):
            self.condensed[target[link.condensed]] = True
        self.stress = StressHistory(
            engine,
            self.unreduced,
            self.run_bases,
            drive,
            "none" if stretches and not turns_far else prestress,
            equilibrium_of=self.bases if turns_far else None,
        )

    @property
    def size(self) -> int:
        """Number of independent coordinates."""
        return int(np.sum(~self.condensed))

    @property
    def _frame_size(self) -> int:
        """Number of coordinates of a frame on springs."""
        return 0 if self.carried is None else COORDINATES

    @property
    def rotor_coordinate(self) -> int:
        """Number of the coordinate of a rotor on a coupling, counted from the last one on."""
        return -1 - self._frame_size

    @property
    def shaft_coordinates(self) -> list[int]:
        """Numbers of the coordinates by which a free shaft and a rotor on a coupling turn."""
        if self.shaft is None:
            return []
        [column] = np.flatnonzero(self.shaft.coordinate)
        columns = [int(np.sum(~self.condensed[:column]))]
        return columns if self.rotor is None else [*columns, self.size + self.rotor_coordinate]

    @property
    def is_condensed(self) -> bool:
        """Whether some coordinates of the frames are condensed statically."""
        return bool(self.condensed.any())

    def motion(self, time: FloatArray) -> RigidMotion:
        """Rigid motion at times of shape (m,)."""
        return self.drive.motion(self.engine.mechanism.linkage, time)

    def loads(self, motion: RigidMotion) -> list[FloatArray]:
        """Inertia forces of the rigid motion and weight on each reduced link, (m, n)."""
        full = inertia_loads(self.unreduced, motion, self.engine.mechanism.gravity)
        return [load @ basis for load, basis in zip(full, self.run_bases, strict=True)]

    def step_forces(self, time: FloatArray) -> FloatArray | None:
        """Forces on all coordinates that are not interpolated, those of loads over tables.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.

        Returns
        -------
        ndarray, shape (m, size), or None
            Of condensed coordinates as well; None if there are none.
        """
        if not self.connectors.has_tables:
            return None
        motion = self.motion(time)
        force = self.connectors.force(motion, time, smooth=False)
        if self.shaft is not None and not self.shaft.has_motor:
            force += self.shaft.force(motion, self.shaft.balance(motion, force))
        return np.pad(force, ((0, 0), (0, len(self.condensed) - self.frames.size)))

    def equations(
        self, time: FloatArray, *, frozen: bool = False, tables: bool = True
    ) -> Equations:
        """Equations of motion.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        frozen : bool
            Leave out the rotation terms, as in the frozen inertial form.
        tables : bool
            Whether the loads of :meth:`step_forces` count.

        Returns
        -------
        Equations
        """
        motion, stress = self.motion(time), self.stress.at(time)
        force, torque = self.frames.gather(motion, self.loads(motion)), None
        if self.connectors.any:
            force += self.connectors.force(motion, time, tables=tables)
        if self.shaft is not None:
            torque, pull = self.shaft.torque(time, motion, force)
            force += self.shaft.force(motion, pull)
        force += self.frames.gather(motion, [-s.prestress for s in stress])
        if self.carried is not None:
            force = np.concatenate([force, self.carried.load(motion, time)], axis=1)
        if self._motor is not None:
            turning = self.drive.crank_acceleration(time)
            force = self._motor.forces(time, force, turning, self.frames.size)
        terms = RotationTerms.all_or_none(not frozen)
        tangents = [s.stiffness for s in stress]
        if self.shaft is not None and torque is not None:
            link = self.shaft.link
            tangents[link] = tangents[link] + self.shaft.stiffness(torque)
        matrices = self.frames.assemble(
            motion,
            tangents,
            terms,
            [s.damping for s in stress],
            self.stress.guide_stiffness(time),
        )
        if self.stretch is not None:
            matrices = self.stretch.added(matrices, motion, terms)
        if self.connectors.any:
            matrices = self.connectors.added(motion, matrices, terms, time)
        if self.carried is not None:
            matrices = self.carried.added(motion, matrices, terms, time=time)
        if self.shaft is not None and self._motor is not None:
            matrices = self._motor.added(time, matrices, self.shaft.coordinate)
        return Equations.condensed(motion, matrices, force, self.condensed)

    def quasi_static_equations(self, time: FloatArray) -> Equations:
        """Equations of the quasi-static state at times of shape (m,): without rotation terms.

        Links that rotate as one body keep them, as inertia forces of a constant displacement.
        """
        return self.equations(time, frozen=not self.engine.turns_as_one_body)

    def link_motion(
        self, equations: Equations, vibration: VibrationState
    ) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Coordinates of each reduced link and their time derivatives in its frame.

        Parameters
        ----------
        equations : Equations
            At m instants.
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        list of tuple of ndarray, shape (m, n_link)
        """
        return self.frames.link_motion(equations.motion, *equations.expansion.expanded(vibration))

    def link_state(self, equations: Equations, vibration: VibrationState) -> LinkState:
        """State of the engine's links at the first of the instants."""
        pairs = list(zip(self.bases, self.link_motion(equations, vibration), strict=True))
        return LinkState(
            displacement=[basis @ q[0] for basis, (q, _, _) in pairs],
            rate=[basis @ rate[0] for basis, (_, rate, _) in pairs],
            frame=self.frame_motion(vibration[:1]),
        )

    def frame_motion(self, vibration: VibrationState) -> FrameMotion | None:
        """Motion of a frame on springs; None of one that stands.

        Parameters
        ----------
        vibration : VibrationState
            Arrays of shape (m, n).
        """
        if self.carried is None:
            return None
        return FrameMotion(
            vibration.position[:, -COORDINATES:], vibration.velocity[:, -COORDINATES:]
        )

    def coordinates(self, state: LinkState, time: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Independent coordinates of a state of the engine's links, projected by the mass.

        The inverse of :meth:`link_state` for states in the span of the component modes.

        Parameters
        ----------
        state : LinkState
        time : float
            At which it is, in s.

        Returns
        -------
        ndarray, shape (n,)
            Position z.
        ndarray, shape (n,)
            Velocity z'.
        """
        nearest = []
        for number, (full, basis) in enumerate(zip(self.unreduced, self.run_bases, strict=True)):
            both = np.stack([state.displacement[number], state.rate[number]], axis=1)
            both = self._from_engine[number] @ both
            # A basis of all coordinates needs no mass, which of a rigid link may be singular.
            weights = basis.T @ full.mass if basis.shape[1] < len(basis) else np.eye(len(basis))
            both = np.asarray(np.linalg.solve(weights @ basis, weights @ both), dtype=float)
            nearest.append(both[None])
        motion = self.motion(np.array([time]))
        values = self.frames.independent(motion, nearest)[0].T
        if self.frames.topology.sliders:
            # The part of the rates by the rotation of the frames is no rate of a slide.
            zero = np.zeros_like(values[:1])
            moving = self.frames.link_motion(motion, values[:1], zero, zero)
            rates = [
                both[..., 1:] - rate[..., None]
                for both, (_, rate, _) in zip(nearest, moving, strict=True)
            ]
            values[1] = self.frames.independent(motion, rates)[0, :, 0]
        if self.rotor is not None:
            values = np.pad(values, ((0, 0), (0, 1)))
        if self.carried is not None:
            moved = state.moved
            values = np.concatenate([values, [moved.displacement[0], moved.rate[0]]], axis=1)
        position, velocity = values[:, ~self.condensed]
        return position, velocity

    def unstressed(self) -> FloatArray:
        """Position z at time zero of straight links without axial stress, (n,).

        Zero, except about a bowed equilibrium: to first order a straight link is longer there
        by the square of the bow, which would be an initial stress that it does not have.
        """
        equations = self.equations(np.zeros(1), frozen=True)
        parts = [-s.prestress for s in self.stress.at(np.zeros(1))]
        inner = np.zeros(len(self.condensed))
        inner[: self.frames.size] = self.frames.gather(equations.motion, parts)[0]
        position, along = np.zeros(self.size), np.zeros(len(inner), dtype=bool)
        for number, (link, target) in enumerate(zip(self.links, self.frames.targets, strict=True)):
            coordinates = self.frames.independent_coordinates(number)
            along[target[coordinates[link.is_axial[coordinates]]]] = True
        axial = np.flatnonzero(along[~self.condensed])
        if len(axial):
            force = equations.expansion.matrix[0].T @ inner
            stiffness = equations.stiffness[0][np.ix_(axial, axial)]
            position[axial] = np.linalg.solve(stiffness, force[axial])
        return position


def static_balance(linkage: DrivenLinkage, position: FloatArray, time: float = 0.0) -> FloatArray:
    """Static equilibrium z of links that stretch, under the loads at an instant, (n,).

    Parameters
    ----------
    linkage : DrivenLinkage
        Whose links stretch.
    position : ndarray, shape (n,)
        Near it.
    time : float
        In s.

    Returns
    -------
    ndarray, shape (n,)

    Raises
    ------
    ComputationError
        If Newton's method does not converge.
    """
    assert linkage.stretch is not None
    equations = linkage.quasi_static_equations(np.array([time]))
    row = np.eye(linkage.size)[linkage.shaft_coordinates]
    stiffness, force, z = equations.stiffness[0], equations.force[0], np.array(position)
    last = np.inf
    for _ in range(MOST_PASSES):
        pulled, tangent = linkage.stretch.static_force(equations.motion, z)
        gap = np.concatenate([force - stiffness @ z - pulled, -row @ z])
        bordered = np.block([[stiffness + tangent, row.T], [row, np.zeros(2 * [len(row)])]])
        change = np.linalg.solve(bordered, gap)[: linkage.size]
        z += change
        ratio = np.abs(change).max() / max(np.abs(z).max(), NOTHING)
        if ratio <= CONVERGED or last <= 2 * ratio <= STAGNATED:
            return z
        last = ratio
    raise ComputationError(
        f"the links find no balance at time {time:.6g} s from which to start, crank angle "
        f"{np.degrees(float(linkage.drive.crank_angle(time))):.6g} deg; lower the crank speed, or "
        "choose start rigid"
    )
