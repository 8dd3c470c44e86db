"""Driven linkage: linear equations of motion in link frames with time-varying matrices.

``M(t) z'' + C(t) z' + K(t) z = f(t)``: the matrices of
:mod:`flexmech.linear_system.joints.link_frames` with all rotation terms, the inertia forces of the
rigid motion and weight as load. Links are reduced to component modes whose constraint
modes rotate with the pins as a whole (Galerkin): a response in time does not depend on the frame in
which it is written, as frozen eigenvalues do. Axial modes above
the frequencies of interest are condensed: a bowed link stretches when it bends.

They are linear about straight links, or their quasi-static equilibrium. On request links stretch by
half the square of their slopes (:class:`LinkageStretch`); then no axial mode is condensed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import (
    COORDINATES,
    CarriedLinkage,
    Engine,
    LinkFrames,
    Prestress,
    RotationTerms,
    inertia_loads,
)
from flexmech.linkages import Drive, RigidMotion
from flexmech.time_domain.equations_of_motion.driven_connectors import DrivenConnectors
from flexmech.time_domain.equations_of_motion.driven_shaft import DrivenShaft
from flexmech.time_domain.equations_of_motion.equations import Equations
from flexmech.time_domain.equations_of_motion.linkage_stretch import LinkageStretch
from flexmech.time_domain.equations_of_motion.moving_guides import MovingGuides
from flexmech.time_domain.equations_of_motion.reduced_links import (
    DETAIL,
    prestressed_links,
    stretching_links,
)
from flexmech.time_domain.equations_of_motion.shaft_torque import ShaftTorque
from flexmech.time_domain.equations_of_motion.stress_history import StressHistory
from flexmech.time_domain.recorded_runs.states import FrameMotion, LinkState


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
    with_energy : bool
        Whether energies and joint forces are needed.
    stretches : bool
        Let straight links stretch in place of a prestress; see :func:`stretches_in_runs`.
    shaft_torque : ShaftTorque, optional
        Of a motor on a free shaft.

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
        On a coupling to that, whose coordinate is the last one.
    carried : CarriedLinkage or None
        With the frame on springs that carries the linkage, whose coordinates are the last three.
    condensed : ndarray of bool, shape (size,)
        Which coordinates of the frames are condensed statically.
    stress : StressHistory
        Of the reduced links.
    """

    def __init__(
        self,
        engine: Engine,
        drive: Drive,
        prestress: Prestress = "equilibrium",
        *,
        modes: int = MODES,
        detail: float = DETAIL,
        with_energy: bool = True,
        stretches: bool = False,
        shaft_torque: ShaftTorque | None = None,
    ) -> None:
        self.engine, self.drive, self.prestress = engine, drive, prestress
        reduced = (
            stretching_links(engine, modes, detail)
            if stretches
            else prestressed_links(engine, drive, prestress, modes, detail)
        )
        self.links, self.run_bases = reduced.models, reduced.bases
        self.unreduced = tuple(link.model for link in reduced.unreduced)
        self._from_engine = [link.from_engine for link in reduced.unreduced]
        self.bases = reduced.engine_bases
        self.frames = LinkFrames(reduced.topology, self.links)
        self.carried = CarriedLinkage.of(
            engine.mechanism, self.frames, self.unreduced, self.run_bases
        )
        if self.carried is not None:
            engine.require_prescribed_shaft("a linkage whose frame is on springs")
        self._motor = shaft_torque
        self.rotor = None if shaft_torque is None else shaft_torque.coupling
        others = int(self.rotor is not None) if self.carried is None else COORDINATES
        self.stretch = None
        if stretches:
            guides = MovingGuides(engine, self.frames, reduced.unreduced, self.run_bases)
            self.stretch = LinkageStretch(self.frames, reduced.stretches, guides, others)
        own = reduced.unreduced, self.run_bases
        self.shaft = DrivenShaft.of(engine, drive, self.frames, *own, shaft_torque)
        turns_far = self.shaft is not None and self.shaft.is_natural
        self.connectors = DrivenConnectors(engine, self.frames, follower_torque=turns_far)
        self.condensed = np.zeros(self.frames.size + others, dtype=bool)
        for target, condensed in zip(self.frames.targets, reduced.condensed, strict=True):
            self.condensed[target[condensed]] = True
        self.stress = StressHistory(
            engine,
            self.unreduced,
            self.run_bases,
            drive,
            "none" if stretches and not turns_far else prestress,
            with_energy=with_energy,
            equilibrium_of=self.bases if turns_far else None,
        )

    @property
    def size(self) -> int:
        """Number of independent coordinates."""
        return int(np.sum(~self.condensed))

    @property
    def shaft_coordinates(self) -> list[int]:
        """Numbers of the coordinates by which a free shaft and a rotor on a coupling turn."""
        if self.shaft is None:
            return []
        [column] = np.flatnonzero(self.shaft.coordinate)
        own = [int(np.sum(~self.condensed[:column]))]
        return own if self.rotor is None else [*own, self.size - 1]

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

    def step_forces(
        self, time: FloatArray, pushed: Sequence[FloatArray] | None = None
    ) -> FloatArray | None:
        """Forces on all coordinates that are not interpolated: of loads over tables, and others.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        pushed : sequence of ndarray, shape (m, n_full), optional
            The others, on the unreduced links in their frames.

        Returns
        -------
        ndarray, shape (m, size), or None
            Of condensed coordinates as well; None if there are none.
        """
        if pushed is None and not self.connectors.has_tables:
            return None
        motion = self.motion(time)
        force = self.connectors.force(motion, time, smooth=False)
        if self.shaft is not None and not self.shaft.has_motor:
            force += self.shaft.force(motion, self.shaft.balance(motion, force))
        if pushed is not None:
            reduced = [f @ basis for f, basis in zip(pushed, self.run_bases, strict=True)]
            force += self.frames.gather(motion, reduced)
        force = np.pad(force, ((0, 0), (0, len(self.condensed) - self.frames.size)))
        if pushed is not None and self.carried is not None:
            force[:, -COORDINATES:] += self.carried.on_frame(motion, pushed)
        return force

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
        force, torque = np.zeros((len(time), self.frames.size)), None
        if self.stress.has_internal_forces:
            force += self.frames.gather(motion, self.loads(motion))
        if self.connectors.any:
            force += self.connectors.force(motion, time, tables=tables)
        if self.shaft is not None:
            torque, pull = self.shaft.torque(time, motion, force)
            force += self.shaft.force(motion, pull)
        force += self.frames.gather(motion, [-s.prestress for s in stress])
        if self.carried is not None:
            force = np.concatenate([force, self.carried.load(motion, time)], axis=1)
        if self._motor is not None:
            force = self._motor.forces(time, force, self.drive.crank_acceleration(time))
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
            matrices = self.stretch.guides.added(matrices, motion, terms)
        if self.connectors.any:
            matrices = self.connectors.added(motion, matrices, terms, time)
        if self.shaft is not None and self._motor is not None:
            matrices = self._motor.added(time, matrices, self.shaft.coordinate)
        if self.carried is not None:
            matrices = self.carried.added(motion, matrices, terms, time=time)
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
            if not full.rigid:
                weighted = basis.T @ full.mass
                both = np.asarray(np.linalg.solve(weighted @ basis, weighted @ both), dtype=float)
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
        if self.carried is not None:
            moved = state.moved
            values = np.concatenate([values, [moved.displacement[0], moved.rate[0]]], axis=1)
        if self.rotor is not None:
            values = np.pad(values, ((0, 0), (0, 1)))
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
            own = self.frames.independent_coordinates(number)
            along[target[own[link.is_axial[own]]]] = True
        axial = np.flatnonzero(along[~self.condensed])
        if len(axial):
            force = equations.expansion.matrix[0].T @ inner
            own = equations.stiffness[0][np.ix_(axial, axial)]
            position[axial] = np.linalg.solve(own, force[axial])
        return position
